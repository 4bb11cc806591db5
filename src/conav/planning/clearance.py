"""Whether a piece of a motion keeps its distance: from walls, from obstacles, from other pieces.

Straight pieces are compared in closed form, with `>=`: touching is allowed. Others by conservative
advancement: let d be the vector from the nearest point of what is to be kept away from, n its
direction, b the speed along n and A a bound on the (relative) acceleration. What is kept away from
is convex and stays on the other side of the line through its nearest point across n, so after a
time h the distance is at least |d| + b h - A h^2 / 2, and it is safe to go on by the h at which
that comes down to the distance asked for. Nothing that overlaps is ever accepted. What comes nearer
than `TOUCH` over it is refused, so curves that only just touch are; every step is then longer than
a fixed time, and the loop ends.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.piece import bend, state_on_piece

TOUCH = 1e-6
"""[m] curves have to stay farther away than straight motions by that much."""


@kernel
def piece_clear_of_segment(
    piece: NDArray[np.float64], ax: float, ay: float, bx: float, by: float, distance: float
) -> bool:
    """Whether a piece stays at least `distance` [m] from a segment, or a point where a is b."""
    bound = bend(piece)
    if bound == 0.0:
        duration = piece[1] - piece[0]
        return _segments_apart(
            piece[2],
            piece[3],
            piece[2] + duration * piece[4],
            piece[3] + duration * piece[5],
            ax,
            ay,
            bx,
            by,
            distance,
        )
    t = piece[0]
    while True:
        x, y, vx, vy = state_on_piece(piece, t)
        dx, dy = _from_segment(x, y, ax, ay, bx, by)
        step = _safe_step(dx, dy, vx, vy, bound, distance)
        if step == 0.0:
            return False
        t += step
        if t >= piece[1]:
            return True


@kernel
def pieces_apart(
    mine: NDArray[np.float64], a: int, theirs: NDArray[np.float64], b: int, distance: float
) -> bool:
    """Whether rows a and b of two arrays of pieces are `distance` [m] apart while both last."""
    begin = max(mine[a, 0], theirs[b, 0])
    end = min(mine[a, 1], theirs[b, 1])
    if begin > end:
        return True
    bound = bend(mine[a]) + bend(theirs[b])
    if mine[a, 8] == 0.0 and theirs[b, 8] == 0.0:
        ax = mine[a, 6] - theirs[b, 6]
        ay = mine[a, 7] - theirs[b, 7]
        bound = sqrt(ax * ax + ay * ay)
    t = begin
    while True:
        x, y, vx, vy = state_on_piece(mine[a], t)
        ox, oy, ux, uy = state_on_piece(theirs[b], t)
        x -= ox
        y -= oy
        vx -= ux
        vy -= uy
        if bound == 0.0:
            duration = end - begin
            return _segments_apart(
                x, y, x + duration * vx, y + duration * vy, 0.0, 0.0, 0.0, 0.0, distance
            )
        step = _safe_step(x, y, vx, vy, bound, distance)
        if step == 0.0:
            return False
        t += step
        if t >= end:
            return True


@kernel
def _safe_step(dx: float, dy: float, vx: float, vy: float, bound: float, distance: float) -> float:
    """The longest time after which |d| + b h - bound h^2 / 2 is `distance` still; 0: too near."""
    away = sqrt(dx * dx + dy * dy)
    gap = away - distance
    if gap < TOUCH:
        return 0.0
    along = (dx * vx + dy * vy) / away
    root = sqrt(along * along + 2.0 * bound * gap)
    # Of the two forms of the greater root the one in which nothing cancels.
    return (along + root) / bound if along > 0.0 else 2.0 * gap / (root - along)


@kernel
def _from_segment(
    x: float, y: float, ax: float, ay: float, bx: float, by: float
) -> tuple[float, float]:
    """The vector to (x, y) from the nearest point of a segment."""
    ex = bx - ax
    ey = by - ay
    square = ex * ex + ey * ey
    s = 0.0
    if square > 0.0:
        s = min(max(((x - ax) * ex + (y - ay) * ey) / square, 0.0), 1.0)
    return x - ax - s * ex, y - ay - s * ey


@kernel
def _segments_apart(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    cx: float,
    cy: float,
    dx: float,
    dy: float,
    distance: float,
) -> bool:
    """Whether the segments ab and cd are that far apart: neither crossing nor with an end near."""
    side_c = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    side_d = (bx - ax) * (dy - ay) - (by - ay) * (dx - ax)
    side_a = (dx - cx) * (ay - cy) - (dy - cy) * (ax - cx)
    side_b = (dx - cx) * (by - cy) - (dy - cy) * (bx - cx)
    if side_c * side_d < 0.0 and side_a * side_b < 0.0:
        return False
    least = distance * distance
    for end in range(4):
        if end == 0:
            x, y = _from_segment(ax, ay, cx, cy, dx, dy)
        elif end == 1:
            x, y = _from_segment(bx, by, cx, cy, dx, dy)
        elif end == 2:
            x, y = _from_segment(cx, cy, ax, ay, bx, by)
        else:
            x, y = _from_segment(dx, dy, ax, ay, bx, by)
        if x * x + y * y < least:
            return False
    return True
