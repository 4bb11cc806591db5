"""Moves that make room for each other: priority inheritance with backtracking.

PIBT (Okumura, Machida, Defago, Tamura, IJCAI 2019), for discs: two moves of the same step are in
conflict when the robots, each driving its straight line at constant speed, would come nearer than
the sum of their radii, and never less than `MIN_GAP` of a cell apart, which forbids swapping cells,
crossing diagonally and sharing a cell even for robots of no size.

One thing differs from the paper: a pushed robot leaves to the side where it can, so that it is
passed at the first side pocket; a robot that must turn for that turns first.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW, OPPOSITE, STAY

MIN_GAP = 0.4  # [cells]

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
def make_room(
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
