"""Prices of anarchy on small grids, from all paths of each robot that are not too long."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.planning.grid_motion import (
    UNREACHED,
    Cells,
    GridProblem,
    cost,
    distances,
    grid_of_text,
    neighbours,
)
from conav.planning.prices import PathGame, Prices, prices

CORRIDOR_WITH_BAY = grid_of_text(
    """
    a...b
    ##.##

    B...A
    ##.##
    """,
    horizon=64,
    name="corridor with a bay",
)
"""Two robots change ends of a corridor of five cells with a bay beside the middle one."""

CROSS = grid_of_text(
    """
    ##b##
    ##.##
    a...A
    ##.##
    ##B##
    """,
    horizon=64,
    name="cross",
)
"""Two robots cross on a plus of five by five cells."""

RING = grid_of_text(
    """
    a..
    .#.
    ..b

    B..
    .#.
    ..A
    """,
    horizon=64,
    name="ring",
)
"""Two robots change places across a ring of eight cells."""

OPEN = grid_of_text(
    """
    .c..
    a..b
    ....

    ....
    B..A
    .C..
    """,
    horizon=64,
    name="open",
)
"""Three robots on three by four open cells: two change ends of the middle row, one crosses it."""

INSTANCES = (
    (CORRIDOR_WITH_BAY, 2),
    (CORRIDOR_WITH_BAY, 4),
    (CORRIDOR_WITH_BAY, 6),
    (CROSS, 3),
    (RING, 4),
    (OPEN, 2),
)
"""Problems and slacks of `price_table`."""


@dataclass(frozen=True, eq=False)
class GridGame:
    """A problem's game with all paths of each robot up to its solo cost and `slack` steps more."""

    problem: GridProblem
    slack: int
    paths: tuple[tuple[Cells, ...], ...]  # by cost, then in lexicographic order
    solo: tuple[int, ...]
    game: PathGame


@dataclass(frozen=True)
class PriceRow:
    """The prices of an instance at a slack, which says how long paths may be."""

    name: str
    slack: int  # [steps] above each robot's solo cost
    paths: tuple[int, ...]
    solo: int  # sum of the solo costs
    found: Prices
    certain: bool
    """Whether no plan with a longer path is below the optimum: it would cost more than it."""


def paths_within(problem: GridProblem, robot: int, slack: int) -> list[Cells]:
    """All paths of a robot with at most `slack` steps above its solo cost, by cost.

    A path's last step enters the goal; it may have been there before, and left.
    """
    start, goal = problem.starts[robot], problem.goals[robot]
    far = distances(problem.free, goal)
    if far[start] >= UNREACHED:
        return []
    most = min(far[start] + slack, problem.horizon)
    near = neighbours(problem.free).tolist()
    found: list[list[int]] = [[start]] if start == goal else []
    stack = [[start]]
    while stack:
        path = stack.pop()
        for cell in near[path[-1]]:
            if cell == problem.free.size or len(path) + far[cell] > most:
                continue
            longer = [*path, cell]
            if cell == goal and path[-1] != goal:
                found.append(longer)
            stack.append(longer)
    found.sort(key=lambda path: (len(path), path))
    return [np.array(path, np.int64) for path in found]


def grid_game(problem: GridProblem, slack: int) -> GridGame:
    """The game of all paths within the slack."""
    paths = tuple(tuple(paths_within(problem, robot, slack)) for robot in range(problem.size))
    steps = max(len(path) for own in paths for path in own)
    tables = [
        np.array([np.pad(path, (0, steps - len(path)), mode="edge") for path in own])
        for own in paths
    ]
    nobody = np.empty((0, 0), np.bool_)
    apart = tuple(
        tuple(nobody if i == j else _apart(a, b) for j, b in enumerate(tables))
        for i, a in enumerate(tables)
    )
    costs = tuple(np.array([[float(cost(path))] for path in own]) for own in paths)
    solo = tuple(cost(own[0]) for own in paths)
    return GridGame(problem, slack, paths, solo, PathGame(costs, apart))


def grid_prices(problem: GridProblem, slack: int) -> PriceRow | None:
    """The prices of an instance; None when no paths within the slack keep everybody apart.

    Equilibria are exact for profiles of paths within the slack: a path that does better than one
    of them is shorter, so it is among them. Longer ones may be worse equilibria, so the price of
    anarchy is a lower bound that grows with the slack; with waiting allowed it may have no end.
    """
    built = grid_game(problem, slack)
    found = prices(built.game)
    if found is None or found.optimum is None:
        return None
    solo = sum(built.solo)
    return PriceRow(
        problem.name,
        slack,
        tuple(len(own) for own in built.paths),
        solo,
        found,
        found.optimum <= solo + slack + 1,
    )


def price_table() -> list[PriceRow]:
    """The prices of `INSTANCES`: a corridor, a cross, a ring and an open floor."""
    rows = [grid_prices(problem, slack) for problem, slack in INSTANCES]
    return [row for row in rows if row is not None]


def _apart(a: NDArray[np.int64], b: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which paths, (n, steps) and (m, steps), keep apart, (n, m)."""
    fine = np.ones((len(a), len(b)), np.bool_)
    for step in range(a.shape[1]):
        fine &= a[:, None, step] != b[None, :, step]
        if step:
            fine &= (a[:, None, step] != b[None, :, step - 1]) | (
                a[:, None, step - 1] != b[None, :, step]
            )
    return fine
