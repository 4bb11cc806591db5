"""The windows of viewpoints as chords of their floor, kept in one table for kernels.

Kernels that part a floor by the views of a team take a table and the numbers of its viewpoints, so
asking about another team copies nothing.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.chords import Chords, find_crossings, find_root, order_on_wall
from conav.geometry.triangulation import Triangulation
from conav.geometry.visibility import WINDOW, VisibilityPolygon, window_ends

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Scalar = TypeVar("Scalar", bound=np.generic)


class ViewTable:
    """Viewpoints on one floor with their windows; viewpoint i is row n + i of `points`.

    Arrays have room for more than what is in them.
    """

    def __init__(self, floor: Triangulation) -> None:
        self.floor = floor
        self.count = 0
        self.points: Floats = np.empty((len(floor.vertices) + 8, 2))
        self.points[: len(floor.vertices)] = floor.vertices
        self.starts: Ints = np.zeros(9, np.int64)  # where the windows of each viewpoint begin
        self.windows: Ints = np.empty((64, 3), np.int64)  # near vertex, far vertex, far wall
        # Of each view a vertex from which it sees a wall start, or else to which it sees one end.
        self.anchors: Ints = np.full((8, 2), -1, np.int64)

    def add(self, view: VisibilityPolygon) -> int:
        """The number of the viewpoint whose visibility polygon this is."""
        number = self.count
        self.count += 1
        n = len(self.floor.vertices)
        if self.count > len(self.anchors):
            self.points = _longer(self.points, n + 2 * self.count)
            self.starts = _longer(self.starts, 2 * self.count + 1)
            more = np.full((2 * self.count - len(self.anchors), 2), -1, np.int64)
            self.anchors = np.concatenate((self.anchors, more))
        begin = int(self.starts[number])
        if begin + len(view.walls) > len(self.windows):
            self.windows = _longer(self.windows, 2 * (begin + len(view.walls)))
        self.points[n + number] = view.viewpoint
        self.starts[number + 1] = begin + _add_windows(
            self.floor.vertices, *view.viewpoint, view.vertices, view.hit_walls, view.walls,
            self.windows[begin:], self.anchors[number],
        )  # fmt: skip
        return number


def _longer(array: NDArray[Scalar], length: int) -> NDArray[Scalar]:
    longer = np.empty((length, *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer


@kernel
def _add_windows(
    vertices: Floats, x: float, y: float, corner_vertices: Ints, hit_walls: Ints, walls: Ints,
    windows: Ints, anchor: Ints,
) -> int:  # fmt: skip
    """How many windows were written; finds the view's anchor too."""
    k = walls.shape[0]
    sides = np.empty(k, np.int64)
    near = np.empty(k, np.int64)
    far = np.empty(k, np.int64)
    outward = np.empty(k, np.bool_)
    count = window_ends(vertices, x, y, corner_vertices, walls, sides, near, far, outward)
    for w in range(count):
        windows[w, 0] = corner_vertices[near[w]]
        windows[w, 1] = corner_vertices[far[w]]
        windows[w, 2] = hit_walls[far[w]]
    for i in range(k):
        # The ring on from a vertex, or back from one. Every view has such a side: beside a window
        # there is a wall at its near vertex.
        if walls[i] != WINDOW:
            j = i + 1 if i + 1 < k else 0
            if corner_vertices[i] >= 0:
                anchor[0] = corner_vertices[i]
                anchor[1] = -1
                break
            if corner_vertices[j] >= 0:
                anchor[1] = corner_vertices[j]
    return count


@kernel
def chords_of(
    points: Floats, wall_ends: Ints, starts: Ints, windows: Ints, viewpoints: Ints
) -> Chords:
    """The windows of these viewpoints of a table, the i-th one's with bit i; copies made one.

    They are sorted by the vertices and walls that they join, whoever they are of.

    Between its ends a window meets neither vertex nor wall, so two that overlap are the same piece
    of floor: they join the same vertices, or lead from one vertex along one line to one wall.
    """
    n = wall_ends.shape[0]
    count = 0
    for i in range(viewpoints.shape[0]):
        count += starts[viewpoints[i] + 1] - starts[viewpoints[i]]
    columns = np.empty((6, count), np.int64)
    at = 0
    for i in range(viewpoints.shape[0]):
        for w in range(starts[viewpoints[i]], starts[viewpoints[i] + 1]):
            columns[0, at] = n + viewpoints[i]
            columns[1, at] = columns[2, at] = windows[w, 0]
            columns[3, at] = windows[w, 1]
            columns[4, at] = windows[w, 2]
            columns[5, at] = 1 << i
            at += 1
    every = Chords(columns[0], columns[1], columns[2], columns[3], columns[4], columns[5])
    return merge_copies(points, wall_ends, every)[0]


