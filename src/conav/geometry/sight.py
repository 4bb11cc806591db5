"""What is seen from a cell: exact shadow casting on a grid, and the open disc.

Definition of sight, the same in both directions. From the centre of cell v the centre of cell u is
seen when the straight segment between them does not run through the inside of an opaque cell and
does not graze opaque cells on both of its sides. Cells are full squares, so two opaque cells that
touch only at a corner close the gap between them: one-pixel walls never leak, whatever their
direction. An opaque cell is seen when some part of its boundary is.

The octants are swept row by row with the list of still open slopes. Slopes are quotients of odd
integers; a division of two such numbers is rounded the same way on every machine and two equal
quotients give equal floats, so comparisons are exact. Every visible cell is touched once or twice.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

OPAQUE = 1

# Per octant: the step of depth (row, col) and of the lateral direction (row, col).
_OCTANTS = (
    (1, 0, 0, 1),
    (1, 0, 0, -1),
    (-1, 0, 0, 1),
    (-1, 0, 0, -1),
    (0, 1, 1, 0),
    (0, 1, -1, 0),
    (0, -1, 1, 0),
    (0, -1, -1, 0),
)


def lateral_limits(range_cells: float) -> NDArray[np.int32]:
    """Per depth d the largest lateral offset c with d^2 + c^2 <= range^2, -1 beyond the range.

    Shape (floor(range) + 1,). Only + - * and comparisons, so equal on every machine.
    """
    square = range_cells * range_cells
    reach = int(range_cells)
    limits = np.full(reach + 1, -1, dtype=np.int32)
    c = reach
    for d in range(reach + 1):
        while c >= 0 and d * d + c * c > square:
            c -= 1
        limits[d] = c
    return limits


@kernel
def visible_cells(
    cells: NDArray[np.uint8],
    row: int,
    col: int,
    limits: NDArray[np.int32],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
) -> int:
    """The number of flat indices written to `out`: all cells seen from (row, col).

    `cells` (rows, cols) is opaque where it equals `OPAQUE`. `limits` from `lateral_limits`. `lows`
    and `highs` are working space from `new_gap_space`. A cell on the border of two octants may
    come twice; `out` must hold `sight_buffer_size(limits)` entries.
    """
    rows, cols = cells.shape
    flat = cells.reshape(-1)
    here = row * cols + col
    out[0] = here
    count = 1
    reach = limits.shape[0] - 1
    for octant in range(8):
        dr, dc, lr, lc = _OCTANTS[octant]
        # How far the map goes in the direction of depth and sideways.
        if dr == 1:
            depth_end = rows - 1 - row
        elif dr == -1:
            depth_end = row
        elif dc == 1:
            depth_end = cols - 1 - col
        else:
            depth_end = col
        if lr == 1:
            side_end = rows - 1 - row
        elif lr == -1:
            side_end = row
        elif lc == 1:
            side_end = cols - 1 - col
        else:
            side_end = col
        depth_end = min(depth_end, reach)
        depth_step = dr * cols + dc
        side_step = lr * cols + lc
        gaps = 1
        now = 0
        lows[0, 0] = 0.0
        highs[0, 0] = 1.0
        for d in range(1, depth_end + 1):
            limit = min(limits[d], side_end, d)
            base = here + d * depth_step
            following = 0
            near = d - 0.5
            far = d + 0.5
            for k in range(gaps):
                low = lows[now, k]
                high = highs[now, k]
                # One column more on the low side: rounding may only cost a needless look.
                first = max(int(low * near + 0.5) - 1, 0)
                last = min(int(high * far + 0.5), limit)
                # Centres seen lie in the columns from_c to to_c; c / d is compared exactly.
                from_c = int(low * d)
                while from_c / d < low:
                    from_c += 1
                to_c = int(high * d) + 1
                while to_c / d > high:
                    to_c -= 1
                index = base + (first - 1) * side_step
                for c in range(first, last + 1):
                    index += side_step
                    if flat[index] != OPAQUE:
                        if from_c <= c <= to_c:
                            out[count] = index
                            count += 1
                        continue
                    left = (c - 0.5) / far if c > 0 else -1.0
                    right = (c + 0.5) / near
                    if max(left, low) < min(right, high):
                        out[count] = index
                        count += 1
                        if left > low:
                            lows[1 - now, following] = low
                            highs[1 - now, following] = left
                            following += 1
                        low = right
                        if low >= high:
                            break
                        # No centre left of the wall's far edge is seen from here on.
                        from_c = c + 1
                        while from_c / d < low:
                            from_c += 1
                if low < high:
                    lows[1 - now, following] = low
                    highs[1 - now, following] = high
                    following += 1
            gaps = following
            now = 1 - now
            if gaps == 0:
                break
    return count


@kernel
def segment_is_clear(
    cells: NDArray[np.uint8], row: int, col: int, to_row: int, to_col: int
) -> bool:
    """Whether the segment between two cell centres is clear, by the definition above.

    Walks the cells the segment runs through, in integers; the two end cells do not count.
    """
    dr = to_row - row
    dc = to_col - col
    steep = abs(dr) > abs(dc)
    major = abs(dr) if steep else abs(dc)
    minor = abs(dc) if steep else abs(dr)
    major_row = (1 if dr > 0 else -1) if steep else 0
    major_col = 0 if steep else (1 if dc > 0 else -1)
    minor_row = 0 if steep else (1 if dr > 0 else -1)
    minor_col = (1 if dc > 0 else -1) if steep else 0
    left = False
    right = False
    y = 0
    for x in range(major):
        # Where the segment leaves column x, at x + 1/2, it is at height numerator / (2 major);
        # the border to the next cell up is at y + 1/2.
        numerator = minor * (2 * x + 1)
        border = (2 * y + 1) * major
        r = row + x * major_row + y * minor_row
        c = col + x * major_col + y * minor_col
        if numerator > border:
            y += 1
            r += minor_row
            c += minor_col
            if cells[r, c] == OPAQUE and not (r == to_row and c == to_col):
                return False
            r += major_row
            c += major_col
        elif numerator == border:
            # Exactly through a corner: it grazes the cell above and the cell ahead.
            if cells[r + minor_row, c + minor_col] == OPAQUE:
                left = True
            if cells[r + major_row, c + major_col] == OPAQUE:
                right = True
            if left and right:
                return False
            y += 1
            r += minor_row + major_row
            c += minor_col + major_col
        else:
            r += major_row
            c += major_col
        if cells[r, c] == OPAQUE and not (r == to_row and c == to_col):
            return False
    return True


@kernel
def disc_cells(
    cells: NDArray[np.uint8],
    row: int,
    col: int,
    limits: NDArray[np.int32],
    out: NDArray[np.int32],
) -> int:
    """The number of flat indices written to `out`: all cells of the disc, walls or not."""
    rows, cols = cells.shape
    reach = limits.shape[0] - 1
    count = 0
    for r in range(max(row - reach, 0), min(row + reach, rows - 1) + 1):
        limit = limits[abs(r - row)]
        for c in range(max(col - limit, 0), min(col + limit, cols - 1) + 1):
            out[count] = r * cols + c
            count += 1
    return count


@kernel
def cells_in_sight(
    cells: NDArray[np.uint8],
    row: int,
    col: int,
    occlusion: bool,
    limits: NDArray[np.int32],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
) -> int:
    """The number of flat indices written to `out`: `visible_cells`, or without occlusion the disc.

    A cell may come twice.
    """
    if occlusion:
        return visible_cells(cells, row, col, limits, lows, highs, out)
    return disc_cells(cells, row, col, limits, out)


def sight_buffer_size(limits: NDArray[np.int32]) -> int:
    """How many entries the output of one look can need at most, repeats included."""
    reach = limits.shape[0] - 1
    # The whole square of the disc, and every octant border a second time. An opaque cell can be
    # met once more per gap in its row, which the second copy of the disc covers.
    return 2 * (2 * reach + 1) ** 2 + 16


def new_gap_space(limits: NDArray[np.int32]) -> NDArray[np.float64]:
    """Working space for `visible_cells`: one of these as `lows`, one as `highs`."""
    # A row at depth d has d + 1 columns, so at most that many open intervals of slopes.
    return np.zeros((2, limits.shape[0] + 2), dtype=np.float64)
