"""A first path of a robot whose ways are curves, along straight lines through given places.

A double integrator stops at every corner, so that it stays on the lines. A Dubins car comes through
a corner half turned, and leaves the lines there: where walls are near it may not get through, and
its path is then no more than where samples are drawn around.
"""

import numpy as np
from numpy.typing import NDArray

from conav.geometry.elementary import arc_tangent
from conav.planning.curves import pieces_free
from conav.planning.graph import RobotGraph
from conav.planning.motion_states import soonest
from conav.planning.steering import CAR, MAX_PIECES, MOTION, connection
from conav.planning.types import PIECE


def curved_guide(
    graph: RobotGraph, places: NDArray[np.float64], horizon_s: float
) -> NDArray[np.float64] | None:
    """States, (m, numbers), at these places, (m, 2), as soon as can be.

    The first of the places is the start. None if that takes longer than the horizon.
    """
    limits = graph.surroundings.limits
    start = graph.vertices[0]
    moved = np.any(np.diff(places, axis=0) != 0.0, axis=1)
    places = places[np.append(True, moved)]
    states = np.zeros((len(places), len(start)))
    states[:, :2] = places
    states[0] = start
    if limits[MOTION] == CAR:
        steps = np.diff(places, axis=0)
        units = steps / np.sqrt(np.sum(steps * steps, axis=1))[:, None]
        for i, unit in enumerate(units, start=1):
            ahead = unit + units[i] if i < len(units) else unit
            states[i, 3] = arc_tangent(float(ahead[1]), float(ahead[0]))
    pieces = np.empty((MAX_PIECES, PIECE))
    for i in range(1, len(states)):
        if soonest(limits, states[i - 1 : i + 1], pieces) == 0:
            return None
    return states if states[-1, 2] <= horizon_s else None


def free_ways(graph: RobotGraph, states: NDArray[np.float64]) -> bool:
    """Whether the way through these states, (m, numbers), overlaps no obstacle."""
    pieces = np.empty((MAX_PIECES, PIECE))
    obstacles = graph.surroundings.obstacles
    for tail in range(len(states) - 1):
        count = connection(graph.surroundings.limits, states, tail, tail + 1, pieces)
        if count == 0 or not pieces_free(*obstacles, pieces, count):
            return False
    return True
