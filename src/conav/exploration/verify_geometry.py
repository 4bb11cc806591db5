"""Where robots fit, for the verifier, written a second time on purpose.

Nothing here is shared with the simulator: clearance and ways are derived anew, by other means, from
the same definitions (docs/verify.md), so that a mistake in one shows up as a disagreement.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

WALL = 1


@kernel
def box_gap(t: float, ax: float, ay: float, bx: float, by: float, left: float, low: float) -> float:
    """Squared distance from the point at parameter t of the segment a-b to a unit square."""
    x = ax + t * (bx - ax)
    y = ay + t * (by - ay)
    gx = max(left - x, x - (left + 1.0), 0.0)
    gy = max(low - y, y - (low + 1.0), 0.0)
    return gx * gx + gy * gy


@kernel
def sweep_gap(ax: float, ay: float, bx: float, by: float, left: float, low: float) -> float:
    """Squared distance between the segment a-b and the unit square at (left, low).

    The distance along the segment is convex and made of pieces that change where the segment passes
    a side's line; its least value lies at an end, at such a place, or at the foot of a corner.
    """
    dx = bx - ax
    dy = by - ay
    best = min(box_gap(0.0, ax, ay, bx, by, left, low), box_gap(1.0, ax, ay, bx, by, left, low))
    length = dx * dx + dy * dy
    if length == 0.0:
        return best
    for side in range(2):
        if dx != 0.0:
            t = (left + side - ax) / dx
            if 0.0 < t < 1.0:
                best = min(best, box_gap(t, ax, ay, bx, by, left, low))
        if dy != 0.0:
            t = (low + side - ay) / dy
            if 0.0 < t < 1.0:
                best = min(best, box_gap(t, ax, ay, bx, by, left, low))
        for other in range(2):
            t = ((left + side - ax) * dx + (low + other - ay) * dy) / length
            if 0.0 < t < 1.0:
                best = min(best, box_gap(t, ax, ay, bx, by, left, low))
    return best


@kernel
def sweep_fits(
    walls: NDArray[np.uint8], ratio: float, radius: float, r1: int, c1: int, r2: int, c2: int
) -> bool:
    """Whether a disc drives from planning cell (r1, c1) to (r2, c2) clear of walls and map borders.

    `radius` in fine cells; planning cell (r, c) has its centre at ((c + 0.5), (r + 0.5)) * ratio.
    """
    rows, cols = walls.shape
    ax = (c1 + 0.5) * ratio
    ay = (r1 + 0.5) * ratio
    bx = (c2 + 0.5) * ratio
    by = (r2 + 0.5) * ratio
    slack = 1e-9
    if (
        min(ax, bx) < radius - slack
        or min(ay, by) < radius - slack
        or max(ax, bx) > cols - radius + slack
        or max(ay, by) > rows - radius + slack
    ):
        return False
    for r in range(max(0, int(min(ay, by) - radius) - 1), min(rows, int(max(ay, by) + radius) + 2)):
        for c in range(
            max(0, int(min(ax, bx) - radius) - 1), min(cols, int(max(ax, bx) + radius) + 2)
        ):
            if walls[r, c] == WALL and (
                sweep_gap(ax, ay, bx, by, float(c), float(r)) < radius * radius - slack
            ):
                return False
    return True


@kernel
def reachable_cells(
    walls: NDArray[np.uint8],
    rows: int,
    cols: int,
    ratio: float,
    radius: float,
    diagonal: bool,
    starts: NDArray[np.int64],
) -> NDArray[np.uint8]:
    """1 for each planning cell robots can drive to from the starts, shape (rows, cols)."""
    reached = np.zeros((rows, cols), dtype=np.uint8)
    stack = np.empty(rows * cols, dtype=np.int64)
    height = 0
    for i in range(starts.shape[0]):
        if reached[starts[i] // cols, starts[i] % cols] == 0:
            reached[starts[i] // cols, starts[i] % cols] = 1
            stack[height] = starts[i]
            height += 1
    while height > 0:
        height -= 1
        r = stack[height] // cols
        c = stack[height] % cols
        for r2 in range(max(r - 1, 0), min(r + 2, rows)):
            for c2 in range(max(c - 1, 0), min(c + 2, cols)):
                if reached[r2, c2] == 1 or not move_fits(
                    walls, ratio, radius, diagonal, r, c, r2, c2
                ):
                    continue
                reached[r2, c2] = 1
                stack[height] = r2 * cols + c2
                height += 1
    return reached


@kernel
def move_fits(
    walls: NDArray[np.uint8],
    ratio: float,
    radius: float,
    diagonal: bool,
    r1: int,
    c1: int,
    r2: int,
    c2: int,
) -> bool:
    """Whether a robot may move between two neighbouring planning cells (or stay where it is)."""
    if abs(r1 - r2) > 1 or abs(c1 - c2) > 1:
        return False
    if r1 != r2 and c1 != c2:
        if not diagonal:
            return False
        # No corner is cut: the robot also fits where it would turn the corner at right angles.
        if not sweep_fits(walls, ratio, radius, r1, c2, r1, c2):
            return False
        if not sweep_fits(walls, ratio, radius, r2, c1, r2, c1):
            return False
    if not sweep_fits(walls, ratio, radius, r2, c2, r2, c2):
        return False
    return sweep_fits(walls, ratio, radius, r1, c1, r2, c2)


@kernel
def unknown_in_sweep(
    known: NDArray[np.uint8],
    mark: int,
    ratio: float,
    radius: float,
    r1: int,
    c1: int,
    r2: int,
    c2: int,
) -> int:
    """How many fine cells with their centre under the swept disc lack the bit `mark` in `known`."""
    rows, cols = known.shape
    ax = (c1 + 0.5) * ratio
    ay = (r1 + 0.5) * ratio
    dx = (c2 - c1) * ratio
    dy = (r2 - r1) * ratio
    length = dx * dx + dy * dy
    count = 0
    for r in range(max(0, int(ay + min(dy, 0.0) - radius) - 1), rows):
        if r > ay + max(dy, 0.0) + radius:
            break
        for c in range(max(0, int(ax + min(dx, 0.0) - radius) - 1), cols):
            if c > ax + max(dx, 0.0) + radius:
                break
            if known[r, c] & mark:
                continue
            px = c + 0.5 - ax
            py = r + 0.5 - ay
            along = 0.0 if length == 0.0 else min(max((px * dx + py * dy) / length, 0.0), 1.0)
            ex = px - along * dx
            ey = py - along * dy
            if ex * ex + ey * ey < radius * radius - 1e-9:
                count += 1
    return count
