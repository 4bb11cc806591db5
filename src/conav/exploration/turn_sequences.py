"""Two-step action sequences and what they would discover: the game of papers on potential games.

[Philip2014] lets a robot move as Lindsay's simple forward turn does: it goes forward, or spends a
step on turning and goes forward in the next. At a time t it can play one of four two-step sequences
(2): forward twice (the baseline), or turn by +90, 180 or -90 degrees and go forward. Its utility
(7) is the number of points it has discovered plus those it would discover on the way that nobody
has. Only the second part depends on the sequence; here it is called the gain of a sequence, and it
is counted over the squares around the future positions, (16) and (17), so that its cost does not
depend on the size of the map.

On real maps a point is a cell of the map and robots stand on planning cells of any size. Where
walls block sight a point counts when it could be seen from the future position if everything
unknown were clear; through walls, as in the paper, robots would be drawn to what they can never
see. With a motion that turns for free a turn sequence takes one step; its position is the same.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.types import Action, TeamView
from conav.geometry.directions import DCOL, DROW, STAY, STRAIGHT
from conav.geometry.sight import (
    visible_cells,
)
from conav.geometry.sight_space import sight_space
from conav.maps.occupancy_grid import OCCUPIED, UNKNOWN

BLOCKED = -1
"""Gain of a sequence that cannot be played: its first move is not known to be possible."""
LEFT_OUT = 2
"""State of a point that somebody saw and nobody counts as discovered."""

Tie = Literal["random", "baseline"]
Draw = Literal["step", "sequence"]

_NOTHING = np.empty((0, 0), dtype=np.uint8)
_NOBODY = np.empty((0, 2), dtype=np.int32)


@dataclass
class TurnMemory:
    """Where a robot is in its sequence, and what its decisions have cost."""

    heading: int = -1  # the heading of the sequence under way, -1 for none
    bound_at: tuple[int, ...] = ()  # planning cells in which it is bound to go on with that
    decisions: int = 0  # how often it computed utilities
    points_checked: int = 0  # points looked at for that
    turns: int = 0  # turn sequences played
    free_steps: int = 0  # steps in which it was not bound to the second step of a sequence


def predicted_positions(
    row: int, col: int, heading: int
) -> tuple[tuple[tuple[int, int], ...], ...]:
    """Where a robot expects to be for each sequence of (2), in their order (Figure 1).

    Per sequence the (row, col) of its new positions in time order: two for the baseline, one for
    each turn. `heading` is 0 to 3 for E, N, W, S; +90 degrees is to the left.
    """
    positions: list[tuple[tuple[int, int], ...]] = []
    for turn in range(4):
        k = (heading + turn) % 4
        steps = (1, 2) if turn == 0 else (1,)
        positions.append(tuple((row + s * DROW[k], col + s * DCOL[k]) for s in steps))
    return tuple(positions)


def points_in_square(s_range: int) -> int:
    """The points to be scanned in the square around one position, (15)."""
    return (2 * s_range + 1) ** 2 - 1


def ways(view: TeamView) -> int:
    """The straight moves the robot knows it can make from where it stands, a bit each."""
    return int(view.belief.moves.item(view.cell)) & STRAIGHT


def clear_ahead(view: TeamView) -> bool:
    """Whether no obstacle is in front of the robot; a teammate is none."""
    return ways(view) >> view.heading & 1 == 1


def second_step(memory: TurnMemory, view: TeamView) -> bool:
    """Whether the robot is in the middle of a sequence and goes forward now; counts the others.

    A sequence that somebody else's push has undone does not bind it any more. A robot too slow to
    move in every step stays bound until it has moved.
    """
    if view.cell in memory.bound_at and view.heading == memory.heading and clear_ahead(view):
        return True
    memory.bound_at = ()
    memory.free_steps += 1
    return False


def check_settings(epsilon: float, tie: str = "random", draw: str = "step") -> None:
    """Raise `ValueError` for settings that mean nothing."""
    if not 0.0 <= epsilon <= 1.0:
        raise ValueError(f"epsilon is {epsilon:g}; a probability is 0 to 1")
    if tie not in get_args(Tie):
        raise ValueError(f"tie is {tie!r}; it is one of {', '.join(get_args(Tie))}")
    if draw not in get_args(Draw):
        raise ValueError(f"draw is {draw!r}; it is one of {', '.join(get_args(Draw))}")


def explores(view: TeamView, epsilon: float, rng: np.random.Generator) -> bool:
    """Whether the robot may change its action in this step: with probability epsilon.

    In the first step everybody goes forward (section 2.1.1), and nothing is drawn.
    """
    return view.step > 0 and rng.random() < epsilon


def forward(view: TeamView) -> Action:
    """The second step of a sequence."""
    return Action(view.heading)


def play(memory: TurnMemory, view: TeamView, turn: int, draw: Draw) -> Action:
    """The first step of the sequence with that turn (0 is the baseline); `STAY` for none."""
    if turn < 0:
        return Action(STAY)
    heading = memory.heading = (view.heading + turn) % 4
    if turn != 0:
        memory.turns += 1
        if view.body.motion.turn_costs_step:
            memory.bound_at = (view.cell,)
    elif draw == "sequence":
        ahead = view.cell + DROW[heading] * view.lattice.cols + DCOL[heading]
        memory.bound_at = (view.cell, ahead)
    return Action(heading)


def best_of(gains: NDArray[np.int64], tie: Tie, rng: np.random.Generator) -> int:
    """The sequence of highest gain, (14), or -1 when all are blocked.

    With `tie` "baseline" the baseline wins every tie it is in, as section 2.4 has it; all other
    ties, and with "random" that one too, are drawn evenly.
    """
    values = gains.tolist()
    most = max(values)
    if most == BLOCKED:
        return -1
    if tie == "baseline" and values[0] == most:
        return 0
    if values.count(most) == 1:
        return values.index(most)
    ties = [turn for turn in range(4) if values[turn] == most]
    return ties[int(rng.random() * len(ties))]


def turn_from_obstacle(gains: NDArray[np.int64], rng: np.random.Generator) -> int:
    """The turn of highest gain, as Algorithm 2 takes before an obstacle; -1 when shut in."""
    turns = gains.copy()
    turns[0] = BLOCKED
    return best_of(turns, "random", rng)


def sequence_gains(
    memory: TurnMemory,
    view: TeamView,
    state: NDArray[np.uint8] = _NOTHING,
    others: NDArray[np.int32] = _NOBODY,
) -> NDArray[np.int64]:
    """How many points each of the four sequences would newly discover, `BLOCKED` where it cannot.

    Equation (17) less its constant first term. A point is undiscovered when it is unknown, or where
    `state` (fine rows, fine cols; may be empty) marks it `LEFT_OUT`. Points within the sensor's
    range of `others` (k, 2), predicted fine positions of teammates, do not count: (18). Adds to the
    memory's counters.
    """
    lattice = view.lattice
    sensor = view.body.sensor
    space = sight_space(
        sensor.range_m, lattice.resolution, sensor.occlusion, view.belief.cells.shape
    )
    gains = np.empty(4, dtype=np.int64)
    row, col = divmod(view.cell, lattice.cols)
    checked = _sequence_gains(
        view.belief.cells,
        state,
        others,
        row,
        col,
        view.heading,
        ways(view),
        lattice.fine_row,
        lattice.fine_col,
        *space,
        gains,
    )
    memory.decisions += 1
    memory.points_checked += checked
    return gains


@kernel
def in_range(limits: NDArray[np.int32], down: int, right: int) -> bool:
    """Whether a point so many rows and columns away lies within the sensor's range."""
    d = abs(down)
    return d < limits.shape[0] and abs(right) <= limits[d]


