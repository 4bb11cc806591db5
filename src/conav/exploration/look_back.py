"""From where unknown cells may be seen, kept for as long as nothing changes that matters.

Sight is the same in both directions, so these are the planning cells that the unknown cell sees if
everything unknown is clear. As cells are only ever found to be walls, it sees less and less. So
what was found holds until a wall comes up beside the line to a place, a place is scanned from, or a
planning cell that the unknown cell saw turns out to be standable. Each of these counts as a change
in the block of the map it lies in, and blocks are what is watched.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.belief import BLOCK, OPEN, STOOD
from conav.exploration.types import TeamView
from conav.geometry.sight import cells_in_sight
from conav.geometry.sight_space import sight_space


class _View(NamedTuple):
    """What an unknown cell sees."""

    places: NDArray[np.int64]  # planning cells known to be standable and not scanned from
    blocks: NDArray[np.int64]  # flat, that matter
    changes: int  # in these when it was found


class Views:
    """The views of a belief's unknown cells with one sensor; those asked for can be kept."""

    def __init__(self, view: TeamView) -> None:
        sensor = view.body.sensor
        self._belief = view.belief
        self._lattice = view.lattice
        self._space = sight_space(
            sensor.range_m, view.lattice.resolution, sensor.occlusion, view.belief.cells.shape
        )
        self._changes = view.belief.changes.reshape(-1)
        self._key = f"views {sensor.range_m!r} {sensor.occlusion}"
        self._before: dict[int, _View] = view.belief.derived.get(self._key, {})
        self._after: dict[int, _View] = {}

    def places(self, cell: int) -> NDArray[np.int64]:
        """The planning cells known to be standable, not scanned from, that may see an unknown cell.

        `cell` is a flat map cell.
        """
        seen = self._before.get(cell)
        if seen is None or _sum_of(self._changes, seen.blocks) != seen.changes:
            seen = self._look_back(cell)
        self._after[cell] = seen
        return seen.places

    def keep(self) -> None:
        """Keep what was asked for with the belief, instead of what was kept before."""
        self._belief.derived[self._key] = self._after

    def _look_back(self, cell: int) -> _View:
        belief = self._belief
        lattice = self._lattice
        out = np.empty(belief.marks.size, dtype=np.int64)
        matters = np.zeros(belief.changes.shape, dtype=np.bool_)
        count = _places_that_see(
            belief.cells,
            cell,
            belief.marks,
            lattice.row_of,
            lattice.col_of,
            lattice.fine_row,
            lattice.fine_col,
            0 if lattice.ratio >= 1 else int(0.5 / lattice.ratio) + 1,
            *self._space,
            matters,
            out,
        )
        blocks = np.flatnonzero(matters)
        return _View(out[:count].copy(), blocks, _sum_of(self._changes, blocks))


@kernel
def _sum_of(changes: NDArray[np.int64], blocks: NDArray[np.int64]) -> int:
    """How much has changed so far in some blocks."""
    total = 0
    for i in range(blocks.shape[0]):
        total += int(changes[blocks[i]])
    return total


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
    matters: NDArray[np.bool_],
    places: NDArray[np.int64],
) -> int:
    """The number of open planning cells not stood on, written to `places`, that may see a cell.

    `matters` gets the blocks in which a change may change them.
    """
    fine_cols = cells.shape[1]
    rows, cols = marks.shape
    r = hidden // fine_cols
    c = hidden % fine_cols
    count = cells_in_sight(cells, r, c, occlusion, limits, lows, highs, out)
    # Mark the map cells in reach that hold the centre of a planning cell not stood on: few of those
    # in sight, where planning cells are large.
    reach = limits.shape[0] - 1
    stamp = stamps[stamps.shape[0] - 1] + 1
    stamps[stamps.shape[0] - 1] = stamp + 1
    bottom = max(row_of[max(r - reach, 0)] - spread, 0)
    top = min(row_of[min(r + reach, cells.shape[0] - 1)] + spread, rows - 1)
    left = max(col_of[max(c - reach, 0)] - spread, 0)
    right = min(col_of[min(c + reach, fine_cols - 1)] + spread, cols - 1)
    for pr in range(bottom, top + 1):
        for pc in range(left, right + 1):
            if marks[pr, pc] & STOOD == 0:
                stamps[fine_row[pr] * fine_cols + fine_col[pc]] = stamp
    found = 0
    for i in range(count):
        if stamps[out[i]] != stamp:
            continue
        stamps[out[i]] = stamp + 1  # it may come twice
        r2 = out[i] // fine_cols
        c2 = out[i] - r2 * fine_cols
        matters[r2 // BLOCK, c2 // BLOCK] = True
        before = found
        for pr in range(max(row_of[r2] - spread, 0), min(row_of[r2] + spread, rows - 1) + 1):
            for pc in range(max(col_of[c2] - spread, 0), min(col_of[c2] + spread, cols - 1) + 1):
                if (
                    fine_row[pr] == r2
                    and fine_col[pc] == c2
                    and marks[pr, pc] & (OPEN | STOOD) == OPEN
                ):
                    places[found] = pr * cols + pc
                    found += 1
        if found > before and occlusion:
            _mark_line(r, c, r2, c2, matters)
    return found


@kernel
def _mark_line(r: int, c: int, r2: int, c2: int, matters: NDArray[np.bool_]) -> None:
    """Mark the blocks within a map cell of the segment between two cells, and some more."""
    parts = max(abs(r2 - r), abs(c2 - c)) // (BLOCK // 2) + 1
    for i in range(parts):
        # From one end of a part to the other, and the cells around both.
        low = r + (r2 - r) * i // parts
        high = r + (r2 - r) * (i + 1) // parts
        near = c + (c2 - c) * i // parts
        far = c + (c2 - c) * (i + 1) // parts
        for row in range(
            max(min(low, high) - 2, 0) // BLOCK,
            min((max(low, high) + 2) // BLOCK, matters.shape[0] - 1) + 1,
        ):
            for col in range(
                max(min(near, far) - 2, 0) // BLOCK,
                min((max(near, far) + 2) // BLOCK, matters.shape[1] - 1) + 1,
            ):
                matters[row, col] = True
