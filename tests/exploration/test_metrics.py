"""The metrics by hand."""

import numpy as np
import pytest

from conav.exploration.metrics import ExplorationMetrics, exploration_metrics


def metrics(covered: list[int], observable: int, **other: object) -> ExplorationMetrics:
    numbers: dict[str, object] = {
        "step_s": 0.5,
        "travelled_m": np.array([0.0]),
        "sensed": np.array([0]),
        "discovered": np.array([0]),
        "messages": 0,
        "bytes_sent": 0,
    }
    return exploration_metrics(covered=covered, observable=observable, **(numbers | other))  # type: ignore[arg-type]


def test_a_small_run_by_hand() -> None:
    found = metrics(
        [40, 80, 90, 96, 99, 100],
        100,
        travelled_m=np.array([2.0, 1.0, 1.0]),
        sensed=np.array([60, 50, 40]),
        discovered=np.array([50, 30, 20]),
        messages=12,
        bytes_sent=345,
    )
    assert found.steps == 5
    assert found.time_s == 2.5
    assert found.coverage == 1.0
    assert (found.t90_s, found.t95_s, found.t99_s, found.t100_s) == (1.0, 1.5, 2.0, 2.5)
    assert found.path_m == (2.0, 1.0, 1.0)
    assert found.overlap == 0.5  # 150 seen for 100
    # Shares of the path 0.5, 0.25, 0.25 about 1/3: squares 1/36, 1/144, 1/144.
    assert found.balance["path"] == pytest.approx((1 / 72) ** 0.5)
    # Shares 0.5, 0.3, 0.2: squares 1/36, 1/900, 4/225.
    assert found.balance["seen"] == pytest.approx((14 / 900) ** 0.5)
    assert (found.messages, found.bytes) == (12, 345)


def test_a_share_counts_when_it_is_reached_exactly() -> None:
    found = metrics([0, 9, 10], 10)
    assert found.t90_s == 0.5
    assert found.t95_s == found.t99_s == found.t100_s == 1.0
    # 0.9 of 11 cells is 9.9: nine are too few.
    assert metrics([0, 9, 10], 11).t90_s == 1.0


def test_what_was_never_reached_has_no_time() -> None:
    found = metrics([10, 91], 100)
    assert found.t90_s == 0.5
    assert found.t95_s is None
    assert found.t99_s is None
    assert found.t100_s is None
    assert found.coverage == 0.91


def test_the_first_look_is_at_time_zero() -> None:
    found = metrics([10], 10)
    assert (found.steps, found.time_s) == (0, 0.0)
    assert found.t90_s == found.t100_s == 0.0


def test_nothing_to_observe_is_all_observed() -> None:
    found = metrics([0, 0], 0)
    assert found.coverage == 1.0
    assert found.t100_s == 0.0
    assert found.overlap == 0.0


def test_a_run_without_a_single_look() -> None:
    found = metrics([], 10)
    assert (found.steps, found.time_s, found.coverage) == (0, 0.0, 0.0)
    assert found.t90_s is None
    assert found.overlap == 0.0


def test_an_even_team_has_no_spread() -> None:
    found = metrics([4], 4, travelled_m=np.array([0.0, 0.0]), discovered=np.array([2, 2]))
    assert found.balance == {"seen": 0.0, "path": 0.0}
    # All by one of two: shares 1 and 0.
    found = metrics([4], 4, travelled_m=np.array([3.0, 0.0]), discovered=np.array([0, 4]))
    assert found.balance == {"seen": 0.5, "path": 0.5}


def test_times_carry_no_rounding_noise() -> None:
    found = metrics([0, 0, 0, 1], 1, step_s=0.1)
    assert found.time_s == found.t100_s == 0.3
