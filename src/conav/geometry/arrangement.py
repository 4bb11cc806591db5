"""The arrangement of chords on a floor: nodes, half-edges, cells and who sees each.

See `conav.geometry.view_cells`, which this serves. Every order is an exact sign.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.chords import (
    Chords,
    find_root,
    order_on_chord,
    order_on_wall,
    turn_between,
)
from conav.geometry.predicates import direction_turn

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

NO_CELL = -1


@kernel
def arrange(
    points: Floats, wall_ends: Ints, rings: Ints, chords: Chords, pairs: Ints, anchors: Ints
) -> tuple[Floats, Ints, Ints, Ints, Ints, Ints, Ints, Ints, Floats, Ints]:
    """Areas of cells, and the fields of `ViewCells` from `seen_by` on without them.

    `points` are the floor's vertices, then viewpoints. There is at least one chord, all rings hang
    together by chords, and `pairs` are the chords' crossings. For each view `anchors` has a vertex
    from which it sees the ring on, or -1, and one to which it sees the ring come, or -1; both -1
    where it sees nothing.
    """
    crossings, crossing_starts = _sort_crossings(points, chords, pairs)
    same = np.arange(pairs.shape[0])
    _find_equal_crossings(points, chords, pairs, crossings, crossing_starts, same)
    order = np.argsort(chords.walls, kind="mergesort")
    node_of_vertex, node_of_end, node_of_crossing, places, node_points = _number_nodes(
        points, wall_ends, chords, pairs, same, order
    )
    along_chords, chord_of = _cut_chords(
        chords, crossings, crossing_starts, same, node_of_vertex, node_of_end, node_of_crossing
    )
    pieces = chord_of.shape[0]
    by_place = np.argsort(places, kind="mergesort")
    off_rings = 0
    while off_rings < by_place.shape[0] and places[by_place[off_rings]] < 0:
        off_rings += 1
    ring_nodes = by_place[off_rings:]
    nodes = np.concatenate((along_chords, ring_nodes))
    out_of, into = _ring_stretches(rings, places, ring_nodes, pieces)
    following = _link(points, wall_ends, chords, chord_of, nodes, places, out_of, into)
    cells, areas = _trace(points, wall_ends, node_points, places, nodes, following, chord_of)
    left = cells[: 2 * pieces : 2].copy()
    right = cells[1 : 2 * pieces : 2].copy()
    changes = chords.views[chord_of]
    seen_by = _spread(areas, left, right, changes)
    for i in range(anchors.shape[0]):
        h = _seen_half_edge(anchors[i], rings, places, ring_nodes, node_of_vertex, out_of, into)
        # So far differences to cell 0.
        if h >= 0 and not (seen_by[cells[h]] >> i) & 1:
            for cell in range(seen_by.shape[0]):
                seen_by[cell] ^= 1 << i
    return areas, seen_by, left, right, changes, cells, following, nodes, node_points, places


@kernel
def _seen_half_edge(
    anchor: Ints, rings: Ints, places: Ints, ring_nodes: Ints, node_of_vertex: Ints,
    out_of: Ints, into: Ints,
) -> int:  # fmt: skip
    v = max(anchor[0], anchor[1])
    if v < 0:
        return -1
    node = node_of_vertex[v]
    if node >= 0:
        return out_of[node] if anchor[0] >= 0 else into[node]
    # On the stretch that passes the vertex: from the last node before it on its ring, which comes
    # last where the ring begins with the vertex.
    before = -1
    last = -1
    for r in range(ring_nodes.shape[0]):
        place = places[ring_nodes[r]]
        if rings[place // 2] == rings[v]:
            last = r
            if place < 2 * v:
                before = r
    return out_of[ring_nodes[before if before >= 0 else last]]


@kernel
def _cut_chords(
    chords: Chords, crossings: Ints, crossing_starts: Ints, same: Ints, node_of_vertex: Ints,
    node_of_end: Ints, node_of_crossing: Ints,
) -> tuple[Ints, Ints]:  # fmt: skip
    """The node where each half-edge along chords starts, and the chord of each piece."""
    most = chords.starts.shape[0] + crossings.shape[0]
    nodes = np.empty(2 * most, np.int64)
    chord_of = np.empty(most, np.int64)
    pieces = 0
    for i in range(chords.starts.shape[0]):
        at = node_of_vertex[chords.starts[i]]
        for k in range(crossing_starts[i], crossing_starts[i + 1] + 1):
            if k < crossing_starts[i + 1]:
                to = node_of_crossing[find_root(same, crossings[k])]
            else:
                to = node_of_end[i]
            if to != at:
                chord_of[pieces] = i
                nodes[2 * pieces] = at
                nodes[2 * pieces + 1] = to
                pieces += 1
                at = to
    return nodes[: 2 * pieces].copy(), chord_of[:pieces].copy()


@kernel
def _ring_stretches(rings: Ints, places: Ints, ring_nodes: Ints, pieces: int) -> tuple[Ints, Ints]:
    """The half-edge along the ring out of each node and into it, -1 for nodes off the rings."""
    out_of = np.full(places.shape[0], -1, np.int64)
    into = np.full(places.shape[0], -1, np.int64)
    first = 0
    count = ring_nodes.shape[0]
    for r in range(count):
        ring = rings[places[ring_nodes[r]] // 2]
        if rings[places[ring_nodes[first]] // 2] != ring:
            first = r
        last = r + 1 == count or rings[places[ring_nodes[r + 1]] // 2] != ring
        out_of[ring_nodes[r]] = 2 * pieces + r
        into[ring_nodes[first] if last else ring_nodes[r + 1]] = 2 * pieces + r
    return out_of, into


@kernel
def _trace(
    points: Floats, wall_ends: Ints, node_points: Floats, places: Ints, nodes: Ints,
    following: Ints, chord_of: Ints,
) -> tuple[Ints, Floats]:  # fmt: skip
    """The cell of each half-edge, and the cells' areas."""
    total = nodes.shape[0]
    cells = np.full(total, NO_CELL, np.int64)
    areas = np.zeros(total)
    count = 0
    for h in range(total):
        if cells[h] == NO_CELL:
            edge = h
            while cells[edge] == NO_CELL:
                cells[edge] = count
                areas[count] += _stretch_area(
                    points, wall_ends, node_points, places, nodes[edge], nodes[following[edge]],
                    edge >= 2 * chord_of.shape[0],
                )  # fmt: skip
                edge = following[edge]
            count += 1
    return cells, areas[:count].copy()


