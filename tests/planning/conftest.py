"""Scenes several tests plan in: the fixture `scenes` has a function for each."""

import math
from itertools import combinations, pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import shapely

from conav.maps.polygon_map import PolygonMap
from conav.planning.types import PlanningProblem, PlanningResult, PlanningRobot, Region
from conav.runs.types import PlanRun

from .hand_plan import hand_problem, hand_result, write_plan

SQUARE = PolygonMap([(0, 0), (20, 0), (20, 20), (0, 20)])


def disc(name: str, x: float, y: float, radius: float = 0.5) -> dict[str, Region]:
    return {name: Region(name, disc=(x, y, radius))}


def antipodal(
    count: int, radius: float = 0.5, after: str = "stay", costs: tuple[str, ...] = ("length",)
) -> PlanningProblem:
    """Robots on a circle that want to the other side."""
    robots = []
    for i in range(count):
        dx, dy = 8 * math.cos(2 * math.pi * i / count), 8 * math.sin(2 * math.pi * i / count)
        goal = disc("goal", 10 - dx, 10 - dy)
        robots.append(
            PlanningRobot(f"r{i}", (10 + dx, 10 + dy), "F goal", goal, radius, after_arrival=after)
        )
    return PlanningProblem(SQUARE, tuple(robots), 60.0, costs=costs)


def bay() -> PlanningProblem:
    """Two robots swap in a corridor: one must wait in the bay."""
    floor = PolygonMap([(0, 0), (10, 0), (10, 1), (5.5, 1), (5.5, 2), (4.5, 2), (4.5, 1), (0, 1)])
    robots = (
        PlanningRobot("a", (1.0, 0.5), "F goal", disc("goal", 9.0, 0.5, 0.3), 0.3),
        PlanningRobot("b", (9.0, 0.5), "F goal", disc("goal", 1.0, 0.5, 0.3), 0.3),
    )
    return PlanningProblem(floor, robots, 60.0)


def discs(count: int, seed: int) -> np.ndarray:
    """Discs in the square, away from its border and each other."""
    random = np.random.default_rng(seed)
    found: list[tuple[float, float, float]] = []
    while len(found) < count:
        x, y = random.uniform(3, 17, 2)
        r = random.uniform(0.4, 1.0)
        if all(math.hypot(x - u, y - v) > r + s + 1.2 for u, v, s in found):
            found.append((x, y, r))
    return np.array(found)


def errand() -> PlanningProblem:
    """One robot with two places to be at and one to stay out of, among discs."""
    regions = {
        **disc("dock", 17, 3, 0.6),
        "shelf": Region("shelf", polygon=np.array([(2, 15), (4, 15), (4, 18), (2, 18)])),
        **disc("pit", 10, 10, 1.5),
    }
    robot = PlanningRobot("a", (2.0, 2.0), "F dock & F shelf & G !pit", regions, 0.4)
    return PlanningProblem(SQUARE, (robot,), 90.0, discs(8, 3))


def check(problem: PlanningProblem, result: PlanningResult) -> None:
    """Every trajectory is driven as its robot can, free of walls and discs, and apart."""
    walls = shapely.boundary(problem.floor.polygon)
    for robot, trajectory, costs in zip(
        problem.robots, result.trajectories, result.costs, strict=True
    ):
        if trajectory is None:
            assert np.isinf(costs).all()
            continue
        pieces = trajectory.pieces
        t0, t1, x, y, vx, vy = pieces[:, :6].T
        assert t0[0] == 0.0
        assert (x[0], y[0]) == robot.start
        assert np.array_equal(t0[1:], t1[:-1])
        assert t1[-1] <= problem.horizon_s
        assert np.abs(x[1:] - (x + vx * (t1 - t0))[:-1]).max(initial=0) < 1e-9
        assert np.abs(y[1:] - (y + vy * (t1 - t0))[:-1]).max(initial=0) < 1e-9
        assert np.hypot(vx, vy).max() <= robot.speed_mps * (1 + 1e-9)
        length = float((np.hypot(vx, vy) * (t1 - t0)).sum())
        by_name = {"length": length, "duration": t1[-1]}
        for component, cost in zip(problem.costs, costs, strict=True):
            assert math.isclose(cost, by_name[component], abs_tol=1e-9)
        for row in pieces:
            end = row[2:4] + row[4:6] * (row[1] - row[0])
            way = shapely.LineString([row[2:4], end])
            assert walls.distance(way) >= robot.radius_m - 1e-9
            for u, v, r in problem.discs:
                assert shapely.Point(u, v).distance(way) >= robot.radius_m + r - 1e-9
        if robot.task == "F goal":
            at = shapely.Point(end)
            assert (
                at.distance(shapely.Point(robot.regions["goal"].disc[:2]))
                <= (robot.regions["goal"].disc[2])
            )
    driving = [i for i, each in enumerate(result.trajectories) if each is not None]
    for i, j in combinations(driving, 2):
        needed = problem.robots[i].radius_m + problem.robots[j].radius_m + problem.margin_m
        assert apart(problem, result, i, j) >= needed - 1e-9


def apart(problem: PlanningProblem, result: PlanningResult, i: int, j: int) -> float:
    """The least distance of two robots: between all times at which one of them turns."""
    tracks = []
    for robot in (i, j):
        pieces = result.trajectories[robot].pieces
        end = pieces[-1]
        points = [(row[0], row[2], row[3]) for row in pieces]
        dt = end[1] - end[0]
        points.append((end[1], end[2] + end[4] * dt, end[3] + end[5] * dt))
        if problem.robots[robot].after_arrival == "stay":
            points.append((problem.horizon_s, *points[-1][1:]))
        tracks.append(np.array(points))
    last = min(track[-1, 0] for track in tracks)
    times = np.unique(np.concatenate([track[:, 0] for track in tracks]))
    times = times[times <= last]
    at = [
        np.column_stack([np.interp(times, track[:, 0], track[:, k]) for k in (1, 2)])
        for track in tracks
    ]
    between = at[0] - at[1]
    least = np.inf
    for a, b in pairwise(between):
        least = min(least, shapely.Point(0, 0).distance(shapely.LineString([a, b])))
    return least


@pytest.fixture(scope="session")
def scenes() -> SimpleNamespace:
    return SimpleNamespace(
        antipodal=antipodal,
        bay=bay,
        errand=errand,
        discs=discs,
        disc=disc,
        square=SQUARE,
        check=check,
    )


@pytest.fixture
def hand_run(tmp_path: Path) -> PlanRun:
    """The run of a plan made by hand."""
    problem = hand_problem()
    return write_plan(tmp_path / "plan.mcap", problem, hand_result(problem))
