"""When evaders that walk at random are seen: what a schedule does on average, by simulation.

A schedule that captures sees every evader before it ends, whatever evaders do. How soon it sees one
that moves at bounded speed and does not know of the pursuers is another question.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, inf, isfinite

import numpy as np
from numpy.typing import NDArray

from conav.geometry.sight_lines import sees
from conav.geometry.triangulation import Triangulation, triangulate
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.shadow_moves import Point
from conav.pursuit.types import Schedule

_TRIES = 1000  # points of the floor tried as the next goal, before an evader waits

_Look = tuple[float, list[tuple[Point, float]]]
"""A moment, and who sees then: places and ranges."""


@dataclass(frozen=True, eq=False)
class CaptureTimes:
    """When each evader was seen first."""

    times: NDArray[np.float64]  # (evaders,) [s] since the schedule begins; inf: never

    @property
    def caught(self) -> int:
        """How many were seen at all."""
        return int(np.isfinite(self.times).sum())

    @property
    def mean_s(self) -> float | None:
        """The mean time of those that were seen; None where nobody was."""
        return float(self.times[np.isfinite(self.times)].mean()) if self.caught else None

    @property
    def standard_error_s(self) -> float | None:
        """Of the mean; None where fewer than two were seen."""
        if self.caught < 2:
            return None
        spread = float(self.times[np.isfinite(self.times)].std(ddof=1))
        return spread / self.caught**0.5


def random_evader_capture_times(
    floor: PolygonMap,
    schedule: Schedule,
    ranges: Sequence[float | None],
    *,
    speed_mps: float,
    evaders: int,
    seed: int,
    step_s: float = 0.1,
) -> CaptureTimes:
    """When each of so many evaders is first seen by pursuers that follow the schedule.

    An evader begins anywhere on the floor, all points being equally likely. It chooses a point of
    the floor that it sees, again all equally likely, walks straight to it at `speed_mps` [m/s], and
    chooses anew; at speed 0 it stands. It knows nothing of the pursuers. `ranges` [m] are as in
    `Pursuer`. Each evader has random numbers of its own, so its way depends on `seed` and its
    number alone.

    It is looked at the ends of legs and every `step_s` [s] or more often in between, so an evader
    may be seen up to `step_s` too late, or, seen in passing, not at all. Raises `ValueError` for a
    speed, number or step that is none.
    """
    if not (isfinite(speed_mps) and speed_mps >= 0.0):
        raise ValueError(f"speed_mps is {speed_mps:g}; give 0 or more")
    if evaders < 1:
        raise ValueError(f"evaders is {evaders}; give 1 or more")
    if seed < 0:
        raise ValueError(f"seed is {seed}; give 0 or more")
    if not (isfinite(step_s) and step_s > 0.0):
        raise ValueError(f"step_s is {step_s:g}; give more than 0")
    mesh = triangulate(floor.vertices, floor.ring_starts)
    corners = mesh.vertices[mesh.triangles]
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    shares = np.cumsum(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    looks = list(_looks(schedule, ranges, step_s))
    times = np.full(evaders, inf)
    for number in range(evaders):
        walk = _Walk(mesh, shares, np.random.default_rng([seed, number]), speed_mps)
        for time, seeing in looks:
            at = walk.at(time)
            if any(_near(at, place, reach) and sees(mesh, place, at) for place, reach in seeing):
                times[number] = time
                break
    return CaptureTimes(times)


def _looks(schedule: Schedule, ranges: Sequence[float | None], step_s: float) -> Iterator[_Look]:
    reach = [inf if range_m is None else range_m for range_m in ranges]
    first = float(schedule.times[0])
    for leg, active in enumerate(schedule.active.tolist()):
        begin, end = (float(time) - first for time in schedule.times[leg : leg + 2])
        before, after = schedule.positions[leg], schedule.positions[leg + 1]
        count = max(1, ceil((end - begin) / step_s))
        for k in range(count + 1):
            share = k / count
            # Ends are places of the schedule, to the last digit.
            places = after if k == count else before + share * (after - before)
            seeing = [((x, y), reach[i]) for i, (x, y) in enumerate(places.tolist()) if active[i]]
            yield begin + share * (end - begin), seeing


class _Walk:
    """The way of one evader; it is asked for times that never fall."""

    def __init__(
        self,
        mesh: Triangulation,
        shares: NDArray[np.float64],
        rng: np.random.Generator,
        speed_mps: float,
    ) -> None:
        self._mesh, self._shares, self._rng, self._speed = mesh, shares, rng, speed_mps
        self._from = self._to = self._point()
        self._left = self._arrives = 0.0

    def at(self, time: float) -> Point:
        """Where it is."""
        while self._speed > 0.0 and time > self._arrives:
            self._from, self._to = self._to, self._goal()
            (ax, ay), (bx, by) = self._from, self._to
            length = ((ax - bx) ** 2 + (ay - by) ** 2) ** 0.5
            self._left = self._arrives
            # Who found no goal waits a metre's time.
            self._arrives += (length if length > 0.0 else 1.0) / self._speed
        if time >= self._arrives:
            return self._to
        share = (time - self._left) / (self._arrives - self._left)
        (ax, ay), (bx, by) = self._from, self._to
        return ax + share * (bx - ax), ay + share * (by - ay)

    def _goal(self) -> Point:
        for _ in range(_TRIES):
            point = self._point()
            if sees(self._mesh, self._to, point):
                return point
        return self._to

    def _point(self) -> Point:
        """A point of the floor, all equally likely."""
        u, v, w = self._rng.random(3).tolist()
        found = int(np.searchsorted(self._shares, w * self._shares[-1], side="right"))
        number = min(found, len(self._shares) - 1)
        if u + v > 1.0:
            u, v = 1.0 - u, 1.0 - v
        a, b, c = self._mesh.vertices[self._mesh.triangles[number]]
        x, y = (a + u * (b - a) + v * (c - a)).tolist()
        return x, y


def _near(a: Point, b: Point, reach: float) -> bool:
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 <= reach * reach
