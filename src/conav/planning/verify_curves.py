"""Curves for the verifier, written a second time on purpose: least distances between enclosures.

A motion over a time of half-length h around its middle is a straight one, give or take A h^2 / 2
with A a bound on the acceleration. The least distance of the straight one is known in closed form,
so less that amount it is a lower bound; the distance at one time is an upper bound. Times are
halved where the bounds leave a doubt. For straight motions A is 0 and nothing is halved.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

SHARP = 1e-7
"""[m] between the bounds on a least distance, where it matters."""

_STACK = 256
_SHORTEST = 1e-12  # [s] never halved below


@kernel
def place_at(piece: NDArray[np.float64], t: float) -> tuple[float, float]:
    """Where a piece is at a time."""
    s = t - piece[0]
    turn = piece[8]
    if turn == 0.0:
        return (
            piece[2] + piece[4] * s + piece[6] * s * s / 2.0,
            piece[3] + piece[5] * s + piece[7] * s * s / 2.0,
        )
    # About the centre of its circle, a quarter to the left of the velocity.
    cx = piece[2] - piece[5] / turn
    cy = piece[3] + piece[4] / turn
    ux = piece[2] - cx
    uy = piece[3] - cy
    c = np.cos(turn * s)
    d = np.sin(turn * s)
    return cx + c * ux - d * uy, cy + d * ux + c * uy


@kernel
def velocity_at(piece: NDArray[np.float64], t: float) -> tuple[float, float]:
    """How fast a piece is at a time."""
    s = t - piece[0]
    c = np.cos(piece[8] * s)
    d = np.sin(piece[8] * s)
    return (
        c * piece[4] - d * piece[5] + piece[6] * s,
        d * piece[4] + c * piece[5] + piece[7] * s,
    )


@kernel
def bending(piece: NDArray[np.float64]) -> float:
    """The norm of a piece's acceleration."""
    return np.hypot(piece[6], piece[7]) + abs(piece[8]) * np.hypot(piece[4], piece[5])


@kernel
def relative_bending(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """A bound on the acceleration of one piece as seen from another."""
    if a[8] == 0.0 and b[8] == 0.0:
        return np.hypot(a[6] - b[6], a[7] - b[7])
    return bending(a) + bending(b)


@kernel
def nearest_as_straight(
    a: NDArray[np.float64], b: NDArray[np.float64], begin: float, end: float
) -> tuple[float, float, float]:
    """The least distance of two pieces if both kept their velocity of the middle of two times.

    Also the time of it, and how far apart they are then.
    """
    h = (end - begin) / 2.0
    t = begin + h
    ax, ay = place_at(a, t)
    bx, by = place_at(b, t)
    avx, avy = velocity_at(a, t)
    bvx, bvy = velocity_at(b, t)
    x = bx - ax
    y = by - ay
    vx = bvx - avx
    vy = bvy - avy
    square = vx * vx + vy * vy
    s = 0.0
    if square > 0.0:
        s = min(max(-(x * vx + y * vy) / square, -h), h)
    ax, ay = place_at(a, t + s)
    bx, by = place_at(b, t + s)
    return np.hypot(x + vx * s, y + vy * s), t + s, np.hypot(bx - ax, by - ay)


@kernel
def least_apart(
    a: NDArray[np.float64], b: NDArray[np.float64], begin: float, end: float, enough: float
) -> tuple[float, float, float]:
    """Bounds on the least distance of two pieces between two times, and a time of the upper one.

    Distances from `enough` on are of no interest: both bounds may then be any number above it.
    """
    curved = relative_bending(a, b)
    if curved == 0.0:
        bound, when, found = nearest_as_straight(a, b, begin, end)
        return min(bound, found), found, min(max(when, begin), end)
    starts = np.empty(_STACK)
    ends = np.empty(_STACK)
    starts[0] = begin
    ends[0] = end
    height = 1
    low = np.inf
    high = np.inf
    when = begin
    while height > 0:
        height -= 1
        t0 = starts[height]
        t1 = ends[height]
        h = (t1 - t0) / 2.0
        bound, at, found = nearest_as_straight(a, b, t0, t1)
        bound -= curved * h * h / 2.0
        if found < high:
            high = found
            when = at
        if bound >= min(high - SHARP, enough) or h < _SHORTEST or height + 2 > _STACK:
            low = min(low, bound)
            continue
        starts[height] = t0
        ends[height] = t0 + h
        starts[height + 1] = t0 + h
        ends[height + 1] = t1
        height += 2
    # Rounding alone can put the lower bound above the upper, or the time outside.
    return min(low, high), high, min(max(when, begin), end)


@kernel
def point_to_segment(x: float, y: float, ax: float, ay: float, bx: float, by: float) -> float:
    """The distance from a point to a segment."""
    dx = bx - ax
    dy = by - ay
    square = dx * dx + dy * dy
    s = 0.0
    if square > 0.0:
        s = min(max(((x - ax) * dx + (y - ay) * dy) / square, 0.0), 1.0)
    return np.hypot(x - ax - s * dx, y - ay - s * dy)


@kernel
def segment_to_segment(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float
) -> float:
    """The distance between two segments, 0 where they cross."""
    c = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    d = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
    a = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
    b = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
    if c * d < 0.0 and a * b < 0.0:
        return 0.0
    return min(
        min(point_to_segment(ax, ay, cx, cy, dx, dy), point_to_segment(bx, by, cx, cy, dx, dy)),
        min(point_to_segment(cx, cy, ax, ay, bx, by), point_to_segment(dx, dy, ax, ay, bx, by)),
    )


@kernel
def least_from_segment(
    piece: NDArray[np.float64], wall: NDArray[np.float64], enough: float
) -> tuple[float, float, float]:
    """As `least_apart`, from a piece, all of it, to a segment x0, y0, x1, y1."""
    curved = bending(piece)
    starts = np.empty(_STACK)
    ends = np.empty(_STACK)
    starts[0] = piece[0]
    ends[0] = piece[1]
    height = 1
    low = np.inf
    high = np.inf
    when = piece[0]
    while height > 0:
        height -= 1
        t0 = starts[height]
        t1 = ends[height]
        h = (t1 - t0) / 2.0
        t = t0 + h
        x, y = place_at(piece, t)
        vx, vy = velocity_at(piece, t)
        bound = segment_to_segment(
            x - h * vx, y - h * vy, x + h * vx, y + h * vy, wall[0], wall[1], wall[2], wall[3]
        )
        bound -= curved * h * h / 2.0
        for k in range(3):
            at = t0 if k == 0 else (t if k == 1 else t1)
            x, y = place_at(piece, at)
            found = point_to_segment(x, y, wall[0], wall[1], wall[2], wall[3])
            if found < high:
                high = found
                when = at
        if bound >= min(high - SHARP, enough) or h < _SHORTEST or height + 2 > _STACK:
            low = min(low, bound)
            continue
        starts[height] = t0
        ends[height] = t
        starts[height + 1] = t
        ends[height + 1] = t1
        height += 2
    return min(low, high), high, when
