"""Shortest path lengths from one cell to all others over bytes of moves.

Most of a map is open ground, where every cell has very many shortest paths. As in jump point search
[Harabor2011] and canonical orderings on grids [Sturtevant2016], a cell that was reached by a move
hands on only what no path around it reaches as well: after a straight move what lies straight on,
after a diagonal one that and its two straight parts, where nothing is in the way. Straight runs are
then written in one go, and only corners and diagonals go through a queue, with one list per length
rounded down (Dial 1969). Lengths are those of `grid_search.search`, float by float.

Why nothing is lost. Let x be reached from p, and the move from x to n be left out. Then p reaches n
by another cell, or directly, and that is (1) shorter, or (2) as long, and its last move is straight
while the one left out is diagonal, or (3) as long, and its last move runs along the row while the
one left out runs along the column. In case (1) no shortest path to n leads over x. Otherwise n has
a shortest path whose last move is straight, or even along the row; and moves along the row are left
out in case (1) only.
"""

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW, SQRT2
from conav.geometry.ground import Ground


class FieldSpace:
    """The queue of a search: entries in one list per length, rounded down."""

    def __init__(self, entries: int, lists: int) -> None:
        self.cell = np.empty(entries, dtype=np.int32)
        self.diagonals = np.empty(entries, dtype=np.int32)
        self.length = np.empty(entries, dtype=np.float64)
        self.came = np.empty(entries, dtype=np.int8)
        self.following = np.empty(entries, dtype=np.int32)
        self.head = np.empty(lists, dtype=np.int32)


_spaces = threading.local()


def field_buffer(size: int) -> NDArray[np.float64]:
    """This thread's working space for one field of `size` cells (the last size is kept).

    `fill_distances` clears only from the first to the last cell it wrote the last time, which for a
    short search is much less than all; nobody else may write to it.
    """
    buffer: NDArray[np.float64] | None = getattr(_spaces, "buffer", None)
    if buffer is None or len(buffer) != size:
        buffer = np.full(size, np.inf)
        _spaces.buffer = buffer
        _spaces.written = np.array([0, 0])  # cells that may be written lie from here to there
    return buffer


def _field_space(shape: tuple[int, int]) -> FieldSpace:
    """This thread's queue for grids of a shape (the last size is kept)."""
    entries = shape[0] * shape[1] // 4 + 64  # few cells wait; where it is too short it grows
    lists = shape[0] + shape[1] + 4  # longer than any straight run and a diagonal move
    space: FieldSpace | None = getattr(_spaces, "space", None)
    if space is None or len(space.cell) < entries or len(space.head) != lists:
        space = FieldSpace(entries, lists)
        _spaces.space = space
    return space


def fill_distances(
    ground: Ground,
    starts: NDArray[np.int64],
    distance: NDArray[np.float64],
    first: NDArray[np.int64] | None = None,
    places: NDArray[np.int64] | None = None,
) -> int:
    """The number of cells taken from the queue to fill `distance` with path lengths [cells].

    `distance` (rows * cols,) gets the length from the nearest of `starts`, flat cells, inf where no
    path leads; straight moves cost 1, diagonal ones
    sqrt(2), and a length is its number of straight moves plus sqrt(2) times that of diagonal ones.
    With `places` it ends early, when of each group
    `places[first[j]:first[j + 1]]` the nearest cell is final, and all that are no farther; other
    cells may then hold too large a length.
    """
    if first is None or places is None:
        first, places = _NO_GROUPS, _NO_PLACES
    taken = -1
    written = _spaces.written if distance is getattr(_spaces, "buffer", None) else None
    while taken < 0:
        if written is None:
            distance.fill(np.inf)
        else:
            distance[written[0] : written[1]] = np.inf
        space = _field_space(ground.moves.shape)
        taken, low, high = _spread_out(
            ground.moves,
            ground.only,
            ground.runs,
            starts,
            distance,
            first,
            places,
            space.cell,
            space.diagonals,
            space.length,
            space.came,
            space.following,
            space.head,
        )
        if written is not None:
            written[:] = low, high
        if taken < 0:  # the queue was too short
            _spaces.space = FieldSpace(4 * len(space.cell), len(space.head))
    return taken


def shortest_path(ground: Ground, start: int, goal: int) -> tuple[NDArray[np.int8], int]:
    """The moves of a shortest path, the last one first, and how many they are; none without a path.

    Of several shortest paths it is one that goes straight first and then along diagonals: a robot
    that drives along a frontier then moves straight on, while diagonals first make it zigzag. Of
    moves alike the last is that of the lowest direction, then the last but one, and so on.
    """
    distance = field_buffer(ground.moves.size)
    end = np.array([goal], dtype=np.int64)
    fill_distances(ground, np.array([start], dtype=np.int64), distance, _ONE_GROUP, end)
    if not np.isfinite(distance[goal]):
        return np.empty(0, dtype=np.int8), 0
    return walk_back(ground, distance, goal)


