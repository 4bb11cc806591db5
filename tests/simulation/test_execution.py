"""Plans driven with errors and late: what margins promise, and what the verifier catches."""

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as runs
from hypothesis import strategies as st

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.planning.plan import plan
from conav.planning.plan_summary import pair_clearances
from conav.planning.trajectory import positions, straight
from conav.planning.types import PlanningProblem, PlanningRobot, Region, Trajectory
from conav.planning.verify_deviation import deviation
from conav.planning.verify_execution import ExecutionReport, verify_execution
from conav.runs.reader import read_run
from conav.runs.types import ExecutionRun
from conav.simulation.execution import (
    KNOT_S,
    Disturbance,
    Execution,
    drive,
    execute,
    executed,
    safe_margin,
)
from conav.simulation.record_execution import record_execution

FLOOR = PolygonMap([(0, 0), (20, 0), (20, 20), (0, 20)])
REGIONS = {"goal": Region("goal", disc=(10.0, 10.0, 20.0))}


def robot(name: str, start: tuple[float, ...], **more: Any) -> PlanningRobot:
    return PlanningRobot(name, start, "F goal", REGIONS, **{"radius_m": 0.5, **more})


def passing(gap: float = 1.0) -> tuple[PlanningProblem, list[Trajectory]]:
    """Two robots of half a metre that pass each other, their lines so far apart."""
    robots = (robot("a", (2.0, 5.0)), robot("b", (18.0, 5.0 + gap)))
    ways = [straight([(2, 5), (18, 5)], [0, 16]), straight([(18, 5 + gap), (2, 5 + gap)], [0, 16])]
    return PlanningProblem(FLOOR, robots, 30.0), ways


def arc(turns: float = 0.5) -> Trajectory:
    """A circle of 2 m around (10, 10) from (12, 10), at 1 m/s, then straight on."""
    angle = 2.0 * math.pi * turns
    end = 2.0 * angle
    x, y = 10 + 2 * math.cos(angle), 10 + 2 * math.sin(angle)
    vx, vy = -math.sin(angle), math.cos(angle)
    return Trajectory(
        np.array(
            [[0, end, 12, 10, 0, 1, 0, 0, 0.5], [end, end + 2, x, y, vx, vy, 0, 0, 0]],
            dtype=np.float64,
        )
    )


def test_a_late_robot_waits_and_then_drives_its_plan() -> None:
    way = straight([(1, 1), (4, 5)], [0, 10])
    late = drive(way, Disturbance(2.0, np.zeros((30, 2))))
    assert late.pieces[0, :6].tolist() == [0, 2, 1, 1, 0, 0]
    assert late.arrival_s == 12.0
    assert np.allclose(positions(late, [0, 2, 7, 12]), [(1, 1), (1, 1), (2.5, 3), (4, 5)])
    assert np.array_equal(drive(way, Disturbance(0.0, np.zeros((30, 2)))).pieces, way.pieces)


def test_errors_are_added_to_the_plan() -> None:
    way = straight([(1, 1), (5, 1)], [0, 4])
    errors = np.array([(0, 0), (0.1, 0), (0, -0.2), *[(0.05, 0.05)] * 20])
    found = drive(way, Disturbance(0.5, errors))
    # Half way to the first knot; at it, still waiting; at the second; and long after.
    at = positions(found, [KNOT_S / 2, KNOT_S, 2 * KNOT_S, 4.0])
    assert np.allclose(at, [(1.05, 1), (1.1, 1), (1.5, 0.8), (4.55, 1.05)])
    assert found.arrival_s == 4.5
    problem = PlanningProblem(FLOOR, (robot("a", (1.0, 1.0)),), 30.0)
    outcome = executed(
        problem, [way], [Disturbance(0.5, errors)], tracking_error_m=0.2, delay_s=0.5
    )
    assert outcome.deviation_m == pytest.approx(0.2)
    assert outcome.clearance_m is None
    assert outcome.wall_clearance_m == pytest.approx(0.3)  # from y = 0, at the second knot


