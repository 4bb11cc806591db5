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


@dataclass(frozen=True, eq=False)
class Run:
    """A run as read from its file."""

    path: Path
    header: dict[str, Any]  # job, map, robots, settings, seed: everything that made the run
    cells: NDArray[np.uint8]  # (fine rows, fine cols) the true map: 0 free, 1 occupied, 2 unknown
    resolution: float  # [m]
    origin: tuple[float, float, float]  # x [m], y [m], yaw [rad]
    steps: list[StepRecord]
    result: dict[str, Any] | None  # None when the run was cut short
    timing: dict[str, str]  # wall times and versions; never part of the digest
    digest: str  # of the events that were read
    intact: bool  # False when the file was cut short or damaged at its end
