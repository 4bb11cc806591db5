"""Targets by utility less cost, where every target given away makes those near it less useful.

The assignment of Burgard et al. (2000, 2005): all targets have utility 1; the pair of robot and
target with the highest U_t - beta V_t^i goes together, and the utility of every other target t' is
lowered by the probability P(|t - t'|) that a robot at t sees t'. Then the next pair, until every
robot has a target.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from conav.exploration.frontier_targets import Targets

Seen = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Probability that a target is seen from a distance [planning cells], element by element."""


def assign_by_utility(
    targets: Targets,
    values: NDArray[np.float64],
    beta: float,
    cols: int,
    seen: Seen,
    taken: NDArray[np.int64],
) -> NDArray[np.int64]:
    """A target cell for each robot, -1 where it can reach none.

    `values` (n_robots, n_targets) are the costs V, inf where unreachable; `taken` are cells other
    robots are believed to be heading for. Ties go to the lower robot, then the lower cell.
    """
    goals = np.full(len(values), -1, dtype=np.int64)
    utility = np.ones(len(targets.cells))
    row, col = np.divmod(targets.cells, cols)
    for cell in taken.tolist():
        _reduce(utility, row, col, cell // cols, cell % cols, seen)
    reachable = np.isfinite(values)
    prices = beta * np.where(reachable, values, 0.0)
    left = np.asarray(reachable.any(axis=1), dtype=np.bool_)
    while left.any():
        worth = np.where(reachable & left[:, None], utility - prices, -np.inf)
        robot, target = divmod(int(np.argmax(worth)), len(targets.cells))
        goals[robot] = targets.cells[target]
        left[robot] = False
        _reduce(utility, row, col, int(row[target]), int(col[target]), seen)
    return goals


def _reduce(
    utility: NDArray[np.float64],
    row: NDArray[np.int64],
    col: NDArray[np.int64],
    at_row: int,
    at_col: int,
    seen: Seen,
) -> None:
    """Lower the utility of all targets by the probability that they are seen from a place."""
    utility -= seen(np.sqrt(((row - at_row) ** 2 + (col - at_col) ** 2).astype(np.float64)))
