"""A run played again: who was where, and what the team knew together after each step."""

from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN
from conav.runs.types import OCCUPIED_BIT, ExplorationRun, StepRecord


@dataclass(frozen=True, eq=False)
class Team:
    """What pictures need of a run's header, and where everybody was at every step."""

    map_name: str
    strategy: str
    radius_m: tuple[float, ...]  # [m] per robot
    has_heading: tuple[bool, ...]  # whether a robot drives only where it faces
    step_s: float  # [s]
    cell_m: float  # [m] side of a planning cell
    track: NDArray[np.float64]  # (steps or 1, n, 2) x, y [m] in the grid's own frame
    goals: NDArray[np.float64]  # (steps or 1, n, 2) x, y [m], nan for none
    headings: NDArray[np.uint8]  # (steps or 1, n)
    condition: NDArray[np.uint8]  # (steps or 1, n) as in `StepRecord`

    @property
    def size(self) -> int:
        return len(self.radius_m)


class Replay:
    """What a team knows together, one step after another.

    `team_map` and `first_seen_by` change in place; a step costs what was new in it, whatever the
    size of the map.
    """

    def __init__(self, run: ExplorationRun) -> None:
        self.run = run
        self.team_map = np.full(run.cells.shape, UNKNOWN, dtype=np.uint8)
        self.first_seen_by = np.full(run.cells.shape, -1, dtype=np.int16)  # robot, -1 nobody
        self.free_cells = 0  # free fine cells known

    def apply(self, record: StepRecord) -> NDArray[np.int64]:
        """The flat fine cells the team did not know before this step, ascending.

        A cell that several robots see for the first time in one step counts for the lowest number.
        """
        if len(record.scans) == 0:
            return np.empty(0, dtype=np.int64)
        known = self.team_map.reshape(-1)
        cells = (record.scans & ~OCCUPIED_BIT).astype(np.int64)
        if int(cells.max()) >= known.size or int(record.scan_ends[-1]) != len(cells):
            raise InputError(self.run.path, "has scans that are off its map", "the file is damaged")
        fresh = np.flatnonzero(known[cells] == UNKNOWN)
        cells, first = np.unique(cells[fresh], return_index=True)
        at = fresh[first]
        walls = (record.scans[at] & OCCUPIED_BIT) != 0
        known[cells] = np.where(walls, OCCUPIED, FREE)
        robots = np.searchsorted(record.scan_ends, at, side="right")
        self.first_seen_by.reshape(-1)[cells] = robots
        self.free_cells += len(cells) - int(np.count_nonzero(walls))
        return cells


def team_of(run: ExplorationRun) -> Team:
    """The team of a run. Raises `InputError` when the run is not an exploration or is damaged."""
    header = run.header
    if header.get("job") != "explore":
        raise InputError(
            run.path, f"is a run of {header.get('job')!r}", "give a run of conav explore"
        )
    try:
        robots: list[dict[str, Any]] = list(header["robots"])
        cell_m = float(header["cell_m"])
        cols = _planning_cells(run.cells.shape[1], cell_m / run.resolution)
        rows = _planning_cells(run.cells.shape[0], cell_m / run.resolution)
        starts = np.array([header["starts"]], dtype=np.int64)
        shape = (max(len(run.steps), 1), len(robots))
        cells = np.array([record.cells for record in run.steps] or starts).astype(np.int64)
        goals = np.array([record.goals for record in run.steps] or np.full_like(starts, -1))
        if run.steps:
            headings = np.array([record.headings for record in run.steps], dtype=np.uint8)
            condition = np.array([record.condition for record in run.steps], dtype=np.uint8)
        else:
            headings = condition = np.zeros(shape, dtype=np.uint8)
        if (
            not cells.shape == goals.shape == headings.shape == condition.shape == shape
            or not robots
        ):
            raise ValueError
        if cells.min() < 0 or max(cells.max(), goals.max()) >= rows * cols or headings.max() > 3:
            raise ValueError
        return Team(
            map_name=str(header["map"]),
            strategy=str(header["strategy"]),
            radius_m=tuple(float(robot["radius_m"]) for robot in robots),
            has_heading=tuple(bool(robot["motion"]["turn_costs_step"]) for robot in robots),
            step_s=float(header["step_s"]),
            cell_m=cell_m,
            track=_centres(cells, cols, cell_m),
            goals=np.where((goals < 0)[..., None], np.nan, _centres(goals, cols, cell_m)),
            headings=headings,
            condition=condition,
        )
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        raise InputError(
            run.path, "has a header or steps that fit no exploration", "the file is damaged"
        ) from None


def free_seen(run: ExplorationRun, replay: Replay) -> NDArray[np.int64]:
    """The free fine cells the team knew after each step, shape (steps,); `replay` is used up."""
    counts = np.zeros(len(run.steps), dtype=np.int64)
    for index, record in enumerate(run.steps):
        replay.apply(record)
        counts[index] = replay.free_cells
    return counts


def _planning_cells(fine: int, ratio: float) -> int:
    """How many planning cells have their centre on a side of that many fine cells."""
    return ceil(fine / ratio - 0.5 - 1e-9)


def _centres(cells: NDArray[Any], cols: int, cell_m: float) -> NDArray[np.float64]:
    row, col = np.divmod(cells, cols)
    return np.stack([(col + 0.5) * cell_m, (row + 0.5) * cell_m], axis=-1)