@kernel
def near_any(others: NDArray[np.int32], limits: NDArray[np.int32], r: int, c: int) -> bool:
    """Whether a point lies within the sensor's range of one of these positions."""
    near = False
    for i in range(others.shape[0]):
        near = near or in_range(limits, others[i, 0] - r, others[i, 1] - c)
    return near


@kernel
def _undiscovered(cells: NDArray[np.uint8], state: NDArray[np.uint8], r: int, c: int) -> bool:
    return cells[r, c] == UNKNOWN or (state.shape[0] > 0 and state[r, c] == LEFT_OUT)


@kernel
def _sequence_gains(
    cells: NDArray[np.uint8],
    state: NDArray[np.uint8],
    others: NDArray[np.int32],
    row: int,
    col: int,
    heading: int,
    bits: int,
    fine_row: NDArray[np.int32],
    fine_col: NDArray[np.int32],
    limits: NDArray[np.int32],
    occlusion: bool,
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    stamps: NDArray[np.int32],
    gains: NDArray[np.int64],
) -> int:
    """The number of points looked at; fills `gains` (4,)."""
    checked = 0
    for turn in range(4):
        k = (heading + turn) & 3
        if bits & (1 << k) == 0:
            gains[turn] = BLOCKED
            continue
        r1 = fine_row[row + DROW[k]]
        c1 = fine_col[col + DCOL[k]]
        r2 = -1
        c2 = -1
        if turn == 0:
            r = row + 2 * DROW[k]
            c = col + 2 * DCOL[k]
            # The second move counts unless an obstacle is known to be there.
            if (
                0 <= r < fine_row.shape[0]
                and 0 <= c < fine_col.shape[0]
                and cells[fine_row[r], fine_col[c]] != OCCUPIED
            ):
                r2 = fine_row[r]
                c2 = fine_col[c]
        elif state.shape[0] > 0:
            # In its first step a robot that turns stays where it is, and points left out may be in
            # range there: C1 of (18). Without such points all in range here are known.
            r2 = fine_row[row]
            c2 = fine_col[col]
        if occlusion:
            found, looked = _count_in_sight(
                cells, state, others, limits, lows, highs, out, stamps, r1, c1, r2, c2
            )
        else:
            found, looked = _count_in_squares(cells, state, others, limits, r1, c1, r2, c2)
        gains[turn] = found
        checked += looked
    return checked


