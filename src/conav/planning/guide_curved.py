"""A first path of a robot whose ways are curves, along straight lines through given places.

A double integrator stops at every place, so that it stays on the lines. A Dubins car leaves the
lines where it turns: of some headings at each place those are taken that make the shortest way free
of walls and discs, by dynamic programming over places and headings.
"""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.elementary import TWO_PI, arc_tangent
from conav.planning.curves import pieces_free
from conav.planning.graph import RobotGraph
from conav.planning.motion_states import soonest
from conav.planning.steering import BOUND, CAR, MAX_PIECES, MOTION, SPEED
from conav.planning.types import PIECE

HEADINGS = 16
"""Of a car at a place, beginning with that of the line to it."""

_LONGEST = 6.0  # of a line, in radii of the tightest turn, between two places of a car


def curved_guide(
    graph: RobotGraph, places: NDArray[np.float64], horizon_s: float
) -> NDArray[np.float64] | None:
    """States, (m, numbers), at these places, (m, 2), as soon as can be, and free of obstacles.

    The first of the places is the start. None if nothing is found, or takes longer than the
    horizon.
    """
    limits = graph.surroundings.limits
    start = graph.vertices[0]
    moved = np.any(np.diff(places, axis=0) != 0.0, axis=1)
    places = places[np.append(True, moved)]
    if limits[MOTION] == CAR:
        places = _divided(places, _LONGEST * float(limits[BOUND]))
    states = np.zeros((len(places), len(start)))
    states[:, :2] = places
    states[0] = start
    if limits[MOTION] == CAR and not _fill_headings(*graph.surroundings.obstacles, limits, states):
        return None
    if not _drive(*graph.surroundings.obstacles, limits, states):
        return None
    return states if states[-1, 2] <= horizon_s else None


def _divided(places: NDArray[np.float64], longest_m: float) -> NDArray[np.float64]:
    """The places and more between them, nowhere farther apart than that."""
    rows = [places[:1]]
    for a, b in pairwise(places):
        steps = int(math.sqrt(float(((b - a) ** 2).sum())) / longest_m) + 1
        rows.append(a + np.arange(1, steps + 1)[:, None] / steps * (b - a))
    return np.concatenate(rows)


@kernel
def _drive(
    grid: NDArray[np.float64],
    starts: NDArray[np.int32],
    items: NDArray[np.int32],
    shapes: NDArray[np.float64],
    limits: NDArray[np.float64],
    states: NDArray[np.float64],
) -> bool:
    """Fills in the times; whether the way through the states is one, and free."""
    pieces = np.empty((MAX_PIECES, PIECE))
    for i in range(1, len(states)):
        count = soonest(limits, states[i - 1 : i + 1], pieces)
        if count == 0 or not pieces_free(grid, starts, items, shapes, pieces, count):
            return False
    return True


@kernel
def _fill_headings(
    grid: NDArray[np.float64],
    starts: NDArray[np.int32],
    items: NDArray[np.int32],
    shapes: NDArray[np.float64],
    limits: NDArray[np.float64],
    states: NDArray[np.float64],
) -> bool:
    """Fills in the headings of a shortest way; whether there is one."""
    size = len(states)
    heading = np.zeros((size, HEADINGS))
    cost = np.full((size, HEADINGS), np.inf)
    before = np.zeros((size, HEADINGS), np.int64)
    pair = np.zeros((2, 4))
    pieces = np.empty((MAX_PIECES, PIECE))
    heading[0, 0] = states[0, 3]
    cost[0, 0] = 0.0
    for i in range(1, size):
        line = arc_tangent(states[i, 1] - states[i - 1, 1], states[i, 0] - states[i - 1, 0])
        for to in range(HEADINGS):
            heading[i, to] = line + to * (TWO_PI / HEADINGS)
        for at in range(HEADINGS):
            if cost[i - 1, at] == np.inf:
                continue
            pair[0, 0] = states[i - 1, 0]
            pair[0, 1] = states[i - 1, 1]
            pair[0, 2] = 0.0
            pair[0, 3] = heading[i - 1, at]
            for to in range(HEADINGS):
                pair[1, 0] = states[i, 0]
                pair[1, 1] = states[i, 1]
                pair[1, 3] = heading[i, to]
                count = soonest(limits, pair, pieces)
                total = cost[i - 1, at] + limits[SPEED] * pair[1, 2]
                if (
                    count > 0
                    and total < cost[i, to]
                    and pieces_free(grid, starts, items, shapes, pieces, count)
                ):
                    cost[i, to] = total
                    before[i, to] = at
    best = 0
    for to in range(HEADINGS):
        if cost[size - 1, to] < cost[size - 1, best]:
            best = to
    if cost[size - 1, best] == np.inf:
        return False
    for i in range(size - 1, 0, -1):
        states[i, 3] = heading[i, best]
        best = before[i, best]
    return True
