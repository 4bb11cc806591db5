"""Everything that is left to see as tasks: pieces of frontier, and pockets looked into from afar.

A piece of frontier is stood on. A pocket is unknown area whose frontier no robot can stand on or
beside: behind furniture, along walls, in gaps. Strategies usually leave pockets to the end, when a
robot has to come back for each; here they are tasks from the moment they are seen. The places from
which a pocket may be looked into are the cells that it can see, with everything unknown taken as
clear.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.frontier_targets import (
    by_piece,
    connected_cells,
    cut_into_pieces,
    paths_to_targets,
)
from conav.exploration.look_back import Views
from conav.exploration.types import TeamView
from conav.exploration.viewpoints import unknown_beside_frontier
from conav.geometry.jump_graph import JumpGraph


@dataclass(frozen=True, eq=False)
class Tasks:
    """Tasks, the places from which each is done, and what it costs each robot to get there.

    Places of task j are `places[first[j]:first[j + 1]]`. `looks_for` is the unknown fine cell a
    pocket is about, -1 for a piece of frontier.
    """

    places: NDArray[np.int64]  # flat planning cells
    first: NDArray[np.int64]  # (n_tasks + 1,)
    looks_for: NDArray[np.int64]  # (n_tasks,)
    costs: NDArray[np.float64]  # (n_robots, n_tasks) to the nearest place [planning cells], inf
    nearest: NDArray[np.int64]  # (n_robots, n_tasks) that place, of equals the first
    paths: JumpGraph  # to the places

    def __len__(self) -> int:
        return len(self.looks_for)


def find_tasks(view: TeamView, positions: NDArray[np.int32]) -> Tasks:
    """The tasks that robots at these planning cells can reach."""
    belief = view.belief
    ground = belief.ground
    starts = positions.astype(np.int64)
    # Whoever can be reached can reach the same.
    targets = ground.reachable(paths_to_targets(belief).cells, starts)
    length = max(int(view.body.sensor.range_m / view.lattice.cell_m), 1)
    piece, n_pieces = cut_into_pieces(targets, view.lattice.cols, length)
    order, first = by_piece(piece, n_pieces)
    pockets = _pockets(view, targets, starts)
    places = np.concatenate([targets[order], *(around for _, around in pockets)])
    ends = [len(around) for _, around in pockets]
    first = np.concatenate([first, len(targets) + np.cumsum(ends, dtype=np.int64)])
    looks_for = np.full(n_pieces + len(pockets), -1, dtype=np.int64)
    looks_for[n_pieces:] = [cell for cell, _ in pockets]
    paths = JumpGraph(ground, first, places)
    costs, nearest = paths.lengths(starts)
    return Tasks(places, first, looks_for, costs, nearest, paths)


def _pockets(
    view: TeamView, targets: NDArray[np.int64], starts: NDArray[np.int64]
) -> list[tuple[int, NDArray[np.int64]]]:
    """An unknown fine cell of each pocket, and the places in reach that may see it."""
    belief = view.belief
    lattice = view.lattice
    hidden = unknown_beside_frontier(belief)
    wanted = np.zeros(belief.marks.shape, dtype=np.bool_)
    wanted.reshape(-1)[targets] = True
    alone = np.empty(len(hidden), dtype=np.bool_)
    _stand_alone(hidden, wanted, lattice.row_of, lattice.col_of, alone)
    hidden = hidden[alone]
    order, first = by_piece(*connected_cells(hidden, belief.cells.shape[1]))
    # One cell in the middle stands for the pocket, or another where that one is out of sight.
    start, end = first[:-1], first[1:]
    picks = hidden[order[np.stack([(start + end) // 2, start, end - 1], axis=1)]]
    views = Views(view)
    found: list[tuple[int, NDArray[np.int64]]] = []
    for cells in picks.tolist():
        for cell in cells:
            places = belief.ground.reachable(views.places(cell), starts)
            if len(places):
                found.append((cell, places))
                break
    views.keep()
    return found


@kernel
def _stand_alone(
    hidden: NDArray[np.int64],
    wanted: NDArray[np.bool_],
    row_of: NDArray[np.int32],
    col_of: NDArray[np.int32],
    alone: NDArray[np.bool_],
) -> None:
    """Whether no wanted planning cell is that of a hidden fine cell or one of its eight neighbours.

    Written to `alone`, one for each of `hidden`.
    """
    rows, cols = wanted.shape
    fine_cols = col_of.shape[0]
    for i in range(hidden.shape[0]):
        row = row_of[hidden[i] // fine_cols]
        col = col_of[hidden[i] % fine_cols]
        alone[i] = True
        for r in range(max(row - 1, 0), min(row + 1, rows - 1) + 1):
            for c in range(max(col - 1, 0), min(col + 1, cols - 1) + 1):
                if wanted[r, c]:
                    alone[i] = False
