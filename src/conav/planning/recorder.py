"""Writing the run of a solver: the problem, what it found as it came, the result, ROS 2 topics."""

import os
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from math import isfinite
from types import TracebackType
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from conav.planning.budget import Progress
from conav.planning.plan_topics import write_motion, write_scenery
from conav.planning.recorded import problem_record
from conav.planning.types import PlanningProblem, PlanningResult, Trajectory
from conav.runs.plan_writer import PlanWriter
from conav.runs.schemas import FORMAT


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
        write_scenery(self._writer, problem)
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
        write_motion(self._writer, self._problem, self._trajectories)
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
