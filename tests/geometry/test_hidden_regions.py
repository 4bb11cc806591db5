"""Hidden regions: by hand, by their areas, and by points and ways that the twin finds hidden."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.geometry.hidden_regions import (
    NOT_HIDDEN,
    hidden_regions,
    hidden_rings,
    region_border,
    regions_at,
)
from conav.geometry.point_grid import OUTSIDE
from conav.geometry.triangulation import triangulate
from conav.geometry.visibility import visibility_polygon
from exact_floor import ExactFloor, exact
from floor_shapes import (
    L_SHAPE,
    RING,
    ROOMS,
    area,
    comb,
    floors,
    jittered_floors,
    pillar_floors,
    viewpoints,
)


def floor_of(rings):
    return triangulate(
        [point for ring in rings for point in ring], np.cumsum([0] + [len(r) for r in rings])
    )


def hide(rings, x: float, y: float):
    floor = floor_of(rings)
    return floor, hidden_regions(floor, visibility_polygon(floor, x, y))


def areas(floor, hidden) -> list[float]:
    return [
        sum(area(ring) for ring in region_border(floor, hidden, region))
        for region in range(hidden.n_regions)
    ]


def test_nothing_is_hidden_in_a_convex_room_or_from_off_the_floor() -> None:
    assert hide([[(0, 0), (4, 0), (4, 3), (0, 3)]], 1, 1)[1].n_regions == 0
    floor, hidden = hide(RING, 5, 5)
    assert hidden.n_regions == 0
    assert regions_at(floor, hidden, [(1, 1), (5, 5)]).tolist() == [-1, -1]


def test_one_pocket_behind_a_corner() -> None:
    floor, hidden = hide(L_SHAPE, 2, 1)
    assert areas(floor, hidden) == [1]
    points = [(0.5, 1.5), (0.5, 1), (1, 1), (0.5, 0.5), (0, 2), (3, 3)]
    assert regions_at(floor, hidden, points).tolist() == [0, -1, -1, -1, 0, -1]


def test_behind_a_hole_two_windows_share_a_region() -> None:
    floor, hidden = hide(RING, 1, 5)
    assert hidden.n_regions == 1
    assert (hidden.regions == 0).sum() == 2
    assert areas(floor, hidden) == [pytest.approx(20)]


def test_each_tooth_of_a_comb_hides_its_own_region() -> None:
    floor, hidden = hide(comb(7), 7.5, 0)
    assert hidden.n_regions == 6  # the one straight above is seen
    assert sum(areas(floor, hidden)) == pytest.approx(7 * 5 + 15 - hidden.seen.area)


def test_windows_on_one_ray_part_pockets_that_touch() -> None:
    # From (1, 1), two pillars stand on the line y = 1: one pocket between them, one beyond.
    rings = [
        [(0, 0), (12, 0), (12, 6), (8, 6), (6, 1), (5, 6), (4, 1), (3, 6), (0, 6)],
    ]
    floor, hidden = hide(rings, 1, 1)
    assert hidden.n_regions == 2
    assert regions_at(floor, hidden, [(5, 3), (10, 5)]).tolist() in ([0, 1], [1, 0])


def test_holes_that_nobody_sees_lie_in_a_region() -> None:
    rings = [
        [(0, 0), (20, 0), (20, 9), (0, 9)],
        [(4, 1), (4, 8), (5, 8), (5, 1)],
        [(8, 4), (8, 5), (9, 5), (9, 4)],
        [(1, 1), (1, 2), (2, 2), (2, 1)],
    ]
    floor, hidden = hide(rings, 1, 4.5)
    behind = int(regions_at(floor, hidden, [(7, 4.5)])[0])
    assert behind != NOT_HIDDEN
    assert hidden_rings(floor, hidden).tolist() == [-1, -1, behind, -1]
    assert sum(areas(floor, hidden)) + hidden.seen.area == pytest.approx(180 - 7 - 1 - 1)


def test_a_region_around_the_viewpoint_lies_outside_its_walk() -> None:
    # Four bars like the blades of a shutter: no ray gets between them to the outer walls.
    blades = [[(-4, -6), (-4, -5), (9, -5), (9, -6)]]
    for _ in range(3):
        blades.append([(-y, x) for x, y in blades[-1]])
    rings = [[(-20, -20), (20, -20), (20, 20), (-20, 20)], *blades]
    floor, hidden = hide(rings, 0, 0)
    assert hidden.n_regions == 1
    assert (hidden.regions == 0).sum() == 4
    assert hidden_rings(floor, hidden).tolist() == [0, -1, -1, -1, -1]
    walk, outer = region_border(floor, hidden, 0)
    assert area(walk) < 0
    assert area(walk) + area(outer) + hidden.seen.area == pytest.approx(1600 - 4 * 13)
    assert regions_at(floor, hidden, [(19, 19), (0, 4), (10, 0)]).tolist() == [0, -1, 0]


@settings(max_examples=150, deadline=None)
@given(st.one_of(floors, pillar_floors(), jittered_floors()), st.integers(0, 2**32 - 1))
def test_regions_and_the_polygon_fill_the_floor(rings, seed: int) -> None:
    floor = floor_of(rings)
    for x, y in viewpoints(rings, 4, np.random.default_rng(seed)):
        seen = visibility_polygon(floor, x, y)
        if seen.place == OUTSIDE:
            continue
        hidden = hidden_regions(floor, seen)
        parts = areas(floor, hidden)
        whole = float(ExactFloor(rings).area())
        # Slivers may be smaller than rounding.
        assert all(part > -1e-9 * whole for part in parts)
        assert sum(parts) + seen.area == pytest.approx(whole, rel=1e-9)
        walks = hidden.following[hidden.following >= 0]
        assert sorted(walks.tolist()) == np.flatnonzero(seen.walls < 0).tolist()


@settings(max_examples=25, deadline=None)
@given(st.one_of(floors, jittered_floors()), st.integers(0, 2**32 - 1))
def test_points_joined_by_a_hidden_way_are_in_one_region(rings, seed: int) -> None:
    exactly, floor = ExactFloor(rings), floor_of(rings)
    rng = np.random.default_rng(seed)
    (x, y), *others = viewpoints(rings, 7, rng)
    seen = visibility_polygon(floor, x, y)
    if seen.place == OUTSIDE:
        return
    hidden = hidden_regions(floor, seen)
    found = regions_at(floor, hidden, others).tolist()
    q = exact((x, y))
    for k, point in enumerate(others):
        assert (found[k] == NOT_HIDDEN) == (not exactly.contains(exact(point)) or
                                            exactly.sees(q, exact(point)))  # fmt: skip
    # A straight way that meets no visible piece of floor stays in its region.
    for i in range(len(others)):
        for j in range(i):
            if found[i] >= 0 and found[j] >= 0 and found[i] != found[j]:
                assert not hidden_way(exactly, q, exact(others[i]), exact(others[j]))


def hidden_way(exactly: ExactFloor, q, a, b) -> bool:
    """Whether the segment is on the floor and hidden: it is where lines through q may change it."""
    if a == b or not exactly.sees(a, b):
        return False
    parts = {0, 1}
    d = (b[0] - a[0], b[1] - a[1])
    for v in exactly.vertices:
        e = (v[0] - q[0], v[1] - q[1])
        determinant = d[0] * e[1] - d[1] * e[0]
        if determinant:
            t = ((q[0] - a[0]) * e[1] - (q[1] - a[1]) * e[0]) / determinant
            if 0 < t < 1:
                parts.add(t)
    ordered = sorted(parts)
    middles = [(s + t) / 2 for s, t in pairwise(ordered)]
    return not any(
        exactly.sees(q, (a[0] + t * d[0], a[1] + t * d[1])) for t in [*middles, *ordered]
    )


def test_rooms_are_hidden_apart() -> None:
    floor, hidden = hide(ROOMS, 12, 0)
    labels = regions_at(floor, hidden, [(1.5, 8), (9.5, 8.5), (14.5, 8.5), (22.5, 8)]).tolist()
    assert len(set(labels)) == 4
    assert NOT_HIDDEN not in labels
