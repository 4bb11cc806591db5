"""Targets for robots that are sent to frontiers together, and the drive to them.

A target is a planning cell with frontier in it that nobody has scanned from. Neighbouring ones make
a cluster; a long cluster is cut into pieces no longer than the sensor's range, so that two robots
may work at two ends of it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from conav.exploration.belief import TARGET, Belief
from conav.exploration.types import TeamView
from conav.geometry.grid_search import search, search_space


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
    piece, n_pieces = cut_into_pieces(wanted, cells, length)
    costs = path_costs(belief, positions, cells)
    return Targets(cells, piece, n_pieces, costs)


def cut_into_pieces(
    wanted: NDArray[Any], cells: NDArray[np.int64], length: int
) -> tuple[NDArray[np.int64], int]:
    """The piece of every target, numbered from 0, and how many there are.

    `wanted` (rows, cols) is not 0 at the targets `cells`; a piece lies in a square block of that
    `length` [planning cells].
    """
    if len(cells) == 0:
        return cells, 0
    cols = wanted.shape[1]
    row, col = np.divmod(cells, cols)
    block = (row // length) * (cols // length + 1) + col // length
    number = np.full((wanted.shape[0] + 2, cols + 2), -1, dtype=np.int64)
    number[row + 1, col + 1] = np.arange(len(cells))
    # Neighbours in the same block belong together: half of the eight directions are enough.
    pairs: list[NDArray[np.int64]] = []
    for down, right in ((0, 1), (1, -1), (1, 0), (1, 1)):
        other = number[row + 1 + down, col + 1 + right]
        joined = np.flatnonzero((other >= 0) & (block == block[other]))
        pairs.append(np.stack([joined, other[joined]]))
    one, two = np.concatenate(pairs, axis=1)
    graph = coo_array((np.ones(len(one)), (one, two)), shape=(len(cells), len(cells)))
    count, piece = connected_components(graph, directed=False)
    return np.asarray(piece, dtype=np.int64), int(count)


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
