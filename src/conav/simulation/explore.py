"""From a map's name or file to a finished exploration, in one call."""

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any

from conav.errors import InputError
from conav.exploration.bounds.bounds import FinishBounds
from conav.exploration.catalogue import DEFAULT_STRATEGY, make_strategy
from conav.exploration.metrics import ExplorationMetrics
from conav.exploration.types import TRAFFIC, ExplorationProblem, Strategy
from conav.maps.builtin.catalogue import BUILTIN, builtin_map
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import default_start_area, planning_grid
from conav.maps.read_map import read_map
from conav.robots.fault import Fault, check_faults, parse_fault
from conav.robots.motion import MOTIONS
from conav.robots.radio import RADIOS, Radio
from conav.robots.radio import radio as make_radio
from conav.robots.robot import Robot
from conav.robots.sensor import SENSORS
from conav.robots.sensor import sensor as make_sensor
from conav.runs.exploration_writer import ExplorationWriter
from conav.simulation.finish_bounds import finish_bounds
from conav.simulation.run_exploration import ExplorationResult, run_exploration
from conav.simulation.starts import start_together, starts_at
from conav.simulation.world_state import WorldState, generator_for
from conav.status import Status

DEFAULT_MAX_TIME_S = 36_000.0  # [s] simulated
MAX_ROBOTS = 1024
THIS_RUN = "this-run"
_BOUND_KEYS = ("lower_bound_s", "lower_bound_by", "upper_bound_s", "upper_bound_by", "ratio")
MAX_LOSS = 0.99


@dataclass(frozen=True, eq=False)
class Exploration:
    """A finished exploration: the problem, the result, and where its run file lies."""

    problem: ExplorationProblem
    strategy: str
    result: ExplorationResult
    warnings: tuple[str, ...]
    run: Path | None

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.result.status

    @property
    def metrics(self) -> ExplorationMetrics:
        """What is reported of it."""
        return self.result.metrics

    def bounds(self, effort: str = "quick") -> dict[int, FinishBounds]:
        """Bounds on the best possible time to each share [%] of `SHARES`, worked out at each call.

        `effort` is "quick", a second or two, or "full", tighter and some ten times slower. The run
        itself is one that the upper bounds come from: a run that got there is a plan.
        """
        found = finish_bounds(self.problem, effort=effort)
        return {
            share: bounds.with_run(self.time_to(share), THIS_RUN) for share, bounds in found.items()
        }

    def time_to(self, share: int) -> float | None:
        """When coverage first reached one of `SHARES` [%], in simulated seconds; None for never."""
        return getattr(self.metrics, f"t{share}_s")

    def ratios(self, bounds: FinishBounds, share: int = 100) -> tuple[float, float]:
        """The least and the greatest that the time to a share [%] can be over the best possible.

        The second is inf where the run had not got there by its end, and where the lower bound is
        0 and the time is not.
        """
        time_s = self.time_to(share)
        if time_s is None:
            return bounds.ratios_beyond(self.metrics.time_s)
        return bounds.ratios(time_s)

    def summary(self, bounds: dict[int, FinishBounds] | None = None) -> dict[str, Any]:
        """The object that `conav explore --json` prints; without bounds they are null in it."""
        metrics = self.metrics
        held = {} if bounds is None else {k: self._bounds(k, item) for k, item in bounds.items()}
        whole = held.get(100, dict.fromkeys(_BOUND_KEYS))
        return {
            "job": "explore",
            "map": self.problem.plan.grid.name,
            "strategy": self.strategy,
            "robots": len(self.problem.robots),
            "seed": self.problem.seed,
            "status": str(self.status),
            "steps": metrics.steps,
            "time_s": metrics.time_s,
            "coverage": metrics.coverage,
            "t90_s": metrics.t90_s,
            "t95_s": metrics.t95_s,
            "t99_s": metrics.t99_s,
            "t100_s": metrics.t100_s,
            **whole,
            "bounds": {f"t{k}": item for k, item in held.items()} if held else None,
            "path_m": list(metrics.path_m),
            "overlap": metrics.overlap,
            "balance": metrics.balance,
            "messages": metrics.messages,
            "bytes": metrics.bytes,
            "robot_events": [event._asdict() for event in self.result.events],
            "decision_ms": self.result.decision_ms,
            "compute_s": self.result.compute_s,
            "run": str(self.run) if self.run is not None else None,
            "digest": self.result.digest,
            "interrupted": self.result.interrupted,
            "warnings": list(self.warnings),
        }

    def _bounds(self, share: int, bounds: FinishBounds) -> dict[str, Any]:
        low, high = self.ratios(bounds, share)
        values = (
            _finite(bounds.lower_s),
            bounds.by,
            bounds.upper_s,
            bounds.upper_by,
            [_finite(low), _finite(high)],
        )
        return dict(zip(_BOUND_KEYS, values, strict=True))


