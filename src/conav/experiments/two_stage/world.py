"""The paper's world and the runs that are played in it."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from conav import __version__
from conav.errors import InputError
from conav.experiments.compare.source import source_hash
from conav.exploration.catalogue import make_strategy
from conav.exploration.types import ExplorationProblem, Strategy
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import PlanningGrid, planning_grid
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import sensor
from conav.simulation.pibt import MIN_GAP
from conav.simulation.world_state import generator_for

METHODS = {
    "TSCA": "two-stage",
    "DTA": "decision-theoretic",
    "RAA": "repeated-auction",
}
"""The paper's names of the methods -> strategies."""

WAITS_S = (5.0, 0.0)
"""How long an auction makes robots stand still [s]: the paper's, and not at all."""

RANGE_M = 4.0
SPEED_MPS = 0.2
CELL_M = 0.5
RADIUS_M = 0.1
MAX_TIME_S = 200_000.0  # [s] simulated, some twenty times what one robot needs

_PLAYS = ("conav.experiments.two_stage.play", "conav.maps.planning_grid")


@dataclass(frozen=True)
class World:
    """What is ours to choose of the world; the rest is the paper's."""

    side_m: float = 100.0
    motion: str = "8-connected"


class Case(NamedTuple):
    """One run."""

    method: str  # of `METHODS`
    robots: int
    wait_s: float
    seed: int

    @property
    def played(self) -> "Case":
        """The case whose run is this one's as well, so that it is played once.

        The decision-theoretic approach holds no auction, and a robot alone none with anybody but
        itself, for which repeated auctions let it wait for nothing.
        """
        if self.method == "DTA" or (self.method == "RAA" and self.robots == 1):
            return self._replace(wait_s=0.0)
        return self


def all_cases(robots: Sequence[int], runs: int, seed: int) -> list[Case]:
    """Every case, seed by seed: whatever is stopped has about as many runs of each size."""
    return [
        Case(method, count, wait_s, number)
        for number in range(seed, seed + runs)
        for count in robots
        for method in METHODS
        for wait_s in WAITS_S
    ]


def strategy_of(case: Case) -> Strategy:
    """The strategy that plays a case."""
    settings = {} if case.method == "DTA" else {"auction_wait_s": case.wait_s}
    return make_strategy(METHODS[case.method], settings)


def case_key(case: Case, world: World) -> str:
    """All that a case's run follows from, as JSON."""
    mind = strategy_of(case)
    code = source_hash(type(mind).__module__, *_PLAYS)
    return json.dumps(
        {"conav": __version__, "code": code, **case._asdict(), **asdict(world)}, sort_keys=True
    )


@lru_cache(maxsize=2)
def plan_of(world: World) -> PlanningGrid:
    """The empty square inside a wall one cell thick."""
    inside = round(world.side_m / CELL_M)
    cells = np.ones((inside + 2, inside + 2), dtype=np.uint8)
    cells[1:-1, 1:-1] = 0
    grid = OccupancyGrid(cells, CELL_M, name=f"empty {world.side_m:g} m square")
    return planning_grid(
        grid, cell_m=CELL_M, radius_m=RADIUS_M, diagonal=MOTIONS[world.motion].diagonal
    )


def problem_of(robots: int, seed: int, world: World) -> ExplorationProblem:
    """A team at random places all over the square; a larger team's first robots stand there too."""
    plan = plan_of(world)
    able = np.flatnonzero(plan.standable.reshape(-1))
    gap = max(2 * RADIUS_M / CELL_M, MIN_GAP)
    rng = generator_for(seed, "starts all over")
    starts: list[int] = []
    for _ in range(1000 * robots):
        if len(starts) == robots:
            break
        cell = int(able[int(rng.integers(len(able)))])
        row, col = divmod(cell, plan.lattice.cols)
        away = [
            (row - a) ** 2 + (col - b) ** 2
            for a, b in (divmod(s, plan.lattice.cols) for s in starts)
        ]
        if all(square >= gap * gap for square in away):
            starts.append(cell)
    else:
        raise InputError(
            f"robots {robots}", f"do not fit in {world.side_m:g} x {world.side_m:g} m", "use fewer"
        )
    team = tuple(
        Robot(
            name=f"robot_{number}",
            radius_m=RADIUS_M,
            speed_mps=SPEED_MPS,
            motion=MOTIONS[world.motion],
            sensor=sensor("range", RANGE_M),
        )
        for number in range(robots)
    )
    return ExplorationProblem(plan, team, tuple(starts), seed, MAX_TIME_S)
