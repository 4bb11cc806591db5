"""What is reported of a plan, against numbers worked out by hand."""

import json

import numpy as np
import pytest

from conav.maps.polygon_map import PolygonMap
from conav.planning.plan_summary import TOLERANCE_M, min_clearance, plan_summary
from conav.planning.trajectory import straight
from conav.planning.types import PIECE, PlanningProblem, PlanningResult, PlanningRobot, Trajectory
from conav.status import Status

FLOOR = PolygonMap([(0, 0), (20, 0), (20, 20), (0, 20)])


def problem(*radii: float, after: str = "stay") -> PlanningProblem:
    robots = tuple(
        PlanningRobot(f"r{i}", (0.0, 0.0), "true", {}, radius_m=radius, after_arrival=after)  # type: ignore[arg-type]
        for i, radius in enumerate(radii)
    )
    return PlanningProblem(FLOOR, robots, horizon_s=30.0)


def test_clearance_of_two_that_cross() -> None:
    # At time t at (t, 5) and (5, t + 2): apart by sqrt((t - 5)^2 + (t - 3)^2), least at t = 4.
    ways = (straight([(0, 5), (10, 5)], [0, 10]), straight([(5, 2), (5, 12)], [0, 10]))
    assert min_clearance(problem(0.3, 0.5), ways) == pytest.approx(np.sqrt(2) - 0.8)


def test_clearance_of_one_that_passes_another_that_stopped_or_vanished() -> None:
    stops = straight([(5, 0), (5, 5)], [0, 5])
    passes = straight([(0, 6), (10, 6)], [0, 20])  # above it at time 10
    assert min_clearance(problem(0.3, 0.3), (stops, passes)) == pytest.approx(1 - 0.6)
    # At time 5 it has got to x = 2.5; later the other is gone.
    apart = np.hypot(2.5, 1.0) - 0.6
    assert min_clearance(problem(0.3, 0.3, after="vanish"), (stops, passes)) == pytest.approx(apart)


def test_clearance_of_one_that_comes_by_after_everybody_stopped() -> None:
    stops = straight([(5, 0), (5, 5)], [0, 5])
    late = straight([(0, 6), (10, 6)], [0, 40])  # at x = 5 at time 20, within the horizon of 30
    assert min_clearance(problem(0.3, 0.3), (stops, late)) == pytest.approx(1 - 0.6)


def test_clearance_of_a_curve_is_never_too_large() -> None:
    # Half a circle of radius 5 about the robot that stands in its middle.
    arc = np.zeros((1, PIECE))
    arc[0] = (0, 5 * np.pi, 5, 0, 0, 1, 0, 0, 0.2)
    stands = straight([(0, 0), (0, 0)], [0, 1])
    found = min_clearance(problem(0.5, 0.5), (Trajectory(arc), stands))
    assert found is not None
    assert 4 - 4 * TOLERANCE_M <= found <= 4


def test_clearance_needs_two() -> None:
    way = straight([(0, 5), (10, 5)], [0, 10])
    assert min_clearance(problem(0.3), (way,)) is None
    assert min_clearance(problem(0.3, 0.3), (way, None)) is None


def result(*ways: Trajectory | None, **changes: object) -> PlanningResult:
    costs = [[np.inf] if way is None else [10.0] for way in ways]
    content: dict[str, object] = {
        "status": Status.DONE,
        "reason": "",
        "trajectories": ways,
        "costs": np.array(costs),
        "epsilon": np.zeros(len(ways)),
        "solo": np.full((len(ways), 1), 9.0),
        "lower_bound": 16.0,
        "counters": {"vertices": 7, "iterations": 2, "messages": 3, "checks": 5},
    }
    return PlanningResult(**{**content, **changes})  # type: ignore[arg-type]


def test_a_summary_says_all() -> None:
    ways = (straight([(0, 5), (10, 5)], [0, 10]), straight([(5, 2), (5, 12)], [0, 20]))
    summary = plan_summary(problem(0.3, 0.5), result(*ways), solver="inash", seed=4, compute_s=1.5)
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    keys = (
        "job scene solver status robots sum_cost lower_bound ratio min_clearance_m vertices "
        "iterations messages first_solution_compute_s compute_s run"
    )
    assert set(keys.split()) <= set(summary)
    assert (summary["job"], summary["solver"], summary["seed"]) == ("plan", "inash", 4)
    assert (summary["sum_cost"], summary["lower_bound"], summary["ratio"]) == (20.0, 16.0, 1.25)
    assert (summary["vertices"], summary["iterations"], summary["messages"]) == (7, 2, 3)
    assert summary["robots"][1] == {
        "name": "r1",
        "cost": [10.0],
        "length_m": 10.0,
        "arrival_s": 20.0,
        "epsilon": 0.0,
        "solo_m": 9.0,
    }


def test_what_is_unknown_or_infinite_is_none() -> None:
    way = straight([(0, 5), (10, 5)], [0, 10])
    found = result(
        way, None, status=Status.OUT_OF_BUDGET, epsilon=None, lower_bound=None, solo=None
    )
    summary = plan_summary(problem(0.3, 0.5), found, solver="inash", seed=0, compute_s=1.0)
    json.dumps(summary, allow_nan=False)
    assert summary["status"] == "out_of_budget"
    for key in ("sum_cost", "lower_bound", "ratio", "min_clearance_m"):
        assert summary[key] is None
    missing = summary["robots"][1]
    assert missing["cost"] == [None]
    assert all(missing[key] is None for key in ("length_m", "arrival_s", "epsilon", "solo_m"))
