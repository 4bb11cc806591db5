"""Which triangle holds a point: a grid of candidates, then exact tests.

Points on sides and corners are found as such. A cell of the grid lists every triangle that may
reach into it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.predicates import GREATEST, orientation

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

OUTSIDE = -1
INSIDE = 0  # of a triangle
ON_SIDE = 1  # of a triangle, between its ends
ON_VERTEX = 2

CELLS_PER_TRIANGLE = 2.0


class Grid(NamedTuple):
    """Triangles by square cells: cell c lists `triangles[starts[c] : starts[c + 1]]`."""

    frame: Floats  # (5,) x and y of the corner [m], cells per metre, columns, rows
    starts: Ints  # (cells + 1,)
    triangles: Ints  # (entries,)


def make_grid(vertices: Floats, triangles: Ints) -> Grid:
    """The grid over the triangles, some two cells a triangle."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    width, height = (high - low).tolist()
    wanted = max(1.0, CELLS_PER_TRIANGLE * len(triangles))
    # Divided first: the product of two sides may be out of range.
    per_metre = float(np.sqrt(wanted / width / height))
    # A thin floor has one row of cells, not more of them than wanted.
    per_metre = min(per_metre, wanted / width, wanted / height)
    cols = int(width * per_metre) + 1
    rows = int(height * per_metre) + 1
    frame = np.array([low[0], low[1], per_metre, cols, rows])
    corners = triangles.reshape(-1)
    counts = np.zeros(cols * rows + 1, np.int64)
    empty = np.empty(0, np.int64)
    _fill(vertices, corners, frame, counts, empty, False)
    starts = np.concatenate(([0], np.cumsum(counts[:-1]))).astype(np.int64)
    entries = np.empty(int(starts[-1]), np.int64)
    _fill(vertices, corners, frame, starts[:-1].copy(), entries, True)
    for array in (frame, starts, entries):
        array.flags.writeable = False
    return Grid(frame, starts, entries)


@kernel
def _cell(at: float, low: float, per_metre: float, cells: float) -> int:
    """The row or column of a coordinate, the nearest one for coordinates outside.

    Rounding keeps order, so a coordinate between two others has its cell between theirs.
    """
    return int(min(max((at - low) * per_metre, 0.0), cells - 1.0))


@kernel
def _fill(
    vertices: Floats, corners: Ints, frame: Floats, counters: Ints, entries: Ints, write: bool
) -> None:
    """Counts the triangles of each cell, or writes them from each cell's counter on."""
    x0, y0, per_metre, cols, rows = frame
    reach = abs(x0) + abs(y0) + (cols + rows) / per_metre
    slack = 1e-6 / per_metre + 1e-15 * reach
    for triangle in range(corners.shape[0] // 3):
        ys = np.empty(3)
        xs = np.empty(3)
        for s in range(3):
            xs[s] = vertices[corners[3 * triangle + s], 0]
            ys[s] = vertices[corners[3 * triangle + s], 1]
        left = xs.min()
        right = xs.max()
        bottom = _cell(ys.min(), y0, per_metre, rows)
        top = _cell(ys.max(), y0, per_metre, rows)
        for row in range(bottom, top + 1):
            # The triangle's extent in this row, a little more for rounding.
            band_low = y0 + row / per_metre - slack
            band_high = y0 + (row + 1) / per_metre + slack
            least = np.inf
            most = -np.inf
            for s in range(3):
                t = (s + 1) % 3
                low, high = (s, t) if ys[s] <= ys[t] else (t, s)
                if (ys[high] < band_low and row > 0) or (ys[low] > band_high and row < rows - 1):
                    continue
                rise = ys[high] - ys[low]
                for band in (band_low, band_high):
                    part = 0.0
                    if rise > 0.0:
                        part = min(max((band - ys[low]) / rise, 0.0), 1.0)
                    x = xs[low] + part * (xs[high] - xs[low])
                    least = min(least, x)
                    most = max(most, x)
                if rise == 0.0:
                    least = min(least, xs[high])
                    most = max(most, xs[high])
            from_col = _cell(max(least - slack, left), x0, per_metre, cols)
            to_col = _cell(min(most + slack, right), x0, per_metre, cols)
            for col in range(from_col, to_col + 1):
                cell = row * int(cols) + col
                if write:
                    entries[counters[cell]] = triangle
                counters[cell] += 1


@kernel
def locate(
    vertices: Floats,
    corners: Ints,
    frame: Floats,
    starts: Ints,
    entries: Ints,
    x: float,
    y: float,
) -> tuple[int, int]:
    """Where a point lies: `INSIDE` a triangle, `ON_SIDE`, `ON_VERTEX`, `OUTSIDE`; and a half-edge.

    The half-edge is the first of the triangle, the one the point lies on, or one that starts at
    the vertex; -1 outside. `corners` are the triangles (3 m,). Exact; points on walls are inside
    the floor. A number that is not finite is outside.
    """
    if not (abs(x) <= GREATEST and abs(y) <= GREATEST):
        return OUTSIDE, -1
    col = _cell(x, frame[0], frame[2], frame[3])
    row = _cell(y, frame[1], frame[2], frame[4])
    cell = row * int(frame[3]) + col
    for k in range(starts[cell], starts[cell + 1]):
        h = 3 * entries[k]
        a = corners[h]
        b = corners[h + 1]
        c = corners[h + 2]
        ax, ay = vertices[a, 0], vertices[a, 1]
        bx, by = vertices[b, 0], vertices[b, 1]
        side0 = orientation(ax, ay, bx, by, x, y)
        if side0 < 0:
            continue
        cx, cy = vertices[c, 0], vertices[c, 1]
        side1 = orientation(bx, by, cx, cy, x, y)
        if side1 < 0:
            continue
        side2 = orientation(cx, cy, ax, ay, x, y)
        if side2 < 0:
            continue
        if side0 > 0 and side1 > 0 and side2 > 0:
            return INSIDE, h
        if side0 == 0:
            if side1 == 0:
                return ON_VERTEX, h + 1
            if side2 == 0:
                return ON_VERTEX, h
            return ON_SIDE, h
        if side1 == 0:
            if side2 == 0:
                return ON_VERTEX, h + 2
            return ON_SIDE, h + 1
        return ON_SIDE, h + 2
    return OUTSIDE, -1
