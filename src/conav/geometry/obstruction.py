"""How much of a straight line runs through walls, exactly."""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel


@kernel
def obstructed(
    walls: NDArray[np.uint8], row: int, col: int, to_row: int, to_col: int
) -> tuple[int, int]:
    """The part of the segment between two cells' centres inside cells that are not 0: a fraction.

    Returns numerator and denominator, both whole numbers, so that it is equal on every machine and
    in both directions. A segment through a corner touches two of the four cells in a point only.
    """
    height = abs(to_row - row)
    width = abs(to_col - col)
    if height == 0 and width == 0:
        return 0, 1
    down = 1 if to_row > row else -1
    right = 1 if to_col > col else -1
    # The segment enters its k-th row and column at (2 k + 1) / (2 height) and / (2 width) of the
    # way; counted in parts of 2 height width, or of 2 length where it is straight.
    tall = max(height, 1)
    wide = max(width, 1)
    whole = 2 * tall * wide
    r = row
    c = col
    next_row = wide if height > 0 else whole + 1
    next_col = tall if width > 0 else whole + 1
    at = 0
    inside = 0
    while at < whole:
        after = min(next_row, next_col, whole)
        if walls[r, c] != 0:
            inside += after - at
        at = after
        if at == whole:
            break
        if next_row == at:
            r += down
            next_row += 2 * wide
        if next_col == at:
            c += right
            next_col += 2 * tall
    return inside, whole
