"""Robots of every motion, and teams of several, through every solver, as the verifier sees it."""

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.planning.inash import INash
from conav.planning.load_scene import load_scene
from conav.planning.plan import plan
from conav.planning.recorder import PlanRecorder
from conav.planning.team import build_team
from conav.planning.trajectory import end_position, velocities
from conav.planning.types import (
    DOUBLE_INTEGRATOR,
    DUBINS_CAR,
    PLANNING_MOTIONS,
    PlanningProblem,
    PlanningResult,
    PlanningRobot,
    Region,
)
from conav.planning.verify import PlanReport, verify_plan
from conav.runs.reader import read_plan
from conav.status import Status

CURVED = (DOUBLE_INTEGRATOR, DUBINS_CAR)
SOLVERS = ("inash", "prioritized", "anytime-prioritized", "inash-restarts")

LAY_BY = PolygonMap([(0, 0), (12, 0), (12, 1), (9, 1), (8, 2), (4, 2), (3, 1), (0, 1)])


def moved(problem: PlanningProblem, *motions: str, **more) -> PlanningProblem:
    """The problem for robots of these motions in turn, at rest or facing their goal."""
    robots = []
    for number, robot in enumerate(problem.robots):
        motion = motions[number % len(motions)]
        x, y = robot.start[:2]
        start: tuple[float, ...] = (x, y)
        if motion == DOUBLE_INTEGRATOR:
            start = (x, y, 0.0, 0.0)
        if motion == DUBINS_CAR:
            goal_x, goal_y, _ = robot.regions["goal"].disc
            start = (x, y, math.atan2(goal_y - y, goal_x - x))
        robots.append(replace(robot, motion=motion, start=start, **more))
    return replace(problem, robots=tuple(robots))


def swap(scenes) -> PlanningProblem:
    """Two robots change places in a corridor with a lay-by for one."""
    robots = (
        PlanningRobot("a", (1.0, 0.5), "F goal", scenes.disc("goal", 11.0, 0.5, 0.3), 0.3),
        PlanningRobot("b", (11.0, 0.5), "F goal", scenes.disc("goal", 1.0, 0.5, 0.3), 0.3),
    )
    return PlanningProblem(LAY_BY, robots, 60.0)


def crossing(scenes) -> PlanningProblem:
    return load_scene("intersection:3,seed=1")


def circle(scenes) -> PlanningProblem:
    return scenes.antipodal(4)


