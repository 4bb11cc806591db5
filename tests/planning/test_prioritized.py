"""The two methods of comparison."""

from dataclasses import replace
from time import monotonic
from types import SimpleNamespace

import numpy as np
import pytest

from conav.maps.polygon_map import PolygonMap
from conav.planning.plan import plan
from conav.planning.team import Team
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


@pytest.mark.parametrize("solver", ["prioritized", "anytime-prioritized"])
@pytest.mark.parametrize("mode", ["paper", "forward"])
def test_nobody_can_gain_alone(scenes, solver: str, mode: str) -> None:
    """Those after a robot only take paths away from it, so its best answer stays one."""
    for seed in range(3):
        result = plan(scenes.antipodal(5), solver, seed=seed, samples=900, mode=mode)
        assert result.epsilon is not None
        assert result.epsilon.tolist() == [0.0] * 5
        assert np.isfinite(result.costs).any()


def test_any_time_costs_of_the_first_never_rise(scenes) -> None:
    result = plan(scenes.antipodal(5), "anytime-prioritized", seed=2, samples=1500)
    first = [line["costs"][0][0] for line in result.history]
    assert first == sorted(first, reverse=True)


def test_a_budget_of_time_leaves_time_to_choose(scenes, monkeypatch) -> None:
    """By a clock that goes on by what is done: a choice takes as long as edges are many."""
    now = [0.0]
    clock = SimpleNamespace(monotonic=lambda: now[0])
    monkeypatch.setattr("conav.planning.budget.time", clock)
    best_path, better_path, grow = Team.best_path, Team.better_path, Team.grow

    def takes(per_edge: float, method):
        def timed(team: Team, robot: int, *rest, **more):
            now[0] += per_edge * team.graphs[robot].edges
            return method(team, robot, *rest, **more)

        return timed

    def growing(team: Team, robot: int, samples: int) -> None:
        now[0] += 2e-4 * samples
        grow(team, robot, samples)

    monkeypatch.setattr(Team, "best_path", takes(2e-5, best_path))
    monkeypatch.setattr(Team, "better_path", takes(2e-5, better_path))
    monkeypatch.setattr(Team, "grow", growing)
    for seconds in (1.0, 3.0):
        now[0] = 0.0
        plan(scenes.antipodal(6, 0.4), "prioritized", samples=None, time_s=seconds, batch=50)
        assert 0.8 * seconds < now[0] < 1.1 * seconds


@pytest.mark.parametrize("solver", ["inash", "prioritized", "anytime-prioritized"])
def test_what_has_no_plan_for_all_ends_all_the_same(scenes, solver: str) -> None:
    """Two robots that cannot pass each other: no budget of samples or time is outlived."""
    problem = replace(scenes.bay(), floor=PolygonMap([(0, 0), (10, 0), (10, 1), (0, 1)]))
    result = plan(problem, solver, seed=1, samples=400)
    assert result.status == Status.OUT_OF_BUDGET
    assert "no path past the others yet for " in result.reason
    began = monotonic()
    plan(problem, solver, seed=1, samples=None, time_s=0.3)
    assert monotonic() - began < 10.0
