"""Triangulations of floors: every point, every wall, the whole floor, and Delaunay."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.geometry.point_grid import INSIDE, ON_SIDE, ON_VERTEX, OUTSIDE, locate
from conav.geometry.triangulation import Triangulation, triangulate
from exact_floor import ExactFloor, cross, exact, minus, turn
from floor_shapes import L_SHAPE, RING, ROOMS, comb, floors, jittered_floors, viewpoints


def floor_of(rings) -> Triangulation:
    return triangulate(
        [point for ring in rings for point in ring], np.cumsum([0] + [len(r) for r in rings])
    )


def check(rings, floor: Triangulation) -> None:
    exactly = ExactFloor(rings)
    points = exactly.vertices
    assert [exact(p) for p in floor.vertices] == points
    assert list(enumerate(floor.wall_ends.tolist())) == exactly.walls
    # Counter-clockwise triangles that fill the floor.
    doubled = Fraction(0)
    for a, b, c in floor.triangles.tolist():
        assert turn(points[a], points[b], points[c]) == 1
        doubled += cross(minus(points[b], points[a]), minus(points[c], points[a]))
    assert doubled / 2 == exactly.area()
    n, holes = len(points), len(rings) - 1
    assert len(floor.triangles) == n + 2 * holes - 2
    # Twins agree, and each wall is a side once, its floor on the left.
    corners, twins = floor.triangles.reshape(-1), floor.twins.reshape(-1)
    ends = floor.triangles[:, [1, 2, 0]].reshape(-1)
    walls = []
    for h, g in enumerate(twins.tolist()):
        if g < 0:
            walls.append(-1 - g)
            assert (corners[h], ends[h]) == (-1 - g, floor.wall_ends[-1 - g])
            assert floor.wall_edges[-1 - g] == h
        else:
            assert twins[g] == h
            assert (corners[h], ends[h]) == (ends[g], corners[g])
    assert sorted(walls) == list(range(n))
    assert np.array_equal(floor.neighbours < 0, floor.constrained)


@settings(max_examples=150, deadline=None)
@given(st.one_of(floors, jittered_floors()))
def test_every_point_and_wall_and_the_whole_floor(rings) -> None:
    check(rings, floor_of(rings))


@settings(max_examples=80, deadline=None)
@given(floors)
def test_sides_between_triangles_are_delaunay(rings) -> None:
    floor = floor_of(rings)
    twins = floor.twins.reshape(-1)
    points = [exact(p) for p in floor.vertices]
    for h, g in enumerate(twins.tolist()):
        if g < 0:
            continue
        a, b, c = (points[v] for v in floor.triangles[h // 3])
        d = points[floor.triangles[g // 3, (g + 2) % 3]]
        rows = [minus(p, d) for p in (a, b, c)]
        lifted = [x * x + y * y for x, y in rows]
        value = (
            lifted[0] * cross(rows[1], rows[2])
            + lifted[1] * cross(rows[2], rows[0])
            + lifted[2] * cross(rows[0], rows[1])
        )
        assert value <= 0


@settings(max_examples=80, deadline=None)
@given(st.one_of(floors, jittered_floors()), st.integers(0, 2**32 - 1))
def test_points_are_located(rings, seed: int) -> None:
    floor, exactly = floor_of(rings), ExactFloor(rings)
    corners, ends = floor.triangles.reshape(-1), floor.triangles[:, [1, 2, 0]].reshape(-1)
    for x, y in viewpoints(rings, 12, np.random.default_rng(seed)):
        place, h = locate(floor.vertices, corners, *floor.grid, x, y)
        p = exact((x, y))
        assert (place != OUTSIDE) == exactly.contains(p)
        if place == OUTSIDE:
            assert h == -1
            continue
        assert (place == ON_VERTEX) == (p in exactly.vertices)
        if place == ON_VERTEX:
            assert exactly.vertices[corners[h]] == p
        signs = [
            turn(exactly.vertices[corners[e]], exactly.vertices[ends[e]], p)
            for e in range(h - h % 3, h - h % 3 + 3)
        ]
        if place == INSIDE:
            assert signs == [1, 1, 1]
        elif place == ON_SIDE:
            assert signs[h % 3] == 0
            assert sum(signs) == 2


def test_known_shapes() -> None:
    for rings in (L_SHAPE, RING, ROOMS, comb(5)):
        check(rings, floor_of(rings))


def test_a_large_floor_far_from_the_origin() -> None:
    rings = [[(x / 8 + 1e6, y / 8 - 3e6) for x, y in ring] for ring in comb(300)]
    check(rings, floor_of(rings))


def test_points_that_are_no_numbers_are_outside() -> None:
    floor = floor_of(RING)
    corners = floor.triangles.reshape(-1)
    for x, y in [(np.nan, 1.0), (1.0, np.inf), (-np.inf, np.nan), (1e300, 0.0)]:
        assert locate(floor.vertices, corners, *floor.grid, x, y)[0] == OUTSIDE


SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]


@pytest.mark.parametrize(
    ("rings", "words"),
    [
        ([[(0, 0), (4, 4), (4, 0), (0, 4)]], "meets wall"),
        ([SQUARE, [(3, 1), (3, 2), (5, 2), (5, 1)]], "meets wall"),
        ([SQUARE, [(1, 1), (1, 2), (2, 2)], [(1.5, 1), (1.5, 3), (3, 3)]], "meets wall"),
        ([SQUARE, [(0, 1), (1, 2), (1, 1)]], "lies on wall 3"),
        ([SQUARE, [(4, 4), (3, 3), (3, 3.5)]], "is the same point as vertex 2"),
        ([[(0, 0), (2, 0), (1, 0), (1, 1)]], "lies on wall 0"),
        ([[(0, 0), (2, 0), (0, 0), (1, 1)]], "is the same point as vertex 0"),
        ([SQUARE[::-1]], "not on the left"),
        ([SQUARE, [(1, 1), (2, 1), (2, 2)]], "not on the left"),
        ([SQUARE, [(5, 1), (5, 2), (6, 2)]], "not on the left"),
        (
            [SQUARE, [(1, 1), (1, 3), (3, 3), (3, 1)], [(2, 1.5), (1.5, 2), (2, 2)]],
            "not on the left",
        ),
        ([[(0, 0), (1, 1), (2, 2)]], "one line"),
        ([[(0, 0), (1, 1)]], "fewer than 3"),
        ([[(0, 0), (1, 0), (0, np.nan)]], "exactly"),
        ([[(0, 0), (1, 0), (0, 1e-300)]], "same point"),
        ([[(0, 0), (1, 0), (0, 1e200)]], "exactly"),
    ],
)
def test_rings_that_bound_no_floor_are_refused(rings, words: str) -> None:
    with pytest.raises(InputError, match=words):
        floor_of(rings)


def test_arrays_of_the_wrong_form_are_refused() -> None:
    with pytest.raises(InputError, match="shape"):
        triangulate([1.0, 2.0, 3.0], [0, 3])
    with pytest.raises(InputError, match="ring_starts"):
        triangulate(SQUARE, [0, 3])
