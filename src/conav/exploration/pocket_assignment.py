"""Frontier pieces and pockets assigned by distance advantage.

Two things make exploration end late. Pockets, unknown corners that cannot be stood on, are left to
the end by frontier strategies, and then a robot has to come back for each. And robots that always
take what is nearest leave behind what lies apart. Here pockets are tasks from the moment they are
seen, and a task is the cheaper the farther it lies from all others, so that whoever is near does it
on the way.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from conav.compiled import kernel
from conav.exploration.frontier_tasks import Tasks, find_tasks
from conav.exploration.team_assignment import Order, TeamMemory, planned_step
from conav.exploration.types import Action, TeamView
from conav.messages.message import Message


@dataclass(frozen=True)
class PocketAssignment:
    """Robots are assigned to pieces of frontier and pockets by path length less advantage.

    The advantage of a task is its mean distance from the other tasks; the assignment is the one of
    the least total, by scipy. A robot without a task of its own takes its cheapest.
    """

    advantage: float = 0.5
    """Weight of a task's mean distance from the others against a robot's way to it."""

    def __post_init__(self) -> None:
        check_advantage(self.advantage)

    def start(self, view: TeamView, rng: np.random.Generator) -> TeamMemory:
        return TeamMemory()

    def step(
        self,
        memory: TeamMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[TeamMemory, Action, Sequence[Message]]:
        return planned_step(memory, view, inbox, self._plan)

    def _plan(
        self, view: TeamView, robots: Sequence[int], positions: NDArray[np.int32]
    ) -> list[Order]:
        return plan_pockets(self.advantage, view, positions)


def check_advantage(advantage: float) -> None:
    """Raise `ValueError` for a weight that means nothing."""
    if not 0.0 <= advantage < float("inf"):
        raise ValueError(f"advantage is {advantage:g}; give 0 or more")


def plan_pockets(advantage: float, view: TeamView, positions: NDArray[np.int32]) -> list[Order]:
    """An order for robots at each of these planning cells."""
    tasks = find_tasks(view, positions)
    costs = tasks.costs
    if advantage > 0 and len(tasks) > 1:
        costs = costs - advantage * mean_distances(tasks)
    return assign_tasks(tasks, costs)


def mean_distances(tasks: Tasks) -> NDArray[np.float64]:
    """Each task's mean path length [planning cells] from the other tasks, (n_tasks,).

    Measured from the place of the other task that is nearest to any robot; what cannot be reached
    from there counts 0.
    """
    robots = tasks.costs.argmin(axis=0)
    nearest = tasks.nearest[robots, np.arange(len(tasks))]
    number: dict[int, int] = {}  # of each place, in the order they come
    which = [number.setdefault(place, len(number)) for place in nearest.tolist()]
    between, _ = tasks.paths.lengths(np.array(list(number)))
    total = np.zeros(len(tasks))
    _add_up(between, np.array(which), total)
    return total / (len(tasks) - 1)


@kernel
def _add_up(
    between: NDArray[np.float64], which: NDArray[np.int64], total: NDArray[np.float64]
) -> None:
    """Add the rows of `between` that are named, as far as they are finite, one after the other."""
    for row in which:
        for j in range(total.shape[0]):
            if between[row, j] < np.inf:
                total[j] += between[row, j]


def assign_tasks(tasks: Tasks, costs: NDArray[np.float64]) -> list[Order]:
    """An order for each robot: the assignment of least total cost, (n_robots, n_tasks).

    Costs may be negative, and are inf where a robot cannot get. Robots that are left over go to
    their cheapest task.
    """
    reachable = np.isfinite(costs)
    orders = [Order(-1)] * len(costs)
    if not reachable.any():
        return orders
    # What cannot be reached costs more than any assignment of what can.
    never = 1.0 + 2.0 * float(np.abs(costs[reachable]).max()) * (len(costs) + 1)
    chosen = linear_sum_assignment(np.where(reachable, costs, never))
    picks = dict(zip(*(numbers.tolist() for numbers in chosen), strict=True))
    for robot, row in enumerate(reachable):
        task = picks.get(robot, -1)
        if task < 0 or not row[task]:
            if not row.any():
                continue
            task = int(np.argmin(np.where(row, costs[robot], np.inf)))
        orders[robot] = Order(tasks.nearest.item(robot, task), tasks.looks_for.item(task))
    return orders
