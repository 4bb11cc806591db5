"""Cells of several views: by hand, against single views, exact sight, and overlays of polygons."""

from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.geometry.hidden_regions import hidden_regions, region_border
from conav.geometry.point_grid import OUTSIDE
from conav.geometry.triangulation import triangulate
from conav.geometry.view_cells import cell_border, join_cells, shadows, view_cells
from conav.geometry.visibility import visibility_polygon
from exact_floor import ExactFloor, exact
from floor_shapes import L_SHAPE, RING, ROOMS, area, floors, jittered_floors, viewpoints


def floor_of(rings):
    return triangulate(
        [point for ring in rings for point in ring], np.cumsum([0] + [len(r) for r in rings])
    )


def part(rings, points):
    floor = floor_of(rings)
    views = [visibility_polygon(floor, *point) for point in points]
    return floor, views, view_cells(floor, views)


def by_views(cells) -> dict[int, float]:
    """The area seen by each set of views."""
    total: dict[int, float] = {}
    for views, size in zip(cells.seen_by.tolist(), cells.areas.tolist(), strict=True):
        total[views] = total.get(views, 0.0) + size
    return total


def shadow_areas(cells) -> list[float]:
    labels = shadows(cells)
    return sorted(
        float(cells.areas[labels == label].sum()) for label in range(int(labels.max()) + 1)
    )


# By hand


def test_two_arms_of_an_l() -> None:
    _, _, cells = part(L_SHAPE, [(2, 1), (1, 2)])
    assert by_views(cells) == {1: 1.0, 2: 1.0, 3: 1.0}
    assert shadow_areas(cells) == []


def test_two_robots_on_either_side_of_a_hole() -> None:
    _, _, cells = part(RING, [(1, 5), (9, 5)])
    # From (1, 5) the rays by the hole's corners (4, 4), (4, 6) end at (10, 2), (10, 8); from the
    # other side alike. They cross at x = 5, one third above the hole.
    assert shadow_areas(cells) == [pytest.approx(1 / 3), pytest.approx(1 / 3)]
    assert by_views(cells)[3] == pytest.approx(96 - 2 * 20 + 2 / 3)


def test_one_robot_alone_has_the_regions_of_its_polygon() -> None:
    floor, views, cells = part(ROOMS, [(12, 0)])
    hidden = hidden_regions(floor, views[0])
    assert len(shadow_areas(cells)) == hidden.n_regions
    assert by_views(cells)[1] == pytest.approx(views[0].area)


def test_nobody_and_everybody() -> None:
    _, _, cells = part(RING, [])
    assert by_views(cells) == {0: 96.0}
    _, _, cells = part([[(0, 0), (4, 0), (4, 3), (0, 3)]], [(1, 1), (2, 2), (7, 7)])
    assert (cells.n_cells, by_views(cells)) == (1, {3: 12.0})
    _, _, cells = part(RING, [(5, 5)])  # in the hole
    assert by_views(cells) == {0: 96.0}
    with pytest.raises(InputError, match="62"):
        part(L_SHAPE, [(0.5, 0.5)] * 63)


def test_the_same_place_twice_and_views_along_one_line() -> None:
    _, _, cells = part(RING, [(1, 1), (1, 1), (2, 2)])
    assert set(by_views(cells)) <= {0, 4, 3, 7}
    # Three on the lower line of the hole: their windows by its far corner are one.
    _, views, cells = part(RING, [(1, 4), (2, 4), (3, 4)])
    assert by_views(cells)[7] + by_views(cells)[0] <= 96
    for i, view in enumerate(views):
        seen = sum(size for views_, size in by_views(cells).items() if views_ >> i & 1)
        assert seen == pytest.approx(view.area)


def test_windows_of_three_robots_through_one_point() -> None:
    # Three posts, each robot's ray by its post goes through (5, 5).
    rings = [
        [(0, 0), (10, 0), (10, 10), (0, 10)],
        [(3, 5), (2.5, 5.5), (3, 6)],
        [(5, 3), (4.5, 2.5), (4, 3)],
        [(7, 7), (7.5, 7), (7.25, 6.5)],
    ]
    _, views, cells = part(rings, [(1, 5), (5, 1), (9, 9)])
    assert cells.areas.sum() == pytest.approx(sum(area(ring) for ring in rings))
    for i, view in enumerate(views):
        seen = sum(size for views_, size in by_views(cells).items() if views_ >> i & 1)
        assert seen == pytest.approx(view.area)


