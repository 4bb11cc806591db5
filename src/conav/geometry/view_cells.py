"""The cells into which the views of several viewpoints part a floor, exactly.

A cell is a piece of floor that no window runs through: each viewpoint sees all of it or none of it
with some width. Cells come from the arrangement of all windows as chords; where rings hang
together by no chord, edges of the triangulation are added as chords that nobody sees, so that
every cell has one border, without holes. The border is walked, floor on the left, over nodes:
vertices with chords, places where chords end on walls, and crossings of chords. Which chord comes
next at a node, which crossing comes first on a chord and which points coincide are exact signs of
given points (`conav.geometry.chords`); computed coordinates decide nothing.

Unions of cells answer what regions are hidden from a team, and which of them hang together.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.errors import InputError
from conav.geometry.chords import (
    Chords,
    find_crossings,
    find_root,
    order_on_chord,
    order_on_wall,
    side_of_line,
    turn_between,
)
from conav.geometry.predicates import direction_turn
from conav.geometry.triangulation import Triangulation
from conav.geometry.visibility import VisibilityPolygon, WINDOW, window_ends

Ints = NDArray[np.int32]
Longs = NDArray[np.int64]
Floats = NDArray[np.float64]

MOST_VIEWS = 62
NO_CELL = -1


class ViewCells(NamedTuple):
    """The cells of several views. Bit i of a number stands for view i.

    Pieces are the parts of chords between nodes, each between two cells. Half-edge 2 p runs along
    piece p, its left cell `left[p]`; 2 p + 1 runs back. Half-edges from 2 pieces on run along rings.
    """

    count: int
    seen_by: Longs  # (count,) the views each cell is part of
    areas: Floats  # (count,) [m^2], rounded
    left: Ints  # (pieces,) the cell on the left
    right: Ints  # (pieces,) the cell on the right
    changes: Longs  # (pieces,) the views that see one side only; 0 for an added chord
    cells: Ints  # (half-edges,) the cell of each half-edge
    following: Ints  # (half-edges,) the next one on the cell's border
    nodes: Ints  # (half-edges,) the node where it starts
    node_points: Floats  # (nodes, 2) [m], rounded
    node_places: Ints  # (nodes,) 2 v at vertex v, 2 w + 1 on wall w, -1 off the rings


def view_cells(floor: Triangulation, views: Sequence[VisibilityPolygon]) -> ViewCells:
    """The cells of the views, up to 62 visibility polygons on this floor.

    A viewpoint off the floor sees no cell. Raises `InputError` for more views.

    >>> from conav.geometry.triangulation import triangulate
    >>> from conav.geometry.visibility import visibility_polygon
    >>> corner = triangulate([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], [0, 6])
    >>> cells = view_cells(corner, [visibility_polygon(corner, *p) for p in [(2, 1), (1, 2)]])
    >>> sorted(zip(cells.seen_by.tolist(), cells.areas.tolist()))
    [(1, 1.0), (2, 1.0), (3, 1.0)]
    """
    if len(views) > MOST_VIEWS:
        raise InputError("views", f"are {len(views)}", f"give at most {MOST_VIEWS}")
    n = len(floor.vertices)
    viewpoints = np.array([view.viewpoint for view in views]).reshape(-1, 2)
    points = np.concatenate((floor.vertices, viewpoints))
    size = sum(len(view.walls) for view in views)
    columns = np.empty((5, size), np.int32)
    owners = np.empty(size, np.int64)
    # For each view a half-edge of its border that it sees: a wall that starts or ends at a vertex.
    anchors = np.full((len(views), 2), -1, np.int32)
    count = 0
    for i, view in enumerate(views):
        count = _add_windows(
            floor.vertices, *view.viewpoint, view.vertices, view.hit_walls, view.walls,
            n + i, np.int64(1) << i, columns, owners, count, anchors[i],
        )  # fmt: skip
    chords = Chords(*columns[:, :count].copy(), owners[:count].copy())
    chords = Chords(*_without_copies(points, chords))
    *chord_columns, pairs = _connect_rings(
        points, floor.wall_ends, floor.rings, floor.triangles.reshape(-1),
        floor.twins.reshape(-1), chords,
    )  # fmt: skip
    chords = Chords(*chord_columns)
    if len(chords.starts) == 0:
        return _one_cell(floor, views)
    return ViewCells(
        *_arrange(points, floor.wall_ends, floor.rings, n, chords, pairs, anchors)
    )


def join_cells(cells: ViewCells, chosen: NDArray[np.bool_]) -> Ints:
    """A label per cell, shape (count,): chosen cells that hang together share one, others have -1.

    `chosen` has shape (count,). Labels count from 0 in the order of each one's first cell. Cells
    hang together along pieces; those that only meet at a point do not.
    """
    return _join(cells.left, cells.right, chosen)


def shadows(cells: ViewCells) -> Ints:
    """A label per cell, shape (count,): the shadow, a region no viewpoint sees, it is part of; or -1.

    Shadows count from 0 in the order of their first cells. See `conav.geometry.hidden_regions` for
    what is exact about them.
    """
    return join_cells(cells, cells.seen_by == 0)


def cell_border(floor: Triangulation, cells: ViewCells, cell: int) -> Floats:
    """The border of a cell, counter-clockwise, shape (k, 2) [m]; it may touch itself."""
    if len(cells.left) == 0:
        return floor.vertices.copy()
    border: list[Floats] = []
    begin = int(np.flatnonzero(cells.cells == cell)[0])
    h = begin
    while True:
        border.append(cells.node_points[cells.nodes[h]])
        after = int(cells.following[h])
        if h >= 2 * len(cells.left):
            # Along the ring: the vertices without chords.
            node, end_node = int(cells.nodes[h]), int(cells.nodes[after])
            end = int(cells.node_places[end_node])
            v = int(cells.node_places[node]) // 2
            on_one_wall = _on_one_wall(cells.node_places, node, end_node)
            while not on_one_wall:
                v = int(floor.wall_ends[v])
                if end == 2 * v:
                    break
                border.append(floor.vertices[v])
                on_one_wall = end == 2 * v + 1
        h = after
        if h == begin:
            return np.array(border)


def _one_cell(floor: Triangulation, views: Sequence[VisibilityPolygon]) -> ViewCells:
    """All of a floor with one ring of which every viewpoint sees all or nothing."""
    seen_by = sum(1 << i for i, view in enumerate(views) if len(view.walls) > 0)
    x, y = (floor.vertices - floor.vertices[0]).T
    area = float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2.0
    none = np.empty(0, np.int32)
    return ViewCells(
        1, np.array([seen_by], np.int64), np.array([area]), none, none, np.empty(0, np.int64),
        none, none, none, np.empty((0, 2)), none,
    )  # fmt: skip


@kernel
def _add_windows(
    vertices: Floats, x: float, y: float, corner_vertices: Ints, hit_walls: Ints, walls: Ints,
    row: int, view: int, columns: Ints, owners: Longs, count: int, anchor: Ints,
) -> int:  # fmt: skip
    """The new count of chords with the windows of a view; and its anchor."""
    k = walls.shape[0]
    sides = np.empty(k, np.int32)
    near = np.empty(k, np.int32)
    far = np.empty(k, np.int32)
    outward = np.empty(k, np.bool_)
    windows = window_ends(vertices, x, y, corner_vertices, walls, sides, near, far, outward)
    for w in range(windows):
        columns[0, count] = row
        columns[1, count] = corner_vertices[near[w]]
        columns[2, count] = corner_vertices[near[w]]
        columns[3, count] = corner_vertices[far[w]]
        columns[4, count] = hit_walls[far[w]]
        owners[count] = view
        count += 1
    for i in range(k):
        # The ring on from a vertex, or back from one. Every view has such a side: beside a window
        # there is a wall at its near vertex.
        if walls[i] != WINDOW:
            j = i + 1 if i + 1 < k else 0
            if corner_vertices[i] >= 0:
                anchor[0] = corner_vertices[i]
                break
            if corner_vertices[j] >= 0:
                anchor[1] = corner_vertices[j]
    return count


@kernel
def _without_copies(points: Floats, chords: Chords) -> tuple[Ints, Ints, Ints, Ints, Ints, Longs]:
    """The columns of the chords, those that are the same piece of floor made one.

    Between its ends a chord meets neither vertex nor wall, so two that overlap are the same piece:
    they join the same vertices, or lead from one vertex along one line to one wall.
    """
    n = chords.starts.shape[0]
    key = np.empty((n, 2), np.int64)
    for i in range(n):
        a, b = chords.starts[i], chords.ends[i]
        key[i, 0] = min(a, b) if b >= 0 else a
        key[i, 1] = max(a, b) if b >= 0 else -1 - chords.walls[i]
    order = np.argsort(key[:, 0], kind="mergesort")
    kept = np.ones(n, np.bool_)
    views = chords.views.copy()
    for first in range(n):
        i = order[first]
        if not kept[i]:
            continue
        for second in range(first + 1, n):
            j = order[second]
            if key[j, 0] != key[i, 0]:
                break
            if not kept[j] or key[j, 1] != key[i, 1]:
                continue
            if chords.ends[i] < 0:
                side = side_of_line(points, chords.tails[i], chords.heads[i], chords.tails[j])
                if side != 0:
                    continue
            kept[j] = False
            views[i] ^= views[j]
    return (
        chords.tails[kept], chords.heads[kept], chords.starts[kept], chords.ends[kept],
        chords.walls[kept], views[kept],
    )  # fmt: skip


@kernel
def _connect_rings(
    points: Floats, wall_ends: Ints, rings: Ints, corners: Ints, twins: Ints, chords: Chords
) -> tuple[Ints, Ints, Ints, Ints, Ints, Longs, Ints]:
    """The columns of the chords, with sides of triangles where rings were apart; and crossings."""
    n = chords.starts.shape[0]
    pairs, count = find_crossings(points, wall_ends, chords, 0, np.empty((0, 2), np.int32), 0)
    parents = np.arange(rings[-1] + 1).astype(np.int32)
    for i in range(n):
        end = chords.ends[i] if chords.ends[i] >= 0 else chords.walls[i]
        one = find_root(parents, rings[chords.starts[i]])
        parents[one] = find_root(parents, rings[end])
    for p in range(count):
        one = find_root(parents, rings[chords.starts[pairs[p, 0]]])
        parents[one] = find_root(parents, rings[chords.starts[pairs[p, 1]]])
    added = np.empty((rings[-1], 2), np.int32)
    more = 0
    for h in range(corners.shape[0]):
        if twins[h] > h:
            a = corners[h]
            b = corners[twins[h]]
            one = find_root(parents, rings[a])
            other = find_root(parents, rings[b])
            if one != other:
                parents[one] = other
                added[more, 0] = a
                added[more, 1] = b
                more += 1
    tails = np.concatenate((chords.tails, added[:more, 0]))
    heads = np.concatenate((chords.heads, added[:more, 1]))
    starts = np.concatenate((chords.starts, added[:more, 0]))
    ends = np.concatenate((chords.ends, added[:more, 1]))
    walls = np.concatenate((chords.walls, np.full(more, -1, np.int32)))
    views = np.concatenate((chords.views, np.zeros(more, np.int64)))
    every = Chords(tails, heads, starts, ends, walls, views)
    pairs, count = find_crossings(points, wall_ends, every, n, pairs, count)
    return tails, heads, starts, ends, walls, views, pairs[:count].copy()


@kernel
def _join(left: Ints, right: Ints, chosen: NDArray[np.bool_]) -> Ints:
    n = chosen.shape[0]
    parents = np.arange(n).astype(np.int32)
    for p in range(left.shape[0]):
        a, b = left[p], right[p]
        if chosen[a] and chosen[b]:
            parents[find_root(parents, a)] = find_root(parents, b)
    labels = np.full(n, NO_CELL, np.int32)
    of_root = np.full(n, -1, np.int32)
    count = 0
    for cell in range(n):
        if chosen[cell]:
            root = find_root(parents, cell)
            if of_root[root] < 0:
                of_root[root] = count
                count += 1
            labels[cell] = of_root[root]
    return labels


@kernel
def _arrange(
    points: Floats, wall_ends: Ints, rings: Ints, n: int, chords: Chords, pairs: Ints, anchors: Ints
) -> tuple[int, Longs, Floats, Ints, Ints, Longs, Ints, Ints, Ints, Floats, Ints]:
    """The fields of `ViewCells`; at least one chord, and all rings hang together by chords."""
    crossings, crossing_starts, parents = _sort_crossings(points, chords, pairs)
    node_of_vertex, node_of_end, node_of_crossing, places, node_points = _number_nodes(
        points, wall_ends, n, chords, pairs, parents
    )
    # Pieces of chords.
    count = chords.starts.shape[0]
    most = count + crossings.shape[0]
    nodes = np.empty(2 * most + places.shape[0], np.int32)
    chord_of = np.empty(most, np.int32)
    pieces = 0
    for i in range(count):
        at = node_of_vertex[chords.starts[i]]
        for k in range(crossing_starts[i], crossing_starts[i + 1] + 1):
            if k < crossing_starts[i + 1]:
                to = node_of_crossing[find_root(parents, crossings[k])]
            else:
                to = node_of_end[i]
            if to != at:
                chord_of[pieces] = i
                nodes[2 * pieces] = at
                nodes[2 * pieces + 1] = to
                pieces += 1
                at = to
    # Stretches of rings.
    ring_nodes = np.argsort(places, kind="mergesort")
    ring_nodes = ring_nodes[np.searchsorted(places[ring_nodes], 0) :]
    total = 2 * pieces + ring_nodes.shape[0]
    out_of = np.full(places.shape[0], -1, np.int32)
    into = np.full(places.shape[0], -1, np.int32)
    following = np.full(total, -1, np.int32)
    first = 0
    for r in range(ring_nodes.shape[0]):
        node = ring_nodes[r]
        ring = rings[places[node] // 2]
        if rings[places[ring_nodes[first]] // 2] != ring:
            first = r
        nodes[2 * pieces + r] = node
        out_of[node] = 2 * pieces + r
        last = (
            r + 1 == ring_nodes.shape[0] or rings[places[ring_nodes[r + 1]] // 2] != ring
        )
        into[ring_nodes[first] if last else ring_nodes[r + 1]] = 2 * pieces + r
    _link(points, wall_ends, chords, chord_of, nodes, pieces, places, out_of, into, following)
    cells = np.full(total, NO_CELL, np.int32)
    areas = np.empty(total)
    number = 0
    for h in range(total):
        if cells[h] == NO_CELL:
            areas[number] = 0.0
            edge = h
            while cells[edge] == NO_CELL:
                cells[edge] = number
                areas[number] += _stretch_area(
                    points, wall_ends, node_points, places, nodes[edge], nodes[following[edge]],
                    edge >= 2 * pieces,
                )  # fmt: skip
                edge = following[edge]
            number += 1
    left = cells[: 2 * pieces : 2].copy()
    right = cells[1 : 2 * pieces : 2].copy()
    changes = chords.views[chord_of[:pieces]]
    seen_by = _spread(number, left, right, changes)
    # So far as differences to cell 0: each view sees the cell at its anchor.
    for i in range(anchors.shape[0]):
        v = max(anchors[i, 0], anchors[i, 1])
        if v < 0:
            continue
        node = node_of_vertex[v]
        if node >= 0:
            h = out_of[node] if anchors[i, 0] >= 0 else into[node]
        else:
            # On the stretch that passes the vertex: from the last node before it on its ring.
            r = np.searchsorted(places[ring_nodes], 2 * v) - 1
            if r < 0 or rings[places[ring_nodes[r]] // 2] != rings[v]:
                r += 1
                while (
                    r + 1 < ring_nodes.shape[0]
                    and rings[places[ring_nodes[r + 1]] // 2] == rings[v]
                ):
                    r += 1
            h = 2 * pieces + r
        bit = np.int64(1) << i
        if seen_by[cells[h]] & bit == 0:
            for cell in range(number):
                seen_by[cell] ^= bit
    return (
        number, seen_by, areas[:number].copy(), left, right, changes, cells, following,
        nodes[:total].copy(), node_points, places,
    )  # fmt: skip


@kernel
def _sort_crossings(points: Floats, chords: Chords, pairs: Ints) -> tuple[Ints, Ints, Ints]:
    """The crossings along each chord, where each chord's begin, and a forest of equal crossings."""
    count = chords.starts.shape[0]
    starts = np.zeros(count + 1, np.int32)
    for p in range(pairs.shape[0]):
        starts[pairs[p, 0] + 1] += 1
        starts[pairs[p, 1] + 1] += 1
    for i in range(count):
        starts[i + 1] += starts[i]
    filled = starts[:-1].copy()
    crossings = np.empty(2 * pairs.shape[0], np.int32)
    parents = np.arange(pairs.shape[0]).astype(np.int32)
    for p in range(pairs.shape[0]):
        for side in range(2):
            i = pairs[p, side]
            other = pairs[p, 1 - side]
            k = filled[i]
            filled[i] += 1
            while k > starts[i]:
                before = pairs[crossings[k - 1], 0] + pairs[crossings[k - 1], 1] - i
                order = order_on_chord(points, chords, i, before, other)
                if order == 0:
                    one = find_root(parents, p)
                    parents[one] = find_root(parents, crossings[k - 1])
                if order <= 0:
                    break
                crossings[k] = crossings[k - 1]
                k -= 1
            crossings[k] = p
    return crossings, starts, parents