@kernel
def merge_copies(points: Floats, wall_ends: Ints, every: Chords) -> tuple[Chords, Ints]:
    """The chords with those that are one piece of floor made one; the new row of each.

    Of copies the first is kept, with the bits of views in which an odd number of them has a one.
    """
    n = wall_ends.shape[0]
    count = every.starts.shape[0]
    keys = np.empty(count, np.int64)
    for i in range(count):
        near = every.starts[i]
        far = every.ends[i]
        if far >= 0:
            keys[i] = min(near, far) * (2 * n) + max(near, far)
        else:
            keys[i] = near * (2 * n) + n + every.walls[i]
    order = np.argsort(keys, kind="mergesort")
    kept = np.empty((6, count), np.int64)
    row_of = np.empty(count, np.int64)
    total = 0
    begin = 0
    while begin < count:
        end = begin + 1
        while end < count and keys[order[end]] == keys[order[begin]]:
            end += 1
        wall = every.walls[order[begin]] if every.ends[order[begin]] < 0 else -1
        if wall >= 0:
            for second in range(begin + 1, end):
                i = order[second]
                k = second
                while k > begin:
                    if order_on_wall(points, wall_ends, every, wall, order[k - 1], i) <= 0:
                        break
                    order[k] = order[k - 1]
                    k -= 1
                order[k] = i
        for k in range(begin, end):
            i = order[k]
            if k > begin and (
                wall < 0 or order_on_wall(points, wall_ends, every, wall, order[k - 1], i) == 0
            ):
                kept[5, total - 1] ^= every.views[i]
            else:
                kept[0, total] = every.tails[i]
                kept[1, total] = every.heads[i]
                kept[2, total] = every.starts[i]
                kept[3, total] = every.ends[i]
                kept[4, total] = every.walls[i]
                kept[5, total] = every.views[i]
                total += 1
            row_of[i] = total - 1
        begin = end
    chords = Chords(
        kept[0, :total].copy(), kept[1, :total].copy(), kept[2, :total].copy(),
        kept[3, :total].copy(), kept[4, :total].copy(), kept[5, :total].copy(),
    )  # fmt: skip
    return chords, row_of


@kernel
def linked_chords(
    points: Floats, wall_ends: Ints, rings: Ints, corners: Ints, twins: Ints, chords: Chords
) -> tuple[Chords, Ints]:
    """The chords, with sides of triangles where rings hang together by no chord; the crossings.

    `corners` and `twins` are those of the triangulation, flat.
    """
    pairs = find_crossings(points, wall_ends, chords, 0)
    parents = np.arange(rings[-1] + 1)
    for i in range(chords.starts.shape[0]):
        end = chords.ends[i] if chords.ends[i] >= 0 else chords.walls[i]
        parents[find_root(parents, rings[chords.starts[i]])] = find_root(parents, rings[end])
    for p in range(pairs.shape[0]):
        one = find_root(parents, rings[chords.starts[pairs[p, 0]]])
        parents[one] = find_root(parents, rings[chords.starts[pairs[p, 1]]])
    tails = np.empty(rings[-1], np.int64)
    heads = np.empty(rings[-1], np.int64)
    count = 0
    for h in range(corners.shape[0]):
        if twins[h] > h and count < rings[-1]:
            one = find_root(parents, rings[corners[h]])
            other = find_root(parents, rings[corners[twins[h]]])
            if one != other:
                parents[one] = other
                tails[count] = corners[h]
                heads[count] = corners[twins[h]]
                count += 1
    if count == 0:
        return chords, pairs
    tails, heads = tails[:count], heads[:count]
    every = Chords(
        np.concatenate((chords.tails, tails)),
        np.concatenate((chords.heads, heads)),
        np.concatenate((chords.starts, tails)),
        np.concatenate((chords.ends, heads)),
        np.concatenate((chords.walls, np.full(count, -1, np.int64))),
        np.concatenate((chords.views, np.zeros(count, np.int64))),
    )
    more = find_crossings(points, wall_ends, every, chords.starts.shape[0])
    return every, np.concatenate((pairs, more))
