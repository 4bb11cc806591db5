"""Where a disc fits among the cells of a fine grid, and along which straight moves.

Everything is measured in fine cells ("pixels"): pixel (r, c) is the square from (c, r) to
(c + 1, r + 1) in (x, y). A disc of radius `radius` touches a pixel when the distance from its
centre to the square is smaller than the radius, by more than `SLACK`: a disc that just fits between
two walls fits, whatever the rounding of lengths such as 0.1 m says.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW

FREE = 0
SLACK = 1e-9  # on squared distances [fine cells^2]


@kernel
def point_segment_square(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    """The squared distance from a point to the segment from a to b."""
    dx = bx - ax
    dy = by - ay
    length = dx * dx + dy * dy
    t = 0.0
    if length > 0.0:
        t = ((px - ax) * dx + (py - ay) * dy) / length
        t = min(max(t, 0.0), 1.0)
    ex = ax + t * dx - px
    ey = ay + t * dy - py
    return ex * ex + ey * ey


@kernel
def _box_segment_square(
    left: float, low: float, ax: float, ay: float, bx: float, by: float
) -> float:
    """The squared distance from the unit square at (left, low) to the segment from a to b."""
    # Clip the segment against the square; if something is left they meet.
    t0 = 0.0
    t1 = 1.0
    inside = True
    for axis in range(2):
        p = ax if axis == 0 else ay
        d = (bx - ax) if axis == 0 else (by - ay)
        lo = left if axis == 0 else low
        if d == 0.0:
            if p < lo or p > lo + 1.0:
                inside = False
        else:
            u = (lo - p) / d
            v = (lo + 1.0 - p) / d
            if u > v:
                u, v = v, u
            t0 = max(t0, u)
            t1 = min(t1, v)
    if inside and t0 <= t1:
        return 0.0
    best = np.inf
    for x, y in ((ax, ay), (bx, by)):
        ex = max(left - x, 0.0, x - left - 1.0)
        ey = max(low - y, 0.0, y - low - 1.0)
        best = min(best, ex * ex + ey * ey)
    for corner in range(4):
        x = left + (corner & 1)
        y = low + (corner >> 1)
        best = min(best, point_segment_square(x, y, ax, ay, bx, by))
    return best


@kernel
def capsule_is_free(
    cells: NDArray[np.uint8], ax: float, ay: float, bx: float, by: float, radius: float
) -> bool:
    """Whether a disc swept from a to b touches only free pixels and stays inside the grid."""
    rows, cols = cells.shape
    if min(ax, bx) - radius < -SLACK or max(ax, bx) + radius > cols + SLACK:
        return False
    if min(ay, by) - radius < -SLACK or max(ay, by) + radius > rows + SLACK:
        return False
    square = radius * radius - SLACK
    for r in range(max(int(min(ay, by) - radius), 0), min(int(max(ay, by) + radius), rows - 1) + 1):
        for c in range(
            max(int(min(ax, bx) - radius), 0), min(int(max(ax, bx) + radius), cols - 1) + 1
        ):
            if (
                cells[r, c] != FREE
                and _box_segment_square(float(c), float(r), ax, ay, bx, by) < square
            ):
                return False
    return True


@kernel
def free_moves(
    cells: NDArray[np.uint8], rows: int, cols: int, ratio: float, radius: float
) -> NDArray[np.uint8]:
    """Per planning cell the moves a disc can make, shape (rows, cols, 2) of bytes.

    Planning cell (r, c) has its centre at ((c + 0.5) * ratio, (r + 0.5) * ratio) pixels. Layer 0 is
    1 where the disc fits at the centre, layer 1 has bit k set where it also fits along the whole
    straight move in direction k and at its end. A diagonal needs the two straight detours' corner
    cells to fit as well, so no corner is cut.
    """
    result = np.zeros((rows, cols, 2), dtype=np.uint8)
    for r in range(rows):
        for c in range(cols):
            x = (c + 0.5) * ratio
            y = (r + 0.5) * ratio
            if capsule_is_free(cells, x, y, x, y, radius):
                result[r, c, 0] = 1
    for r in range(rows):
        for c in range(cols):
            if result[r, c, 0] == 0:
                continue
            for k in (0, 1, 4, 5):
                r2 = r + DROW[k]
                c2 = c + DCOL[k]
                if r2 < 0 or r2 >= rows or c2 < 0 or c2 >= cols or result[r2, c2, 0] == 0:
                    continue
                if k >= 4 and (result[r2, c, 0] == 0 or result[r, c2, 0] == 0):
                    continue
                if capsule_is_free(
                    cells,
                    (c + 0.5) * ratio,
                    (r + 0.5) * ratio,
                    (c2 + 0.5) * ratio,
                    (r2 + 0.5) * ratio,
                    radius,
                ):
                    result[r, c, 1] |= 1 << k
                    # Opposites: E-W, N-S, NE-SW, NW-SE are two apart in their group of four.
                    result[r2, c2, 1] |= 1 << (k + 2)
    return result


@kernel
def capsule_is_known(
    belief: NDArray[np.uint8],
    unknown: int,
    ax: float,
    ay: float,
    bx: float,
    by: float,
    radius: float,
) -> bool:
    """Whether no pixel whose centre the swept disc covers is unknown.

    Pixel centres, not whole pixels: the line of sight from one end to such a centre stays inside
    the swept disc, so a robot at that end can always see what it must know.
    """
    rows, cols = belief.shape
    square = radius * radius + SLACK
    for r in range(max(int(min(ay, by) - radius), 0), min(int(max(ay, by) + radius), rows - 1) + 1):
        for c in range(
            max(int(min(ax, bx) - radius), 0), min(int(max(ax, bx) + radius), cols - 1) + 1
        ):
            if (
                belief[r, c] == unknown
                and point_segment_square(c + 0.5, r + 0.5, ax, ay, bx, by) <= square
            ):
                return False
    return True


@kernel
def components(moves: NDArray[np.uint8], standable: NDArray[np.uint8]) -> NDArray[np.int32]:
    """A component label per planning cell, -1 where the robot cannot stand.

    Labels count from 0 in the order of the components' first cells.
    """
    rows, cols = moves.shape
    labels = np.full((rows, cols), -1, dtype=np.int32)
    queue = np.empty(rows * cols, dtype=np.int32)
    label = 0
    for start in range(rows * cols):
        r0 = start // cols
        c0 = start % cols
        if standable[r0, c0] == 0 or labels[r0, c0] >= 0:
            continue
        labels[r0, c0] = label
        queue[0] = start
        head = 0
        tail = 1
        while head < tail:
            r = queue[head] // cols
            c = queue[head] % cols
            head += 1
            for k in range(8):
                if moves[r, c] & (1 << k):
                    r2 = r + DROW[k]
                    c2 = c + DCOL[k]
                    if labels[r2, c2] < 0:
                        labels[r2, c2] = label
                        queue[tail] = r2 * cols + c2
                        tail += 1
        label += 1
    return labels
