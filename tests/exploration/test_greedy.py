"""Greedy distinct assignment, by its definition and end to end."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import conav
from conav.exploration.frontier_targets import Targets
from conav.exploration.greedy import assign_nearest_pairs

VIEW: Any = SimpleNamespace()  # the rule looks at the targets only


def random_targets(count: int) -> list[Targets]:
    """Few robots, targets and pieces; whole costs, so that many tie, and some out of reach."""
    rng = np.random.default_rng(3)
    found = []
    for _ in range(count):
        robots, cells = int(rng.integers(1, 5)), int(rng.integers(1, 9))
        costs = rng.integers(1, 7, (robots, cells)).astype(float)
        costs[rng.random(costs.shape) < rng.choice([0.0, 0.3, 0.8])] = np.inf
        pieces = int(rng.integers(1, cells + 1))
        piece = np.concatenate([np.arange(pieces), rng.integers(0, pieces, cells - pieces)])
        rng.shuffle(piece)
        at = np.sort(rng.choice(100, cells, replace=False))
        found.append(Targets(at, piece, pieces, costs))
    return found


def goals_of(targets: Targets) -> list[int]:
    robots = len(targets.costs)
    nowhere = np.zeros(robots, np.int32)
    return assign_nearest_pairs(targets, VIEW, list(range(robots)), nowhere).tolist()


def cells_of(targets: Targets, robot: int, piece: int) -> list[tuple[float, int]]:
    """Cost and cell of the targets of a piece, the nearest first."""
    rows = zip(targets.costs[robot], targets.cells.tolist(), targets.piece, strict=True)
    return sorted((float(cost), cell) for cost, cell, of in rows if of == piece)


def by_definition(targets: Targets) -> list[int]:
    """Go through all pairs from the nearest on; whoever is free takes what is free."""
    pairs = sorted(
        (cells_of(targets, robot, piece)[0][0], robot, piece)
        for robot in range(len(targets.costs))
        for piece in range(targets.n_pieces)
    )
    goals = [-1] * len(targets.costs)
    gone: set[int] = set()
    for cost, robot, piece in pairs:
        if goals[robot] < 0 and piece not in gone and cost < np.inf:
            goals[robot] = cells_of(targets, robot, piece)[0][1]
            gone.add(piece)
    return goals


def test_assignments_are_those_of_the_definition() -> None:
    without = 0
    for targets in random_targets(400):
        goals = goals_of(targets)
        assert goals == by_definition(targets)
        without += -1 in goals
    assert 40 < without < 360


def test_two_robots_never_get_the_same_piece() -> None:
    for targets in random_targets(200):
        piece_of = dict(zip(targets.cells.tolist(), targets.piece.tolist(), strict=True))
        pieces = [piece_of[goal] for goal in goals_of(targets) if goal >= 0]
        assert len(set(pieces)) == len(pieces)


def test_greedy_by_hand() -> None:
    # Robot 1 is nearest to piece 0 and takes it, though robot 0 then has far to go.
    costs = np.array([[2.0, 9.0], [1.0, 3.0]])
    assert goals_of(Targets(np.array([4, 7]), np.array([0, 1]), 2, costs)) == [7, 4]
    # Ties go to the lower robot, then to the lower piece.
    costs = np.array([[2.0, 2.0], [2.0, 2.0]])
    assert goals_of(Targets(np.array([4, 7]), np.array([0, 1]), 2, costs)) == [4, 7]
    assert goals_of(Targets(np.array([4, 7]), np.array([1, 0]), 2, costs)) == [7, 4]


def test_the_costs_it_is_given_are_left_as_they_are() -> None:
    for targets in random_targets(20):
        before = targets.costs.copy()
        goals_of(targets)
        assert np.array_equal(targets.costs, before)


@pytest.mark.parametrize("name", ["office", "cave", "maze", "three-obstacles"])
@pytest.mark.parametrize("radio", ["perfect", 6.0])
def test_finishes_and_is_accepted(name: str, radio: str | float, tmp_path: Path) -> None:
    size = 20 if name == "three-obstacles" else 8
    for robots in (1, 2, 4) if radio == "perfect" else (2, 4):
        grid = conav.builtin_map(name, width_m=size, height_m=size, seed=robots)
        out = tmp_path / f"{robots}.mcap"
        done = conav.explore(
            grid,
            strategy="greedy",
            robots=robots,
            range_m=size / 4,
            radio=radio,
            seed=robots,
            out=out,
        )
        assert done.status == "done"
        assert done.metrics.coverage == 1.0
        report = conav.verify_exploration(conav.read_run(out))
        assert report.accepted, report.lines()
