"""Exact sight between lattice points, for the verifier; written a second time on purpose.

Coordinates are integers of at most `REACH` (docs/pursuit-verifier.md, section 2). A line is a triple
(A, B, C) of integers: A x + B y + C is positive on its left, and its direction is (B, -A). A point
that is no lattice point is named by two lines through it. Every sign below is exact:
- a turn of three lattice points fits into 64 bits;
- the determinant of three lines is computed in floating point with a bound on the error. Where the
  bound leaves the sign open, the determinant is so small that 64-bit arithmetic, which drops
  multiples of 2^64, gives it exactly.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

Ints = NDArray[np.int64]

REACH = 1 << 26
"""The greatest coordinate: beyond it determinants could not be told from their remainders."""

# A product of three numbers and its share of the sum are rounded eight times, by 2^-53 each; twice
# that covers the rounding of the bound itself.
_ERROR = 2.0**-49


@kernel
def turn(ax: int, ay: int, bx: int, by: int, cx: int, cy: int) -> int:
    """1 where c is left of the line from a to b, -1 right, 0 on it."""
    value = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    return 1 if value > 0 else (-1 if value < 0 else 0)


@kernel
def determinant_sign(l: Ints, m: Ints, n: Ints) -> int:
    """The exact sign of the determinant of three lines (A, B, C), as rows."""
    a = float(n[0]) * float(l[1]) * float(m[2])
    b = float(n[0]) * float(l[2]) * float(m[1])
    c = float(n[1]) * float(l[2]) * float(m[0])
    d = float(n[1]) * float(l[0]) * float(m[2])
    e = float(n[2]) * float(l[0]) * float(m[1])
    f = float(n[2]) * float(l[1]) * float(m[0])
    value = (a - b) + (c - d) + (e - f)
    limit = _ERROR * (abs(a) + abs(b) + abs(c) + abs(d) + abs(e) + abs(f))
    if value > limit:
        return 1
    if value < -limit:
        return -1
    exact = (
        n[0] * (l[1] * m[2] - l[2] * m[1])
        + n[1] * (l[2] * m[0] - l[0] * m[2])
        + n[2] * (l[0] * m[1] - l[1] * m[0])
    )
    return 1 if exact > 0 else (-1 if exact < 0 else 0)


@kernel
def cross_sign(l: Ints, m: Ints) -> int:
    """The sign of the turn from the direction of line l to that of m; 0 where they are parallel."""
    value = l[0] * m[1] - l[1] * m[0]
    return 1 if value > 0 else (-1 if value < 0 else 0)


@kernel
def side(n: Ints, l: Ints, m: Ints) -> int:
    """Where the crossing of lines l and m lies of line n: 1 left, -1 right, 0 on it."""
    return determinant_sign(l, m, n) * cross_sign(l, m)


@kernel
def order(l: Ints, m: Ints, n: Ints) -> int:
    """1 where along line l its crossing with n comes after that with m, -1 before, 0 at it."""
    return -side(m, l, n) * cross_sign(l, m)


@kernel
def line(px: int, py: int, qx: int, qy: int, out: Ints) -> None:
    """Put the line from p to q into `out`."""
    out[0] = py - qy
    out[1] = qx - px
    out[2] = px * qy - qx * py


@kernel
def axis_through(px: int, py: int, l: Ints, out: Ints) -> None:
    """Put an upright or level line through p, not parallel to line l, into `out`."""
    if l[1] != 0:  # line l is not upright
        out[0] = 1
        out[1] = 0
        out[2] = -px
    else:
        out[0] = 0
        out[1] = 1
        out[2] = -py


@kernel
def opens(points: Ints, links: Ints, v: int, x: int, y: int) -> bool:
    """Whether the direction from corner v towards (x, y) leads into the closed floor at v."""
    vx, vy = points[v, 0], points[v, 1]
    u, w = links[v, 0], links[v, 1]
    ahead = turn(vx, vy, points[w, 0], points[w, 1], x, y) >= 0
    behind = turn(points[u, 0], points[u, 1], vx, vy, x, y) >= 0
    if links[v, 2] < 0:
        return ahead or behind
    return ahead and behind


@kernel
def on_floor(points: Ints, links: Ints, x: int, y: int) -> bool:
    """Whether a lattice point lies in the closed floor."""
    inside = False
    for i in range(points.shape[0]):
        j = links[i, 1]
        ix, iy, jx, jy = points[i, 0], points[i, 1], points[j, 0], points[j, 1]
        where = turn(ix, iy, jx, jy, x, y)
        if where == 0 and (x - ix) * (x - jx) + (y - iy) * (y - jy) <= 0:
            return True
        if iy <= y < jy and where > 0:
            inside = not inside
        if jy <= y < iy and where < 0:
            inside = not inside
    return inside


@kernel
def sees(points: Ints, links: Ints, ax: int, ay: int, bx: int, by: int) -> bool:
    """Whether the segment between two points of the floor lies in the closed floor.

    `points` (n, 2) are the corners, `links` (n, 3) the corners before and after and the turn.
    A segment leaves the floor where it crosses a wall from side to side, where an end lies on a wall
    and the other behind it, or at a corner on it from which it leads between the walls.
    """
    for i in range(points.shape[0]):
        j = links[i, 1]
        ix, iy, jx, jy = points[i, 0], points[i, 1], points[j, 0], points[j, 1]
        of_i = turn(ax, ay, bx, by, ix, iy)
        if of_i == 0 and (ix - ax) * (ix - bx) + (iy - ay) * (iy - by) <= 0:
            if (ax != ix or ay != iy) and not opens(points, links, i, ax, ay):
                return False
            if (bx != ix or by != iy) and not opens(points, links, i, bx, by):
                return False
        of_a = turn(ix, iy, jx, jy, ax, ay)
        of_b = turn(ix, iy, jx, jy, bx, by)
        if of_a >= 0 and of_b >= 0:
            continue
        if of_a * of_b < 0 and of_i * turn(ax, ay, bx, by, jx, jy) < 0:
            return False
        if of_a == 0 and (ax - ix) * (ax - jx) + (ay - iy) * (ay - jy) < 0:
            return False
        if of_b == 0 and (bx - ix) * (bx - jx) + (by - iy) * (by - jy) < 0:
            return False
    return True


@kernel
def cast(
    points: Ints, links: Ints, walls: Ints, vx: int, vy: int, dx: int, dy: int, out: Ints
) -> bool:
    """Put a line that crosses the ray from v in direction d where the ray leaves the floor
    into `out`; False where it never does.

    Corners that the ray only grazes do not stop it. The direction must lead into the floor at v.
    """
    ray = np.empty(3, dtype=np.int64)
    line(vx, vy, vx + dx, vy + dy, ray)
    stop = np.empty(3, dtype=np.int64)
    found = False
    for i in range(points.shape[0]):
        j = links[i, 1]
        ix, iy = points[i, 0], points[i, 1]
        of_i = turn(vx, vy, vx + dx, vy + dy, ix, iy)
        if of_i == 0:
            ahead = (ix - vx) * dx + (iy - vy) * dy > 0
            if not ahead or opens(points, links, i, ix + dx, iy + dy):
                continue
            axis_through(ix, iy, ray, stop)
        else:
            if of_i * turn(vx, vy, vx + dx, vy + dy, points[j, 0], points[j, 1]) >= 0:
                continue
            # The ray goes towards the wall when it changes the side in which v lies.
            here = turn(ix, iy, points[j, 0], points[j, 1], vx, vy)
            change = walls[i, 0] * dx + walls[i, 1] * dy
            if not (here > 0 > change or here < 0 < change):
                continue
            stop[:] = walls[i]
        if not found or order(ray, out, stop) < 0:
            found = True
            out[:] = stop
    return found


@kernel
def windows(points: Ints, links: Ints, walls: Ints, px: int, py: int) -> Ints:
    """The windows of the view from p, shape (k, 8), by corner: corner, side, line, line at the end.

    A window lies on the line from p through a reflex corner that p sees and from which the walls
    turn to one side, `side` (1 left, -1 right); it runs from the corner until the floor ends. On
    that side of it nothing is seen. Within the floor the view is bounded by windows alone.
    """
    out = np.empty((points.shape[0], 8), dtype=np.int64)
    count = 0
    for v in range(points.shape[0]):
        vx, vy = points[v, 0], points[v, 1]
        if links[v, 2] >= 0 or (vx == px and vy == py):
            continue
        u, w = links[v, 0], links[v, 1]
        of_u = turn(px, py, vx, vy, points[u, 0], points[u, 1])
        of_w = turn(px, py, vx, vy, points[w, 0], points[w, 1])
        dx, dy = vx - px, vy - py
        if of_u == 0:
            # A wall along the ray hides something only when it lies before the corner.
            if (points[u, 0] - vx) * dx + (points[u, 1] - vy) * dy > 0:
                continue
            of_u = of_w
        elif of_w == 0:
            if (points[w, 0] - vx) * dx + (points[w, 1] - vy) * dy > 0:
                continue
            of_w = of_u
        if of_u != of_w or not sees(points, links, px, py, vx, vy):
            continue
        out[count, 0] = v
        out[count, 1] = of_u
        line(px, py, vx, vy, out[count, 2:5])
        cast(points, links, walls, vx, vy, dx, dy, out[count, 5:8])
        count += 1
    return out[:count].copy()


@kernel
def first_seen(points: Ints, links: Ints, px: int, py: int) -> int:
    """The first corner, other than p itself, that p sees; -1 where there is none."""
    for v in range(points.shape[0]):
        if (points[v, 0] != px or points[v, 1] != py) and sees(
            points, links, px, py, points[v, 0], points[v, 1]
        ):
            return v
    return -1


@kernel
def never_sees(
    points: Ints, links: Ints, xx: int, xy: int, view: Ints, ax: int, ay: int, bx: int, by: int
) -> bool:
    """Whether point x sees no point of the segment a-b, which lies in the floor.

    `view` are the windows of x. What x sees of the segment ends at a, at b, or at one of them.
    """
    if sees(points, links, xx, xy, ax, ay) or sees(points, links, xx, xy, bx, by):
        return False
    if ax == bx and ay == by:
        return True
    segment = np.empty(3, dtype=np.int64)
    start = np.empty(3, dtype=np.int64)
    end = np.empty(3, dtype=np.int64)
    corner = np.empty(3, dtype=np.int64)
    line(ax, ay, bx, by, segment)
    for k in range(view.shape[0]):
        window = view[k, 2:5]
        vx, vy = points[view[k, 0], 0], points[view[k, 0], 1]
        axis_through(vx, vy, window, corner)
        if cross_sign(segment, window) == 0:
            if side(segment, window, corner) == 0:
                return False  # along the segment; that it is seen is not known, but may be
            continue
        axis_through(ax, ay, segment, start)
        axis_through(bx, by, segment, end)
        apart = side(window, segment, start) * side(window, segment, end)
        across = side(segment, window, corner) * side(segment, window, view[k, 5:8])
        if apart <= 0 and across <= 0:
            return False
    return True
