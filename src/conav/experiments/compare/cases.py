"""What a comparison consists of: maps, strategies, the world, and the cases they combine to."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, NamedTuple

from conav import __version__
from conav.exploration.types import Strategy
from conav.maps.occupancy_grid import OccupancyGrid
from conav.simulation.finish_bounds import NO_BOUNDS

FORMAT = 1
"""Of a case's key and of what is kept of its run; another number and all runs are made anew."""

OWN_RADIO = "default"
"""In place of a radio: perfect, but for a strategy that is made for another one."""


class Case(NamedTuple):
    """One run of a comparison."""

    map: str  # as the comparison calls it
    robots: int
    range_m: float
    radio: str  # "perfect", "off", "path-loss", metres, or `OWN_RADIO`
    strategy: str  # as the comparison calls it
    seed: int

    @property
    def group(self) -> "Group":
        """What it shares with the cases it stands in one table with."""
        return Group(self.map, self.robots, self.range_m, self.radio)

    @property
    def ground(self) -> "Ground":
        """What it shares with all cases of the same bounds."""
        return Ground(self.map, self.robots, self.range_m, self.seed)

    @property
    def pair(self) -> tuple["Group", int]:
        """What it shares with the same run of the other strategies: map, starts, everything."""
        return self.group, self.seed


class Group(NamedTuple):
    """Runs that differ in seed and strategy only."""

    map: str
    robots: int
    range_m: float
    radio: str


@dataclass(frozen=True)
class MapSource:
    """A map of a comparison: what tables call it, where it is from, what it holds."""

    name: str
    source: str | OccupancyGrid
    content: str  # what stands for its cells: a hash of them, or of the code that draws them
    seeded: bool  # whether each seed draws another layout


@dataclass(frozen=True)
class Team:
    """A strategy of a comparison: what tables call it, its mind, and what tells it from others."""

    name: str
    mind: Strategy
    strategy: str  # name in the catalogue, or module and class
    settings: dict[str, Any]
    code: str  # a hash of the code its runs follow from

    @property
    def radio(self) -> str | None:
        """The radio it is made for."""
        return getattr(self.mind, "radio", None)


@dataclass(frozen=True)
class World:
    """What all runs of a comparison share; see `conav.simulation.explore.exploration_problem`."""

    motion: str = "8-connected"
    sensor: str = "range"
    cell_m: float | None = None
    radius_m: float = 0.1
    speed_mps: float = 0.5
    resolution: float | None = None
    loss: float = 0.0
    delay_s: float = 0.0
    energy_j: float | None = None
    faults: tuple[str, ...] = ()
    traffic: str = "pibt"
    outside: bool = False
    outside_folder: bool = False
    max_time_s: float = 3600.0  # [s] simulated


class Ground(NamedTuple):
    """What bounds on the best possible time depend on: neither a strategy nor a radio."""

    map: str
    robots: int
    range_m: float
    seed: int


@dataclass(frozen=True)
class Study:
    """A comparison: every map with every number of robots, range, radio, strategy and seed."""

    maps: tuple[MapSource, ...]
    teams: tuple[Team, ...]
    robots: tuple[int, ...]
    ranges_m: tuple[float, ...]
    radios: tuple[str, ...]
    seeds: tuple[int, ...]
    world: World
    effort: str = NO_BOUNDS  # how hard to look for bounds on the best possible time
    bounds_code: str = ""  # a hash of the code they follow from

    def groups(self) -> list[Group]:
        """The groups in the order they were asked for."""
        return [
            Group(place.name, robots, range_m, radio)
            for place in self.maps
            for robots in self.robots
            for range_m in self.ranges_m
            for radio in self.radios
        ]

    def cases(self) -> list[Case]:
        """The cases in the order of tables and files."""
        return [
            Case(*group, team.name, seed)
            for group in self.groups()
            for team in self.teams
            for seed in self.seeds
        ]

    def map(self, name: str) -> MapSource:
        """The map of that name."""
        return self._maps[name]

    def team(self, name: str) -> Team:
        """The strategy of that name."""
        return self._teams[name]

    @cached_property
    def _maps(self) -> dict[str, MapSource]:
        return {item.name: item for item in self.maps}

    @cached_property
    def _teams(self) -> dict[str, Team]:
        return {item.name: item for item in self.teams}

    def radio(self, case: Case) -> str:
        """The radio the robots of a case have: a name or metres."""
        if case.radio != OWN_RADIO:
            return case.radio
        return self.team(case.strategy).radio or "perfect"

    def key(self, case: Case) -> str:
        """All that the case's result follows from, as JSON; equal for equal runs in any study."""
        team = self.team(case.strategy)
        content = {
            **self._ground_content(case.ground),
            "radio": self.radio(case),
            "strategy": team.strategy,
            "code": team.code,
            "settings": team.settings,
        }
        return json.dumps(content, sort_keys=True, default=repr)

    def grounds(self) -> list[Ground]:
        """What there are bounds of, seed by seed, without those that agree in all but radio."""
        return list(dict.fromkeys(case.ground for case in by_seed(self.cases())))

    def bounds_key(self, ground: Ground) -> str:
        """All that the ground's bounds follow from, as JSON."""
        content = {
            **self._ground_content(ground),
            "bounds": self.effort,
            "code": self.bounds_code,
        }
        return json.dumps(content, sort_keys=True, default=repr)

    def _ground_content(self, ground: Ground) -> dict[str, Any]:
        place = self.map(ground.map)
        world = asdict(self.world)
        del world["outside_folder"]
        if not place.seeded:
            del world["resolution"]  # the grid has one, and it is part of the content
        return {
            "format": FORMAT,
            "conav": __version__,
            "map": place.content,
            "robots": ground.robots,
            "range_m": ground.range_m,
            "seed": ground.seed,
            **world,
        }


def by_seed(cases: Sequence[Case]) -> list[Case]:
    """The cases in the order they are run in: seed by seed.

    So a comparison that is stopped has played about as many runs of each group, all of them paired,
    and the time that is left can be told from the time that has passed.
    """
    return sorted(cases, key=lambda case: case.seed)
