"""The loop of an exploration: step until done, recording as it goes."""

import platform
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, is_dataclass
from importlib.metadata import version
from math import pi
from time import perf_counter
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from conav.exploration.metrics import ExplorationMetrics, exploration_metrics
from conav.exploration.types import ExplorationProblem, Strategy
from conav.maps.occupancy_grid import UNKNOWN
from conav.runs.exploration_writer import ExplorationWriter
from conav.runs.schemas import FORMAT
from conav.runs.types import OCCUPIED_BIT, StepRecord
from conav.simulation.conditions import to_come
from conav.simulation.engine import StepEvents, engine_for
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import ABSENT, ACTIVE, DEAD, STALLED, WorldState, new_world
from conav.status import Status

POSE_EVERY_S = 2.0  # [s] simulated, between two poses on the ROS topics
MAP_SHARES = 10  # keyframes of the team's map on the ROS topics
STILL_STEPS = 4096  # steps without a move after which a run is stuck

Progress = Callable[[WorldState], None]


class RobotEvent(NamedTuple):
    """Something that happened to a robot."""

    time_s: float  # [s] simulated
    robot: str
    event: str  # "died", "stalled", "went on" or "joined"


@dataclass(frozen=True, eq=False)
class ExplorationResult:
    """How an exploration ended."""

    status: Status
    metrics: ExplorationMetrics
    covered: tuple[int, ...]  # observable cells seen by the team after the looks of each step
    observable: int
    team_map: NDArray[np.uint8]  # (fine rows, fine cols) what the team knows together
    decision_ms: dict[str, float]  # wall time of one robot's decision: mean, p99, max
    compute_s: float  # wall time of the whole run
    interrupted: bool
    digest: str | None  # of the run file, if one was written
    events: tuple[RobotEvent, ...]  # who died, stalled, went on and joined, in order


def run_exploration(
    problem: ExplorationProblem,
    strategy: Strategy,
    *,
    name: str,
    writer: ExplorationWriter | None = None,
    progress: Progress | None = None,
) -> ExplorationResult:
    """The result of one exploration.

    It ends when the team has seen all it can observe (`DONE`), when every mind says it is finished
    or nobody has moved for long (`STUCK`), at the problem's time limit or at an interrupt from the
    keyboard (`OUT_OF_BUDGET`). `name` is the strategy's, for the header. `progress` is called
    after every step.
    """
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, strategy, observable)
    engine = engine_for(state)
    recorder = _Recorder(writer, problem, state) if writer is not None else None
    if recorder is not None:
        recorder.begin(_header(state, name))
    told = _Counters(state)  # as of the last step that was recorded
    covered: list[int] = []
    decision_ns: list[int] = []
    last_step = int(problem.max_time_s / problem.step_s + 1e-9)
    status = Status.OUT_OF_BUDGET
    interrupted = False
    still = 0
    happened: list[RobotEvent] = []
    before = state.condition.copy()
    start = perf_counter()
    try:
        while True:
            events = engine.sense_and_decide(state, decision_ns)
            if recorder is not None:
                recorder.record(events, int(state.covered[0]))
            if problem.breakable:
                happened += _changes(state, before)
                before = state.condition.copy()
            covered.append(int(state.covered[0]))
            told = _Counters(state)
            if progress is not None:
                progress(state)
            if covered[-1] == state.n_observable:
                status = Status.DONE
                break
            if _is_stuck(state, still):
                status = Status.STUCK
                break
            if state.step >= last_step:
                break
            still = 0 if engine.move(state, events.actions) or to_come(state) else still + 1
    except KeyboardInterrupt:
        interrupted = True
    compute_s = perf_counter() - start
    metrics = exploration_metrics(
        covered=covered,
        observable=state.n_observable,
        step_s=problem.step_s,
        travelled_m=told.travelled * problem.plan.lattice.cell_m,
        sensed=told.sensed,
        discovered=told.discovered,
        messages=told.messages,
        bytes_sent=told.bytes,
    )
    decision = np.array(decision_ns or [0]) / 1e6
    decision_ms = {
        "mean": float(decision.mean()),
        "p99": float(np.percentile(decision, 99)),
        "max": float(decision.max()),
    }
    if recorder is not None:
        recorder.end(status, metrics, interrupted, compute_s, decision_ms)
    return ExplorationResult(
        status=status,
        metrics=metrics,
        covered=tuple(covered),
        observable=state.n_observable,
        team_map=team_map(state),
        decision_ms=decision_ms,
        compute_s=compute_s,
        interrupted=interrupted,
        digest=writer.digest if writer is not None else None,
        events=tuple(happened),
    )


