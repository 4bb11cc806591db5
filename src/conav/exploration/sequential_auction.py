"""Sequential single-item auctions of tasks at places, with path costs as bids.

The clearing of [Nanjanath2010]'s auctions: no synergies between tasks, every task is sold for
itself, and a bid counts from the end of what the bidder has won so far.
"""

from collections.abc import Callable
from math import inf

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.belief import Belief
from conav.exploration.frontier_targets import paths_to
from conav.geometry.directions import DCOL, DROW, SQRT2

Between = Callable[[int, int], float]
"""The path cost from one task to another, by their indices."""

_ROUNDING = 1e-9


def sequential_auctions(
    costs: NDArray[np.float64], between: Between, least: NDArray[np.float64] | None = None
) -> list[tuple[int, int]]:
    """The (task, bidder) pairs in the order of the awards.

    `costs` (n_bidders, n_tasks) are those from where the bidders stand, inf where they cannot go;
    `least` (n_tasks, n_tasks) are lower bounds of what `between` says, 0 if not given. One task
    after the other is sold, that with the lowest cost for anybody first, then the lower index.
    Every bidder bids the path cost from the end of what it has won so far; the lowest bid wins and
    counts as paid, then the lower bidder. What nobody can reach is not sold.
    """
    n_bidders, n_tasks = costs.shape
    if n_tasks == 0:
        return []
    can = np.isfinite(costs)
    order = np.argsort(costs.min(axis=0), kind="stable").tolist()
    if n_bidders == 1:
        return [(task, 0) for task in order if can[0, task]]
    rows = costs.tolist()
    bounds = (np.zeros((n_tasks, n_tasks)) if least is None else least).tolist()
    ends = [-1] * n_bidders  # the last task each has won
    awards: list[tuple[int, int]] = []
    for task in order:
        reach = [bidder for bidder in range(n_bidders) if rows[bidder][task] < inf]
        if not reach:
            continue
        lowest, winner = inf, -1
        if len(reach) == 1:  # it wins, whatever it bids
            winner = reach.pop()
        # Most bids need not be worked out to know that they lose.
        at_least = [
            (rows[bidder][task] if ends[bidder] < 0 else bounds[ends[bidder]][task], bidder)
            for bidder in reach
        ]
        for bound, bidder in sorted(at_least):
            if bound > lowest + _ROUNDING:
                break
            end = ends[bidder]
            if end < 0:
                bid = bound
            elif lowest < inf and _triangle(rows, end, task) > lowest + _ROUNDING:
                continue
            else:
                bid = between(end, task)
            if bid < lowest or (bid == lowest and bidder < winner):
                lowest, winner = bid, bidder
        awards.append((task, winner))
        ends[winner] = task
    return awards


def _triangle(rows: list[list[float]], one: int, other: int) -> float:
    """A lower bound of the path cost between two tasks, by the triangle inequality."""
    return max(
        (abs(row[one] - row[other]) for row in rows if row[one] < inf and row[other] < inf),
        default=0.0,
    )


class TaskPaths:
    """Path costs between tasks in one map, worked out when they are asked for."""

    def __init__(self, belief: Belief, tasks: tuple[int, ...]) -> None:
        self._belief = belief
        self._tasks = tasks
        self.least = _empty_grid_costs(tasks, belief.moves.shape[1])
        """The path costs (n_tasks, n_tasks) if nothing were in the way: lower bounds."""
        self._paths, self._which = paths_to(belief, tasks)

    def between(self, one: int, other: int) -> float:
        """The path cost [planning cells] over known moves, inf where there is no way."""
        moves = self._belief.moves
        start, goal = self._tasks[one], self._tasks[other]
        if goes_straight(moves, start, goal):
            return float(self.least[one, other])
        return self._paths.cost(start, int(self._which[other]))


def _empty_grid_costs(tasks: tuple[int, ...], cols: int) -> NDArray[np.float64]:
    row, col = np.divmod(np.array(tasks, dtype=np.int64), cols)
    down = np.abs(row[:, None] - row)
    right = np.abs(col[:, None] - col)
    diagonals = np.minimum(down, right)
    return np.maximum(down, right) - diagonals + diagonals * SQRT2


def goes_straight(moves: NDArray[np.uint8], start: int, goal: int) -> bool:
    """Whether a path as short as on an empty grid is found without a search.

    Two are tried: all diagonal moves first, and all of them last. If neither is possible there may
    be another one as short.
    """
    return bool(_goes_straight(moves, start, goal))


@kernel
def _goes_straight(moves: NDArray[np.uint8], start: int, goal: int) -> bool:
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    down = goal // cols - start // cols
    right = goal % cols - start % cols
    diagonals = min(abs(down), abs(right))
    straights = max(abs(down), abs(right)) - diagonals
    along = 0
    slanting = 0
    for k in range(8):
        row = DROW[k]
        col = DCOL[k]
        if k < 4:
            if abs(down) >= abs(right):
                if col == 0 and row * down > 0:
                    along = k
            elif row == 0 and col * right > 0:
                along = k
        elif row * down > 0 and col * right > 0:
            slanting = k
    for diagonals_first in range(2):
        cell = start
        free = True
        for part in range(2):
            slant = (part == 0) == (diagonals_first == 0)
            k = slanting if slant else along
            for _ in range(diagonals if slant else straights):
                if not flat[cell] & (1 << k):
                    free = False
                    break
                cell += DROW[k] * cols + DCOL[k]
            if not free:
                break
        if free:
            return True
    return False
