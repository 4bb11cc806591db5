"""Exact sight between lattice points, for the verifier; written a second time on purpose.

Coordinates are integers of at most `REACH` (docs/pursuit-verifier.md, section 2). A line is a
triple (A, B, C) of integers: A x + B y + C is positive on its left, and its direction is (B, -A).
A point that is no lattice point is named by two lines through it. Every sign below is exact:
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
def determinant_sign(lines: Ints, k: int, m: int, n: int) -> int:
    """The exact sign of the determinant of three lines, rows k, m and n of a table (?, 3)."""
    k0, k1, k2 = lines[k, 0], lines[k, 1], lines[k, 2]
    m0, m1, m2 = lines[m, 0], lines[m, 1], lines[m, 2]
    n0, n1, n2 = lines[n, 0], lines[n, 1], lines[n, 2]
    a = float(n0) * float(k1) * float(m2)
    b = float(n0) * float(k2) * float(m1)
    c = float(n1) * float(k2) * float(m0)
    d = float(n1) * float(k0) * float(m2)
    e = float(n2) * float(k0) * float(m1)
    f = float(n2) * float(k1) * float(m0)
    value = (a - b) + (c - d) + (e - f)
    limit = _ERROR * (abs(a) + abs(b) + abs(c) + abs(d) + abs(e) + abs(f))
    if value > limit:
        return 1
    if value < -limit:
        return -1
    exact = n0 * (k1 * m2 - k2 * m1) + n1 * (k2 * m0 - k0 * m2) + n2 * (k0 * m1 - k1 * m0)
    return 1 if exact > 0 else (-1 if exact < 0 else 0)


@kernel
def cross_sign(lines: Ints, k: int, m: int) -> int:
    """The sign of the turn from the direction of line k to that of m; 0 where they are parallel."""
    value = lines[k, 0] * lines[m, 1] - lines[k, 1] * lines[m, 0]
    return 1 if value > 0 else (-1 if value < 0 else 0)


@kernel
def side(lines: Ints, n: int, k: int, m: int) -> int:
    """Where the crossing of lines k and m lies of line n: 1 left, -1 right, 0 on it."""
    return determinant_sign(lines, k, m, n) * cross_sign(lines, k, m)


@kernel
def order(lines: Ints, k: int, m: int, n: int) -> int:
    """1 where along line k its crossing with n comes after that with m, -1 before, 0 at it."""
    return -side(lines, m, k, n) * cross_sign(lines, k, m)


@kernel
def put_line(lines: Ints, row: int, px: int, py: int, qx: int, qy: int) -> None:
    """Put the line from p to q into a row of a table."""
    lines[row, 0] = py - qy
    lines[row, 1] = qx - px
    lines[row, 2] = px * qy - qx * py


@kernel
def put_axis(lines: Ints, row: int, px: int, py: int, k: int) -> None:
    """Put an upright or level line through p, not parallel to line k, into a row of a table."""
    upright = lines[k, 1] != 0  # line k is not
    lines[row, 0] = 1 if upright else 0
    lines[row, 1] = 0 if upright else 1
    lines[row, 2] = -px if upright else -py


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
    A segment leaves the floor where it crosses a wall from side to side, where an end lies on a
    wall and the other behind it, or at a corner on it from which it leads between the walls.
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
def put_stop(
    points: Ints, links: Ints, lines: Ints, row: int, px: int, py: int, vx: int, vy: int
) -> None:
    """Put a line into row + 2 of a table that crosses the ray from p on beyond v where that leaves
    the floor; row holds the line from p to v, row + 1 is overwritten.

    The ray must lead into the floor at v. Corners that it only grazes do not stop it.
    """
    dx, dy = vx - px, vy - py
    found = False
    for i in range(points.shape[0]):
        j = links[i, 1]
        ix, iy, jx, jy = points[i, 0], points[i, 1], points[j, 0], points[j, 1]
        of_i = turn(px, py, vx, vy, ix, iy)
        if of_i == 0:
            ahead = (ix - vx) * dx + (iy - vy) * dy > 0
            if not ahead or opens(points, links, i, ix + dx, iy + dy):
                continue
            put_axis(lines, row + 1, ix, iy, row)
        else:
            if of_i * turn(px, py, vx, vy, jx, jy) >= 0:
                continue
            put_line(lines, row + 1, ix, iy, jx, jy)
            # The ray goes towards the wall when it changes the side on which v lies.
            here = turn(ix, iy, jx, jy, vx, vy)
            change = lines[row + 1, 0] * dx + lines[row + 1, 1] * dy
            if not (here > 0 > change or here < 0 < change):
                continue
        if not found or order(lines, row, row + 2, row + 1) < 0:
            found = True
            lines[row + 2, 0] = lines[row + 1, 0]
            lines[row + 2, 1] = lines[row + 1, 1]
            lines[row + 2, 2] = lines[row + 1, 2]


@kernel
def windows(points: Ints, links: Ints, px: int, py: int) -> tuple[Ints, Ints]:
    """The windows of the view from p: their lines (3 k, 3), and corners and sides (k, 2).

    A window lies on the line from p through a reflex corner that p sees and from which the walls
    turn to one side (1 left, -1 right); it runs from the corner until the floor ends. On that side
    of it nothing is seen. Within the floor the view is bounded by windows alone. Each has three
    lines: its own, one that crosses it at its start, and one at its end.
    """
    n = points.shape[0]
    lines = np.empty((3 * n, 3), dtype=np.int64)
    of = np.empty((n, 2), dtype=np.int64)
    count = 0
    for v in range(n):
        vx, vy = points[v, 0], points[v, 1]
        if links[v, 2] >= 0 or (vx == px and vy == py):
            continue
        u, w = links[v, 0], links[v, 1]
        ux, uy, wx, wy = points[u, 0], points[u, 1], points[w, 0], points[w, 1]
        of_u = turn(px, py, vx, vy, ux, uy)
        of_w = turn(px, py, vx, vy, wx, wy)
        dx, dy = vx - px, vy - py
        if of_u == 0:
            # A wall along the ray hides something only when it lies before the corner.
            if (ux - vx) * dx + (uy - vy) * dy > 0:
                continue
            of_u = of_w
        elif of_w == 0:
            if (wx - vx) * dx + (wy - vy) * dy > 0:
                continue
            of_w = of_u
        if of_u != of_w or not sees(points, links, px, py, vx, vy):
            continue
        put_line(lines, 3 * count, px, py, vx, vy)
        put_stop(points, links, lines, 3 * count, px, py, vx, vy)
        put_axis(lines, 3 * count + 1, vx, vy, 3 * count)
        of[count, 0] = v
        of[count, 1] = of_u
        count += 1
    return lines[: 3 * count].copy(), of[:count].copy()


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
    points: Ints, links: Ints, view: Ints, xx: int, xy: int, ax: int, ay: int, bx: int, by: int
) -> bool:
    """Whether point x sees no point of the segment a-b, which lies in the floor.

    `view` are the lines of the windows of x. What x sees of the segment ends at a, at b, or at one
    of them.
    """
    if sees(points, links, xx, xy, ax, ay) or sees(points, links, xx, xy, bx, by):
        return False
    if ax == bx and ay == by:
        return True
    # Rows: the segment, lines through its ends, then a window with its ends.
    lines = np.empty((6, 3), dtype=np.int64)
    put_line(lines, 0, ax, ay, bx, by)
    put_axis(lines, 1, ax, ay, 0)
    put_axis(lines, 2, bx, by, 0)
    for k in range(view.shape[0] // 3):
        lines[3:6] = view[3 * k : 3 * k + 3]
        if cross_sign(lines, 0, 3) == 0:
            if side(lines, 0, 3, 4) == 0:
                return False  # along the segment; that it is seen is not known, but may be
            continue
        apart = side(lines, 3, 0, 1) * side(lines, 3, 0, 2)
        across = side(lines, 0, 3, 4) * side(lines, 0, 3, 5)
        if apart <= 0 and across <= 0:
            return False
    return True
