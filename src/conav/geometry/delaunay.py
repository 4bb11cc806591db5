"""Triangulations of points as half-edges, by a sweep and flips; walls put in by flips.

A half-edge h starts at point `origin[h]`, `following[h]` is the next one counter-clockwise around
its triangle, `twin[h]` the same edge seen from the other side, or -1 on the hull. A flip keeps the
number of every half-edge. Every decision that must be right is exact (`orientation`); edges are
flipped towards Delaunay where the filter is sure.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.predicates import orientation, surely_in_circle

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

NO_WALL = -1  # the label of a half-edge that is not a wall
SOLID = -2  # the label of a wall's half-edge on the side that is not free


@kernel
def _turn(points: Floats, a: int, b: int, c: int) -> int:
    return orientation(
        points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1]
    )


@kernel
def _new_triangle(
    origin: Ints, following: Ints, twin: Ints, out: Ints, h: int, a: int, b: int, c: int
) -> None:
    """Triangle a, b, c as the half-edges h (from a), h + 1, h + 2."""
    origin[h] = a
    origin[h + 1] = b
    origin[h + 2] = c
    following[h] = h + 1
    following[h + 1] = h + 2
    following[h + 2] = h
    twin[h] = -1
    twin[h + 1] = -1
    twin[h + 2] = -1
    out[a] = h
    out[b] = h + 1
    out[c] = h + 2


@kernel
def _join(twin: Ints, h: int, g: int) -> None:
    twin[h] = g
    twin[g] = h


@kernel
def _flip(origin: Ints, following: Ints, twin: Ints, out: Ints, h: int) -> None:
    """Replaces the edge a-b by the other diagonal of its two triangles; h then starts at d."""
    g = twin[h]
    h1 = following[h]
    h2 = following[h1]
    g1 = following[g]
    g2 = following[g1]
    a = origin[h]
    b = origin[g]
    if out[a] == h:
        out[a] = g1
    if out[b] == g:
        out[b] = h1
    origin[h] = origin[g2]
    origin[g] = origin[h2]
    following[h] = h2
    following[h2] = g1
    following[g1] = h
    following[g] = g2
    following[g2] = h1
    following[h1] = g


@kernel
def _make_delaunay(
    points: Floats,
    origin: Ints,
    following: Ints,
    twin: Ints,
    out: Ints,
    label: Ints,
    stack: Ints,
    waiting: NDArray[np.bool_],
    count: int,
) -> None:
    """Flips until no edge on the stack, nor any it touches, is surely not Delaunay (Lawson)."""
    while count > 0:
        count -= 1
        h = stack[count]
        waiting[h] = False
        g = twin[h]
        if g < 0 or label[h] != NO_WALL:
            continue
        a = origin[h]
        b = origin[g]
        c = origin[following[following[h]]]
        d = origin[following[following[g]]]
        if not surely_in_circle(
            points[a, 0], points[a, 1], points[b, 0], points[b, 1],
            points[c, 0], points[c, 1], points[d, 0], points[d, 1],
        ):  # fmt: skip
            continue
        around = (following[h], following[following[h]], following[g], following[following[g]])
        _flip(origin, following, twin, out, h)
        for edge in around:
            if not waiting[edge]:
                waiting[edge] = True
                stack[count] = edge
                count += 1


@kernel
def triangulate_points(points: Floats, order: Ints) -> tuple[int, Ints, Ints, Ints, Ints, Ints]:
    """How many half-edges, then `origin`, `following`, `twin`, `label`, and one leaving each point.

    `order` lists the points to take, different ones, sorted by x, then y. Each one lies outside
    the hull of those before it, so it is joined to the hull edges that face it. No half-edges
    where all points lie on one line. Labels are all `NO_WALL`.
    """
    n = order.shape[0]
    size = 6 * n
    origin = np.empty(size, np.int64)
    following = np.empty(size, np.int64)
    twin = np.empty(size, np.int64)
    label = np.full(size, NO_WALL, np.int64)
    out = np.full(points.shape[0], -1, np.int64)
    stack = np.empty(size, np.int64)
    waiting = np.zeros(size, np.bool_)
    after = np.full(points.shape[0], -1, np.int64)  # next on the hull, counter-clockwise
    before = np.full(points.shape[0], -1, np.int64)
    edge = np.full(points.shape[0], -1, np.int64)  # half-edge along the hull from this point
    first = 2
    while first < n and _turn(points, order[0], order[1], order[first]) == 0:
        first += 1
    if first >= n:
        return 0, origin, following, twin, label, out
    # The first points lie on a line: a fan from the first point off it.
    apex = order[first]
    left = _turn(points, order[0], order[1], apex) > 0
    count = 0
    for i in range(first - 1):
        a, b = order[i], order[i + 1]
        if left:
            _new_triangle(origin, following, twin, out, count, a, b, apex)
            after[a] = b
            before[b] = a
            edge[a] = count
            if i > 0:
                _join(twin, count + 2, count - 2)
        else:
            _new_triangle(origin, following, twin, out, count, b, a, apex)
            after[b] = a
            before[a] = b
            edge[b] = count
            if i > 0:
                _join(twin, count + 1, count - 1)
        count += 3
    low, high = order[0], order[first - 1]
    if left:
        after[high] = apex
        before[apex] = high
        edge[high] = count - 2
        after[apex] = low
        before[low] = apex
        edge[apex] = 2
    else:
        after[low] = apex
        before[apex] = low
        edge[low] = 1
        after[apex] = high
        before[high] = apex
        edge[apex] = count - 1
    waits = 0
    for h in range(count):
        stack[waits] = h
        waiting[h] = True
        waits += 1
    _make_delaunay(points, origin, following, twin, out, label, stack, waiting, waits)
    for i in range(first + 1, n):
        p = order[i]
        start = order[i - 1]
        while _turn(points, before[start], start, p) < 0:
            start = before[start]
        v = start
        link = -1
        opening = -1
        waits = 0
        while _turn(points, v, after[v], p) < 0:
            w = after[v]
            _new_triangle(origin, following, twin, out, count, w, v, p)
            _join(twin, count, edge[v])
            if link >= 0:
                _join(twin, count + 1, link)
            else:
                opening = count + 1
            link = count + 2
            stack[waits] = count
            waiting[count] = True
            waits += 1
            count += 3
            v = w
        after[start] = p
        before[p] = start
        edge[start] = opening
        after[p] = v
        before[v] = p
        edge[p] = link
        _make_delaunay(points, origin, following, twin, out, label, stack, waiting, waits)
    return count, origin, following, twin, label, out


@kernel
def _leave(
    points: Floats, origin: Ints, following: Ints, twin: Ints, out: Ints, a: int, b: int
) -> tuple[int, int]:
    """Where the segment from a to b leaves a: (half-edge, -1) across it, or (-1, point) along.

    The half-edge runs from the right of the segment to its left; the point may be b.
    """
    h = out[a]
    begin = h
    while twin[h] >= 0:  # clockwise to the hull, or once around
        h = following[twin[h]]
        if h == begin:
            break
    begin = h
    while True:
        across = following[h]
        x = origin[across]
        y = origin[following[across]]
        side_x = _turn(points, a, b, x)
        side_y = _turn(points, a, b, y)
        if side_x < 0 and side_y > 0:
            return across, -1
        if side_x == 0 and _ahead(points, a, b, x):
            return -1, x
        if side_y == 0 and _ahead(points, a, b, y):
            return -1, y
        h = twin[following[across]]
        if h < 0 or h == begin:
            return -1, -1


@kernel
def _ahead(points: Floats, a: int, b: int, x: int) -> bool:
    """Whether x, on the line from a to b, lies on b's side of a."""
    if points[a, 0] != points[b, 0]:
        return (points[b, 0] > points[a, 0]) == (points[x, 0] > points[a, 0])
    return (points[b, 1] > points[a, 1]) == (points[x, 1] > points[a, 1])


