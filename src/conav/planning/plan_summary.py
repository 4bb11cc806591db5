"""What is reported of a plan: for programs as one object, and the least clearance in it."""

from collections.abc import Sequence
from itertools import combinations
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.planning.trajectory import length, polyline
from conav.planning.types import PlanningProblem, PlanningResult, Trajectory

TOLERANCE_M = 1e-4  # [m] that curved ways are taken apart from straight ones


def plan_summary(
    problem: PlanningProblem,
    result: PlanningResult,
    *,
    solver: str,
    seed: int,
    compute_s: float,
    first_solution_compute_s: float | None = None,
    interrupted: bool = False,
) -> dict[str, Any]:
    """The object that `conav plan --json` prints; what is unknown or infinite is None in it.

    Costs, lower bound and ratio of the sum are those of the first component. `min_clearance_m` is
    what stays between two robots at least, beyond both radii.
    """
    robots = [_robot(problem, result, index) for index in range(len(problem.robots))]
    total = _finite(float(result.costs[:, 0].sum()))
    bound = result.lower_bound
    ratio = total / bound if total is not None and bound is not None and bound > 0 else None
    counters = result.counters
    return {
        "job": "plan",
        "scene": problem.name,
        "solver": solver,
        "seed": seed,
        "status": str(result.status),
        "reason": result.reason,
        "costs": list(problem.costs),
        "robots": robots,
        "sum_cost": total,
        "lower_bound": bound,
        "graph_bound": result.graph_bound,
        "ratio": ratio,
        "min_clearance_m": min_clearance(problem, result.trajectories),
        "vertices": counters.get("vertices", 0),
        "iterations": counters.get("iterations", 0),
        "messages": counters.get("messages", 0),
        "counters": dict(counters),
        "first_solution_compute_s": first_solution_compute_s,
        "compute_s": compute_s,
        "interrupted": interrupted,
        "run": None,
        "warnings": list(problem.floor.warnings),
    }


def min_clearance(
    problem: PlanningProblem, trajectories: Sequence[Trajectory | None]
) -> float | None:
    """The least distance between two discs at any time [m], negative where they overlap.

    Closed form for straight motions; for curved ones, which are cut into straight stretches, at
    most 4 `TOLERANCE_M` less than the truth and never more. Robots that stay are there until the
    horizon, those without a trajectory nowhere. None for fewer than two trajectories.
    """
    return min((each.clearance_m for each in pair_clearances(problem, trajectories)), default=None)


class Nearest(NamedTuple):
    """How near two robots come to each other, beyond both radii, and when first so near."""

    robots: tuple[int, int]
    clearance_m: float
    time_s: float


def pair_clearances(
    problem: PlanningProblem, trajectories: Sequence[Trajectory | None]
) -> list[Nearest]:
    """`min_clearance` of each two robots that have a trajectory."""
    ways = [_way(problem, index, item) for index, item in enumerate(trajectories)]
    found: list[Nearest] = []
    for i, j in combinations(range(len(ways)), 2):
        a, b = ways[i], ways[j]
        if a is None or b is None:
            continue
        curved = _is_curved(trajectories[i]) + _is_curved(trajectories[j])
        reach = problem.robots[i].radius_m + problem.robots[j].radius_m
        distance, time_s = _least_distance(a, b)
        found.append(Nearest((i, j), distance - reach - curved * TOLERANCE_M, time_s))
    return found


def _robot(problem: PlanningProblem, result: PlanningResult, index: int) -> dict[str, Any]:
    trajectory = result.trajectories[index]
    return {
        "name": problem.robots[index].name,
        "cost": [_finite(value) for value in result.costs[index].tolist()],
        "length_m": None if trajectory is None else length(trajectory),
        "arrival_s": None if trajectory is None else trajectory.arrival_s,
        "epsilon": None if result.epsilon is None else _finite(float(result.epsilon[index])),
        "solo_m": None if result.solo is None else _finite(float(result.solo[index, 0])),
    }


def _way(
    problem: PlanningProblem, index: int, trajectory: Trajectory | None
) -> NDArray[np.float64] | None:
    """Points of a way, shape (n, 3): x, y [m], time [s], straight between, until it is gone."""
    if trajectory is None:
        return None
    points = polyline(trajectory, TOLERANCE_M)
    if problem.robots[index].after_arrival == "vanish":
        return points
    last = points[-1].copy()
    last[2] = max(problem.horizon_s, last[2])
    return np.vstack([points, last])


def _is_curved(trajectory: Trajectory | None) -> bool:
    return trajectory is not None and bool(trajectory.pieces[:, 6:].any())


def _least_distance(a: NDArray[np.float64], b: NDArray[np.float64]) -> tuple[float, float]:
    """The least distance of two ways while both last, and the first time they are so near."""
    end = min(a[-1, 2], b[-1, 2])
    times = np.unique(np.concatenate([a[:, 2], b[:, 2]]))
    times = times[times <= end]
    gap = np.stack([np.interp(times, a[:, 2], a[:, k]) - np.interp(times, b[:, 2], b[:, k])
                    for k in (0, 1)], axis=1)  # fmt: skip
    drift = np.diff(gap, axis=0)
    square = (drift * drift).sum(axis=1)
    towards = -(gap[:-1] * drift).sum(axis=1)
    share = np.clip(towards / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    nearest = np.concatenate([gap[:1], gap[:-1] + share[:, np.newaxis] * drift, gap[-1:]])
    when = np.concatenate([times[:1], times[:-1] + share * np.diff(times), times[-1:]])
    distances = np.sqrt((nearest * nearest).sum(axis=1))
    first = int(distances.argmin())
    return float(distances[first]), float(when[first])


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None
