"""Optimal assignment against all assignments, and end to end."""

from itertools import permutations
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import conav
from conav.exploration.frontier_targets import Targets
from conav.exploration.hungarian import assign_shortest

VIEW: Any = SimpleNamespace()  # the rule looks at the targets only


def random_targets(count: int) -> list[Targets]:
    """Few robots, targets and pieces; whole costs, so that many tie, and some out of reach."""
    rng = np.random.default_rng(5)
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
    return assign_shortest(targets, VIEW, list(range(robots)), nowhere).tolist()


def cells_of(targets: Targets, robot: int, piece: int) -> list[tuple[float, int]]:
    """Cost and cell of the targets of a piece, the nearest first."""
    rows = zip(targets.costs[robot], targets.cells.tolist(), targets.piece, strict=True)
    return sorted((float(cost), cell) for cost, cell, of in rows if of == piece)


def all_assignments(targets: Targets) -> set[tuple[int, float]]:
    """Robots left out and total cost, of every way to give robots different pieces."""
    robots, pieces = len(targets.costs), targets.n_pieces
    found = set()
    # Numbers from `pieces` on stand for no piece.
    for choice in permutations(range(pieces + robots), robots):
        total, out = 0.0, 0
        for robot, piece in enumerate(choice):
            if piece >= pieces:
                out += 1
            else:
                total += cells_of(targets, robot, piece)[0][0]
        if total < np.inf:
            found.add((out, total))
    return found


def test_it_leaves_out_as_few_as_possible_and_is_shortest_among_those() -> None:
    without = better = 0
    for targets in random_targets(150):
        if len(targets.costs) + targets.n_pieces > 8:
            continue
        goals = goals_of(targets)
        piece_of = dict(zip(targets.cells.tolist(), targets.piece.tolist(), strict=True))
        pieces = [piece_of[goal] for goal in goals if goal >= 0]
        assert len(set(pieces)) == len(pieces)
        total = 0.0
        for robot, goal in enumerate(goals):
            if goal >= 0:
                cost, cell = cells_of(targets, robot, piece_of[goal])[0]
                assert goal == cell
                total += cost
        best = all_assignments(targets)
        assert (goals.count(-1), total) == min(best)
        without += -1 in goals
        # Leaving somebody out would be shorter.
        better += min(cost for _, cost in best) < total
    assert without > 20
    assert better > 20


def test_hungarian_by_hand() -> None:
    # 2 + 3 is less than 1 + 9.
    costs = np.array([[2.0, 9.0], [1.0, 3.0]])
    assert goals_of(Targets(np.array([4, 7]), np.array([0, 1]), 2, costs)) == [4, 7]


def test_a_long_way_is_better_than_nobody() -> None:
    far = np.inf
    costs = np.array([[1.0, 1000.0, far], [1.0, far, far], [1.0, far, far]])
    assert goals_of(Targets(np.arange(3), np.arange(3), 3, costs)) in ([1, 0, -1], [1, -1, 0])
    assert goals_of(Targets(np.arange(2), np.arange(2), 2, np.full((3, 2), far))) == [-1] * 3


def test_more_robots_than_pieces() -> None:
    costs = np.array([[5.0], [2.0], [4.0]])
    assert goals_of(Targets(np.array([6]), np.array([0]), 1, costs)) == [-1, 6, -1]


@pytest.mark.parametrize("name", ["office", "cave", "maze", "three-obstacles"])
@pytest.mark.parametrize("radio", ["perfect", 6.0])
def test_finishes_and_is_accepted(name: str, radio: str | float, tmp_path: Path) -> None:
    size = 20 if name == "three-obstacles" else 8
    for robots in (1, 2, 4) if radio == "perfect" else (2, 4):
        grid = conav.builtin_map(name, width_m=size, height_m=size, seed=robots)
        out = tmp_path / f"{robots}.mcap"
        done = conav.explore(
            grid,
            strategy="hungarian",
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
