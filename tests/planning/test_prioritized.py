"""The two methods of comparison."""

import numpy as np
import pytest

from conav.planning.plan import plan
from conav.status import Status


@pytest.mark.parametrize("solver", ["prioritized", "anytime-prioritized"])
def test_valid_and_repeatable(scenes, solver: str) -> None:
    problem = scenes.antipodal(6, 0.4)
    result = plan(problem, solver, seed=1, samples=1600)
    scenes.check(problem, result)
    assert result.status == Status.DONE
    again = plan(problem, solver, seed=1, samples=1600)
    assert np.array_equal(result.costs, again.costs)


@pytest.mark.parametrize("solver", ["prioritized", "anytime-prioritized"])
def test_the_first_robot_has_the_floor_to_itself(scenes, solver: str) -> None:
    problem = scenes.bay()
    result = plan(problem, solver, seed=0, samples=800)
    assert result.costs[0, 0] == result.solo[0, 0]
    scenes.check(problem, result)


def test_the_last_may_be_left_without_a_path(scenes) -> None:
    result = plan(scenes.bay(), "prioritized", seed=0, samples=300, guide=False)
    assert result.status == Status.OUT_OF_BUDGET
    assert "b" in result.reason
    assert result.epsilon is not None


def test_any_time_costs_of_the_first_never_rise(scenes) -> None:
    result = plan(scenes.antipodal(5), "anytime-prioritized", seed=2, samples=1500)
    first = [line["costs"][0][0] for line in result.history]
    assert first == sorted(first, reverse=True)
