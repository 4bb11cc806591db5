"""Sight between points, visible vertices and rays: by hand and against rational numbers."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.geometry.sight_lines import (
    sees,
    shoot_ray,
    shoot_ray_from_vertex,
    vertex_visibility,
    visible_vertices,
)
from conav.geometry.triangulation import triangulate
from exact_floor import ExactFloor, cross, exact, minus
from floor_shapes import L_SHAPE, RING, ROOMS, comb, floors, jittered_floors, viewpoints


def floor_of(rings):
    return triangulate(
        [point for ring in rings for point in ring], np.cumsum([0] + [len(r) for r in rings])
    )


# Two holes touch the line y = 5 from either side.
BETWEEN = [
    [(0, 0), (10, 0), (10, 10), (0, 10)],
    [(3, 5), (3, 8), (4, 8), (4, 5)],
    [(6, 2), (6, 5), (7, 5), (7, 2)],
]


def test_sight_along_walls_and_past_corners() -> None:
    floor = floor_of(RING)
    assert sees(floor, (0, 4), (10, 4))  # along the hole's lower wall
    assert sees(floor, (4, 0), (4, 10))
    assert sees(floor, (2, 6), (6, 2))  # by the corner (4, 4)
    assert not sees(floor, (2, 6), (6.0000001, 2.0000001))
    assert not sees(floor, (1, 5), (9, 5))
    assert sees(floor, (0, 0), (4, 4))
    assert not sees(floor, (0, 0), (6, 6))
    assert sees(floor, (1, 1), (1, 1))
    # Ends off the floor.
    assert not sees(floor, (5, 5), (1, 1))
    assert not sees(floor, (1, 1), (5, 5))
    assert not sees(floor, (1, 1), (11, 1))
    assert not sees(floor, (1, 1), (np.nan, 1))


def test_sight_without_width() -> None:
    floor = floor_of(BETWEEN)
    assert sees(floor, (0, 5), (10, 5))
    assert not sees(floor, (0, 5.0000001), (10, 5))
    seen = visible_vertices(floor, 0, 5)
    assert seen[[4, 7, 9, 10]].all()  # every vertex on the line
    assert shoot_ray(floor, (0, 5), (1, 5)).point == (10, 5)


def test_rays_end_at_walls_and_vertices() -> None:
    floor = floor_of(RING)
    end = shoot_ray(floor, (1, 5), (2, 5))
    assert (end.wall, end.parameter, end.point) == (4, 0.5, (4.0, 5.0))
    end = shoot_ray(floor, (1, 1), (2, 2))
    assert (end.vertex, end.wall, end.point) == (4, -1, (4.0, 4.0))
    end = shoot_ray(floor, (1, 4), (2, 4))
    assert (end.vertex, end.wall, end.parameter) == (-1, 1, 0.4)
    # From a wall off the floor, along a wall to its end, and from off the floor.
    assert shoot_ray(floor, (5, 0), (5, -1)).point == (5, 0)
    assert shoot_ray(floor, (5, 0), (6, 0)).vertex == 1
    assert (shoot_ray(floor, (5, 5), (6, 5)).vertex, shoot_ray(floor, (5, 5), (6, 5)).wall) == (
        -1,
        -1,
    )
    # Beyond a vertex.
    end = shoot_ray_from_vertex(floor, (0, 2), 5)
    assert (end.wall, end.parameter) == (2, pytest.approx(0.2))
    assert end.point == (pytest.approx(8), 10)
    assert shoot_ray_from_vertex(floor, (0, 0), 4).vertex == 4
    assert shoot_ray_from_vertex(floor, (4, 0), 4).point == (4, 10)
    with pytest.raises(InputError, match="direction"):
        shoot_ray(floor, (1, 1), (1, 1))
    with pytest.raises(InputError, match="direction"):
        shoot_ray_from_vertex(floor, (4, 4), 4)


def test_vertices_of_an_l_around_its_inner_corner() -> None:
    seen = vertex_visibility(floor_of(L_SHAPE))
    hidden = {(int(a), int(b)) for a, b in np.argwhere(~seen)}
    assert hidden == {(2, 4), (4, 2), (1, 4), (4, 1), (2, 5), (5, 2)}
    assert not visible_vertices(floor_of(L_SHAPE), 1.5, 1.5).any()


def test_collinear_corners_of_a_comb_see_each_other() -> None:
    teeth = 30
    floor = floor_of(comb(teeth))
    seen = vertex_visibility(floor)
    line = np.flatnonzero(floor.vertices[:, 1] == 1)
    assert seen[np.ix_(line, line)].all()
    assert np.array_equal(seen, seen.T)


@settings(max_examples=60, deadline=None)
@given(st.one_of(floors, jittered_floors()), st.integers(0, 2**32 - 1))
def test_sight_is_what_the_twin_says_both_ways(rings, seed: int) -> None:
    floor, exactly = floor_of(rings), ExactFloor(rings)
    points = viewpoints(rings, 6, np.random.default_rng(seed))
    for a in points:
        for b in points:
            assert sees(floor, a, b) == exactly.sees(exact(a), exact(b))


@settings(max_examples=20, deadline=None)
@given(st.one_of(floors, jittered_floors()))
def test_vertices_see_each_other_as_the_twin_says(rings) -> None:
    floor, exactly = floor_of(rings), ExactFloor(rings)
    seen = vertex_visibility(floor)
    assert np.array_equal(seen, seen.T)
    assert seen.diagonal().all()
    n = len(exactly.vertices)
    pairs = [(a, b) for a in range(n) for b in range(a)]
    for a, b in pairs[:: max(len(pairs) // 150, 1)]:
        assert seen[a, b] == exactly.sees(exactly.vertices[a], exactly.vertices[b])


@settings(max_examples=60, deadline=None)
@given(st.one_of(floors, jittered_floors()), st.integers(0, 2**32 - 1))
def test_rays_end_where_sight_does(rings, seed: int) -> None:
    floor, exactly = floor_of(rings), ExactFloor(rings)
    points = viewpoints(rings, 5, np.random.default_rng(seed))
    for a in points:
        for b in points:
            if a == b or not exactly.contains(exact(a)):
                continue
            end = shoot_ray(floor, a, b)
            p, d = exact(a), minus(exact(b), exact(a))
            if end.vertex >= 0:
                stop = exactly.vertices[end.vertex]
            else:
                c, e = exactly.ends(end.wall)
                along = cross(minus(e, c), d)
                if along == 0:  # from a wall, off the floor at once
                    stop = p
                else:
                    part = cross(minus(p, c), d) / along
                    assert 0 <= part <= 1
                    assert float(part) == pytest.approx(end.parameter, abs=1e-6)
                    stop = exactly.point_on(end.wall, part)
            # On the ray; seen; and a hair further nothing is.
            away = minus(stop, p)
            assert cross(away, d) == 0
            assert away[0] * d[0] + away[1] * d[1] >= 0
            assert exactly.sees(p, stop)
            hair = Fraction(1, 2**200)
            assert not exactly.contains((stop[0] + hair * d[0], stop[1] + hair * d[1]))


def test_rooms_seen_from_the_corridor() -> None:
    floor = floor_of(ROOMS)
    seen = visible_vertices(floor, 12, 0)
    # The door posts of the middle room and the ends of the corridor.
    at = {tuple(p): bool(s) for p, s in zip(floor.vertices.tolist(), seen, strict=True)}
    assert all(at[point] for point in [(0, 0), (24, 3), (11, 3), (13, 4)])
    assert not any(at[point] for point in [(9, 9), (1, 4)])
