"""The polygonal floor plan and what it refuses."""

import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap, without_collinear_points
from conav.maps.rings import meeting_edges, orientations

SQUARE = [(0, 0), (10, 0), (10, 10), (0, 10)]
HOLE = [(2, 2), (2, 4), (4, 4), (4, 2)]  # clockwise
OTHER = [(6, 6), (6, 8), (8, 8), (8, 6)]


def test_facts_of_a_square_with_two_holes():
    plan = PolygonMap(SQUARE, [HOLE, OTHER])
    assert plan.area == 100 - 4 - 4
    assert plan.bounds == (0, 0, 10, 10)
    assert plan.ring_starts.tolist() == [0, 4, 8, 12]
    assert plan.vertices.tolist() == [list(map(float, p)) for p in SQUARE + HOLE + OTHER]
    assert plan.segments[3].tolist() == [0, 10, 0, 0]
    assert plan.segments[4].tolist() == [2, 2, 2, 4]
    assert plan.turns.tolist() == [1, 1, 1, 1] + [-1] * 8
    points = [[1, 1], [3, 3], [2, 3], [0, 5], [11, 5], [10, 10]]
    assert plan.contains(points).tolist() == [True, False, True, True, False, True]
    assert plan.contains((1.0, 1.0)).shape == ()


def test_arrays_are_copies_and_locked():
    mine = np.array(SQUARE, dtype=np.float64)
    plan = PolygonMap(mine, [HOLE])
    mine[0] = 5.0
    assert plan.outer[0].tolist() == [0, 0]
    again = pickle.loads(pickle.dumps(plan))
    for each in (plan, again):
        for array in (*each.rings, each.vertices, each.segments, each.ring_starts, each.turns):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0
    assert all(np.array_equal(a, b) for a, b in zip(plan.rings, again.rings, strict=True))


@pytest.mark.parametrize(
    ("outer", "holes", "words"),
    [
        ([(0, 0), (1, 0)], [], "plan: outer: has 2 points"),
        ([(0, 0), (1, 0), (1, 1, 1)], [], "outer: holds something that is no number"),
        ([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], r"outer: has the shape \(3, 3\)"),
        ([(0, 0), (1, 0), (1, float("nan"))], [], r"outer: point 2 is \(1, nan\)"),
        ([(0, 0), (1, 0), (1, 1e300)], [], r"outer: point 2 is \(1, 1e\+300\)"),
        ([*SQUARE, (0, 0)], [], r"outer: the last point repeats the first, \(0, 0\)"),
        ([(0, 0), (0, 0), *SQUARE[1:]], [], r"outer: point 1 repeats the last, \(0, 0\)"),
        (
            [(0, 0), (4, 0), (2, 2), (4, 4), (0, 4), (2, 2)],
            [],
            r"outer: touches itself: points 2 and 5 are both \(2, 2\)",
        ),
        ([(0, 0), (5, 0), (3, 0), (3, 3)], [], r"outer: turns back on itself at point 1, \(5, 0\)"),
        ([(0, 0), (1, 0), (2, 0)], [], "outer: turns back on itself"),
        ([(0, 0), (4, 0), (0, 4), (4, 4)], [], r"outer: edge 1 meets edge 3 at \(2, 2\)"),
        # a point of one wall in the middle of another
        ([(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)], [], r"outer: edge 0 meets edge 2 at \(2, 0\)"),
        (SQUARE[::-1], [], "outer: runs clockwise"),
        (SQUARE, [HOLE[::-1]], r"holes\[0\]: runs counter-clockwise"),
        (SQUARE, [HOLE, [(p[0] + 20, p[1]) for p in HOLE]], r"holes\[1\]: lies outside"),
        (
            SQUARE,
            [[(0, 2), (0, 4), (4, 4)]],
            r"outer: edge 3 meets holes\[0\] edge 0 at \(0, [24]\)",
        ),
        (
            SQUARE,
            [HOLE, [(4, 4), (5, 5), (5, 4)]],
            r"holes\[0\]: edge 1 meets holes\[1\] edge 0 at",
        ),
        (SQUARE, [HOLE, HOLE], r"holes\[0\]: edge 0 meets holes\[1\] edge 0 at \(2, [24]\)"),
        (
            SQUARE,
            [HOLE, [(2.5, 2.5), (2.5, 3), (3, 2.5)]],
            r"holes\[1\]: lies inside holes\[0\] at \(2.5, 2.5\)",
        ),
    ],
)
def test_what_is_refused(outer: list[tuple[float, ...]], holes: list[object], words: str):
    with pytest.raises(InputError, match=words) as caught:
        PolygonMap(outer, holes, name="plan")  # type: ignore[arg-type]
    assert caught.value.remedy