def test_clearances_of_a_hand_made_case() -> None:
    """Errors of 0.1 m towards each other where they pass: from 1.05 m apart to 0.85."""
    problem, ways = passing(1.05)
    up, down = np.tile((0.0, 0.1), (60, 1)), np.tile((0.0, -0.1), (60, 1))
    up[0] = down[0] = 0.0
    given_ones = [Disturbance(0.0, up), Disturbance(0.0, down)]
    outcome = executed(problem, ways, given_ones, tracking_error_m=0.1, delay_s=0.0)
    assert outcome.clearance_m == pytest.approx(-0.15)
    (touch,) = outcome.touches
    assert touch.robots == (0, 1)
    assert touch.time_s == pytest.approx(8.0)
    smaller = executed(problem, ways, given_ones, tracking_error_m=0.1, delay_s=0.0, slack_m=0.08)
    assert smaller.clearance_m == pytest.approx(0.01)
    assert not smaller.touched
    assert smaller.margin_m == pytest.approx(0.16)


def test_without_a_margin_errors_make_robots_touch() -> None:
    problem, ways = passing()
    assert not execute(problem, ways).touched
    touched = [
        execute(problem, ways, tracking_error_m=0.05, seed=seed).touched for seed in range(20)
    ]
    assert any(touched)
    # Robots of another margin, of the same errors, never do.
    problem, ways = passing(1.1)
    assert not any(
        execute(problem, ways, tracking_error_m=0.05, seed=seed).touched for seed in range(20)
    )


def test_without_a_margin_delays_make_robots_touch() -> None:
    """One crosses right behind the other: if that one is late, they meet."""
    robots = (robot("a", (5.0, 10.0)), robot("b", (10.0, 5.0)))
    ways = [
        straight([(5, 10), (15, 10)], [0, 10]),
        # Its centre comes by (10, 10) when the other is sqrt(2) further on.
        straight([(10, 5), (10, 15)], [math.sqrt(2.0), 10 + math.sqrt(2.0)]),
    ]
    still = straight([(10, 5), (10, 5)], [0, math.sqrt(2.0)])
    ways[1] = Trajectory(np.vstack([still.pieces, ways[1].pieces]))
    problem = PlanningProblem(FLOOR, robots, 30.0)
    assert execute(problem, ways).clearance_m == pytest.approx(0.0, abs=1e-9)
    assert any(execute(problem, ways, delay_s=0.3, seed=seed).touched for seed in range(10))


point = st.tuples(st.floats(1, 19), st.floats(1, 19))


@st.composite
def adversaries(draw: Any) -> tuple[PlanningProblem, list[Trajectory], list[Disturbance], float]:
    """Any two or three plans, touching or not, and errors and lags at their bounds or within."""
    count = draw(st.integers(2, 3))
    error, delay = draw(st.sampled_from([0.0, 0.1, 0.5])), draw(st.sampled_from([0.0, 0.5, 2.0]))
    robots, ways, bad = [], [], []
    for number in range(count):
        speed = draw(st.floats(0.5, 2.0))
        points = draw(st.lists(point, min_size=2, max_size=4, unique=True))
        legs = [max(math.dist(a, b), 0.01) for a, b in pairwise(points)]
        slow = draw(st.floats(1.0, 2.0))
        times = np.cumsum([0.0, *(leg / speed * slow for leg in legs)])
        ways.append(straight(points, times))
        after = draw(st.sampled_from(["stay", "vanish"]))
        robots.append(
            robot(f"r{number}", points[0], radius_m=0.2, speed_mps=speed, after_arrival=after)
        )
        lag = draw(st.sampled_from([0.0, delay, 0.4 * delay]))
        knots = int((times[-1] + lag) / KNOT_S) + 2
        angles = np.array(draw(st.lists(st.floats(0, 6.3), min_size=1, max_size=4)))
        turned = np.resize(angles, knots)
        errors = error * np.stack([np.cos(turned), np.sin(turned)], axis=1)
        errors[0] = 0.0
        bad.append(Disturbance(lag, errors))
    horizon = max(way.arrival_s for way in ways) + 1.0
    problem = PlanningProblem(FLOOR, tuple(robots), horizon)
    return problem, ways, bad, safe_margin(problem, error, delay)


