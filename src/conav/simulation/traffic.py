"""The shared local traffic rule: who may move when robots meet.

Priority inheritance with backtracking (PIBT; Okumura, Machida, Defago, Tamura, IJCAI 2019): robots
choose in order of priority; one that wants to go where another stands makes that one move first.
Here for discs: two moves of the same step are in conflict when the robots, each driving its
straight line at constant speed, would come nearer than the sum of their radii, and never less than
`MIN_GAP` of a cell apart, which forbids swapping cells, crossing diagonally and sharing a cell even
for robots of no size.

Two things differ from the paper. Priorities there grow until a goal is reached, but explorers drop
and change goals all the time, and robots whose priorities follow each other push each other to and
fro. Here robots that want to move come before idle ones, and among them the order is drawn anew at
set times, after 24, 24, 48, 24, 24, 48, 96, ... steps (Luby, Sinclair, Zuckerman 1993): often
enough to part robots that block each other in step, and now and then for long enough to push one
out of a long corridor. And a pushed robot leaves to the side where it can, so that it is passed at
the first side pocket; a robot that must turn for that turns first.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW, OPPOSITE, SQRT2, STAY

MIN_GAP = 0.4  # [cells]
ORDER_STEPS = 24  # [steps] the shortest time one order of robots holds
MOVED = 1
TURNED = 2

# How long an order holds, in units of ORDER_STEPS: the Luby sequence, after which it begins anew.
_LUBY = (
    *(1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8),
    *(1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8, 16),
)
_LUBY_SUM = sum(_LUBY)

# Directions by how well they get out of the way of a push in direction k: to the sides first, then
# slanting onwards, onwards, slanting back, back.
_ASIDE = (
    (1, 3, 4, 7, 0, 5, 6, 2),
    (0, 2, 4, 5, 1, 7, 6, 3),
    (1, 3, 5, 6, 2, 4, 7, 0),
    (0, 2, 6, 7, 3, 5, 4, 1),
    (5, 7, 0, 1, 4, 3, 2, 6),
    (4, 6, 1, 2, 5, 0, 3, 7),
    (5, 7, 2, 3, 6, 1, 0, 4),
    (4, 6, 0, 3, 7, 1, 2, 5),
)


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
def moves_conflict(r1: int, c1: int, k1: int, r2: int, c2: int, k2: int, gap_square: float) -> bool:
    """Whether two simultaneous moves come nearer than the gap [cells squared].

    Robots start at (r, c) and move in direction k, or stay where k is `STAY`, in the same time.
    """
    y = r2 - r1
    x = c2 - c1
    if y * y + x * x >= 32 + gap_square + 8 * gap_square:
        return False
    dy = (DROW[k2] if k2 >= 0 else 0) - (DROW[k1] if k1 >= 0 else 0)
    dx = (DCOL[k2] if k2 >= 0 else 0) - (DCOL[k1] if k1 >= 0 else 0)
    limit = gap_square - 1e-9
    if (y + dy) * (y + dy) + (x + dx) * (x + dx) < limit:
        return True
    length = dy * dy + dx * dx
    along = -(y * dy + x * dx)
    if 0 < along < length:
        cross = y * dx - x * dy
        return cross * cross < limit * length
    return False


@kernel
def _clear(
    robot: int,
    k: int,
    rows: NDArray[np.int32],
    cols: NDArray[np.int32],
    chosen: NDArray[np.int8],
    decided: NDArray[np.uint8],
    gap: NDArray[np.float64],
) -> bool:
    """Whether the robot's move k is in conflict with no decided move of another."""
    for j in range(rows.shape[0]):
        if j != robot and decided[j] == 1:
            g = max(float(gap[robot] + gap[j]), MIN_GAP)
            if moves_conflict(
                int(rows[robot]),
                int(cols[robot]),
                k,
                int(rows[j]),
                int(cols[j]),
                int(chosen[j]),
                g * g,
            ):
                return False
    return True


@kernel
def _vacant(
    robot: int,
    k: int,
    rows: NDArray[np.int32],
    cols: NDArray[np.int32],
    chosen: NDArray[np.int8],
    decided: NDArray[np.uint8],
    gap: NDArray[np.float64],
) -> bool:
    """Whether the robot's move k would hit nobody, decided or still standing."""
    for j in range(rows.shape[0]):
        if j != robot:
            g = max(float(gap[robot] + gap[j]), MIN_GAP)
            k2 = int(chosen[j]) if decided[j] == 1 else STAY
            if moves_conflict(
                int(rows[robot]), int(cols[robot]), k, int(rows[j]), int(cols[j]), k2, g * g
            ):
                return False
    return True


