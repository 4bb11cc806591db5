"""What a run's header and map say, in the verifier's own terms, and the notes it takes."""

from dataclasses import dataclass, field
from math import ceil, isfinite
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.runs.types import ExplorationRun

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


class Budget(NamedTuple):
    """What one robot's radio needs of a signal; lengths in units of `unit_m`."""

    transmit_dbm: float
    threshold_dbm: float
    reference_db: float
    free_exponent: float
    wall_exponent: float
    reference_distance: float
    wall_shadow_db: float
    free_shadow_db: float
    unit_m: float


class Fault(NamedTuple):
    """What happens to a robot, in steps."""

    robot: int
    kind: str
    at: int
    until: int | None


class Battery(NamedTuple):
    """What one robot has and spends."""

    energy_j: float | None
    drive_j_per_m: float
    on_w: float


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
    budgets: list[Budget | None]  # (n,) what each radio needs of the signal, None nothing
    loss: float  # probability that a message is lost
    delay: int  # steps until it arrives
    faults: list[Fault]
    batteries: list[Battery]
    apart: bool  # whether robots must not touch
    starts: NDArray[np.int64]
    step_s: float
    cell_m: float
    steps_allowed: int
    odd: tuple[str, ...]  # where the header contradicts itself

    @property
    def breakable(self) -> bool:
        """Whether a robot may be anything but in order."""
        return bool(self.faults) or any(one.energy_j is not None for one in self.batteries)

    @property
    def mortal(self) -> bool:
        """Whether a robot may die."""
        return any(fault.kind == "dies" for fault in self.faults) or any(
            one.energy_j is not None for one in self.batteries
        )

    @property
    def slow(self) -> bool:
        """Whether messages may be late or lost."""
        return not self.all_to_all and (self.loss > 0.0 or self.delay > 0)

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


class Knowledge:
    """A bit per robot and fine cell; robots with a perfect radio share one."""

    def __init__(self, shape: tuple[int, ...], n: int) -> None:
        self._bits = np.zeros(((n + 7) // 8, *shape), dtype=np.uint8)

    def of(self, robot: int) -> tuple[NDArray[np.uint8], int]:
        """The array with the robot's bit, shape (fine rows, fine cols), and the bit."""
        return self._bits[robot // 8], 1 << (robot % 8)

    def add(self, robot: int, cells: NDArray[np.int64]) -> None:
        """The robot knows these flat cells from now on."""
        bits, mark = self.of(robot)
        bits.reshape(-1)[cells] |= np.uint8(mark)

    def anybody(self, robots: list[int]) -> NDArray[np.bool_]:
        """Whether one of these robots knows each cell, shape (fine rows, fine cols)."""
        held = np.zeros(self._bits.shape[1:], dtype=np.bool_)
        for word in range(len(self._bits)):
            mark = sum(1 << (robot % 8) for robot in robots if robot // 8 == word)
            held |= (self._bits[word] & np.uint8(mark)) != 0
        return held

    def has(self, robot: int, cells: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether the robot knows each of these flat cells."""
        bits, mark = self.of(robot)
        return (bits.reshape(-1)[cells] & mark) != 0


def read_world(run: ExplorationRun) -> World:
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


def _world(run: ExplorationRun, header: dict[str, Any]) -> World:
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
    radios = [cast("dict[str, Any]", robot["radio"]) for robot in robots]
    network = {(_number(radio["loss"]), _number(radio["delay_s"])) for radio in radios}
    if len(network) > 1:
        raise ValueError("radios of more than one network")
    loss, delay_s = network.pop()
    if loss >= 1.0:
        raise ValueError(f"a radio that loses {loss:g} of its messages")
    budgets = [_budget(radio["path_loss"]) for radio in radios]
    faults = [_fault(fault, len(robots), step_s) for fault in header["faults"]]
    batteries = [_battery(robot) for robot in robots]
    all_to_all = _flag(header["all_to_all"])
    if all_to_all and (
        any(limit is not None for limit in limits)
        or any(budget is not None for budget in budgets)
        or loss > 0.0
        or delay_s > 0.0
        or any(fault.kind != "stalls" for fault in faults)
        or any(one.energy_j is not None for one in batteries)
    ):
        odd.append("all robots tell all others everything, though they cannot always")
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
        budgets=budgets,
        loss=loss,
        delay=ceil(delay_s / step_s - 1e-9),
        faults=faults,
        batteries=batteries,
        apart=header["traffic"] != "none",
        starts=np.array(starts, dtype=np.int64),
        step_s=step_s,
        cell_m=cell_m,
        steps_allowed=int(_number(header["max_time_s"]) / step_s + 1e-9),
        odd=tuple(odd),
    )


def _budget(model: Any) -> Budget | None:
    if model is None:
        return None
    budget = Budget(**{name: _any_number(value) for name, value in dict(model).items()})
    if budget.unit_m <= 0.0 or budget.reference_distance <= 0.0:
        raise ValueError("a link budget without a unit")
    return budget


def _fault(fault: Any, robots: int, step_s: float) -> Fault:
    robot, kind, until = fault["robot"], fault["kind"], fault["until_s"]
    if isinstance(robot, bool) or not isinstance(robot, int) or not 0 <= robot < robots:
        raise ValueError(f"a fault of robot {robot!r}")
    if kind not in ("dies", "stalls", "joins"):
        raise ValueError(f"a robot that {kind!r}")
    at = ceil(_number(fault["at_s"]) / step_s - 1e-9)
    return Fault(robot, kind, at, None if until is None else ceil(_number(until) / step_s - 1e-9))


def _battery(robot: dict[str, Any]) -> Battery:
    energy = robot["energy_j"]
    return Battery(
        None if energy is None else _number(energy, above=0.0),
        _number(robot["drive_j_per_m"]),
        _number(robot["on_w"]),
    )


def _any_number(value: object) -> float:
    """A finite number."""
    return -_number(-value) if isinstance(value, int | float) and value < 0 else _number(value)


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