def _changes(state: WorldState, before: NDArray[np.uint8]) -> list[RobotEvent]:
    """What has happened to robots since they were in this condition."""
    words = {DEAD: "died", STALLED: "stalled", ACTIVE: "went on"}
    return [
        RobotEvent(
            round(state.time_s, 9),
            state.problem.robots[robot].name,
            "joined"
            if before[robot] == ABSENT and state.condition[robot] != DEAD
            else words[int(state.condition[robot])],
        )
        for robot in np.flatnonzero(state.condition != before).tolist()
    ]


def _is_stuck(state: WorldState, still: int) -> bool:
    """Whether nothing will happen any more, or seems so."""
    if still >= STILL_STEPS:
        return True
    if not state.problem.breakable:
        return bool(state.finished.all()) and not state.in_flight
    condition = state.condition
    if (condition == DEAD).all():
        return True
    waits = bool(state.in_flight) or bool((condition == ABSENT).any())
    return not waits and bool(state.finished[condition != DEAD].all())


class _Counters:
    """The counters of a run at one moment, which an interrupt in the middle of a step leaves."""

    __slots__ = ("bytes", "discovered", "messages", "sensed", "travelled")

    def __init__(self, state: WorldState) -> None:
        self.travelled = state.travelled.copy()
        self.sensed = state.sensed.copy()
        self.discovered = state.discovered.copy()
        self.messages = state.messages
        self.bytes = state.bytes


def team_map(state: WorldState) -> NDArray[np.uint8]:
    """What the robots know together, whether or not they have told each other."""
    walls = state.problem.plan.walls
    seen = (state.sensed_by != 0).any(axis=0).reshape(walls.shape)
    return np.where(seen, walls, np.uint8(UNKNOWN))


def _header(state: WorldState, name: str) -> dict[str, Any]:
    problem, strategy = state.problem, state.strategy
    plan = problem.plan
    return {
        "format": FORMAT,
        "job": "explore",
        "map": plan.grid.name,
        "cell_m": plan.lattice.cell_m,
        "radius_m": plan.radius_m,
        "robots": [_plain(robot) for robot in problem.robots],
        "starts": [int(cell) for cell in problem.starts],
        "seed": problem.seed,
        "max_time_s": problem.max_time_s,
        "traffic": problem.traffic,
        "all_to_all": state.all_to_all,
        "faults": [_plain(fault) for fault in problem.faults],
        "step_s": problem.step_s,
        "strategy": name,
        "settings": _plain(strategy) if is_dataclass(strategy) else {},
    }


def _plain(item: object) -> Any:
    if is_dataclass(item) and not isinstance(item, type):
        return {field.name: _plain(getattr(item, field.name)) for field in fields(item)}
    if isinstance(item, tuple | list):
        return [_plain(part) for part in cast("tuple[object, ...]", item)]
    return item if item is None or isinstance(item, bool | int | float | str) else repr(item)