@kernel
def _sort_crossings(points: Floats, chords: Chords, pairs: Ints) -> tuple[Ints, Ints]:
    """The crossings in their order along each chord, and where each chord's begin."""
    count = chords.starts.shape[0]
    starts = np.zeros(count + 1, np.int64)
    for p in range(pairs.shape[0]):
        starts[pairs[p, 0] + 1] += 1
        starts[pairs[p, 1] + 1] += 1
    for i in range(count):
        starts[i + 1] += starts[i]
    filled = starts[:-1].copy()
    crossings = np.empty(2 * pairs.shape[0], np.int64)
    for p in range(pairs.shape[0]):
        for side in range(2):
            i = pairs[p, side]
            other = pairs[p, 1 - side]
            k = filled[i]
            filled[i] += 1
            while k > starts[i]:
                before = pairs[crossings[k - 1], 0] + pairs[crossings[k - 1], 1] - i
                if order_on_chord(points, chords, i, before, other) <= 0:
                    break
                crossings[k] = crossings[k - 1]
                k -= 1
            crossings[k] = p
    return crossings, starts


@kernel
def _find_equal_crossings(
    points: Floats, chords: Chords, pairs: Ints, crossings: Ints, starts: Ints, same: Ints
) -> None:
    """Joins crossings at one point in the forest `same`: three chords and more may meet."""
    for i in range(chords.starts.shape[0]):
        for k in range(starts[i] + 1, starts[i + 1]):
            j = pairs[crossings[k - 1], 0] + pairs[crossings[k - 1], 1] - i
            other = pairs[crossings[k], 0] + pairs[crossings[k], 1] - i
            if order_on_chord(points, chords, i, j, other) == 0:
                one = find_root(same, crossings[k])
                same[one] = find_root(same, crossings[k - 1])


