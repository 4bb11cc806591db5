"""Shortest paths over bytes of moves, from one start outwards, stopping as soon as possible."""

import threading

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW, SQRT2


class SearchSpace:
    """Working arrays of a search over `size` cells, reused without being cleared.

    Cells carry the number of the search that touched them last, so results never depend on what
    an earlier search left behind.
    """

    def __init__(self, size: int) -> None:
        self.stamp = np.zeros(size + 1, dtype=np.int32)  # [size] counts the searches
        self.distance = np.empty(size, dtype=np.float64)  # [cells]
        self.diagonals = np.empty(size, dtype=np.int32)  # diagonal moves among them
        self.parent = np.empty(size, dtype=np.int8)  # direction by which a cell was reached
        self.path = np.empty(size, dtype=np.int8)
        self.buckets = np.empty((3, size), dtype=np.int32)


_spaces = threading.local()


def search_space(size: int) -> SearchSpace:
    """This thread's working arrays for searches over `size` cells (the last size is kept)."""
    space: SearchSpace | None = getattr(_spaces, "space", None)
    if space is None or space.distance.shape[0] != size:
        space = SearchSpace(size)
        _spaces.space = space
    return space


def search(
    moves: NDArray[np.uint8],
    start: int,
    goals: NDArray[np.uint8],
    mask: int,
    space: SearchSpace,
) -> int:
    """The nearest cell whose `goals` share a bit with `mask`, or -1 when none can be reached.

    Straight moves cost 1, diagonal ones sqrt(2); ties go to the lower flat index. Dijkstra with
    buckets of width 1 (Dial 1969; Denardo and Fox 1979): no move is shorter than a bucket, so all
    distances in the bucket at hand are final and their order inside it does not matter. On return
    `space.stamp[cell] == space.stamp[-1]` marks the cells whose distance and parent are current;
    they are final everywhere when nothing was found.
    """
    return _search(
        moves,
        start,
        goals,
        mask,
        space.stamp,
        space.distance,
        space.diagonals,
        space.parent,
        space.buckets,
    )


@kernel
def _search(
    moves: NDArray[np.uint8],
    start: int,
    goals: NDArray[np.uint8],
    mask: int,
    stamp: NDArray[np.int32],
    distance: NDArray[np.float64],
    diagonals: NDArray[np.int32],
    parent: NDArray[np.int8],
    buckets: NDArray[np.int32],
) -> int:
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    wanted = goals.reshape(-1)
    size = flat.shape[0]
    now = stamp[size] + 1
    stamp[size] = now
    stamp[start] = now
    distance[start] = 0.0
    diagonals[start] = 0
    parent[start] = -1
    filled = np.zeros(3, dtype=np.int64)
    buckets[0, 0] = start
    filled[0] = 1
    level = 0
    empty = 0
    while empty < 3:
        slot = level % 3
        count = filled[slot]
        empty = empty + 1 if count == 0 else 0
        best = -1
        for i in range(count):
            cell = buckets[slot, i]
            reached = distance[cell]
            # Moved on to an earlier bucket by a shorter way: dealt with there.
            if int(reached) != level:
                continue
            if wanted[cell] & mask and (
                best < 0 or reached < distance[best] or (reached == distance[best] and cell < best)
            ):
                best = cell
        if best >= 0:
            return best
        for i in range(count):
            cell = buckets[slot, i]
            reached = distance[cell]
            if int(reached) != level:
                continue
            bits = flat[cell]
            diagonal = diagonals[cell]
            # Lengths are made from the two numbers of moves, never added up move by move, so that
            # equal lengths are equal floats whatever the order of the moves.
            straight = int(reached - diagonal * SQRT2 + 0.5)
            for k in range(8):
                if bits & (1 << k):
                    following = cell + DROW[k] * cols + DCOL[k]
                    more = diagonal + (1 if k >= 4 else 0)
                    length = straight + (1 if k < 4 else 0) + more * SQRT2
                    if stamp[following] != now:
                        stamp[following] = now
                    elif length >= distance[following]:
                        continue
                    elif int(distance[following]) == int(length):
                        # It lies in that bucket already.
                        distance[following] = length
                        diagonals[following] = more
                        parent[following] = k
                        continue
                    distance[following] = length
                    diagonals[following] = more
                    parent[following] = k
                    other = int(length) % 3
                    buckets[other, filled[other]] = following
                    filled[other] += 1
        filled[slot] = 0
        level += 1
    return -1


def path_to(space: SearchSpace, cols: int, goal: int) -> tuple[NDArray[np.int8], int]:
    """The moves of the last search's path to `goal`, the last one first, and how many they are."""
    length = _trace_back(cols, space.parent, goal, space.path)
    return space.path[:length].copy(), length


@kernel
def _trace_back(cols: int, parent: NDArray[np.int8], goal: int, out: NDArray[np.int8]) -> int:
    """The number of moves from the last search's start to `goal`, written to `out` backwards."""
    count = 0
    cell = goal
    while parent[cell] >= 0:
        k = parent[cell]
        out[count] = k
        count += 1
        cell -= DROW[k] * cols + DCOL[k]
    return count
