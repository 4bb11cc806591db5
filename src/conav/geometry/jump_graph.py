"""Path lengths from a few cells to groups of places, by the corners of a ground alone.

`distance_field` writes the length of every cell, although only a few are asked for. Here straight
runs and diagonals are followed without writing: from a cell they lead to the next cells from which
a search may have to turn, and to the places they pass. These cells, corners mostly, are the nodes
of a graph, as in jump point search with stored jumps [Harabor2011] [Harabor2019]. What was found
from a node is kept, so one graph serves many searches over the same ground and places; of an office
of 200,000 cells about 1,300 are nodes.

Why lengths are exact. A search of `distance_field` reaches every cell from its start, or from a
cell that went through its queue, by a straight run or by a diagonal and a straight run, with
nothing but natural successors on the way. Cells that went through its queue after a straight move,
or after a diagonal one with other than natural successors, hand on in all directions: they are
nodes. All its other queued cells lie on diagonals, which are followed here at once.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import SQRT2
from conav.geometry.ground import Ground
from conav.geometry.jumps import MORE_EDGES, MORE_NODES, look_around, node_at

FIRST_ROOM = 1024
"""There is room for so many nodes at first, and for eight times as many edges and hits."""


class JumpGraph:
    """The nodes found so far over a ground, and the places that each sees along runs.

    Group j is `places[first[j]:first[j + 1]]`, flat cells, and not empty. The graph is that of the
    moves of now; once moves are added it must not be used any more.
    """

    def __init__(self, ground: Ground, first: NDArray[np.int64], places: NDArray[np.int64]) -> None:
        self._ground = ground
        self._first = first
        self._places = places
        rows, cols = ground.moves.shape
        groups = len(first) - 1
        group = np.repeat(np.arange(groups, dtype=np.int32), np.diff(first))
        # Places by row, then by column: where in it they lie, their group, and which they are.
        self._on_line = np.empty((2 * len(places), 3), dtype=np.int32)
        self._line_first = np.zeros(rows + cols + 1, dtype=np.int64)
        _sort_places(places, group, rows, cols, self._line_first, self._on_line)
        self._node_of = np.full(rows * cols, -1, dtype=np.int32)
        room = FIRST_ROOM
        self._nodes = np.empty((room, 5), dtype=np.int32)  # cell, edges from, to, hits from, to
        self._edges = np.empty((8 * room, 3), dtype=np.int32)  # node, straight moves, diagonal
        self._hits = np.empty((8 * room, 4), dtype=np.int32)  # group, straight, diagonal, place
        self._used = np.zeros(3, dtype=np.int64)  # nodes, edges, hits
        self._best = np.empty((groups, 3), dtype=np.int32)  # straight, diagonal, place
        self._least = np.full(groups, np.inf)
        self._seen = np.empty(groups, dtype=np.int32)
        lists = 1 << (2 * (rows + cols)).bit_length()  # longer than any edge, for `&` as modulo
        self._head = np.full(lists, -1, dtype=np.int32)

    def lengths(self, starts: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """From each start the path length to each group, and its nearest place.

        Both (n_starts, n_groups). Lengths [cells] are to the nearest place of a group, inf where no
        path leads; of equally near places it is the first, as where there is none. They are those
        of `fill_distances`, float by float.
        """
        shape = (len(starts), len(self._first) - 1)
        costs = np.empty(shape)
        nearest = np.empty(shape, dtype=np.int64)
        self._search(starts, -1, costs, nearest)
        return costs, nearest

    def length(self, start: int, group: int) -> float:
        """The path length from a cell to one group."""
        costs = np.empty((1, len(self._first) - 1))
        nearest = np.empty((1, len(self._first) - 1), dtype=np.int64)
        self._search(np.array([start]), group, costs, nearest)
        return float(costs[0, group])

    @property
    def nodes(self) -> int:
        """How many nodes were found so far."""
        return int(self._used[0])

    def _search(
        self,
        starts: NDArray[np.int64],
        group: int,
        costs: NDArray[np.float64],
        nearest: NDArray[np.int64],
    ) -> None:
        done = 0
        while True:
            work = np.empty((len(self._nodes), 4), dtype=np.int32)
            length = np.empty(len(self._nodes))
            lack, done = _search_all(
                self._ground.moves,
                self._ground.only,
                self._ground.runs,
                starts,
                done,
                group,
                self._first,
                self._places,
                self._line_first,
                self._on_line,
                self._node_of,
                self._nodes,
                self._edges,
                self._hits,
                self._used,
                self._best,
                self._least,
                self._seen,
                self._head,
                work,
                length,
                costs,
                nearest,
            )
            if lack == 0:
                return
            if lack == MORE_NODES:
                self._nodes = _doubled(self._nodes)
            elif lack == MORE_EDGES:
                self._edges = _doubled(self._edges)
            else:
                self._hits = _doubled(self._hits)


def _doubled(array: NDArray[np.int32]) -> NDArray[np.int32]:
    return np.concatenate([array, np.empty_like(array)])


@kernel
def _sort_places(
    places: NDArray[np.int64],
    group: NDArray[np.int32],
    rows: int,
    cols: int,
    line_first: NDArray[np.int64],
    on_line: NDArray[np.int32],
) -> None:
    """Write places in the order of rows, then in that of columns, both sorted within."""
    count = places.shape[0]
    for i in range(count):
        line_first[places[i] // cols + 1] += 1
        line_first[rows + places[i] % cols + 1] += 1
    for line in range(rows + cols):
        line_first[line + 1] += line_first[line]
    # Sorted by column first, they come into each row in that order, and the other way round.
    following = line_first.copy()
    by_col = np.empty(count, dtype=np.int64)
    for i in range(count):
        c = rows + places[i] % cols
        by_col[following[c] - count] = i
        following[c] += 1
    for j in range(count):
        i = by_col[j]
        r = places[i] // cols
        on_line[following[r], 0] = places[i] % cols
        on_line[following[r], 1] = group[i]
        on_line[following[r], 2] = i
        following[r] += 1
    following[:] = line_first
    for j in range(count):
        i = on_line[j, 2]
        c = rows + places[i] % cols
        on_line[following[c], 0] = places[i] // cols
        on_line[following[c], 1] = group[i]
        on_line[following[c], 2] = i
        following[c] += 1


@kernel
def _search(
    moves: NDArray[np.uint8],
    only: NDArray[np.uint8],
    runs: Any,  # (4, rows * cols) of a signed type
    start: int,
    group: int,
    first: NDArray[np.int64],
    places: NDArray[np.int64],
    line_first: NDArray[np.int64],
    on_line: NDArray[np.int32],
    node_of: NDArray[np.int32],
    nodes: NDArray[np.int32],
    edges: NDArray[np.int32],
    hits: NDArray[np.int32],
    used: NDArray[np.int64],
    best: NDArray[np.int32],
    least: NDArray[np.float64],
    seen: NDArray[np.int32],
    head: NDArray[np.int32],
    work: NDArray[np.int32],
    length: NDArray[np.float64],
    costs: NDArray[np.float64],
    nearest: NDArray[np.int64],
) -> int:
    """0 when the costs from `start` are written, or what there is too little room for.

    It ends early, when all costs are final, or with `group` not below 0 that of this group. `work`
    has for each node the straight and diagonal moves to it, and the nodes after and before it in
    its list; lists hold the nodes of one length, rounded down.
    """
    groups = first.shape[0] - 1
    modulo = head.shape[0] - 1
    head[:] = -1
    for j in range(groups):
        costs[j] = np.inf
        nearest[j] = first[j]
    begin = node_at(start, node_of, nodes, used)
    if begin < 0:
        return MORE_NODES
    known = used[0]
    for i in range(known):
        length[i] = np.inf
    length[begin] = 0.0
    work[begin, 0] = 0
    work[begin, 1] = 0
    work[begin, 2] = -1
    work[begin, 3] = -1
    head[0] = begin
    live = 1
    level = 0
    settled = 0 if group < 0 else group  # groups before this one have their costs
    last = groups if group < 0 else group + 1
    while live > 0:
        while settled < last and costs[settled] < level:
            settled += 1
        if settled == last:
            break
        slot = level & modulo
        node = int(head[slot])
        head[slot] = -1
        while node >= 0:  # no edge is shorter than 1, so none leads back into this list
            following = int(work[node, 2])
            live -= 1
            if nodes[node, 1] < 0:
                lack = look_around(
                    moves,
                    only,
                    runs,
                    node,
                    line_first,
                    on_line,
                    node_of,
                    nodes,
                    edges,
                    hits,
                    used,
                    best,
                    least,
                    seen,
                )
                if lack < 0:
                    return lack
                for i in range(known, used[0]):
                    length[i] = np.inf
                known = used[0]
            straight = work[node, 0]
            diagonal = work[node, 1]
            for i in range(nodes[node, 3], nodes[node, 4]):
                j = hits[i, 0]
                reached = (straight + hits[i, 1]) + (diagonal + hits[i, 2]) * SQRT2
                if reached < costs[j] or (reached == costs[j] and hits[i, 3] < nearest[j]):
                    costs[j] = reached
                    nearest[j] = hits[i, 3]
            for i in range(nodes[node, 1], nodes[node, 2]):
                other = edges[i, 0]
                along = straight + edges[i, 1]
                more = diagonal + edges[i, 2]
                reached = along + more * SQRT2
                before = length[other]
                if reached >= before:
                    continue
                if before < np.inf:  # out of the list it is in
                    live -= 1
                    after = work[other, 2]
                    if work[other, 3] >= 0:
                        work[work[other, 3], 2] = after
                    else:
                        head[int(before) & modulo] = after
                    if after >= 0:
                        work[after, 3] = work[other, 3]
                length[other] = reached
                work[other, 0] = along
                work[other, 1] = more
                to = int(reached) & modulo
                work[other, 2] = head[to]
                work[other, 3] = -1
                if head[to] >= 0:
                    work[head[to], 3] = other
                head[to] = other
                live += 1
            node = following
        level += 1
    for j in range(groups):
        nearest[j] = places[nearest[j]]
    return 0


@kernel
def _search_all(
    moves: NDArray[np.uint8],
    only: NDArray[np.uint8],
    runs: Any,  # (4, rows * cols) of a signed type
    starts: NDArray[np.int64],
    done: int,
    group: int,
    first: NDArray[np.int64],
    places: NDArray[np.int64],
    line_first: NDArray[np.int64],
    on_line: NDArray[np.int32],
    node_of: NDArray[np.int32],
    nodes: NDArray[np.int32],
    edges: NDArray[np.int32],
    hits: NDArray[np.int32],
    used: NDArray[np.int64],
    best: NDArray[np.int32],
    least: NDArray[np.float64],
    seen: NDArray[np.int32],
    head: NDArray[np.int32],
    work: NDArray[np.int32],
    length: NDArray[np.float64],
    costs: NDArray[np.float64],
    nearest: NDArray[np.int64],
) -> tuple[int, int]:
    """0 when all starts after the first `done` are dealt with, or what there is too little room
    for; and how many starts are done."""
    for i in range(done, starts.shape[0]):
        lack = _search(
            moves,
            only,
            runs,
            starts[i],
            group,
            first,
            places,
            line_first,
            on_line,
            node_of,
            nodes,
            edges,
            hits,
            used,
            best,
            least,
            seen,
            head,
            work,
            length,
            costs[i],
            nearest[i],
        )
        if lack < 0:
            return lack, i
    return 0, starts.shape[0]
