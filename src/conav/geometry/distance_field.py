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
    """This thread's working space for one field of `size` cells (the last size is kept)."""
    buffer: NDArray[np.float64] | None = getattr(_spaces, "buffer", None)
    if buffer is None or len(buffer) != size:
        buffer = np.empty(size)
        _spaces.buffer = buffer
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


class Ground:
    """Moves, and for each cell what may be left out after each move that reaches it.

    `moves` (rows, cols) has bit k where the move in direction k is possible, and then so is the way
    back. `update` follows moves that are added in few cells; none may be taken away.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        self.moves = np.zeros(shape, dtype=np.uint8)
        self.only = np.full(shape[0] * shape[1], 255, dtype=np.uint8)  # as `_mark` says
        self.added: list[NDArray[np.int64]] = []  # cells that got moves, one array an update

    def copy(self) -> "Ground":
        """An independent ground with the same moves."""
        other = object.__new__(Ground)
        other.moves = self.moves.copy()
        other.only = self.only.copy()
        other.added = []
        return other

    def update(self, moves: NDArray[np.uint8]) -> None:
        """Take over these moves."""
        changed = np.flatnonzero(moves != self.moves)
        if len(changed):
            self.moves.reshape(-1)[changed] = moves.reshape(-1)[changed]
            _mark(self.moves, changed, self.only)
            self.added.append(changed)


class GrowingField:
    """Path lengths from one cell over a ground that grows; brought up to date when asked for."""

    def __init__(self, ground: Ground, start: int) -> None:
        self._ground = ground
        self._start = start
        self._updates = len(ground.added)
        self._diagonals = np.empty(ground.moves.size, dtype=np.int32)
        self._distance = np.empty(ground.moves.size)
        self._begin()

    @staticmethod
    def bytes_of(ground: Ground) -> int:
        """The size of a field over a ground."""
        return 12 * ground.moves.size

    @property
    def distance(self) -> NDArray[np.float64]:
        """The lengths (rows * cols,) as `fill_distances` makes them."""
        self.follow()
        return self._distance

    def follow(self) -> None:
        """Take account of the moves added since the last time."""
        added = self._ground.added[self._updates :]
        if added:
            self._updates += len(added)
            seeds = added[0] if len(added) == 1 else np.concatenate(added)
            if not self._spread(seeds):
                self._begin()

    def _begin(self) -> None:
        done = False
        while not done:
            self._distance.fill(np.inf)
            self._distance[self._start] = 0.0
            self._diagonals[self._start] = 0
            done = self._spread(np.array([self._start], dtype=np.int64))

    def _spread(self, seeds: NDArray[np.int64]) -> bool:
        groups = (_NO_GROUPS, _NO_PLACES)
        return _spread(self._ground, seeds, self._distance, self._diagonals, *groups) >= 0


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
    while taken < 0:
        distance.fill(np.inf)
        distance[starts] = 0.0
        taken = _spread(ground, starts, distance, None, first, places)
    return taken


def _spread(
    ground: Ground,
    seeds: NDArray[np.int64],
    distance: NDArray[np.float64],
    diagonals: NDArray[np.int32] | None,
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

    Of several shortest paths it is the one whose last move has the lowest direction, then the last
    but one, and so on.
    """
    distance = field_buffer(ground.moves.size)
    end = np.array([goal], dtype=np.int64)
    fill_distances(ground, np.array([start], dtype=np.int64), distance, _ONE_GROUP, end)
    if not np.isfinite(distance[goal]):
        return np.empty(0, dtype=np.int8), 0
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
        for k in range(8):
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
def _mark(moves: NDArray[np.uint8], changed: NDArray[np.int64], only: NDArray[np.uint8]) -> None:
    """Set bit k of `only` around changed cells: after a move k nothing but the natural follows.

    Natural is straight on, and after a diagonal move its two straight parts too.
    """
    rows, cols = moves.shape
    done = np.zeros(only.shape[0], dtype=np.uint8)
    for i in range(changed.shape[0]):
        row = changed[i] // cols
        col = changed[i] % cols
        for r in range(max(row - 1, 0), min(row + 1, rows - 1) + 1):
            for c in range(max(col - 1, 0), min(col + 1, cols - 1) + 1):
                cell = r * cols + c
                if done[cell] == 1:
                    continue
                done[cell] = 1
                here = moves[r, c]
                marks = 0
                for k in range(8):
                    # Moves come and go, so where none leads back none led here.
                    if here & (1 << (k ^ 2)) == 0:
                        marks |= 1 << k
                        continue
                    if k < 4:
                        left = _side_is_clear(moves, r, c, k, (k + 1) % 4, 4 + k, 4 + (k + 1) % 4)
                        right = _side_is_clear(
                            moves, r, c, k, (k + 3) % 4, 4 + (k + 3) % 4, 4 + (k + 2) % 4
                        )
                        clear = left and right
                    else:
                        clear = _diagonal_is_clear(moves, r, c, k)
                    if clear:
                        marks |= 1 << k
                only[cell] = marks


