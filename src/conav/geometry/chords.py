"""Chords of a floor: straight pieces from a vertex to a vertex or a wall, and how they cross.

Chord i lies on the line from row `tails[i]` to row `heads[i]` of `points`, from vertex `starts[i]`
on, in that direction; it ends at vertex `ends[i]`, or, where that is -1, at the inside of wall
`walls[i]`, which it meets from the left. No vertex and no wall touches a chord between its ends.
All signs are exact.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.predicates import direction_turn, orientation, orientation_products

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


class Chords(NamedTuple):
    """Chords by column; `views` has a bit for each viewpoint that sees one side of it only."""

    tails: Ints
    heads: Ints
    starts: Ints
    ends: Ints
    walls: Ints
    views: NDArray[np.int64]


@kernel
def side_of_line(points: Floats, tail: int, head: int, row: int) -> int:
    """1 where a row of `points` lies left of a line, -1 right, 0 on it."""
    return orientation(
        points[tail, 0], points[tail, 1], points[head, 0], points[head, 1],
        points[row, 0], points[row, 1],
    )  # fmt: skip


@kernel
def side_of_end(points: Floats, wall_ends: Ints, chords: Chords, line: int, other: int) -> int:
    """On which side of chord `line`'s line the other chord ends."""
    tail = chords.tails[line]
    head = chords.heads[line]
    if chords.ends[other] >= 0:
        return side_of_line(points, tail, head, chords.ends[other])
    # The end is c + s (d - c) on the wall from c to d, c right of the other chord and d left.
    c = chords.walls[other]
    d = wall_ends[c]
    t = chords.tails[other]
    h = chords.heads[other]
    return orientation_products(points, (tail, head, c), (t, h, d), (tail, head, d), (t, h, c))


@kernel
def chords_cross(points: Floats, wall_ends: Ints, chords: Chords, i: int, j: int) -> bool:
    """Whether two chords cross between their ends. Chords that only touch do so at their ends."""
    side = side_of_line(points, chords.tails[i], chords.heads[i], chords.starts[j])
    if side == 0 or side_of_end(points, wall_ends, chords, i, j) != -side:
        return False
    side = side_of_line(points, chords.tails[j], chords.heads[j], chords.starts[i])
    return side != 0 and side_of_end(points, wall_ends, chords, j, i) == -side


@kernel
def order_on_chord(points: Floats, chords: Chords, i: int, j: int, k: int) -> int:
    """-1 where chord i, from its start, crosses chord j before chord k; 1 after; 0 at one point."""
    order = _order_on_line(points, chords, chords.tails[i], chords.heads[i], j, k)
    first = side_of_line(points, chords.tails[j], chords.heads[j], chords.starts[i])
    second = side_of_line(points, chords.tails[k], chords.heads[k], chords.starts[i])
    return order * first * second


@kernel
def order_on_wall(
    points: Floats, wall_ends: Ints, chords: Chords, wall: int, j: int, k: int
) -> int:
    """-1 where chord j ends on a wall before chord k, from the wall's start; 1 after; 0 with it."""
    return _order_on_line(points, chords, wall, wall_ends[wall], j, k)


@kernel
def _order_on_line(points: Floats, chords: Chords, tail: int, head: int, j: int, k: int) -> int:
    """The order of two crossings along a line, if it crosses both chords from the same side.

    Chord j crosses the line at part A / (A - B) of the way from tail to head, A and B their sides
    of chord j; so the difference of two parts has the sign of A' B - A B' over both denominators.
    """
    tj, hj = chords.tails[j], chords.heads[j]
    tk, hk = chords.tails[k], chords.heads[k]
    return orientation_products(
        points, (tk, hk, tail), (tj, hj, head), (tj, hj, tail), (tk, hk, head)
    )


@kernel
def turn_between(points: Floats, chords: Chords, i: int, j: int) -> int:
    """1 where chord j points left of chord i's direction, -1 right, 0 where they are parallel."""
    return direction_turn(
        points, chords.tails[i], chords.heads[i], chords.tails[j], chords.heads[j]
    )


@kernel
def find_crossings(points: Floats, wall_ends: Ints, chords: Chords, begin: int) -> Ints:
    """The pairs i < j of crossing chords with j >= begin, shape (crossings, 2). Exact.

    Boxes that hold chords, however ends are rounded, save most tests.
    """
    n = chords.starts.shape[0]
    boxes = np.empty((n, 4))
    for i in range(n):
        box = boxes[i]
        row = chords.starts[i]
        box[0] = box[2] = points[row, 0]
        box[1] = box[3] = points[row, 1]
        a = chords.ends[i]
        b = a
        if a < 0:
            a = chords.walls[i]
            b = wall_ends[a]
        for row in (a, b):
            box[0] = min(box[0], points[row, 0])
            box[1] = min(box[1], points[row, 1])
            box[2] = max(box[2], points[row, 0])
            box[3] = max(box[3], points[row, 1])
    pairs = np.empty((4 * n + 16, 2), np.int64)
    count = 0
    for j in range(begin, n):
        for i in range(j):
            if (
                boxes[i, 0] > boxes[j, 2]
                or boxes[j, 0] > boxes[i, 2]
                or boxes[i, 1] > boxes[j, 3]
                or boxes[j, 1] > boxes[i, 3]
            ):
                continue
            if chords_cross(points, wall_ends, chords, i, j):
                if count == pairs.shape[0]:
                    larger = np.empty((2 * count, 2), np.int64)
                    for k in range(count):
                        larger[k, 0] = pairs[k, 0]
                        larger[k, 1] = pairs[k, 1]
                    pairs = larger
                pairs[count, 0] = i
                pairs[count, 1] = j
                count += 1
    return pairs[:count].copy()


@kernel
def find_root(parents: Ints, node: int) -> int:
    """The representative of a node in a forest of parents, which is made flatter on the way."""
    while parents[node] != node:
        parents[node] = parents[parents[node]]
        node = parents[node]
    return node