def test_a_shadow_between_two_views_that_do_not_meet() -> None:
    # A shutter of four bars around one robot, another robot in a corner niche: the shadow between
    # them has two borders.
    blades = [[(-4, -6), (-4, -5), (9, -5), (9, -6)]]
    for _ in range(3):
        blades.append([(-y, x) for x, y in blades[-1]])
    outer = [(-20, -20), (20, -20), (20, 18), (20, 20), (18, 20), (-20, 20)]
    rings = [outer, *blades, [(17, 12), (12, 17), (13, 18), (18, 13)]]
    floor, _, cells = part(rings, [(0, 0), (18, 18)])
    assert len(shadow_areas(cells)) >= 1
    total = sum(area(ring) for ring in rings)
    assert cells.areas.sum() == pytest.approx(total)
    assert max(shadow_areas(cells)) > 0.5 * total
    border_sum = sum(area(cell_border(floor, cells, k)) for k in range(cells.n_cells))
    assert border_sum == pytest.approx(total)


# For any floor and any views


def check(rings, points) -> None:
    floor, views, cells = part(rings, points)
    whole = float(ExactFloor(rings).area())
    assert cells.areas.sum() == pytest.approx(whole, rel=1e-9)
    assert (cells.areas > -1e-9 * whole).all()
    # Each view's cells make up its polygon; each piece of window parts what it should.
    for i, view in enumerate(views):
        seen = cells.areas[cells.seen_by >> i & 1 == 1].sum()
        assert seen == pytest.approx(view.area, rel=1e-9, abs=1e-9 * whole)
    changed = cells.seen_by[cells.left] ^ cells.seen_by[cells.right]
    assert np.array_equal(changed, cells.changes)
    # Every half-edge is on one border, and the border's area is the cell's.
    assert sorted(cells.following.tolist()) == list(range(len(cells.following)))
    for k in range(cells.n_cells):
        border = cell_border(floor, cells, k)
        assert area(border) == pytest.approx(cells.areas[k], abs=1e-9 * whole)
    # Euler: the cells are the faces of a connected planar graph, but for the outer face of it.
    if len(cells.left):
        solids = len(rings)  # outside and each hole
        edges = len(cells.following) - len(cells.left)
        assert len(cells.node_points) - edges + cells.n_cells + solids == 2
    # The shadows of one view alone are its hidden regions.
    for view in views[:1]:
        if view.place != OUTSIDE:
            hidden = hidden_regions(floor, view)
            alone = view_cells(floor, [view])
            sizes = [
                sum(area(ring) for ring in region_border(floor, hidden, region))
                for region in range(hidden.n_regions)
            ]
            assert shadow_areas(alone) == pytest.approx(sorted(sizes), abs=1e-9 * whole)


@settings(max_examples=150, deadline=None)
@given(st.one_of(floors, jittered_floors()), st.integers(1, 4), st.integers(0, 2**32 - 1))
@example(ROOMS, 4, 0)
def test_cells_fill_the_floor_and_make_up_the_views(rings, count: int, seed: int) -> None:
    check(rings, viewpoints(rings, count, np.random.default_rng(seed)))


@settings(max_examples=60, deadline=None)
@given(floors, st.integers(0, 2**32 - 1))
def test_viewpoints_at_vertices(rings, seed: int) -> None:
    rng = np.random.default_rng(seed)
    every = [point for ring in rings for point in ring]
    check(rings, [every[k] for k in rng.integers(len(every), size=3)])