@kernel
def _side_is_clear(
    moves: NDArray[np.uint8], r: int, c: int, k: int, side: int, fore: int, back: int
) -> bool:
    """Whether what lies to one side of a cell reached by a straight move k may be left out.

    `side` is the direction of that side, `fore` and `back` are the diagonals to both sides of it.
    """
    here = moves[r, c]
    r0 = r - DROW[k]
    c0 = c - DCOL[k]
    before = moves[r0, c0]
    if (
        here & (1 << side)
        and not before & (1 << fore)
        # Along the row is preferred as the last move: first aside, then along.
        and not (
            k % 2 == 0
            and before & (1 << side)
            and moves[r0 + DROW[side], c0 + DCOL[side]] & (1 << k)
        )
    ):
        return False
    if here & (1 << fore):
        r1 = r + DROW[side]
        c1 = c + DCOL[side]
        if not (before & (1 << fore) and moves[r1, c1] & (1 << k)):
            return False
    return not (here & (1 << back) and not before & (1 << side))


@kernel
def _diagonal_is_clear(moves: NDArray[np.uint8], r: int, c: int, k: int) -> bool:
    """Whether all but the natural may be left out at a cell reached by a diagonal move k."""
    one = k - 4
    other = (one + 1) % 4
    against_one = (one + 2) % 4
    against_other = (other + 2) % 4
    here = moves[r, c]
    before = moves[r - DROW[k], c - DCOL[k]]
    if here & (1 << against_one) and not before & (1 << other):
        return False
    if here & (1 << against_other) and not before & (1 << one):
        return False
    # The diagonals to both sides: around the cells beside.
    if here & (1 << (4 + other)) and not (
        before & (1 << other) and moves[r + DROW[against_one], c + DCOL[against_one]] & (1 << other)
    ):
        return False
    return not (
        here & (1 << (4 + against_other))
        and not (
            before & (1 << one)
            and moves[r + DROW[against_other], c + DCOL[against_other]] & (1 << one)
        )
    )


@kernel
def _spread_out(
    moves: NDArray[np.uint8],
    only: NDArray[np.uint8],
    seeds: NDArray[np.int64],
    distance: NDArray[np.float64],
    diagonals: Any,  # (rows * cols,) int32, or None: compiled apart, which is faster
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
    to date, or None where all seeds are at 0 and nobody wants to know.
    """
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    lists = head.shape[0]
    capacity = e_cell.shape[0]
    head[:] = -1
    steps = np.empty(8, dtype=np.int64)
    for k in range(8):
        steps[k] = DROW[k] * cols + DCOL[k]
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
                if reached >= distance[other]:
                    continue
                distance[other] = reached
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
                        if reached >= distance[other]:
                            ended = True
                            break
                        distance[other] = reached
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
    return taken
