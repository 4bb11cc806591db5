"""What a sensor of limited range sees: the visibility polygon inside a polygon in its circle.

The circle is replaced by a regular polygon whose corners lie a little inside it, so nothing is
claimed that is out of range.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.errors import InputError
from conav.geometry.visibility import VisibilityPolygon

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

RANGE_END = -2  # the wall of a side where the range ends
_INSIDE_CIRCLE = 1.0 - 1e-12  # of the range: more than rounding can lose


class RangePolygon(NamedTuple):
    """What a point sees within a range; side i runs from corner i to the next, counter-clockwise.

    A side is a piece of a wall, of a window (`WINDOW`), or of the range's polygon (`RANGE_END`).
    """

    viewpoint: tuple[float, float]  # [m]
    corners: Floats  # (k, 2) [m]
    walls: Ints  # (k,) the wall of each side, WINDOW or RANGE_END

    @property
    def area(self) -> float:
        """Of the polygon [m^2]."""
        if len(self.corners) == 0:
            return 0.0
        x, y = (self.corners - np.array(self.viewpoint)).T
        return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2.0


def limit_range(seen: VisibilityPolygon, range_m: float, sides: int = 64) -> RangePolygon:
    """The part of a visibility polygon within a range [m] of its viewpoint.

    The range is a regular polygon of `sides` sides, a power of two and at least 8, in its circle:
    with 64 sides its area is 0.2 % smaller, its sides come 0.12 % nearer. Corners where sides are
    cut are rounded. Empty for a viewpoint off the floor.

    Raises `InputError` for other numbers of sides and for a range that is not positive and finite.

    >>> from conav.geometry.triangulation import triangulate
    >>> from conav.geometry.visibility import visibility_polygon
    >>> room = triangulate([(-9, -2), (9, -2), (9, 2), (-9, 2)], [0, 4])
    >>> near = limit_range(visibility_polygon(room, 0, 0), 4.0)
    >>> sorted(set(near.walls.tolist())), near.area < 2 * 4 * 8
    ([-2, 0, 2], True)
    """
    if not (0.0 < range_m < np.inf):
        raise InputError("range", f"is {range_m:g} m", "give a positive number of metres")
    if sides < 8 or sides & (sides - 1):
        raise InputError("range sides", f"are {sides}", "give 8, 16, 32, 64, ...")
    if len(seen.corners) == 0:
        return RangePolygon(seen.viewpoint, seen.corners, seen.walls)
    circle = np.array(seen.viewpoint) + (range_m * _INSIDE_CIRCLE) * _directions(sides)
    out = np.empty((3 * len(seen.corners) + sides, 2))
    walls = np.empty(len(out), np.int64)
    count = _clip(*seen.viewpoint, seen.corners, seen.walls, circle, out, walls)
    return RangePolygon(seen.viewpoint, out[:count].copy(), walls[:count].copy())


@cache
def _directions(sides: int) -> Floats:
    """Unit vectors at even angles, counter-clockwise from the x axis; by halving, no cosine."""
    found = np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
    while len(found) < sides:
        between = found + np.roll(found, -1, axis=0)
        between /= np.sqrt((between**2).sum(axis=1, keepdims=True))
        found = np.stack((found, between), axis=1).reshape(-1, 2)
    return found


@kernel
def _clip(
    x: float, y: float, corners: Floats, walls: Ints, circle: Floats, out: Floats, out_walls: Ints
) -> int:
    """How many corners were written: those of the polygon inside the convex `circle`.

    Both go counter-clockwise around (x, y) and are star-shaped from there, so between a side that
    leaves the circle and the next that comes in, the circle itself is the border.
    """
    k = corners.shape[0]
    sides = circle.shape[0]
    count = 0
    first_in = -1
    last_out = -1
    for i in range(k):
        ax, ay = corners[i]
        bx, by = corners[(i + 1) % k]
        begin = 0.0
        end = 1.0
        come_in = -1
        go_out = -1
        for s in range(sides):
            px, py = circle[s]
            qx, qy = circle[(s + 1) % sides]
            a = (qx - px) * (ay - py) - (qy - py) * (ax - px)
            b = (qx - px) * (by - py) - (qy - py) * (bx - px)
            if a < 0.0 and b < 0.0:
                begin = 2.0
                break
            if a < 0.0 and a / (a - b) > begin:
                begin = a / (a - b)
                come_in = s
            elif b < 0.0 and a / (a - b) < end:
                end = a / (a - b)
                go_out = s
        if begin > end:
            continue
        if come_in >= 0:
            if last_out >= 0:
                count = _along_circle(
                    x, y, circle, last_out, come_in, ax + begin * (bx - ax),
                    ay + begin * (by - ay), out, out_walls, count,
                )  # fmt: skip
            elif first_in < 0:
                first_in = come_in
        out[count, 0] = ax + begin * (bx - ax)
        out[count, 1] = ay + begin * (by - ay)
        out_walls[count] = walls[i]
        count += 1
        last_out = go_out
        if go_out >= 0:
            out[count, 0] = ax + end * (bx - ax)
            out[count, 1] = ay + end * (by - ay)
            out_walls[count] = RANGE_END
            count += 1
    if count == 0:
        out[:sides] = circle
        out_walls[:sides] = RANGE_END
        return sides
    if last_out >= 0 and first_in >= 0:
        count = _along_circle(
            x, y, circle, last_out, first_in, out[0, 0], out[0, 1], out, out_walls, count
        )
    return count


@kernel
def _along_circle(
    x: float, y: float, circle: Floats, leave: int, enter: int, ex: float, ey: float,
    out: Floats, out_walls: Ints, count: int,
) -> int:  # fmt: skip
    """The new count after the circle's corners from where it was left to (ex, ey) on side `enter`.

    The last corner so far is where it was left, on side `leave`.
    """
    sides = circle.shape[0]
    steps = (enter - leave) % sides
    lx = out[count - 1, 0] - x
    ly = out[count - 1, 1] - y
    if steps == 0 and lx * (ey - y) - ly * (ex - x) < 0.0:
        steps = sides  # once around
    for step in range(steps):
        out[count] = circle[(leave + 1 + step) % sides]
        out_walls[count] = RANGE_END
        count += 1
    return count
