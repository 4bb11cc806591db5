"""Problems without a solution are told apart, with robot and reason."""

import numpy as np
import pytest

from conav.maps.polygon_map import PolygonMap
from conav.planning.plan import plan
from conav.planning.types import PlanningProblem, PlanningRobot, Region
from conav.status import Status

ROOMS = PolygonMap([(0, 0), (9.5, 0), (9.5, 3.7), (10.5, 3.7), (10.5, 0), (20, 0), (20, 10),
                    (10.5, 10), (10.5, 4.3), (9.5, 4.3), (9.5, 10), (0, 10)])  # fmt: skip


def problem(scenes, floor=None, horizon=60.0, discs=(), **robot) -> PlanningProblem:
    fields = {"start": (2.0, 2.0), "task": "F goal", "regions": scenes.disc("goal", 17, 5)}
    one = PlanningRobot("alf", **{**fields, "radius_m": 0.4, **robot})
    return PlanningProblem(floor or scenes.square, (one,), horizon, np.array(discs))


def reason_of(found: PlanningProblem, solver: str = "inash") -> str:
    result = plan(found, solver, samples=100)
    assert result.status == Status.INFEASIBLE
    assert all(trajectory is None for trajectory in result.trajectories)
    return result.reason


@pytest.mark.parametrize("solver", ["inash", "prioritized", "anytime-prioritized"])
def test_start_in_a_wall(scenes, solver: str) -> None:
    assert reason_of(problem(scenes, start=(0.2, 5.0)), solver).startswith("robot alf: its start")
    assert "start" in reason_of(problem(scenes, start=(25.0, 5.0)), solver)
    assert "start" in reason_of(problem(scenes, discs=[(2.0, 3.0, 0.7)]), solver)


def test_start_that_touches_is_fine(scenes) -> None:
    assert plan(problem(scenes, start=(0.4, 5.0)), samples=400).status == Status.DONE


def test_starts_overlap(scenes) -> None:
    near = problem(scenes)
    other = PlanningRobot("bea", (2.5, 2.5), "F goal", scenes.disc("goal", 3, 9), 0.4)
    reason = reason_of(PlanningProblem(scenes.square, (*near.robots, other), 60.0))
    assert reason == (
        "robots alf and bea: their starts are 0.707107 m apart and must be 0.8 m at least"
    )


def test_goal_in_a_disc_or_off_the_floor(scenes) -> None:
    inside = problem(scenes, discs=[(17.0, 5.0, 0.9)])
    assert "region 'goal' cannot be reached" in reason_of(inside)
    off = problem(scenes, regions=scenes.disc("goal", 25, 5))
    assert "region 'goal' cannot be reached" in reason_of(off)


def test_door_too_narrow_for_the_radius(scenes) -> None:
    assert "cannot be reached" in reason_of(problem(scenes, ROOMS))
    assert plan(problem(scenes, ROOMS, radius_m=0.2), samples=500).status == Status.DONE


def test_the_way_leads_through_what_is_to_be_avoided(scenes) -> None:
    wall = Region("wall", polygon=np.array([(9, -1), (11, -1), (11, 21), (9, 21)], float))
    regions = {**scenes.disc("goal", 17, 5), "wall": wall}
    reason = reason_of(problem(scenes, task="F goal & G !wall", regions=regions))
    assert "'goal' cannot be reached" in reason
    task = "F goal & (!goal U wall)"
    assert plan(problem(scenes, task=task, regions=regions), samples=300).status == Status.DONE


def test_task_that_no_labels_satisfy(scenes) -> None:
    inner = {**scenes.disc("goal", 17, 5), **scenes.disc("room", 17, 5, 2.0)}
    reason = reason_of(problem(scenes, task="F (goal & !room)", regions=inner))
    assert "cannot be done with the regions as they lie" in reason
    start = {**scenes.disc("goal", 17, 5), **scenes.disc("home", 2, 2)}
    reason = reason_of(problem(scenes, task="F goal & G !home", regions=start))
    assert "lost at the start" in reason


def test_horizon_too_short(scenes) -> None:
    reason = reason_of(problem(scenes, horizon=14.0))
    assert "14.797 m even without walls" in reason
    assert "the horizon is 14 s" in reason


def test_out_of_budget_is_not_infeasible(scenes) -> None:
    result = plan(problem(scenes, ROOMS, radius_m=0.29), samples=20, guide=False)
    assert result.status == Status.OUT_OF_BUDGET
    assert "alf" in result.reason