@kernel
def _number_nodes(
    points: Floats, wall_ends: Ints, chords: Chords, pairs: Ints, same: Ints, order: Ints
) -> tuple[Ints, Ints, Ints, Ints, Floats]:
    """The node of each vertex (or -1), chord's end and crossing; each node's place and point.

    Nodes on one wall are numbered in their order along it; `order` has the chords by walls.
    """
    count = chords.starts.shape[0]
    node_of_vertex = np.full(wall_ends.shape[0], -1, np.int64)
    node_of_end = np.empty(count, np.int64)
    node_of_crossing = np.full(pairs.shape[0], -1, np.int64)
    places = np.empty(2 * count + pairs.shape[0], np.int64)
    node_points = np.empty((2 * count + pairs.shape[0], 2))
    number = 0
    for i in range(count):
        for v in (chords.starts[i], chords.ends[i]):
            if v >= 0:
                if node_of_vertex[v] < 0:
                    node_of_vertex[v] = number
                    places[number] = 2 * v
                    node_points[number, 0] = points[v, 0]
                    node_points[number, 1] = points[v, 1]
                    number += 1
                if v == chords.ends[i]:
                    node_of_end[i] = node_of_vertex[v]
    begin = 0
    while begin < count and chords.walls[order[begin]] < 0:
        begin += 1
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
        with_last = (
            k > begin
            and chords.walls[order[k - 1]] == wall
            and order_on_wall(points, wall_ends, chords, wall, order[k - 1], i) == 0
        )
        if with_last:
            node_of_end[i] = node_of_end[order[k - 1]]
            continue
        node_of_end[i] = number
        places[number] = 2 * wall + 1
        node_points[number, 0], node_points[number, 1] = _meeting(
            points, wall, wall_ends[wall], chords.tails[i], chords.heads[i]
        )
        number += 1
    for p in range(pairs.shape[0]):
        if find_root(same, p) == p:
            i, j = pairs[p]
            node_of_crossing[p] = number
            places[number] = -1
            node_points[number, 0], node_points[number, 1] = _meeting(
                points, chords.tails[i], chords.heads[i], chords.tails[j], chords.heads[j]
            )
            number += 1
    return (
        node_of_vertex, node_of_end, node_of_crossing, places[:number].copy(),
        node_points[:number].copy(),
    )  # fmt: skip


@kernel
def _meeting(points: Floats, a: int, b: int, c: int, d: int) -> tuple[float, float]:
    """Where the line from a to b meets that from c to d, rounded."""
    dx = points[d, 0] - points[c, 0]
    dy = points[d, 1] - points[c, 1]
    one = (points[a, 0] - points[c, 0]) * dy - (points[a, 1] - points[c, 1]) * dx
    two = (points[b, 0] - points[c, 0]) * dy - (points[b, 1] - points[c, 1]) * dx
    part = one / (one - two) if one != two else 0.5
    x = points[a, 0] + part * (points[b, 0] - points[a, 0])
    return x, points[a, 1] + part * (points[b, 1] - points[a, 1])


@kernel
def _link(
    points: Floats, wall_ends: Ints, chords: Chords, chord_of: Ints, nodes: Ints, places: Ints,
    out_of: Ints, into: Ints,
) -> Ints:  # fmt: skip
    """The half-edge after each one: at its end the first clockwise from where it came."""
    pieces = chord_of.shape[0]
    following = np.empty(nodes.shape[0], np.int64)
    starts = np.zeros(places.shape[0] + 1, np.int64)
    for h in range(2 * pieces):
        starts[nodes[h] + 1] += 1
    for node in range(places.shape[0]):
        starts[node + 1] += starts[node]
    filled = starts[:-1].copy()
    leaving = np.empty(2 * pieces, np.int64)
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
    return following


@kernel
def _sort_around(
    points: Floats, chords: Chords, chord_of: Ints, around: Ints, tail: int, head: int,
    crossing: bool,
) -> None:  # fmt: skip
    """Sorts half-edges that leave a node counter-clockwise from the direction of tail to head.

    That is the wall on from a node of a ring, or the chord of the first half-edge at a crossing.
    """
    n = around.shape[0]
    signs = np.empty(n, np.int64)
    quarters = np.empty(n, np.int64)
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
        here = on_one_wall(places, node, after)
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
def on_one_wall(places: Ints, node: int, after: int) -> bool:
    """Whether the ring goes from a node to the one after along one wall, past no vertex."""
    place = places[node]
    if place % 2 == 0:
        return places[after] == place + 1
    # Nodes on one wall are numbered along it; else the ring comes around from behind.
    return places[after] == place and node < after


@kernel
def _spread(areas: Floats, left: Ints, right: Ints, changes: Ints) -> Ints:
    """The views that see a cell but not cell 0, or the other way round, for every cell."""
    count = areas.shape[0]
    starts = np.zeros(count + 1, np.int64)
    for p in range(left.shape[0]):
        starts[left[p] + 1] += 1
        starts[right[p] + 1] += 1
    for cell in range(count):
        starts[cell + 1] += starts[cell]
    filled = starts[:-1].copy()
    beside = np.empty(2 * left.shape[0], np.int64)
    for p in range(left.shape[0]):
        beside[filled[left[p]]] = p
        filled[left[p]] += 1
        beside[filled[right[p]]] = p
        filled[right[p]] += 1
    seen_by = np.zeros(count, np.int64)
    reached = np.zeros(count, np.bool_)
    queue = np.empty(count, np.int64)
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
