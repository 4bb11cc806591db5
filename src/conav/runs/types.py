"""What a run file holds."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

OCCUPIED_BIT = np.uint32(1 << 31)
"""Set in an entry of `StepRecord.scans` whose fine cell is occupied."""


class StepRecord(NamedTuple):
    """One step: positions at its beginning, what was sensed and told then, what was decided."""

    step: int
    cells: NDArray[np.uint32]  # (n,) planning cell of each robot, flat index
    headings: NDArray[np.uint8]  # (n,) direction 0 to 3
    looked: NDArray[np.uint8]  # (n,) 1: the robot made a scan in this step
    scan_ends: NDArray[np.uint32]  # (n,) where each robot's part of `scans` ends
    scans: NDArray[np.uint32]  # flat fine indices new to the robot, `OCCUPIED_BIT` on walls
    told: NDArray[np.uint32]  # (4 k,) receiver, sender, origin, scans of origin now held
    said: NDArray[np.uint32]  # (3 k,) sender, receiver, bytes of each message a mind sent
    wishes: NDArray[np.int8]  # (n,) direction asked for, -1 stay
    goals: NDArray[np.int32]  # (n,) planning cell headed for, -1 none
    finished: NDArray[np.uint8]  # (n,) 1: nothing left to do as far as it knows
    quiet: NDArray[np.uint8]  # (n,) 1: switches its radio off for the next step
    condition: NDArray[np.uint8]  # (n,) 0 in order, 1 stalled, 2 dead, 3 not there yet
    messages: int  # sent in this step: reports, transfers and what minds said
    bytes: int

    def scan(self, robot: int) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """One robot's scan: flat fine indices and whether each is occupied."""
        start = int(self.scan_ends[robot - 1]) if robot else 0
        part = self.scans[start : int(self.scan_ends[robot])]
        return (part & ~OCCUPIED_BIT).astype(np.int64), (part & OCCUPIED_BIT) != 0


@dataclass(frozen=True, eq=False, kw_only=True)
class Run:
    """What every run read from a file has, whatever its job."""

    path: Path
    header: dict[str, Any]  # job, problem, settings, seed: everything that made the run
    result: dict[str, Any] | None  # None when the run was cut short
    timing: dict[str, str]  # wall times and versions; never part of the digest
    digest: str  # of the events that were read
    intact: bool  # False when the file was cut short or damaged at its end


@dataclass(frozen=True, eq=False, kw_only=True)
class ExplorationRun(Run):
    """The run of an exploration."""

    cells: NDArray[np.uint8]  # (fine rows, fine cols) the true map: 0 free, 1 occupied, 2 unknown
    resolution: float  # [m]
    origin: tuple[float, float, float]  # x [m], y [m], yaw [rad]
    steps: list[StepRecord]


class TrajectoryRecord(NamedTuple):
    """A robot has a trajectory from now on, in place of the one it had."""

    robot: int
    improvement: int  # how many improvements had been written before
    pieces: NDArray[np.float64]  # (n, 9) as in `planning`; no rows: it has none any more


@dataclass(frozen=True, eq=False, kw_only=True)
class PlanRun(Run):
    """The run of a planner."""

    history: list[dict[str, Any]]  # improvements as they came
    trajectories: list[TrajectoryRecord]  # of robots, as they came
    graphs: dict[int, NDArray[np.float64]]  # of a robot: (n, columns) vertices as they were put in

    def pieces(self, robot: int) -> NDArray[np.float64] | None:
        """The trajectory a robot had in the end, (n, 9); None when it had none."""
        of_robot = [one.pieces for one in self.trajectories if one.robot == robot]
        return of_robot[-1] if of_robot and len(of_robot[-1]) else None


@dataclass(frozen=True, eq=False, kw_only=True)
class ExecutionRun(Run):
    """The run of robots that drive a plan; by robot, (n, 9) as in `planning`."""

    planned: dict[int, NDArray[np.float64]]
    driven: dict[int, NDArray[np.float64]]


class LegRecord(NamedTuple):
    """All pursuers during one interval of a schedule."""

    begin_s: float
    end_s: float
    before: NDArray[np.float64]  # (n, 2) [m]
    after: NDArray[np.float64]  # (n, 2) [m]
    active: NDArray[np.bool_]  # (n,)


class RegionRecord(NamedTuple):
    """A hidden region as the team knows it."""

    clear: bool
    rings: tuple[NDArray[np.float64], ...]  # each (m, 2) [m], the outer one first


@dataclass(frozen=True, eq=False, kw_only=True)
class PursuitRun(Run):
    """The run of a pursuit."""

    legs: list[LegRecord]
    beliefs: dict[int, tuple[RegionRecord, ...]]  # by the number of the leg they follow