def _finite(value: float) -> float | None:
    """The number, or None for infinity, which JSON has no word for."""
    return value if isfinite(value) else None


def load_map(
    source: str | os.PathLike[str] | OccupancyGrid,
    *,
    resolution: float | None = None,
    seed: int = 0,
    outside_folder: bool = False,
) -> OccupancyGrid:
    """The grid behind a built-in name, a file or a grid itself.

    `resolution` [m] overrides a built-in map's and is needed for bare pictures; "NAME@METRES" says
    it for one map among several. `seed` makes a built-in map's layout. A file beats a built-in map
    of the same name when its name has a suffix.
    """
    if isinstance(source, OccupancyGrid):
        return source
    source, own = map_and_resolution(source)
    resolution = resolution if own is None else own
    if str(source) in BUILTIN:
        return builtin_map(str(source), resolution=resolution, seed=seed)
    if not Path(source).suffix and not Path(source).exists():
        raise InputError(
            f"map {str(source)!r}",
            "is neither a file nor a built-in map",
            "built-in maps: " + ", ".join(BUILTIN),
        )
    return read_map(Path(source), resolution=resolution, outside_folder=outside_folder)


def map_and_resolution(source: str | os.PathLike[str]) -> tuple[str, float | None]:
    """The map's name or path and its metres per cell, from "NAME@METRES"; None where not said.

    A file whose own name ends like that is a file.
    """
    text = str(source)
    name, at, metres = text.rpartition("@")
    if not at or not name or Path(text).exists():
        return text, None
    try:
        return name, float(metres)
    except ValueError:
        return text, None


def exploration_problem(
    map: str | os.PathLike[str] | OccupancyGrid,
    *,
    robots: int = 3,
    range_m: float = 7.0,
    cell_m: float | None = None,
    radius_m: float = 0.1,
    speed_mps: float = 0.5,
    resolution: float | None = None,
    motion: str = "8-connected",
    sensor: str = "range",
    radio: str | float | Radio = "perfect",
    loss: float = 0.0,
    delay_s: float = 0.0,
    energy_j: float | None = None,
    faults: Sequence[str | Fault] = (),
    traffic: str = "pibt",
    starts: Sequence[tuple[float, float]] | None = None,
    outside: bool = False,
    outside_folder: bool = False,
    seed: int = 0,
    max_time_s: float = DEFAULT_MAX_TIME_S,
) -> tuple[ExplorationProblem, tuple[str, ...]]:
    """The problem of a team of equal robots on a map, and what was odd about it.

    Lengths in metres, `radio` "perfect", "off", "path-loss", a range or a `Radio`, whose messages
    are lost with probability `loss` and arrive `delay_s` later; `faults` as objects or as on the
    command line; the other parameters are those of `conav explore`. Raises `InputError` for
    anything that does not fit.
    """
    _one_of("motion", motion, MOTIONS)
    _one_of("sensor", sensor, SENSORS)
    _one_of("traffic", traffic, TRAFFIC)
    _number("robots", robots, 1, MAX_ROBOTS)
    _number("range", range_m, 0, 1e6)
    _number("radius", radius_m, 0, 1e6)
    _number("speed", speed_mps, 1e-9, 1e6)
    _number("max-time", max_time_s, 0, 1e12)
    if energy_j is not None:
        _number("energy", energy_j, 1e-9, 1e12)
    link = make_link(radio, loss, delay_s)
    _number("seed", seed, 0, 2**63)
    grid = load_map(map, resolution=resolution, seed=seed, outside_folder=outside_folder)
    model = MOTIONS[motion]
    plan = planning_grid(grid, cell_m=cell_m, radius_m=radius_m, diagonal=model.diagonal)
    team = tuple(
        Robot(
            name=f"robot_{number}",
            radius_m=radius_m,
            speed_mps=speed_mps,
            motion=model,
            sensor=make_sensor(sensor, range_m),
            radio=link,
            energy_j=energy_j,
        )
        for number in range(robots)
    )
    warnings = list(grid.warnings)
    if range_m < plan.lattice.cell_m:
        warnings.append(
            f"a sensor range of {range_m:g} m is less than a planning cell of "
            f"{plan.lattice.cell_m:g} m: robots may not see where they could go"
        )
    if starts is not None:
        cells = starts_at(plan, starts, team, apart=traffic != "none")
    else:
        area = default_start_area(plan, outside=outside)
        warnings.extend(area.warnings)
        cells = start_together(plan, area, team, generator_for(seed, "starts"))
    made = ExplorationProblem(
        plan, team, cells, seed, float(max_time_s), traffic, make_faults(faults, team)
    )
    return made, tuple(warnings)