class _Recorder:
    """Turns the events of a run into a run file."""

    def __init__(
        self, writer: ExplorationWriter, problem: ExplorationProblem, state: WorldState
    ) -> None:
        self.writer = writer
        self.problem = problem
        self.state = state
        self.step_ns = round(problem.step_s * 1e9)
        self.pose_every = max(round(POSE_EVERY_S / problem.step_s), 1)
        self.next_map = 1
        self.occupied = problem.plan.walls.reshape(-1).astype(np.uint32) * OCCUPIED_BIT
        self.names = [robot.name for robot in problem.robots]
        self.nobody = np.empty(0, dtype=np.uint32)

    def begin(self, header: dict[str, Any]) -> None:
        grid = self.problem.plan.grid
        self.writer.header(header)
        self.writer.world(grid.cells, grid.resolution, grid.origin)
        self.writer.map("/ground_truth", 0, grid.cells, grid.resolution, grid.origin)
        self.writer.flush()

    def record(self, events: StepEvents, covered: int) -> None:
        looked: list[int] = []
        ends: list[int] = []
        parts: list[NDArray[np.int32]] = []
        total = 0
        for scan in events.scans:
            looked.append(scan is not None)
            if scan is not None:
                parts.append(scan.seen)
                total += len(scan.seen)
            ends.append(total)
        scans = self.nobody
        if total:
            seen = np.concatenate(parts) if len(parts) > 1 else parts[0]
            scans = seen.view(np.uint32) | self.occupied[seen]
        wishes, goals, finished, quiet = zip(*events.actions, strict=True)
        time_ns = events.step * self.step_ns
        self.writer.step(
            time_ns,
            StepRecord(
                events.step,
                events.cells.view(np.uint32),
                events.headings.view(np.uint8),
                np.array(looked, dtype=np.uint8),
                np.array(ends, dtype=np.uint32),
                scans,
                np.array(events.told, dtype=np.uint32).reshape(-1) if events.told else self.nobody,
                self._said(events),
                np.array(wishes, dtype=np.int8),
                np.array(goals, dtype=np.int32),
                np.array(finished, dtype=np.uint8),
                np.array(quiet, dtype=np.uint8),
                events.condition,
                events.messages,
                events.bytes,
            ),
        )
        if events.step % self.pose_every == 0:
            self._poses(time_ns)
        if covered * MAP_SHARES >= self.next_map * self.state.n_observable:
            self.next_map = covered * MAP_SHARES // max(self.state.n_observable, 1) + 1
            self._map(time_ns)

    def end(
        self,
        status: Status,
        metrics: ExplorationMetrics,
        interrupted: bool,
        compute_s: float,
        decision_ms: dict[str, float],
    ) -> None:
        time_ns = self.state.step * self.step_ns
        self._poses(time_ns)
        self._map(time_ns)
        self.writer.result(
            time_ns,
            {
                "status": str(status),
                "interrupted": interrupted,
                "observable": self.state.n_observable,
                "metrics": asdict(metrics),
            },
        )
        self.writer.flush()
        self.writer.timing(
            {
                "compute_s": repr(compute_s),
                **{f"decision_ms_{key}": repr(value) for key, value in decision_ms.items()},
                **versions(),
            }
        )
        self.writer.close()

    def _said(self, events: StepEvents) -> NDArray[np.uint32]:
        if not events.said:
            return self.nobody
        rows = [(item.sender, item.receiver, item.size_bytes) for item in events.said]
        return np.array(rows, dtype=np.uint32).reshape(-1)

    def _poses(self, time_ns: int) -> None:
        plan = self.problem.plan
        x0, y0, yaw = plan.grid.origin
        cos, sin = float(np.cos(yaw)), float(np.sin(yaw))
        poses: list[tuple[float, float, float]] = []
        for robot in range(len(self.names)):
            x, y = plan.lattice.position(int(self.state.cells[robot]))
            poses.append(
                (
                    x0 + cos * x - sin * y,
                    y0 + sin * x + cos * y,
                    yaw + int(self.state.headings[robot]) * pi / 2,
                )
            )
        self.writer.poses(time_ns, self.names, poses)

    def _map(self, time_ns: int) -> None:
        grid = self.problem.plan.grid
        self.writer.map("/map", time_ns, team_map(self.state), grid.resolution, grid.origin)


def versions() -> dict[str, str]:
    """The versions a run was made with."""
    return {
        "python": platform.python_version(),
        **{name: version(name) for name in ("conav", "numpy", "scipy", "numba", "mcap", "rosbags")},
    }
