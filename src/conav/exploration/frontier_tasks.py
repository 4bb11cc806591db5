"""Everything that is left to see as tasks: pieces of frontier, and pockets looked into from afar.

A piece of frontier is stood on. A pocket is unknown area whose frontier no robot can stand on or
beside: behind furniture, along walls, in gaps. Strategies usually leave pockets to the end, when a
robot has to come back for each; here they are tasks from the moment they are seen. The places from
which a pocket may be looked into are the cells that it can see, with everything unknown taken as
clear.
"""

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from conav.compiled import kernel
from conav.exploration.belief import OPEN, STOOD, TARGET, Belief
from conav.exploration.frontier_targets import cut_into_pieces
from conav.exploration.turn_sequences import sight_space
from conav.exploration.types import TeamView
from conav.exploration.viewpoints import unknown_beside_frontier
from conav.geometry.grid_search import search, search_space
from conav.geometry.sight import disc_cells, visible_cells

_EIGHT = np.ones((3, 3), dtype=np.int8)


@dataclass(frozen=True, eq=False)
class Tasks:
    """Tasks and the places from which each is done.

    Places of task j are `places[first[j]:first[j + 1]]`. `looks_for` is the unknown fine cell a
    pocket is about, -1 for a piece of frontier.
    """

    places: NDArray[np.int64]  # flat planning cells
    first: NDArray[np.int64]  # (n_tasks + 1,)
    looks_for: NDArray[np.int64]  # (n_tasks,)
    fields: NDArray[np.float64]  # (n_robots, planning cells) distance from each robot, inf

    def __len__(self) -> int:
        return len(self.looks_for)

    def costs(self, fields: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """The distance of each task's nearest place, (n_fields, n_tasks) [planning cells]."""
        if fields is None:
            fields = self.fields
        if len(self) == 0:
            return np.empty((len(fields), 0))
        return np.minimum.reduceat(fields[:, self.places], self.first[:-1], axis=1)

    def nearest_place(self, robot: int, task: int) -> int:
        """The place of a task that is nearest to a robot, the lower number first."""
        places = self.places[self.first[task] : self.first[task + 1]]
        return int(places[np.argmin(self.fields[robot, places])])


def distance_fields(belief: Belief, starts: NDArray[np.int64]) -> NDArray[np.float64]:
    """Path lengths [planning cells] from each start to every cell over known moves, inf if none."""
    size = belief.moves.size
    space = search_space(size)
    nowhere = np.zeros_like(belief.marks)
    fields = np.full((len(starts), size), np.inf)
    for start, field in zip(starts.tolist(), fields, strict=True):
        search(belief.moves, start, nowhere, 1, space)
        reached = np.flatnonzero(space.stamp[:-1] == space.stamp[-1])
        field[reached] = space.distance[reached]
    return fields


def find_tasks(view: TeamView, positions: NDArray[np.int32]) -> Tasks:
    """The tasks that robots at these planning cells can reach."""
    belief = view.belief
    lattice = view.lattice
    fields = distance_fields(belief, positions.astype(np.int64))
    reach = np.isfinite(fields).any(axis=0)
    wanted = ((belief.marks & TARGET).reshape(-1) != 0) & reach
    places = np.flatnonzero(wanted)
    length = max(int(view.body.sensor.range_m / lattice.cell_m), 1)
    grid = wanted.reshape(belief.marks.shape)
    piece, n_pieces = cut_into_pieces(grid, places, length)
    order = np.argsort(piece, kind="stable")
    parts = [places[order]]
    sizes = np.bincount(piece, minlength=n_pieces).tolist() if n_pieces else []
    looks_for = [-1] * n_pieces
    marks = belief.marks.reshape(-1)
    able = reach & (marks & OPEN != 0) & (marks & STOOD == 0)
    for cell, around in _pockets(view, grid, able):
        parts.append(around)
        sizes.append(len(around))
        looks_for.append(cell)
    first = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    return Tasks(np.concatenate(parts), first, np.array(looks_for, dtype=np.int64), fields)


def _pockets(
    view: TeamView, wanted: NDArray[np.bool_], able: NDArray[np.bool_]
) -> list[tuple[int, NDArray[np.int64]]]:
    """An unknown fine cell of each pocket, and the able planning cells that may see it."""
    belief = view.belief
    lattice = view.lattice
    hidden = unknown_beside_frontier(belief)
    if len(hidden) == 0:
        return []
    row, col = np.divmod(hidden, belief.cells.shape[1])
    near = _grown(wanted)
    alone = ~near[lattice.row_of[row], lattice.col_of[col]]
    hidden, row, col = hidden[alone], row[alone], col[alone]
    if len(hidden) == 0:
        return []
    top, left = row.min(), col.min()
    part = np.zeros((row.max() - top + 1, col.max() - left + 1), dtype=np.uint8)
    part[row - top, col - left] = 1
    clusters = np.asarray(cast("tuple[Any, int]", label(part, structure=_EIGHT))[0])
    cluster = clusters[row - top, col - left]
    space = sight_space(
        view.body.sensor.range_m,
        lattice.resolution,
        view.body.sensor.occlusion,
        belief.cells.shape,
    )
    flags = able.reshape(wanted.shape).astype(np.uint8)
    out = np.empty(belief.marks.size, dtype=np.int64)
    found: list[tuple[int, NDArray[np.int64]]] = []
    order = np.argsort(cluster, kind="stable")
    starts = np.flatnonzero(np.diff(cluster[order], prepend=-1))
    ends = np.append(starts[1:], len(order))
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        # One cell in the middle stands for the pocket, or another where that one is out of sight.
        for pick in (int((start + end) // 2), start, end - 1):
            cell = int(hidden[order[pick]])
            count = _places_that_see(
                belief.cells,
                cell,
                flags,
                lattice.row_of,
                lattice.col_of,
                lattice.fine_row,
                lattice.fine_col,
                0 if lattice.ratio >= 1 else int(0.5 / lattice.ratio) + 1,
                *space,
                out,
            )
            if count:
                found.append((cell, out[:count].copy()))
                break
    return found


def _grown(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The cells and their eight neighbours."""
    rows, cols = cells.shape
    inside = np.zeros((rows + 2, cols + 2), dtype=np.bool_)
    inside[1:-1, 1:-1] = cells
    grown = np.zeros((rows, cols), dtype=np.bool_)
    for down in range(3):
        for right in range(3):
            grown |= inside[down : down + rows, right : right + cols]
    return grown


@kernel
def _places_that_see(
    cells: NDArray[np.uint8],
    hidden: int,
    able: NDArray[np.uint8],
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
    """The number of able planning cells written to `places`, whose centres may see a cell."""
    fine_cols = cells.shape[1]
    rows, cols = able.shape
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
                if fine_row[pr] == r2 and fine_col[pc] == c2 and able[pr, pc] == 1:
                    places[found] = pr * cols + pc
                    found += 1
    return found