@runs(max_examples=80)
@given(adversaries())
def test_clearance_never_falls_by_more_than_the_safe_margin(
    case: tuple[PlanningProblem, list[Trajectory], list[Disturbance], float],
) -> None:
    problem, ways, bad, safe = case
    planned = min(pair.clearance_m for pair in pair_clearances(problem, ways))
    error = max(float(np.hypot(*each.errors.T).max()) for each in bad)
    lag = max(each.lag_s for each in bad)
    outcome = executed(problem, ways, bad, tracking_error_m=error, delay_s=lag)
    assert outcome.clearance_m is not None
    assert outcome.clearance_m >= planned - safe - 1e-9
    assert outcome.deviation_m <= error + 1e-9


@pytest.mark.parametrize("after", ["stay", "vanish"])
def test_a_plan_with_the_safe_margin_is_driven_without_a_touch(after: str, tmp_path: Path) -> None:
    goals = [(15.0, 10.0), (10.0, 15.0), (5.0, 10.0), (10.0, 5.0)]
    robots = tuple(
        PlanningRobot(
            f"r{i}", (20 - x, 20 - y), "F goal", {"goal": Region("goal", disc=(x, y, 0.4))},
            0.5, after_arrival=after,
        )
        for i, (x, y) in enumerate(goals)
    )  # fmt: skip
    error, delay = 0.05, 0.2
    # 0.3 of margin, a third of it by robots that are smaller than planned, which clears walls too.
    problem = PlanningProblem(FLOOR, robots, 60.0, margin_m=0.2)
    found = plan(problem, samples=300, seed=2)
    assert str(found.status) == "done"
    for seed in range(30):
        outcome = execute(
            problem, found.trajectories, tracking_error_m=error, delay_s=delay, slack_m=0.05,
            seed=seed,
        )  # fmt: skip
        assert outcome.margin_m == pytest.approx(outcome.safe_margin_m)
        assert not outcome.touched
        assert outcome.deviation_m <= error + 1e-12
        assert all(lag is not None and 0 <= lag <= delay for lag in outcome.lags_s)
    report = verified(tmp_path, outcome)
    assert report.verdict == "verified", report.lines()


def verified(folder: Path, outcome: Execution) -> ExecutionReport:
    path = folder / "driven.mcap"
    record_execution(path, outcome, plan_digest="0" * 64, compute_s=0.1)
    run = read_run(path)
    assert isinstance(run, ExecutionRun)
    return verify_execution(run)


def test_the_same_seed_drives_the_same(tmp_path: Path) -> None:
    problem, ways = passing()

    def digest(seed: int) -> str:
        outcome = execute(problem, ways, tracking_error_m=0.1, delay_s=1.0, seed=seed)
        path = tmp_path / "driven.mcap"
        return record_execution(path, outcome, plan_digest="", compute_s=0.0)

    assert digest(3) == digest(3) != digest(4)


def test_curves_keep_their_bounds_and_are_verified(tmp_path: Path) -> None:
    robots = (
        robot("car", (12.0, 10.0, math.pi / 2), motion="dubins-car", turning_radius_m=2.0),
        robot("other", (10.0, 10.0)),
    )
    problem = PlanningProblem(FLOOR, robots, 30.0)
    ways = [arc(), straight([(10, 10), (10, 10.5)], [0, 2])]
    for seed in range(8):
        outcome = execute(problem, ways, tracking_error_m=0.1, delay_s=0.5, seed=seed)
        report = verified(tmp_path, outcome)
        assert report.verdict == "verified", report.lines()
        assert 0.03 < outcome.deviation_m <= 0.1
        # Finely sampled, the distance from the late plan is within the bound too.
        assert outcome.driven[0] is not None
        times = np.linspace(0, outcome.driven[0].arrival_s, 3000)
        off = positions(outcome.driven[0], times) - positions(ways[0], times - outcome.lags_s[0])
        assert np.hypot(*off.T).max() <= 0.1
    whole = execute(problem, ways, delay_s=0.5, seed=1)
    assert whole.driven[0] is not None
    assert whole.driven[0].pieces[:, 8].any()  # without errors arcs stay arcs
    assert verified(tmp_path, whole).verdict == "verified"


