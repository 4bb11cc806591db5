"""The least sum of costs on a grid, by conflict-based search [Sharon2015].

Branches, and why no answer is lost at any of them:

- Two robots in a cell at a step: one of them is not there at that step.
- Two robots that change places: one of them does not make its move at that step.
- A robot in the goal of one that has arrived by then: that one arrives later than at this step, or
  the other is not in this cell at this step nor afterwards. In every answer in which the first has
  arrived by then it is in its goal from there on, and the other is not [Li2021].

Each bars what one of the two does now. A collision is branched at where it costs both robots
something, if there is such a one, then where it costs one of them [Boyarski2015]: a robot must be
in a cell at a step when all its cheapest paths are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from conav.planning.conflict_search import conflict_based_search
from conav.planning.grid_game import GridPlan, grid_equilibrium, solo_costs
from conav.planning.grid_motion import Cells, GridProblem, at, cost
from conav.planning.grid_paths import Bars, GridPaths, grid_paths
from conav.status import Status


class GridBar(NamedTuple):
    """What a robot may not do: be in a cell, be there for good, move there, or arrive by then."""

    kind: Literal["cell", "for good", "move", "arrive"]
    step: int
    cell: int
    tail: int = -1


class Collision(NamedTuple):
    """Two robots in a cell at a step, or with `tail` the first comes from there, the other goes."""

    a: int
    b: int
    step: int
    cell: int
    tail: int = -1


@dataclass(eq=False)
class GridModel:
    """A grid problem for conflict-based search."""

    grid: GridPaths
    _musts: dict[tuple[int, tuple[GridBar, ...]], Cells] = field(default_factory=dict)

    @property
    def size(self) -> int:
        return self.grid.problem.size

    def cheapest(
        self, robot: int, bars: Sequence[GridBar], others: Sequence[Cells]
    ) -> tuple[float, Cells] | None:
        path = self.grid.cheapest(robot, _bars(bars), others)
        return None if path is None else (float(cost(path)), path)

    def collisions(self, paths: Sequence[Cells]) -> int:
        return len(find_collisions(paths))

    def branches(
        self, paths: Sequence[Cells], bars: Sequence[Sequence[GridBar]]
    ) -> Sequence[tuple[int, GridBar]]:
        found = find_collisions(paths)
        worst = max(found, key=lambda one: (self._cardinal(one, paths, bars), -one.step))
        a, b, step, cell, tail = worst
        if tail >= 0:
            return ((a, GridBar("move", step, cell, tail)), (b, GridBar("move", step, tail, cell)))
        for there, other in ((a, b), (b, a)):
            if step >= cost(paths[there]):
                return (
                    (there, GridBar("arrive", step, cell)),
                    (other, GridBar("for good", step, cell)),
                )
        return ((a, GridBar("cell", step, cell)), (b, GridBar("cell", step, cell)))

    def _cardinal(
        self, one: Collision, paths: Sequence[Cells], bars: Sequence[Sequence[GridBar]]
    ) -> int:
        """How many of the two robots pay for getting out of the way."""
        count = 0
        for robot, cell in ((one.a, one.cell), (one.b, one.cell if one.tail < 0 else one.tail)):
            musts = self._must(robot, tuple(bars[robot]))
            fixed = at(musts, one.step) == cell
            if one.tail >= 0:
                before = one.tail if robot == one.a else one.cell
                fixed = fixed and at(musts, one.step - 1) == before
            count += fixed
        return count

    def _must(self, robot: int, bars: tuple[GridBar, ...]) -> Cells:
        """The cell all cheapest paths of the robot are in at each step, -1 where they differ."""
        key = (robot, bars)
        if key not in self._musts:
            self._musts[key] = self.grid.musts(robot, _bars(bars))
        return self._musts[key]


def find_collisions(paths: Sequence[Cells]) -> list[Collision]:
    """The first collision of each two robots that collide."""
    longest = max(len(path) for path in paths)
    cells = np.array([np.pad(path, (0, longest - len(path)), mode="edge") for path in paths])
    found: list[Collision] = []
    for a in range(len(paths)):
        same = cells[a] == cells[a + 1 :]
        swap = np.zeros_like(same)
        swap[:, 1:] = (cells[a, 1:] == cells[a + 1 :, :-1]) & (cells[a, :-1] == cells[a + 1 :, 1:])
        any_of = same | swap
        for i in np.flatnonzero(any_of.any(axis=1)).tolist():
            step = int(any_of[i].argmax())
            tail = -1 if same[i, step] else int(cells[a, step - 1])
            found.append(Collision(a, a + 1 + i, step, int(cells[a, step]), tail))
    return found


def grid_optimum(problem: GridProblem, max_nodes: int = 10_000, seed: int = 0) -> GridPlan:
    """The plan with the least sum of costs; out of budget with what is known when nodes end.

    Then its paths are those of an equilibrium, if one was found, and no plan is below its
    `lower_bound`.
    """
    grid = grid_paths(problem)
    if solo_costs(grid) is None:
        reason = "a robot has no path to its goal within the horizon"
        return GridPlan(Status.INFEASIBLE, reason, (), 0)
    equilibrium = grid_equilibrium(problem, seed)
    known = float(sum(equilibrium.costs)) if equilibrium.paths else float("inf")
    found = conflict_based_search(GridModel(grid), max_nodes, known)
    if found.proved and found.lower_bound == float("inf"):
        return GridPlan(
            Status.INFEASIBLE, "no paths for all keep apart within the horizon", (), 0, found.nodes
        )
    bound = int(found.lower_bound)
    if found.proved:
        paths = equilibrium.paths if found.paths is None else found.paths
        return GridPlan(Status.DONE, "", paths, bound, found.nodes)
    gap = f"{known - bound:.0f} steps" if equilibrium.paths else "unknown"
    reason = f"{found.nodes} nodes did not prove an optimum: the gap is {gap}; raise max_nodes"
    return GridPlan(Status.OUT_OF_BUDGET, reason, equilibrium.paths, bound, found.nodes)


def _bars(rows: Sequence[GridBar]) -> Bars:
    bars = Bars()
    for kind, step, cell, tail in rows:
        if kind == "cell":
            bars.cells.add((step, cell))
        elif kind == "for good":
            bars.for_good.add((step, cell))
        elif kind == "move":
            bars.moves.add((step, tail, cell))
        else:
            bars.arrives_after = max(bars.arrives_after, step)
    return bars
