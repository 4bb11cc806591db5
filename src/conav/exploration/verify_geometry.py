"""Geometry for the verifier, written a second time on purpose.

Nothing here is shared with the simulator: walls, clearance and sight are derived anew, by other
means, from the same definitions (docs/verify.md), so that a mistake in one shows up as a
disagreement.
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
def free_cell_seen(walls: NDArray[np.uint8], r1: int, c1: int, r2: int, c2: int) -> bool:
    """Whether the centre of free cell (r2, c2) is seen from the centre of (r1, c1).

    Goes through the rows (or columns) the segment crosses, in coordinates where a cell has side 2
    and the viewer's centre is the origin, and asks which cells of each it runs through. A grazed
    corner counts against the side the wall is on; walls on both sides block.
    """
    dr = r2 - r1
    dc = c2 - c1
    flip = abs(dc) > abs(dr)
    # Let "up" be the longer direction; the segment goes from (0, 0) to (x, y) with y >= |x|.
    y = abs(dc) if flip else abs(dr)
    x = (dr if flip else dc) * 1
    sign = (1 if dc > 0 else -1) if flip else (1 if dr > 0 else -1)
    wall_left = False
    wall_right = False
    for k in range(y + 1):
        low = max(2 * k - 1, 0)  # doubled heights between which this row lies
        high = min(2 * k + 1, 2 * y)
        # Doubled positions x * low / y and x * high / y, kept over the common denominator y.
        first = x * low
        last = x * high
        if first > last:
            first, last = last, first
        # Cells j of this row whose inside (2 j - 1, 2 j + 1) meets the open stretch.
        j0 = (first + y) // (2 * y) - 1
        j1 = (last + y) // (2 * y) + 1
        for j in range(j0, j1 + 1):
            inside = first < (2 * j + 1) * y and last > (2 * j - 1) * y
            if x == 0:
                inside = j == 0
            touches_right = last == (2 * j - 1) * y and x != 0
            touches_left = first == (2 * j + 1) * y and x != 0
            if not (inside or touches_left or touches_right):
                continue
            r = r1 + (j if flip else sign * k)
            c = c1 + (sign * k if flip else j)
            if (r == r1 and c == c1) or (r == r2 and c == c2):
                continue
            if r < 0 or c < 0 or r >= walls.shape[0] or c >= walls.shape[1]:
                continue
            if walls[r, c] != WALL:
                continue
            if inside:
                return False
            if touches_right:
                wall_right = True
            else:
                wall_left = True
            if wall_left and wall_right:
                return False
    return True


@kernel
def wall_seen(walls: NDArray[np.uint8], r1: int, c1: int, r2: int, c2: int) -> bool:
    """Whether some ray from the centre of (r1, c1) meets wall cell (r2, c2) before any other wall.

    Which wall a ray meets first changes only at directions through corners of walls, so one ray
    between each two such directions decides.
    """
    dr = r2 - r1
    dc = c2 - c1
    flip = abs(dr) > abs(dc)
    u = abs(dr) if flip else abs(dc)
    v = abs(dc) if flip else abs(dr)
    if u == 0:
        return True
    su = (1 if dr > 0 else -1) if flip else (1 if dc > 0 else -1)
    sv = (1 if dc >= 0 else -1) if flip else (1 if dr >= 0 else -1)
    if v == 0:
        lo = -0.5 / (u - 0.5)
        hi = 0.5 / (u - 0.5)
    else:
        lo = (v - 0.5) / (u + 0.5)
        hi = (v + 0.5) / (u - 0.5)
    slopes = np.empty(4 * (u + 1) * (v + 4) + 2, dtype=np.float64)
    count = 2
    slopes[0] = lo
    slopes[1] = hi
    for i in range(u + 1):
        for j in range(-1, v + 2):
            r = r1 + (su * i if flip else sv * j)
            c = c1 + (sv * j if flip else su * i)
            if r < 0 or c < 0 or r >= walls.shape[0] or c >= walls.shape[1]:
                continue
            if walls[r, c] != WALL:
                continue
            for corner in range(4):
                x = i + (corner & 1) - 0.5
                y = j + (corner >> 1) - 0.5
                if x > 0.0 and lo < y / x < hi:
                    slopes[count] = y / x
                    count += 1
    used = np.sort(slopes[:count])
    for k in range(count - 1):
        if used[k + 1] - used[k] < 1e-12:
            continue
        slope = 0.5 * (used[k] + used[k + 1])
        met = False
        for i in range(u + 1):
            y0 = slope * max(i - 0.5, 0.0)
            y1 = slope * (i + 0.5)
            step = 1 if y1 >= y0 else -1
            j = int(np.floor(y0 + 0.5))
            end = int(np.floor(y1 + 0.5))
            while not met:
                r = r1 + (su * i if flip else sv * j)
                c = c1 + (sv * j if flip else su * i)
                if r < 0 or c < 0 or r >= walls.shape[0] or c >= walls.shape[1]:
                    met = True
                elif walls[r, c] == WALL and not (i == 0 and j == 0):
                    if r == r2 and c == c2:
                        return True
                    met = True
                if j == end:
                    break
                j += step
            if met:
                break
    return False


@kernel
def false_claims(
    walls: NDArray[np.uint8],
    cells: NDArray[np.int64],
    row: int,
    col: int,
    square: float,
    occlusion: bool,
) -> int:
    """How many of these fine cells cannot be seen from (row, col)."""
    cols = walls.shape[1]
    wrong = 0
    for i in range(cells.shape[0]):
        r = cells[i] // cols
        c = cells[i] % cols
        if (r - row) * (r - row) + (c - col) * (c - col) > square:
            wrong += 1
        elif occlusion:
            seen = (
                wall_seen(walls, row, col, r, c)
                if walls[r, c] == WALL
                else free_cell_seen(walls, row, col, r, c)
            )
            if not seen:
                wrong += 1
    return wrong


@kernel
def missed_cells(
    walls: NDArray[np.uint8],
    known: NDArray[np.uint8],
    row: int,
    col: int,
    square: float,
    occlusion: bool,
) -> int:
    """How many free fine cells seen from (row, col) are not known."""
    rows, cols = walls.shape
    reach = int(np.sqrt(square)) + 1
    missed = 0
    for r in range(max(0, row - reach), min(rows, row + reach + 1)):
        for c in range(max(0, col - reach), min(cols, col + reach + 1)):
            if (
                known[r, c] == 0
                and walls[r, c] != WALL
                and (r - row) * (r - row) + (c - col) * (c - col) <= square
                and (not occlusion or free_cell_seen(walls, row, col, r, c))
            ):
                missed += 1
    return missed


@kernel
def unknown_in_sweep(
    known: NDArray[np.uint8], ratio: float, radius: float, r1: int, c1: int, r2: int, c2: int
) -> int:
    """How many fine cells with their centre under the swept disc are not known."""
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
            if known[r, c] == 1:
                continue
            px = c + 0.5 - ax
            py = r + 0.5 - ay
            along = 0.0 if length == 0.0 else min(max((px * dx + py * dy) / length, 0.0), 1.0)
            ex = px - along * dx
            ey = py - along * dy
            if ex * ex + ey * ey < radius * radius - 1e-9:
                count += 1
    return count


@kernel
def nearest_places(walls: NDArray[np.uint8], places: NDArray[np.uint8]) -> NDArray[np.int64]:
    """For each free fine cell the nearest place by steps through free cells, or -1.

    Rings of breadth-first search from all places at once, places in row order; a cell takes over
    the place of the first cell that reaches it, straight neighbours (E, N, W, S) before diagonal
    ones (NE, NW, SW, SE); a diagonal step between two walls does not exist.
    """
    rows, cols = walls.shape
    owner = np.full((rows, cols), -1, dtype=np.int64)
    ring = np.flatnonzero(places)
    for i in range(ring.shape[0]):
        owner[ring[i] // cols, ring[i] % cols] = ring[i]
    while ring.shape[0] > 0:
        following = np.empty(8 * ring.shape[0], dtype=np.int64)
        count = 0
        for i in range(ring.shape[0]):
            r = ring[i] // cols
            c = ring[i] % cols
            for k in range(8):
                # E, N, W, S, then NE, NW, SW, SE
                dr = 0
                dc = 0
                if k < 4:
                    dr = 1 if k == 1 else (-1 if k == 3 else 0)
                    dc = 1 if k == 0 else (-1 if k == 2 else 0)
                else:
                    dr = 1 if k < 6 else -1
                    dc = 1 if k in (4, 7) else -1
                r2 = r + dr
                c2 = c + dc
                if r2 < 0 or c2 < 0 or r2 >= rows or c2 >= cols:
                    continue
                if walls[r2, c2] == WALL or owner[r2, c2] >= 0:
                    continue
                if k >= 4 and walls[r, c2] == WALL and walls[r2, c] == WALL:
                    continue
                owner[r2, c2] = owner[r, c]
                following[count] = r2 * cols + c2
                count += 1
        ring = following[:count].copy()
    return owner


@kernel
def observable_from_nearest(
    walls: NDArray[np.uint8], owner: NDArray[np.int64], square: float
) -> NDArray[np.uint8]:
    """1 for each free fine cell seen from its nearest place within the range."""
    rows, cols = walls.shape
    result = np.zeros((rows, cols), dtype=np.uint8)
    for r in range(rows):
        for c in range(cols):
            if owner[r, c] >= 0:
                r2 = owner[r, c] // cols
                c2 = owner[r, c] % cols
                if (r - r2) * (r - r2) + (c - c2) * (c - c2) <= square and free_cell_seen(
                    walls, r2, c2, r, c
                ):
                    result[r, c] = 1
    return result


@kernel
def add_free_view(
    walls: NDArray[np.uint8],
    seen: NDArray[np.uint8],
    row: int,
    col: int,
    square: float,
    occlusion: bool,
) -> int:
    """The number of free cells in view of (row, col) that were not in `seen`; adds them."""
    rows, cols = walls.shape
    reach = int(np.sqrt(square)) + 1
    added = 0
    for r in range(max(0, row - reach), min(rows, row + reach + 1)):
        for c in range(max(0, col - reach), min(cols, col + reach + 1)):
            if (
                seen[r, c] == 0
                and walls[r, c] != WALL
                and (r - row) * (r - row) + (c - col) * (c - col) <= square
                and (not occlusion or free_cell_seen(walls, row, col, r, c))
            ):
                seen[r, c] = 1
                added += 1
    return added


@kernel
def within_range(
    walls: NDArray[np.uint8], places: NDArray[np.uint8], square: float
) -> NDArray[np.uint8]:
    """1 for each free fine cell within the range of some place, walls or not.

    Per row the distance to the nearest place in that row, then the best row within reach.
    """
    rows, cols = walls.shape
    far = rows + cols + 1
    aside = np.full((rows, cols), far, dtype=np.int64)
    for r in range(rows):
        for c in range(cols):
            if places[r, c] == 1:
                aside[r, c] = 0
            elif c > 0:
                aside[r, c] = min(aside[r, c - 1] + 1, far)
        for c in range(cols - 2, -1, -1):
            aside[r, c] = min(aside[r, c], aside[r, c + 1] + 1)
    reach = int(np.sqrt(square)) + 1
    result = np.zeros((rows, cols), dtype=np.uint8)
    for r in range(rows):
        for c in range(cols):
            if walls[r, c] == WALL:
                continue
            for r2 in range(max(0, r - reach), min(rows, r + reach + 1)):
                if aside[r2, c] ** 2 + (r - r2) ** 2 <= square:
                    result[r, c] = 1
                    break
    return result
