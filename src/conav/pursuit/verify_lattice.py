"""The floor on a lattice of integers, for the verifier: the one place where numbers are rounded."""

from dataclasses import dataclass
from itertools import pairwise
from math import floor as round_down
from math import log10

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap, without_collinear_points
from conav.pursuit.verify_sight import REACH, on_floor, sees

Ints = NDArray[np.int64]
Point = tuple[int, int]

PARTS = 256
"""Lattice units in a grid step: a motion between grid points is halved eight times at most."""
FINEST_M = 1e-6  # [m] the finest grid


@dataclass(frozen=True, eq=False)
class Lattice:
    """A floor whose corners are grid points; coordinates count parts of a grid step.

    The lattice point (x, y) lies at `((x, y) / PARTS + centre) * grid_m`.
    """

    grid_m: float  # [m] steps of 1, 2 or 5 times a power of ten
    centre: Point  # [grid steps]
    points: Ints  # (n, 2) corners
    links: Ints  # (n, 3) corner before, corner after, turn (1 convex, -1 reflex)
    rings: tuple[Ints, ...]  # the same corners, ring by ring
    bridges: tuple[tuple[int, int], ...]  # pairs of corners that see each other and join all rings

    def snap(self, place: NDArray[np.float64] | tuple[float, float]) -> Point | None:
        """The grid point of the floor that is nearest, if it is no farther than three steps."""
        x, y = self.grid_point(place)
        near = [
            (ex * ex + ey * ey, x + PARTS * ex, y + PARTS * ey)
            for ex in range(-3, 4)
            for ey in range(-3, 4)
            if ex * ex + ey * ey <= 9
        ]
        for _, px, py in sorted(near):
            if max(abs(px), abs(py)) <= REACH and on_floor(self.points, self.links, px, py):
                return px, py
        return None

    def grid_point(self, place: NDArray[np.float64] | tuple[float, float]) -> Point:
        """The nearest grid point, on the floor or not."""
        x = round(float(place[0]) / self.grid_m) - self.centre[0]
        y = round(float(place[1]) / self.grid_m) - self.centre[1]
        return x * PARTS, y * PARTS

    def metres(self, points: NDArray[np.float64] | Ints) -> NDArray[np.float64]:
        """Lattice coordinates, shape (..., 2), in metres."""
        return (np.asarray(points, dtype=np.float64) / PARTS + np.array(self.centre)) * self.grid_m

    def from_metres(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places, shape (..., 2) [m], in lattice coordinates, not rounded."""
        return (np.asarray(places) / self.grid_m - np.array(self.centre)) * PARTS

    def joined(self, a: Point, b: Point) -> bool:
        """Whether the segment between two points of the floor lies in it."""
        return sees(self.points, self.links, *a, *b)


def make_lattice(plan: PolygonMap) -> Lattice:
    """The floor on the finest grid on which all signs stay exact.

    Raises `InputError` where rings meet on that grid that did not before.
    """
    x0, y0, x1, y1 = plan.bounds
    grid_m = _grid_m(max(x1 - x0, y1 - y0, 1e-3) / 2)
    centre = (round((x0 + x1) / 2 / grid_m), round((y0 + y1) / 2 / grid_m))
    rings = [np.rint(ring / grid_m) - np.array(centre) for ring in plan.rings]
    try:
        rings = [ring[(ring != np.roll(ring, 1, axis=0)).any(axis=1)] for ring in rings]
        snapped = without_collinear_points(PolygonMap(rings[0], rings[1:], plan.name))
    except InputError as error:
        raise InputError(
            plan.name,
            f"has walls nearer to each other than the verifier tells apart, {grid_m:g} m ({error})",
            "part them or split the floor",
        ) from None
    corners = tuple(np.rint(ring).astype(np.int64) * PARTS for ring in snapped.rings)
    points = np.concatenate(corners)
    starts = snapped.ring_starts.tolist()
    links = np.empty((len(points), 3), dtype=np.int64)
    for begin, end in pairwise(starts):
        numbers = np.arange(begin, end)
        links[begin:end, 0] = np.roll(numbers, 1)
        links[begin:end, 1] = np.roll(numbers, -1)
    links[:, 2] = snapped.turns
    for array in (points, links):
        array.flags.writeable = False
    return Lattice(grid_m, centre, points, links, corners, _bridges(points, links, starts))


def _grid_m(half_m: float) -> float:
    """The finest grid of steps 1, 2 or 5 times a power of ten that reaches as far."""
    # The other half of the lattice is for what lies outside the floor: the circles of ranges.
    steps = REACH // PARTS // 2 - 8
    least = max(half_m / steps, FINEST_M)
    power = round_down(log10(least)) - 1
    for exponent in range(power, power + 3):
        for step in (1, 2, 5):
            # A quotient where the power is negative, so that 0.001 is the float of that name.
            grid = step * 10.0**exponent if exponent >= 0 else step / 10.0**-exponent
            if grid >= least:
                return grid
    raise AssertionError("a power of ten is missing")


def _bridges(points: Ints, links: Ints, starts: list[int]) -> tuple[tuple[int, int], ...]:
    """Short segments between corners that join all rings, as pairs of corners."""
    n = len(points)
    ring = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    u, v = np.triu_indices(n, k=1)
    apart = ring[u] != ring[v]
    u, v = u[apart], v[apart]
    length = ((points[u] - points[v]) ** 2).sum(axis=1)
    joined = list(range(len(starts) - 1))
    bridges: list[tuple[int, int]] = []
    for k in np.argsort(length, kind="stable").tolist():
        if len(bridges) == len(starts) - 2:
            break
        i, j = int(u[k]), int(v[k])
        one, two = joined[ring[i]], joined[ring[j]]
        if one != two and sees(points, links, *points[i].tolist(), *points[j].tolist()):
            bridges.append((i, j))
            joined = [one if group == two else group for group in joined]
    return tuple(bridges)
