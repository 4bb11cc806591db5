"""An open square with three rectangles, after the example world of the potential-game papers."""

import math

import numpy as np

from conav.maps.occupancy_grid import FREE, OCCUPIED, OccupancyGrid

_START = 4  # cells a side of the lower left square where robots start
_TRIES = 2000
_TRIES_AT_ONCE = 40  # then all are placed anew, as the first may leave no place for the rest
_STRIP_M = 0.6  # [m] clear width around an obstacle, and on larger grids two cells at least

_Box = tuple[int, int, int, int]  # first and past-the-end column, first and past-the-end row


def three_obstacles(
    width_m: float, height_m: float, resolution: float, rng: np.random.Generator
) -> OccupancyGrid:
    """An open rectangle of grid points with three rectangular obstacles placed by `rng`.

    Sizes in metres, rounded to whole cells; at least 12 cells a side. After the world of
    [Philip2014], "three obstacles" in a Z x Z grid whose border is the limit: no wall cells stand
    around it. The papers give neither Z nor the places of the obstacles, so both are ours. Free
    cells are one 4-connected part, because obstacles touch neither each other nor the border, and
    the 4 x 4 cells at the lower left are free for robots to start on.
    """
    rows, cols = round(height_m / resolution), round(width_m / resolution)
    cells = np.full((rows, cols), FREE, np.uint8)
    # Two robots on grid points pass each other in two cells, a round one needs its diameter.
    strip = max(2 if min(rows, cols) >= 20 else 1, math.ceil(_STRIP_M / resolution))
    for left, right, bottom, top in _layout(rows, cols, strip, rng):
        cells[bottom:top, left:right] = OCCUPIED
    return OccupancyGrid(cells, resolution, name="three-obstacles")


def _layout(rows: int, cols: int, strip: int, rng: np.random.Generator) -> list[_Box]:
    """Three boxes with so many clear cells around each."""
    boxes: list[_Box] = []
    for attempt in range(_TRIES):
        if attempt % _TRIES_AT_ONCE == 0:
            boxes = [(0, _START, 0, _START)]  # the start is kept clear like an obstacle
        wide = int(rng.integers(max(1, cols // 8), max(2, cols // 3) + 1))
        high = int(rng.integers(max(1, rows // 8), max(2, rows // 3) + 1))
        left = int(rng.integers(strip, cols - strip - wide + 1))
        bottom = int(rng.integers(strip, rows - strip - high + 1))
        box = (left, left + wide, bottom, bottom + high)
        if not any(_closer_than(strip, box, other) for other in boxes):
            boxes.append(box)
        if len(boxes) == 4:
            return boxes[1:]
    # One in each quarter but the start's always fits.
    wide, high = max(1, cols // 5), max(1, rows // 5)
    east, north = (3 * cols) // 4 - wide // 2, (3 * rows) // 4 - high // 2
    west, south = cols // 4 - wide // 2, rows // 4 - high // 2
    corners = ((east, south), (west, north), (east, north))
    return [(x, x + wide, y, y + high) for x, y in corners]


def _closer_than(strip: int, one: _Box, other: _Box) -> bool:
    """Whether fewer than `strip` clear cells lie between two boxes, corners included."""
    return (
        one[0] < other[1] + strip
        and other[0] < one[1] + strip
        and one[2] < other[3] + strip
        and other[2] < one[3] + strip
    )
