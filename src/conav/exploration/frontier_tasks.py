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
from conav.exploration.belief import BLOCK, OPEN, STOOD
from conav.exploration.frontier_targets import (
    by_piece,
    connected_cells,
    cut_into_pieces,
    paths_to_targets,
)
from conav.exploration.types import TeamView
from conav.exploration.viewpoints import unknown_beside_frontier
from conav.geometry.jump_graph import JumpGraph
from conav.geometry.sight import cells_in_sight
from conav.geometry.sight_space import SightSpace, sight_space


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


Views = dict[int, tuple[int, NDArray[np.int64]]]
"""Unknown fine cell -> changes in the map around it so far, and the places that may see it."""


def _pockets(
    view: TeamView, targets: NDArray[np.int64], starts: NDArray[np.int64]
) -> list[tuple[int, NDArray[np.int64]]]:
    """An unknown fine cell of each pocket, and the places in reach that may see it."""
    belief = view.belief
    lattice = view.lattice
    sensor = view.body.sensor
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
    space = sight_space(sensor.range_m, lattice.resolution, sensor.occlusion, belief.cells.shape)
    around = np.empty(picks.shape, dtype=np.int64)
    _sum_around(belief.changes, belief.cells.shape, len(space.limits) - 1, picks, around)
    key = f"places that see {sensor.range_m!r} {sensor.occlusion}"
    before: Views = belief.derived.get(key, {})
    after: Views = {}
    found: list[tuple[int, NDArray[np.int64]]] = []
    for which in range(len(picks)):
        for cell, now in zip(picks[which].tolist(), around[which].tolist(), strict=True):
            kept = before.get(cell)
            if kept is None or kept[0] != now:
                kept = now, _look_back(view, cell, space)
            after[cell] = kept
            places = belief.ground.reachable(kept[1], starts)
            if len(places):
                found.append((cell, places))
                break
    belief.derived[key] = after
    return found


@kernel
def _sum_around(
    changes: NDArray[np.int64],
    shape: tuple[int, int],
    reach: int,
    cells: NDArray[np.int64],
    total: NDArray[np.int64],
) -> None:
    """Write how much has changed so far in the blocks within `reach` of each of some fine cells."""
    rows, cols = shape
    for i in range(cells.shape[0]):
        for j in range(cells.shape[1]):
            row = cells[i, j] // cols
            col = cells[i, j] % cols
            total[i, j] = 0
            for r in range(max(row - reach, 0) // BLOCK, min(row + reach, rows - 1) // BLOCK + 1):
                left = max(col - reach, 0) // BLOCK
                for c in range(left, min(col + reach, cols - 1) // BLOCK + 1):
                    total[i, j] += changes[r, c]


def _look_back(view: TeamView, cell: int, space: SightSpace) -> NDArray[np.int64]:
    """The planning cells known to be standable, not scanned from, that may see an unknown cell."""
    belief = view.belief
    lattice = view.lattice
    out = np.empty(belief.marks.size, dtype=np.int64)
    count = _places_that_see(
        belief.cells,
        cell,
        belief.marks,
        lattice.row_of,
        lattice.col_of,
        lattice.fine_row,
        lattice.fine_col,
        0 if lattice.ratio >= 1 else int(0.5 / lattice.ratio) + 1,
        *space,
        out,
    )
    return out[:count].copy()


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


@kernel
def _places_that_see(
    cells: NDArray[np.uint8],
    hidden: int,
    marks: NDArray[np.uint8],
    row_of: NDArray[np.int32],
    col_of: NDArray[np.int32],
    fine_row: NDArray[np.int32],
    fine_col: NDArray[np.int32],
    spread: int,
    limits: NDArray[np.int32],
    occlusion: bool,
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    stamps: NDArray[np.int32],
    places: NDArray[np.int64],
) -> int:
    """The number of open planning cells not stood on, written to `places`, that may see a cell."""
    fine_cols = cells.shape[1]
    rows, cols = marks.shape
    r = hidden // fine_cols
    c = hidden % fine_cols
    count = cells_in_sight(cells, r, c, occlusion, limits, lows, highs, out)
    stamp = stamps[stamps.shape[0] - 1] + 1
    stamps[stamps.shape[0] - 1] = stamp
    found = 0
    for i in range(count):
        if stamps[out[i]] == stamp:
            continue
        stamps[out[i]] = stamp
        r2 = out[i] // fine_cols
        c2 = out[i] % fine_cols
        for pr in range(max(row_of[r2] - spread, 0), min(row_of[r2] + spread, rows - 1) + 1):
            for pc in range(max(col_of[c2] - spread, 0), min(col_of[c2] + spread, cols - 1) + 1):
                if (
                    fine_row[pr] == r2
                    and fine_col[pc] == c2
                    and marks[pr, pc] & (OPEN | STOOD) == OPEN
                ):
                    places[found] = pr * cols + pc
                    found += 1
    return found
