"""A planning problem and trajectories as they stand in a run file, and back."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.planning.types import Coupling, PlanningProblem, PlanningRobot, Region, Trajectory
from conav.runs.types import PlanRun


def problem_record(problem: PlanningProblem) -> dict[str, Any]:
    """The whole problem as JSON, floats to the last digit; `recorded_problem` reads it."""
    return {
        "name": problem.name,
        "floor": {
            "name": problem.floor.name,
            "outer": problem.floor.outer.tolist(),
            "holes": [ring.tolist() for ring in problem.floor.holes],
        },
        "discs": problem.discs.tolist(),
        "horizon_s": float(problem.horizon_s),
        "margin_m": float(problem.margin_m),
        "costs": list(problem.costs),
        "robots": [_robot_record(robot) for robot in problem.robots],
        **(
            {"couplings": [_coupling_record(coupling) for coupling in problem.couplings]}
            if problem.couplings
            else {}
        ),
    }


def recorded_problem(run: PlanRun) -> PlanningProblem:
    """The problem in a run's header. Raises `InputError` where there is none."""
    try:
        problem = run.header["problem"]
        return PlanningProblem(
            floor=PolygonMap(
                problem["floor"]["outer"], problem["floor"]["holes"], problem["floor"]["name"]
            ),
            robots=tuple(_robot(robot) for robot in problem["robots"]),
            horizon_s=float(problem["horizon_s"]),
            discs=np.array(problem["discs"], dtype=np.float64).reshape(-1, 3),
            costs=tuple(problem["costs"]),
            margin_m=float(problem["margin_m"]),
            name=str(problem["name"]),
            couplings=tuple(_coupling(one) for one in problem.get("couplings", ())),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            run.path, f"has a header that cannot be used ({error!r})", "the file is damaged"
        ) from None


def recorded_trajectories(run: PlanRun) -> tuple[Trajectory | None, ...]:
    """The trajectories the robots had in the end, None where a robot had none."""
    found = (run.pieces(robot) for robot in range(len(run.header["problem"]["robots"])))
    return tuple(None if pieces is None else Trajectory(pieces) for pieces in found)


def _robot_record(robot: PlanningRobot) -> dict[str, Any]:
    return {
        "name": robot.name,
        "start": [float(number) for number in robot.start],
        "task": robot.task,
        "regions": {key: _region_record(region) for key, region in robot.regions.items()},
        "radius_m": float(robot.radius_m),
        "speed_mps": float(robot.speed_mps),
        "acceleration_mps2": float(robot.acceleration_mps2),
        "turning_radius_m": float(robot.turning_radius_m),
        "motion": robot.motion,
        "after_arrival": robot.after_arrival,
    }


def _coupling_record(coupling: Coupling) -> dict[str, Any]:
    record: dict[str, Any] = {"kind": coupling.kind, "robots": list(coupling.robots)}
    for key in ("region", "other_region"):
        region = getattr(coupling, key)
        if region is not None:
            record[key] = {"name": region.name, **_region_record(region)}
    if coupling.within_m is not None:
        record["within_m"] = float(coupling.within_m)
    return record


def _coupling(record: Mapping[str, Any]) -> Coupling:
    regions = {
        key: _region(str(record[key]["name"]), record[key])
        for key in ("region", "other_region")
        if key in record
    }
    a, b = record["robots"]
    return Coupling(record["kind"], (str(a), str(b)), within_m=record.get("within_m"), **regions)


def _region_record(region: Region) -> dict[str, Any]:
    if region.disc is not None:
        return {"disc": [float(number) for number in region.disc]}
    assert region.polygon is not None
    return {"polygon": region.polygon.tolist()}


def _robot(record: Mapping[str, Any]) -> PlanningRobot:
    content = dict(record)
    content["start"] = tuple(float(number) for number in content["start"])
    content["regions"] = {
        key: _region(key, region) for key, region in dict(content["regions"]).items()
    }
    return PlanningRobot(**content)


def _region(name: str, record: Mapping[str, Any]) -> Region:
    if "disc" in record:
        x, y, radius = record["disc"]
        return Region(name, disc=(float(x), float(y), float(radius)))
    return Region(name, polygon=np.array(record["polygon"], dtype=np.float64))
