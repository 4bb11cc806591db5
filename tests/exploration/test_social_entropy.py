"""Social entropy by hand."""

from itertools import combinations
from math import inf, log2, sqrt

import numpy as np
import pytest

from conav.exploration.social_entropy import (
    best_directions,
    clusters,
    entropy_at,
    hierarchic_entropy,
    nearest_points,
    shannon,
    team_entropy,
)


def distances(points: list[tuple[float, float]]) -> list[list[float]]:
    return [[sqrt((x - a) ** 2 + (y - b) ** 2) for a, b in points] for x, y in points]


def test_simple_entropy_by_hand() -> None:
    assert shannon([1, 3]) == pytest.approx(0.811, abs=5e-4)  # 1 mother, 3 daughters
    assert shannon([3, 1]) == shannon([1, 3])
    assert shannon([5]) == 0.0
    assert shannon([]) == 0.0
    assert shannon([2, 2]) == 1.0
    assert shannon([1] * 8) == 3.0
    assert shannon([0, 4]) == 0.0


def test_two_robots_have_as_many_bits_as_metres_between_them() -> None:
    for d in (0.0, 0.5, 1.0, 7.25):
        assert hierarchic_entropy(distances([(1.0, 2.0), (1.0 + d, 2.0)])) == d


def test_one_robot_has_none() -> None:
    assert hierarchic_entropy([[0.0]]) == 0.0
    assert hierarchic_entropy([]) == 0.0
    assert team_entropy([(3.0, 4.0)], "simple", 1.0) == 0.0


def test_three_in_a_row_by_hand() -> None:
    # At 0, 1 and 3: apart below 1; {0, 1} and {3} below 2; {0, 1} and {1, 3}, which overlap, below
    # 3; then one.
    row = distances([(0.0, 0.0), (1.0, 0.0), (3.0, 0.0)])
    assert clusters(row, 0.5) == [{0}, {1}, {2}]
    assert clusters(row, 1.0) == [{0, 1}, {2}]
    assert clusters(row, 2.9) == [{0, 1}, {1, 2}]
    assert clusters(row, 3.0) == [{0, 1, 2}]
    expected = log2(3) + (-(1 / 3) * log2(1 / 3) - (2 / 3) * log2(2 / 3)) + 1.0
    assert hierarchic_entropy(row) == pytest.approx(expected, abs=1e-10)


def test_the_integral_is_exact() -> None:
    """A sum over many small levels comes near it, and nearer with smaller ones."""
    points = [(0.0, 0.0), (2.0, 1.0), (2.5, 4.0), (7.0, 3.0), (2.0, 1.0)]
    table = distances(points)
    step = 1e-3
    approximate = sum(entropy_at(table, (i + 0.5) * step) * step for i in range(9000))
    assert hierarchic_entropy(table) == pytest.approx(approximate, abs=2e-2)


def test_entropy_grows_with_the_team_drawn_larger() -> None:
    points = [(0.0, 0.0), (2.0, 1.0), (2.5, 4.0), (7.0, 3.0)]
    once = hierarchic_entropy(distances(points))
    twice = hierarchic_entropy(distances([(2 * x, 2 * y) for x, y in points]))
    moved = hierarchic_entropy(distances([(x + 8, y - 4) for x, y in points]))
    assert twice == pytest.approx(2 * once)
    assert moved == pytest.approx(once)


def test_clusters_are_all_maximal_sets_of_that_diameter() -> None:
    rng = np.random.default_rng(0)
    for _ in range(60):
        n = int(rng.integers(1, 8))
        table = distances([(float(x), float(y)) for x, y in rng.integers(0, 6, (n, 2))])
        level = float(rng.uniform(0, 6))
        close = [
            set(group)
            for size in range(1, n + 1)
            for group in combinations(range(n), size)
            if all(table[i][j] <= level for i, j in combinations(group, 2))
        ]
        maximal = [group for group in close if not any(group < other for other in close)]
        assert clusters(table, level) == sorted(maximal, key=sorted)


def test_best_directions_by_sign() -> None:
    shifts = [(0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0)]
    other = (10.0, 0.0)

    def entropy(shift: tuple[float, float]) -> float:
        return team_entropy([shift, other], "hierarchic", inf)

    assert best_directions(shifts, entropy, "minimise") == [2]
    assert best_directions(shifts, entropy, "maximise") == [3]
    # Alone all directions are equal.
    assert best_directions(shifts, lambda shift: 0.0, "minimise") == [0, 1, 2, 3]
    assert best_directions([], lambda shift: 0.0, "minimise") == []


def test_only_the_nearest_count_in_large_teams() -> None:
    points = [(float(x), 0.0) for x in (9, 0, 4, 1, 2)]
    assert nearest_points(points, 1, 3) == [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]
    assert nearest_points(points, 0, 10) == points
