"""No run is faster than the bounds allow, whatever its strategy; what a bound says of itself."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np
import pytest

from conav.exploration.bounds.bounds import (
    FinishBounds,
    Ground,
    cells_needed,
    lower_bounds,
    lower_bounds_on,
)
from conav.exploration.catalogue import STRATEGIES, make_strategy
from conav.exploration.metrics import SHARES
from conav.exploration.types import Action, ExplorationProblem, TeamView
from conav.maps.ascii_art import parse_ascii
from conav.maps.builtin.catalogue import builtin_map
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import planning_grid
from conav.messages.message import Message
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import run_exploration


@dataclass(frozen=True)
class RandomWalker:
    """Every robot makes a random known move."""

    def start(self, view: TeamView, rng: np.random.Generator) -> None:
        return None

    def step(
        self, memory: Any, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[Any, Action, Sequence[Message]]:
        ways = [k for k in range(8) if view.belief.moves.item(view.cell) & (1 << k)]
        return memory, Action(int(rng.choice(ways)) if ways else -1), ()


FEW = ("nearest", "potential", "marginal-contribution", "random-walker")
ALL = (*STRATEGIES, "random-walker")


def strategy(name: str) -> Any:
    return RandomWalker() if name == "random-walker" else make_strategy(name)


def check(problem: ExplorationProblem, names: Sequence[str], **options: int) -> None:
    """No strategy reaches a share before the lower bound."""
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    ground = Ground.of(problem, observable)
    bounds = [lower_bounds_on(ground, share / 100, **options) for share in SHARES]
    for name in names:
        metrics = run_exploration(problem, strategy(name), name=name).metrics
        for share, bound in zip(SHARES, bounds, strict=True):
            reached = getattr(metrics, f"t{share}_s")
            assert reached is None or reached >= bound.lower_s, (name, share)


@pytest.mark.parametrize("seed", range(24))
def test_no_run_on_random_maps(seed: int) -> None:
    rng = np.random.default_rng(seed)
    motion = MOTIONS[sorted(MOTIONS)[seed % 3]]
    resolution = 0.25
    cells = (rng.random((18, 22)) < rng.choice([0.05, 0.2, 0.3])).astype(np.uint8)
    cell = float(rng.choice([0.25, 0.5, 0.6, 0.2]))
    plan = planning_grid(
        OccupancyGrid(cells, resolution), cell_m=cell, radius_m=0.08, diagonal=motion.diagonal
    )
    free = np.flatnonzero(plan.standable)
    robots = tuple(
        Robot(
            f"robot_{i}",
            0.08,
            float(rng.choice([0.5, 0.5, 0.3])),
            motion,
            Sensor("any", bool(rng.random() < 0.7), float(rng.choice([0.7, 1.1, 2.0, 6.0]))),
        )
        for i in range(int(rng.integers(1, 4)))
    )
    starts = tuple(rng.choice(free, size=len(robots), replace=False).tolist())
    problem = ExplorationProblem(plan, robots, starts, seed, 300.0, "none")
    check(problem, FEW, witnesses=8)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", ["office", "maze", "cave", "three-obstacles"])
def test_no_run_on_the_built_in_maps(name: str, motion: str) -> None:
    size = {} if name == "three-obstacles" else {"width_m": 7.0, "height_m": 7.0}
    grid = builtin_map(name, **size)
    larger = 4.0 if name == "three-obstacles" else 1.0  # its cells are of 1 m
    for robots, reach, seed in ((1, 3.0, 1), (3, 1.5, 2)):
        problem, _ = exploration_problem(
            grid,
            robots=robots,
            range_m=reach * larger,
            motion=motion,
            seed=seed,
            max_time_s=150.0 * larger,
        )
        check(problem, ALL, witnesses=10)


@pytest.mark.parametrize(
    ("share", "observable", "needed"),
    [
        *((0.7, 10, 7), (0.9, 10, 9), (0.99, 100, 99), (0.95, 40, 38), (1 / 3, 3, 1)),
        *((1.0, 12345, 12345), (0.0, 5, 0), (0.9, 0, 0), (0.9, 11, 10), (0.28, 25, 7)),
    ],
)
def test_shares_are_counted_without_rounding_errors(
    share: float, observable: int, needed: int
) -> None:
    assert cells_needed(share, observable) == needed


def test_shares_agree_with_the_metrics() -> None:
    for count in range(1, 400):
        for share in SHARES:
            least = next(k for k in range(count + 1) if k * 100 >= share * count)
            assert cells_needed(share / 100, count) == least


@pytest.mark.parametrize("share", [-0.1, 1.01, inf])
def test_a_share_is_from_0_to_1(share: float) -> None:
    with pytest.raises(ValueError, match="share"):
        cells_needed(share, 10)


def small() -> tuple[ExplorationProblem, np.ndarray]:
    plan = planning_grid(parse_ascii("######\n#....#\n######"), cell_m=1.0, radius_m=0.1)
    robot = Robot("r", 0.1, 0.5, sensor=Sensor("any", True, 1.0))
    problem = ExplorationProblem(plan, (robot,), (7,), 0, 1e3)
    return problem, observable_cells(plan, problem.starts, robot.sensor)


def test_what_a_bound_says() -> None:
    problem, observable = small()
    bounds = lower_bounds(problem, observable)
    assert bounds == FinishBounds(
        share=1.0,
        observable=4,
        needed=4,
        lower_s=4.0,
        by="swath",
        swath_s=4.0,
        eccentricity_s=4.0,
        witness_s=4.0,
        witnesses=bounds.witnesses,
        caught=2,
        places=4,
        tried=bounds.tried,
        upper_s=None,
    )
    assert bounds.witnesses[0] == 10
    assert lower_bounds(problem, observable, 0.5).lower_s == 0.0


def test_ratios() -> None:
    bounds = replace(lower_bounds(*small()), upper_s=5.0)
    assert bounds.ratios(10.0) == (2.0, 2.5)
    assert replace(bounds, upper_s=None).ratios(10.0) == (1.0, 2.5)
    assert bounds.ratios(4.5) == (1.0, 1.125)  # nothing is faster than the fastest
    assert bounds.ratios_beyond(10.0) == (2.0, inf)
    nothing = replace(bounds, lower_s=0.0, upper_s=0.0)
    assert nothing.ratios(0.0) == (1.0, 1.0)
    assert nothing.ratios(1.0) == (inf, inf)


def test_nothing_to_observe() -> None:
    problem, observable = small()
    bounds = lower_bounds(problem, np.zeros_like(observable))
    assert (bounds.lower_s, bounds.needed, bounds.witnesses) == (0.0, 0, ())


def test_the_same_again() -> None:
    problem, _ = exploration_problem(builtin_map("maze", width_m=8.0, height_m=8.0), robots=2)
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    for share in (0.9, 1.0):
        first = lower_bounds(problem, observable, share)
        assert lower_bounds(problem, observable, share) == first