def explore(
    map: str | os.PathLike[str] | OccupancyGrid,
    *,
    strategy: str | Strategy = DEFAULT_STRATEGY,
    settings: Mapping[str, object] | None = None,
    out: str | os.PathLike[str] | None = None,
    progress: Callable[[WorldState], None] | None = None,
    **problem: Any,
) -> Exploration:
    """A team's exploration of a map, run to its end.

    `map` is a built-in name, a file or an `OccupancyGrid`; `strategy` a name of the catalogue, with
    `settings`, or an object of your own; `out` the run file to write. The other parameters are
    those of `exploration_problem`. A strategy made for one radio (it has an attribute `radio`) gets
    that one. Raises `InputError` for bad input.
    """
    if isinstance(strategy, str):
        name, mind = strategy, make_strategy(strategy, settings)
    else:
        name, mind = type(strategy).__name__, strategy
    made_for = getattr(mind, "radio", None)
    if problem.get("radio") is None:
        problem["radio"] = made_for or "perfect"
    elif made_for is not None and make_link(problem["radio"]) != make_link(made_for):
        raise InputError(
            f"radio {problem['radio']!r}",
            f"does not go with strategy {name}, which is made for radio {made_for}",
            "leave the radio out, or use another strategy",
        )
    given, warnings = exploration_problem(map, **problem)
    if out is None:
        result = run_exploration(given, mind, name=name, progress=progress)
        return Exploration(given, name, result, warnings, None)
    with ExplorationWriter(out) as writer:
        result = run_exploration(given, mind, name=name, writer=writer, progress=progress)
    return Exploration(given, name, result, warnings, Path(out))


def make_link(value: str | float | Radio, loss: float = 0.0, delay_s: float = 0.0) -> Radio:
    """The radio asked for. Raises `InputError` for one there is not."""
    _number("loss", loss, 0, MAX_LOSS)
    _number("delay", delay_s, 0, 1e6)
    if isinstance(value, Radio):
        return replace(value, loss=loss or value.loss, delay_s=delay_s or value.delay_s)
    if value in RADIOS:
        return make_radio(str(value), loss=loss, delay_s=delay_s)
    try:
        range_m = float(value)
    except ValueError:
        raise InputError(
            f"radio {value!r}",
            f"is neither {', '.join(RADIOS)} nor a range",
            'give "perfect", "off", "path-loss" or metres',
        ) from None
    _number("radio", range_m, 0, 1e6)
    return make_radio("limited", range_m, loss=loss, delay_s=delay_s)


def make_faults(faults: Sequence[str | Fault], team: Sequence[Robot]) -> tuple[Fault, ...]:
    """The faults asked for. Raises `InputError` for those that cannot happen to this team."""
    names = [robot.name for robot in team]
    made = tuple(parse_fault(fault, names) if isinstance(fault, str) else fault for fault in faults)
    try:
        check_faults(made, len(team))
    except ValueError as error:
        raise InputError("faults", f"cannot be: {error}", "give other robots or times") from None
    return made


def _one_of(what: str, value: str, known: Collection[str]) -> None:
    if value not in known:
        raise InputError(f"{what} {value!r}", "is not known", "use one of: " + ", ".join(known))


def _number(what: str, value: float, least: float, most: float) -> None:
    if not (isfinite(value) and least <= value <= most):
        raise InputError(f"{what} {value:g}", "is out of range", f"give {least:g} to {most:g}")
