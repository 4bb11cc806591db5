"""How long robots take to places of a known map, never overestimated.

A robot earns `rate` cells of travel a step (1 for the fastest) and a move is made when its length
is earned, so after k steps nobody has driven more than k * rate cells. `SLACK` covers what the
simulation gives away: each move may be made 1e-9 cells before it is earned.
"""

import heapq
from math import ceil, isinf

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW, SQRT2
from conav.robots.motion import Motion

SLACK = 2e-9  # of a length, and on top of a number of steps; every move is one cell at least


def turn_cost(motion: Motion, rate: float) -> float:
    """What turning costs a robot in cells of travel: a step's earnings, or nothing."""
    return rate if motion.turn_costs_step else 0.0


def whole_steps(steps: float) -> float:
    """The earliest whole step at which travel worth `steps` steps can be over; inf stays inf."""
    return steps if isinf(steps) else float(max(ceil(steps * (1.0 - SLACK) - SLACK), 0))


def most_travel(steps: float, rate: float) -> float:
    """The most cells of travel a robot can have made in a number of steps."""
    return (steps + SLACK) * rate / (1.0 - SLACK)


def travel_from(
    moves: NDArray[np.uint8], sources: NDArray[np.int64], turn: float
) -> NDArray[np.float64]:
    """The least cells of travel from any of the sources to each planning cell, flat.

    Straight moves cost 1, diagonal ones sqrt(2); inf where no path leads. With `turn` above 0 a
    robot drives the way it faces and turning costs that much; it may face any way at first and in
    the end. Dijkstra's algorithm: over cells with buckets as wide as the shortest move (Dial 1969),
    over cells and headings with a heap.
    """
    return _turning(moves, sources, turn) if turn > 0.0 else _free(moves, sources)


@kernel
def _free(moves: NDArray[np.uint8], sources: NDArray[np.int64]) -> NDArray[np.float64]:
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    best = np.full(flat.shape[0], np.inf)
    # No move is shorter than a bucket is wide, so what lies in the one at hand is final.
    buckets = np.empty((3, flat.shape[0]), dtype=np.int32)
    filled = np.zeros(3, dtype=np.int64)
    for i in range(sources.shape[0]):
        if best[sources[i]] > 0.0:
            best[sources[i]] = 0.0
            buckets[0, filled[0]] = sources[i]
            filled[0] += 1
    level = 0
    empty = 0
    while empty < 3:
        slot = level % 3
        empty = empty + 1 if filled[slot] == 0 else 0
        for i in range(filled[slot]):
            cell = buckets[slot, i]
            reached = best[cell]
            if int(reached) != level:
                continue  # a shorter way led to it later: it was dealt with in that bucket
            bits = flat[cell]
            for k in range(8):
                if bits & (1 << k):
                    other = cell + DROW[k] * cols + DCOL[k]
                    length = reached + (1.0 if k < 4 else SQRT2)
                    if length < best[other]:
                        there = best[other] < np.inf and int(best[other]) == int(length)
                        best[other] = length
                        if not there:
                            into = int(length) % 3
                            buckets[into, filled[into]] = other
                            filled[into] += 1
        filled[slot] = 0
        level += 1
    return best


@kernel
def _turning(
    moves: NDArray[np.uint8], sources: NDArray[np.int64], turn: float
) -> NDArray[np.float64]:
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    best = np.full(4 * flat.shape[0], np.inf)
    heap = [(0.0, np.int64(-1))]
    for i in range(sources.shape[0]):
        for h in range(4):
            best[4 * sources[i] + h] = 0.0
            heapq.heappush(heap, (0.0, np.int64(4 * sources[i] + h)))
    while len(heap) > 0:
        reached, state = heapq.heappop(heap)
        if state < 0 or reached > best[state]:
            continue
        cell = state // 4
        for h in range(4):
            if reached + turn < best[4 * cell + h]:
                best[4 * cell + h] = reached + turn
                heapq.heappush(heap, (reached + turn, 4 * cell + h))
        facing = state % 4
        if flat[cell] & (1 << facing):
            other = 4 * (cell + DROW[facing] * cols + DCOL[facing]) + facing
            if reached + 1.0 < best[other]:
                best[other] = reached + 1.0
                heapq.heappush(heap, (reached + 1.0, other))
    result = np.empty(flat.shape[0])
    for cell in range(flat.shape[0]):
        result[cell] = best[4 * cell : 4 * cell + 4].min()
    return result
