"""How much of a line runs through walls, against exact fractions and the verifier's own count."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.exploration.verify_radio import wall_share
from conav.geometry.obstruction import obstructed


def slow(walls: np.ndarray, a: tuple[int, int], b: tuple[int, int]) -> Fraction:
    """For every wall the part of the segment between its two sides, by clipping."""
    total = Fraction(0)
    for cell in np.argwhere(walls != 0).tolist():
        first, last = Fraction(0), Fraction(1)
        for axis in (0, 1):
            low, high = cell[axis] - Fraction(1, 2), cell[axis] + Fraction(1, 2)
            start, change = a[axis], b[axis] - a[axis]
            if change == 0:
                if not low < start < high:
                    last = first
                continue
            one, other = (low - start) / change, (high - start) / change
            first, last = max(first, min(one, other)), min(last, max(one, other))
        total += max(last - first, Fraction(0))
    return total if a != b else Fraction(0)


@pytest.mark.parametrize(
    ("picture", "a", "b", "part"),
    [
        (["..#.."], (0, 0), (0, 4), (1, 4)),
        (["....."], (0, 0), (0, 4), (0, 1)),
        (["#...#"], (0, 0), (0, 4), (1, 4)),  # half a cell at either end
        ([".#", "#."], (0, 0), (1, 1), (0, 1)),  # between two walls that touch
        (["#.", ".#"], (0, 0), (1, 1), (1, 1)),
        (["#"], (0, 0), (0, 0), (0, 1)),
    ],
)
def test_by_hand(
    picture: list[str], a: tuple[int, int], b: tuple[int, int], part: tuple[int, int]
) -> None:
    walls = np.array([[c == "#" for c in row] for row in picture], np.uint8)
    inside, whole = obstructed(walls, *a, *b)
    assert Fraction(inside, whole) == Fraction(*part)


@settings(max_examples=200, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    ends=st.tuples(*[st.integers(0, 11)] * 4),
    share=st.sampled_from([0.1, 0.5, 0.9]),
)
def test_equals_slow_ways(seed: int, ends: tuple[int, int, int, int], share: float) -> None:
    walls = (np.random.default_rng(seed).random((12, 12)) < share).astype(np.uint8)
    a, b = ends[:2], ends[2:]
    expected = slow(walls, a, b)
    assert Fraction(*obstructed(walls, *a, *b)) == expected
    assert Fraction(*obstructed(walls, *b, *a)) == expected
    if a != b:
        assert Fraction(*wall_share(walls, np.array(a), np.array(b))) == expected
