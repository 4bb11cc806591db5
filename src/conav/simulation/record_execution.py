"""Writing the run of robots that drive a plan, and what is reported of it."""

import os
import platform
from importlib.metadata import version
from typing import Any

from conav.planning.plan_topics import write_motion, write_scenery
from conav.planning.recorded import problem_record
from conav.runs.plan_writer import PlanWriter
from conav.runs.schemas import FORMAT
from conav.simulation.execution import Execution


def record_execution(
    path: str | os.PathLike[str], execution: Execution, *, plan_digest: str, compute_s: float
) -> str:
    """The digest of the run file this writes.

    `plan_digest` is that of the run the plan came from; `compute_s` is wall time, and no part of
    the digest. Raises `InputError` when the file cannot be written.
    """
    with PlanWriter(path) as writer:
        writer.header(
            {
                "format": FORMAT,
                "job": "execute",
                "problem": problem_record(execution.problem),
                "plan": plan_digest,
                "tracking_error_m": execution.tracking_error_m,
                "delay_s": execution.delay_s,
                "slack_m": execution.slack_m,
                "seed": execution.seed,
            }
        )
        write_scenery(writer, execution.problem)
        for robot, way in enumerate(execution.planned):
            if way is not None:
                writer.trajectory(robot, way.pieces)
        end_s = 0.0
        for robot, way in enumerate(execution.driven):
            if way is not None:
                writer.driven(robot, way.pieces)
                end_s = max(end_s, way.arrival_s)
        writer.result(round(end_s * 1e9), _claims(execution))
        writer.flush()
        write_motion(writer, execution.problem, execution.driven)
        writer.timing(
            {
                "compute_s": f"{compute_s:.6f}",
                "python": platform.python_version(),
                "machine": platform.machine(),
                **{name: version(name) for name in ("conav", "numpy", "numba", "shapely")},
            }
        )
        return writer.digest


def execution_summary(execution: Execution) -> dict[str, Any]:
    """The object that `conav execute --json` prints."""
    problem = execution.problem
    return {
        "job": "execute",
        "scene": problem.name,
        "seed": execution.seed,
        "tracking_error_m": execution.tracking_error_m,
        "delay_s": execution.delay_s,
        "slack_m": execution.slack_m,
        "margin_m": execution.margin_m,
        "safe_margin_m": execution.safe_margin_m,
        **_claims(execution),
        "robots": [
            {
                "name": robot.name,
                "radius_m": robot.radius_m,
                "lag_s": lag,
                "deviation_m": deviation,
                "arrival_s": None if way is None else way.arrival_s,
            }
            for robot, lag, deviation, way in zip(
                problem.robots, execution.lags_s, execution.deviations_m, execution.driven,
                strict=True,
            )
        ],
        "run": None,
    }  # fmt: skip


def _claims(execution: Execution) -> dict[str, Any]:
    """What the run says of itself, and the verifier looks at again."""
    names = [robot.name for robot in execution.problem.robots]
    return {
        "touched": execution.touched,
        "touches": [
            {
                "robots": [names[robot] for robot in pair.robots],
                "depth_m": -pair.clearance_m,
                "time_s": pair.time_s,
            }
            for pair in execution.touches
        ],
        "wall_touches": [
            {"robot": names[each.robot], "depth_m": each.depth_m} for each in execution.wall_touches
        ],
        "clearance_m": execution.clearance_m,
        "wall_clearance_m": execution.wall_clearance_m,
        "deviation_m": execution.deviation_m,
        "lags_s": list(execution.lags_s),
        "tolerance_m": execution.tolerance_m,
    }
