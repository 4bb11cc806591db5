"""What robots see, for the verifier, written a second time on purpose.

As `verify_geometry` it shares nothing with the simulator but the definitions (docs/verify.md).
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.verify_geometry import WALL


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
    # Let "up" be the longer direction; the segment goes from (0, 0) to (x, y) with 0 <= x <= y.
    y = abs(dc) if flip else abs(dr)
    x = abs(dr) if flip else abs(dc)
    if y == 0:
        return True
    up = (1 if dc > 0 else -1) if flip else (1 if dr > 0 else -1)
    side = (1 if dr > 0 else -1) if flip else (1 if dc > 0 else -1)
    wall_left = False
    wall_right = False
    j = 0  # leftmost cell of the row that the segment may touch
    for k in range(y + 1):
        # Positions at the row's lower and upper border, times y: x times the doubled heights.
        first = x * max(2 * k - 1, 0)
        last = x * min(2 * k + 1, 2 * y)
        while (2 * j + 1) * y < first:
            j += 1
        i = j
        while (2 * i - 1) * y <= last:
            inside = x == 0 or (first < (2 * i + 1) * y and last > (2 * i - 1) * y)
            r = r1 + (side * i if flip else up * k)
            c = c1 + (up * k if flip else side * i)
            if 0 <= r < walls.shape[0] and 0 <= c < walls.shape[1] and walls[r, c] == WALL:
                end = (k == 0 and i == 0) or (k == y and i == x)
                if inside and not end:
                    return False
                if not inside:
                    # The segment leaves the row at this cell's left corner, or came in at its
                    # right one.
                    if last == (2 * i - 1) * y:
                        wall_right = True
                    else:
                        wall_left = True
                    if wall_left and wall_right:
                        return False
            i += 1
    return True


@kernel
def wall_seen(walls: NDArray[np.uint8], r1: int, c1: int, r2: int, c2: int) -> bool:
    """Whether some ray from the centre of (r1, c1) meets wall cell (r2, c2) before any other wall.

    In coordinates where the wall lies u columns on and v <= u rows up, each wall on the way shades
    the slopes between two of its corners. The wall is seen when the shades leave a gap in the
    slopes between its own corners.
    """
    dr = r2 - r1
    dc = c2 - c1
    if dr == 0 and dc == 0:
        return True
    sr = 1 if dr > 0 else -1
    sc = 1 if dc > 0 else -1
    # Rays come in through a side that faces the viewer, so one of those must be open.
    if (dr == 0 or (walls[r2 - sr, c2] == WALL and not (abs(dr) == 1 and dc == 0))) and (
        dc == 0 or (walls[r2, c2 - sc] == WALL and not (abs(dc) == 1 and dr == 0))
    ):
        return False
    flip = abs(dr) > abs(dc)
    u = abs(dr) if flip else abs(dc)
    v = abs(dc) if flip else abs(dr)
    lo = (v - 0.5) / (u + 0.5) if v > 0 else -0.5 / (u - 0.5)
    hi = (v + 0.5) / (u - 0.5)
    starts = np.empty(8 * (u + 1), dtype=np.float64)
    ends = np.empty(8 * (u + 1), dtype=np.float64)
    count = 0
    for i in range(u + 1):
        # Between these rows the slopes cross column i; one more on each side against rounding.
        bottom = lo * (i - 0.5) if i > 0 else 0.0
        first = max(int(np.floor(bottom + 0.5)) - 1, 0)
        last = min(int(np.floor(hi * (i + 0.5) + 0.5)) + 1, v)
        for j in range(first, last + 1):
            if (i == 0 and j == 0) or (i == u and j == v):
                continue
            r = r1 + (sr * i if flip else sr * j)
            c = c1 + (sc * j if flip else sc * i)
            if walls[r, c] != WALL:
                continue
            start = (j - 0.5) / (i + 0.5) if j > 0 else -0.5 / (i - 0.5)
            end = (j + 0.5) / (i - 0.5) if i > 0 else np.inf
            if end <= lo or start >= hi:
                continue
            if start <= lo and end >= hi:
                return False
            at = count
            while at > 0 and starts[at - 1] > start:
                starts[at] = starts[at - 1]
                ends[at] = ends[at - 1]
                at -= 1
            starts[at] = start
            ends[at] = end
            count += 1
    shaded = lo
    for k in range(count):
        if starts[k] > shaded:
            return True
        shaded = max(shaded, ends[k])
    return shaded < hi


@kernel
def look_around(
    walls: NDArray[np.uint8],
    known: NDArray[np.uint8],
    known_mark: int,
    claimed: NDArray[np.uint8],
    seen: NDArray[np.uint8],
    mark: int,
    wanted: NDArray[np.uint8],
    row: int,
    col: int,
    square: float,
    occlusion: bool,
) -> tuple[int, int]:
    """How many cells seen from (row, col) are neither known nor claimed, and how many wanted ones
    are seen for the first time.

    All arrays have the shape of the map; `known` has the bit `known_mark` where something is known,
    `claimed` is 1 where the robot says it sees something new. Cells seen get the bit `mark` in
    `seen`; cells that have it already were looked at before and are passed over.
    """
    rows, cols = walls.shape
    reach = min(int(np.sqrt(square)) + 1, max(rows, cols))
    missed = 0
    fresh = 0
    # Sight only ever goes away from the viewer, so a cell that no way of such steps through free
    # cells leads to is not seen and need not be asked about.
    led = np.zeros((2 * reach + 1, 2 * reach + 1), dtype=np.uint8)
    for quarter in range(4):
        up = 1 if quarter < 2 else -1
        side = 1 if quarter % 2 == 0 else -1
        # Each line that parts two quarters belongs to the first of them.
        for i in range(0 if up == 1 else 1, reach + 1):
            r = row + up * i
            if r < 0 or r >= rows:
                break
            for j in range(0 if side == 1 else 1, reach + 1):
                c = col + side * j
                if c < 0 or c >= cols or i * i + j * j > square:
                    break
                y = reach + up * i
                x = reach + side * j
                straight = (i > 0 and led[y - up, x] == 1) or (j > 0 and led[y, x - side] == 1)
                corner = i > 0 and j > 0 and led[y - up, x - side] == 1
                if occlusion and not (straight or corner or (i == 0 and j == 0)):
                    continue
                opaque = occlusion and walls[r, c] == WALL
                if not opaque:
                    led[y, x] = 1
                if seen[r, c] & mark:
                    continue
                if opaque:
                    if not straight or not wall_seen(walls, row, col, r, c):
                        continue
                elif occlusion and not free_cell_seen(walls, row, col, r, c):
                    continue
                seen[r, c] |= mark
                if known[r, c] & known_mark == 0 and claimed[r, c] == 0:
                    missed += 1
                if wanted[r, c] == 1:
                    fresh += 1
    return missed, fresh


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
