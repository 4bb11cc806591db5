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

    `fill_distances` clears only what it wrote there the last time, which for a short search is much
    less than all; nobody else may write to it.
    """
    buffer: NDArray[np.float64] | None = getattr(_spaces, "buffer", None)
    if buffer is None or len(buffer) != size:
        buffer = np.full(size, np.inf)
        _spaces.buffer = buffer
        _spaces.touched = np.zeros(size + 1, dtype=np.int32)  # cells written, [size] how many
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
        first, places = NO_GROUPS, NO_PLACES
    taken = -1
    touched = _spaces.touched if distance is getattr(_spaces, "buffer", None) else None
    while taken < 0:
        if touched is None:
            distance.fill(np.inf)
        else:
            _clear(distance, touched)
            _touch(touched, starts)
        distance[starts] = 0.0
        taken = spread(ground, starts, distance, None, touched, first, places)
    return taken


def spread(
    ground: Ground,
    seeds: NDArray[np.int64],
    distance: NDArray[np.float64],
    diagonals: NDArray[np.int32] | None,
    touched: NDArray[np.int32] | None,
    first: NDArray[np.int64],
    places: NDArray[np.int64],
) -> int:
    """The number of cells taken from the queue to lower `distance` from `seeds` on.

    It is -1, and `distance` half done, where the queue was too short; the next one is longer.
    """
    space = _field_space(ground.moves.shape)
    taken = _spread_out(
        ground.moves,
        ground.only,
        seeds,
        distance,
        diagonals,
        touched,
        first,
        places,
        space.cell,
        space.diagonals,
        space.length,
        space.came,
        space.following,
        space.head,
    )
    if taken < 0:
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
NO_GROUPS = np.zeros(1, dtype=np.int64)
NO_PLACES = np.empty(0, dtype=np.int64)


@kernel
def _clear(distance: NDArray[np.float64], touched: NDArray[np.int32]) -> None:
    """Set the cells that were touched to inf, and forget them."""
    size = distance.shape[0]
    count = touched[size]
    if count > size // 4:
        distance[:] = np.inf
    else:
        for i in range(count):
            distance[touched[i]] = np.inf
    touched[size] = 0


@kernel
def _touch(touched: NDArray[np.int32], cells: NDArray[np.int64]) -> None:
    """Add cells to those touched."""
    size = touched.shape[0] - 1
    for i in range(min(cells.shape[0], size)):
        touched[i] = cells[i]
    touched[size] = min(cells.shape[0], size)


@kernel
def nearest_of_groups(
    distance: NDArray[np.float64],
    first: NDArray[np.int64],
    places: NDArray[np.int64],
    costs: NDArray[np.float64],
    nearest: NDArray[np.int64],
) -> None:
    """Write the least distance among each group's places, and the first such place.

    Group j is `places[first[j]:first[j + 1]]`, not empty; `costs` and `nearest` are (groups,).
    """
    for j in range(first.shape[0] - 1):
        nearest[j] = places[first[j]]
        costs[j] = distance[nearest[j]]
        for i in range(first[j] + 1, first[j + 1]):
            length = distance[places[i]]
            if length < costs[j]:
                costs[j] = length
                nearest[j] = places[i]


@kernel
def _spread_out(
    moves: NDArray[np.uint8],
    only: NDArray[np.uint8],
    seeds: NDArray[np.int64],
    distance: NDArray[np.float64],
    # Compiled apart for None, which is faster.
    diagonals: Any,  # (rows * cols,) int32 or None
    touched: Any,  # (rows * cols + 1,) int32 or None
    first: NDArray[np.int64],
    places: NDArray[np.int64],
    e_cell: NDArray[np.int32],
    e_diagonals: NDArray[np.int32],
    e_length: NDArray[np.float64],
    e_came: NDArray[np.int8],
    e_next: NDArray[np.int32],
    head: NDArray[np.int32],
) -> int:
    """How many entries were taken from the queue, -1 where it was too short.

    Seeds that are inf do not count. `diagonals` are the diagonal moves among the lengths, kept up
    to date, or None where all seeds are at 0 and nobody wants to know; to `touched` the cells are
    added that were inf before.
    """
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    lists = head.shape[0]
    capacity = e_cell.shape[0]
    head[:] = -1
    steps = np.empty(8, dtype=np.int64)
    for k in range(8):
        steps[k] = DROW[k] * cols + DCOL[k]
    size = flat.shape[0]
    written = 0
    if touched is not None:
        written = touched[size]
    groups = first.shape[0] - 1
    settled = 0  # groups before this one have their nearest cell
    used = 0
    lowest = np.inf
    for i in range(seeds.shape[0]):
        length = distance[seeds[i]]
        if length == np.inf:
            continue
        if used == capacity:
            return -1
        lowest = min(lowest, length)
        e_cell[used] = seeds[i]
        e_diagonals[used] = 0
        if diagonals is not None:
            e_diagonals[used] = diagonals[seeds[i]]
        e_length[used] = length
        e_came[used] = -1
        to = int(length) % lists
        e_next[used] = head[to]
        head[to] = used
        used += 1
    spare = -1  # entries given back
    live = used
    taken = 0
    level = int(lowest) if live > 0 else 0
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
        while entry >= 0:
            now = entry
            entry = e_next[now]
            cell = e_cell[now]
            length = e_length[now]
            if int(length) > level:  # a seed whose turn comes when this list is met again
                e_next[now] = head[slot]
                head[slot] = now
                continue
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
                along = straight + (1 if k < 4 else 0)
                step = steps[k]
                other = cell + step
                reached = along + across
                before = distance[other]
                if reached >= before:
                    continue
                distance[other] = reached
                if touched is not None and before == np.inf:
                    touched[written] = other
                    written += 1
                if diagonals is not None:
                    diagonals[other] = more
                if k < 4:
                    ended = False
                    while only[other] & (1 << k):
                        if flat[other] & (1 << k) == 0:
                            ended = True
                            break
                        along += 1
                        other += step
                        reached = along + across
                        before = distance[other]
                        if reached >= before:
                            ended = True
                            break
                        distance[other] = reached
                        if touched is not None and before == np.inf:
                            touched[written] = other
                            written += 1
                        if diagonals is not None:
                            diagonals[other] = more
                    if ended:
                        continue
                if spare >= 0:
                    new = spare
                    spare = e_next[new]
                elif used < capacity:
                    new = used
                    used += 1
                else:
                    if touched is not None:
                        touched[size] = written
                    return -1
                e_cell[new] = other
                e_diagonals[new] = more
                e_length[new] = reached
                e_came[new] = k
                to = int(reached) % lists
                e_next[new] = head[to]
                head[to] = new
                live += 1
        level += 1
    if touched is not None:
        touched[size] = written
    return taken
