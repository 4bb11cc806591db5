"""States of a motion that does not go straight: what sampling asks of it beside a connection.

The rest of a state (after x, y and t) is a velocity or a heading; here it is drawn, aimed, taken
from a way, or made one in which the robot can stay.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.elementary import TWO_PI, arc_tangent
from conav.planning.piece import state_on_piece
from conav.planning.steer_double_integrator import least_duration as least_of_double_integrator
from conav.planning.steer_dubins import least_duration as least_of_dubins
from conav.planning.steering import ACCELERATED, AT_MOST, BOUND, MOTION, SPEED, connection

_STRETCHES = np.array([1.0 + 1e-6, 1.05, 1.2, 1.5, 2.0])
"""Of the least duration, tried one after the other; the first so that parts of a way are ways."""


@kernel
def draw_rest(
    limits: NDArray[np.float64], state: NDArray[np.float64], u: float, v: float, w: float
) -> None:
    """Fills in any heading, or any velocity of the square around the disc of those allowed.

    u, v and w are random numbers from 0 to 1. Of velocities, three in ten are none, and one that is
    too fast is made slower.
    """
    if limits[MOTION] != ACCELERATED:
        state[3] = TWO_PI * u
        return
    speed = limits[SPEED]
    state[3] = speed * (2.0 * u - 1.0)
    state[4] = speed * (2.0 * v - 1.0)
    if w < 0.3:
        stand(limits, state)
    slow_down(limits, state)


@kernel
def stand(limits: NDArray[np.float64], state: NDArray[np.float64]) -> None:
    """No velocity; a heading stays."""
    if limits[MOTION] == ACCELERATED:
        state[3] = 0.0
        state[4] = 0.0


@kernel
def slow_down(limits: NDArray[np.float64], state: NDArray[np.float64]) -> None:
    """A velocity above the top speed becomes one just below, in the same direction."""
    if limits[MOTION] == ACCELERATED:
        square = state[3] * state[3] + state[4] * state[4]
        if square > limits[SPEED] * limits[SPEED]:
            share = limits[SPEED] / (sqrt(square) * AT_MOST)
            state[3] *= share
            state[4] *= share


@kernel
def aim(
    limits: NDArray[np.float64], state: NDArray[np.float64], dx: float, dy: float, dt: float
) -> None:
    """Fills in the heading of (dx, dy), or the velocity that goes so far in dt seconds."""
    if limits[MOTION] == ACCELERATED:
        state[3] = dx / dt
        state[4] = dy / dt
        slow_down(limits, state)
    else:
        state[3] = arc_tangent(dy, dx)


@kernel
def come_to_rest(
    limits: NDArray[np.float64],
    states: NDArray[np.float64],
    vertex: int,
    state: NDArray[np.float64],
) -> None:
    """Fills in the state in which the robot has stopped, as soon as it can after one of these."""
    for i in range(len(state)):
        state[i] = states[vertex, i]
    if limits[MOTION] == ACCELERATED:
        speed = sqrt(state[3] * state[3] + state[4] * state[4])
        duration = speed / limits[BOUND] * AT_MOST
        state[0] += 0.5 * duration * state[3]
        state[1] += 0.5 * duration * state[4]
        state[2] += duration
        stand(limits, state)


@kernel
def soonest(
    limits: NDArray[np.float64], pair: NDArray[np.float64], pieces: NDArray[np.float64]
) -> int:
    """The number of pieces from the first of two states to the second as soon as is found.

    The second's time is filled in. 0: nothing was found up to twice the least duration.
    """
    if limits[MOTION] == ACCELERATED:
        least = least_of_double_integrator(limits, pair, 0, 1)
    else:
        least = least_of_dubins(limits, pair, 0, 1)
    for i in range(len(_STRETCHES)):
        pair[1, 2] = pair[0, 2] + least * _STRETCHES[i]
        count = connection(limits, pair, 0, 1, pieces)
        if count > 0:
            return count
    return 0


@kernel
def state_on_way(
    limits: NDArray[np.float64],
    first: NDArray[np.float64],
    pieces: NDArray[np.float64],
    count: int,
    t: float,
    state: NDArray[np.float64],
) -> None:
    """Fills in the state at a time of a way that begins in `first`."""
    piece = 0
    while piece < count - 1 and pieces[piece, 1] < t:
        piece += 1
    x, y, vx, vy = state_on_piece(pieces[piece], t)
    state[0] = x
    state[1] = y
    state[2] = t
    if limits[MOTION] == ACCELERATED:
        state[3] = vx
        state[4] = vy
        slow_down(limits, state)
        return
    heading = first[3]
    for i in range(piece + 1):
        until = t if i == piece else pieces[i, 1]
        heading += pieces[i, 8] * (until - pieces[i, 0])
    state[3] = heading
