"""Moves on a grid, marked with what searches for path lengths may leave out.

In the terms of jump point search [Harabor2011]: after a move into a cell its natural successors
are what lies straight on and, after a diagonal move, its two straight parts; a cell is marked for a
move when it has no forced ones beside them. `distance_field` says why that loses nothing.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW
from conav.geometry.sparse_cells import cells_that_differ


class Ground:
    """Moves, and for each cell what may be left out after each move that reaches it.

    `moves` (rows, cols) has bit k where the move in direction k is possible, and then so is the way
    back. `update` follows moves that are added in few cells; none may be taken away.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        size = shape[0] * shape[1]
        self.moves = np.zeros(shape, dtype=np.uint8)
        self.only = np.full(size, 255, dtype=np.uint8)  # as `_mark` says
        short = max(shape) < 2**15
        self.runs = np.full((4, size), -1, dtype=np.int16 if short else np.int32)  # as `_set_run`
        self._parent = np.arange(size, dtype=np.int32)  # towards the cell that stands for its part
        self._done = np.zeros(size, dtype=np.bool_)  # working space, all false between updates

    def copy(self) -> "Ground":
        """An independent ground with the same moves."""
        other = object.__new__(Ground)
        other.moves = self.moves.copy()
        other.only = self.only.copy()
        other.runs = self.runs.copy()
        other._parent = self._parent.copy()
        other._done = np.zeros_like(self._done)
        return other

    def update(self, moves: NDArray[np.uint8]) -> None:
        """Take over these moves."""
        _update(moves, self.moves, self.only, self.runs, self._parent, self._done)

    def reachable(self, cells: NDArray[np.int64], starts: NDArray[np.int64]) -> NDArray[np.int64]:
        """Those of some cells to which a path leads from one of the starts, in their order."""
        found = np.empty(len(cells), dtype=np.int64)
        return found[: _reachable(self._parent, cells, starts, found)]


@kernel
def _update(
    given: NDArray[np.uint8],
    moves: NDArray[np.uint8],
    only: NDArray[np.uint8],
    runs: Any,  # (4, rows * cols) of a signed type
    parent: NDArray[np.int32],
    done: NDArray[np.bool_],
) -> None:
    """Take the given moves over, and follow them with all that is kept beside them."""
    flat = moves.reshape(-1)
    new = given.reshape(-1)
    changed = np.empty(moves.size, dtype=np.int64)
    count = cells_that_differ(new, flat, changed)
    if count > 0:
        changed = changed[:count]
        for i in range(count):
            flat[changed[i]] = new[changed[i]]
        _mark(moves, changed, only, runs, done)
        _unite(moves, changed, parent)


@kernel
def _mark(
    moves: NDArray[np.uint8],
    changed: NDArray[np.int64],
    only: NDArray[np.uint8],
    runs: Any,  # (4, rows * cols) of a signed type
    done: NDArray[np.bool_],
) -> None:
    """Set bit k of `only` around changed cells: after a move k nothing but the natural follows.

    Natural is straight on, and after a diagonal move its two straight parts too. `runs` follow.
    `changed` is ascending; `done` is false everywhere, before and after.
    """
    rows, cols = moves.shape
    marked = np.empty(min(9 * changed.shape[0], only.shape[0]), dtype=np.int64)
    count = 0
    for i in range(changed.shape[0]):
        row = changed[i] // cols
        col = changed[i] % cols
        for r in range(max(row - 1, 0), min(row + 1, rows - 1) + 1):
            for c in range(max(col - 1, 0), min(col + 1, cols - 1) + 1):
                cell = r * cols + c
                if done[cell]:
                    continue
                done[cell] = True
                marked[count] = cell
                count += 1
                only[cell] = _marks_at(moves, r, c)
    flat = moves.reshape(-1)
    for i in range(count):
        done[marked[i]] = False
    # A run is made from that of the next cell, so those are set first that lead nowhere new: from
    # the last cell to the first for moves E and N. The other way round each cell would be set as
    # often as its run is long.
    for j in range(count):
        for k in range(4):
            cell = marked[count - 1 - j] if k < 2 else marked[j]
            _set_run(flat, only, runs[k], cell, k, DROW[k] * cols + DCOL[k])


@kernel
def _marks_at(moves: NDArray[np.uint8], r: int, c: int) -> int:
    """What `only` is to be at a cell."""
    rows, cols = moves.shape
    if 0 < r < rows - 1 and 0 < c < cols - 1:
        common = np.uint8(255)
        for r2 in range(r - 1, r + 2):
            for c2 in range(c - 1, c + 2):
                common &= moves[r2, c2]
        if common == 255:
            return 255  # in the open every other cell around is reached without this one
    here = moves[r, c]
    marks = 0
    for k in range(8):
        # Moves come and go, so where none leads back none led here.
        if here & (1 << (k ^ 2)) == 0:
            marks |= 1 << k
            continue
        if k < 4:
            left = _side_is_clear(moves, r, c, k, (k + 1) % 4, 4 + k, 4 + (k + 1) % 4)
            right = _side_is_clear(moves, r, c, k, (k + 3) % 4, 4 + (k + 3) % 4, 4 + (k + 2) % 4)
            clear = left and right
        else:
            clear = _diagonal_is_clear(moves, r, c, k)
        if clear:
            marks |= 1 << k
    return marks


