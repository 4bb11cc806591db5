"""Floors and schedules for the tests of the verifier."""

from collections.abc import Sequence

import numpy as np
import shapely

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.types import Schedule

Way = Sequence[tuple[float, float]]

ROOMS = PolygonMap(
    [
        *[(0, 0), (13, 0), (13, -2), (10, -2), (10, -8), (18, -8), (18, -2), (15, -2), (15, 0)],
        *[(30, 0), (30, 3), (26, 3), (26, 5), (29, 5), (29, 11), (21, 11), (21, 5), (24, 5)],
        *[(24, 3), (6, 3), (6, 5), (9, 5), (9, 11), (1, 11), (1, 5), (4, 5), (4, 3), (0, 3)],
    ]
)
"""A corridor with three rooms, left, middle (below) and right."""
LEFT, DOORS, MIDDLE, RIGHT = (5, 6), (5, 1.5), (14, -3), (25, 6)
LEFT_TO_RIGHT: Way = [LEFT, DOORS, (14, 1.5), MIDDLE, (14, 1.5), (25, 1.5), RIGHT]

RING = PolygonMap([(0, 0), (6, 0), (6, 6), (0, 6)], [[(2, 2), (2, 4), (4, 4), (4, 2)]])
LAP: Way = [(1, 1), (5, 1), (5, 5), (1, 5), (1, 1)]

NINE = PolygonMap(
    [
        *[(2.3464, -0.6), (-5, -0.6), (-5, 0), (-0.6928, 0), (2.9804, 6.3622)][::-1],
        *[(4.5, -4.3301), (5.0196, -4.0301), (1.3464, 2.3321), (3.5, 6.0622)],
    ]
)
"""Three pursuers see all of its walls, and not a triangle in its middle."""

SPIDER = PolygonMap(
    [
        *[(-8.5, -4.5), (-8.5, -3.5), (-4.5, -3.5), (-4.5, 0.5), (-0.5, 0.5), (-0.5, 4.5)],
        *[(3.5, 4.5), (3.5, 8.5), (4.5, 8.5), (4.5, 3.5), (0.5, 3.5), (0.5, 0.5), (4.5, 0.5)],
        *[(4.5, -3.5), (8.5, -3.5), (8.5, -4.5), (3.5, -4.5), (3.5, -0.5), (-3.5, -0.5)],
        *[(-3.5, -4.5)],
    ][::-1]
)
"""Three arms of corridor with two bends each: one pursuer cannot clear it."""


def schedule(*ways: Way, times: Sequence[float] | None = None) -> Schedule:
    """Pursuers who drive these ways, all as many legs, and see all the time; legs of a second."""
    positions = np.array(ways, dtype=np.float64).transpose(1, 0, 2)
    n = len(positions) - 1
    when = np.arange(n + 1.0) if times is None else np.array(times)
    return Schedule(when, positions, np.ones((n, len(ways)), dtype=np.bool_))


def in_turn(*moves: tuple[int, tuple[float, float]], starts: Way) -> Schedule:
    """Pursuers who drive one at a time: who, and where to."""
    rows = [list(starts)]
    for who, place in moves:
        rows.append([place if i == who else at for i, at in enumerate(rows[-1])])
    return schedule(*zip(*rows, strict=True))


def block_floor(rng: np.random.Generator, size: int = 6, jitter: float = 0.0) -> PolygonMap:
    """A random floor of unit squares: orthogonal, with holes, all corners on a lattice.

    With `jitter` the corners are moved a little.
    """
    while True:
        free = rng.random((size, size)) < 0.62
        squares = [shapely.box(x, y, x + 1, y + 1) for y, x in np.argwhere(free).tolist()]
        parts = shapely.get_parts(shapely.union_all(squares))
        if len(parts) == 0:
            continue
        floor = max(parts, key=shapely.area).simplify(0.0)
        floor = shapely.geometry.polygon.orient(floor, 1.0)
        rings = [np.array(r.coords)[:-1] for r in (floor.exterior, *floor.interiors)]
        rings = [ring + rng.normal(0.0, jitter, ring.shape) for ring in rings]
        try:
            plan = PolygonMap(rings[0], rings[1:])
        except InputError:  # rings that touch
            continue
        if len(plan.vertices) >= 8:
            return plan


def random_ways(
    plan: PolygonMap, rng: np.random.Generator, pursuers: int, legs: int
) -> list[list[tuple[float, float]]]:
    """Drives between corners, places on a half-unit lattice and others; some legs are rests."""
    x0, y0, x1, y1 = plan.bounds
    places = [tuple(corner) for corner in plan.vertices.tolist()]
    while len(places) < len(plan.vertices) + 20:
        at = rng.uniform((x0, y0), (x1, y1))
        at = np.round(2 * at) / 2 if rng.random() < 0.6 else np.round(at, 3)
        if plan.contains(at):
            places.append(tuple(at.tolist()))
    ways: list[list[tuple[float, float]]] = []
    for _ in range(pursuers):
        way = [places[rng.integers(len(places))]]
        while len(way) <= legs:
            to = places[rng.integers(len(places))]
            if plan.polygon.covers(shapely.LineString((way[-1], to))):
                way.append(to)
            elif rng.random() < 0.2:
                way.append(way[-1])
        ways.append(way)
    return ways
