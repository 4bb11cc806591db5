"""Rings with faults, and what is made of them."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.maps.repair_polygon import GAP_M, floor_of_parts, repair_polygon_map

SQUARE = [(0, 0), (10, 0), (10, 10), (0, 10)]
CW = "turned round, so that outer runs counter-clockwise and holes clockwise: "


def test_rings_without_fault_stay_as_they_are():
    plan = repair_polygon_map(SQUARE, [[(2, 2), (2, 4), (4, 4)]], name="a")
    assert plan.warnings == ()
    assert plan.outer.tolist() == [list(map(float, p)) for p in SQUARE]
    assert plan.name == "a"


@pytest.mark.parametrize(
    ("outer", "holes", "area", "counts", "words"),
    [
        # repeated and nearly repeated points, a closed ring
        ([*SQUARE, (0, 0)], [], 100, (4, 0), ["left out 1 point repeating the one before (outer)"]),
        (
            [(0, 0), (0, 0), (10, 0), (10 + 1e-12, 1e-12), (10, 10), (0, 10), (0, 1e-13)],
            [],
            100,
            (4, 0),
            ["left out 3 points repeating the one before (outer)"],
        ),
        # spikes, one on another
        (
            [(0, 0), (10, 0), (15, 0), (10, 0), (10, 10), (0, 10)],
            [],
            100,
            (4, 0),
            ["left out 2 points where a wall runs back on itself (outer)"],
        ),
        (
            [(0, 0), (10, 0), (10, 10), (5, 10), (5, 15), (7, 15), (5, 15), (5, 10), (0, 10)],
            [],
            100,
            (5, 0),
            ["left out 4 points where a wall runs back on itself (outer)"],
        ),
        # orientation
        (SQUARE[::-1], [], 100, (4, 0), [CW + "outer"]),
        (SQUARE, [[(2, 2), (4, 2), (4, 4)]], 98, (4, 1), [CW + "holes[0]"]),
        # holes: without area, outside, inside another, overlapping, over the border
        (SQUARE, [[(2, 2), (4, 2), (3, 2)]], 100, (4, 0), ["holes[0]: left out, it has no area"]),
        (
            SQUARE,
            [[(12, 2), (12, 4), (14, 4)]],
            100,
            (4, 0),
            ["holes[0]: left out, it lies outside the floor"],
        ),
        (
            SQUARE,
            [[(2, 2), (2, 8), (8, 8), (8, 2)], [(3, 3), (3, 5), (5, 5)]],
            64,
            (4, 1),
            ["holes[1]: left out, it lies outside the floor"],
        ),
        (
            SQUARE,
            [[(2, 2), (2, 5), (5, 5), (5, 2)], [(4, 4), (4, 7), (7, 7), (7, 4)]],
            100 - 17,
            (4, 1),
            ["holes[1]: touches the walls round the floor and reaches out of it"],
        ),
        (
            SQUARE,
            [[(-1, 2), (-1, 4), (3, 4), (3, 2)]],
            94,
            (8, 0),
            ["holes[0]: touches the walls round the floor and reaches out of it"],
        ),
        # a hole along a wall becomes part of it
        (
            SQUARE,
            [[(0, 2), (0, 4), (3, 4), (3, 2)]],
            94,
            (8, 0),
            ["holes[0]: touches the walls round the floor"],
        ),
    ],
)
def test_repairs(outer, holes, area, counts, words):
    plan = repair_polygon_map(outer, holes)
    assert plan.area == pytest.approx(area)
    assert (len(plan.outer), len(plan.holes)) == counts
    assert list(plan.warnings) == words


def test_a_hole_that_touches_a_wall_in_a_point_leaves_a_gap():
    touching = [(0, 3), (2, 4), (2, 2)]
    plan = repair_polygon_map(SQUARE, [touching])
    assert len(plan.holes) == 1
    assert plan.area == pytest.approx(98, abs=1e-6)
    assert plan.warnings[-1].startswith("walls touch at (0, 3); the point was widened")
    floor = plan.polygon
    assert floor.distance(shapely.Point(0, 3)) == 0
    assert 0 < shapely.LinearRing(plan.holes[0]).distance(floor.exterior) <= GAP_M
    closed = repair_polygon_map(SQUARE, [touching], close_touching=True)
    assert (len(closed.holes), len(closed.outer)) == (0, 10)
    assert closed.area == pytest.approx(98, abs=1e-6)
    assert closed.warnings[-1].endswith("the point was closed")


def test_rooms_joined_in_a_point_stay_joined_for_a_point():
    pinch = [(0, 0), (4, 0), (2, 2), (4, 4), (0, 4), (2, 2)]
    plan = repair_polygon_map(pinch)
    assert plan.contains([(2, 1), (2, 2), (2, 3)]).all()
    assert plan.area == pytest.approx(8, abs=1e-6)
    with pytest.raises(InputError, match="falls into 2 pieces"):
        repair_polygon_map(pinch, close_touching=True)


def test_a_ring_that_crosses_itself():
    small = [(0, 0), (10, 0), (10, 10), (-0.1, 10), (0.1, 10.2), (0.0, 10.2)]
    plan = repair_polygon_map(small)
    assert plan.warnings[0].startswith("outer: meets itself at (0, 10)")
    assert plan.warnings[1].startswith("left out loops behind crossings, 0.0")
    assert plan.area == pytest.approx(100, rel=0.01)
    with pytest.raises(InputError, match="crosses itself: 4 m2 lie to one side of it and 4 m2"):
        repair_polygon_map([(0, 0), (4, 0), (0, 4), (4, 4)])


def test_a_ring_that_laps_over_itself_is_not_holed():
    lap = [(0, 0), (10, 0), (10, 10), (2, 10), (2, 2), (4, 2), (4, 4), (0, 4)]
    plan = repair_polygon_map(lap)
    assert plan.contains((3, 3))
    assert plan.warnings[0].startswith("outer: meets itself at (2, 4)")


@pytest.mark.parametrize(
    ("outer", "words"),
    [
        ([(0, 0), (1, 0)], r"outer: has the shape \(2, 2\)"),
        ([(0, 0), (1, 0), ("a", 2)], "outer: holds something that is no number"),
        ([(0, 0), (1, 0), (2, float("inf"))], r"outer: point 2 is \(2, inf\)"),
        ([(0, 0), (1, 0), (2, 0)], "outer: has no area"),
        ([(0, 0), (0, 0), (0, 0)], "outer: has no area"),
    ],
)
def test_beyond_repair(outer, words):
    with pytest.raises(InputError, match=words):
        repair_polygon_map(outer, name="plan")


def test_everything_a_hole():
    with pytest.raises(InputError, match="has no area"):
        repair_polygon_map(SQUARE, [[(-1, -1), (-1, 11), (11, 11), (11, -1)]])


def test_several_outer_rings():
    small = [(20, 0), (24, 0), (24, 4), (20, 4)]
    plan = floor_of_parts([[small], [SQUARE]])
    assert plan.area == 100
    assert plan.warnings == (
        "took part 1, 100 m2, the largest of 2 outer rings; the others have 16 m2 together; name"
        " one to take it instead",
    )
    named = floor_of_parts([[small], [SQUARE]], part=0)
    assert (named.area, named.warnings) == (16, ())
    with pytest.raises(InputError, match="part 2: there are 2; give 0 to 1"):
        floor_of_parts([[small], [SQUARE]], part=2)
    with pytest.raises(InputError, match="has no polygon"):
        floor_of_parts([])


points = st.tuples(st.integers(0, 6), st.integers(0, 6))
rings = st.lists(points, min_size=3, max_size=9)


def repaired(outer, holes, close) -> PolygonMap | str:
    try:
        return repair_polygon_map(outer, holes, close_touching=close)
    except InputError as error:
        return str(error)


@settings(deadline=None, max_examples=150)
@given(rings, st.lists(rings, max_size=2), st.booleans())
def test_any_rings_become_a_plan_or_one_error(outer, holes, close):
    plan = repaired(outer, holes, close)
    if isinstance(plan, str):
        # What cannot be meant, not a repair that went wrong.
        assert any(words in plan for words in ("has no area", "crosses itself", "falls into")), plan
        return
    again = repair_polygon_map(plan.outer, plan.holes)
    assert again.warnings == ()
    assert np.array_equal(again.vertices, plan.vertices)
    if all(len(set(ring)) >= 3 for ring in (outer, *holes)):
        as_given = PolygonMap(plan.outer, plan.holes)
        assert as_given.area == pytest.approx(plan.area)
    # Nothing but gaps is floor that was not inside the outer ring.
    hull = shapely.MultiPoint(outer).convex_hull.buffer(2 * GAP_M)
    assert hull.covers(plan.polygon)
