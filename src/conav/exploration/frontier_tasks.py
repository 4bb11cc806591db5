"""Everything that is left to see as tasks: pieces of frontier, and pockets looked into from afar.

A piece of frontier is stood on. A pocket is unknown area whose frontier no robot can stand on or
beside: behind furniture, along walls, in gaps. Strategies usually leave pockets to the end, when a
robot has to come back for each; here they are tasks from the moment they are seen. The places from
which a pocket may be looked into are the cells that it can see, with everything unknown taken as
clear.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.belief import BLOCK, OPEN, STOOD, TARGET, Belief
from conav.exploration.frontier_targets import connected_cells, cut_into_pieces
from conav.exploration.types import TeamView
from conav.exploration.viewpoints import unknown_beside_frontier
from conav.geometry.distance_field import (
    field_buffer,
    fill_distances,
    nearest_of_groups,
)
from conav.geometry.growing_field import GrowingField
from conav.geometry.sight import disc_cells, visible_cells
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

    def __len__(self) -> int:
        return len(self.looks_for)


KEPT_BYTES = 2**28
"""Fields from the places of tasks are kept, from one assignment to the next, up to this size."""


def costs_between(belief: Belief, tasks: Tasks, starts: Sequence[int]) -> NDArray[np.float64]:
    """Path lengths from planning cells to the nearest place of each task, (n_starts, n_tasks).

    Made for places of tasks: most are asked for again at the next assignment, when the map has
    grown a little, so their fields are kept and grow with it.
    """
    before: dict[int, GrowingField] = belief.derived.get("fields of tasks", {})
    after: dict[int, GrowingField] = {}
    wanted = set(starts)
    room = KEPT_BYTES // GrowingField.bytes_of(belief.ground) - len(before)
    spare = [field for start, field in before.items() if start not in wanted]
    costs = np.empty((len(starts), len(tasks)))
    nearest = np.empty(len(tasks), dtype=np.int64)
    for row, start in zip(costs, starts, strict=True):
        field = after.get(start) or before.get(start)
        if field is None and spare:
            field = spare.pop()
            field.restart(start)
        elif field is None and room > 0:
            room -= 1
            field = GrowingField(belief.ground, start)
        if field is None:
            distance = _to_tasks(belief, start, tasks)
        else:
            after[start] = field
            distance = field.distance
        nearest_of_groups(distance, tasks.first, tasks.places, row, nearest)
    belief.derived["fields of tasks"] = after
    return costs


def _to_tasks(belief: Belief, start: int, tasks: Tasks) -> NDArray[np.float64]:
    """Path lengths from a planning cell, exact as far as the nearest place of every task."""
    distance = field_buffer(belief.moves.size)
    here = np.array([start], dtype=np.int64)
    fill_distances(belief.ground, here, distance, tasks.first, tasks.places)
    return distance


def distance_fields(belief: Belief, starts: NDArray[np.int64]) -> NDArray[np.float64]:
    """Path lengths [planning cells] from each start to every cell over known moves, inf if none."""
    fields = np.empty((len(starts), belief.moves.size))
    for start, field in zip(starts, fields, strict=True):
        fill_distances(belief.ground, np.array([start], dtype=np.int64), field)
    return fields


def find_tasks(view: TeamView, positions: NDArray[np.int32]) -> Tasks:
    """The tasks that robots at these planning cells can reach."""
    belief = view.belief
    lattice = view.lattice
    marks = belief.marks.reshape(-1)
    reach, fields = _reach(belief, positions)
    wanted = (marks & TARGET != 0) & reach
    targets = np.flatnonzero(wanted)
    length = max(int(view.body.sensor.range_m / lattice.cell_m), 1)
    piece, n_pieces = cut_into_pieces(targets, lattice.cols, length)
    order = np.argsort(piece, kind="stable")
    parts = [targets[order]]
    sizes = np.bincount(piece, minlength=n_pieces).tolist() if n_pieces else []
    looks_for = [-1] * n_pieces
    for cell, around in _pockets(view, wanted.reshape(belief.marks.shape), reach):
        parts.append(around)
        sizes.append(len(around))
        looks_for.append(cell)
    shape = (len(positions), len(sizes))
    tasks = Tasks(
        np.concatenate(parts),
        np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        np.array(looks_for, dtype=np.int64),
        np.full(shape, np.inf),
        np.full(shape, -1, dtype=np.int64),
    )
    if len(tasks):
        for robot, start in enumerate(positions.tolist()):
            distance = fields[robot] if robot in fields else _to_tasks(belief, start, tasks)
            of_robot = (tasks.costs[robot], tasks.nearest[robot])
            nearest_of_groups(distance, tasks.first, tasks.places, *of_robot)
    return tasks


def _reach(
    belief: Belief, positions: NDArray[np.int32]
) -> tuple[NDArray[np.bool_], dict[int, NDArray[np.float64]]]:
    """Which cells any robot can reach, and the fields of the robots that were asked for it."""
    reach = np.zeros(belief.moves.size, dtype=np.bool_)
    fields: dict[int, NDArray[np.float64]] = {}
    for robot, start in enumerate(positions.tolist()):
        # Whoever can be reached can reach the same.
        if not reach[start]:
            fields[robot] = distance_fields(belief, np.array([start]))[0]
            reach |= np.isfinite(fields[robot])
    return reach, fields


Views = dict[int, tuple[int, NDArray[np.int64]]]
"""Unknown fine cell -> changes in the map around it so far, and the places that may see it."""


def _pockets(
    view: TeamView, wanted: NDArray[np.bool_], reach: NDArray[np.bool_]
) -> list[tuple[int, NDArray[np.int64]]]:
    """An unknown fine cell of each pocket, and the places in reach that may see it."""
    belief = view.belief
    lattice = view.lattice
    sensor = view.body.sensor
    hidden = unknown_beside_frontier(belief)
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
            around = kept[1][reach[kept[1]]]
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
    if occlusion:
        count = visible_cells(cells, r, c, limits, lows, highs, out)
    else:
        count = disc_cells(cells, r, c, limits, out)
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
