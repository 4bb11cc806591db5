"""How walls and chords part the floor into faces: an exact planar arrangement, for the verifier.

Segment s is given by three lines, rows 3 s to 3 s + 2 of a table: its own, one that crosses it at
its start, and one at its end. Segments may cross, touch and overlap in any way; walls among
themselves meet at corners only. All segments together must be connected, so that every face has
one boundary.

An edge is a part of a segment between two neighbouring nodes. Half-edge 2 e runs along edge e in
the direction of its segment and 2 e + 1 against it; half-edges also name the sides of edges, each
the one on its left.
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
    nodes: Ints  # (nodes, 2) rows of two lines through each node
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
def _boxes(lines: Ints) -> NDArray[np.float64]:
    """Boxes around the segments up to rounding: x0, y0, x1, y1."""
    boxes = np.empty((lines.shape[0] // 3, 4), dtype=np.float64)
    for s in range(boxes.shape[0]):
        a, b, c = float(lines[3 * s, 0]), float(lines[3 * s, 1]), float(lines[3 * s, 2])
        for end in range(2):
            k = 3 * s + 1 + end
            d, e, f = float(lines[k, 0]), float(lines[k, 1]), float(lines[k, 2])
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
def crossings(lines: Ints, n_walls: int, slack: float) -> Ints:
    """Where segments meet, shape (k, 3): segment, the segment met, and 0 for the crossing of both
    lines, 1 for the start and 2 for the end of the segment met, where both lie on one line.
    """
    m = lines.shape[0] // 3
    boxes = _boxes(lines)
    found = np.empty((64 + 8 * m, 3), dtype=np.int64)
    count = 0
    for s in range(n_walls, m):
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
            start = side(lines, 3 * s, 3 * d, 3 * d + 1)
            if cross_sign(lines, 3 * s, 3 * d) != 0:
                if start * side(lines, 3 * s, 3 * d, 3 * d + 2) > 0:
                    continue
                of_start = side(lines, 3 * d, 3 * s, 3 * s + 1)
                if of_start * side(lines, 3 * d, 3 * s, 3 * s + 2) > 0:
                    continue
                found[count, 0], found[count, 1], found[count, 2] = s, d, 0
                count += 1
            elif start == 0:
                for k in range(4):
                    one, other = (s, d) if k < 2 else (d, s)
                    end = 1 + k % 2
                    if (
                        order(lines, 3 * one, 3 * one + 1, 3 * other + end) >= 0
                        and order(lines, 3 * one, 3 * other + end, 3 * one + 2) >= 0
                    ):
                        found[count, 0], found[count, 1], found[count, 2] = one, other, end
                        count += 1
    return found[:count].copy()


@kernel
def _sort(lines: Ints, s: int, marks: Ints, items: Ints, scratch: Ints, a: int, b: int) -> None:
    """Sort items[a:b], points on segment s, along it (merge sort); `marks` are lines through
    points.
    """
    width = 1
    while width < b - a:
        for at in range(a, b, 2 * width):
            middle, end = min(at + width, b), min(at + 2 * width, b)
            i, j = at, middle
            for k in range(at, end):
                if i < middle and (
                    j >= end or order(lines, 3 * s, marks[int(items[i])], marks[int(items[j])]) >= 0
                ):
                    scratch[k] = items[i]
                    i += 1
                else:
                    scratch[k] = items[j]
                    j += 1
        for k in range(a, b):
            items[k] = scratch[k]
        width *= 2


@kernel
def arrange(
    lines: Ints, n_walls: int, next_corner: Ints, slack: float
) -> tuple[Ints, Ints, Ints, Ints, Ints, Ints, Ints, int]:
    """The fields of the `Arrangement` of these segments, the first `n_walls` of which are walls.

    Wall i runs from corner i to corner `next_corner[i]`. `slack` is added to boxes before they are
    compared, against rounding.
    """
    m = lines.shape[0] // 3
    met = crossings(lines, n_walls, slack)
    # A point on a segment: whose, and a line through it. First all starts, then all ends, then the
    # crossings as seen from one segment and from the other.
    n_points = 2 * m + 2 * met.shape[0]
    parent = np.arange(n_points)
    owner = np.empty(n_points, dtype=np.int64)
    marks = np.empty(n_points, dtype=np.int64)
    begin = np.zeros(m + 1, dtype=np.int64)
    for s in range(m):
        owner[s] = owner[m + s] = s
        marks[s] = 3 * s + 1
        marks[m + s] = 3 * s + 2
        begin[s + 1] += 2
    for s in range(n_walls):
        unite(parent, m + s, next_corner[s])
    n_points = 2 * m
    for k in range(met.shape[0]):
        s, d = met[k, 0], met[k, 1]
        owner[n_points] = s
        begin[s + 1] += 1
        if met[k, 2] == 0:
            marks[n_points] = 3 * d
            owner[n_points + 1] = d
            marks[n_points + 1] = 3 * s
            begin[d + 1] += 1
            unite(parent, n_points, n_points + 1)
            n_points += 2
        else:
            marks[n_points] = 3 * d + met[k, 2]
            unite(parent, n_points, (met[k, 2] - 1) * m + d)
            n_points += 1
    # Points by segment, in order along it.
    for s in range(m):
        begin[s + 1] += begin[s]
    fill = begin[:m].copy()
    items = np.empty(n_points, dtype=np.int64)
    for k in range(n_points):
        items[fill[owner[k]]] = k
        fill[owner[k]] += 1
    scratch = np.empty(n_points, dtype=np.int64)
    for s in range(m):
        _sort(lines, s, marks, items, scratch, begin[s], begin[s + 1])
        for k in range(begin[s] + 1, begin[s + 1]):
            if order(lines, 3 * s, marks[int(items[k - 1])], marks[int(items[k])]) == 0:
                unite(parent, items[k - 1], items[k])
    # Nodes in order of their first point, which represents them.
    number = np.empty(n_points, dtype=np.int64)
    nodes = np.empty((n_points, 2), dtype=np.int64)
    n_nodes = 0
    for k in range(n_points):
        r = root(parent, k)
        if r == k:
            number[k] = n_nodes
            nodes[n_nodes, 0] = 3 * owner[k]
            nodes[n_nodes, 1] = marks[k]
            n_nodes += 1
        number[k] = number[r]
    # Edges.
    first = np.zeros(m + 1, dtype=np.int64)
    segment = np.empty(n_points, dtype=np.int64)
    tail = np.empty(2 * n_points, dtype=np.int64)
    edges = 0
    for s in range(m):
        for k in range(begin[s] + 1, begin[s + 1]):
            one, two = number[items[k - 1]], number[items[k]]
            if one != two:
                segment[edges] = s
                tail[2 * edges] = one
                tail[2 * edges + 1] = two
                edges += 1
        first[s + 1] = edges
    segment = segment[:edges].copy()
    tail = tail[: 2 * edges].copy()
    same, after = _turn_around(lines, segment, tail, n_nodes)
    # Each face has one boundary; number the faces in the order in which their boundaries begin.
    face = np.full(2 * edges, -1, dtype=np.int64)
    faces = 0
    for h in range(2 * edges):
        if same[h] == h and face[h] < 0:
            at = h
            while face[at] < 0:
                face[at] = faces
                at = after[at]
            faces += 1
    for h in range(2 * edges):
        face[h] = face[same[h]]
    return first, segment, face, same, after, tail, nodes[:n_nodes].copy(), faces


@kernel
def _turn_around(lines: Ints, segment: Ints, tail: Ints, n_nodes: int) -> tuple[Ints, Ints]:
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
    half = np.empty(n, dtype=np.int64)
    for h in range(n):
        sign = 1 - 2 * (h % 2)
        dx[h] = sign * lines[3 * segment[h // 2], 1]
        dy[h] = -sign * lines[3 * segment[h // 2], 0]
        # 0 for directions from east round to just before west, 1 for the others.
        half[h] = 0 if dy[h] > 0 or (dy[h] == 0 and dx[h] > 0) else 1
        # Insertion sort by direction, counter-clockwise; few edges meet at a node.
        at = fill[tail[h]]
        while at > begin[tail[h]]:
            other = around[at - 1]
            ahead = half[other] - half[h]
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
                and half[previous] == half[h]
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
