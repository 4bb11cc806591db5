"""What the events of each job between header and result add up to."""

from itertools import pairwise
from math import isfinite
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.runs.mcap_records import Damage
from conav.runs.schemas import (
    BELIEF,
    BELIEF_TOPIC,
    DRIVEN_TOPIC,
    GRAPH,
    GRAPH_TOPIC,
    IMPROVEMENT_TOPIC,
    LEG,
    LEG_TOPIC,
    STEP,
    STEP_TOPIC,
    TRAJECTORY,
    TRAJECTORY_TOPIC,
    WORLD,
    WORLD_TOPIC,
    decode,
    decode_object,
)
from conav.runs.types import (
    ExecutionRun,
    ExplorationRun,
    LegRecord,
    PlanRun,
    PursuitRun,
    RegionRecord,
    Run,
    StepRecord,
    TrajectoryRecord,
)

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


class ExecutionEvents:
    """What was planned for each robot, then what it drove."""

    def __init__(self) -> None:
        self._planned: dict[int, NDArray[np.float64]] = {}
        self._driven: dict[int, NDArray[np.float64]] = {}

    @property
    def begun(self) -> bool:
        return True  # the header says all of the problem

    def take(self, topic: str, data: bytes) -> None:
        kept = {TRAJECTORY_TOPIC: self._planned, DRIVEN_TOPIC: self._driven}.get(topic)
        if kept is None:
            raise Damage
        message = decode(data, TRAJECTORY)
        if int(message.robot) in kept:
            raise Damage
        pieces = np.asarray(message.pieces, dtype=np.float64)
        kept[int(message.robot)] = pieces.reshape(-1, _PIECE)

    def run(self, **common: Any) -> ExecutionRun:
        return ExecutionRun(**common, planned=self._planned, driven=self._driven)


class PursuitEvents:
    """Legs, and what the team believes after some of them."""

    def __init__(self) -> None:
        self._legs: list[LegRecord] = []
        self._beliefs: dict[int, tuple[RegionRecord, ...]] = {}

    @property
    def begun(self) -> bool:
        return True  # the header says all of the problem

    def take(self, topic: str, data: bytes) -> None:
        if topic == LEG_TOPIC:
            message = decode(data, LEG)
            before, after = (
                np.array(places, dtype=np.float64).reshape(-1, 2)
                for places in (message.before, message.after)
            )
            active = np.array(message.active, dtype=np.uint8)
            if len(before) != len(active) or len(after) != len(active) or (active > 1).any():
                raise Damage
            self._legs.append(
                LegRecord(message.begin_s, message.end_s, before, after, active.astype(np.bool_))
            )
        elif topic == BELIEF_TOPIC:
            message = decode(data, BELIEF)
            if message.legs != len(self._legs) or message.legs - 1 in self._beliefs:
                raise Damage
            self._beliefs[int(message.legs) - 1] = _regions(message)
        else:
            raise Damage

    def run(self, **common: Any) -> PursuitRun:
        return PursuitRun(**common, legs=self._legs, beliefs=self._beliefs)


def _regions(message: Any) -> tuple[RegionRecord, ...]:
    ring_ends = [0, *message.ring_ends.tolist()]
    region_ends = [0, *message.region_ends.tolist()]
    rises = all(a < b for ends in (ring_ends, region_ends) for a, b in pairwise(ends))
    whole = ring_ends[-1] == len(message.outlines) and region_ends[-1] == len(ring_ends) - 1
    if not (rises and whole and len(message.clear) == len(region_ends) - 1):
        raise Damage
    outlines = np.array(message.outlines, dtype=np.float64)
    rings = [outlines[a:b].reshape(-1, 2) for a, b in pairwise(ring_ends)]
    return tuple(
        RegionRecord(bool(clear), tuple(rings[a:b]))
        for clear, (a, b) in zip(message.clear.tolist(), pairwise(region_ends), strict=True)
    )


JOBS: dict[str, type[JobEvents]] = {
    "explore": ExplorationEvents,
    "plan": PlanEvents,
    "execute": ExecutionEvents,
    "pursue": PursuitEvents,
}
"""By the job in a run's header."""
