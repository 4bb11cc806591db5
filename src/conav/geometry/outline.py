"""The outline of a set of cells: its connected parts, and the rings around a part.

Corners of cells are at whole numbers: cell (row, col) covers col to col + 1 and row to row + 1.
Where two cells of the set share only a corner, `open_corners` says whether the set is connected
there.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

E, N, W, S = 0, 1, 2, 3
_DX = np.array([1, 0, -1, 0])
_DY = np.array([0, 1, 0, -1])


@kernel
def label_parts(mask: NDArray[np.uint8], open_corners: bool) -> NDArray[np.int32]:
    """The part of each cell of the mask, -1 outside, shape (rows, cols).

    Parts are numbered in the order of their first cells, row by row from the bottom.
    """
    rows, cols = mask.shape
    labels = np.full((rows, cols), -1, dtype=np.int32)
    stack = np.empty(rows * cols, dtype=np.int64)
    parts = 0
    for row in range(rows):
        for col in range(cols):
            if mask[row, col] == 0 or labels[row, col] >= 0:
                continue
            labels[row, col] = parts
            stack[0] = row * cols + col
            size = 1
            while size > 0:
                size -= 1
                r, c = stack[size] // cols, stack[size] % cols
                for dr in range(-1, 2):
                    for dc in range(-1, 2):
                        if dr * dc != 0 and not open_corners:
                            continue
                        r2, c2 = r + dr, c + dc
                        if r2 < 0 or c2 < 0 or r2 >= rows or c2 >= cols:
                            continue
                        if mask[r2, c2] != 0 and labels[r2, c2] < 0:
                            labels[r2, c2] = parts
                            stack[size] = r2 * cols + c2
                            size += 1
            parts += 1
    return labels


def trace_rings(
    mask: NDArray[np.uint8], open_corners: bool, cut: float
) -> list[NDArray[np.float64]]:
    """The rings around the mask's cells, the cells on the left: each (n, 2) of corners (x, y).

    A ring has a point only where it turns. For a mask of one part the one counter-clockwise ring is
    the outer one and comes first; the others are its holes. Rings never touch: where two cells
    share only a corner, a triangle with legs of `cut` is added to the set on either side (with
    `open_corners`) or taken away from both cells (without).
    """
    padded = np.zeros((mask.shape[0] + 2, mask.shape[1] + 2), dtype=np.uint8)
    padded[1:-1, 1:-1] = mask
    points, ends = _trace(padded, open_corners, cut)
    rings = np.split(points, ends[:-1])
    return sorted(rings, key=_area_sign, reverse=True)


def _area_sign(ring: NDArray[np.float64]) -> int:
    x, y = (ring - ring[0]).T
    return 1 if float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) > 0 else -1


@kernel
def _trace(
    padded: NDArray[np.uint8], open_corners: bool, cut: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """All points, and where each ring ends in them."""
    rows, cols = padded.shape
    walked = np.zeros((rows + 1, cols + 1), dtype=np.uint8)  # of edges east, by their start
    edges = 0
    for row in range(1, rows):
        for col in range(1, cols):
            edges += padded[row, col] != padded[row - 1, col]
            edges += padded[row, col] != padded[row, col - 1]
    points = np.empty((2 * edges, 2), dtype=np.float64)
    ends = np.empty(edges, dtype=np.int64)
    count, rings = 0, 0
    for row in range(1, rows):
        for col in range(1, cols):
            if walked[row, col] or not _is_edge(padded, col, row, E):
                continue
            # Scanned from the left, the first edge of a ring to be found begins at a turn.
            x, y, direction = col, row, E
            while True:
                if direction == E:
                    walked[y, x] = 1
                x, y = x + _DX[direction], y + _DY[direction]
                pinched = (
                    padded[y, x] == padded[y - 1, x - 1]
                    and padded[y - 1, x] == padded[y, x - 1]
                    and padded[y, x] != padded[y - 1, x]
                )
                turn = -1 if open_corners else 1  # where both turns are possible
                after = (direction + turn) % 4
                if not _is_edge(padded, x, y, after):
                    after = direction
                    if not _is_edge(padded, x, y, after):
                        after = (direction - turn) % 4
                if pinched:
                    points[count, 0] = x - 1 - cut * _DX[direction]
                    points[count, 1] = y - 1 - cut * _DY[direction]
                    points[count + 1, 0] = x - 1 + cut * _DX[after]
                    points[count + 1, 1] = y - 1 + cut * _DY[after]
                    count += 2
                elif after != direction:
                    points[count, 0] = x - 1
                    points[count, 1] = y - 1
                    count += 1
                direction = after
                if x == col and y == row and direction == E:
                    break
            ends[rings] = count
            rings += 1
    return points[:count], ends[:rings]


@kernel
def _is_edge(padded: NDArray[np.uint8], x: int, y: int, direction: int) -> bool:
    """Whether the set is on the left, and not on the right, of a step from corner (x, y)."""
    below, above, left, right = y - 1, y, x - 1, x
    if direction == E:
        return padded[above, right] != 0 and padded[below, right] == 0
    if direction == N:
        return padded[above, left] != 0 and padded[above, right] == 0
    if direction == W:
        return padded[below, left] != 0 and padded[above, left] == 0
    return padded[below, right] != 0 and padded[below, left] == 0
