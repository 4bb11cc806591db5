"""Targets by utility less cost, where every target given away makes those near it less useful.

The assignment of Burgard et al. (2000, 2005): all targets have utility 1; the pair of robot and
target with the highest U_t - beta V_t^i goes together, and the utility of every other target t' is
lowered by the probability P(|t - t'|) that a robot at t sees t'. Then the next pair, until every
robot has a target.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.frontier_targets import Targets


class Seen(NamedTuple):
    """The probability P(d) that a target is seen, by its distance d; `probability` has it."""

    reach: float  # [planning cells], above 0
    share: NDArray[np.float64]  # (n_parts,) for equal parts of the reach
    slope: float = 0.0  # what is lost up to the end of the reach


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
    _assign(targets.cells, values, beta, cols, *seen, taken, goals)
    return goals


@kernel
def probability(distance: float, reach: float, share: NDArray[np.float64], slope: float) -> float:
    """P(d) [planning cells]: `share[k] - slope d / reach` in part k of the reach, 0 beyond it."""
    if distance > reach:
        return 0.0
    near = distance / reach
    parts = share.shape[0]
    return share[min(int(near * parts), parts - 1)] - slope * near


@kernel
def _assign(
    cells: NDArray[np.int64],
    values: NDArray[np.float64],
    beta: float,
    cols: int,
    reach: float,
    share: NDArray[np.float64],
    slope: float,
    taken: NDArray[np.int64],
    goals: NDArray[np.int64],
) -> None:
    """Write a target cell for each robot that can reach one to `goals`, all -1 so far."""
    robots = values.shape[0]
    utility = np.ones(cells.shape[0])
    for i in range(taken.shape[0]):
        _reduce(utility, cells, cols, taken[i], reach, share, slope)
    for _ in range(robots):
        best = -np.inf
        robot = -1
        target = -1
        for i in range(robots):
            if goals[i] >= 0:
                continue
            for j in range(cells.shape[0]):
                # Where everything is worth minus infinity the first is as good as any.
                if values[i, j] < np.inf and (utility[j] - beta * values[i, j] > best or robot < 0):
                    best = utility[j] - beta * values[i, j]
                    robot = i
                    target = j
        if robot < 0:
            break
        goals[robot] = cells[target]
        _reduce(utility, cells, cols, cells[target], reach, share, slope)


@kernel
def _reduce(
    utility: NDArray[np.float64],
    cells: NDArray[np.int64],
    cols: int,
    place: int,
    reach: float,
    share: NDArray[np.float64],
    slope: float,
) -> None:
    """Lower the utility of all targets by the probability that they are seen from a place."""
    row = place // cols
    col = place % cols
    for j in range(cells.shape[0]):
        down = cells[j] // cols - row
        right = cells[j] % cols - col
        utility[j] -= probability(np.sqrt(down * down + right * right), reach, share, slope)
