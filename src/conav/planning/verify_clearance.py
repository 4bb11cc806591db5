"""Nobody touches a wall, an obstacle or another robot, at any time."""

from math import inf, isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.verify_curves import least_apart, least_from_segment, place_at
from conav.planning.verify_scene import TOLERANCE, Check, Scene, Violation


class Clearance(NamedTuple):
    """Bounds on a smallest clearance [m] over radii (and margin); infinite where nobody meets."""

    low: float
    high: float
    robots: tuple[str, ...] = ()
    time_s: float | None = None

    def summary(self) -> dict[str, object] | None:
        """As JSON; None where nobody meets."""
        if not isfinite(self.high):
            return None
        return {
            "at_least_m": self.low,
            "at_most_m": self.high,
            "robots": list(self.robots),
            "time_s": self.time_s,
        }


NOBODY = Clearance(inf, inf)


def check_walls(scene: Scene, check: Check) -> Clearance:
    """The smallest clearance of a robot's disc from walls and obstacles."""
    smallest = NOBODY
    discs = np.column_stack([scene.discs[:, :2], scene.discs])  # segments of one point, and radii
    shapes = np.vstack([np.column_stack([scene.walls, np.zeros(len(scene.walls))]), discs])
    for _, body, track in scene.ways():
        x, y = track[0, 2:4].tolist()
        check.looked += len(track)
        if not inside(scene.walls, x, y):
            check.fault(Violation("begins outside the floor", (body.name,), 0.0, (x, y)))
            continue
        enough = max(smallest.high, TOLERANCE) if isfinite(smallest.high) else inf
        low, high, when, _, shape = least_over_shapes(track, shapes, body.radius, enough)
        found = Clearance(low, high, (body.name,), when)
        if high < smallest.high:
            smallest = found._replace(low=min(low, smallest.low))
        elif low < smallest.low:
            smallest = smallest._replace(low=low)
        if low < -TOLERANCE:
            what = "an obstacle" if shape >= len(scene.walls) else "a wall"
            check.fault(
                Violation(
                    f"overlaps {what} by {-low:.3g} m", (body.name,), when, _place(track, when)
                )
            )
    return smallest


def check_pairs(scene: Scene, check: Check) -> Clearance:
    """The smallest clearance between two robots, over their radii and the margin."""
    smallest = NOBODY
    ways = [(body, extended(track, body.stays, scene.horizon)) for _, body, track in scene.ways()]
    for i, (body, track) in enumerate(ways):
        for other, theirs in ways[i + 1 :]:
            check.looked += 1
            needed = body.radius + other.radius + scene.margin
            # What is farther than the smallest so far need not be known exactly.
            enough = needed + max(smallest.high, 2.0 * TOLERANCE)
            low, high, when = least_over_pieces(track, theirs, enough)
            low, high = low - needed, high - needed
            names = (body.name, other.name)
            if high < smallest.high:
                smallest = Clearance(min(low, smallest.low), high, names, when)
            elif low < smallest.low:
                smallest = smallest._replace(low=low)
            if low < -TOLERANCE:
                check.fault(
                    Violation(f"too near by {-low:.3g} m", names, when, _place(track, when))
                )
    return smallest


def extended(track: NDArray[np.float64], stays: bool, horizon: float) -> NDArray[np.float64]:
    """The pieces of a robot for as long as it is there, (n, 9)."""
    end = float(track[-1, 1])
    if not stays or end >= horizon:
        return track
    rest = np.zeros(9)
    rest[:4] = end, horizon, *place_at(track[-1], end)
    return np.vstack([track, rest])


def inside(walls: NDArray[np.float64], x: float, y: float) -> bool:
    """Whether a place is on the floor: a ray to the right crosses an odd number of walls."""
    x0, y0, x1, y1 = walls.T
    crossed = (y0 > y) != (y1 > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = x0 + (y - y0) / (y1 - y0) * (x1 - x0)
    return bool((crossed & (at > x)).sum() % 2)


@kernel
def least_over_shapes(
    track: NDArray[np.float64], shapes: NDArray[np.float64], radius: float, enough: float
) -> tuple[float, float, float, int, int]:
    """Bounds on the clearance of a disc from shapes, (n, 5) segments and how thick they are.

    Also a time of the upper bound, the piece and the shape.
    """
    low = np.inf
    high = np.inf
    when = 0.0
    which = 0
    nearest = 0
    for i in range(len(track)):
        for j in range(len(shapes)):
            needed = radius + shapes[j, 4]
            limit = max(min(enough, high), 0.0) + 1e-6
            lo, hi, t = least_from_segment(track[i], shapes[j, :4], needed + limit)
            low = min(low, lo - needed)
            if hi - needed < high:
                high = hi - needed
                when = t
                which = i
                nearest = j
    return low, high, when, which, nearest


@kernel
def least_over_pieces(
    a: NDArray[np.float64], b: NDArray[np.float64], enough: float
) -> tuple[float, float, float]:
    """Bounds on the least distance of two robots while both are there, and a time of the upper."""
    low = np.inf
    high = np.inf
    when = 0.0
    i = 0
    j = 0
    while i < len(a) and j < len(b):
        begin = max(a[i, 0], b[j, 0])
        end = min(a[i, 1], b[j, 1])
        if begin <= end:
            lo, hi, t = least_apart(a[i], b[j], begin, end, min(enough, high))
            low = min(low, lo)
            if hi < high:
                high = hi
                when = t
        if a[i, 1] <= b[j, 1]:
            i += 1
        else:
            j += 1
    return low, high, when


def _place(track: NDArray[np.float64], t: float) -> tuple[float, float]:
    rows = np.flatnonzero(track[:, 0] <= t)
    piece = track[rows[-1] if len(rows) else 0]
    x, y = place_at(piece, min(t, float(piece[1])))
    return float(x), float(y)
