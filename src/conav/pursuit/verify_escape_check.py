"""Whether an evader's path is never seen: a small check that needs nothing but the path.

It takes the floor and the schedule as they are, not on the lattice, and a rule that is sufficient
and simple: during a short time somebody who moves on a straight line does not see an evader who
does, when one wall lies between all their places at once.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.maps.polygon_map import PolygonMap
from conav.pursuit.types import Schedule

DEEPEST = 48  # halvings of a piece of time

# Over the rounding of the sum of two products of differences of coordinates that were interpolated.
_ROUNDING = 2.0**-46


@dataclass(frozen=True, eq=False)
class EvaderPath:
    """Where an evader is when: on straight lines at constant speed from each place to the next."""

    times: NDArray[np.float64]  # (n,) [s], rising
    places: NDArray[np.float64]  # (n, 2) [m]


def evader_path(times: ArrayLike, places: ArrayLike) -> EvaderPath:
    """A path of these times, shape (n,) [s], and places, shape (n, 2) [m]."""
    return EvaderPath(np.array(times, dtype=np.float64), np.array(places, dtype=np.float64))


def escape_faults(
    plan: PolygonMap,
    schedule: Schedule,
    ranges: tuple[float | None, ...],
    path: EvaderPath,
) -> list[str]:
    """Why a path is no escape, in words; empty when nobody active ever sees the evader.

    An escape lasts as long as the schedule, moves through the inside of the floor, and is seen at
    no time, ends of activity included.
    """
    times, places = path.times, path.places
    if times.ndim != 1 or places.shape != (len(times), 2) or len(times) == 0:
        return ["the path's times and places do not belong together"]
    if not (np.isfinite(times).all() and np.isfinite(places).all()):
        return ["the path has numbers that are not finite"]
    if (np.diff(times) <= 0).any():
        return ["the path's times do not rise"]
    if times[0] != schedule.times[0] or times[-1] != schedule.times[-1]:
        return ["the path does not last as long as the schedule"]
    walls = _walls(plan)
    if not plan.contains(places).all():
        return ["the path leaves the floor"]
    for k in range(len(times) - 1):
        if _touches(walls, places[k], places[k + 1]):
            return [f"the path meets a wall after {times[k]:.9g} s"]
    for leg in range(len(schedule.active)):
        begin, end = schedule.times[leg : leg + 2]
        inner = times[(times > begin) & (times < end)]
        cuts = np.concatenate(([begin], inner, [end]))
        at = np.stack([np.interp(cuts, times, places[:, axis]) for axis in range(2)], axis=1)
        share = (cuts - begin) / (end - begin) if end > begin else np.array([0.0, 1.0])
        for i in np.flatnonzero(schedule.active[leg]).tolist():
            a, b = schedule.positions[leg, i], schedule.positions[leg + 1, i]
            where = a + share[:, None] * (b - a)
            where[-1] = b
            for k in range(len(cuts) - 1):
                if not _unseen(walls, where[k : k + 2], at[k : k + 2], ranges[i]):
                    return [
                        f"pursuer {i} may see the evader between {cuts[k]:.9g} and "
                        f"{cuts[k + 1]:.9g} s"
                    ]
    return []


def _cross(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]):
    """The cross product (b - a) x (c - a) and a bound on its rounding, over the last axis."""
    left = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1])
    right = (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
    size = np.abs(a).max() + np.abs(b).max() + np.abs(c).max()
    return left - right, _ROUNDING * size * size


def _touches(walls: "_Walls", x: NDArray[np.float64], y: NDArray[np.float64]) -> bool:
    """Whether a segment meets a wall, or comes so near that rounding hides it."""
    c, d = walls.c, walls.d
    of_c, e1 = _cross(x, y, c)
    of_d, e2 = _cross(x, y, d)
    of_x, e3 = _cross(c, d, x[None])
    of_y, e4 = _cross(c, d, y[None])
    apart = ((of_c > e1) & (of_d > e2)) | ((of_c < -e1) & (of_d < -e2))
    apart |= ((of_x > e3) & (of_y > e4)) | ((of_x < -e3) & (of_y < -e4))
    low, high = np.minimum(x, y), np.maximum(x, y)
    apart |= ((np.minimum(c, d) > high) | (np.maximum(c, d) < low)).any(axis=1)
    return not bool(apart.all())


def _unseen(
    walls: "_Walls",
    pursuer: NDArray[np.float64],
    evader: NDArray[np.float64],
    range_m: float | None,
) -> bool:
    """Whether a pursuer does not see an evader while both move, from the first to the second row.

    All lines of sight are among those between the two segments.
    """
    stack = [(pursuer, evader, 0)]
    while stack:
        p, x, depth = stack.pop()
        if _blocked(walls, p, x) or (range_m is not None and _far(p, x, range_m)):
            continue
        still = (p[0] == p[1]).all() and (x[0] == x[1]).all()
        if depth == DEEPEST or still:
            return False
        pm, xm = (p[0] + p[1]) / 2, (x[0] + x[1]) / 2
        stack.append((np.stack((p[0], pm)), np.stack((x[0], xm)), depth + 1))
        stack.append((np.stack((pm, p[1])), np.stack((xm, x[1])), depth + 1))
    return True


class _Walls(NamedTuple):
    """Walls from c to d, the floor on their left, and the walls before and after each."""

    c: NDArray[np.float64]  # (n, 2) [m]
    d: NDArray[np.float64]  # (n, 2) [m]
    before: NDArray[np.int64]
    after: NDArray[np.int64]
    convex: NDArray[np.bool_]  # the corner at c


def _walls(plan: PolygonMap) -> _Walls:
    n = len(plan.vertices)
    before, after = np.arange(n) - 1, np.arange(n) + 1
    for begin, end in pairwise(plan.ring_starts.tolist()):
        before[begin], after[end - 1] = end - 1, begin
    return _Walls(plan.segments[:, :2], plan.segments[:, 2:], before, after, plan.turns > 0)


def _blocked(walls: _Walls, p: NDArray[np.float64], x: NDArray[np.float64]) -> bool:
    """Whether one wall, or two that meet at a corner, lie across all lines of sight.

    On which side of a line of sight a place lies is linear in either end of the line, so the four
    extreme lines tell for all. The rules and why they suffice: docs/pursuit-verifier.md, section 5.
    """
    c, d = walls.c, walls.d
    begins, ends = p[[0, 0, 1, 1], None, :], x[[0, 1, 0, 1], None, :]
    of_c, e1 = _cross(begins, ends, c[None])
    of_d, e2 = _cross(begins, ends, d[None])
    of_p, e3 = _cross(c[None], d[None], begins)
    of_x, e4 = _cross(c[None], d[None], ends)
    e = max(e1, e2, e3, e4)
    # The pursuer before the wall or on it, the evader behind it.
    faced = (of_p >= -e).all(axis=0)
    hidden = (of_x < -e).all(axis=0)
    c_right, d_left = (of_c < -e).all(axis=0), (of_d > e).all(axis=0)
    # At a convex corner a line of sight that passes the wall's end meets the next wall.
    c_ends = walls.convex & faced[walls.before] & (of_c <= e).all(axis=0)
    d_ends = walls.convex[walls.after] & faced[walls.after] & (of_d >= -e).all(axis=0)
    if (faced & hidden & (c_right | c_ends) & (d_left | d_ends)).any():
        return True
    # Before both walls at a corner, and behind both.
    after = walls.after
    if (faced & faced[after] & hidden & hidden[after] & c_right & d_left[after]).any():
        return True
    # The same with the evader before the walls.
    faced, hidden = (of_x > e).all(axis=0), (of_p < -e).all(axis=0)
    c_left, d_right = (of_c > e).all(axis=0), (of_d < -e).all(axis=0)
    if (faced & hidden & c_left & d_right).any():
        return True
    return bool((faced & faced[after] & hidden & hidden[after] & c_left & d_right[after]).any())


def _far(p: NDArray[np.float64], x: NDArray[np.float64], range_m: float) -> bool:
    """Whether both are out of range of each other all the time they move."""
    a, b = x[0] - p[0], x[1] - p[1]
    d = b - a
    length = float(d @ d)
    t = min(max(-float(a @ d) / length, 0.0), 1.0) if length > 0.0 else 0.0
    nearest = a + t * d
    return float(np.hypot(*nearest)) > range_m * (1 + 1e-9) + 1e-9
