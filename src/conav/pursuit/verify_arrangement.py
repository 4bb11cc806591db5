"""How walls and chords part the floor into faces: an exact planar arrangement, for the verifier.

A segment is a row of nine numbers: its line, a line that crosses it at its start, and one at its
end. Segments may cross, touch and overlap in any way; walls among themselves meet at corners only.
All segments together must be connected, so that every face has one boundary.

An edge is a part of a segment between two neighbouring nodes. Half-edge 2 e runs along edge e in the
direction of its segment and 2 e + 1 against it; half-edges also name the sides of edges, each the
one on its left.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.pursuit.verify_sight import cross_sign, order, side

Ints = NDArray[np.int64]


class Arrangement(NamedTuple):
    """Faces, and the edges between them."""

    first: Ints  # (segments + 1,) the edges of segment s are first[s] to first[s + 1] - 1, in order
    segment: Ints  # (edges,) whose part an edge is
    face: Ints  # (2 edges,) the face on the left of each half-edge
    same: Ints  # (2 edges,) the one of the half-edges between the same nodes that stands for all
    after: Ints  # (2 edges,) next half-edge round the face, for those that stand for themselves
    tail: Ints  # (2 edges,) row of `nodes` at which each half-edge begins
    nodes: Ints  # (nodes, 6) two lines through each node
    faces: int


@kernel
def root(parent: Ints, i: int) -> int:
    """The representative of i, with paths halved."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@kernel
def unite(parent: Ints, i: int, j: int) -> None:
    """Make one class of those of i and j; the lower representative stays."""
    i = root(parent, i)
    j = root(parent, j)
    if i < j:
        parent[j] = i
    else:
        parent[i] = j


@kernel
def _boxes(segments: Ints) -> NDArray[np.float64]:
    """Boxes around the segments, wide enough for the rounding: x0, y0, x1, y1."""
    boxes = np.empty((segments.shape[0], 4), dtype=np.float64)
    for s in range(segments.shape[0]):
        a, b, c = float(segments[s, 0]), float(segments[s, 1]), float(segments[s, 2])
        for end in range(2):
            k = 3 + 3 * end
            d, e, f = float(segments[s, k]), float(segments[s, k + 1]), float(segments[s, k + 2])
            w = a * e - b * d
            x = (b * f - c * e) / w
            y = (c * d - a * f) / w
            if end == 0:
                boxes[s, 0] = boxes[s, 2] = x
                boxes[s, 1] = boxes[s, 3] = y
            else:
                boxes[s, 0] = min(boxes[s, 0], x)
                boxes[s, 1] = min(boxes[s, 1], y)
                boxes[s, 2] = max(boxes[s, 2], x)
                boxes[s, 3] = max(boxes[s, 3], y)
    return boxes


@kernel
def crossings(segments: Ints, n_walls: int, slack: float) -> Ints:
    """Where segments meet, shape (k, 3): segment, the segment met, and 0 for the crossing of both
    lines, 1 for the start and 2 for the end of the segment met, where both lie on one line.
    """
    m = segments.shape[0]
    boxes = _boxes(segments)
    found = np.empty((64 + 8 * m, 3), dtype=np.int64)
    count = 0
    for s in range(n_walls, m):
        of_s = segments[s, 0:3]
        for d in range(s):
            if (
                boxes[s, 0] > boxes[d, 2] + slack
                or boxes[d, 0] > boxes[s, 2] + slack
                or boxes[s, 1] > boxes[d, 3] + slack
                or boxes[d, 1] > boxes[s, 3] + slack
            ):
                continue
            if count + 4 > found.shape[0]:
                longer = np.empty((2 * found.shape[0], 3), dtype=np.int64)
                longer[:count] = found[:count]
                found = longer
            of_d = segments[d, 0:3]
            start = side(of_s, of_d, segments[d, 3:6])
            if cross_sign(of_s, of_d) != 0:
                if start * side(of_s, of_d, segments[d, 6:9]) > 0:
                    continue
                if side(of_d, of_s, segments[s, 3:6]) * side(of_d, of_s, segments[s, 6:9]) > 0:
                    continue
                found[count, 0], found[count, 1], found[count, 2] = s, d, 0
                count += 1
            elif start == 0:
                for turn in range(2):
                    one, other = (s, d) if turn == 0 else (d, s)
                    l = segments[one, 0:3]
                    for end in range(2):
                        point = segments[other, 3 + 3 * end : 6 + 3 * end]
                        if (
                            order(l, segments[one, 3:6], point) >= 0
                            and order(l, point, segments[one, 6:9]) >= 0
                        ):
                            found[count, 0], found[count, 1] = one, other
                            found[count, 2] = 1 + end
                            count += 1
    return found[:count].copy()


