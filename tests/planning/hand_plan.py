"""A plan made by hand, and what a solver would say of it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from conav.maps.polygon_map import PolygonMap
from conav.planning.recorder import PlanRecorder
from conav.planning.trajectory import cost, straight
from conav.planning.types import (
    PlanningProblem,
    PlanningResult,
    PlanningRobot,
    Region,
    Trajectory,
)
from conav.runs.reader import read_plan
from conav.runs.types import PlanRun
from conav.status import Status

ROOM = [(0, 0), (10, 0), (10, 6), (0, 6)]
HOLE = [(4, 2), (4, 4), (6, 4), (6, 2)]


def hand_problem(**changes: Any) -> PlanningProblem:
    """Two robots around a pillar: one drives below it and one above; a disc in a corner."""
    west, east = Region("west", disc=(1, 3, 0.5)), Region("east", disc=(9, 3, 0.5))
    lawn = Region("lawn", polygon=np.array([(6.5, 4.5), (9.5, 4.5), (9.5, 5.8), (6.5, 5.8)]))
    regions = {"west": west, "east": east, "lawn": lawn}
    robots = (
        PlanningRobot("ann", (1, 3), "F east & G !lawn", regions, radius_m=0.3),
        PlanningRobot("bob", (9, 3), "F west & F lawn", regions, radius_m=0.4, speed_mps=1.5),
    )
    problem = PlanningProblem(
        floor=PolygonMap(ROOM, [HOLE], "pillar"),
        robots=robots,
        horizon_s=30.0,
        discs=np.array([(0.6, 5.4, 0.5)]),
        costs=("length", "duration"),
        margin_m=0.1,
        name="hand",
    )
    return replace(problem, **changes)


def hand_trajectories() -> tuple[Trajectory, Trajectory]:
    ann = straight([(1, 3), (4, 1.5), (6, 1.5), (9, 3)], [0, 5, 8, 12])
    bob = straight([(9, 3), (7, 5), (4, 4.5), (1, 4.2), (1, 3.45)], [0, 4, 8, 13, 14])
    return ann, bob


def hand_result(problem: PlanningProblem, **changes: Any) -> PlanningResult:
    trajectories = hand_trajectories()
    result = PlanningResult(
        status=Status.DONE,
        reason="",
        trajectories=trajectories,
        costs=np.array([cost(one, problem.costs) for one in trajectories]),
        epsilon=None,
        solo=None,
        lower_bound=None,
        counters={"samples": 7},
        history=({"round": 0, "sum": 30.0},),
    )
    return replace(result, **changes)


def write_plan(
    path: Path,
    problem: PlanningProblem,
    result: PlanningResult,
    solver: str = "by-hand",
    settings: dict[str, Any] | None = None,
) -> PlanRun:
    with PlanRecorder(path, problem, solver=solver, settings=settings or {}, seed=3) as recorder:
        recorder.improvement({"round": 0, "sum": 30.0}, result.trajectories)
        recorder.finish(result, compute_s=0.25)
    return read_plan(path)