@kernel
def _number_nodes(
    points: Floats, wall_ends: Ints, n: int, chords: Chords, pairs: Ints, parents: Ints
) -> tuple[Ints, Ints, Ints, Ints, Floats]:
    """The node of each vertex (or -1), chord's end and crossing; each node's place and point.

    Nodes on one wall are numbered in their order along it.
    """
    count = chords.starts.shape[0]
    node_of_vertex = np.full(n, -1, np.int32)
    node_of_end = np.empty(count, np.int32)
    node_of_crossing = np.full(pairs.shape[0], -1, np.int32)
    places = np.empty(2 * count + pairs.shape[0], np.int32)
    node_points = np.empty((2 * count + pairs.shape[0], 2))
    number = 0
    for i in range(count):
        for v in (chords.starts[i], chords.ends[i]):
            if v >= 0:
                if node_of_vertex[v] < 0:
                    node_of_vertex[v] = number
                    places[number] = 2 * v
                    node_points[number] = points[v]
                    number += 1
                if v == chords.ends[i]:
                    node_of_end[i] = node_of_vertex[v]
    order = np.argsort(chords.walls, kind="mergesort")
    begin = np.searchsorted(chords.walls[order], 0)
    for second in range(begin, count):
        i = order[second]
        wall = chords.walls[i]
        k = second
        while k > begin and chords.walls[order[k - 1]] == wall:
            if order_on_wall(points, wall_ends, chords, wall, order[k - 1], i) <= 0:
                break
            order[k] = order[k - 1]
            k -= 1
        order[k] = i
    for k in range(begin, count):
        i = order[k]
        wall = chords.walls[i]
        same = (
            k > begin
            and chords.walls[order[k - 1]] == wall
            and order_on_wall(points, wall_ends, chords, wall, order[k - 1], i) == 0
        )
        if same:
            node_of_end[i] = node_of_end[order[k - 1]]
            continue
        node_of_end[i] = number
        places[number] = 2 * wall + 1
        node_points[number] = _meeting(
            points, wall, wall_ends[wall], chords.tails[i], chords.heads[i]
        )
        number += 1
    for p in range(pairs.shape[0]):
        if find_root(parents, p) == p:
            i, j = pairs[p]
            node_of_crossing[p] = number
            places[number] = -1
            node_points[number] = _meeting(
                points, chords.tails[i], chords.heads[i], chords.tails[j], chords.heads[j]
            )
            number += 1
    return (
        node_of_vertex, node_of_end, node_of_crossing, places[:number].copy(),
        node_points[:number].copy(),
    )  # fmt: skip