@settings(max_examples=40, deadline=None)
@given(st.one_of(floors, jittered_floors()), st.integers(0, 2**32 - 1))
def test_cells_are_seen_by_whom_the_twin_says(rings, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = viewpoints(rings, 3, rng)
    floor, _, cells = part(rings, points)
    exactly = ExactFloor(rings)
    borders = [cell_border(floor, cells, k) for k in range(cells.n_cells)]
    labels = shadows(cells)
    hidden = []
    for x, y in viewpoints(rings, 12, rng):
        inside_of = [k for k, border in enumerate(borders) if depth(border, (x, y)) > 1e-9]
        if len(inside_of) != 1:
            continue
        p = exact((x, y))
        seen = sum(1 << i for i, q in enumerate(points) if exactly.sees(exact(q), p))
        assert cells.seen_by[inside_of[0]] == seen
        if seen == 0:
            hidden.append((p, labels[inside_of[0]]))
    # A straight way that is hidden from all stays in its shadow.
    for i in range(len(hidden)):
        for j in range(i):
            if hidden[i][1] != hidden[j][1]:
                assert not is_hidden_way(exactly, points, hidden[i][0], hidden[j][0])


def is_hidden_way(exactly: ExactFloor, points, a, b) -> bool:
    if a == b or not exactly.sees(a, b):
        return False
    d = (b[0] - a[0], b[1] - a[1])
    for q in map(exact, points):
        parts = {0, 1}
        for v in exactly.vertices:
            e = (v[0] - q[0], v[1] - q[1])
            determinant = d[0] * e[1] - d[1] * e[0]
            if determinant:
                t = ((q[0] - a[0]) * e[1] - (q[1] - a[1]) * e[0]) / determinant
                if 0 < t < 1:
                    parts.add(t)
        ordered = sorted(parts)
        ordered += [(s + t) / 2 for s, t in pairwise(ordered)]
        if any(exactly.sees(q, (a[0] + t * d[0], a[1] + t * d[1])) for t in ordered):
            return False
    return True


def depth(ring: np.ndarray, point) -> float:
    """The distance to the border of a ring, negative outside it."""
    ends = np.roll(ring, -1, axis=0)
    along = ends - ring
    square = np.maximum((along**2).sum(axis=1), 1e-300)
    where = np.clip(((point - ring) * along).sum(axis=1) / square, 0, 1)
    away = float(np.hypot(*(ring + where[:, None] * along - point).T).min())
    x, y = point
    inside = False
    for (ax, ay), (bx, by) in zip(ring.tolist(), ends.tolist(), strict=True):
        if (ay > y) != (by > y):
            inside ^= ax + (y - ay) * (bx - ax) / (by - ay) > x
    return away if inside else -away


@settings(max_examples=60, deadline=None)
@given(floors, st.integers(2, 4), st.integers(0, 2**32 - 1))
def test_shadows_are_what_an_overlay_leaves(rings, count: int, seed: int) -> None:
    points = viewpoints(rings, count, np.random.default_rng(seed))
    _, views, cells = part(rings, points)
    left = shapely.Polygon(rings[0], rings[1:])
    for view in views:
        if len(view.corners):
            polygon = shapely.make_valid(shapely.Polygon(view.corners))
            left = polygons(shapely.difference(left, polygon, grid_size=1e-8))
    sizes = sorted(g.area for g in shapely.get_parts(left) if g.area > 1e-5)
    ours = [size for size in shadow_areas(cells) if size > 1e-5]
    assert ours == pytest.approx(sizes, abs=1e-5)


def polygons(geometry):
    parts = [g for g in shapely.get_parts(geometry) if g.geom_type == "Polygon" and g.area > 0]
    return shapely.MultiPolygon(parts)


def test_other_unions_of_cells() -> None:
    _, _, cells = part(RING, [(1, 5), (9, 5)])
    both = join_cells(cells, cells.seen_by == 3)
    assert both.max() == 1  # above and below the hole
    everything = join_cells(cells, np.ones(cells.n_cells, np.bool_))
    assert (everything == 0).all()


def test_a_move_links_shadows_before_and_after() -> None:
    # Along the corridor of the comb-like rooms: each room is a shadow, and stays apart on the way.
    floor, _, cells = part(ROOMS, [(10, 1), (14, 1)])
    before = join_cells(cells, cells.seen_by & 1 == 0)
    after = join_cells(cells, cells.seen_by & 2 == 0)
    linked = join_cells(cells, cells.seen_by != 3)
    links = {
        (int(b), int(a))
        for c in range(linked.max() + 1)
        for b in before[(linked == c) & (before >= 0)]
        for a in after[(linked == c) & (after >= 0)]
    }
    areas_before = [cells.areas[before == k].sum() for k in range(before.max() + 1)]
    assert len(areas_before) >= 3
    # The rooms at either end link with themselves only.
    ends = [
        {
            int(labels[k])
            for k in range(cells.n_cells)
            if depth(cell_border(floor, cells, k), (x, 8.75)) > 0
        }
        for x in (1.25, 22.75)
        for labels in (before, after)
    ]
    for b, a in (ends[:2], ends[2:]):
        assert len(b) == len(a) == 1
        assert {link for link in links if link[0] in b} == {(*b, *a)}
        assert {link for link in links if link[1] in a} == {(*b, *a)}
