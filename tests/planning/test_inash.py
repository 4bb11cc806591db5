"""iNash: valid plans, costs that never rise, equilibria, the same result for the same seed."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from conav.errors import InputError
from conav.planning.best_response import LEAST_GAIN
from conav.planning.inash import INash
from conav.planning.plan import plan
from conav.planning.team import build_team
from conav.planning.types import PlanningProblem, PlanningResult
from conav.status import Status

METHODS = [
    {},
    {"response": "first"},
    {"order": "random"},
    {"feasibility": False},
    {"shortcut_tries": 0, "guide": False},
    {"mode": "paper", "exponent": "d+1", "batch": 50},
    {"mode": "paper", "response": "first", "feasibility": False, "shortcut_tries": 0, "batch": 10},
]


def costs_over_time(result: PlanningResult) -> list[tuple[str, np.ndarray]]:
    return [(str(line["stage"]), np.array(line["costs"])) for line in result.history]


def check_never_rises(result: PlanningResult) -> None:
    """No component of anybody's cost rises, but where paths for all were looked for.

    Of two costs one may rise by a rounding for a gain in the other.
    """
    rounding = LEAST_GAIN if len(result.costs[0]) > 1 else 0.0
    lines = costs_over_time(result)
    for (_, before), (stage, after) in pairwise(lines):
        if stage != "feasibility":
            had = np.isfinite(before)
            assert (after[had] <= before[had] + rounding).all()
        if np.isfinite(before).all():
            assert stage != "feasibility"
            assert after.sum() <= before.sum()


@pytest.mark.parametrize("settings", METHODS, ids=str)
def test_eight_across_a_circle(scenes, settings) -> None:
    problem = scenes.antipodal(8, 0.4)
    samples = 1500 if settings.get("mode") == "paper" else 600
    result = plan(problem, samples=samples, seed=3, settings=settings)
    scenes.check(problem, result)
    check_never_rises(result)
    assert result.epsilon is not None
    assert not result.epsilon.any()
    assert (
        result.counters["messages"]
        <= 2 * 8 * result.counters["rounds"] + 8 * (result.counters["last_rounds"])
    )
    if settings.get("mode") != "paper" and settings.get("feasibility", True):
        assert result.status == Status.DONE
        assert result.costs.sum() <= 1.05 * result.lower_bound
    assert (result.solo <= result.costs + 1e-9).all()


def test_nobody_can_do_better_on_the_final_graphs(scenes) -> None:
    """The certificate, made again from the problem, the trajectories and the vertices alone."""
    problem = scenes.antipodal(6, 0.5)
    settings = INash(samples=400)
    result = settings.solve(problem, 5)
    team = build_team(problem, settings, 0)
    for robot in range(team.size):
        graph = team.graphs[robot]
        assert graph.insert(result.graphs[robot][1:]) == len(result.graphs[robot]) - 1
        assert np.array_equal(graph.vertices, result.graphs[robot])
        team.traffic.put(robot, result.trajectories[robot].pieces)
    for robot in range(team.size):
        best = team.best_path(robot, team.everybody())
        assert best is not None
        assert best.cost >= result.costs[robot, 0] - 1e-9


@pytest.mark.parametrize("costs", [("duration",), ("length", "duration"), ("duration", "length")])
def test_other_costs(scenes, costs) -> None:
    problem = scenes.antipodal(5, 0.5, costs=costs)
    result = plan(problem, samples=3000, seed=1)
    scenes.check(problem, result)
    check_never_rises(result)
    assert result.status == Status.DONE
    assert result.costs.shape == (5, len(costs))
    assert (result.costs >= 15.5 - 1e-9).all()
    if costs == ("duration",):
        assert result.costs.max() < 17.5  # 15.5 s alone at full speed


def test_one_must_wait_in_the_bay(scenes) -> None:
    problem = scenes.bay()
    for seed in range(3):
        result = plan(problem, seed=seed, samples=1500)
        assert result.status == Status.DONE
        scenes.check(problem, result)
        check_never_rises(result)
        assert sorted(result.costs[:, 0])[1] < 9.0


def test_without_the_stage_somebody_may_be_locked_out_and_is_named(scenes) -> None:
    problem = scenes.bay()
    result = plan(problem, seed=0, samples=400, guide=False, feasibility=False)
    assert result.status == Status.OUT_OF_BUDGET
    assert "b" in result.reason
    assert result.trajectories[1] is None
    assert np.isinf(result.costs[1, 0])


def test_an_errand_with_two_places_and_a_pit(scenes) -> None:
    problem = scenes.errand()
    result = plan(problem, seed=2, samples=2000)
    scenes.check(problem, result)
    assert result.status == Status.DONE
    points = result.trajectories[0].pieces[:, 2:4]
    pieces = result.trajectories[0].pieces
    end = pieces[-1, 2:4] + pieces[-1, 4:6] * (pieces[-1, 1] - pieces[-1, 0])
    points = np.vstack([points, end])
    assert (np.hypot(*(points - (17, 3)).T) <= 0.6 + 1e-9).any()
    in_shelf = (points >= (2 - 1e-9, 15 - 1e-9)) & (points <= (4 + 1e-9, 18 + 1e-9))
    assert in_shelf.all(axis=1).any()
    assert result.lower_bound <= result.costs[0, 0] <= 1.35 * result.lower_bound


def test_same_seed_same_result(scenes) -> None:
    problem = scenes.antipodal(4)
    first, second = (plan(problem, seed=7, samples=400) for _ in range(2))
    assert np.array_equal(first.costs, second.costs)
    assert first.counters == second.counters
    for a, b in zip(first.graphs, second.graphs, strict=True):
        assert np.array_equal(a, b)
    third = plan(problem, seed=8, samples=400)
    assert not np.array_equal(first.graphs[0], third.graphs[0])


def test_more_samples_never_cost_more(scenes) -> None:
    problem = scenes.errand()
    costs = [plan(problem, seed=4, samples=count).costs[0, 0] for count in (200, 600, 1200)]
    assert costs[0] >= costs[1] >= costs[2]


def test_progress_is_told_and_may_stop_it(scenes) -> None:
    seen = []

    def on_progress(progress):
        seen.append((progress.stage, progress.samples))
        return len(seen) < 3

    result = plan(scenes.antipodal(3), seed=0, samples=5000, batch=100, on_progress=on_progress)
    assert [samples for _, samples in seen] == [100, 200, 300]
    assert result.status == Status.OUT_OF_BUDGET
    assert result.epsilon is None
    assert all(trajectory is not None for trajectory in result.trajectories)


def test_budgets(scenes) -> None:
    problem = scenes.antipodal(2)
    assert plan(problem, samples=None, iterations=3, batch=50).counters["iterations"] == 3
    timed = plan(problem, samples=None, time_s=0.5)
    assert timed.status == Status.DONE
    with pytest.raises(InputError, match="has no end"):
        plan(problem, samples=None)


def test_robots_of_different_sizes_and_a_margin(scenes) -> None:
    problem = scenes.antipodal(4, 0.3)
    robots = tuple(
        replace(robot, radius_m=0.2 + 0.2 * i, speed_mps=1.0 + 0.2 * i)
        for i, robot in enumerate(problem.robots)
    )
    problem = PlanningProblem(
        scenes.square, robots, 60.0, scenes.discs(6, 1) * [1, 1, 0.6], margin_m=0.2
    )
    result = plan(problem, seed=0, samples=1000)
    scenes.check(problem, result)
    assert result.status == Status.DONE