@kernel
def _decide(
    root: int,
    rows: NDArray[np.int32],
    cols: NDArray[np.int32],
    wish: NDArray[np.int8],
    able: NDArray[np.uint8],
    ways: NDArray[np.uint8],
    heading: NDArray[np.int8],
    turning: NDArray[np.uint8],
    gap: NDArray[np.float64],
    chosen: NDArray[np.int8],
    decided: NDArray[np.uint8],
    turn_to: NDArray[np.int8],
) -> bool:
    """Whether the robot, and all it pushes, found moves that leave room for all decided ones.

    A robot tries its wish, then (pushed) every way out, then staying. Whoever is undecided and
    would be hit while standing is pushed in turn; if one of them finds no room everything since the
    attempt is taken back. Written with a stack of its own: compiled recursion cannot be cached.
    """
    n = rows.shape[0]
    robots = np.empty(n + 1, dtype=np.int32)
    pushes = np.empty(n + 1, dtype=np.int8)
    attempts = np.zeros(n + 1, dtype=np.int8)
    scanned = np.zeros(n + 1, dtype=np.int32)  # robots already looked at for being hit
    kept_chosen = np.empty((n + 1, n), dtype=np.int8)
    kept_decided = np.empty((n + 1, n), dtype=np.uint8)
    depth = 0
    robots[0] = root
    pushes[0] = STAY
    returned = 0  # 1: the robot above found room, 2: it did not
    while depth >= 0:
        robot = int(robots[depth])
        push = int(pushes[depth])
        if returned == 2:
            # Somebody could not be pushed away: take the attempt back.
            chosen[:] = kept_chosen[depth]
            decided[:] = kept_decided[depth]
        elif returned == 0:
            scanned[depth] = -1
        trying = returned != 1
        returned = 0
        while trying:
            attempt = attempts[depth]
            if attempt == 11:
                break
            attempts[depth] += 1
            way = int(ways[robot])
            faces_out = (
                push >= 0
                and turning[robot] == 1
                and heading[robot] != OPPOSITE[push]
                and way & (1 << heading[robot]) != 0
            )
            if attempt == 0:
                k = int(wish[robot])
                if k < 0:
                    continue
            elif attempt == 1:
                # A robot that faces a way out, other than straight on, has turned to it before.
                if not faces_out or heading[robot] == push:
                    continue
                k = int(heading[robot])
            elif attempt < 10:
                if push < 0:
                    continue
                k = _ASIDE[push][attempt - 2]
                if k == wish[robot]:
                    continue
            else:
                k = STAY
            if k >= 0:
                if way & (1 << k) == 0:
                    continue
                if turning[robot] == 1 and (k >= 4 or heading[robot] != k):
                    # It has to turn first. Pushed, it turns to the first free way out and leaves a
                    # step later, rather than let itself be driven on past a side pocket; where
                    # none is free it faces one to push on by.
                    if k < 4 and push >= 0:
                        if _vacant(robot, k, rows, cols, chosen, decided, gap):
                            turn_to[robot] = k
                            break
                        if turn_to[robot] < 0 and not faces_out:
                            turn_to[robot] = k
                    continue
                if (able[robot] >> (1 if k >= 4 else 0)) & 1 == 0:
                    continue
            if not _clear(robot, k, rows, cols, chosen, decided, gap):
                continue
            kept_chosen[depth] = chosen
            kept_decided[depth] = decided
            chosen[robot] = k
            decided[robot] = 1
            scanned[depth] = 0 if k >= 0 else n
            trying = False
        if trying:
            returned = 2
            depth -= 1
            continue
        # Push the next undecided robot that would be hit while standing.
        pushed = -1
        while scanned[depth] < n and pushed < 0:
            j = int(scanned[depth])
            scanned[depth] += 1
            if decided[j] == 0:
                g = max(float(gap[robot] + gap[j]), MIN_GAP)
                if moves_conflict(
                    int(rows[robot]),
                    int(cols[robot]),
                    int(chosen[robot]),
                    int(rows[j]),
                    int(cols[j]),
                    STAY,
                    g * g,
                ):
                    pushed = j
        if pushed < 0:
            returned = 1
            depth -= 1
            continue
        depth += 1
        robots[depth] = pushed
        pushes[depth] = chosen[robot]
        attempts[depth] = 0
    return returned == 1


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
            _decide(
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
