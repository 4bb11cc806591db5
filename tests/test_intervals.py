"""Intervals against their definitions and by hand."""

from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conav.intervals import bootstrap_interval, mean_interval, ratio_interval, wilson

Z = 1.959963984540054


def test_known_numbers() -> None:
    half = wilson(5, 10)
    assert half.share == 0.5
    assert (round(half.low, 4), round(half.high, 4)) == (0.2366, 0.7634)
    none = wilson(0, 10)
    assert none.low == 0.0
    assert round(none.high, 4) == 0.2775
    assert wilson(10, 10).high == 1.0


@given(st.integers(1, 500).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_the_ends_lie_z_deviations_away(case: tuple[int, int]) -> None:
    successes, trials = case
    found = wilson(successes, trials)
    assert 0.0 <= found.low <= found.share <= found.high <= 1.0
    for end in (found.low, found.high):
        # The deviation of the share if the truth were this end.
        assert abs(found.share - end) == pytest.approx(Z * sqrt(end * (1 - end) / trials), abs=1e-9)
    mirrored = wilson(trials - successes, trials)
    assert mirrored.low == pytest.approx(1.0 - found.high)


@pytest.mark.parametrize(("successes", "trials"), [(-1, 3), (4, 3), (0, 0)])
def test_shares_that_are_none_are_refused(successes: int, trials: int) -> None:
    with pytest.raises(ValueError, match="is no share"):
        wilson(successes, trials)


def test_mean_interval_by_hand() -> None:
    # Mean 2, standard deviation 1, three values: half width 4.3027 / sqrt(3).
    found = mean_interval([1.0, 2.0, 3.0])
    assert found.value == 2.0
    assert found.high == pytest.approx(2.0 + 4.302652729911275 / 3**0.5)
    assert found.low == pytest.approx(2.0 - 4.302652729911275 / 3**0.5)
    assert mean_interval([5.0])[1:] == (-float("inf"), float("inf"), 1)
    with pytest.raises(ValueError, match="no value"):
        mean_interval([])


def test_mean_interval_covers_the_truth_as_often_as_it_says() -> None:
    rng = np.random.default_rng(0)
    hits = 0
    for _ in range(2000):
        found = mean_interval(rng.normal(3.0, 2.0, size=5))
        hits += found.low <= 3.0 <= found.high
    share = wilson(hits, 2000)
    assert share.low <= 0.95 <= share.high


def test_ratio_interval_is_of_pairs_and_the_other_way_round() -> None:
    found = ratio_interval([2.0, 8.0], [1.0, 2.0])
    assert found.value == pytest.approx(8.0**0.5)
    back = ratio_interval([1.0, 2.0], [2.0, 8.0])
    assert back.low == pytest.approx(1.0 / found.high)
    assert ratio_interval([3.0, 5.0], [1.5, 2.5])[:3] == pytest.approx((2.0, 2.0, 2.0))
    with pytest.raises(ValueError, match="positive"):
        ratio_interval([1.0, 0.0], [1.0, 1.0])


def test_bootstrap_of_a_mean_is_near_the_normal_interval() -> None:
    values = np.random.default_rng(3).normal(5.0, 2.0, 400)
    found = bootstrap_interval(lambda at: values[at].mean(), 400, np.random.default_rng(0))
    plain = mean_interval(values)
    assert found.value == pytest.approx(plain.value)
    assert found.low == pytest.approx(plain.low, abs=0.03)
    assert found.high == pytest.approx(plain.high, abs=0.03)
    assert found.n == 400


def test_bootstrap_without_spread_and_with_gaps() -> None:
    rng = np.random.default_rng(0)
    assert bootstrap_interval(lambda at: 2.0, 5, rng)[:3] == (2.0, 2.0, 2.0)
    assert bootstrap_interval(lambda at: 2.0, 1, rng)[:3] == (2.0, -np.inf, np.inf)
    values = np.array([np.nan, 1.0, 2.0])
    gaps = bootstrap_interval(lambda at: float(values[at].mean()), 3, rng)
    assert np.isnan(gaps.value)
    assert 1.0 <= gaps.low <= gaps.high <= 2.0
    with pytest.raises(ValueError, match="no repetitions"):
        bootstrap_interval(lambda at: 0.0, 0, rng)