@kernel
def _merge(segments: Ints, s: int, items: Ints, marks: Ints, scratch: Ints, size: int) -> None:
    """Sort the crossings of segment s along it (merge sort); `marks` holds the crossing lines."""
    l = segments[s, 0:3]
    width = 1
    while width < size:
        at = 0
        while at < size:
            i, middle, end = at, min(at + width, size), min(at + 2 * width, size)
            j = middle
            for k in range(at, end):
                if i < middle and (
                    j >= end or order(l, marks[items[i]], marks[items[j]]) >= 0
                ):
                    scratch[k] = items[i]
                    i += 1
                else:
                    scratch[k] = items[j]
                    j += 1
            at = end
        items[:size] = scratch[:size]
        width *= 2


@kernel
def arrange(
    segments: Ints, n_walls: int, next_corner: Ints, slack: float
) -> tuple[Ints, Ints, Ints, Ints, Ints, Ints, Ints, int]:
    """The fields of the `Arrangement` of these segments, the first `n_walls` of which are walls.

    Wall i runs from corner i to corner `next_corner[i]`. `slack` is added to boxes before they are
    compared, against rounding.
    """
    m = segments.shape[0]
    met = crossings(segments, n_walls, slack)
    # A point on a segment: its node, and a line through it. First all starts, then all ends, then
    # the crossings as seen from one segment, then from the other.
    n_points = 2 * m + 2 * met.shape[0]
    parent = np.arange(n_points)
    owner = np.empty(n_points, dtype=np.int64)
    marks = np.empty((n_points, 3), dtype=np.int64)
    count = np.zeros(m + 1, dtype=np.int64)
    for s in range(m):
        owner[s] = owner[m + s] = s
        marks[s] = segments[s, 3:6]
        marks[m + s] = segments[s, 6:9]
        count[s] += 2
    for s in range(n_walls):
        unite(parent, m + s, next_corner[s])
    n_points = 2 * m
    for k in range(met.shape[0]):
        s, d = met[k, 0], met[k, 1]
        owner[n_points] = s
        count[s] += 1
        if met[k, 2] == 0:
            marks[n_points] = segments[d, 0:3]
            owner[n_points + 1] = d
            marks[n_points + 1] = segments[s, 0:3]
            count[d] += 1
            unite(parent, n_points, n_points + 1)
            n_points += 2
        else:
            end = (met[k, 2] - 1) * m + d
            marks[n_points] = marks[end]
            unite(parent, n_points, end)
            n_points += 1
    # Points by segment, in order along it.
    begin = np.zeros(m + 1, dtype=np.int64)
    for s in range(m):
        begin[s + 1] = begin[s] + count[s]
    fill = begin[:m].copy()
    items = np.empty(n_points, dtype=np.int64)
    for k in range(n_points):
        items[fill[owner[k]]] = k
        fill[owner[k]] += 1
    scratch = np.empty(n_points, dtype=np.int64)
    for s in range(m):
        part = items[begin[s] : begin[s + 1]]
        _merge(segments, s, part, marks, scratch, part.shape[0])
        for k in range(1, part.shape[0]):
            if order(segments[s, 0:3], marks[part[k - 1]], marks[part[k]]) == 0:
                unite(parent, part[k - 1], part[k])
    # Edges.
    first = np.zeros(m + 1, dtype=np.int64)
    segment = np.empty(n_points, dtype=np.int64)
    tail = np.empty(2 * n_points, dtype=np.int64)
    edges = 0
    for s in range(m):
        for k in range(begin[s] + 1, begin[s + 1]):
            one, two = root(parent, items[k - 1]), root(parent, items[k])
            if one != two:
                segment[edges] = s
                tail[2 * edges] = one
                tail[2 * edges + 1] = two
                edges += 1
        first[s + 1] = edges
    segment = segment[:edges].copy()
    tail = tail[: 2 * edges].copy()
    # Nodes in order of their first point.
    number = np.full(n_points, -1, dtype=np.int64)
    n_nodes = 0
    for k in range(n_points):
        r = root(parent, k)
        if number[r] < 0:
            number[r] = n_nodes
            n_nodes += 1
    nodes = np.empty((n_nodes, 6), dtype=np.int64)
    for k in range(n_points):
        node = number[root(parent, k)]
        nodes[node, 0:3] = segments[owner[k], 0:3]
        nodes[node, 3:6] = marks[k]
    for h in range(2 * edges):
        tail[h] = number[tail[h]]
    same, after = _turn_around(segments, segment, tail, n_nodes)
    # Each face has one boundary; number the faces in the order in which their boundaries begin.
    face = np.full(2 * edges, -1, dtype=np.int64)
    faces = 0
    for h in range(2 * edges):
        if same[h] == h and face[h] < 0:
            along = h
            while face[along] < 0:
                face[along] = faces
                along = after[along]
            faces += 1
    for h in range(2 * edges):
        face[h] = face[same[h]]
    return first, segment, face, same, after, tail, nodes, faces


