"""From what a person asks for to a `Study`; whatever is wrong is said before anything is run."""

import hashlib
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import is_dataclass
from math import isfinite
from pathlib import Path
from typing import Any, TypeVar

from conav.errors import InputError
from conav.experiments.compare.cases import OWN_RADIO, MapSource, Study, Team, World
from conav.experiments.compare.source import source_hash
from conav.exploration.catalogue import make_strategy, settings_of
from conav.exploration.types import TRAFFIC, Strategy
from conav.maps.builtin.catalogue import BUILTIN
from conav.maps.occupancy_grid import OccupancyGrid
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import SENSORS
from conav.simulation.explore import (
    MAX_ROBOTS,
    load_map,
    make_faults,
    make_link,
    map_and_resolution,
)
from conav.simulation.finish_bounds import check_effort

Map = str | os.PathLike[str] | OccupancyGrid
Strategies = Sequence[str] | Mapping[str, str | Strategy]
T = TypeVar("T")

MAX_RUNS = 100_000


def make_study(
    maps: Sequence[Map],
    strategies: Strategies,
    *,
    robots: Sequence[int],
    ranges_m: Sequence[float],
    radios: Sequence[str | float] | None,
    runs: int,
    seed: int,
    settings: Mapping[str, Mapping[str, object]],
    bounds: str,
    world: World,
) -> Study:
    """The comparison asked for; the parameters are those of `compare`.

    Map files are read. Raises `InputError` for whatever can be known to be wrong without a run.
    """
    _one_of("motion", world.motion, MOTIONS)
    _one_of("sensor", world.sensor, SENSORS)
    _one_of("traffic", world.traffic, TRAFFIC)
    _number("radius", world.radius_m, 0, 1e6)
    _number("speed", world.speed_mps, 1e-9, 1e6)
    _number("max-time", world.max_time_s, 0, 1e12)
    make_link("perfect", world.loss, world.delay_s)
    if world.energy_j is not None:
        _number("energy", world.energy_j, 1e-9, 1e12)
    _number("runs", runs, 1, MAX_RUNS)
    _number("seed", seed, 0, 2**63 - MAX_RUNS)
    for count in _some("robots", robots):
        _number("robots", count, 1, MAX_ROBOTS)
    for range_m in _some("range", ranges_m):
        _number("range", range_m, 0, 1e6)
    check_effort(bounds)
    make_faults(world.faults, [Robot(f"robot_{number}") for number in range(min(robots))])
    teams = _teams(strategies, settings)
    return Study(
        maps=_maps(maps, world),
        teams=teams,
        robots=_once(robots),
        ranges_m=_once([float(range_m) for range_m in ranges_m]),
        radios=_radios(radios, teams),
        seeds=tuple(range(seed, seed + runs)),
        world=world,
        effort=bounds,
        bounds_code=_code("conav.simulation.finish_bounds"),
    )


def map_content(grid: OccupancyGrid) -> str:
    """A hash of what a map says, whatever its file is called."""
    digest = hashlib.sha256(f"{grid.cells.shape} {grid.resolution!r} {grid.origin!r} ".encode())
    digest.update(grid.cells.tobytes())
    return digest.hexdigest()[:32]


def _maps(maps: Sequence[Map], world: World) -> tuple[MapSource, ...]:
    found: dict[str, MapSource] = {}
    for item in _some("map", maps):
        source = item if isinstance(item, OccupancyGrid) else str(item)
        bare, scale = (
            (None, None) if isinstance(source, OccupancyGrid) else map_and_resolution(source)
        )
        if bare in BUILTIN:
            name = bare
            drawn = source_hash(BUILTIN[name].function.partition(":")[0])
            content = f"built-in {name} {drawn}" + (f" {scale!r}" if scale is not None else "")
            made = MapSource(name, str(source), content, seeded=True)
        else:
            grid = load_map(
                source, resolution=world.resolution, outside_folder=world.outside_folder
            )
            name = grid.name if bare is None else _name(Path(bare))
            content = map_content(grid)
            taken = name in BUILTIN or (name in found and found[name].content != content)
            if taken and bare is not None:
                name = str(source)  # files of one name in several folders, one file at two scales
            made = MapSource(name, source, content, seeded=False)
        before = found.setdefault(name, made)
        if before.content != made.content:
            raise InputError(f"map {name!r}", "is the name of two maps", "name them differently")
    return tuple(found.values())


