"""Targets for robots that are sent to frontiers together, and the drive to them.

A target is a planning cell with frontier in it that nobody has scanned from. Neighbouring ones make
a cluster; a long cluster is cut into pieces no longer than the sensor's range, so that two robots
may work at two ends of it.
"""

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from conav.exploration.belief import TARGET, Belief
from conav.exploration.types import TeamView
from conav.geometry.grid_search import search, search_space

_EIGHT = np.ones((3, 3), dtype=np.int8)


@dataclass(frozen=True, eq=False)
class Targets:
    """Where to go, and how far it is for each robot."""

    cells: NDArray[np.int64]  # (n_targets,) flat planning cells, ascending
    piece: NDArray[np.int64]  # (n_targets,) the piece of a cluster each belongs to
    n_pieces: int
    costs: NDArray[np.float64]  # (n_robots, n_targets) [planning cells], inf where unreachable

    def piece_costs(self) -> NDArray[np.float64]:
        """The cost of each piece for each robot: that of its nearest target, (n_robots, pieces)."""
        costs = np.full((len(self.costs), self.n_pieces), np.inf)
        for robot, row in enumerate(self.costs):
            np.minimum.at(costs[robot], self.piece, row)
        return costs

    def nearest_in(self, robot: int, piece: int) -> int:
        """The cell of a piece nearest to a robot, the lower number first."""
        inside = np.flatnonzero(self.piece == piece)
        return int(self.cells[inside[np.argmin(self.costs[robot, inside])]])


def find_targets(view: TeamView, positions: NDArray[np.int32]) -> Targets:
    """The targets this robot knows of, with the costs for robots at these planning cells."""
    belief = view.belief
    wanted = np.asarray(belief.marks & TARGET, dtype=np.uint8)
    cells = np.flatnonzero(wanted)
    length = max(int(view.body.sensor.range_m / view.lattice.cell_m), 1)
    piece, n_pieces = _pieces(wanted, cells, length)
    costs = path_costs(belief, positions, cells)
    return Targets(cells, piece, n_pieces, costs)


def _pieces(
    wanted: NDArray[np.uint8], cells: NDArray[np.int64], length: int
) -> tuple[NDArray[np.int64], int]:
    """The piece of every target, numbered from 0, and how many there are."""
    if len(cells) == 0:
        return cells, 0
    cols = wanted.shape[1]
    row, col = np.divmod(cells, cols)
    # Only the part of the map that has targets is looked at.
    top, left = row.min(), col.min()
    part = wanted[top : row.max() + 1, left : col.max() + 1]
    clusters = np.asarray(cast("tuple[Any, int]", label(part, structure=_EIGHT))[0])
    cluster = clusters[row - top, col - left].astype(np.int64)
    wide = cols // length + 1
    block = (row // length) * wide + col // length
    keys = cluster * (wide * (wanted.shape[0] // length + 1)) + block
    unique, piece = np.unique(keys, return_inverse=True)
    return piece.astype(np.int64), len(unique)


def path_costs(
    belief: Belief, positions: NDArray[np.int32], cells: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Path lengths [planning cells] from positions to cells over known moves, inf where none is."""
    space = search_space(belief.moves.size)
    nowhere = np.zeros_like(belief.marks)
    costs = np.full((len(positions), len(cells)), np.inf)
    for robot, position in enumerate(positions):
        search(belief.moves, int(position), nowhere, 1, space)
        reached = space.stamp[cells] == space.stamp[-1]
        costs[robot, reached] = space.distance[cells[reached]]
    return costs