@kernel
def _half(dx: int, dy: int) -> int:
    """0 for directions from east round to just before west, 1 for the others."""
    return 0 if dy > 0 or (dy == 0 and dx > 0) else 1


@kernel
def _turn_around(segments: Ints, segment: Ints, tail: Ints, n_nodes: int) -> tuple[Ints, Ints]:
    """Which half-edges coincide, and which follows which round a face."""
    n = tail.shape[0]
    begin = np.zeros(n_nodes + 1, dtype=np.int64)
    for h in range(n):
        begin[tail[h] + 1] += 1
    for node in range(n_nodes):
        begin[node + 1] += begin[node]
    fill = begin[:n_nodes].copy()
    around = np.empty(n, dtype=np.int64)
    dx = np.empty(n, dtype=np.int64)
    dy = np.empty(n, dtype=np.int64)
    for h in range(n):
        sign = 1 - 2 * (h % 2)
        dx[h] = sign * segments[segment[h // 2], 1]
        dy[h] = -sign * segments[segment[h // 2], 0]
        # Insertion sort by direction, counter-clockwise; few edges meet at a node.
        at = fill[tail[h]]
        while at > begin[tail[h]]:
            other = around[at - 1]
            ahead = _half(dx[other], dy[other]) - _half(dx[h], dy[h])
            cross = dx[other] * dy[h] - dy[other] * dx[h]
            if ahead < 0 or (ahead == 0 and cross >= 0):
                break
            around[at] = other
            at -= 1
        around[at] = h
        fill[tail[h]] += 1
    same = np.empty(n, dtype=np.int64)
    after = np.full(n, -1, dtype=np.int64)
    for node in range(n_nodes):
        # One half-edge stands for those in its direction; edges were inserted in their order, so it
        # is that of the least edge at either end.
        previous = -1
        first = -1
        for k in range(begin[node], begin[node + 1]):
            h = around[k]
            if (
                previous >= 0
                and dx[previous] * dy[h] == dy[previous] * dx[h]
                and _half(dx[previous], dy[previous]) == _half(dx[h], dy[h])
            ):
                same[h] = previous
                continue
            same[h] = h
            if previous >= 0:
                after[h ^ 1] = previous
            else:
                first = h
            previous = h
        if first >= 0:
            after[first ^ 1] = previous
    return same, after
