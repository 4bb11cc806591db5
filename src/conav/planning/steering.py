"""How a robot gets from one state to a later one: what a motion adds to planning.

A state is a row: x, y [m], t [s], and what else the motion has. `connection` says whether there is
a way from one to another that takes exactly the time between, and which pieces it is made of; all
else in this room looks at pieces alone.
"""

import math

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.errors import InputError
from conav.planning.types import PIECE, SINGLE_INTEGRATOR, PlanningRobot

MAX_PIECES = 1
"""Of a connection."""

STATE = 3
"""Numbers of a state."""

AT_MOST = 1.0 + 1e-9
"""Full speed leaves that much to spare, so that rounding never asks for more."""

SPEED = 0  # place in the limits


def build_limits(robot: PlanningRobot) -> NDArray[np.float64]:
    """What bounds a robot's motion, as an array. Raises `InputError` for a motion not known."""
    if robot.motion != SINGLE_INTEGRATOR:
        raise InputError(
            f"robot {robot.name}", f"no solver steers the motion {robot.motion!r}",
            f"use {SINGLE_INTEGRATOR!r}",
        )  # fmt: skip
    return np.array([robot.speed_mps], dtype=np.float64)


def start_state(robot: PlanningRobot) -> NDArray[np.float64]:
    """The robot's state at time 0, shape (STATE,)."""
    return np.array([*robot.start[:2], 0.0])


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
    states: NDArray[np.float64], tail: int, head: int, pieces: NDArray[np.float64], count: int
) -> float:
    """The length [m] of a connection."""
    dx = states[head, 0] - states[tail, 0]
    dy = states[head, 1] - states[tail, 1]
    return math.sqrt(dx * dx + dy * dy)


def pieces_of(limits: NDArray[np.float64], states: NDArray[np.float64]) -> NDArray[np.float64]:
    """The pieces, (n, PIECE), of the way through these states, (m, STATE), m >= 1."""
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
        length += connection_length(states, tail, head, pieces, count)
        duration += states[head, 2] - states[tail, 2]
    return length, duration
