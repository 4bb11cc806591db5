"""How a robot of a bulk game chooses among its four sequences, draw for draw as strategies do."""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.simulation.bulk_random import next_double


@kernel
def best_of_four(
    gain0: int,
    gain1: int,
    gain2: int,
    gain3: int,
    baseline_wins: bool,
    states: NDArray[np.uint64],
    i: int,
) -> int:
    """The turn of highest gain, or -1 when all are blocked."""
    most = max(max(gain0, gain1), max(gain2, gain3))
    if most < 0:
        return -1
    if baseline_wins and gain0 == most:
        return 0
    tie0 = 1 if gain0 == most else 0
    tie1 = 1 if gain1 == most else 0
    tie2 = 1 if gain2 == most else 0
    tie3 = 1 if gain3 == most else 0
    ties = tie0 + tie1 + tie2 + tie3
    pick = int(next_double(states, i) * ties) if ties > 1 else 0
    # Sums instead of branches, which nobody could predict.
    return int(pick >= tie0) + int(pick >= tie0 + tie1) + int(pick >= tie0 + tie1 + tie2)


@kernel
def better_of_four(
    gain0: int, gain1: int, gain2: int, gain3: int, states: NDArray[np.uint64], i: int
) -> int:
    """One possible turn at random if it is better than going forward, else 0; -1 if none is."""
    can0 = 1 if gain0 >= 0 else 0
    can1 = 1 if gain1 >= 0 else 0
    can2 = 1 if gain2 >= 0 else 0
    possible = can0 + can1 + can2 + (1 if gain3 >= 0 else 0)
    if possible == 0:
        return -1
    pick = int(next_double(states, i) * possible)
    if pick < can0:
        return 0
    if pick < can0 + can1:
        return 1 if gain1 > gain0 else 0
    if pick < can0 + can1 + can2:
        return 2 if gain2 > gain0 else 0
    return 3 if gain3 > gain0 else 0
