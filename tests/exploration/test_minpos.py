"""Assignment by rank, by its definition and end to end."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import conav
from conav.exploration.frontier_targets import Targets
from conav.exploration.minpos import assign_by_rank

VIEW: Any = SimpleNamespace()  # the rule looks at the targets only


def random_targets(count: int) -> list[Targets]:
    """Few robots, targets and pieces; whole costs, so that many tie, and some out of reach."""
    rng = np.random.default_rng(7)
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
    return assign_by_rank(targets, VIEW, list(range(robots)), nowhere).tolist()


def cells_of(targets: Targets, robot: int, piece: int) -> list[tuple[float, int]]:
    """Cost and cell of the targets of a piece, the nearest first."""
    rows = zip(targets.costs[robot], targets.cells.tolist(), targets.piece, strict=True)
    return sorted((float(cost), cell) for cost, cell, of in rows if of == piece)


def by_definition(targets: Targets) -> list[int]:
    robots, pieces = range(len(targets.costs)), range(targets.n_pieces)
    cost = [[cells_of(targets, robot, piece)[0][0] for piece in pieces] for robot in robots]
    goals = []
    for robot in robots:
        choices = []
        for piece in pieces:
            if cost[robot][piece] == np.inf:
                continue
            nearer = sum(cost[other][piece] < cost[robot][piece] for other in robots)
            choices.append((nearer, cost[robot][piece], piece))
        goals.append(cells_of(targets, robot, min(choices)[2])[0][1] if choices else -1)
    return goals


def test_assignments_are_those_of_the_definition() -> None:
    without = shared = 0
    for targets in random_targets(400):
        goals = goals_of(targets)
        assert goals == by_definition(targets)
        without += -1 in goals
        shared += len(set(goals)) < len(goals)
    assert without > 40
    assert shared > 40


def test_minpos_by_hand() -> None:
    # Robot 1 is second at both pieces; it is nearer to the first. Both go there.
    cells, piece = np.array([4, 7]), np.array([0, 1])
    assert goals_of(Targets(cells, piece, 2, np.array([[1.0, 2.0], [3.0, 4.0]]))) == [4, 4]
    # Robot 1 is nearest to the second, so it goes there although the first is nearer to it.
    assert goals_of(Targets(cells, piece, 2, np.array([[1.0, 9.0], [3.0, 8.0]]))) == [4, 7]
    # As near as another is not behind it.
    assert goals_of(Targets(cells, piece, 2, np.array([[3.0, 9.0], [3.0, 8.0]]))) == [4, 4]
    # Who cannot get there is nearer to nothing.
    far = np.inf
    assert goals_of(Targets(cells, piece, 2, np.array([[far, 2.0], [9.0, 3.0]]))) == [7, 4]
    assert goals_of(Targets(cells, piece, 2, np.array([[far, far], [9.0, 3.0]]))) == [-1, 7]


def test_one_robot_goes_to_the_nearest() -> None:
    for targets in random_targets(100):
        goal = goals_of(Targets(targets.cells, targets.piece, targets.n_pieces, targets.costs[:1]))
        nearest = targets.costs[0].min()
        if nearest == np.inf:
            assert goal == [-1]
        else:
            assert targets.costs[0][targets.cells.tolist().index(goal[0])] == nearest


@pytest.mark.parametrize("name", ["office", "cave", "maze", "three-obstacles"])
@pytest.mark.parametrize("radio", ["perfect", 6.0])
def test_finishes_and_is_accepted(name: str, radio: str | float, tmp_path: Path) -> None:
    size = 20 if name == "three-obstacles" else 8
    for robots in (1, 2, 4) if radio == "perfect" else (2, 4):
        grid = conav.builtin_map(name, width_m=size, height_m=size, seed=robots)
        out = tmp_path / f"{robots}.mcap"
        done = conav.explore(
            grid,
            strategy="minpos",
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
