"""Cutting convex corners off rings: a simplification under which walls only ever grow.

Where the floor turns left round a corner v between a and b, the wall may take the triangle a v b.
That keeps all rings simple and apart when no other corner lies in the triangle, because an edge
that crossed a b would have to end in it.

Let every point between two neighbours a and b that was cut so far lie right of the line a b (or on
it) and within h of it. From any point of the floor that was lost there, the ray to the right, at a
right angle to a b, leaves the lost part through the old wall, at most h away. So no point farther
than h from the walls is ever lost.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

# Over twice the bound of [Shewchuk1997] on the error of an orientation, relative to its products.
_TURN_ERROR = 4 * float(np.finfo(np.float64).eps)
_STEPS = 4  # small cuts first: the tolerance is reached by halving steps from tolerance / 8


@kernel
def cut_corners(
    points: NDArray[np.float64], ring_starts: NDArray[np.int64], tolerance: float
) -> NDArray[np.bool_]:
    """Which points stay, shape (n,), so that no point farther than `tolerance` from walls is lost.

    `points` (n, 2) and `ring_starts` (rings + 1,) are rings with the floor on the left, as in
    `PolygonMap`. Corners are cut in order, small cuts first; where a rounding error could decide,
    the corner stays.
    """
    n = points.shape[0]
    before, after = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    left_in = np.empty(n, dtype=np.int64)  # points left in the ring, kept at its first point
    first = np.empty(n, dtype=np.int64)
    for ring in range(ring_starts.shape[0] - 1):
        start, end = ring_starts[ring], ring_starts[ring + 1]
        for i in range(start, end):
            before[i], after[i], first[i] = i - 1, i + 1, start
        before[start], after[end - 1] = end - 1, start
        left_in[start] = end - start
    following = after.copy()
    kept = np.ones(n, dtype=np.bool_)
    bins, bin_start, low, size, across, up = _bins(points)
    for step in range(_STEPS):
        limit = tolerance / 2.0 ** (_STEPS - 1 - step)
        again = True
        while again:
            again = False
            for v in range(n):
                if not kept[v] or left_in[first[v]] <= 3:
                    continue
                a, b = before[v], after[v]
                if _turn(points, a, v, b) != 1:
                    continue
                if not _within(points, following, a, b, limit):
                    continue
                if not _empty(points, kept, a, v, b, bins, bin_start, low, size, across, up):
                    continue
                kept[v] = False
                after[a], before[b] = b, a
                left_in[first[v]] -= 1
                again = True
    return kept


@kernel
def _turn(points: NDArray[np.float64], a: int, b: int, c: int) -> int:
    """The sign of (b - a) x (c - a), or 0 where rounding leaves it open."""
    left = (points[a, 0] - points[c, 0]) * (points[b, 1] - points[c, 1])
    right = (points[a, 1] - points[c, 1]) * (points[b, 0] - points[c, 0])
    value = left - right
    limit = _TURN_ERROR * (abs(left) + abs(right)) + 1e-290
    if value > limit:
        return 1
    return -1 if value < -limit else 0


@kernel
def _within(
    points: NDArray[np.float64], following: NDArray[np.int64], a: int, b: int, limit: float
) -> bool:
    """Whether all old points between a and b are within `limit` of the line and not left of it."""
    dx, dy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    farthest = limit * limit * (dx * dx + dy * dy)
    i = following[a]
    while i != b:
        if _turn(points, a, b, int(i)) > 0:
            return False
        across = dx * (points[i, 1] - points[a, 1]) - dy * (points[i, 0] - points[a, 0])
        if across * across > farthest:
            return False
        i = following[i]
    return True


@kernel
def _empty(
    points: NDArray[np.float64],
    kept: NDArray[np.bool_],
    a: int,
    v: int,
    b: int,
    bins: NDArray[np.int64],
    bin_start: NDArray[np.int64],
    low: NDArray[np.float64],
    size: float,
    across: int,
    up: int,
) -> bool:
    """Whether no other kept point lies in the triangle a v b or on its border."""
    x0 = min(points[a, 0], points[v, 0], points[b, 0])
    x1 = max(points[a, 0], points[v, 0], points[b, 0])
    y0 = min(points[a, 1], points[v, 1], points[b, 1])
    y1 = max(points[a, 1], points[v, 1], points[b, 1])
    for j in range(int((y0 - low[1]) / size), min(int((y1 - low[1]) / size), up - 1) + 1):
        for i in range(int((x0 - low[0]) / size), min(int((x1 - low[0]) / size), across - 1) + 1):
            for at in range(bin_start[j * across + i], bin_start[j * across + i + 1]):
                p = bins[at]
                if not kept[p] or p in (a, v, b):
                    continue
                if (
                    _turn(points, a, v, p) >= 0
                    and _turn(points, v, b, p) >= 0
                    and _turn(points, b, a, p) >= 0
                ):
                    return False
    return True


@kernel
def _bins(
    points: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], float, int, int]:
    """The points sorted into square bins, about one a bin: order, starts, and where bins lie."""
    n = points.shape[0]
    low, high = points[0].copy(), points[0].copy()
    for i in range(n):
        for k in range(2):
            low[k] = min(low[k], points[i, k])
            high[k] = max(high[k], points[i, k])
    longer = max(high[0] - low[0], high[1] - low[1])
    size = max(np.sqrt((high[0] - low[0]) * (high[1] - low[1]) / n), longer / n)
    across = int((high[0] - low[0]) / size) + 1
    up = int((high[1] - low[1]) / size) + 1
    starts = np.zeros(across * up + 1, dtype=np.int64)
    of_point = np.empty(n, dtype=np.int64)
    for i in range(n):
        col = int((points[i, 0] - low[0]) / size)
        row = int((points[i, 1] - low[1]) / size)
        of_point[i] = row * across + col
        starts[of_point[i] + 1] += 1
    for k in range(across * up):
        starts[k + 1] += starts[k]
    order = np.empty(n, dtype=np.int64)
    filled = starts[:-1].copy()
    for i in range(n):
        order[filled[of_point[i]]] = i
        filled[of_point[i]] += 1
    return order, starts, low, size, across, up
