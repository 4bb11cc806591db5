"""The cost of reaching every known cell by deterministic value iteration, and the work it takes.

So Burgard et al. [Burgard2000] find what reaching each frontier cell costs a robot: its own cell
gets 0, all others infinity, and then

    V(x) <- min over the eight neighbours n of x that can be moved to of V(n) + |x - n|

is applied to all explored cells again and again until nothing changes. Their loop assigns to one
array, so a value may use what its neighbours were given earlier in the same sweep (in place, or
Gauss-Seidel); the textbook's form with two arrays (Jacobi) needs a sweep for every move of the
longest shortest path. In place and in raster order only moves against the raster need a sweep each.
They weigh distances by the probability that a cell is occupied; here a move is known to be possible
or it is not.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW, SQRT2

DIAGONAL = round(SQRT2 * 2**30) / 2**30
"""The length of a diagonal move, sqrt(2) to 1.2e-11.

As a multiple of 2^-30, so that sums of moves are exact up to 2^23 cells and paths of equal length
have equal costs. With sqrt(2) they differ in the last bit by the order of their moves, and sweeps
would go on over nothing but that.
"""


class Sweeps(NamedTuple):
    """What a value iteration took; the last sweep is the one that changed nothing."""

    sweeps: int
    touched: int  # cells whose neighbours were looked at, over all sweeps
    lowered: int  # values that were replaced by a lower one


def raster_order(moves: NDArray[np.uint8], start: int) -> NDArray[np.int32]:
    """The explored cells, flat and ascending: those with any move, and the start; (1, explored)."""
    explored = moves.reshape(-1) != 0
    explored[start] = True
    return np.flatnonzero(explored).astype(np.int32)[np.newaxis]


def there_and_back(order: NDArray[np.int32]) -> NDArray[np.int32]:
    """Orders (2, explored) that sweep an order (1, explored) forwards and backwards in turn."""
    return np.concatenate([order, order[:, ::-1]])


def value_iteration(
    moves: NDArray[np.uint8],
    start: int,
    cost: NDArray[np.float64],
    orders: NDArray[np.int32],
) -> Sweeps:
    """The work of filling `cost` with the cost of reaching each explored cell from `start`.

    `moves` (rows, cols) has bit k where the move in direction k is possible, and then so is the way
    back, as in a belief. `cost` (rows * cols,) is written at explored cells only, inf where they
    cannot be reached. `orders` (k, explored) are the explored cells, flat, in the orders in which
    they are swept, one after the other: `raster_order(moves, start)` is Burgard's loop. Ends after
    a sweep that changes nothing; costs do not depend on the order.
    """
    return Sweeps(*_value_iteration(moves, start, cost, orders))


@kernel
def _value_iteration(
    moves: NDArray[np.uint8],
    start: int,
    cost: NDArray[np.float64],
    orders: NDArray[np.int32],
) -> tuple[int, int, int]:
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    count = orders.shape[1]
    # Cells that are not explored cost nothing, not even being set: no move leads to them.
    for i in range(count):
        cost[orders[0, i]] = np.inf
    cost[start] = 0.0
    sweeps = 0
    lowered = 0
    before = -1
    while lowered > before:
        before = lowered
        turn = sweeps % orders.shape[0]
        for i in range(count):
            cell = orders[turn, i]
            bits = flat[cell]
            best = cost[cell]
            for k in range(8):
                if bits & (1 << k):
                    reached = cost[cell + DROW[k] * cols + DCOL[k]]
                    best = min(best, reached + (1.0 if k < 4 else DIAGONAL))
            if best < cost[cell]:
                cost[cell] = best
                lowered += 1
        sweeps += 1
    return sweeps, sweeps * count, lowered
