"""What does not move: walls and discs in a grid of cells, for robots of one radius.

Every cell lists the obstacles that a robot whose centre is in it could touch, with a little to
spare, so a test looks only at the lists of the cells it passes and an empty list is an answer. The
tests themselves are distances in floating point, compared with `>=`: touching is allowed.

Kernels take arrays one by one: a tuple of arrays handed to a compiled function costs more than the
test itself.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.clearance import point_segment_square
from conav.maps.polygon_map import PolygonMap

MAX_CELLS = 1 << 20
SPARE = 1e-6  # [m] by which cells list too much, far above the rounding of a walk through cells


class Obstacles(NamedTuple):
    """Arrays for kernels, in the order in which these take them."""

    grid: NDArray[np.float64]  # left, low, cell [m], columns, rows, number of walls
    starts: NDArray[np.int32]  # (columns * rows + 1,) of the lists
    items: NDArray[np.int32]  # rows of `shapes`
    shapes: NDArray[np.float64]  # (n, 5) segment x0, y0, x1, y1 and reach [m]; walls come first


def build_obstacles(
    floor: PolygonMap,
    discs: NDArray[np.float64],
    radius_m: float,
    cell_m: float = 0.5,
    spare_m: float = 0.0,
) -> Obstacles:
    """The obstacles for the centre of a robot of this radius, which must be above 0.

    `discs` has shape (m, 3): x, y, radius [m]. Cells are as large as asked, or larger where there
    would be more than `MAX_CELLS`. Who asks for more distance (`segment_keeps`) must have that much
    to spare in the lists.
    """
    round_ones = np.reshape(np.asarray(discs, dtype=np.float64), (-1, 3))
    walls = len(floor.segments)
    shapes = np.empty((walls + len(round_ones), 5))
    shapes[:walls, :4] = floor.segments
    shapes[:walls, 4] = radius_m
    shapes[walls:, 0:2] = round_ones[:, :2]
    shapes[walls:, 2:4] = round_ones[:, :2]
    shapes[walls:, 4] = round_ones[:, 2] + radius_m
    x0, y0, x1, y1 = floor.bounds
    cell = cell_m
    while ((x1 - x0) / cell + 1) * ((y1 - y0) / cell + 1) > MAX_CELLS:
        cell *= 2
    columns, rows = int((x1 - x0) / cell) + 1, int((y1 - y0) / cell) + 1
    grid = np.array([x0, y0, cell, columns, rows, walls])
    starts, items = _lists(grid, shapes, SPARE + spare_m)
    return Obstacles(grid, starts, items, shapes)


@kernel
def _lists(
    grid: NDArray[np.float64], shapes: NDArray[np.float64], spare: float
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Where each cell's list starts, and the lists."""
    left = grid[0]
    low = grid[1]
    cell = grid[2]
    columns = int(grid[3])
    rows = int(grid[4])
    starts = np.zeros(columns * rows + 1, np.int32)
    items = np.empty(0, np.int32)
    at = np.empty(0, np.int32)
    for filling in range(2):
        for item in range(len(shapes)):
            ax, ay, bx, by, reach = shapes[item]
            # A cell in reach has its centre in reach and half a diagonal.
            far = reach + cell * 0.7072 + spare
            first_column = max(0, int((min(ax, bx) - far - left) / cell) - 1)
            last_column = min(columns - 1, int((max(ax, bx) + far - left) / cell) + 1)
            first_row = max(0, int((min(ay, by) - far - low) / cell) - 1)
            last_row = min(rows - 1, int((max(ay, by) + far - low) / cell) + 1)
            for row in range(first_row, last_row + 1):
                for column in range(first_column, last_column + 1):
                    x = left + (column + 0.5) * cell
                    y = low + (row + 0.5) * cell
                    if point_segment_square(x, y, ax, ay, bx, by) <= far * far:
                        index = row * columns + column
                        if filling == 0:
                            starts[index + 1] += 1
                        else:
                            items[at[index]] = item
                            at[index] += 1
        if filling == 0:
            for index in range(columns * rows):
                starts[index + 1] += starts[index]
            items = np.empty(starts[-1], np.int32)
            at = starts[:-1].copy()
    return starts, items