def test_collinear_points_go_and_corners_stay():
    plan = PolygonMap(
        [(0, 0), (1, 0), (2, 0), (10, 0), (10, 10), (5, 10), (0, 10), (0, 0.5)],
        [[(2, 2), (2, 3), (2, 4), (4, 4), (4, 2)]],
    )
    bare = without_collinear_points(plan)
    assert bare.outer.tolist() == [[0, 0], [10, 0], [10, 10], [0, 10]]
    assert bare.holes[0].tolist() == [[2, 2], [2, 4], [4, 4], [4, 2]]
    assert bare.area == plan.area


def test_the_first_point_may_be_collinear():
    plan = PolygonMap([(5, 0), *SQUARE[1:], (0, 0)])
    assert len(without_collinear_points(plan).outer) == 4


numbers = st.one_of(
    st.integers(-3, 3).map(float),
    st.floats(-100, 100, allow_nan=False),
    st.sampled_from([0.1, 0.2, 0.3, 0.1 + 0.2, 1e-17, 1e16, 1e-160, 1 / 3]),
)


@given(st.lists(numbers, min_size=6, max_size=6))
def test_orientation_is_exact(values: list[float]):
    ax, ay, bx, by, cx, cy = (Fraction(value) for value in values)
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    a, b, c = np.array(values).reshape(3, 1, 2)
    assert orientations(a, b, c)[0] == (area > 0) - (area < 0)


def test_orientation_near_a_line_needs_the_exact_part():
    # Points around (0.5, 0.5) one unit in the last place apart, against the line y = x from 12.
    steps = np.arange(16) * 2.0**-53
    x, y = np.meshgrid(0.5 + steps, 0.5 + steps)
    a = np.column_stack((x.ravel(), y.ravel()))
    b, c = np.full_like(a, 12.0), np.full_like(a, 24.0)
    expected = np.sign(a[:, 0] - a[:, 1])  # above the line is to the left of 12 -> 24
    assert (orientations(a, b, c) == -expected).all()


def brute_force_meetings(ring: np.ndarray) -> list[tuple[int, int]]:
    def side(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int]) -> int:
        value = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        return (value > 0) - (value < 0)

    def within(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int]) -> bool:
        return all(min(a[k], b[k]) <= c[k] <= max(a[k], b[k]) for k in (0, 1))

    points = [(int(x), int(y)) for x, y in ring]
    count = len(points)
    edges = [(points[i], points[(i + 1) % count]) for i in range(count)]
    found: list[tuple[int, int]] = []
    for i in range(count):
        for j in range(i + 1, count):
            if j - i in (1, count - 1):
                continue
            (a, b), (c, d) = edges[i], edges[j]
            sides = side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)
            crosses = sides[0] * sides[1] < 0 and sides[2] * sides[3] < 0
            touches = (
                (sides[0] == 0 and within(a, b, c))
                or (sides[1] == 0 and within(a, b, d))
                or (sides[2] == 0 and within(c, d, a))
                or (sides[3] == 0 and within(c, d, b))
            )
            if crosses or touches:
                found.append((i, j))
    return found


points = st.tuples(st.integers(0, 8), st.integers(0, 8))


@given(st.lists(points, min_size=4, max_size=10, unique=True))
def test_meeting_edges_are_those_of_the_definition(ring: list[tuple[int, int]]):
    array = np.array(ring, dtype=np.float64)
    assert [tuple(pair) for pair in meeting_edges([array])] == brute_force_meetings(array)
