"""Corridors one cell wide on the lattice of whole numbers, and the floor they are."""

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from conav.geometry.outline import trace_rings
from conav.maps.polygon_map import PolygonMap

Point = tuple[int, int]
Path = Sequence[Point]  # corners of a centre line; each step along x or along y


def cells_of_paths(paths: Iterable[Path]) -> set[Point]:
    """The lattice points on centre lines.

    >>> sorted(cells_of_paths([[(0, 0), (2, 0), (2, 1)]]))
    [(0, 0), (1, 0), (2, 0), (2, 1)]
    """
    cells: set[Point] = set()
    for path in paths:
        cells.update(path[:1])
        for (x0, y0), (x1, y1) in pairwise(path):
            steps = max(abs(x1 - x0), abs(y1 - y0))
            dx, dy = _sign(x1 - x0), _sign(y1 - y0)
            cells.update((x0 + dx * step, y0 + dy * step) for step in range(steps + 1))
    return cells


def floor_of_cells(
    cells: Iterable[Point], name: str, *, corner: tuple[float, float] = (0.0, 0.0), side: float = 1
) -> PolygonMap:
    """The floor of square cells with sides of `side` [m], connected through their sides.

    Cell (0, 0) has its low corner at `corner`.
    """
    at = np.array(sorted(cells), dtype=np.int64)
    low = at.min(axis=0)
    cols, rows = (at.max(axis=0) - low + 1).tolist()
    mask = np.zeros((rows, cols), dtype=np.uint8)
    mask[at[:, 1] - low[1], at[:, 0] - low[0]] = 1
    rings = trace_rings(mask, False, 1.0 / 1024.0)
    placed = [(ring + low) * side + np.array(corner) for ring in rings]
    return PolygonMap(placed[0], placed[1:], name)


def _sign(value: int) -> int:
    return (value > 0) - (value < 0)