@kernel
def insert_walls(
    points: Floats, ends: Ints, count: int, origin: Ints, following: Ints, twin: Ints,
    label: Ints, out: Ints,
) -> tuple[int, int, int]:  # fmt: skip
    """Makes every wall i, from point i to point `ends[i]`, an edge, and labels its half-edges.

    The half-edge from point i gets the label i, its twin `SOLID`. Returns (-1, -1, -1), or what
    is wrong: (wall, another wall it crosses or repeats, -1), (wall, -1, point on it), or else
    (wall, -1, -1) for one whose left side is outside the hull. Edges that cross a wall are flipped
    away [Sloan1993].
    """
    crossing = np.empty(count, np.int64)
    stack = np.empty(count, np.int64)
    waiting = np.zeros(count, np.bool_)
    outward = -1
    for wall in range(ends.shape[0]):
        a = wall
        b = ends[wall]
        across, point = _leave(points, origin, following, twin, out, a, b)
        if across < 0 and point != b:
            return wall, -1, point
        waits = 0
        flips = 0
        while across >= 0:
            g = twin[across]
            if label[across] != NO_WALL:
                return wall, max(label[across], label[g]), -1
            crossing[flips] = across
            flips += 1
            far = following[following[g]]
            z = origin[far]
            if z == b:
                break
            side = _turn(points, a, b, z)
            if side == 0:
                return wall, -1, z
            across = following[g] if side > 0 else far
        head = 0
        while flips > 0:
            h = crossing[head]
            head = (head + 1) % count
            flips -= 1
            g = twin[h]
            c = origin[following[following[h]]]
            d = origin[following[following[g]]]
            if _turn(points, c, d, origin[h]) * _turn(points, c, d, origin[g]) < 0:
                _flip(origin, following, twin, out, h)
                apart = c != a and c != b and d != a and d != b
                if not (apart and _turn(points, a, b, c) * _turn(points, a, b, d) < 0):
                    if not waiting[h]:
                        stack[waits] = h
                        waiting[h] = True
                        waits += 1
                    continue
            crossing[(head + flips) % count] = h
            flips += 1
        # The wall is an edge now: find its half-edge among those leaving a.
        h = _half_edge(origin, following, twin, out, a, b)
        if h < 0:  # looks out of the hull; a crossing found later says more
            outward = wall
            continue
        if label[h] != NO_WALL:
            other = label[h] if label[h] >= 0 else label[twin[h]]
            return wall, other, -1
        label[h] = wall
        if twin[h] >= 0:
            label[twin[h]] = SOLID
        _make_delaunay(points, origin, following, twin, out, label, stack, waiting, waits)
    return outward, -1, -1


@kernel
def _half_edge(origin: Ints, following: Ints, twin: Ints, out: Ints, a: int, b: int) -> int:
    """The half-edge from a to b, an edge; -1 where only its twin exists, on the hull."""
    h = out[a]
    begin = h
    while twin[h] >= 0:
        h = following[twin[h]]
        if h == begin:
            break
    begin = h
    while True:
        if origin[following[h]] == b:
            return h
        h = twin[following[following[h]]]
        if h < 0 or h == begin:
            return -1
