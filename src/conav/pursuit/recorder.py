"""Writing the run of a pursuit: problem, schedule, beliefs, result, and topics for ROS 2."""

import os
import platform
from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import version
from math import atan2
from typing import Any

import numpy as np

from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult
from conav.runs.pursuit_writer import PursuitWriter
from conav.runs.scenery_writer import Colour
from conav.runs.schemas import FORMAT
from conav.runs.topic_names import topic_names

POSE_EVERY_S = 0.5  # [s] of the schedule, between two poses on the ROS topics

_WALL: Colour = (0.2, 0.2, 0.2, 1.0)


def record_pursuit(
    path: str | os.PathLike[str],
    problem: PursuitProblem,
    result: PursuitResult,
    *,
    method: str,
    settings: Mapping[str, Any],
    seed: int,
    compute_s: float,
) -> str:
    """The digest of the run file this writes.

    `settings` are plain JSON; `compute_s` is wall time, and no part of the digest. Raises
    `InputError` when the file cannot be written.
    """
    with PursuitWriter(os.fspath(path)) as writer:
        writer.header(
            {
                "format": FORMAT,
                "job": "pursue",
                "floor": {
                    "name": problem.floor.name,
                    "outer": problem.floor.outer.tolist(),
                    "holes": [hole.tolist() for hole in problem.floor.holes],
                },
                "name": problem.name,
                "known": problem.known,
                "most": problem.most,
                "begin_with": len(problem.pursuers),
                "pursuers": [_pursuer(one) for one in result.pursuers],
                "faults": [asdict(fault) for fault in problem.faults],
                "method": method,
                "settings": dict(settings),
                "seed": seed,
            }
        )
        writer.scenery("/floor", [("walls", ring, _WALL) for ring in problem.floor.rings], [])
        _legs(writer, result)
        schedule = result.schedule
        writer.result(
            round(float(schedule.times[-1]) * 1e9),
            {
                "status": str(result.status),
                "reason": result.reason,
                "pursuers": len(result.pursuers),
                "legs": len(schedule.active),
                "time_s": float(schedule.times[-1] - schedule.times[0]),
                "distance_m": schedule.distance_m,
                "lower_bound": result.lower_bound,
                "minimal_proved": result.minimal_proved,
                "explored": result.explored,
                "recontaminations": result.recontaminations,
                "counters": {key: int(value) for key, value in result.counters.items()},
                "history": [dict(entry) for entry in result.history],
            },
        )
        _poses(writer, result)
        writer.timing(
            {
                "compute_s": f"{compute_s:.6f}",
                "python": platform.python_version(),
                "machine": platform.machine(),
                **{name: version(name) for name in ("conav", "numpy", "numba", "shapely")},
            }
        )
        return writer.digest


def _pursuer(one: Pursuer) -> dict[str, Any]:
    return {
        "name": one.name,
        "start": list(one.start),
        "speed_mps": one.speed_mps,
        "range_m": one.range_m,
        "reach_m": one.reach_m,
    }


def _legs(writer: PursuitWriter, result: PursuitResult) -> None:
    schedule = result.schedule
    times = schedule.times.tolist()
    for m in range(len(schedule.active)):
        writer.leg(
            times[m],
            times[m + 1],
            schedule.positions[m],
            schedule.positions[m + 1],
            schedule.active[m],
        )
        if m in result.beliefs:
            regions = [(one.clear, (one.outer, *one.holes)) for one in result.beliefs[m]]
            writer.belief(times[m + 1], regions)


def _poses(writer: PursuitWriter, result: PursuitResult) -> None:
    """Poses at the ends of legs and between them, of those who are there."""
    schedule = result.schedule
    names = topic_names([one.name for one in result.pursuers])
    yaws = [0.0] * len(names)
    for m, active in enumerate(schedule.active):
        begin, end = schedule.times[m : m + 2].tolist()
        here = np.flatnonzero(active).tolist()
        before, after = schedule.positions[m], schedule.positions[m + 1]
        for i in here:
            dx, dy = (after[i] - before[i]).tolist()
            if dx != 0.0 or dy != 0.0:
                yaws[i] = atan2(dy, dx)
        last = m + 1 == len(schedule.active)
        times = np.arange(begin, end, POSE_EVERY_S).tolist() + ([end] if last else [])
        for t in times:
            share = (t - begin) / (end - begin) if end > begin else 1.0
            places = (before + share * (after - before)).tolist()
            writer.poses(
                round(t * 1e9),
                [names[i] for i in here],
                [(places[i][0], places[i][1], yaws[i]) for i in here],
            )
