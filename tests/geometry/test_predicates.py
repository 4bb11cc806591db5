"""Exact signs against rational numbers, on points that are nearly or exactly on a line."""

from fractions import Fraction

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.geometry.expansions import grow, sign_of, two_product, two_sum
from conav.geometry.predicates import (
    GREATEST,
    LEAST,
    direction_turn,
    orientation,
    orientation_expansion,
    orientation_products,
    surely_in_circle,
)

sizes = st.floats(LEAST, GREATEST)
numbers = st.one_of(
    st.just(0.0),
    st.integers(-4, 4).map(float),
    st.floats(-10, 10).map(lambda x: x if abs(x) >= LEAST else 0.0),
    sizes,
    sizes.map(lambda x: -x),
)


def sign(value) -> int:
    return (value > 0) - (value < 0)


def rational_orientation(a, b, c) -> Fraction:
    (ax, ay), (bx, by), (cx, cy) = (map(Fraction, p) for p in (a, b, c))
    return (ax - cx) * (by - cy) - (ay - cy) * (bx - cx)


def nudged(value: float, steps: int) -> float:
    """Some floats further."""
    for _ in range(abs(steps)):
        value = float(np.nextafter(value, np.inf if steps > 0 else -np.inf))
    return value


@st.composite
def nearly_collinear(draw):
    """Three points on a line, but for roundings and a few units in the last place."""
    place = st.floats(-100, 100)
    ax, ay, dx, dy = (draw(place) for _ in range(4))
    s, t = draw(st.floats(-3, 3)), draw(st.floats(-3, 3))
    steps = st.integers(-2, 2)
    points = [(ax, ay), (ax + s * dx, ay + s * dy), (ax + t * dx, ay + t * dy)]
    points = [(nudged(x, draw(steps)), nudged(y, draw(steps))) for x, y in points]
    return [tuple(v if abs(v) >= LEAST else 0.0 for v in point) for point in points]


@settings(deadline=None)
@given(numbers, numbers)
def test_sums_and_products_lose_nothing(a: float, b: float) -> None:
    total, rest = two_sum(a, b)
    assert total == a + b
    assert Fraction(total) + Fraction(rest) == Fraction(a) + Fraction(b)
    product, lost = two_product(a, b)
    assert product == a * b
    assert Fraction(product) + Fraction(lost) == Fraction(a) * Fraction(b)


@settings(deadline=None)
@given(st.lists(numbers, min_size=1, max_size=20))
def test_a_grown_expansion_is_the_exact_sum(values: list[float]) -> None:
    expansion = np.empty(len(values))
    count = 0
    for value in values:
        count = grow(expansion, count, value)
    total = sum(map(Fraction, values))
    assert sum((Fraction(float(x)) for x in expansion[:count]), Fraction(0)) == total
    assert sign_of(expansion, count) == sign(total)
    assert np.all(expansion[:count] != 0)


@settings(max_examples=500, deadline=None)
@given(st.one_of(nearly_collinear(), st.lists(st.tuples(numbers, numbers), min_size=3, max_size=3)))
def test_orientation_is_exact(points) -> None:
    a, b, c = points
    value = rational_orientation(a, b, c)
    assert orientation(*a, *b, *c) == sign(value)
    assert orientation(*b, *a, *c) == -sign(value)
    assert orientation(*b, *c, *a) == sign(value)
    out = np.empty(12)
    count = orientation_expansion(out, *a, *b, *c)
    assert sum((Fraction(float(x)) for x in out[:count]), Fraction(0)) == value


def test_orientation_where_the_filter_cannot_tell() -> None:
    # Shewchuk's picture: points around (0.5, 0.5) in steps of 2^-53 against a long diagonal.
    step = 2.0**-53
    for i in range(24):
        for j in range(24):
            a = (0.5 + i * step, 0.5 + j * step)
            expected = sign(rational_orientation(a, (12.0, 12.0), (24.0, 24.0)))
            assert orientation(*a, 12.0, 12.0, 24.0, 24.0) == expected
    # Rounded differences, and an answer 2^-105 in size.
    tiny = 2.0**-60
    assert orientation(0.0, 0.0, 1.0, 1.0, tiny, tiny) == 0
    assert orientation(tiny, 0.0, 1.0, 1.0, -tiny, 0.0) == sign(
        rational_orientation((tiny, 0.0), (1.0, 1.0), (-tiny, 0.0))
    )


@settings(max_examples=300, deadline=None)
@given(
    st.lists(nearly_collinear(), min_size=2, max_size=3),
    st.lists(st.tuples(*[st.integers(0, 5)] * 3), min_size=4, max_size=4),
)
def test_products_of_orientations_are_exact(groups, rows) -> None:
    points = np.array([point for group in groups for point in group])
    a, b, c, d = rows

    def value(row):
        return rational_orientation(*(tuple(points[k].tolist()) for k in row))

    expected = sign(value(a) * value(b) - value(c) * value(d))
    assert orientation_products(points, a, b, c, d) == expected


@settings(max_examples=300, deadline=None)
@given(st.lists(nearly_collinear(), min_size=2, max_size=2), st.permutations(range(6)))
def test_turns_between_directions_are_exact(groups, rows) -> None:
    points = np.array([point for group in groups for point in group])
    a, b, c, d = rows[:4]
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = (
        (Fraction(float(x)), Fraction(float(y))) for x, y in points[rows[:4]]
    )
    expected = sign((bx - ax) * (dy - cy) - (by - ay) * (dx - cx))
    assert direction_turn(points, a, b, c, d) == expected
    assert direction_turn(points, c, d, a, b) == -expected


def test_products_that_are_equal() -> None:
    points = np.array([(0.1, 0.2), (0.7, 0.3), (0.4, 0.9), (1.1, -0.3), (0.3, 0.3), (0.6, 0.1)])
    a, b = (0, 1, 2), (3, 4, 5)
    assert orientation_products(points, a, b, b, a) == 0
    assert orientation_products(points, a, b, b, (1, 0, 2)) != 0


@settings(deadline=None)
@given(st.lists(st.tuples(*[st.integers(-6, 6).map(float)] * 2), min_size=4, max_size=4))
def test_in_circle_says_yes_only_where_it_is_so(points) -> None:
    a, b, c, d = points
    if rational_orientation(a, b, c) <= 0:
        return
    rows = [[Fraction(x - d[0]), Fraction(y - d[1])] for x, y in (a, b, c)]
    rows = [(x, y, x * x + y * y) for x, y in rows]
    (a0, a1, a2), (b0, b1, b2), (c0, c1, c2) = rows
    value = a2 * (b0 * c1 - b1 * c0) - b2 * (a0 * c1 - a1 * c0) + c2 * (a0 * b1 - a1 * b0)
    # On small integers the filter is never in doubt but at zero.
    assert surely_in_circle(*a, *b, *c, *d) == (value > 0)