@kernel
def _count_in_squares(
    cells: NDArray[np.uint8],
    state: NDArray[np.uint8],
    others: NDArray[np.int32],
    limits: NDArray[np.int32],
    r1: int,
    c1: int,
    r2: int,
    c2: int,
) -> tuple[int, int]:
    """The undiscovered points within range of one or two positions, and how many were looked at.

    The squareSet of (16): the points bounded at the positions but for the positions themselves,
    which are known by the time a robot can plan to be there. (Where points may be left out they are
    looked at too: known is not discovered there.) The second is left out where it lies
    within range of the first, as it then is in the first square.
    """
    rows, cols = cells.shape
    reach = limits.shape[0] - 1
    found = 0
    looked = 0
    for r in range(max(r1 - reach, 0), min(r1 + reach, rows - 1) + 1):
        for c in range(max(c1 - reach, 0), min(c1 + reach, cols - 1) + 1):
            if r == r1 and c == c1 and state.shape[0] == 0:
                continue
            looked += 1
            if (
                _undiscovered(cells, state, r, c)
                and in_range(limits, r - r1, c - c1)
                and not near_any(others, limits, r, c)
            ):
                found += 1
    if r2 < 0:
        return found, looked
    for r in range(max(r2 - reach, 0), min(r2 + reach, rows - 1) + 1):
        for c in range(max(c2 - reach, 0), min(c2 + reach, cols - 1) + 1):
            if r == r2 and c == c2 and in_range(limits, r - r1, c - c1):
                continue
            looked += 1
            if (
                _undiscovered(cells, state, r, c)
                and in_range(limits, r - r2, c - c2)
                and not in_range(limits, r - r1, c - c1)
                and not near_any(others, limits, r, c)
            ):
                found += 1
    return found, looked


@kernel
def _count_in_sight(
    cells: NDArray[np.uint8],
    state: NDArray[np.uint8],
    others: NDArray[np.int32],
    limits: NDArray[np.int32],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    stamps: NDArray[np.int32],
    r1: int,
    c1: int,
    r2: int,
    c2: int,
) -> tuple[int, int]:
    """The undiscovered points that might be seen from one or two positions, and those looked at."""
    cols = cells.shape[1]
    stamp = stamps[stamps.shape[0] - 1] + 1
    stamps[stamps.shape[0] - 1] = stamp
    found = 0
    looked = 0
    for second in range(2):
        if second == 1 and r2 < 0:
            break
        r0 = r2 if second == 1 else r1
        c0 = c2 if second == 1 else c1
        count = visible_cells(cells, r0, c0, limits, lows, highs, out)
        looked += count
        for i in range(count):
            cell = out[i]
            r = cell // cols
            c = cell - r * cols
            if stamps[cell] != stamp and _undiscovered(cells, state, r, c):
                stamps[cell] = stamp
                if not near_any(others, limits, r, c):
                    found += 1
    return found, looked