def walk_back(
    ground: Ground, distance: NDArray[np.float64], goal: int
) -> tuple[NDArray[np.int8], int]:
    """The path of `shortest_path` from where a field started, whose length to `goal` is exact."""
    path = np.empty(int(distance[goal]) + 1, dtype=np.int8)
    count = _walk_back(ground.moves, distance, goal, path)
    return path[:count], count


@kernel
def _walk_back(
    moves: NDArray[np.uint8], distance: NDArray[np.float64], goal: int, out: NDArray[np.int8]
) -> int:
    """The number of moves from the start of a field to a cell, written to `out` backwards."""
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    count = 0
    cell = goal
    while distance[cell] > 0.0:
        for j in range(8):
            k = j ^ 4  # diagonal moves first, as the path is made from its end
            back = k ^ 2  # E and W, N and S, NE and SW, NW and SE
            if flat[cell] & (1 << back) == 0:
                continue
            before = cell + DROW[back] * cols + DCOL[back]
            gap = distance[before] + (1.0 if k < 4 else SQRT2) - distance[cell]
            # Lengths are rounded once; paths of different lengths differ by more than this.
            if abs(gap) < 1e-9:
                out[count] = k
                count += 1
                cell = before
                break
    return count


_ONE_GROUP = np.array([0, 1], dtype=np.int64)
_NO_GROUPS = np.zeros(1, dtype=np.int64)
_NO_PLACES = np.empty(0, dtype=np.int64)


@kernel
def _spread_out(
    moves: NDArray[np.uint8],
    only: NDArray[np.uint8],
    runs: Any,  # (4, rows * cols) of a signed type
    starts: NDArray[np.int64],
    distance: NDArray[np.float64],
    first: NDArray[np.int64],
    places: NDArray[np.int64],
    e_cell: NDArray[np.int32],
    e_diagonals: NDArray[np.int32],
    e_length: NDArray[np.float64],
    e_came: NDArray[np.int8],
    e_next: NDArray[np.int32],
    head: NDArray[np.int32],
) -> tuple[int, int, int]:
    """How many entries were taken from the queue, -1 where it was too short.

    Beside it the first cell that was written, and the one after the last.
    """
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    lists = head.shape[0]
    capacity = e_cell.shape[0]
    head[:] = -1
    groups = first.shape[0] - 1
    settled = 0  # groups before this one have their nearest cell
    low = flat.shape[0]
    high = 0
    used = 0
    for i in range(starts.shape[0]):
        cell = starts[i]
        distance[cell] = 0.0
        low = min(low, cell)
        high = max(high, cell + 1)
        if used == capacity:
            return -1, low, high
        e_cell[used] = cell
        e_diagonals[used] = 0
        e_length[used] = 0.0
        e_came[used] = -1
        e_next[used] = head[0]
        head[0] = used
        used += 1
    spare = -1  # entries given back
    live = used
    taken = 0
    level = 0
    while live > 0:
        slot = level % lists
        if groups > 0 and level % 8 == 0:
            while settled < groups:
                nearest = np.inf
                for i in range(first[settled], first[settled + 1]):
                    nearest = min(nearest, distance[places[i]])
                if nearest >= level:
                    break
                settled += 1
            if settled == groups:
                break
        entry = head[slot]
        head[slot] = -1
        while entry >= 0:  # every move is 1 or longer, so none leads back into this list
            now = entry
            entry = e_next[now]
            cell = e_cell[now]
            length = e_length[now]
            diagonal = e_diagonals[now]
            came = e_came[now]
            e_next[now] = spare
            spare = now
            live -= 1
            if distance[cell] != length:
                continue  # reached by a shorter way since
            taken += 1
            straight = int(length - diagonal * SQRT2 + 0.5)
            bits = flat[cell]
            if came >= 4 and only[cell] & (1 << came):
                # The diagonal itself and its two parts: NE is E and N, and so on.
                bits &= (1 << came) | (1 << (came - 4)) | (1 << ((came - 3) % 4))
            for k in range(8):
                if bits & (1 << k) == 0:
                    continue
                more = diagonal + (1 if k >= 4 else 0)
                across = more * SQRT2
                along = straight + (1.0 if k < 4 else 0.0)
                step = DROW[k] * cols + DCOL[k]
                other = cell + step
                reached = along + across
                if reached >= distance[other]:
                    continue
                distance[other] = reached
                ended = False
                if k < 4:
                    run = int(runs[k, other])
                    ended = run < 0
                    for _ in range(abs(run) - 1):
                        along += 1.0
                        other += step
                        reached = along + across
                        if reached >= distance[other]:
                            ended = True
                            break
                        distance[other] = reached
                low = min(low, other)
                high = max(high, other + 1)
                if ended:
                    continue
                if spare >= 0:
                    new = spare
                    spare = e_next[new]
                elif used < capacity:
                    new = used
                    used += 1
                else:
                    return -1, low, high
                e_cell[new] = other
                e_diagonals[new] = more
                e_length[new] = reached
                e_came[new] = k
                to = int(reached) % lists
                e_next[new] = head[to]
                head[to] = new
                live += 1
        level += 1
    return taken, low, high
