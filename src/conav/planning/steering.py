"""How a robot gets from one state to a later one: what a motion adds to planning.

A state is a row: x, y [m], t [s], and what else the motion has: nothing for a single integrator,
the velocity vx, vy [m/s] for a double integrator, the heading [rad] for a Dubins car. `connection`
says whether there is a way from one to another that takes exactly the time between, and which
pieces it is made of; graphs, responses and checks look at pieces alone. What sampling asks of a
motion beside it is in `conav.planning.motion_states`.
"""

import math

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.errors import InputError
from conav.planning.piece import piece_length
from conav.planning.steer_double_integrator import connect_double_integrator
from conav.planning.steer_dubins import connect_dubins
from conav.planning.types import (
    DOUBLE_INTEGRATOR,
    DUBINS_CAR,
    PIECE,
    PLANNING_MOTIONS,
    SINGLE_INTEGRATOR,
    PlanningRobot,
)

MAX_PIECES = 3
"""Of a connection."""

STATE = 3
"""Numbers of a state of a robot that drives straight; the first three of any."""

AT_MOST = 1.0 + 1e-9
"""Full speed leaves that much to spare, so that rounding never asks for more."""

SPEED, BOUND, MOTION = range(3)
"""Places in the limits: top speed [m/s], greatest acceleration or radius of turns, motion."""

STRAIGHT, ACCELERATED, CAR = range(3)
"""Motions, in the limits."""

_NUMBERS = {SINGLE_INTEGRATOR: STATE, DOUBLE_INTEGRATOR: 5, DUBINS_CAR: 4}  # of a state
_AT_REST = 1e-9  # [m/s] is no speed


def build_limits(robot: PlanningRobot) -> NDArray[np.float64]:
    """What bounds a robot's motion, (3,).

    Raises `InputError` for a motion not known, and for bounds and starts that it cannot have.
    """
    if robot.motion not in _NUMBERS:
        raise InputError(
            f"robot {robot.name}", f"the motion {robot.motion!r} is not known",
            "use one of: " + ", ".join(PLANNING_MOTIONS),
        )  # fmt: skip
    if len(robot.start) != _NUMBERS[robot.motion] - 1:
        raise InputError(
            f"robot {robot.name}",
            f"starts at {len(robot.start)} numbers, and a {robot.motion} at "
            f"{_NUMBERS[robot.motion] - 1}",
            "give x, y, then vx, vy of a double integrator or the heading of a car",
        )
    bounds = {
        SINGLE_INTEGRATOR: 0.0,
        DOUBLE_INTEGRATOR: robot.acceleration_mps2,
        DUBINS_CAR: robot.turning_radius_m,
    }
    bound = bounds[robot.motion]
    if not robot.speed_mps > 0.0 or (robot.motion != SINGLE_INTEGRATOR and not bound > 0.0):
        raise InputError(
            f"robot {robot.name}", "has a speed, an acceleration or a turning radius of 0",
            "give positive ones",
        )  # fmt: skip
    return np.array([robot.speed_mps, bound, PLANNING_MOTIONS.index(robot.motion)], np.float64)


def start_state(robot: PlanningRobot) -> NDArray[np.float64]:
    """The robot's state at time 0."""
    return np.array([*robot.start[:2], 0.0, *robot.start[2:]])


@kernel
def may_end(limits: NDArray[np.float64], states: NDArray[np.float64], vertex: int) -> bool:
    """Whether a path may end in a state: a double integrator ends at rest."""
    if limits[MOTION] != ACCELERATED:
        return True
    return abs(states[vertex, 3]) <= _AT_REST and abs(states[vertex, 4]) <= _AT_REST


@kernel
def connection(
    limits: NDArray[np.float64],
    states: NDArray[np.float64],
    tail: int,
    head: int,
    pieces: NDArray[np.float64],
) -> int:
    """The number of pieces from one of the states to a later one; 0: there is no way.

    They are written into `pieces`. A single integrator goes straight at constant speed.
    """
    if limits[MOTION] == ACCELERATED:
        return connect_double_integrator(limits, states, tail, head, pieces)
    if limits[MOTION] == CAR:
        return connect_dubins(limits, states, tail, head, pieces)
    dt = states[head, 2] - states[tail, 2]
    dx = states[head, 0] - states[tail, 0]
    dy = states[head, 1] - states[tail, 1]
    reach = limits[SPEED] * dt
    if dt <= 0.0 or dx * dx + dy * dy > reach * reach:
        return 0
    pieces[0, 0] = states[tail, 2]
    pieces[0, 1] = states[head, 2]
    pieces[0, 2] = states[tail, 0]
    pieces[0, 3] = states[tail, 1]
    pieces[0, 4] = dx / dt
    pieces[0, 5] = dy / dt
    pieces[0, 6] = 0.0
    pieces[0, 7] = 0.0
    pieces[0, 8] = 0.0
    return 1


@kernel
def connection_length(
    limits: NDArray[np.float64],
    states: NDArray[np.float64],
    tail: int,
    head: int,
    pieces: NDArray[np.float64],
    count: int,
) -> float:
    """The length [m] of a connection."""
    if limits[MOTION] != STRAIGHT:
        total = 0.0
        for piece in range(count):
            total += piece_length(pieces[piece])
        return total
    dx = states[head, 0] - states[tail, 0]
    dy = states[head, 1] - states[tail, 1]
    return math.sqrt(dx * dx + dy * dy)


def pieces_of(limits: NDArray[np.float64], states: NDArray[np.float64]) -> NDArray[np.float64]:
    """The pieces, (n, PIECE), of the way through these states, (m, numbers), m >= 1."""
    buffer = np.empty((MAX_PIECES, PIECE))
    rows: list[NDArray[np.float64]] = []
    for tail in range(len(states) - 1):
        count = connection(limits, states, tail, tail + 1, buffer)
        rows.append(buffer[:count].copy())
    if not rows:  # a robot that is done where it starts
        x, y, t = states[0, :3].tolist()
        return np.array([[t, t, x, y, 0.0, 0.0, 0.0, 0.0, 0.0]])
    return np.concatenate(rows)


@kernel
def path_costs(
    limits: NDArray[np.float64], states: NDArray[np.float64], path: NDArray[np.int64]
) -> tuple[float, float]:
    """The length [m] and the duration [s] of a path, summed as responses sum them up."""
    length = 0.0
    duration = 0.0
    pieces = np.empty((MAX_PIECES, PIECE))
    for i in range(1, len(path)):
        tail = path[i - 1]
        head = path[i]
        count = connection(limits, states, tail, head, pieces)
        length += connection_length(limits, states, tail, head, pieces, count)
        duration += states[head, 2] - states[tail, 2]
    return length, duration
