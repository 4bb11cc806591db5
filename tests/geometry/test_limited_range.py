"""Limited range against shapely-free definitions: inside the circle, inside the view, and tight."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.geometry.limited_range import RANGE_END, limit_range
from conav.geometry.point_grid import OUTSIDE
from conav.geometry.triangulation import triangulate
from conav.geometry.visibility import VisibilityPolygon, visibility_polygon
from exact_floor import ExactFloor, exact
from floor_shapes import L_SHAPE, RING, floors, jittered_floors, viewpoints


def look(rings, x: float, y: float) -> VisibilityPolygon:
    floor = triangulate(
        [point for ring in rings for point in ring], np.cumsum([0] + [len(r) for r in rings])
    )
    return visibility_polygon(floor, x, y)


HALL = [[(-10, -10), (10, -10), (10, 10), (-10, 10)]]


def test_in_the_open_it_is_the_polygon_in_the_circle() -> None:
    for sides in (8, 64, 1024):
        near = limit_range(look(HALL, 1, 2), 3.0, sides)
        assert near.walls.tolist() == [RANGE_END] * sides
        angle = 2 * np.pi / sides
        assert near.area == pytest.approx(9 * sides * np.sin(angle) / 2)


def test_a_range_beyond_all_walls_changes_nothing() -> None:
    seen = look(RING, 1, 5)
    near = limit_range(seen, 100.0)
    assert np.array_equal(near.corners, seen.corners)
    assert np.array_equal(near.walls, seen.walls)


def test_at_a_wall_and_in_a_corner() -> None:
    circle = 64 * np.sin(2 * np.pi / 64) / 2
    for x, y, part in [(0, -10, 1 / 2), (-10, -10, 1 / 4), (10, 3, 1 / 2)]:
        assert limit_range(look(HALL, x, y), 2.0).area == pytest.approx(4 * circle * part)
    # All but a quarter, at the reflex vertex.
    assert limit_range(look(L_SHAPE, 1, 1), 0.5).area == pytest.approx(circle / 4 * 3 / 4)


def test_one_wall_cuts_the_circle() -> None:
    near = limit_range(look(HALL, 9, 0), 2.0, 1024)
    angle = np.arccos(0.5)
    segment = 4 * (angle - np.sin(angle) * np.cos(angle))
    assert near.area == pytest.approx(4 * np.pi - segment, rel=1e-4)
    assert sorted(set(near.walls.tolist())) == [RANGE_END, 1]


def test_settings_that_make_no_sense() -> None:
    seen = look(HALL, 0, 0)
    for sides in (4, 12, 0, -8):
        with pytest.raises(InputError, match="sides"):
            limit_range(seen, 1.0, sides)
    for reach in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="range"):
            limit_range(seen, reach)
    assert len(limit_range(look(HALL, 11, 0), 1.0).corners) == 0


@settings(max_examples=100, deadline=None)
@given(
    st.one_of(floors, jittered_floors()),
    st.integers(0, 2**32 - 1),
    st.floats(0.05, 1.0),
    st.sampled_from([8, 32]),
)
def test_within_range_and_within_sight(rings, seed: int, part: float, sides: int) -> None:
    rng = np.random.default_rng(seed)
    span = float(np.ptp(np.array(rings[0]), axis=0).max())
    reach = part * span
    for x, y in viewpoints(rings, 2, rng):
        seen = look(rings, x, y)
        if seen.place == OUTSIDE:
            continue
        near = limit_range(seen, reach, sides)
        away = near.corners - (x, y)
        assert (np.hypot(*away.T) <= reach).all()
        assert near.area <= seen.area * (1 + 1e-12) + 1e-12
        # Star-shaped and closed: counter-clockwise around the viewpoint, once at most.
        turns = away[:, 0] * np.roll(away[:, 1], -1) - away[:, 1] * np.roll(away[:, 0], -1)
        assert (turns >= -1e-9 * span**2).all()
        # Random points: in the polygon exactly if seen and within the range's polygon.
        angles = 2 * np.pi * np.arange(sides) / sides
        exactly, q = ExactFloor(rings), exact((x, y))
        for _ in range(12):
            r, phi = reach * rng.random() ** 0.5, rng.uniform(0, 2 * np.pi)
            point = (x + r * np.cos(phi), y + r * np.sin(phi))
            apothem = reach * np.cos(np.pi / sides)
            depth = apothem - (r * np.cos(phi - angles - np.pi / sides)).max()
            edge = distance_to(near.corners, point)
            if min(abs(depth), edge) > 1e-9 * span:
                expected = depth > 0 and exactly.sees(q, exact(point))
                assert inside(near.corners, point) == expected


def inside(ring: np.ndarray, point) -> bool:
    ends = np.roll(ring, -1, axis=0)
    found = False
    for (ax, ay), (bx, by) in zip(ring.tolist(), ends.tolist(), strict=True):
        if (ay > point[1]) != (by > point[1]):
            found ^= ax + (point[1] - ay) * (bx - ax) / (by - ay) > point[0]
    return found


def distance_to(ring: np.ndarray, point) -> float:
    ends = np.roll(ring, -1, axis=0)
    along = ends - ring
    square = np.maximum((along**2).sum(axis=1), 1e-300)
    part = np.clip(((point - ring) * along).sum(axis=1) / square, 0, 1)
    return float(np.hypot(*(ring + part[:, None] * along - point).T).min())
