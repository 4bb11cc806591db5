"""Warming up leaves nothing of the first plan to be compiled, and never fails."""

import pytest

from conav.planning.catalogue import SOLVERS, make_solver
from conav.planning.types import (
    DUBINS_CAR,
    PLANNING_MOTIONS,
    PlanningProblem,
    PlanningResult,
    PlanningRobot,
)
from conav.planning.warm_up import SAMPLES, warm_up


def problem_with(*motions: str) -> PlanningProblem:
    from conav.maps.polygon_map import PolygonMap

    floor = PolygonMap([(0, 0), (5, 0), (5, 5), (0, 5)])
    robots = tuple(
        PlanningRobot(f"r{i}", (1.0, 1.0), "true", {}, motion=motion)
        for i, motion in enumerate(motions)
    )
    return PlanningProblem(floor, robots, 10.0, costs=("duration",))


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_small_plan_of_the_same_kind_is_made(
    solver: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    heard: list[PlanningResult] = []
    kind = type(make_solver(solver))
    solve = kind.solve

    def listening(self: object, *arguments: object) -> PlanningResult:
        heard.append(solve(self, *arguments))
        return heard[-1]

    monkeypatch.setattr(kind, "solve", listening)
    warm_up(solver, problem_with("single-integrator"))
    (found,) = heard
    assert len(found.trajectories) == 2
    assert found.counters["samples"] == 2 * SAMPLES
    assert all(way is not None for way in found.trajectories)


def test_motions_a_solver_does_not_know_are_no_matter() -> None:
    warm_up("social-optimum", problem_with(*PLANNING_MOTIONS))
    warm_up("coupled", problem_with(DUBINS_CAR))
