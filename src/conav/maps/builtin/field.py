"""An open field: a wall around a large yard, and a few convex obstacles."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conav.maps.occupancy_grid import FREE, OCCUPIED, OccupancyGrid

_TILE_M = 14.0  # [m] one obstacle at most stands in a square this wide
_GAP_M = 1.2  # [m] clear width between obstacles, and between them and the wall
_WALL_M = 0.3  # [m]
# Cosine and sine of a turn as whole numbers over a whole number, so that turned boxes need no
# trigonometry, which differs between machines.
_TURNS = ((1, 0, 1), (4, 3, 5), (3, 4, 5), (12, 5, 13), (5, 12, 13), (15, 8, 17), (24, 7, 25))


def field(
    width_m: float, height_m: float, resolution: float, rng: np.random.Generator
) -> OccupancyGrid:
    """A large open yard inside a wall, with scattered posts, round beds and boxes.

    Sizes in metres, rounded to whole cells; at least 12 cells a side. All obstacles are convex and
    stand clear of each other and of the wall, so the free cells are one part.
    """
    rows, cols = round(height_m / resolution), round(width_m / resolution)
    cells = np.full((rows, cols), OCCUPIED, np.uint8)
    wall = max(1, round(_WALL_M / resolution))
    yard = cells[wall:-wall, wall:-wall]
    yard[...] = FREE

    gap = max(1, round(_GAP_M / resolution))
    tile_rows = _cuts(yard.shape[0] - gap, max(1, round(height_m / _TILE_M)), gap)
    tile_cols = _cuts(yard.shape[1] - gap, max(1, round(width_m / _TILE_M)), gap)
    for bottom, top in tile_rows:
        for left, right in tile_cols:
            if rng.integers(0, 100) < 60:
                _place(yard[bottom:top, left:right], resolution, rng)
    return OccupancyGrid(cells, resolution, name="field")


def _cuts(cells: int, parts: int, gap: int) -> list[tuple[int, int]]:
    """First and past-the-end cell of each tile along an axis, `gap` cells before each of them."""
    ends = [cells * part // parts for part in range(parts + 1)]
    return [(first + gap, last) for first, last in pairwise(ends)]


def _place(tile: NDArray[np.uint8], resolution: float, rng: np.random.Generator) -> None:
    """Draws one obstacle somewhere inside the tile, in place; nothing if it does not fit."""
    shape: NDArray[np.bool_]
    kind = int(rng.integers(0, 10))
    if kind < 5:
        shape = _disc(int(rng.integers(20, 41)), resolution)  # a post or a tree trunk
    elif kind < 7:
        shape = _disc(int(rng.integers(80, 201)), resolution)  # a round flower bed
    else:
        turn = _TURNS[int(rng.integers(0, len(_TURNS)))]
        sides = int(rng.integers(80, 251)), int(rng.integers(80, 501))
        shape = _box(sides, turn, resolution)  # a crate, a shed, a parked cart
        if rng.integers(0, 2):
            shape = np.fliplr(shape)
    rows, cols = int(shape.shape[0]), int(shape.shape[1])
    spare_rows, spare_cols = int(tile.shape[0]) - rows, int(tile.shape[1]) - cols
    if min(spare_rows, spare_cols) < 0:
        return
    row, col = int(rng.integers(0, spare_rows + 1)), int(rng.integers(0, spare_cols + 1))
    tile[row : row + rows, col : col + cols][shape] = OCCUPIED


def _disc(radius_cm: int, resolution: float) -> NDArray[np.bool_]:
    """Which cells of its square belong to a disc, one cell at least."""
    across = max(1, round(2 * radius_cm / 100 / resolution))
    off = np.arange(across, dtype=np.float64) - (across - 1) / 2
    return off[:, None] * off[:, None] + off * off <= across * across / 4


def _box(
    sides_cm: tuple[int, int], turn: tuple[int, int, int], resolution: float
) -> NDArray[np.bool_]:
    """Which cells of its bounding rectangle belong to a turned box, one cell at least."""
    wide, high = (max(1.0, side / 100 / resolution) for side in sides_cm)
    if min(wide, high) < 6.0:
        turn = _TURNS[0]  # so few cells make a ragged star of a turned box
    cosine, sine = turn[0] / turn[2], turn[1] / turn[2]
    cols = round(wide * cosine + high * sine)
    rows = round(wide * sine + high * cosine)
    x = np.arange(cols, dtype=np.float64) - (cols - 1) / 2
    y = (np.arange(rows, dtype=np.float64) - (rows - 1) / 2)[:, None]
    along, across = x * cosine + y * sine, y * cosine - x * sine
    # A margin far below a cell, so that a side that falls on cell centres includes them.
    return (np.abs(along) <= wide / 2 + 1e-9) & (np.abs(across) <= high / 2 + 1e-9)
