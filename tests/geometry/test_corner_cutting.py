"""Cutting corners: the kernel against a plain twin, and what it promises."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from conav.geometry.corner_cutting import cut_corners
from conav.geometry.outline import label_parts, trace_rings
from conav.maps.polygon_map import PolygonMap
from conav.maps.polygonise import is_sound_simplification, simplified

Point = tuple[Fraction, Fraction]


def side(a: Point, b: Point, c: Point) -> Fraction:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def slow_cut(rings: list[NDArray[np.float64]], tolerance: float) -> list[bool]:
    """The same rule with exact numbers, without neighbours' lists or bins."""
    points: list[Point] = [(Fraction(x), Fraction(y)) for ring in rings for x, y in ring]
    starts = np.cumsum([0, *(len(ring) for ring in rings)]).tolist()
    kept = [True] * len(points)

    def next_kept(v: int, start: int, end: int, step: int) -> int:
        while True:
            v = start + (v - start + step) % (end - start)
            if kept[v]:
                return v

    for limit in (tolerance / 8, tolerance / 4, tolerance / 2, tolerance):
        again = True
        while again:
            again = False
            for start, end in pairwise(starts):
                for v in range(start, end):
                    if not kept[v] or sum(kept[start:end]) <= 3:
                        continue
                    a, b = next_kept(v, start, end, -1), next_kept(v, start, end, 1)
                    if side(points[a], points[v], points[b]) <= 0:
                        continue
                    (ax, ay), (bx, by) = points[a], points[b]
                    square = (bx - ax) ** 2 + (by - ay) ** 2
                    chain, i = [], a
                    while (i := start + (i - start + 1) % (end - start)) != b:
                        chain.append(side(points[a], points[b], points[i]))
                    if any(c > 0 or c * c > Fraction(limit) ** 2 * square for c in chain):
                        continue
                    if any(
                        kept[p]
                        and p not in (a, v, b)
                        and side(points[a], points[v], points[p]) >= 0
                        and side(points[v], points[b], points[p]) >= 0
                        and side(points[b], points[a], points[p]) >= 0
                        for p in range(len(points))
                    ):
                        continue
                    kept[v] = False
                    again = True
    return kept


masks = st.tuples(st.integers(1, 8), st.integers(1, 8)).flatmap(
    lambda shape: arrays(np.uint8, shape, elements=st.integers(0, 1))
)


def largest_part(mask: NDArray[np.uint8], open_corners: bool) -> list[NDArray[np.float64]]:
    labels = label_parts(mask, open_corners)
    part = int(np.argmax(np.bincount(labels[labels >= 0])))
    return trace_rings((labels == part).astype(np.uint8), open_corners, 1 / 16)


@settings(deadline=None, max_examples=60)
@given(masks.filter(np.any), st.booleans(), st.sampled_from([0.25, 0.5, 0.75, 1.0, 1.5, 3.0]))
def test_the_kernel_does_what_the_rule_says(
    mask: NDArray[np.uint8], open_corners: bool, tolerance: float
):
    rings = largest_part(mask, open_corners)
    starts = np.cumsum([0, *(len(ring) for ring in rings)], dtype=np.int64)
    kept = cut_corners(np.concatenate(rings), starts, tolerance)
    assert kept.tolist() == slow_cut(rings, tolerance)


@settings(deadline=None)
@given(
    masks.filter(np.any),
    st.booleans(),
    st.sampled_from([0.3, 0.5, 0.8, 1.1, 2.0]),
    st.floats(0, 6.3),
)
def test_what_is_left_lies_inside_and_lacks_nothing_far_from_walls(
    mask: NDArray[np.uint8], open_corners: bool, tolerance: float, angle: float
):
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    rings = [ring @ turn for ring in largest_part(mask, open_corners)]
    exact = PolygonMap(rings[0], rings[1:])
    simple = simplified(exact, tolerance)
    assert is_sound_simplification(exact, simple, tolerance)
    assert simple.area <= exact.area + 1e-12
    assert len(simple.holes) == len(exact.holes)


def test_stairs_become_a_ramp_behind_their_steps():
    steps = 20
    stairs = [(0.0, 0.0), (float(steps), 0.0)]
    for i in range(steps):
        stairs += [(float(steps - i), i + 1.0), (steps - i - 1.0, i + 1.0)]
    plan = PolygonMap([*stairs[:-1], (0.0, float(steps))])
    assert len(simplified(plan, 0.75).outer) < 8
    assert len(simplified(plan, 0.7).outer) > 30  # a step is sqrt(1/2) deep


def test_the_check_refuses_what_is_unsound():
    exact = PolygonMap([(0, 0), (10, 0), (10, 10), (0, 10)])
    larger = PolygonMap([(0, 0), (10, 0), (10.1, 10), (0, 10)])
    smaller = PolygonMap([(0, 0), (10, 0), (10, 8), (0, 10)])
    assert not is_sound_simplification(exact, larger, 5.0)
    assert not is_sound_simplification(exact, smaller, 0.5)
    assert is_sound_simplification(exact, smaller, 2.0)


@pytest.mark.parametrize("tolerance", [-1.0, float("nan"), float("inf")])
def test_tolerances_that_are_none(tolerance: float):
    with pytest.raises(ValueError, match="tolerance: is"):
        simplified(PolygonMap([(0, 0), (1, 0), (0, 1)]), tolerance)