def test_the_verifiers_deviation_is_that_of_fine_samples() -> None:
    way = arc()
    other = straight([(12, 10), (9, 13), (8, 7)], [0, 4, way.arrival_s])
    low, high, when = deviation(way.pieces, other.pieces)
    times = np.linspace(0, way.arrival_s, 200_001)
    sampled = np.hypot(*(positions(way, times) - positions(other, times)).T)
    assert low <= high <= low + 2e-7
    assert sampled.max() <= high + 1e-9
    assert low == pytest.approx(sampled.max(), abs=1e-4)
    assert times[sampled.argmax()] == pytest.approx(when, abs=1e-3)


def test_untrue_runs_are_found_out(tmp_path: Path) -> None:
    problem, ways = passing(1.3)
    outcome = execute(problem, ways, tracking_error_m=0.1, delay_s=1.0, seed=1)
    path = tmp_path / "driven.mcap"
    record_execution(path, outcome, plan_digest="", compute_s=0.0)
    run = read_run(path)
    assert isinstance(run, ExecutionRun)
    assert run.result is not None
    assert verify_execution(run).verdict == "verified"

    def broken(**changes: Any) -> tuple[str, ...]:
        report = verify_execution(replace(run, **changes))
        assert not report.accepted
        return tuple(check.name for check in report.checks if check.broken)

    moved = {**run.driven, 0: run.driven[0] + np.array([0, 0, 0.2, 0, 0, 0, 0, 0, 0])}
    assert {"starts", "deviations"} <= set(broken(driven=moved))
    shorter = {**run.driven, 1: run.driven[1][:-1]}
    assert "lags" in broken(driven=shorter)
    holes = {**run.driven, 1: np.delete(run.driven[1], 5, axis=0)}
    assert "continuity" in broken(driven=holes)
    assert broken(driven={0: run.driven[0]})[0] == "form"
    assert "deviations" in broken(header={**run.header, "tracking_error_m": 0.01})
    assert "lags" in broken(header={**run.header, "delay_s": 0.01})
    for key, value in (
        ("touched", True), ("clearance_m", 0.9), ("wall_clearance_m", None), ("deviation_m", 0.01),
        ("lags_s", [0.0, 0.0]), ("tolerance_m", 3.0),
        ("touches", [{"robots": ["a", "b"], "depth_m": 0.1, "time_s": 1.0}]),
    ):  # fmt: skip
        assert broken(result={**run.result, key: value}), key


def test_touches_are_verified_as_touches(tmp_path: Path) -> None:
    problem, ways = passing()
    outcome = next(
        one
        for seed in range(20)
        if (one := execute(problem, ways, tracking_error_m=0.2, seed=seed)).touched
    )
    report = verified(tmp_path, outcome)
    assert report.verdict == "verified"
    assert any("touched" in line for line in report.lines())
    hidden = replace(outcome, touches=(), wall_touches=())
    assert not verified(tmp_path, hidden).accepted


@pytest.mark.parametrize(
    "numbers", [{"tracking_error_m": -1.0}, {"delay_s": math.nan}, {"slack_m": 0.5}]
)
def test_numbers_that_make_no_sense_are_refused(numbers: dict[str, float]) -> None:
    problem, ways = passing()
    with pytest.raises(InputError):
        execute(problem, ways, **numbers)
