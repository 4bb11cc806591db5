"""What a run's header and map say, in the verifier's own terms, and the notes it takes."""

from dataclasses import dataclass, field
from math import ceil, isfinite
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.runs.types import Run

# How a robot may step, E N W S NE NW SW SE, written out again on purpose.
STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1))
SHOWN = 3  # faults told in full per check
MAX_CELLS = 100_000_000  # planning cells a header may ask for
MAX_ROBOTS = 4096


@dataclass
class Check:
    """One rule: how often it was looked at and where it was broken."""

    name: str
    looked: int = 0
    broken: int = 0
    faults: list[str] = field(default_factory=list[str])

    def fault(self, text: str) -> None:
        """Note a breach."""
        self.broken += 1
        if len(self.faults) < SHOWN:
            self.faults.append(text)


class World(NamedTuple):
    """The problem of a run."""

    walls: NDArray[np.uint8]  # (fine rows, fine cols) 1 where a robot cannot be or see through
    rows: int
    cols: int
    ratio: float  # fine cells per planning cell
    radii: NDArray[np.float64]  # (n,) [fine cells]
    rates: NDArray[np.float64]  # (n,) cells a step
    squares: NDArray[np.float64]  # (n,) squared sensor range [fine cells^2]
    occlusion: list[bool]
    diagonal: list[bool]
    turning: list[bool]
    radio: list[float | None]  # (n,) [planning cells]
    all_to_all: bool  # whether everybody tells everybody everything in every step
    apart: bool  # whether robots must not touch
    starts: NDArray[np.int64]
    step_s: float
    cell_m: float
    steps_allowed: int
    odd: tuple[str, ...]  # where the header contradicts itself

    @property
    def n(self) -> int:
        return len(self.occlusion)

    def fine(self, cell: int) -> tuple[int, int]:
        """The fine cell at a planning cell's centre."""
        row, col = divmod(cell, self.cols)
        return (
            min(int((row + 0.5) * self.ratio), self.walls.shape[0] - 1),
            min(int((col + 0.5) * self.ratio), self.walls.shape[1] - 1),
        )

    def places(self, cells: NDArray[np.uint32]) -> NDArray[np.int64]:
        """Rows and columns of planning cells, shape (n, 2)."""
        return np.stack(np.divmod(cells.astype(np.int64), self.cols), axis=1)

    def change(self, a: int, b: int) -> tuple[int, int]:
        """The rows and columns from one planning cell to another."""
        return b // self.cols - a // self.cols, b % self.cols - a % self.cols


def read_world(run: Run) -> World:
    """The problem of an exploration's run.

    Raises `InputError` when the run is of another job or its header is not one of an exploration.
    """
    if run.header.get("job") != "explore":
        raise InputError(
            run.path, f"is a run of job {run.header.get('job')!r}", "verify takes explorations"
        )
    try:
        return _world(run, run.header)
    except (KeyError, TypeError, ValueError, OverflowError, ZeroDivisionError) as error:
        raise InputError(
            run.path, f"has a header that cannot be used ({error!r})", "the file is damaged"
        ) from None


def _world(run: Run, header: dict[str, Any]) -> World:
    robots = cast("list[dict[str, Any]]", header["robots"])
    if not 1 <= len(robots) <= MAX_ROBOTS:
        raise ValueError(f"{len(robots)} robots")
    cell_m = _number(header["cell_m"], above=0.0)
    step_s = _number(header["step_s"], above=0.0)
    ratio = cell_m / run.resolution
    rows, cols = (ceil(size / ratio - 0.5 - 1e-9) for size in run.cells.shape)
    if rows < 1 or cols < 1 or rows * cols > MAX_CELLS:
        raise ValueError(f"{rows} x {cols} planning cells")

    if header["traffic"] not in ("pibt", "none"):
        raise ValueError(f"traffic {header['traffic']!r}")
    radii_m = [_number(robot["radius_m"]) for robot in robots]
    speeds = [_number(robot["speed_mps"], above=0.0) for robot in robots]
    ranges = [_number(robot["sensor"]["range_m"]) for robot in robots]
    limits = [robot["radio"]["range_m"] for robot in robots]
    starts = [_number(cell) for cell in header["starts"]]
    if len(starts) != len(robots) or max(starts) >= rows * cols or any(s % 1 for s in starts):
        raise ValueError("starts that are no planning cells, one per robot")
    # Lengths beyond the whole map mean the same as the whole map, and do not overflow.
    far = float(sum(run.cells.shape))
    odd: list[str] = []
    if not _near(step_s, cell_m / max(speeds)):
        odd.append(f"a step of {step_s:g} s is not a cell at the fastest robot's speed")
    if not _near(_number(header["radius_m"]), max(radii_m)):
        odd.append("the robots' radius is not the one their moves were made for")
    all_to_all = _flag(header["all_to_all"])
    if all_to_all and any(limit is not None for limit in limits):
        odd.append("all robots tell all others everything, over radios that do not reach them")
    return World(
        walls=(run.cells != 0).astype(np.uint8),
        rows=rows,
        cols=cols,
        ratio=ratio,
        radii=np.array([min(max(r / run.resolution, 1e-3), far) for r in radii_m]),
        rates=np.array([speed / max(speeds) for speed in speeds]),
        squares=np.array([min(r / run.resolution, far) ** 2 for r in ranges]),
        occlusion=[_flag(robot["sensor"]["occlusion"]) for robot in robots],
        diagonal=[_flag(robot["motion"]["diagonal"]) for robot in robots],
        turning=[_flag(robot["motion"]["turn_costs_step"]) for robot in robots],
        radio=[
            None if limit is None else min(_number(limit) / cell_m, rows + cols) for limit in limits
        ],
        all_to_all=all_to_all,
        apart=header["traffic"] != "none",
        starts=np.array(starts, dtype=np.int64),
        step_s=step_s,
        cell_m=cell_m,
        steps_allowed=int(_number(header["max_time_s"]) / step_s + 1e-9),
        odd=tuple(odd),
    )


def _number(value: object, *, above: float | None = None) -> float:
    """A finite number, at least 0; with `above` more than that."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{value!r} is no number")
    number = float(value)
    if not isfinite(number) or number < 0 or (above is not None and number <= above):
        raise ValueError(f"{value!r} is out of range")
    return number


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError(f"{value!r} is neither true nor false")
    return value


def _near(a: float, b: float) -> bool:
    return abs(a - b) <= 1e-9 * max(abs(a), abs(b))
