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
from conav.exploration.belief import BLOCK, OPEN, STOOD, Belief
from conav.exploration.frontier_targets import (
    connected_cells,
    cut_into_pieces,
    paths_to_targets,
)
from conav.exploration.types import TeamView
from conav.exploration.viewpoints import unknown_beside_frontier
from conav.geometry.ground import Ground
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
    lattice = view.lattice
    targets = paths_to_targets(belief).cells
    # Whoever can be reached can reach the same.
    inside = sorted(set(belief.ground.parts(positions.astype(np.int64)).tolist()))
    targets = targets[_within(belief.ground, inside, targets)]
    length = max(int(view.body.sensor.range_m / lattice.cell_m), 1)
    piece, n_pieces = cut_into_pieces(targets, lattice.cols, length)
    order = np.argsort(piece, kind="stable")
    parts = [targets[order]]
    sizes = np.bincount(piece, minlength=n_pieces).tolist() if n_pieces else []
    looks_for = [-1] * n_pieces
    for cell, around in _pockets(view, targets, inside):
        parts.append(around)
        sizes.append(len(around))
        looks_for.append(cell)
    places = np.concatenate(parts)
    first = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    paths = JumpGraph(belief.ground, first, places)
    costs, nearest = paths.lengths(positions.astype(np.int64))
    return Tasks(places, first, np.array(looks_for, dtype=np.int64), costs, nearest, paths)


def _within(ground: Ground, inside: list[int], cells: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which of some planning cells lie in the parts of a ground that robots are in."""
    parts = ground.parts(cells)
    return parts == inside[0] if len(inside) == 1 else np.isin(parts, inside)


Views = dict[int, tuple[int, NDArray[np.int64]]]
"""Unknown fine cell -> changes in the map around it so far, and the places that may see it."""


def _pockets(
    view: TeamView, targets: NDArray[np.int64], inside: list[int]
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
    cluster, count = connected_cells(hidden, belief.cells.shape[1])
    key = f"places that see {sensor.range_m!r} {sensor.occlusion}"
    before: Views = belief.derived.get(key, {})
    after: Views = {}
    found: list[tuple[int, NDArray[np.int64]]] = []
    order = np.argsort(cluster, kind="stable")
    ends = np.cumsum(np.bincount(cluster, minlength=count)) if count else []
    start = 0
    space = sight_space(sensor.range_m, lattice.resolution, sensor.occlusion, belief.cells.shape)
    for end in map(int, ends):
        # One cell in the middle stands for the pocket, or another where that one is out of sight.
        for pick in (int((start + end) // 2), start, end - 1):
            cell = int(hidden[order[pick]])
            changes = _changes_around(belief, cell, len(space.limits) - 1)
            kept = before.get(cell)
            if kept is None or kept[0] != changes:
                kept = changes, _look_back(view, cell, space)
            after[cell] = kept
            around = kept[1][_within(belief.ground, inside, kept[1])]
            if len(around):
                found.append((cell, around))
                break
        start = end
    belief.derived[key] = after
    return found


def _changes_around(belief: Belief, cell: int, reach: int) -> int:
    """How much has changed so far within some fine cells of one."""
    row, col = divmod(cell, belief.cells.shape[1])
    rows = slice(max(row - reach, 0) // BLOCK, (row + reach) // BLOCK + 1)
    cols = slice(max(col - reach, 0) // BLOCK, (col + reach) // BLOCK + 1)
    return int(belief.changes[rows, cols].sum())


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
