"""The cheapest path of one robot on a grid, some cells and moves being barred at some steps.

One pass over the steps, all cells at once: the fewest meetings with robots one would rather not
meet, over all ways to be in a cell at a step. The first step at which the robot can be at its goal
and stay there is its cost, and of the paths with this cost one with the fewest meetings is taken.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.planning.grid_motion import UNREACHED, Cells, GridProblem, at, neighbours


@dataclass(eq=False)
class Bars:
    """What one robot may not do; everything after the last step named is allowed.

    `cells` are (step, cell), `for_good` (step, cell) from that step on, `moves` (step, from, to)
    with the step at which the move ends. `arrives_after` is a step by which it has not arrived.
    """

    cells: set[tuple[int, int]] = field(default_factory=set)
    for_good: set[tuple[int, int]] = field(default_factory=set)
    moves: set[tuple[int, int, int]] = field(default_factory=set)
    arrives_after: int = -1


def past(others: Iterable[Cells]) -> Bars:
    """The bars that keep a robot off these paths."""
    bars = Bars()
    for path in others:
        steps = path.tolist()
        bars.cells.update(enumerate(steps))
        bars.for_good.add((len(steps) - 1, steps[-1]))
        for step in range(1, len(steps)):
            if steps[step] != steps[step - 1]:
                bars.moves.add((step, steps[step], steps[step - 1]))
    return bars


class _Layer(NamedTuple):
    reached: NDArray[np.bool_]  # (cells + 1,)
    choice: NDArray[np.int64]  # (cells + 1,) which way in was taken


@dataclass(frozen=True, eq=False)
class GridPaths:
    """A problem's cells, ready for passes."""

    problem: GridProblem
    near: NDArray[np.int64]  # (cells + 1, 5), the last row for the cell that is not there

    def cheapest(self, robot: int, bars: Bars, soft: Iterable[Cells] = ()) -> Cells | None:
        """A cheapest path within the bars, of those one that meets the `soft` paths least.

        None when there is none within the horizon.
        """
        layers = self._forward(robot, bars, list(soft))
        if layers is None:
            return None
        path = np.empty(len(layers), np.int64)
        path[-1] = self.problem.goals[robot]
        for step in range(len(layers) - 1, 0, -1):
            path[step - 1] = self.near[path[step], layers[step].choice[path[step]]]
        return path

    def musts(self, robot: int, bars: Bars) -> Cells:
        """Where all cheapest paths within the bars are at each step, -1 where they differ.

        There must be one.
        """
        layers = self._forward(robot, bars, [])
        assert layers is not None
        moves = _by_step(bars)
        cells = np.empty(len(layers), np.int64)
        cells[-1] = self.problem.goals[robot]
        alive = np.array([cells[-1]])
        for step in range(len(layers) - 1, 0, -1):
            before: set[int] = set()
            for head in alive.tolist():
                for tail in self.near[head].tolist():
                    if layers[step - 1].reached[tail] and (tail, head) not in moves.get(step, ()):
                        before.add(tail)
            alive = np.array(sorted(before))
            cells[step - 1] = alive[0] if len(alive) == 1 else -1
        return cells

    def _forward(self, robot: int, bars: Bars, soft: list[Cells]) -> list[_Layer] | None:
        """What is reached at each step until the robot has arrived; None when it never does."""
        problem = self.problem
        size = problem.free.size
        goal = problem.goals[robot]
        if any(cell == goal for _, cell in bars.for_good):
            return None
        earliest = max(
            [bars.arrives_after + 1, *(step + 1 for step, cell in bars.cells if cell == goal)]
        )
        barred: dict[int, list[int]] = {}
        for step, cell in bars.cells:
            barred.setdefault(step, []).append(cell)
        closing: dict[int, list[int]] = {}
        for step, cell in bars.for_good:
            closing.setdefault(step, []).append(cell)
        moves = _by_step(bars)
        closed = np.zeros(size + 1, np.bool_)
        closed[size] = True
        meetings = np.full(size + 1, UNREACHED, np.int64)
        meetings[problem.starts[robot]] = 0
        choice = np.zeros(size + 1, np.int64)
        layers: list[_Layer] = []
        for step in range(problem.horizon + 1):
            if step:
                ways = meetings[self.near]
                for path in soft:
                    if step < len(path) and path[step] != path[step - 1]:
                        ways[path[step - 1], self._place(int(path[step]), int(path[step - 1]))] += 1
                for tail, head in moves.get(step, ()):
                    ways[head, self._place(tail, head)] = UNREACHED
                choice = np.argmin(ways, axis=1)
                meetings = ways[np.arange(size + 1), choice]
                for path in soft:
                    meetings[at(path, step)] += 1
            closed[closing.get(step, [])] = True
            meetings[closed] = UNREACHED
            meetings[barred.get(step, [])] = UNREACHED
            reached = meetings < UNREACHED
            meetings[~reached] = UNREACHED
            layers.append(_Layer(reached, choice))
            if step >= earliest and reached[goal]:
                return layers
        return None

    def _place(self, tail: int, head: int) -> int:
        """Which of the ways into `head` comes from `tail`."""
        return int(np.flatnonzero(self.near[head] == tail)[0])


def _by_step(bars: Bars) -> dict[int, set[tuple[int, int]]]:
    """The moves that are barred at each step."""
    moves: dict[int, set[tuple[int, int]]] = {}
    for step, tail, head in bars.moves:
        moves.setdefault(step, set()).add((tail, head))
    return moves


def grid_paths(problem: GridProblem) -> GridPaths:
    """The problem ready for passes."""
    near = neighbours(problem.free)
    return GridPaths(problem, np.vstack([near, np.full((1, 5), problem.free.size)]))