def verified(problem: PlanningProblem, result: PlanningResult) -> PlanReport:
    """What the verifier says of the run; no rule of which may be broken."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "plan.mcap"
        with PlanRecorder(path, problem, solver="by-hand", settings={}, seed=0) as recorder:
            recorder.finish(result, compute_s=0.0)
        report = verify_plan(read_plan(path))
    assert report.accepted, report.lines()
    return report


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("motion", CURVED)
@pytest.mark.parametrize(
    ("scene", "samples"), [(swap, 1500), (circle, 400), (crossing, 400)], ids=lambda x: str(x)[:12]
)
def test_every_solver_plans_for_every_motion(
    scenes, scene, samples: int, motion: str, solver: str
) -> None:
    problem = moved(scene(scenes), motion)
    result = plan(problem, solver, seed=1, samples=samples)
    report = verified(problem, result)
    assert {check.name for check in report.checks if check.looked} >= {"steering", "collisions"}
    if solver in ("prioritized", "anytime-prioritized"):
        # Later ones may be shut out; the first never is.
        assert result.trajectories[0] is not None
    else:
        assert result.status == Status.DONE, result.reason
        assert report.planned == len(problem.robots)
    assert result.epsilon is not None
    assert not result.epsilon.any()
    assert (result.solo <= result.costs + 1e-9).all()
    for robot, trajectory in zip(problem.robots, result.trajectories, strict=True):
        if trajectory is not None and motion == DOUBLE_INTEGRATOR:
            last = trajectory.pieces[-1]
            end = last[4:6] + last[6:8] * (last[1] - last[0])
            assert np.abs(end).max() <= 1e-8, robot.name


def test_costs_never_rise_once_all_have_paths(scenes) -> None:
    for motion in CURVED:
        result = plan(moved(scenes.antipodal(4), motion), seed=3, samples=800)
        whole = [
            np.array(entry["costs"])
            for entry in result.history
            if np.isfinite(np.array(entry["costs"], dtype=float)).all()
        ]
        assert len(whole) > 1
        for before, after in pairwise(whole):
            assert (after <= before + 1e-9).all()


def test_teams_of_all_motions_in_two_costs(scenes) -> None:
    problem = moved(scenes.antipodal(3, costs=("length", "duration")), *PLANNING_MOTIONS)
    result = plan(problem, seed=2, samples=800)
    assert result.status == Status.DONE
    verified(problem, result)
    assert result.costs[:, 0].max() < 17.0  # 15.5 m alone
    assert result.costs[:, 1].max() < 22.0


@pytest.mark.parametrize("motion", CURVED)
def test_the_same_seed_gives_the_same_plan(scenes, motion: str) -> None:
    problem = moved(scenes.antipodal(2), motion)
    one, two = (plan(problem, seed=4, samples=500) for _ in range(2))
    other = plan(problem, seed=5, samples=500)
    assert all(np.array_equal(a, b) for a, b in zip(one.graphs, two.graphs, strict=True))
    assert np.array_equal(one.trajectories[0].pieces, two.trajectories[0].pieces)
    assert not np.array_equal(one.graphs[0], other.graphs[0])


@pytest.mark.parametrize("motion", CURVED)
def test_mode_paper(scenes, motion: str) -> None:
    """Edges from older to newer vertices alone, and uniform samples: still plans that hold."""
    problem = moved(scenes.antipodal(2), motion)
    result = plan(problem, seed=1, samples=1500, mode="paper", shortcut_tries=0)
    verified(problem, result)
    assert min(len(graph) for graph in result.graphs) > 100


@pytest.mark.parametrize("motion", CURVED)
def test_nobody_can_do_better_on_the_final_graphs(scenes, motion: str) -> None:
    """The graphs follow from their vertices, and on them nobody gains."""
    problem = moved(scenes.antipodal(3), motion)
    result = plan(problem, seed=6, samples=400)
    team = build_team(problem, INash(), 0)
    for robot in range(team.size):
        graph = team.graphs[robot]
        assert graph.insert(result.graphs[robot][1:]) == len(result.graphs[robot]) - 1
        team.traffic.put(robot, result.trajectories[robot].pieces)
    for robot in range(team.size):
        best = team.best_path(robot, team.everybody())
        assert best is not None
        assert best.cost >= result.costs[robot, 0] - 1e-9


def test_what_moves_at_the_start_goes_on_from_there(scenes) -> None:
    goal = scenes.disc("goal", 16.0, 10.0)
    robots = (
        PlanningRobot("drift", (4.0, 4.0, 0.0, 0.8), "F goal", goal, motion=DOUBLE_INTEGRATOR),
        PlanningRobot("away", (8.0, 10.0, math.pi), "F goal", goal, motion=DUBINS_CAR,
                      after_arrival="vanish"),
    )  # fmt: skip
    problem = PlanningProblem(scenes.square, robots, 60.0)
    result = plan(problem, seed=1, samples=1500)
    assert result.status == Status.DONE
    verified(problem, result)
    drift, away = result.trajectories
    assert np.allclose(velocities(drift, 0.0)[0], (0.0, 0.8), atol=1e-9)
    # The car has to turn round: a half circle of half a metre's radius at least, and its distance.
    assert result.costs[1, 0] >= 7.5 + math.pi * 0.5 - 1.0
    assert math.dist(end_position(away), (16.0, 10.0)) <= 0.5


def test_bounds_matter(scenes) -> None:
    """What turns wider drives farther, what accelerates less takes longer."""
    goal = scenes.disc("goal", 6.0, 10.0, 0.3)
    lengths, durations = [], []
    for bound in (0.5, 2.0):
        car = PlanningRobot("a", (10.0, 10.0, 0.0), "F goal", goal, motion=DUBINS_CAR,
                            turning_radius_m=bound)  # fmt: skip
        block = PlanningRobot("a", (10.0, 10.0, 0.0, 0.0), "F goal", goal, acceleration_mps2=bound,
                              motion=DOUBLE_INTEGRATOR)  # fmt: skip
        for robot, costs, found in ((car, ("length",), lengths), (block, ("duration",), durations)):
            problem = PlanningProblem(scenes.square, (robot,), 40.0, costs=costs)
            result = plan(problem, seed=1, samples=600)
            verified(problem, result)
            found.append(float(result.costs[0, 0]))
    assert lengths[0] + 1.0 < lengths[1]
    assert durations[1] + 1.0 < durations[0]


def test_what_is_no_motion_or_start_is_told(scenes) -> None:
    def problem(**changes) -> PlanningProblem:
        robot = replace(scenes.antipodal(2).robots[0], **changes)
        return PlanningProblem(scenes.square, (robot,), 60.0)

    with pytest.raises(InputError, match="not known; use one of: single-integrator"):
        plan(problem(motion="hovercraft"), samples=10)
    with pytest.raises(InputError, match="robot r0: starts at 2 numbers, and a dubins-car at 3"):
        plan(problem(motion=DUBINS_CAR), samples=10)
    with pytest.raises(InputError, match="turning radius of 0"):
        plan(problem(motion=DUBINS_CAR, start=(3, 3, 0), turning_radius_m=0.0), samples=10)
    fast = plan(problem(motion=DOUBLE_INTEGRATOR, start=(3, 3, 1.0, 1.0)), samples=10)
    assert fast.status == Status.INFEASIBLE
    assert fast.reason == "robot r0: it starts at 1.41421 m/s, and its top speed is 1 m/s"
    with pytest.raises(InputError, match="use inash"):
        plan(moved(scenes.antipodal(2), DUBINS_CAR), "social-optimum", samples=10)


@st.composite
def small_scenes(draw) -> PlanningProblem:
    """Two or three robots of any motions in a room with a disc, some of which pass on the way."""
    place = st.tuples(st.floats(1, 7), st.floats(1, 5))
    robots = []
    starts: list[tuple[float, float]] = []
    for number in range(draw(st.integers(2, 3))):
        x, y = draw(place.filter(lambda p: all(math.dist(p, q) > 0.9 for q in starts)))
        starts.append((x, y))
        motion = draw(st.sampled_from(PLANNING_MOTIONS))
        start = {
            DOUBLE_INTEGRATOR: (x, y, draw(st.floats(-0.5, 0.5)), draw(st.floats(-0.5, 0.5))),
            DUBINS_CAR: (x, y, draw(st.floats(-3, 3))),
        }.get(motion, (x, y))
        regions = {
            "goal": Region("goal", disc=(*draw(place), 0.4)),
            "mud": Region(
                "mud", polygon=np.array([(3.0, 0.5), (4.0, 0.5), (4.0, 3.0), (3.0, 3.0)])
            ),
        }
        task = draw(st.sampled_from(["F goal", "F goal & G !mud", "F mud & F goal"]))
        robots.append(
            PlanningRobot(
                f"r{number}", start, task, regions, draw(st.floats(0.1, 0.4)), motion=motion,
                acceleration_mps2=draw(st.floats(0.3, 2)), turning_radius_m=draw(st.floats(0.1, 1)),
                after_arrival=draw(st.sampled_from(["stay", "vanish"])),
            )
        )  # fmt: skip
    floor = PolygonMap([(0, 0), (8, 0), (8, 6), (0, 6)])
    return PlanningProblem(floor, tuple(robots), 30.0, np.array([(5.5, 3.0, 0.4)]), margin_m=0.05)


@settings(max_examples=25, deadline=None)
@given(small_scenes(), st.sampled_from(SOLVERS), st.integers(0, 5))
def test_every_plan_is_verified(problem: PlanningProblem, solver: str, seed: int) -> None:
    verified(problem, plan(problem, solver, seed=seed, samples=150))
