"""The constrained Delaunay triangulation of a floor: an outer ring and holes, in metres.

Every point of the rings is a corner, every wall a side, and no other points are made. Which points
and walls meet where is decided exactly, so rings that cross or touch are found and refused.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.compiled import kernel
from conav.errors import InputError
from conav.geometry.delaunay import NO_WALL, SOLID, insert_walls, triangulate_points
from conav.geometry.point_grid import Grid, make_grid
from conav.geometry.predicates import GREATEST, LEAST

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


class Triangulation(NamedTuple):
    """A triangulated floor; floor is what lies inside the outer ring and outside the holes.

    Wall i runs from vertex i to vertex `wall_ends[i]`, the floor on its left. Half-edge 3 t + s
    runs from corner s of triangle t to the next one. Arrays are locked.
    """

    vertices: Floats  # (n, 2) [m]
    wall_ends: Ints  # (n,) the vertex after each one in its ring
    rings: Ints  # (n,) the ring of each vertex; 0 is the outer one
    triangles: Ints  # (m, 3) vertices, counter-clockwise
    twins: Ints  # (m, 3) the half-edge on the other side, or -1 - i for wall i
    wall_edges: Ints  # (n,) the half-edge along each wall
    grid: Grid  # for point location

    @property
    def neighbours(self) -> Ints:
        """The triangle beyond each side, -1 for none, shape (m, 3)."""
        return np.where(self.twins >= 0, self.twins // 3, -1).astype(np.int64)

    @property
    def constrained(self) -> NDArray[np.bool_]:
        """Whether each side is a wall, shape (m, 3)."""
        return self.twins < 0


def triangulate(vertices: ArrayLike, ring_starts: ArrayLike) -> Triangulation:
    """The triangulation of the floor inside ring 0 and outside the other rings.

    Ring i is `vertices[ring_starts[i] : ring_starts[i + 1]]`, `vertices` of shape (n, 2) [m],
    `ring_starts` (rings + 1,), starting with 0 and ending with n. The outer ring runs
    counter-clockwise, holes clockwise. Points on straight walls are kept.

    Raises `InputError` where rings cross, touch, run the wrong way or lie outside each other, and
    for coordinates that are not finite or beyond the exact range. Those smaller than 1e-60 m count
    as 0.

    The points are joined by a sweep, walls are put in by flips [Sloan1993], and edges flipped
    [Lawson1977] where they are surely not Delaunay: of four corners that are nearly on a circle
    either diagonal may be there, the same one on every machine.

    >>> square = triangulate([(0, 0), (2, 0), (2, 2), (0, 2)], [0, 4])
    >>> square.triangles.shape, int(square.constrained.sum())
    ((2, 3), 4)
    """
    points, starts = _checked(vertices, ring_starts)
    n = len(points)
    sizes = np.diff(starts)
    rings = np.repeat(np.arange(len(sizes), dtype=np.int64), sizes)
    ends = np.arange(1, n + 1, dtype=np.int64)
    ends[starts[1:] - 1] = starts[:-1]
    order = np.lexsort((points[:, 1], points[:, 0])).astype(np.int64)
    same = np.flatnonzero((points[order[1:]] == points[order[:-1]]).all(axis=1))
    if len(same):
        one, two = sorted(order[same[0] : same[0] + 2].tolist())
        raise InputError(
            _vertex(points, rings, two), f"is the same point as vertex {one}", "part the rings"
        )
    count, origin, following, twin, label, out = triangulate_points(points, order)
    if count == 0:
        raise InputError("rings", "all points lie on one line", "give rings with an inside")
    wall, other, point = insert_walls(points, ends, count, origin, following, twin, label, out)
    if point >= 0:
        place = _vertex(points, rings, point)
        raise InputError(place, f"lies on wall {wall}", "part the rings, or split the wall there")
    if other >= 0:
        raise InputError(_vertex(points, rings, wall), f"its wall meets wall {other}", "part them")
    free, leak = _flood(count, following, twin, label)
    if wall >= 0 or leak >= 0:
        at = wall if wall >= 0 else _any_vertex_of(leak, following, label, origin)
        raise InputError(
            _vertex(points, rings, at),
            "the floor is not on the left of the walls around it",
            "turn the outer ring counter-clockwise and holes clockwise; put holes inside it",
        )
    triangles, twins, wall_edges = _keep_free(n, count, origin, following, twin, label, free)
    for array in (points, ends, rings, triangles, twins, wall_edges):
        array.flags.writeable = False
    return Triangulation(
        points, ends, rings, triangles, twins, wall_edges, make_grid(points, triangles)
    )


def _checked(vertices: ArrayLike, ring_starts: ArrayLike) -> tuple[Floats, NDArray[np.int64]]:
    points = np.array(vertices, dtype=np.float64, order="C", copy=True) + 0.0
    starts = np.asarray(ring_starts, dtype=np.int64)
    if points.ndim != 2 or points.shape[1] != 2:
        raise InputError("vertices", f"have the shape {points.shape}", "give (x, y) rows")
    if starts.ndim != 1 or len(starts) < 2 or starts[0] != 0 or starts[-1] != len(points):
        raise InputError("ring_starts", "do not run from 0 to the number of vertices")
    short = np.flatnonzero(np.diff(starts) < 3)
    if len(short):
        raise InputError(f"ring {short[0]}", "has fewer than 3 points", "give three or more")
    size = np.abs(points)
    points[size < LEAST] = 0.0
    bad = np.flatnonzero(~((size < LEAST) | ((size >= LEAST) & (size <= GREATEST))).all(axis=1))
    if len(bad):
        x, y = points[bad[0]].tolist()
        raise InputError(
            f"vertex {bad[0]}",
            f"({x:g}, {y:g}) is no point that can be computed with exactly",
            f"give coordinates up to {GREATEST:g} m",
        )
    return points, starts


def _vertex(points: Floats, rings: Ints, vertex: int) -> str:
    x, y = points[vertex].tolist()
    return f"vertex {vertex} at ({x:.9g}, {y:.9g}) of ring {rings[vertex]}"


def _any_vertex_of(h: int, following: Ints, label: Ints, origin: Ints) -> int:
    """The vertex at the start of half-edge h, which the flood should not have reached."""
    return int(origin[following[h]]) if label[h] == SOLID else int(origin[h])


@kernel
def _flood(count: int, following: Ints, twin: Ints, label: Ints) -> tuple[NDArray[np.bool_], int]:
    """Which half-edges bound free triangles, and a half-edge where the flood leaks or -1.

    The flood starts on the left of every wall and crosses every side that is none. It leaks where
    it reaches the right side of a wall or the hull's outside.
    """
    free = np.zeros(count, np.bool_)
    stack = np.empty(count, np.int64)
    waits = 0
    for h in range(count):
        if label[h] >= 0 and not free[h]:
            free[h] = True
            stack[waits] = h
            waits += 1
            while waits > 0:
                waits -= 1
                edge = stack[waits]
                for _ in range(3):
                    free[edge] = True
                    if label[edge] == SOLID or (label[edge] == NO_WALL and twin[edge] < 0):
                        return free, edge
                    if label[edge] == NO_WALL and not free[twin[edge]]:
                        free[twin[edge]] = True
                        stack[waits] = twin[edge]
                        waits += 1
                    edge = following[edge]
    return free, -1


@kernel
def _keep_free(
    n: int, count: int, origin: Ints, following: Ints, twin: Ints, label: Ints,
    free: NDArray[np.bool_],
) -> tuple[Ints, Ints, Ints]:  # fmt: skip
    """The free triangles, their twins and the half-edge along each wall, numbered anew."""
    number = np.full(count, -1, np.int64)
    kept = 0
    for h in range(count):
        if free[h] and number[h] < 0:
            edge = h
            for _ in range(3):
                number[edge] = kept
                kept += 1
                edge = following[edge]
    triangles = np.empty((kept // 3, 3), np.int64)
    twins = np.empty((kept // 3, 3), np.int64)
    corners = triangles.reshape(-1)
    beyond = twins.reshape(-1)
    wall_edges = np.empty(n, np.int64)
    for h in range(count):
        if free[h]:
            new = number[h]
            corners[new] = origin[h]
            if label[h] >= 0:
                beyond[new] = -1 - label[h]
                wall_edges[label[h]] = new
            else:
                beyond[new] = number[twin[h]]
    return triangles, twins, wall_edges
