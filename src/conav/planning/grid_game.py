"""The game on a grid: everybody answers the others' paths until nobody can do better alone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from conav.planning.draws import Draws
from conav.planning.grid_motion import Cells, GridProblem, apart, cost
from conav.planning.grid_paths import Bars, GridPaths, grid_paths, past
from conav.status import Status


@dataclass(frozen=True, eq=False)
class GridPlan:
    """Paths for all, and how they were come by.

    `status` is done when the claim of the function that made it holds: an equilibrium, or the
    optimum. `lower_bound` on the sum of costs is certified.
    """

    status: Status
    reason: str
    paths: tuple[Cells, ...]  # none unless everybody has one
    lower_bound: int
    nodes: int = 0

    @property
    def costs(self) -> list[int]:
        """Each robot's steps until arrival."""
        return [cost(path) for path in self.paths]


def solo_costs(grid: GridPaths) -> list[int] | None:
    """Each robot's cost with nobody about; None when one has no path within the horizon."""
    paths = [grid.cheapest(robot, Bars()) for robot in range(grid.problem.size)]
    return (
        None if any(path is None for path in paths) else [cost(p) for p in paths if p is not None]
    )


def best_response(grid: GridPaths, paths: Sequence[Cells | None], robot: int) -> Cells | None:
    """A cheapest path of the robot past everybody else's; None when there is none."""
    others = [path for i, path in enumerate(paths) if i != robot and path is not None]
    return grid.cheapest(robot, past(others))


def gains(grid: GridPaths, paths: Sequence[Cells]) -> list[int]:
    """What each robot could gain alone, in steps: all 0 at an equilibrium."""
    found: list[int] = []
    for robot, path in enumerate(paths):
        answer = best_response(grid, paths, robot)
        assert answer is not None, "its own path is one"
        found.append(cost(path) - cost(answer))
    return found


def play(grid: GridPaths, paths: Sequence[Cells], order: Sequence[int]) -> tuple[Cells, ...]:
    """The equilibrium that answers in this order lead to from paths that keep apart.

    Each answer lowers the answering robot's cost by a step at least and changes nobody else's, so
    the sum falls with every change and there are at most as many as it has steps.
    """
    now = list(paths)
    improved = True
    while improved:
        improved = False
        for robot in order:
            answer = best_response(grid, now, robot)
            assert answer is not None, "its own path is one"
            if cost(answer) < cost(now[robot]):
                now[robot] = answer
                improved = True
    return tuple(now)


def plan_in_order(grid: GridPaths, order: Sequence[int]) -> tuple[Cells, ...] | int:
    """Prioritized planning: paths, or the first robot that found none past those before it."""
    paths: list[Cells | None] = [None] * grid.problem.size
    for robot in order:
        answer = best_response(grid, paths, robot)
        if answer is None:
            return robot
        paths[robot] = answer
    return tuple(path for path in paths if path is not None)


def grid_equilibrium(problem: GridProblem, seed: int = 0, orders: int = 50) -> GridPlan:
    """An equilibrium: paths in a random order, robots that find none moved to its front, then play.

    Out of budget when none of the orders gives paths to all; that does not say there are none.
    """
    grid = grid_paths(problem)
    solo = solo_costs(grid)
    if solo is None:
        return _without("a robot has no path to its goal within the horizon", Status.INFEASIBLE)
    draws = Draws(np.uint64(seed))
    front: list[int] = []
    for _ in range(orders):
        rest = [robot for robot in range(problem.size) if robot not in front]
        order = [*front, *draws.shuffled(rest)]
        paths = plan_in_order(grid, order)
        if not isinstance(paths, int):
            paths = play(grid, paths, order)
            assert all(apart(a, b) for i, a in enumerate(paths) for b in paths[:i])
            return GridPlan(Status.DONE, "", paths, sum(solo))
        front = [paths, *(robot for robot in front if robot != paths)]
    return GridPlan(
        Status.OUT_OF_BUDGET, f"no paths for all in {orders} orders; raise them", (), sum(solo)
    )


def grid_equilibria(problem: GridProblem, starts: int, seed: int = 0) -> list[GridPlan]:
    """The equilibria reached from paths chosen in random orders, by increasing sum of costs.

    One for each order that gave paths to all, so their spread is what chance leads to; a better or
    a worse one may exist.
    """
    grid = grid_paths(problem)
    solo = solo_costs(grid)
    if solo is None:
        return []
    draws = Draws(np.uint64(seed))
    found: list[GridPlan] = []
    for _ in range(starts):
        order = draws.shuffled(range(problem.size))
        paths = plan_in_order(grid, order)
        if not isinstance(paths, int):
            paths = play(grid, paths, draws.shuffled(range(problem.size)))
            found.append(GridPlan(Status.DONE, "", paths, sum(solo)))
    return sorted(found, key=lambda plan: sum(plan.costs))


def _without(reason: str, status: Status) -> GridPlan:
    return GridPlan(status, reason, (), 0)