@kernel
def point_free(
    grid: NDArray[np.float64],
    starts: NDArray[np.int32],
    items: NDArray[np.int32],
    shapes: NDArray[np.float64],
    x: float,
    y: float,
) -> bool:
    """Whether a robot with its centre there is on the floor and overlaps no obstacle."""
    inside = False  # a ray to the right crosses walls an odd number of times
    for wall in range(int(grid[5])):
        x0, y0, x1, y1, _ = shapes[wall]
        if (y0 > y) != (y1 > y):
            side = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
            if (side > 0.0) == (y1 > y0) and side != 0.0:
                inside = not inside
    return inside and segment_free(grid, starts, items, shapes, x, y, x, y)


@kernel
def segment_free(
    grid: NDArray[np.float64],
    starts: NDArray[np.int32],
    items: NDArray[np.int32],
    shapes: NDArray[np.float64],
    ax: float,
    ay: float,
    bx: float,
    by: float,
) -> bool:
    """Whether a robot that moves straight from a to b overlaps no obstacle on the way.

    From a place on the floor it then stays on the floor, since its radius is above 0.
    """
    return segment_keeps(grid, starts, items, shapes, ax, ay, bx, by, 0.0)


@kernel
def segment_keeps(
    grid: NDArray[np.float64],
    starts: NDArray[np.int32],
    items: NDArray[np.int32],
    shapes: NDArray[np.float64],
    ax: float,
    ay: float,
    bx: float,
    by: float,
    more: float,
) -> bool:
    """Whether it also keeps so much more distance [m] from all obstacles."""
    scale = 1.0 / grid[2]
    columns = int(grid[3])
    rows = int(grid[4])
    u = (ax - grid[0]) * scale
    v = (ay - grid[1]) * scale
    to_u = (bx - grid[0]) * scale
    to_v = (by - grid[1]) * scale
    column = int(np.floor(u))
    row = int(np.floor(v))
    to_column = int(np.floor(to_u))
    to_row = int(np.floor(to_v))
    du = to_u - u
    dv = to_v - v
    right = 1 if du > 0.0 else -1
    up = 1 if dv > 0.0 else -1
    next_u = np.inf
    next_v = np.inf
    step_u = np.inf
    step_v = np.inf
    if column != to_column:
        step_u = abs(1.0 / du)
        next_u = (column + (1 if du > 0.0 else 0) - u) / du
    if row != to_row:
        step_v = abs(1.0 / dv)
        next_v = (row + (1 if dv > 0.0 else 0) - v) / dv
    while True:
        index = min(max(row, 0), rows - 1) * columns + min(max(column, 0), columns - 1)
        for place in range(starts[index], starts[index + 1]):
            item = items[place]
            x0 = shapes[item, 0]
            y0 = shapes[item, 1]
            x1 = shapes[item, 2]
            y1 = shapes[item, 3]
            reach = shapes[item, 4] + more
            if x0 == x1 and y0 == y1:
                square = point_segment_square(x0, y0, ax, ay, bx, by)
            else:
                square = segments_square(ax, ay, bx, by, x0, y0, x1, y1)
            if square < reach * reach:
                return False
        # Never past the last column or row, whatever rounding says of the order.
        if column != to_column and (next_u < next_v or row == to_row):
            column += right
            next_u += step_u
        elif row != to_row:
            row += up
            next_v += step_v
        else:
            return True


@kernel
def segments_square(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float
) -> float:
    """The squared distance between the segments ab and cd, 0 where they cross."""
    side_c = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    side_d = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
    side_a = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
    side_b = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
    # Rounding can only mistake segments that all but touch, and those are too near anyway; one
    # whose end is on the other's line has a side of zero, and is told by the ends' distances.
    if side_c * side_d < 0.0 and side_a * side_b < 0.0:
        return 0.0
    near = point_segment_square(cx, cy, ax, ay, bx, by)
    near = min(near, point_segment_square(dx, dy, ax, ay, bx, by))
    near = min(near, point_segment_square(ax, ay, cx, cy, dx, dy))
    return min(near, point_segment_square(bx, by, cx, cy, dx, dy))