@kernel
def _set_run(
    flat: NDArray[np.uint8], only: NDArray[np.uint8], run: Any, cell: int, k: int, step: int
) -> None:
    """Set how many cells a straight run k has from a cell that it reached, and those behind it.

    A run goes on where nothing but straight on follows, and counts its last cell. Where it ends at
    a cell that has other successors it is above 0, below where there is nothing beyond.
    """
    bit = 1 << k
    back = 1 << (k ^ 2)
    while True:
        if only[cell] & bit == 0:
            now = 1
        elif flat[cell] & bit == 0:
            now = -1
        else:
            beyond = run[cell + step]
            now = beyond + 1 if beyond > 0 else beyond - 1
        if run[cell] == now:
            break
        run[cell] = now
        if flat[cell] & back == 0:
            break
        cell -= step


@kernel
def _unite(moves: NDArray[np.uint8], changed: NDArray[np.int64], parent: NDArray[np.int32]) -> None:
    """Join the parts of cells that got moves with those the moves lead to."""
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    for i in range(changed.shape[0]):
        one = _root(parent, changed[i])
        for k in range(8):
            if flat[changed[i]] & (1 << k):
                other = _root(parent, changed[i] + DROW[k] * cols + DCOL[k])
                if other < one:
                    parent[one] = other
                    one = other
                else:
                    parent[other] = one


@kernel
def _root(parent: NDArray[np.int32], cell: int) -> int:
    """The cell that stands for a cell's part, the lowest; ways to it get shorter."""
    while parent[cell] != cell:
        parent[cell] = parent[parent[cell]]
        cell = parent[cell]
    return cell


@kernel
def _reachable(
    parent: NDArray[np.int32],
    cells: NDArray[np.int64],
    starts: NDArray[np.int64],
    found: NDArray[np.int64],
) -> int:
    """The number of cells written to `found`: those in the part of a start."""
    parts = np.empty(starts.shape[0], dtype=np.int64)
    count = 0
    for i in range(starts.shape[0]):
        part = _root(parent, starts[i])
        if not _is_among(part, parts, count):
            parts[count] = part
            count += 1
    written = 0
    for i in range(cells.shape[0]):
        if _is_among(_root(parent, cells[i]), parts, count):
            found[written] = cells[i]
            written += 1
    return written


@kernel
def _is_among(part: int, parts: NDArray[np.int64], count: int) -> bool:
    among = False
    for i in range(count):
        among |= parts[i] == part
    return among


@kernel
def _side_is_clear(
    moves: NDArray[np.uint8], r: int, c: int, k: int, side: int, fore: int, back: int
) -> bool:
    """Whether what lies to one side of a cell reached by a straight move k may be left out.

    `side` is the direction of that side, `fore` and `back` are the diagonals to both sides of it.
    """
    here = moves[r, c]
    r0 = r - DROW[k]
    c0 = c - DCOL[k]
    before = moves[r0, c0]
    if (
        here & (1 << side)
        and not before & (1 << fore)
        # Along the row is preferred as the last move: first aside, then along.
        and not (
            k % 2 == 0
            and before & (1 << side)
            and moves[r0 + DROW[side], c0 + DCOL[side]] & (1 << k)
        )
    ):
        return False
    if here & (1 << fore):
        r1 = r + DROW[side]
        c1 = c + DCOL[side]
        if not (before & (1 << fore) and moves[r1, c1] & (1 << k)):
            return False
    return not (here & (1 << back) and not before & (1 << side))


@kernel
def _diagonal_is_clear(moves: NDArray[np.uint8], r: int, c: int, k: int) -> bool:
    """Whether all but the natural may be left out at a cell reached by a diagonal move k."""
    one = k - 4
    other = (one + 1) % 4
    against_one = (one + 2) % 4
    against_other = (other + 2) % 4
    here = moves[r, c]
    before = moves[r - DROW[k], c - DCOL[k]]
    if here & (1 << against_one) and not before & (1 << other):
        return False
    if here & (1 << against_other) and not before & (1 << one):
        return False
    # The diagonals to both sides: around the cells beside.
    if here & (1 << (4 + other)) and not (
        before & (1 << other) and moves[r + DROW[against_one], c + DCOL[against_one]] & (1 << other)
    ):
        return False
    return not (
        here & (1 << (4 + against_other))
        and not (
            before & (1 << one)
            and moves[r + DROW[against_other], c + DCOL[against_other]] & (1 << one)
        )
    )
