"""How many walls there are in what a robot knows, for the ground there is.

What was counted is kept with the belief, so only cells that have become known since are looked at.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.belief import Belief
from conav.geometry.directions import DCOL, DROW
from conav.geometry.sparse_cells import cells_that_differ
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN


class _Counted(NamedTuple):
    """What was counted of a belief."""

    cells: NDArray[np.uint8]  # (fine rows, fine cols) as they were
    walls: NDArray[np.bool_]  # (fine rows, fine cols) walls that count
    total: NDArray[np.int64]  # free cells, and walls


def walls_met(belief: Belief, range_fine: float) -> float:
    """How many cells of wall a robot meets for every cell it drives, in what is known.

    The walls beside known free cells over those free cells, times the width a robot sees. A
    corridor narrower than that has 2 and more, an open field far less.
    """
    counted: _Counted | None = belief.derived.get("walls met")
    if counted is None:
        shape = belief.cells.shape
        cells = np.full(shape, UNKNOWN, dtype=np.uint8)
        counted = _Counted(cells, np.zeros(shape, dtype=np.bool_), np.zeros(2, dtype=np.int64))
        belief.derived["walls met"] = counted
    _count(belief.cells, *counted)
    free, walls = counted.total.tolist()
    return walls / max(free, 1) * 2.0 * range_fine


@kernel
def _count(
    cells: NDArray[np.uint8],
    before: NDArray[np.uint8],
    counts: NDArray[np.bool_],
    total: NDArray[np.int64],
) -> None:
    """Count what is known now and was not before."""
    rows, cols = cells.shape
    fresh = np.empty(cells.size, dtype=np.int64)
    fresh = fresh[: cells_that_differ(cells.reshape(-1), before.reshape(-1), fresh)]
    for cell in fresh:
        row = cell // cols
        col = cell - row * cols
        before[row, col] = cells[row, col]
        total[0] += cells[row, col] == FREE
        # A free cell makes walls beside it count, and a wall may do so itself.
        for k in range(5):
            r = row + (DROW[k] if k < 4 else 0)
            c = col + (DCOL[k] if k < 4 else 0)
            if (
                0 <= r < rows
                and 0 <= c < cols
                and cells[r, c] == OCCUPIED
                and not counts[r, c]
                and (
                    (r > 0 and cells[r - 1, c] == FREE)
                    or (r + 1 < rows and cells[r + 1, c] == FREE)
                    or (c > 0 and cells[r, c - 1] == FREE)
                    or (c + 1 < cols and cells[r, c + 1] == FREE)
                )
            ):
                counts[r, c] = True
                total[1] += 1
