"""Whether an evader's path is never seen: a small check that needs nothing but the path.

It takes the floor and the schedule as they are, not on the lattice, and a rule that is sufficient
and simple: during a short time somebody who moves on a straight line does not see an evader who
does, when one wall lies between all their places at once.
"""

from dataclasses import dataclass

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
    walls = plan.segments
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


def _touches(
    walls: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64]
) -> bool:
    """Whether a segment meets a wall, or comes so near that rounding hides it."""
    c, d = walls[:, :2], walls[:, 2:]
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
    walls: NDArray[np.float64],
    pursuer: NDArray[np.float64],
    evader: NDArray[np.float64],
    range_m: float | None,
) -> bool:
    """Whether a pursuer does not see an evader while both move, from the first to the second row.

    All lines of sight are among those between the two segments. That a wall's end lies on one side
    of a line of sight is linear in either of its ends, so the four extreme lines tell for all.
    """
    stack = [(pursuer, evader, 0)]
    while stack:
        p, x, depth = stack.pop()
        if (
            _blocked(walls, p, x)
            or _starts_behind(walls, p, x)
            or (range_m is not None and _far(p, x, range_m))
        ):
            continue
        still = (p[0] == p[1]).all() and (x[0] == x[1]).all()
        if depth == DEEPEST or still:
            return False
        pm, xm = (p[0] + p[1]) / 2, (x[0] + x[1]) / 2
        stack.append((np.stack((p[0], pm)), np.stack((x[0], xm)), depth + 1))
        stack.append((np.stack((pm, p[1])), np.stack((xm, x[1])), depth + 1))
    return True


def _blocked(
    walls: NDArray[np.float64], p: NDArray[np.float64], x: NDArray[np.float64]
) -> bool:
    c, d = walls[None, :, :2], walls[None, :, 2:]
    begins = p[[0, 0, 1, 1], None, :]
    ends = x[[0, 1, 0, 1], None, :]
    of_c, e1 = _cross(begins, ends, c)
    of_d, e2 = _cross(begins, ends, d)
    of_p, e3 = _cross(c, d, begins)
    of_x, e4 = _cross(c, d, ends)
    # A wall hides with its face or from behind; either way round all lines must cross alike.
    left = ((of_c > e1) & (of_d < -e2) & (of_p < -e3) & (of_x > e4)).all(axis=0)
    right = ((of_c < -e1) & (of_d > e2) & (of_p > e3) & (of_x < -e4)).all(axis=0)
    return bool((left | right).any())


def _starts_behind(
    walls: NDArray[np.float64], p: NDArray[np.float64], x: NDArray[np.float64]
) -> bool:
    """Whether the pursuer is on one wall all the time and the evader behind it.

    Where the pursuer is at a reflex corner the evader must be behind both walls.
    """
    c, d = walls[:, :2], walls[:, 2:]
    on = np.ones(len(walls), dtype=np.bool_)
    behind = np.ones(len(walls), dtype=np.bool_)
    for at in p:
        on &= (_cross(c, d, at[None])[0] == 0) & ((at - c) * (at - d) <= 0).all(axis=1)
    for at in x:
        of_at, error = _cross(c, d, at[None])
        behind &= of_at < -error
    return any(
        all(_leaves_behind(walls, behind, k, at) for at in p)
        for k in np.flatnonzero(on & behind).tolist()
    )


def _leaves_behind(
    walls: NDArray[np.float64], behind: NDArray[np.bool_], k: int, at: NDArray[np.float64]
) -> bool:
    """Whether what lies behind wall k is out of the floor as seen from a place on it."""
    c, d = walls[k, :2], walls[k, 2:]
    if (at == c).all():
        other = int(np.flatnonzero((walls[:, 2:] == c).all(axis=1))[0])
        turn, error = _cross(walls[other, :2], c, d)
    elif (at == d).all():
        other = int(np.flatnonzero((walls[:, :2] == d).all(axis=1))[0])
        turn, error = _cross(c, d, walls[other, 2:])
    else:
        return True
    return bool(turn > error or behind[other])


def _far(p: NDArray[np.float64], x: NDArray[np.float64], range_m: float) -> bool:
    """Whether both are out of range of each other all the time they move."""
    a, b = x[0] - p[0], x[1] - p[1]
    d = b - a
    length = float(d @ d)
    t = min(max(-float(a @ d) / length, 0.0), 1.0) if length > 0.0 else 0.0
    nearest = a + t * d
    return float(np.hypot(*nearest)) > range_m * (1 + 1e-9) + 1e-9
