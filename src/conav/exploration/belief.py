"""What a robot believes of the map, kept up to date scan by scan.

Beside the fine cells a belief keeps three layers that follow from them and cost little to keep
current, because a scan changes few cells:
- `frontier`: free fine cells with an unknown straight neighbour (Yamauchi 1997);
- `frontier_count`: how many of these lie in each planning cell, or, where the disc is larger than a
  cell, within the disc's reach of it;
- `marks`: per planning cell whether it is known to be standable (`OPEN`), was scanned from
  (`STOOD`), and has frontier but was not scanned from (`TARGET`; a sensor that looks twice from one
  place sees no more);
- `moves`: the moves between planning cells the robot knows it can make: the true ones whose swept
  disc holds no unknown cell centre.

Beside them it counts changes per block of cells, so that what was worked out from a part of the map
can be kept until that part changes.
"""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.clearance import capsule_is_known
from conav.geometry.directions import DCOL, DROW
from conav.geometry.ground import Ground
from conav.maps.occupancy_grid import FREE, UNKNOWN
from conav.maps.planning_grid import PlanningGrid

_LAYERS = ("_cells", "_frontier", "_count", "_marks", "_moves", "_changes")

BLOCK = 32
"""Fine cells along a side of a block in which changes are counted."""

OPEN = 1
"""Mark of a planning cell: known to be standable."""
STOOD = 2
"""Mark of a planning cell: a scan from here is held."""
TARGET = 4
"""Mark of a planning cell: frontier inside (or within the disc's reach), no scan from here."""


