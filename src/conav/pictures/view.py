"""Which part of a map is shown, how large, and as which tiles."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.maps.occupancy_grid import FREE, OCCUPIED
from conav.pictures.palette import FRONTIER, HIDDEN_WALL, UNKNOWN_GROUND, WALL, Colours
from conav.pictures.replay import Replay

MIN_GAIN = 0.15  # share of the map's area that cutting off must save
MARGIN = 0.03  # of the longer side of what is shown
MAX_GROW = 48  # [pixels] side of a cell


@dataclass(frozen=True)
class Window:
    """A rectangle of fine cells: rows `row0` to `row1`, columns `col0` to `col1`, ends excluded."""

    row0: int
    row1: int
    col0: int
    col1: int


@dataclass(frozen=True)
class View:
    """A window drawn as tiles: `shrink` by `shrink` cells each, `grow` by `grow` pixels each."""

    window: Window
    shrink: int
    grow: int
    resolution: float  # [m]
    page_width: int  # [pixels] at least the map's
    footer_height: int  # [pixels]

    @property
    def tile_rows(self) -> int:
        return -(-(self.window.row1 - self.window.row0) // self.shrink)

    @property
    def tile_cols(self) -> int:
        return -(-(self.window.col1 - self.window.col0) // self.shrink)

    @property
    def width(self) -> int:
        """Of the map [pixels]."""
        return self.tile_cols * self.grow

    @property
    def height(self) -> int:
        """Of the map [pixels]."""
        return self.tile_rows * self.grow

    @property
    def left(self) -> int:
        """Where the map begins on the page [pixels]."""
        return (self.page_width - self.width) // 2

    @property
    def pixels_per_m(self) -> float:
        return self.grow / self.shrink / self.resolution

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Where a point [m] of the grid's own frame lies on the map's picture, y down."""
        scale = self.grow / self.shrink
        return (
            (x / self.resolution - self.window.col0) * scale,
            self.height - (y / self.resolution - self.window.row0) * scale,
        )


def window_around(known: NDArray[np.bool_]) -> Window:
    """The known cells and a margin, or all of the map where that would save little."""
    rows, cols = known.shape
    whole = Window(0, rows, 0, cols)
    at_rows, at_cols = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if len(at_rows) == 0:
        return whole
    first_row, last_row = int(at_rows[0]), int(at_rows[-1])
    first_col, last_col = int(at_cols[0]), int(at_cols[-1])
    margin = max(round(MARGIN * max(last_row - first_row, last_col - first_col)), 2)
    window = Window(
        max(first_row - margin, 0),
        min(last_row + 1 + margin, rows),
        max(first_col - margin, 0),
        min(last_col + 1 + margin, cols),
    )
    area = (window.row1 - window.row0) * (window.col1 - window.col0)
    return window if area <= (1.0 - MIN_GAIN) * rows * cols else whole


def fitted(
    window: Window,
    resolution: float,
    max_pixels: int,
    min_width: int,
    footer_height: Callable[[int], int],
) -> View:
    """The largest view, by whole factors, whose picture with its footer fits into a square."""
    grow, shrink = MAX_GROW, 1
    while True:
        view = View(window, shrink, grow, resolution, 0, 0)
        width = max(view.width, min(min_width, max_pixels))
        footer = footer_height(width)
        tiny = view.tile_rows == view.tile_cols == 1
        if (width <= max_pixels and view.height + footer <= max_pixels) or tiny:
            return View(window, shrink, grow, resolution, width, footer)
        if grow > 1:
            grow -= 1
        else:
            shrink += 1


class Tiles:
    """The colour number of every tile of a view, kept up as cells become known.

    Where a tile holds several cells, a known wall wins, then known free ground if it is at least
    half of the tile, so that thin walls stay visible and the edge of the known stays in place.
    """

    def __init__(self, view: View, truth: NDArray[np.uint8], colours: Colours) -> None:
        self.view = view
        window = view.window
        self._truth = truth
        self._tint = np.array(
            [colours.tint(robot) for robot in range(colours.distinct)], dtype=np.uint8
        )
        hidden = truth[window.row0 : window.row1, window.col0 : window.col1] == OCCUPIED
        if view.shrink > 1:
            rows, cols, side = view.tile_rows, view.tile_cols, view.shrink
            padded = np.zeros((rows * side, cols * side), dtype=np.bool_)
            padded[: hidden.shape[0], : hidden.shape[1]] = hidden
            hidden = padded.reshape(rows, side, cols, side).any(axis=(1, 3))
        self.codes = np.where(hidden, HIDDEN_WALL, UNKNOWN_GROUND).astype(np.uint8)

    def reveal(self, cells: NDArray[np.int64], replay: Replay) -> None:
        """Draw these flat fine cells as the replay knows them now."""
        window, side = self.view.window, self.view.shrink
        row, col = np.divmod(cells, self._truth.shape[1])
        inside = (
            (row >= window.row0) & (row < window.row1) & (col >= window.col0) & (col < window.col1)
        )
        row, col = row[inside], col[inside]
        tile = (row - window.row0) // side * self.view.tile_cols + (col - window.col0) // side
        codes = self.codes.reshape(-1)
        if side == 1:
            codes[tile] = self._shade(replay.team_map[row, col], replay.first_seen_by[row, col])
            return
        if len(tile) == 0:
            return
        tile = np.unique(tile)
        across = np.arange(side)
        rows = window.row0 + (tile // self.view.tile_cols)[:, None] * side + across
        cols = window.col0 + (tile % self.view.tile_cols)[:, None] * side + across
        # A tile that hangs over the edge repeats the last row or column of the window.
        rows = np.minimum(rows, window.row1 - 1)[:, :, None]
        cols = np.minimum(cols, window.col1 - 1)[:, None, :]
        known = replay.team_map[rows, cols].reshape(len(tile), -1)
        seen_by = replay.first_seen_by[rows, cols].reshape(len(tile), -1)
        free = known == FREE
        first = np.argmax(free, axis=1)
        shade = self._shade(
            np.where((known == OCCUPIED).any(axis=1), OCCUPIED, FREE),
            seen_by[np.arange(len(tile)), first],
        )
        decided = (known == OCCUPIED).any(axis=1) | (free.sum(axis=1) * 2 >= side * side)
        codes[tile] = np.where(decided, shade, codes[tile])

    def ground(self, *, frontier: bool) -> NDArray[np.uint8]:
        """Colour numbers of the map's pixels, north up, shape (height, width).

        With `frontier`, free tiles beside unknown ones are marked.
        """
        codes = self.codes
        if frontier:
            unknown = (codes == UNKNOWN_GROUND) | (codes == HIDDEN_WALL)
            near = np.zeros_like(unknown)
            near[1:] |= unknown[:-1]
            near[:-1] |= unknown[1:]
            near[:, 1:] |= unknown[:, :-1]
            near[:, :-1] |= unknown[:, 1:]
            codes = np.where(near & (codes > WALL), np.uint8(FRONTIER), codes)
        codes = codes[::-1]
        if self.view.grow == 1:
            return codes
        return codes.repeat(self.view.grow, axis=0).repeat(self.view.grow, axis=1)

    def _shade(self, known: NDArray[np.uint8], seen_by: NDArray[np.int16]) -> NDArray[np.uint8]:
        tint = self._tint[seen_by % len(self._tint)]
        return np.where(known == OCCUPIED, np.uint8(WALL), tint)
