"""Visibility polygons: by hand, against a slow twin in rational numbers, and against CGAL."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from conav.geometry.point_grid import INSIDE, ON_SIDE, ON_VERTEX, OUTSIDE
from conav.geometry.triangulation import Triangulation, triangulate
from conav.geometry.visibility import (
    HIT,
    WINDOW,
    VisibilityPolygon,
    find_windows,
    visibility_polygon,
)
from exact_floor import ExactFloor, Piece, exact, minus, turn
from floor_shapes import L_SHAPE, RING, ROOMS, comb, floors, jittered_floors, viewpoints


def floor_of(rings) -> Triangulation:
    return triangulate(
        [point for ring in rings for point in ring], np.cumsum([0] + [len(r) for r in rings])
    )


def look(rings, x: float, y: float) -> VisibilityPolygon:
    return visibility_polygon(floor_of(rings), x, y)


# By hand


def test_convex_corners_are_all_seen() -> None:
    seen = look([[(0, 0), (4, 0), (4, 3), (0, 3)]], 1, 1)
    assert seen.place == ON_SIDE or seen.place == INSIDE
    assert seen.area == 12
    assert sorted(seen.vertices.tolist()) == sorted(seen.walls.tolist()) == [0, 1, 2, 3]


def test_an_l_shape_from_inside_one_arm() -> None:
    floor = floor_of(L_SHAPE)
    seen = visibility_polygon(floor, 1.5, 0.5)
    # The ray through the inner corner (1, 1) ends at (0, 2), a vertex exactly.
    assert seen.vertices.tolist().count(HIT) == 0
    assert seen.area == 2.5
    windows = find_windows(floor, seen)
    assert (windows.near.tolist(), windows.far_vertices.tolist()) == ([3], [5])
    assert windows.hidden_right.tolist() == [True]
    seen = visibility_polygon(floor, 1.75, 0.75)
    windows = find_windows(floor, seen)
    assert windows.near.tolist() == [3]
    assert windows.far_walls.tolist() == [5]
    assert windows.far_parameters.tolist() == [pytest.approx((2 - 4 / 3) / 2)]
    assert seen.corners[seen.vertices == HIT].tolist() == [[0.0, pytest.approx(4 / 3)]]


def test_at_the_reflex_vertex_everything_is_seen() -> None:
    seen = look(L_SHAPE, 1, 1)
    assert seen.place == ON_VERTEX
    assert (seen.area, seen.walls.tolist().count(WINDOW)) == (3, 0)


def test_along_a_wall() -> None:
    # On the line of the wall from (2, 1) to (1, 1): it is seen along, not across.
    seen = look(L_SHAPE, 0.5, 1.0)
    assert seen.area == 3
    # The other arm shows nothing beyond the line of the inner wall.
    floor = floor_of(L_SHAPE)
    seen = visibility_polygon(floor, 2, 1)
    assert seen.area == 2
    windows = find_windows(floor, seen)
    assert windows.near.tolist() == [3]
    assert windows.far_walls.tolist() == [5]
    assert windows.far_parameters.tolist() == [0.5]


def test_a_ring_hides_what_lies_behind_its_hole() -> None:
    seen = look(RING, 1, 5)
    # Behind the hole: a trapezium from the hole's near side to x = 10, less the hole.
    assert seen.area == pytest.approx(96 - ((10 - 4) * (2 + 6) / 2 - 4))


def test_two_holes_touch_a_line_of_sight_from_either_side() -> None:
    rings = [
        [(0, 0), (10, 0), (10, 10), (0, 10)],
        [(3, 5), (3, 8), (4, 8), (4, 5)],
        [(6, 2), (6, 5), (7, 5), (7, 2)],
    ]
    floor = floor_of(rings)
    seen = visibility_polygon(floor, 1, 5)
    # Beyond the second hole only the line y = 5 is seen: no part of the polygon.
    assert ExactFloor(rings).sees(exact((1, 5)), exact((10, 5)))
    right = seen.corners[seen.corners[:, 0] > 7]
    assert (np.abs(right[:, 1] - 5) > 1).all()
    windows = find_windows(floor, seen)
    # One window along y = 5, from the first hole's lower right corner to the second's upper left.
    level = [i for i in range(len(windows.near)) if windows.far_vertices[i] != HIT]
    assert [(windows.near[i], windows.far_vertices[i]) for i in level] == [(7, 9)]


def test_vertices_on_one_ray_part_a_window() -> None:
    # Two pillars touch the ray y = 1 from above: it is a chain of walls and windows.
    rings = [
        [(0, 0), (12, 0), (12, 6), (0, 6)],
        [(2, 1), (2, 3), (4, 3), (4, 1)],
        [(6, 1), (7, 3), (8, 3)],
    ]
    floor = floor_of(rings)
    seen = visibility_polygon(floor, 1, 1)
    windows = find_windows(floor, seen)
    chain = [
        (int(a), int(b), int(c))
        for a, b, c in zip(windows.near, windows.far_vertices, windows.far_walls, strict=True)
    ]
    assert (7, 8, -1) in chain  # from the first pillar to the tip of the second
    assert (8, HIT, 1) in chain  # and on to the wall
    assert 4 not in windows.near  # along the pillar's lower wall there is wall, not window
    assert 7 in seen.walls


def test_in_a_doorway() -> None:
    floor = floor_of(ROOMS)
    # In the middle of the door of the first room, and on its posts.
    for x, y in [(4, 3), (4, 3.5), (4, 4), (3, 3), (3, 4), (5, 3.5)]:
        seen = visibility_polygon(floor, x, y)
        assert float(ExactFloor(ROOMS).visible_area(exact((x, y)))) == pytest.approx(seen.area)
    assert visibility_polygon(floor, 4, 4).area == pytest.approx(30 + 2 + 4 / 3 * 3 / 2 + 4, abs=9)


def test_the_corridor_of_a_comb() -> None:
    teeth = 20
    floor = floor_of(comb(teeth))
    seen = visibility_polygon(floor, teeth + 0.5, 0)
    # The whole corridor, and into every tooth.
    assert sum(v != HIT for v in seen.vertices) >= 2 * teeth
    assert len(find_windows(floor, seen).near) == teeth - (teeth % 2 == 1)


def test_off_the_floor() -> None:
    for x, y in [(5, 5), (-1, 5), (11, 5), (np.nan, 1), (np.inf, 1)]:
        seen = look(RING, x, y)
        assert (seen.place, len(seen.corners), seen.area) == (OUTSIDE, 0, 0)
        assert len(find_windows(floor_of(RING), seen).near) == 0


# Against the twin


def pieces_of(seen: VisibilityPolygon, exactly: ExactFloor) -> list[Piece]:
    """The visible pieces of walls, but for those seen edge-on."""
    found = []
    q = exact(seen.viewpoint)
    for i in range(len(seen.walls)):
        wall = int(seen.walls[i])
        if wall == WINDOW or turn(*exactly.ends(wall), q) == 0:
            continue
        j = (i + 1) % len(seen.walls)
        parts = []
        for k, vertex_part in ((i, 0), (j, 1)):
            if seen.vertices[k] == HIT:
                assert seen.hit_walls[k] == wall
                parts.append(exact_part(exactly, q, int(seen.through[k]), wall))
                assert float(parts[-1]) == pytest.approx(seen.parameters[k], abs=1e-6)
            else:
                assert seen.vertices[k] == exactly.walls[wall][vertex_part]
                parts.append(Fraction(vertex_part))
        found.append(Piece(wall, *parts))
    return found


def exact_part(exactly: ExactFloor, q, through: int, wall: int) -> Fraction:
    return exactly._hit(q, minus(exactly.vertices[through], q), wall)


def check(rings, floor: Triangulation, x: float, y: float) -> None:
    exactly = ExactFloor(rings)
    q = exact((x, y))
    seen = visibility_polygon(floor, x, y)
    expected = exactly.visible_pieces(q)
    assert (seen.place != OUTSIDE) == exactly.contains(q)
    if seen.place == OUTSIDE:
        assert len(seen.corners) == 0
        return
    found = pieces_of(seen, exactly)
    first = expected.index(found[0])
    assert found == expected[first:] + expected[:first]
    assert seen.area == pytest.approx(float(exactly.visible_area(q)), rel=1e-9, abs=1e-12)
    check_sides(exactly, floor, seen)


def corner_point(exactly: ExactFloor, q, seen: VisibilityPolygon, k: int):
    if seen.vertices[k] != HIT:
        return exactly.vertices[seen.vertices[k]]
    wall = int(seen.hit_walls[k])
    return exactly.point_on(wall, exact_part(exactly, q, int(seen.through[k]), wall))


def check_sides(exactly: ExactFloor, floor: Triangulation, seen: VisibilityPolygon) -> None:
    """Windows are radial, hide what they say, and meet no vertex on the way."""
    q = exact(seen.viewpoint)
    windows = find_windows(floor, seen)
    corners = [corner_point(exactly, q, seen, k) for k in range(len(seen.walls))]
    for k, corner in enumerate(corners):
        assert k % 3 or exactly.sees(q, corner)
        assert [float(c) for c in corner] == pytest.approx(seen.corners[k].tolist(), abs=1e-6)
        # Star-shaped: counter-clockwise around the viewpoint.
        assert turn(q, corner, corners[(k + 1) % len(corners)]) >= 0
    for i, side in enumerate(windows.sides.tolist()[:5]):
        ends = [corners[side], corners[(side + 1) % len(corners)]]
        near, far = ends if windows.hidden_right[i] else ends[::-1]
        assert turn(q, near, far) == 0
        assert exactly.vertices[windows.near[i]] == near
        distance = [sum(c * c for c in minus(p, q)) for p in (near, far)]
        assert 0 < distance[0] < distance[1]
        if windows.far_vertices[i] != HIT:
            assert exactly.vertices[windows.far_vertices[i]] == far
        parts = exactly.meetings(near, far)
        assert parts == [0, 1]
        # A hair to the hidden side is hidden, a hair to the other side is seen.
        middle = ((near[0] + far[0]) / 2, (near[1] + far[1]) / 2)
        d = minus(far, near)
        out = (d[1], -d[0]) if windows.hidden_right[i] else (-d[1], d[0])
        hair = Fraction(1, 2**200)
        assert not exactly.sees(q, (middle[0] + hair * out[0], middle[1] + hair * out[1]))
        assert exactly.sees(q, (middle[0] - hair * out[0], middle[1] - hair * out[1]))


@settings(max_examples=60, deadline=None)
@given(st.one_of(floors, jittered_floors()), st.integers(0, 2**32 - 1))
@example(RING, 0)
@example(ROOMS, 1)
def test_what_is_seen_is_exactly_what_the_twin_sees(rings, seed: int) -> None:
    floor = floor_of(rings)
    for x, y in viewpoints(rings, 2, np.random.default_rng(seed)):
        check(rings, floor, x, y)


@settings(max_examples=12, deadline=None)
@given(floors)
def test_every_vertex_as_a_viewpoint(rings) -> None:
    floor = floor_of(rings)
    for ring in rings:
        for x, y in ring[:2]:
            check(rings, floor, x, y)


# Against CGAL


@settings(max_examples=60, deadline=None)
@given(st.one_of(floors, jittered_floors()), st.integers(0, 2**32 - 1))
def test_cgal_sees_the_same(rings, seed: int) -> None:
    cgal = pytest.importorskip("pyvispoly", reason="needs the optional oracle pyvispoly (GPL)")
    polygon = cgal.PolygonWithHoles(
        [cgal.Point(*p) for p in rings[0]], [[cgal.Point(*p) for p in r] for r in rings[1:]]
    )
    oracle = cgal.VisibilityPolygonCalculator(polygon)
    floor = floor_of(rings)
    for x, y in viewpoints(rings, 6, np.random.default_rng(seed)):
        seen = visibility_polygon(floor, x, y)
        if seen.place == OUTSIDE:
            continue
        area = float(oracle.compute_visibility_polygon(cgal.Point(x, y)).area())
        assert seen.area == pytest.approx(area, rel=1e-9)