class Belief:
    """A mutable belief over a planning grid. Minds get it with all arrays locked.

    Robots that hold the same scans hold the same belief, so they may share one object; nothing of
    who shares with whom can be seen from inside.
    """

    __slots__ = (
        "_cells",
        "_changes",
        "_count",
        "_frontier",
        "_ground",
        "_ground_ways",
        "_marks",
        "_moves",
        "cells",
        "changes",
        "derived",
        "frontier",
        "frontier_count",
        "known",
        "marks",
        "moves",
        "opened",
        "scans",
        "ways",
    )

    def __init__(self, plan: PlanningGrid) -> None:
        fine = plan.walls.shape
        coarse = plan.moves.shape
        self._cells = np.full(fine, UNKNOWN, dtype=np.uint8)
        self._frontier = np.zeros(fine, dtype=np.uint8)
        self._count = np.zeros(coarse, dtype=_count_type(plan))
        self._marks = np.zeros(coarse, dtype=np.uint8)
        self._moves = np.zeros(coarse, dtype=np.uint8)
        blocks = ((fine[0] - 1) // BLOCK + 1, (fine[1] - 1) // BLOCK + 1)
        self._changes = np.zeros(blocks, dtype=np.int64)
        self.opened = 0  # planning cells known to be standable
        self.ways = 0  # moves known to be possible
        self.known = 0  # fine cells known
        self._lock()

    def _lock(self) -> None:
        self.cells = _locked(self._cells)  # (fine rows, fine cols) FREE, OCCUPIED or UNKNOWN
        self.frontier = _locked(self._frontier)  # (fine rows, fine cols) 0 or 1
        self.frontier_count = _locked(self._count)  # (rows, cols) frontier cells inside
        self.marks = _locked(self._marks)  # (rows, cols) OPEN, STOOD and TARGET added up
        self.moves = _locked(self._moves)  # (rows, cols) bit k: known move in direction k
        # (block rows, block cols) grows when a fine cell inside becomes known, or a planning cell
        # with its centre there becomes known to be standable or is scanned from.
        self.changes = _locked(self._changes)
        self._ground: Ground | None = None
        self._ground_ways = 0
        self.scans = 0  # heard by this object; nothing changes without
        # What was worked out from this belief and is kept beside it, by who did so; not part of its
        # content, and neither copied nor pickled.
        self.derived: dict[str, Any] = {}

    @property
    def ground(self) -> Ground:
        """The known moves as searches for path lengths want them; brought up to date here."""
        if self._ground is None:
            self._ground = Ground(self.moves.shape)
            self._ground_ways = 0
        if self._ground_ways != self.ways:
            self._ground.update(self._moves)
            self._ground_ways = self.ways
        return self._ground

    @property
    def stood(self) -> NDArray[np.uint8]:
        """1 for each planning cell from which a scan is held, shape (rows, cols); made anew."""
        return (self._marks & STOOD != 0).astype(np.uint8)

    def copy(self) -> "Belief":
        """An independent belief with the same content."""
        other = object.__new__(Belief)
        for name in _LAYERS:
            setattr(other, name, getattr(self, name).copy())
        other.opened, other.ways, other.known = self.opened, self.ways, self.known
        other._lock()
        other._ground = self._ground.copy() if self._ground is not None else None
        other._ground_ways = self._ground_ways
        return other

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        arrays = tuple(getattr(self, name) for name in _LAYERS)
        return (_restore, (arrays, self.opened, self.ways, self.known))

    def hear(
        self,
        plan: PlanningGrid,
        cell: int,
        seen: NDArray[np.int32],
        scratch: NDArray[np.int32],
    ) -> int:
        """The number of fine cells new to this belief in a scan made at planning cell `cell`.

        `seen` holds flat fine indices; `scratch` is `new_scratch(plan)`.
        """
        self.scans += 1
        lattice = plan.lattice
        row, col = divmod(cell, lattice.cols)
        self._changes[lattice.fine_row[row] // BLOCK, lattice.fine_col[col] // BLOCK] += 1
        marks = self._marks.reshape(-1)
        marks[cell] = int(marks[cell]) & OPEN | STOOD
        if len(seen) == 0:
            return 0
        fresh, opened, ways = _integrate(
            plan.walls,
            plan.moves,
            plan.standable,
            lattice.row_of,
            lattice.col_of,
            lattice.ratio,
            plan.radius_fine,
            self._cells,
            self._frontier,
            self._count,
            self._marks,
            self._moves,
            self._changes,
            seen,
            scratch,
        )
        self.known += fresh
        self.opened += opened
        self.ways += ways
        return fresh


def _restore(arrays: tuple[NDArray[np.uint8], ...], opened: int, ways: int, known: int) -> Belief:
    belief = object.__new__(Belief)
    for name, array in zip(_LAYERS, arrays, strict=True):
        setattr(belief, name, array)
    belief.opened, belief.ways, belief.known = opened, ways, known
    belief._lock()  # pyright: ignore[reportPrivateUsage]
    return belief


def _count_type(plan: PlanningGrid) -> Any:
    """The smallest type that holds the most frontier cells a planning cell can count."""
    ratio = plan.lattice.ratio
    across = (2 * frontier_reach.python(ratio, plan.radius_fine) + 1) * (int(ratio) + 2)
    return np.uint16 if across * across < 2**16 else np.uint32


T = TypeVar("T", bound=np.generic)


def _locked(array: NDArray[T]) -> NDArray[T]:
    view = array.view()
    view.flags.writeable = False
    return view


def new_scratch(plan: PlanningGrid) -> NDArray[np.int32]:
    """Working space for `Belief.hear`; may be shared by every belief over the same plan."""
    # Per planning cell a stamp and a place in the list of touched cells, and the stamp counter.
    return np.zeros(2 * plan.moves.size + 1, dtype=np.int32)


@kernel
def frontier_reach(ratio: float, radius: float) -> int:
    """How many planning cells around its own the disc at a planning cell's centre reaches into."""
    return int(np.ceil(max(0.0, radius - 0.5 * ratio) / ratio))


@kernel
def _is_frontier(cells: NDArray[np.uint8], r: int, c: int) -> bool:
    if cells[r, c] != FREE:
        return False
    rows, cols = cells.shape
    return (
        (c + 1 < cols and cells[r, c + 1] == UNKNOWN)
        or (c > 0 and cells[r, c - 1] == UNKNOWN)
        or (r + 1 < rows and cells[r + 1, c] == UNKNOWN)
        or (r > 0 and cells[r - 1, c] == UNKNOWN)
    )


@kernel
def _integrate(
    walls: NDArray[np.uint8],
    true_moves: NDArray[np.uint8],
    standable: NDArray[np.uint8],
    row_of: NDArray[np.int32],
    col_of: NDArray[np.int32],
    ratio: float,
    radius: float,
    cells: NDArray[np.uint8],
    frontier: NDArray[np.uint8],
    count: Any,  # (rows, cols) of an unsigned type wide enough
    marks: NDArray[np.uint8],
    moves: NDArray[np.uint8],
    changes: NDArray[np.int64],
    seen: NDArray[np.int32],
    scratch: NDArray[np.int32],
) -> tuple[int, int, int]:
    """How many fine cells became known, planning cells known to be standable, and moves known."""
    fine_rows, fine_cols = cells.shape
    rows, cols = moves.shape
    size = rows * cols
    stamp = scratch[2 * size] + 1
    scratch[2 * size] = stamp
    touched = 0
    fresh = 0
    reach = frontier_reach(ratio, radius)
    # Where planning cells are the fine cells and the disc stays inside one, the centre is all a
    # robot has to know of a cell, and both ends all it has to know of a move.
    bare = ratio == 1.0 and radius < 0.5
    # A fine cell matters to the ends of moves that pass its centre within the radius, or that lie
    # in it: this many planning cells around the one its centre is in.
    spread = 1 if bare else int(max(radius, 0.5) / ratio + 1.5)
    for i in range(seen.shape[0]):
        r = seen[i] // fine_cols
        c = seen[i] - r * fine_cols
        if cells[r, c] != UNKNOWN:
            continue
        cells[r, c] = walls[r, c]
        fresh += 1
        changes[r // BLOCK, c // BLOCK] += 1
        pr = row_of[r]
        pc = col_of[c]
        centre = pr * cols + pc
        # One stamp in the middle stands for the whole neighbourhood.
        if scratch[centre] != stamp:
            scratch[centre] = stamp
            scratch[size + touched] = centre
            touched += 1
    if fresh == 0:
        return 0, 0, 0
    for i in range(seen.shape[0]):
        r = seen[i] // fine_cols
        c = seen[i] - r * fine_cols
        for k in range(5):
            r2 = r + (DROW[k] if k < 4 else 0)
            c2 = c + (DCOL[k] if k < 4 else 0)
            if r2 < 0 or r2 >= fine_rows or c2 < 0 or c2 >= fine_cols:
                continue
            now = 1 if _is_frontier(cells, r2, c2) else 0
            if now != frontier[r2, c2]:
                frontier[r2, c2] = now
                pr = row_of[r2]
                pc = col_of[c2]
                for r3 in range(max(pr - reach, 0), min(pr + reach, rows - 1) + 1):
                    for c3 in range(max(pc - reach, 0), min(pc + reach, cols - 1) + 1):
                        if now == 1:
                            count[r3, c3] += 1
                        else:
                            count[r3, c3] -= 1
                        if count[r3, c3] > 0 and marks[r3, c3] & STOOD == 0:
                            marks[r3, c3] |= TARGET
                        else:
                            marks[r3, c3] &= OPEN | STOOD
    # Spread the touched planning cells to their neighbourhood, each once.
    direct = touched
    for i in range(direct):
        pr = scratch[size + i] // cols
        pc = scratch[size + i] % cols
        for r2 in range(max(pr - spread, 0), min(pr + spread, rows - 1) + 1):
            for c2 in range(max(pc - spread, 0), min(pc + spread, cols - 1) + 1):
                index = r2 * cols + c2
                if scratch[index] != stamp:
                    scratch[index] = stamp
                    scratch[size + touched] = index
                    touched += 1
    opened = 0
    ways = 0
    for i in range(touched):
        pr = scratch[size + i] // cols
        pc = scratch[size + i] % cols
        if standable[pr, pc] == 0 or marks[pr, pc] & OPEN:
            continue
        x = (pc + 0.5) * ratio
        y = (pr + 0.5) * ratio
        r = min(int(y), fine_rows - 1)
        c = min(int(x), fine_cols - 1)
        if cells[r, c] != UNKNOWN and (
            bare or capsule_is_known(cells, UNKNOWN, x, y, x, y, radius)
        ):
            marks[pr, pc] |= OPEN
            changes[r // BLOCK, c // BLOCK] += 1
            opened += 1
    for i in range(touched):
        pr = scratch[size + i] // cols
        pc = scratch[size + i] % cols
        if marks[pr, pc] & OPEN == 0:
            continue
        missing = true_moves[pr, pc] & ~moves[pr, pc]
        if missing == 0:
            continue
        # One of the two directions of each pair is enough: both ends of a move are touched.
        for k in (0, 1, 4, 5):
            if missing & (1 << k) == 0:
                continue
            r2 = pr + DROW[k]
            c2 = pc + DCOL[k]
            if k >= 4 and marks[r2, pc] & marks[pr, c2] & OPEN == 0:
                continue  # a diagonal is possible only where both its corner cells are standable
            if marks[r2, c2] & OPEN and (
                bare
                or capsule_is_known(
                    cells,
                    UNKNOWN,
                    (pc + 0.5) * ratio,
                    (pr + 0.5) * ratio,
                    (c2 + 0.5) * ratio,
                    (r2 + 0.5) * ratio,
                    radius,
                )
            ):
                moves[pr, pc] |= 1 << k
                moves[r2, c2] |= 1 << (k + 2)
                ways += 2
    return fresh, opened, ways
