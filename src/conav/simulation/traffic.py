"""The shared local traffic rule: who may move when robots meet.

Robots choose in order of priority; one that wants to go where another stands makes that one move
first, as `pibt` says.

Priorities differ from those of the paper. There they grow until a goal is reached, but explorers
drop and change goals all the time, and robots whose priorities follow each other push each other to
and fro. Here robots that want to move come before idle ones, and among them the order is drawn anew
at set times, after 24, 24, 48, 24, 24, 48, 96, ... steps (Luby, Sinclair, Zuckerman 1993): often
enough to part robots that block each other in step, and now and then for long enough to push one
out of a long corridor.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW, SQRT2, STAY
from conav.simulation.pibt import make_room

ORDER_STEPS = 24  # [steps] the shortest time one order of robots holds
MOVED = 1
TURNED = 2

# How long an order holds, in units of ORDER_STEPS: the Luby sequence, after which it begins anew.
_LUBY = (
    *(1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8),
    *(1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8, 16),
)
_LUBY_SUM = sum(_LUBY)


@kernel
def order_of(step: int) -> int:
    """Which order of robots holds at a step; orders are numbered from 0."""
    units = step // ORDER_STEPS
    number = units // _LUBY_SUM * len(_LUBY)
    left = units % _LUBY_SUM
    for k in range(len(_LUBY)):
        if left < _LUBY[k]:
            return number + k
        left -= _LUBY[k]
    return number


@kernel
def rank_in(order: int, robot: int) -> int:
    """A number that sorts the robots in that order: mixed from both, the first order by number."""
    if order == 0:
        return robot
    mixed = (order * 0x9E3779B1 + robot * 0x85EBCA77) & 0xFFFFFFFF
    mixed = ((mixed ^ (mixed >> 15)) * 0x2C1B3C6D) & 0xFFFFFFFF
    mixed = ((mixed ^ (mixed >> 12)) * 0x297A2D39) & 0xFFFFFFFF
    return (mixed ^ (mixed >> 15)) & 0xFFFFFFFF


@kernel
def able_and_wanted(
    wish: NDArray[np.int8],
    ways: NDArray[np.uint8],
    rate: NDArray[np.float64],
    credit: NDArray[np.float64],
    able: NDArray[np.uint8],
    wanted: NDArray[np.int8],
) -> None:
    """Let every robot earn its travel; fill what it can afford and which move it wants.

    `able` gets bit 0 for a straight move and bit 1 for a diagonal. A wish for a move that does not
    exist is a wish to stay.
    """
    for i in range(wish.shape[0]):
        credit[i] += rate[i]
        able[i] = 0
        if credit[i] >= 1.0 - 1e-9:
            able[i] |= 1
        if credit[i] >= SQRT2 - 1e-9:
            able[i] |= 2
        k = wish[i]
        wanted[i] = k if k >= 0 and ways[i] & (1 << k) else STAY


@kernel
def carry_out(
    chosen: NDArray[np.int8],
    turn_to: NDArray[np.int8],
    wanted: NDArray[np.int8],
    able: NDArray[np.uint8],
    width: int,
    rate: NDArray[np.float64],
    turning: NDArray[np.uint8],
    cells: NDArray[np.int32],
    heading: NDArray[np.int8],
    credit: NDArray[np.float64],
    travelled: NDArray[np.float64],
    outcome: NDArray[np.uint8],
) -> int:
    """The number of robots that moved; makes the chosen moves and turns."""
    n = cells.shape[0]
    moved = 0
    for i in range(n):
        outcome[i] = 0
        k = chosen[i]
        if k >= 0:
            cells[i] += DROW[k] * width + DCOL[k]
            length = SQRT2 if k >= 4 else 1.0
            credit[i] = max(credit[i] - length, 0.0)
            travelled[i] += length
            outcome[i] = MOVED
            moved += 1
            if k < 4:
                heading[i] = k
            continue
        if turning[i] == 1:
            face = turn_to[i]
            if face < 0 and wanted[i] >= 0 and wanted[i] < 4:
                face = wanted[i]
            if face >= 0 and face != heading[i]:
                heading[i] = face
                outcome[i] = TURNED
                credit[i] = 0.0
                continue
        if wanted[i] < 0 or (able[i] >> (1 if wanted[i] >= 4 else 0)) & 1 == 1:
            # Standing, it keeps what a slow robot lacks for a straight move, so that it can be
            # pushed; one that waits for its move's time to pass keeps all.
            credit[i] = min(credit[i], 1.0 - rate[i])
    return moved


@kernel
def resolve(
    step: int,
    cells: NDArray[np.int32],
    wish: NDArray[np.int8],
    ways: NDArray[np.uint8],
    width: int,
    heading: NDArray[np.int8],
    turning: NDArray[np.uint8],
    gap: NDArray[np.float64],
    rate: NDArray[np.float64],
    credit: NDArray[np.float64],
    travelled: NDArray[np.float64],
    outcome: NDArray[np.uint8],
) -> int:
    """The number of robots that moved; updates cells, headings, credit and path lengths in place.

    `wish` (n,) is the direction each mind asked for, `ways` (n,) the moves each robot knows it can
    make from where it is, `width` the columns of planning cells, `gap` the radii
    [cells]. A robot earns `rate` cells of travel a step while it wants to move; a straight move
    takes 1, a diagonal sqrt(2), so that nobody is ever faster than allowed. `outcome` gets `MOVED`,
    `TURNED` or 0.
    """
    n = cells.shape[0]
    rows = np.empty(n, dtype=np.int32)
    cols = np.empty(n, dtype=np.int32)
    able = np.zeros(n, dtype=np.uint8)
    chosen = np.full(n, STAY, dtype=np.int8)
    decided = np.zeros(n, dtype=np.uint8)
    turn_to = np.full(n, STAY, dtype=np.int8)
    wanted = np.empty(n, dtype=np.int8)
    able_and_wanted(wish, ways, rate, credit, able, wanted)
    for i in range(n):
        rows[i] = cells[i] // width
        cols[i] = cells[i] % width
    # Those who want to move in the order that holds now, then the idle. Staying is always left to
    # each: whatever was decided so far leaves room for everybody standing.
    order = order_of(step)
    key = np.empty(n, dtype=np.int64)
    for i in range(n):
        key[i] = rank_in(order, i) + ((1 << 40) if wanted[i] < 0 else 0)
    for i in np.argsort(key, kind="mergesort"):
        if decided[i] == 0:
            make_room(
                i,
                rows,
                cols,
                wanted,
                able,
                ways,
                heading,
                turning,
                gap,
                chosen,
                decided,
                turn_to,
            )
    return carry_out(
        chosen,
        turn_to,
        wanted,
        able,
        width,
        rate,
        turning,
        cells,
        heading,
        credit,
        travelled,
        outcome,
    )
