"""Writing the run of a solver: the problem, what it found as it came, the result, ROS 2 topics."""

import os
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from math import atan2, cos, isfinite, pi, sin
from types import TracebackType
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from conav.planning.budget import Progress
from conav.planning.recorded import problem_record
from conav.planning.trajectory import headings, polyline, positions
from conav.planning.types import DUBINS_CAR, PlanningProblem, PlanningResult, Region, Trajectory
from conav.runs.plan_writer import PlanWriter
from conav.runs.scenery_writer import Colour
from conav.runs.schemas import FORMAT
from conav.runs.topic_names import topic_names

POSE_EVERY_S = 0.2  # [s] of the plan, between two poses on the ROS topics
_CIRCLE = 48  # corners of a disc that is drawn as a line

_WALL: Colour = (0.2, 0.2, 0.2, 1.0)
_OBSTACLE: Colour = (0.4, 0.4, 0.4, 1.0)
_REGION: Colour = (0.1, 0.6, 0.3, 0.8)
_ROBOT: Colour = (0.1, 0.4, 0.8, 0.9)


class PlanRecorder:
    """Writes a solver's run to one file, a context manager.

    The header is written at once, improvements as they come, so that a killed solver leaves the
    best plan it had. Raises `InputError` when the file cannot be written.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        problem: PlanningProblem,
        *,
        solver: str,
        settings: Mapping[str, Any],
        seed: int,
    ) -> None:
        self._problem = problem
        self._trajectories: list[Trajectory | None] = [None] * len(problem.robots)
        self._entries = 0  # of the history, written
        self._names = topic_names([robot.name for robot in problem.robots])
        self._writer = PlanWriter(path)
        header = {
            "format": FORMAT,
            "job": "plan",
            "problem": problem_record(problem),
            "solver": solver,
            "settings": dict(settings),
            "seed": seed,
        }
        self._writer.header(header)
        self._scenery()
        self._writer.flush()

    def __enter__(self) -> "PlanRecorder":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._writer.close()

    @property
    def digest(self) -> str:
        """The digest of the events written so far."""
        return self._writer.digest

    def improvement(
        self, entry: Mapping[str, Any], trajectories: Sequence[Trajectory | None]
    ) -> None:
        """Write an entry of the history (plain JSON, no wall times) and what has changed."""
        self._writer.improvement(_plain(entry))
        self._entries += 1
        self._changed(trajectories)

    def follow(self, progress: Progress) -> None:
        """Write what a solver has found since it was last listened to; give it as `on_progress`.

        Entries of the history that came together lead to the plan as it is after the last.
        """
        fresh = progress.history[self._entries :]
        if fresh:
            for entry in fresh:
                self._writer.improvement(_plain(entry))
            self._entries += len(fresh)
            self._changed(progress.trajectories())

    def finish(
        self, result: PlanningResult, *, compute_s: float, interrupted: bool = False
    ) -> None:
        """Write the rest of the history, the result and its graphs, then paths and poses for ROS 2.

        `compute_s` is wall time, and no part of the digest.
        """
        for entry in result.history[self._entries :]:
            self._writer.improvement(_plain(entry))
        self._changed(result.trajectories)
        for robot, vertices in enumerate(result.graphs):
            self._writer.graph(robot, vertices)
        found = [one for one in result.trajectories if one is not None]
        end_s = max((one.arrival_s for one in found), default=0.0)
        self._writer.result(
            round(end_s * 1e9),
            {
                "status": str(result.status),
                "reason": result.reason,
                "costs": _numbers(result.costs),
                "epsilon": _numbers(result.epsilon),
                "solo": _numbers(result.solo),
                "lower_bound": result.lower_bound,
                "graph_bound": result.graph_bound,
                "counters": {key: int(value) for key, value in result.counters.items()},
                "interrupted": interrupted,
            },
        )
        self._writer.flush()
        self._paths(end_s)
        self._writer.timing(
            {
                "compute_s": f"{compute_s:.6f}",
                "python": platform.python_version(),
                "machine": platform.machine(),
                **{name: version(name) for name in ("conav", "numpy", "numba")},
            }
        )

    def _changed(self, trajectories: Sequence[Trajectory | None]) -> None:
        for robot, (old, new) in enumerate(zip(self._trajectories, trajectories, strict=True)):
            if old is new or (
                old is not None and new is not None and np.array_equal(old.pieces, new.pieces)
            ):
                continue
            self._writer.trajectory(robot, None if new is None else new.pieces)
            self._trajectories[robot] = new

    def _scenery(self) -> None:
        problem = self._problem
        lines = [("walls", ring, _WALL) for ring in problem.floor.rings]
        for robot in problem.robots:
            lines += [
                (f"{robot.name}/{key}", _outline(region), _REGION)
                for key, region in robot.regions.items()
            ]
        round_ones = [("obstacles", "map", disc, _OBSTACLE) for disc in _discs(problem.discs)]
        round_ones += [
            ("robots", f"{name}/base_link", (0.0, 0.0, robot.radius_m), _ROBOT)
            for name, robot in zip(self._names, problem.robots, strict=True)
        ]
        self._writer.scenery("/scene", lines, round_ones)

    def _paths(self, end_s: float) -> None:
        """Paths at once, then poses in the order of their times."""
        moving = [
            (name, robot, one, robot.start[2] if robot.motion == DUBINS_CAR else 0.0)
            for name, robot, one in zip(
                self._names, self._problem.robots, self._trajectories, strict=True
            )
            if one is not None
        ]
        for name, _, one, first in moving:
            points = polyline(one)
            facing = headings(one, points[:, 2], first).tolist()
            poses = [(t, x, y, yaw) for (x, y, t), yaw in zip(points.tolist(), facing, strict=True)]
            self._writer.way(f"/{name}/path", poses)
        times = np.append(np.arange(0.0, end_s, POSE_EVERY_S), end_s)
        places = [positions(one, times).tolist() for _, _, one, _ in moving]
        yaws = [headings(one, times, first).tolist() for _, _, one, first in moving]
        for k, t in enumerate(times.tolist()):
            here = [
                i
                for i, (_, robot, one, _) in enumerate(moving)
                if robot.after_arrival == "stay" or t <= one.arrival_s
            ]
            self._writer.poses(
                round(t * 1e9),
                [moving[i][0] for i in here],
                [(*places[i][k], _wrapped(yaws[i][k])) for i in here],
            )


def _wrapped(angle: float) -> float:
    return atan2(sin(angle), cos(angle))


def _outline(region: Region) -> NDArray[np.float64]:
    if region.polygon is not None:
        return region.polygon
    assert region.disc is not None
    x, y, radius = region.disc
    angles = 2.0 * pi * np.arange(_CIRCLE) / _CIRCLE
    return np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])


def _discs(discs: NDArray[np.float64]) -> list[tuple[float, float, float]]:
    return [(x, y, radius) for x, y, radius in discs.tolist()]


def _plain(value: Any) -> Any:
    """JSON without infinite numbers: None in their place."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in cast("Mapping[Any, Any]", value).items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in cast("Sequence[Any]", value)]
    return None if isinstance(value, float) and not isfinite(value) else value


def _numbers(array: NDArray[np.float64] | None) -> Any:
    """An array as lists, None where a number is infinite or all is unknown."""
    return None if array is None else _plain(array.tolist())
