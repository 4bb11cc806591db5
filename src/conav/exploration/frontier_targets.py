"""Targets for robots that are sent to frontiers together, and the drive to them.

A target is a planning cell with frontier in it that nobody has scanned from. Neighbouring ones make
a cluster; a long cluster is cut into pieces no longer than the sensor's range, so that two robots
may work at two ends of it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.belief import TARGET, Belief
from conav.exploration.types import TeamView
from conav.geometry.ground import Ground
from conav.geometry.jump_graph import JumpGraph
from conav.geometry.sparse_cells import cells_with_bits


@dataclass(frozen=True, eq=False)
class Targets:
    """Where to go, and how far it is for each robot."""

    cells: NDArray[np.int64]  # (n_targets,) flat planning cells, ascending
    piece: NDArray[np.int64]  # (n_targets,) the piece of a cluster each belongs to
    n_pieces: int
    costs: NDArray[np.float64]  # (n_robots, n_targets) [planning cells], inf where unreachable

    def piece_costs(self) -> NDArray[np.float64]:
        """The cost of each piece for each robot: that of its nearest target, (n_robots, pieces)."""
        if self.n_pieces == 0:
            return np.empty((len(self.costs), 0))
        order, first = by_piece(self.piece, self.n_pieces)
        return np.minimum.reduceat(self.costs[:, order], first[:-1], axis=1)

    def nearest_in(self, robot: int, piece: int) -> int:
        """The cell of a piece nearest to a robot, the lower number first."""
        inside = np.flatnonzero(self.piece == piece)
        return int(self.cells[inside[np.argmin(self.costs[robot, inside])]])


def find_targets(view: TeamView, positions: NDArray[np.int32]) -> Targets:
    """The targets this robot knows of, with the costs for robots at these planning cells."""
    cells, piece, n_pieces = find_pieces(view)
    return Targets(cells, piece, n_pieces, paths_to_targets(view.belief).costs(positions))


def find_pieces(view: TeamView) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """The targets this robot knows of, flat and ascending, the piece of each, and how many."""
    cells = paths_to_targets(view.belief).cells
    length = max(int(view.body.sensor.range_m / view.lattice.cell_m), 1)
    piece, n_pieces = cut_into_pieces(cells, view.lattice.cols, length)
    return cells, piece, n_pieces


def cut_into_pieces(
    cells: NDArray[np.int64], cols: int, length: int
) -> tuple[NDArray[np.int64], int]:
    """The piece of every target, numbered from 0 by their lowest cells, and how many there are.

    `cells` are flat in a grid of `cols` columns, ascending; neighbours, diagonal ones too, belong
    together where they lie in one square block of that `length` [cells].
    """
    piece = np.empty(len(cells), dtype=np.int64)
    return piece, _cut(cells, cols, length, piece)


def connected_cells(cells: NDArray[np.int64], cols: int) -> tuple[NDArray[np.int64], int]:
    """The cluster of each cell as `cut_into_pieces`, however long, and how many there are."""
    return cut_into_pieces(cells, cols, int(np.iinfo(np.int64).max))


def by_piece(
    piece: NDArray[np.int64], n_pieces: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cells piece by piece, each in their order, and where each piece begins.

    Both are indices: cells of piece j are `order[first[j]:first[j + 1]]`.
    """
    order = np.empty(len(piece), dtype=np.int64)
    first = np.zeros(n_pieces + 1, dtype=np.int64)
    _sort_by_piece(piece, order, first)
    return order, first


@kernel
def _sort_by_piece(
    piece: NDArray[np.int64], order: NDArray[np.int64], first: NDArray[np.int64]
) -> None:
    """Write `order` and `first`, which is 0 so far."""
    n_pieces = first.shape[0] - 1
    for i in range(piece.shape[0]):
        first[piece[i] + 1] += 1
    for j in range(n_pieces):
        first[j + 1] += first[j]
    following = first.copy()
    for i in range(piece.shape[0]):
        order[following[piece[i]]] = i
        following[piece[i]] += 1