@kernel
def _meeting(points: Floats, a: int, b: int, c: int, d: int) -> Floats:
    """Where the line from a to b meets that from c to d, rounded."""
    dx = points[d, 0] - points[c, 0]
    dy = points[d, 1] - points[c, 1]
    one = (points[a, 0] - points[c, 0]) * dy - (points[a, 1] - points[c, 1]) * dx
    two = (points[b, 0] - points[c, 0]) * dy - (points[b, 1] - points[c, 1]) * dx
    part = one / (one - two) if one != two else 0.5
    return points[a] + part * (points[b] - points[a])


@kernel
def _link(
    points: Floats, wall_ends: Ints, chords: Chords, chord_of: Ints, nodes: Ints, pieces: int,
    places: Ints, out_of: Ints, into: Ints, following: Ints,
) -> None:  # fmt: skip
    """Fills `following`: at each node the first half-edge clockwise from where one came."""
    starts = np.zeros(places.shape[0] + 1, np.int32)
    for h in range(2 * pieces):
        starts[nodes[h] + 1] += 1
    for node in range(places.shape[0]):
        starts[node + 1] += starts[node]
    filled = starts[:-1].copy()
    leaving = np.empty(2 * pieces, np.int32)
    for h in range(2 * pieces):
        leaving[filled[nodes[h]]] = h
        filled[nodes[h]] += 1
    for node in range(places.shape[0]):
        around = leaving[starts[node] : starts[node + 1]]
        place = places[node]
        if place >= 0:
            tail = place // 2
            head = wall_ends[tail]
        else:
            tail = chords.tails[chord_of[around[0] // 2]]
            head = chords.heads[chord_of[around[0] // 2]]
        if around.shape[0] > 1:
            _sort_around(points, chords, chord_of, around, tail, head, place < 0)
        for k in range(around.shape[0]):
            h = around[k]
            if k > 0:
                following[h ^ 1] = around[k - 1]
            elif place >= 0:
                following[h ^ 1] = out_of[node]
            else:
                following[h ^ 1] = around[-1]
        if place >= 0:
            following[into[node]] = around[-1]


@kernel
def _sort_around(
    points: Floats, chords: Chords, chord_of: Ints, around: Ints, tail: int, head: int,
    crossing: bool,
) -> None:  # fmt: skip
    """Sorts half-edges that leave a node counter-clockwise from the direction of tail to head.

    That is the wall on from a node of a ring, or the chord of the first half-edge at a crossing.
    """
    n = around.shape[0]
    signs = np.empty(n, np.int32)
    quarters = np.empty(n, np.int32)
    first = chord_of[around[0] // 2]
    for k in range(n):
        h = around[k]
        i = chord_of[h // 2]
        signs[k] = 1 if h % 2 == 0 else -1
        turn = signs[k] * direction_turn(points, tail, head, chords.tails[i], chords.heads[i])
        if turn == 0:
            # Straight back; or at a crossing the first chord itself, either way.
            ahead = crossing and i == first and signs[k] == 1
            quarters[k] = 0 if ahead else 2
        else:
            quarters[k] = 1 if turn > 0 else 3
    for k in range(1, n):
        h = around[k]
        quarter = quarters[k]
        sign = signs[k]
        m = k
        while m > 0:
            if quarters[m - 1] < quarter:
                break
            if quarters[m - 1] == quarter:
                turn = turn_between(points, chords, chord_of[around[m - 1] // 2], chord_of[h // 2])
                if signs[m - 1] * sign * turn >= 0:
                    break
            around[m] = around[m - 1]
            quarters[m] = quarters[m - 1]
            signs[m] = signs[m - 1]
            m -= 1
        around[m] = h
        quarters[m] = quarter
        signs[m] = sign


@kernel
def _stretch_area(
    points: Floats, wall_ends: Ints, node_points: Floats, places: Ints, node: int, after: int,
    on_ring: bool,
) -> float:  # fmt: skip
    """What a half-edge adds to its cell's area, about the first vertex."""
    ox, oy = points[0, 0], points[0, 1]
    ax = node_points[node, 0] - ox
    ay = node_points[node, 1] - oy
    area = 0.0
    if on_ring:
        end = places[after]
        v = places[node] // 2
        here = _on_one_wall(places, node, after)
        while not here:
            v = wall_ends[v]
            if end == 2 * v:
                break
            bx = points[v, 0] - ox
            by = points[v, 1] - oy
            area += ax * by - ay * bx
            ax = bx
            ay = by
            here = end == 2 * v + 1
    bx = node_points[after, 0] - ox
    by = node_points[after, 1] - oy
    return (area + ax * by - ay * bx) / 2.0


@kernel
def _on_one_wall(places: Ints, node: int, after: int) -> bool:
    """Whether the ring goes from a node to the one after along one wall, past no vertex."""
    place = places[node]
    if place % 2 == 0:
        return places[after] == place + 1
    # Nodes on one wall are numbered along it; else the ring comes around from behind.
    return places[after] == place and node < after


@kernel
def _spread(count: int, left: Ints, right: Ints, changes: Longs) -> Longs:
    """The views that see a cell but not cell 0, or the other way round, for every cell."""
    starts = np.zeros(count + 1, np.int32)
    for p in range(left.shape[0]):
        starts[left[p] + 1] += 1
        starts[right[p] + 1] += 1
    for cell in range(count):
        starts[cell + 1] += starts[cell]
    filled = starts[:-1].copy()
    beside = np.empty(2 * left.shape[0], np.int32)
    for p in range(left.shape[0]):
        beside[filled[left[p]]] = p
        filled[left[p]] += 1
        beside[filled[right[p]]] = p
        filled[right[p]] += 1
    seen_by = np.zeros(count, np.int64)
    reached = np.zeros(count, np.bool_)
    queue = np.empty(count, np.int32)
    reached[0] = True
    queue[0] = 0
    tail = 1
    head = 0
    while head < tail:
        cell = queue[head]
        head += 1
        for k in range(starts[cell], starts[cell + 1]):
            p = beside[k]
            other = left[p] + right[p] - cell
            if not reached[other]:
                reached[other] = True
                seen_by[other] = seen_by[cell] ^ changes[p]
                queue[tail] = other
                tail += 1
    return seen_by
