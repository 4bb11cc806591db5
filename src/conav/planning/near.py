"""Which vertices of a graph lie near a place and time: the cells that radius and speed allow.

Distances are those of the metric sqrt(|dx|^2 + (v dt)^2), and a robot is no faster than v, so a
vertex with an edge to or from the place has |dx| <= v |dt|. For curved motions both still hold of
the straight line between the ends, which is no longer than the way.
"""

import math

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.graph_arrays import BEFORE, CELL, COLUMNS, LAYERS, LEFT, LOW, ROWS

_FEW = 400  # vertices that are looked through faster than cells
_RINGS = 5  # of cells around a sample that are looked through before all vertices are

# Boxes around what may be connected are larger by that, far above rounding.
_MORE = 1.0 + 1e-9
_MARGIN = 1e-9  # [m]


@kernel
def width(z: int, layers: int, cell: float, at: float, radius: float) -> float:
    """How far away, at most, a vertex of layer z can be that has an edge to one at v t = `at`.

    The robot is no faster than v, and the radius bounds both together. In the last layer are all
    later times.
    """
    low = z * cell - at
    high = low + cell if z < layers - 1 else max(low + cell, radius)
    nearest = max(low, -high, 0.0)
    farthest = max(high, -low)
    if nearest >= radius:
        return 0.0
    return min(farthest, math.sqrt(radius * radius - nearest * nearest)) * _MORE + _MARGIN


@kernel
def near_vertices(
    states: NDArray[np.float64],
    links: NDArray[np.int32],
    heads: NDArray[np.int32],
    box: NDArray[np.float64],
    speed: float,
    radius: float,
    forward: bool,
    x: float,
    y: float,
    t: float,
    near: NDArray[np.int32],
) -> int:
    """How many vertices within the radius can be a way's start or, with `forward`, its end.

    Their numbers are written into `near`.
    """
    square = radius * radius
    columns = int(box[COLUMNS])
    rows = int(box[ROWS])
    layers = int(box[LAYERS])
    cell = box[CELL]
    left = box[LEFT]
    low = box[LOW]
    layer = min(max(int(speed * t / cell), 0), layers - 1)
    farthest = radius * _MORE
    last_layer = min(int((speed * t + farthest) / cell), layers - 1) if forward else layer
    count = 0
    for z in range(max(int((speed * t - farthest) / cell), 0), last_layer + 1):
        # No place of this layer that has an edge to the vertex is farther away than `wide`.
        wide = width(z, layers, cell, speed * t, farthest)
        first_column = max(int((x - wide - left) / cell), 0)
        last_column = min(int((x + wide - left) / cell), columns - 1)
        first_row = max(int((y - wide - low) / cell), 0)
        last_row = min(int((y + wide - low) / cell), rows - 1)
        for v in range(first_row, last_row + 1):
            row = (z * rows + v) * columns
            for u in range(row + first_column, row + last_column + 1):
                old = heads[u]
                while old >= 0:
                    dx = x - states[old, 0]
                    dy = y - states[old, 1]
                    reach = speed * (t - states[old, 2])
                    plane = dx * dx + dy * dy
                    cone = reach * reach
                    if (
                        plane <= cone
                        and plane + cone <= square
                        and (reach > 0.0 or (forward and reach < 0.0))
                    ):
                        near[count] = old
                        count += 1
                    old = links[old, BEFORE]
    return count


@kernel
def nearest(
    states: NDArray[np.float64],
    links: NDArray[np.int32],
    heads: NDArray[np.int32],
    box: NDArray[np.float64],
    vertices: int,
    speed: float,
    x: float,
    y: float,
    t: float,
) -> int:
    """The nearest vertex from which (x, y, t) can be reached in time, -1 for none.

    Of equals the first in order of insertion. Distances are compared in squares.
    """
    best = np.inf
    found = -1
    columns = int(box[COLUMNS])
    rows = int(box[ROWS])
    if vertices > _FEW:
        column = min(max(int((x - box[LEFT]) / box[CELL]), 0), columns - 1)
        row = min(max(int((y - box[LOW]) / box[CELL]), 0), rows - 1)
        layer = min(max(int(speed * t / box[CELL]), 0), int(box[LAYERS]) - 1)
        for ring in range(_RINGS):
            for z in range(max(layer - ring, 0), layer + 1):
                for v in range(max(row - ring, 0), min(row + ring, rows - 1) + 1):
                    inner = ring > 0 and layer - z < ring and abs(v - row) < ring
                    for u in range(column - ring, column + ring + 1, 2 * ring if inner else 1):
                        if u < 0 or u >= columns:
                            continue
                        old = heads[(z * rows + v) * columns + u]
                        while old >= 0:
                            dx = x - states[old, 0]
                            dy = y - states[old, 1]
                            reach = speed * (t - states[old, 2])
                            plane = dx * dx + dy * dy
                            cone = reach * reach
                            away = plane + cone
                            if (
                                plane <= cone
                                and reach > 0.0
                                and (away < best or (away == best and old < found))
                            ):
                                best = away
                                found = old
                            old = links[old, BEFORE]
            # Whatever lies outside the rings so far is at least that far away.
            outside = ring * box[CELL]
            if found >= 0 and best <= outside * outside:
                return found
    for old in range(vertices):
        dx = x - states[old, 0]
        dy = y - states[old, 1]
        reach = speed * (t - states[old, 2])
        plane = dx * dx + dy * dy
        cone = reach * reach
        away = plane + cone
        if plane <= cone and reach > 0.0 and (away < best or (away == best and old < found)):
            best = away
            found = old
    return found
