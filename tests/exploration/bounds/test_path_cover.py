"""The least longest path against all shares and all orders."""

from itertools import combinations, pairwise, permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.exploration.bounds.path_cover import least_longest_path


def brute_force(
    first: np.ndarray, between: np.ndarray, kind: np.ndarray, weights: np.ndarray, spare: int
) -> float:
    n, k = first.shape

    def path(robot: int, places: tuple[int, ...]) -> float:
        if not places:
            return 0.0
        ways = between[kind[robot]]
        return min(
            first[robot, order[0]] + sum(ways[a, b] for a, b in pairwise(order))
            for order in permutations(places)
        )

    def covering(robot: int, places: tuple[int, ...]) -> float:
        """No less than for any part of the places."""
        return max(
            path(robot, part)
            for size in range(len(places) + 1)
            for part in combinations(places, size)
        )

    best = np.inf
    for owners in product(range(-1, n), repeat=k):  # -1: left out
        if sum(weights[w] for w in range(k) if owners[w] < 0) > spare:
            continue
        longest = max(
            covering(robot, tuple(w for w in range(k) if owners[w] == robot)) for robot in range(n)
        )
        best = min(best, longest)
    return float(best)


@settings(deadline=None, max_examples=80)
@given(st.integers(0, 2**32), st.integers(1, 3), st.integers(1, 4), st.integers(0, 4))
def test_equals_brute_force(seed: int, n: int, k: int, spare: int) -> None:
    rng = np.random.default_rng(seed)
    kinds = int(rng.integers(1, n + 1))
    # Not symmetric and without the triangle inequality, with many zeros and some ways missing.
    first = rng.integers(0, 8, size=(n, k)).astype(float)
    between = rng.integers(0, 6, size=(kinds, k, k)).astype(float)
    first[rng.random(first.shape) < 0.1] = np.inf
    between[rng.random(between.shape) < 0.1] = np.inf
    kind = rng.integers(0, kinds, size=n)
    weights = rng.integers(1, 4, size=k)
    expected = brute_force(first, between, kind, weights, spare)
    assert least_longest_path(first, between, kind, weights, spare) == expected


def test_a_detour_through_an_overlap_does_not_shorten_a_path() -> None:
    # Places 0 and 1 are 10 apart, and 2 overlaps with both: ways of no length, but from other
    # points of it. Whoever visits all three has been in 0 and 1 as well.
    between = np.array([[[0.0, 10.0, 0.0], [10.0, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    first = np.zeros((1, 3))
    ones = np.ones(3, dtype=np.int64)
    kind = np.zeros(1, dtype=np.int64)
    assert least_longest_path(first, between, kind, ones, 0) == 10.0
    assert least_longest_path(first, between, kind, ones, 1) == 0.0


@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_line_shared_from_its_ends(n: int) -> None:
    places = np.arange(9.0)
    between = np.abs(places[:, None] - places)[None]
    starts = np.linspace(0, 8, n) if n > 1 else np.array([0.0])
    first = np.abs(starts[:, None] - places)
    longest = least_longest_path(
        first, between, np.zeros(n, dtype=np.int64), np.ones(9, dtype=np.int64), 0
    )
    assert longest == {1: 8.0, 2: 4.0, 3: 3.0}[n]
