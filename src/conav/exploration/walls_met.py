"""How many walls there are in what a robot knows, for the ground there is.

Counts are kept by blocks of the map with the belief, and made anew where something has changed
in a block or beside it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.belief import BLOCK, Belief
from conav.maps.occupancy_grid import FREE, OCCUPIED


class _Counts(NamedTuple):
    """By blocks as in `Belief.changes`."""

    changes: NDArray[np.int64]  # when it was counted
    free: NDArray[np.int64]  # free cells
    walls: NDArray[np.int64]  # cells of wall beside a free one


def walls_met(belief: Belief, range_fine: float) -> float:
    """How many cells of wall a robot meets for every cell it drives, in what is known.

    The walls beside known free cells over those free cells, times the width a robot sees. A
    corridor narrower than that has 2 and more, an open field far less.
    """
    kept: _Counts | None = belief.derived.get("walls met")
    if kept is None:
        shape = belief.changes.shape
        kept = _Counts(np.full(shape, -1), np.zeros(shape, np.int64), np.zeros(shape, np.int64))
        belief.derived["walls met"] = kept
    _recount(belief.cells, belief.changes, *kept)
    return int(kept.walls.sum()) / max(int(kept.free.sum()), 1) * 2.0 * range_fine


@kernel
def _recount(
    cells: NDArray[np.uint8],
    changes: NDArray[np.int64],
    before: NDArray[np.int64],
    free: NDArray[np.int64],
    walls: NDArray[np.int64],
) -> None:
    """Count anew where changes are not as before, and in the blocks beside."""
    rows, cols = cells.shape
    down, across = changes.shape
    stale = np.zeros(changes.shape, dtype=np.bool_)
    for i in range(down):
        for j in range(across):
            if changes[i, j] != before[i, j]:
                before[i, j] = changes[i, j]
                stale[max(i - 1, 0) : i + 2, j] = True
                stale[i, max(j - 1, 0) : j + 2] = True
    for i in range(down):
        for j in range(across):
            if not stale[i, j]:
                continue
            free[i, j] = 0
            walls[i, j] = 0
            for r in range(i * BLOCK, min((i + 1) * BLOCK, rows)):
                for c in range(j * BLOCK, min((j + 1) * BLOCK, cols)):
                    if cells[r, c] == FREE:
                        free[i, j] += 1
                    elif cells[r, c] == OCCUPIED and (
                        (r > 0 and cells[r - 1, c] == FREE)
                        or (r + 1 < rows and cells[r + 1, c] == FREE)
                        or (c > 0 and cells[r, c - 1] == FREE)
                        or (c + 1 < cols and cells[r, c + 1] == FREE)
                    ):
                        walls[i, j] += 1
