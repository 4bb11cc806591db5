"""What the events of each job between header and result add up to."""

from math import isfinite
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.runs.mcap_records import Damage
from conav.runs.schemas import (
    GRAPH,
    GRAPH_TOPIC,
    IMPROVEMENT_TOPIC,
    STEP,
    STEP_TOPIC,
    TRAJECTORY,
    TRAJECTORY_TOPIC,
    WORLD,
    WORLD_TOPIC,
    decode,
    decode_object,
)
from conav.runs.types import ExplorationRun, PlanRun, Run, StepRecord, TrajectoryRecord

_PIECE = 9  # numbers of a piece of a trajectory


class JobEvents(Protocol):
    """The events of a run so far."""

    @property
    def begun(self) -> bool:
        """Whether what was read makes a run, were it only its beginning."""
        ...

    def take(self, topic: str, data: bytes) -> None:
        """Take in the next event. Raises `Damage` when it comes out of turn."""
        ...

    def run(self, **common: Any) -> Run:
        """The run; `common` is what `Run` has. Raises `InputError` where it makes no sense."""
        ...


class ExplorationEvents:
    """The true map, then the steps."""

    def __init__(self) -> None:
        self._world: Any = None
        self._steps: list[StepRecord] = []

    @property
    def begun(self) -> bool:
        return self._world is not None

    def take(self, topic: str, data: bytes) -> None:
        if topic == WORLD_TOPIC and self._world is None:
            self._world = decode(data, WORLD)
        elif topic == STEP_TOPIC and self._world is not None:
            message = decode(data, STEP)
            self._steps.append(StepRecord(*(getattr(message, name) for name in StepRecord._fields)))
        else:
            raise Damage

    def run(self, **common: Any) -> ExplorationRun:
        world = self._world
        numbers = (world.resolution, *world.origin)
        cells = np.asarray(world.cells, dtype=np.uint8)
        if (
            world.rows * world.cols != len(cells)
            or len(cells) == 0
            or int(cells.max()) > 2
            or not all(isfinite(number) for number in numbers)
            or world.resolution <= 0
        ):
            raise InputError(common["path"], "holds a map that is none", "the file is damaged")
        return ExplorationRun(
            **common,
            cells=cells.reshape(world.rows, world.cols),
            resolution=float(world.resolution),
            origin=(float(world.origin[0]), float(world.origin[1]), float(world.origin[2])),
            steps=self._steps,
        )


class PlanEvents:
    """Improvements with their trajectories, then graphs."""

    def __init__(self) -> None:
        self._history: list[dict[str, Any]] = []
        self._trajectories: list[TrajectoryRecord] = []
        self._graphs: dict[int, NDArray[np.float64]] = {}

    @property
    def begun(self) -> bool:
        return True  # the header says all of the problem

    def take(self, topic: str, data: bytes) -> None:
        if topic == IMPROVEMENT_TOPIC:
            self._history.append(decode_object(data))
        elif topic == TRAJECTORY_TOPIC:
            message = decode(data, TRAJECTORY)
            pieces = np.asarray(message.pieces, dtype=np.float64).reshape(-1, _PIECE)
            self._trajectories.append(
                TrajectoryRecord(int(message.robot), len(self._history), pieces)
            )
        elif topic == GRAPH_TOPIC:
            message = decode(data, GRAPH)
            vertices = np.asarray(message.vertices, dtype=np.float64)
            self._graphs[int(message.robot)] = vertices.reshape(-1, int(message.columns))
        else:
            raise Damage

    def run(self, **common: Any) -> PlanRun:
        return PlanRun(
            **common,
            history=self._history,
            trajectories=self._trajectories,
            graphs=self._graphs,
        )


JOBS: dict[str, type[JobEvents]] = {"explore": ExplorationEvents, "plan": PlanEvents}
"""By the job in a run's header."""