def _name(path: Path) -> str:
    """What a map's file is called, with its folder where the name says nothing."""
    folder = path.parent.name
    return f"{folder}/{path.stem}" if path.stem == "map" and folder else path.stem


def _teams(
    strategies: Strategies, settings: Mapping[str, Mapping[str, object]]
) -> tuple[Team, ...]:
    named: dict[str, str | Strategy] = {}
    if isinstance(strategies, Mapping):
        named.update(strategies)
    else:
        for text in strategies:
            name, equals, strategy = text.partition("=")
            strategy = strategy if equals else name
            if not name or not strategy:
                raise InputError(
                    f"strategy {text!r}", "is neither NAME nor NAME=STRATEGY", "name a strategy"
                )
            if named.setdefault(name, strategy) != strategy:
                raise InputError(
                    f"strategy {name!r}", "is the name of two strategies", "name them differently"
                )
    for name in settings:
        if name not in named:
            raise InputError(
                f"setting of {name!r}",
                "which is not among the strategies compared",
                "use one of: " + ", ".join(named),
            )
    return tuple(
        _team(name, strategy, settings.get(name, {}))
        for name, strategy in _some("strategies", list(named.items()))
    )


def _team(name: str, strategy: str | Strategy, settings: Mapping[str, object]) -> Team:
    if isinstance(strategy, str):
        mind = make_strategy(strategy, settings)
        return Team(name, mind, strategy, settings_of(mind), _mind_code(mind))
    if settings:
        raise InputError(f"setting of {name!r}", "which is an object", "give it to the object")
    cls: type[Any] = type(strategy)
    held = settings_of(strategy) if is_dataclass(strategy) else dict(vars(strategy))
    return Team(name, strategy, f"{cls.__module__}:{cls.__qualname__}", held, _mind_code(strategy))


def _mind_code(mind: Strategy) -> str:
    return _code(type(mind).__module__, "conav.simulation.run_exploration")


def _code(*modules: str) -> str:
    """What stands for the code that a result of these modules on a study's problem follows from."""
    return source_hash(*modules, "conav.maps.planning_grid", "conav.simulation.starts")


def _radios(radios: Sequence[str | float] | None, teams: Sequence[Team]) -> tuple[str, ...]:
    if radios is None:
        return (OWN_RADIO if any(team.radio for team in teams) else "perfect",)
    found = _once([_radio(value) for value in _some("radio", radios)])
    for team in teams:
        for radio in found:
            if team.radio is not None and _radio(team.radio) != radio:
                raise InputError(
                    f"radio {radio}",
                    f"does not go with strategy {team.name}, which is made for radio {team.radio}",
                    "leave the radio out, or use another strategy",
                )
    return found


def _radio(value: str | float) -> str:
    """The radio's one way of writing."""
    link = make_link(value)
    return repr(link.range_m).removesuffix(".0") if link.name == "limited" else link.name


def _some(what: str, items: Sequence[T]) -> Sequence[T]:
    if not items:
        raise InputError(what, "is missing", "give one at least")
    return items


def _once(items: Sequence[T]) -> tuple[T, ...]:
    return tuple(dict.fromkeys(items))


def _one_of(what: str, value: str, known: Collection[str]) -> None:
    if value not in known:
        raise InputError(f"{what} {value!r}", "is not known", "use one of: " + ", ".join(known))


def _number(what: str, value: float, least: float, most: float) -> None:
    if not (isfinite(value) and least <= value <= most):
        raise InputError(f"{what} {value:g}", "is out of range", f"give {least:g} to {most:g}")