@kernel
def _cut(cells: NDArray[np.int64], cols: int, length: int, piece: NDArray[np.int64]) -> int:
    """The number of pieces written to `piece`, by union of each cell with those before it."""
    above = 0  # the first cell that may lie in the row below this one's and touch it
    for i in range(cells.shape[0]):
        cell = cells[i]
        row = cell // cols
        col = cell % cols
        piece[i] = i
        if i > 0 and col > 0 and cells[i - 1] == cell - 1 and (col - 1) // length == col // length:
            _join(piece, i, i - 1)
        while cells[above] < cell - cols - 1:
            above += 1
        if row == 0 or (row - 1) // length != row // length:
            continue
        j = above
        while cells[j] <= cell - cols + 1:
            other = cells[j] % cols
            # Both rows' ends are neighbours in flat numbers only.
            if abs(other - col) <= 1 and other // length == col // length:
                _join(piece, i, j)
            j += 1
    count = 0
    for i in range(cells.shape[0]):
        if piece[i] == i:
            piece[i] = count
            count += 1
        else:
            piece[i] = piece[piece[i]]  # a lower one, which has its number
    return count


@kernel
def _join(piece: NDArray[np.int64], one: int, other: int) -> None:
    """Put two cells into one piece; its lowest cell stands for it."""
    while piece[one] != one:
        piece[one] = piece[piece[one]]
        one = piece[one]
    while piece[other] != other:
        piece[other] = piece[piece[other]]
        other = piece[other]
    if one < other:
        piece[other] = one
    else:
        piece[one] = other


class PathsTo:
    """Path lengths over known moves to some planning cells, from wherever they are asked for.

    What was asked for is kept; it holds as long as the ground and the cells do.
    """

    def __init__(self, ground: Ground, cells: NDArray[np.int64]) -> None:
        self.cells = cells  # (n_cells,) flat, ascending
        self._ground = ground
        self._rows: dict[int, NDArray[np.float64]] = {}

    @cached_property
    def _graph(self) -> JumpGraph:
        return JumpGraph(self._ground, np.arange(len(self.cells) + 1), self.cells)

    def costs(self, positions: NDArray[np.int32]) -> NDArray[np.float64]:
        """From each position to each cell [planning cells], inf where no path leads."""
        starts = positions.tolist()
        fresh = [start for start in dict.fromkeys(starts) if start not in self._rows]
        if fresh:
            rows, _ = self._graph.lengths(np.array(fresh, dtype=np.int64))
            self._rows.update(zip(fresh, rows, strict=True))
        found = np.empty((len(starts), len(self.cells)))
        for row, start in zip(found, starts, strict=True):
            row[:] = self._rows[start]
        return found

    def costs_from(self, start: int) -> NDArray[np.float64]:
        """From one planning cell to each cell, (n_cells,); kept, not to be written to."""
        row = self._rows.get(start)
        if row is None:
            row = self._graph.lengths(np.array([start]))[0][0]
            self._rows[start] = row
        return row

    def cost(self, start: int, index: int) -> float:
        """From one planning cell to `cells[index]`."""
        row = self._rows.get(start)
        return self._graph.length(start, index) if row is None else float(row[index])


def paths_to_targets(belief: Belief) -> PathsTo:
    """Paths to all cells with frontier that nobody has scanned from, kept until a scan is heard."""
    kept: tuple[int, PathsTo] | None = belief.derived.get("paths to targets")
    if kept is None or kept[0] != belief.scans:
        cells = np.empty(belief.marks.size, dtype=np.int64)
        count = cells_with_bits(belief.marks.reshape(-1), TARGET, cells)
        kept = belief.scans, PathsTo(belief.ground, cells[:count].copy())
        belief.derived["paths to targets"] = kept
    return kept[1]


Kept = tuple[PathsTo, tuple[int, ...], PathsTo, NDArray[np.int64]]
"""Paths to all targets, then what was asked for last, and what was answered."""


def paths_to(belief: Belief, wanted: tuple[int, ...]) -> tuple[PathsTo, NDArray[np.int64]]:
    """Paths to some planning cells, and which of their cells these are.

    Where all are targets, they are those to the targets. What was asked for last is kept, as all
    bidders of an auction ask for the same.
    """
    paths = paths_to_targets(belief)
    kept: Kept | None = belief.derived.get("paths to")
    if kept is not None and kept[0] is paths and kept[1] == wanted:
        return kept[2], kept[3]
    found, which = _paths_to(belief, paths, np.array(wanted, dtype=np.int64))
    belief.derived["paths to"] = paths, wanted, found, which
    return found, which


def _paths_to(
    belief: Belief, paths: PathsTo, cells: NDArray[np.int64]
) -> tuple[PathsTo, NDArray[np.int64]]:
    which = np.searchsorted(paths.cells, cells)
    if len(cells) and (
        which.max() == len(paths.cells) or not np.array_equal(paths.cells[which], cells)
    ):
        paths = PathsTo(belief.ground, np.unique(cells))
        which = np.searchsorted(paths.cells, cells)
    return paths, which
