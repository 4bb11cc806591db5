"""Static obstacles against shapely and exact fractions."""

from fractions import Fraction

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.maps.polygon_map import PolygonMap
from conav.planning.obstacles import build_obstacles, point_free, segment_free, segments_square

SMALL = st.integers(-6, 6)


def scene(seed: int) -> tuple[PolygonMap, np.ndarray]:
    """A floor with two holes and some discs."""
    random = np.random.default_rng(seed)
    x, y = random.uniform(2, 5, 2)
    holes = [
        [(x, y), (x + 0.7, y + 2.0), (x + 1.5, y + 0.3)],
        [(x + 4, y), (x + 4, y + 1), (x + 4.2, y + 1), (x + 4.2, y)],
    ]
    outer = [(0, 0), (13, -1), (14, 9), (7, 6), (1, 10)]
    discs = np.column_stack([random.uniform(1, 12, (6, 2)), random.uniform(0.1, 0.8, 6)])
    return PolygonMap(outer, holes), discs


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("cell", [0.2, 0.5, 3.0])
def test_free_is_what_shapely_says(seed: int, cell: float) -> None:
    floor, discs = scene(seed)
    radius = 0.3
    obstacles = build_obstacles(floor, discs, radius, cell)
    walls = shapely.union_all([shapely.LineString(ring) for ring in floor.polygon.boundary.geoms])
    centres = shapely.points(discs[:, :2])
    random = np.random.default_rng(seed + 100)
    free = 0
    for _ in range(400):
        ax, ay, bx, by = random.uniform(-1, 14, 4)
        near = random.uniform() < 0.5
        if near:
            bx, by = ax + random.normal(), ay + random.normal()
        at = shapely.Point(ax, ay)
        expected = (
            floor.polygon.covers(at)
            and walls.distance(at) >= radius
            and bool((shapely.distance(centres, at) >= discs[:, 2] + radius).all())
        )
        assert point_free(*obstacles, ax, ay) == expected
        if not expected:
            continue
        way = shapely.LineString([(ax, ay), (bx, by)])
        clear = walls.distance(way) >= radius and bool(
            (shapely.distance(centres, way) >= discs[:, 2] + radius).all()
        )
        assert segment_free(*obstacles, ax, ay, bx, by) == clear
        assert segment_free(*obstacles, bx, by, ax, ay) == clear
        free += clear
    assert free > 20


def test_touching_is_free_and_a_hair_nearer_is_not() -> None:
    floor = PolygonMap([(0, 0), (8, 0), (8, 8), (0, 8)])
    obstacles = build_obstacles(floor, np.array([[4.0, 4.0, 1.0]]), 0.5)
    assert point_free(*obstacles, 0.5, 0.5)
    assert not point_free(*obstacles, 0.5 - 1e-12, 0.5)
    assert segment_free(*obstacles, 1.0, 2.5, 7.0, 2.5)
    assert not segment_free(*obstacles, 1.0, 2.5 + 1e-12, 7.0, 2.5)


@given(st.tuples(*[SMALL] * 8))
@settings(max_examples=300, deadline=None)
def test_distance_of_segments_is_exact_to_rounding(numbers: tuple[int, ...]) -> None:
    a, b, c, d = ((Fraction(numbers[i]), Fraction(numbers[i + 1])) for i in (0, 2, 4, 6))
    expected = exact_square(a, b, c, d)
    found = segments_square(*(float(number) for number in numbers))
    assert abs(found - float(expected)) <= 1e-12 * (1 + float(expected))
    assert (found == 0.0) == (expected == 0) or found < 1e-25


def exact_square(a: tuple, b: tuple, c: tuple, d: tuple) -> Fraction:
    def cross(o: tuple, p: tuple, q: tuple) -> Fraction:
        return (p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0])

    def point(p: tuple, u: tuple, v: tuple) -> Fraction:
        dx, dy = v[0] - u[0], v[1] - u[1]
        length = dx * dx + dy * dy
        along = Fraction(0)
        if length:
            along = ((p[0] - u[0]) * dx + (p[1] - u[1]) * dy) / length
            along = min(max(along, Fraction(0)), Fraction(1))
        return (p[0] - u[0] - along * dx) ** 2 + (p[1] - u[1] - along * dy) ** 2

    if cross(a, b, c) * cross(a, b, d) < 0 and cross(c, d, a) * cross(c, d, b) < 0:
        return Fraction(0)
    return min(point(c, a, b), point(d, a, b), point(a, c, d), point(b, c, d))
