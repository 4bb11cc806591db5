"""Floors between walls."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.planning.floor import WELD_M, floor_between
from conav.planning.types import PlanningRobot

SQUARE = [(0, 0), (8, 0), (8, 8), (0, 8)]


def box(x: float, y: float, w: float = 1.0, h: float = 1.0) -> list[tuple[float, float]]:
    return [(x, y), (x + w, y), (x + w, y + h), (x, y + h)]


def robot(name: str, x: float, y: float) -> PlanningRobot:
    return PlanningRobot(name, (x, y), "true", {})


def test_walls_are_taken_out() -> None:
    floor = floor_between(SQUARE[::-1], walls=[box(2, 2), box(4, 4, 2, 9), box(4.5, 4, 1, 1)])
    assert floor.area == 64 - 1 - 8
    assert len(floor.holes) == 1


def test_rings_are_kept_as_they_are_without_walls() -> None:
    straight = [(0, 0), (0, 4), (0, 8), (8, 8), (8, 0)]  # clockwise, with a point on a wall
    floor = floor_between(straight, [box(1, 1)])
    assert floor.outer.tolist() == [list(point) for point in straight[::-1]]
    assert floor.holes[0].tolist() == [[1, 2], [2, 2], [2, 1], [1, 1]]


def test_walls_that_touch_in_a_point_are_joined() -> None:
    floor = floor_between(SQUARE, walls=[box(2, 2), box(3, 3)])
    assert len(floor.holes) == 1
    assert floor.area == pytest.approx(62, abs=10 * WELD_M)


def test_a_wall_that_touches_the_outline_in_a_point_is_joined_to_it() -> None:
    diamond = [(1, 3), (2, 2), (3, 3), (2, 4)]
    for turn in range(4):
        wall = np.array(diamond, dtype=np.float64) + np.array([-1.0, 2.0])
        wall = wall - 4
        for _ in range(turn):
            wall = np.column_stack([-wall[:, 1], wall[:, 0]])
        floor = floor_between(SQUARE, walls=[wall + 4])
        assert len(floor.holes) == 0
        assert floor.area == pytest.approx(62, abs=10 * WELD_M)


def test_of_several_parts_it_is_the_one_robots_start_in() -> None:
    wall = box(5, 0, 1, 8)
    assert floor_between(SQUARE, walls=[wall]).area == 40
    assert floor_between(SQUARE, walls=[wall], robots=[robot("a", 7, 1)]).area == 16
    in_wall = [robot("a", 5.5, 1)]
    assert floor_between(SQUARE, walls=[wall], robots=in_wall).area == 40
    with pytest.raises(InputError, match="a and c start on parts of the floor that no way joins"):
        floor_between(
            SQUARE, walls=[wall], robots=[robot("a", 1, 1), robot("b", 2, 2), robot("c", 7, 7)]
        )


def test_faults_have_places() -> None:
    with pytest.raises(InputError, match=r"yard: walls\[1\]: is no polygon"):
        floor_between(SQUARE, walls=[box(1, 1), [(0, 0), (1, 1), (1, 0), (0, 1)]], name="yard")
    with pytest.raises(InputError, match="leave nothing"):
        floor_between(SQUARE, walls=[box(-1, -1, 10, 10)])


cells = st.sets(st.tuples(st.integers(0, 7), st.integers(0, 7)), min_size=1, max_size=40)


@settings(max_examples=150, deadline=None)
@given(blocked=cells)
def test_any_cells_leave_a_floor_of_rings_that_do_not_touch(
    blocked: set[tuple[int, int]],
) -> None:
    # `PolygonMap` itself refuses rings that touch; the largest part is counted cell by cell.
    free = {(x, y) for x in range(8) for y in range(8)} - blocked
    sizes: list[int] = []
    while free:
        group, rim = set[tuple[int, int]](), [free.pop()]
        while rim:
            x, y = rim.pop()
            group.add((x, y))
            for near in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
                if near in free:
                    free.remove(near)
                    rim.append(near)
        sizes.append(len(group))
    floor = floor_between(SQUARE, walls=[box(x, y) for x, y in blocked])
    assert floor.area == pytest.approx(max(sizes), abs=100 * WELD_M)


@settings(max_examples=60, deadline=None)
@given(
    corners=st.lists(
        st.tuples(st.integers(-1, 8), st.integers(-1, 8), st.integers(1, 3)), min_size=1, max_size=8
    )
)
def test_turned_squares_that_touch_edges_leave_a_floor_too(
    corners: list[tuple[int, int, int]],
) -> None:
    walls = [[(x, y - r), (x + r, y), (x, y + r), (x - r, y)] for x, y, r in corners]
    left = shapely.difference(
        shapely.Polygon(SQUARE), shapely.union_all([shapely.Polygon(wall) for wall in walls])
    )
    if left.area == 0:
        return
    floor = floor_between(SQUARE, walls=walls)
    largest = max(part.area for part in shapely.get_parts(left))
    assert floor.area == pytest.approx(largest, abs=1e-3)
