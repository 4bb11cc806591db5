"""One step of the rendezvous game, for all robots at once.

After [Philip2014], sections 2.1.1 to 2.1.3:
- A robot that turned in the step before goes forward. In the first step nobody explores.
- Another explores with probability epsilon. It draws one of its sequences and predicts where it
  and the others end if they all go on forward. If that is strictly better for it than going forward
  itself, it turns.
- A robot at the border that it faces cannot go on, and counts for the others as staying. It makes
  the turn of highest predicted utility, equal ones drawn, as Algorithm 2 of [Philip2014] does at
  obstacles.
- Otherwise it goes forward.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.games.rendezvous import TIE, reach
from conav.games.splitmix64 import below, draw, unit
from conav.geometry.directions import DCOL, DROW

# Columns of a state, shape (n_robots, 4).
X = 0
Y = 1
HEADING = 2
TURNED = 3  # 1 between a turn and its move forward, else 0


@kernel
def start(seed: np.uint64, width: int, height: int, state: NDArray[np.int64]) -> None:
    """Write a random state: positions and headings drawn evenly, each for itself."""
    for i in range(state.shape[0]):
        state[i, X] = below(draw(seed, 3 * i), width)
        state[i, Y] = below(draw(seed, 3 * i + 1), height)
        state[i, HEADING] = below(draw(seed, 3 * i + 2), 4)
        state[i, TURNED] = 0


@kernel
def extent(state: NDArray[np.int64]) -> int:
    """The longer side of the box around all robots."""
    longest = 0
    for axis in range(2):
        low = state[0, axis]
        high = low
        for i in range(1, state.shape[0]):
            low = min(low, state[i, axis])
            high = max(high, state[i, axis])
        longest = max(longest, high - low)
    return longest


@kernel
def step(
    seed: np.uint64,
    t: int,
    epsilon: float,
    width: int,
    height: int,
    state: NDArray[np.int64],
    ahead: NDArray[np.int64],
) -> None:
    """Change the state by step number t; `ahead` is working space, shape (n_robots, 2)."""
    n = state.shape[0]
    for i in range(n):
        x, y, heading = state[i, X], state[i, Y], state[i, HEADING]
        ahead[i, X], ahead[i, Y] = reach(x, y, heading, 0, width, height)
    # Whoever moves or turns here does not enter what the others predict: `ahead` is fixed.
    for i in range(n):
        x, y, heading = state[i, X], state[i, Y], state[i, HEADING]
        turn = 0
        # Three draws for each robot's start, then two for each robot and step, used or not.
        number = 3 * n + 2 * (t * n + i)
        if ahead[i, X] == x and ahead[i, Y] == y:
            turn = _best_turn(i, draw(seed, number + 1), width, height, state, ahead)
        elif t > 0 and state[i, TURNED] == 0 and unit(draw(seed, number)) < epsilon:
            turn = _better_turn(i, draw(seed, number + 1), width, height, state, ahead)
        if turn > 0:
            state[i, HEADING] = (heading + turn) % 4
            state[i, TURNED] = 1
        else:
            state[i, X] = x + DCOL[heading]
            state[i, Y] = y + DROW[heading]
            state[i, TURNED] = 0


@kernel
def _utility(i: int, x: int, y: int, ahead: NDArray[np.int64]) -> float:
    """Minus the sum of the distances from (x, y) to where the others are predicted."""
    total = 0.0
    for j in range(ahead.shape[0]):
        if j != i:
            dx = x - ahead[j, X]
            dy = y - ahead[j, Y]
            total += np.sqrt(float(dx * dx + dy * dy))
    return -total


@kernel
def _better_turn(
    i: int,
    bits: np.uint64,
    width: int,
    height: int,
    state: NDArray[np.int64],
    ahead: NDArray[np.int64],
) -> int:
    """One of the sequences possible, drawn, if it is better than going forward; else 0."""
    x, y, heading = state[i, X], state[i, Y], state[i, HEADING]
    possible = 0
    for turn in range(4):
        if reach(x, y, heading, turn, width, height) != (x, y):
            possible += 1
    left = below(bits, possible)
    for turn in range(4):
        end = reach(x, y, heading, turn, width, height)
        if end == (x, y):
            continue
        if left == 0:
            forward = _utility(i, ahead[i, X], ahead[i, Y], ahead)
            return turn if _utility(i, end[0], end[1], ahead) - forward > TIE else 0
        left -= 1
    return 0


@kernel
def _best_turn(
    i: int,
    bits: np.uint64,
    width: int,
    height: int,
    state: NDArray[np.int64],
    ahead: NDArray[np.int64],
) -> int:
    """The turn of highest predicted utility among those possible, equal ones drawn."""
    x, y, heading = state[i, X], state[i, Y], state[i, HEADING]
    gains = np.full(4, -np.inf)
    for turn in range(1, 4):
        end = reach(x, y, heading, turn, width, height)
        if end != (x, y):
            gains[turn] = _utility(i, end[0], end[1], ahead)
    top = gains.max()
    equal = 0
    for turn in range(1, 4):
        if top - gains[turn] <= TIE:
            equal += 1
    left = below(bits, equal)
    for turn in range(1, 4):
        if top - gains[turn] <= TIE:
            if left == 0:
                return turn
            left -= 1
    return 0
