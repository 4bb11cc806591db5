"""Straight lines on a floor: who sees whom, and where a ray ends. All decisions exact.

Sight is closed: a sees b when the segment between them stays on the floor, walls and vertices
included. So one sees along a wall, and between two walls that touch the line from either side.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.errors import InputError
from conav.geometry.point_grid import ON_SIDE, ON_VERTEX, OUTSIDE, locate
from conav.geometry.predicates import orientation
from conav.geometry.triangulation import Triangulation
from conav.geometry.visibility import exact_coordinate, expand, polygon_size

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

REACHED = 0  # the line came to its end point
AT_VERTEX = 1  # the floor ends at a vertex
AT_WALL = 2  # the floor ends at a wall, between its ends


class RayEnd(NamedTuple):
    """Where a ray ends: at `vertex`, or `parameter` of the way along `wall`; both -1 off the floor.

    `point` is (x, y) [m], rounded for a wall.
    """

    vertex: int
    wall: int
    parameter: float  # 0 at the start of the wall to 1 at its end; 0 for a vertex
    point: tuple[float, float]


def sees(floor: Triangulation, a: tuple[float, float], b: tuple[float, float]) -> bool:
    """Whether the closed segment from a to b [m] stays on the floor; `False` for ends off it.

    >>> from conav.geometry.triangulation import triangulate
    >>> corner = triangulate([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], [0, 6])
    >>> sees(corner, (2, 0), (0, 2)), sees(corner, (2, 0.5), (0.5, 2))
    (True, False)
    """
    ax, ay = exact_coordinate(a[0]), exact_coordinate(a[1])
    bx, by = exact_coordinate(b[0]), exact_coordinate(b[1])
    arrays = _flat(floor)
    place, start = locate(*arrays[:2], *floor.grid, ax, ay)
    if place == OUTSIDE:
        return False
    if ax == bx and ay == by:
        return True
    return bool(follow(*arrays, place, start, ax, ay, bx, by, True)[0] == REACHED)


def shoot_ray(
    floor: Triangulation, start: tuple[float, float], through: tuple[float, float]
) -> RayEnd:
    """Where the ray from `start` through another point [m] leaves the floor for the first time.

    The ray passes by the other point where it sees it. Raises `InputError` where the two are one.
    """
    ax, ay = exact_coordinate(start[0]), exact_coordinate(start[1])
    bx, by = exact_coordinate(through[0]), exact_coordinate(through[1])
    if ax == bx and ay == by:
        raise InputError("ray", f"has no direction: twice ({ax:g}, {ay:g})", "give two points")
    arrays = _flat(floor)
    place, at = locate(*arrays[:2], *floor.grid, ax, ay)
    if place == OUTSIDE:
        return RayEnd(-1, -1, 0.0, (ax, ay))
    kind, index, parameter = follow(*arrays, place, at, ax, ay, bx, by, False)
    return _ray_end(floor, kind, index, parameter, (ax, ay))


def shoot_ray_from_vertex(
    floor: Triangulation, viewpoint: tuple[float, float], vertex: int
) -> RayEnd:
    """Where the ray from a viewpoint [m] through a vertex it sees ends, begun at the vertex.

    The vertex itself where the floor ends there. Raises `InputError` for the vertex's own place.
    """
    ax, ay = exact_coordinate(viewpoint[0]), exact_coordinate(viewpoint[1])
    bx, by = floor.vertices[vertex].tolist()
    if ax == bx and ay == by:
        raise InputError("ray", f"has no direction: twice ({ax:g}, {ay:g})", "give two points")
    at = int(floor.wall_edges[vertex])
    kind, index, parameter = follow(*_flat(floor), ON_VERTEX, at, ax, ay, bx, by, False)
    return _ray_end(floor, kind, index, parameter, (bx, by))


def visible_vertices(floor: Triangulation, x: float, y: float) -> NDArray[np.bool_]:
    """Which vertices the point (x, y) [m] sees, shape (n,); none where it is off the floor."""
    seen = np.zeros(len(floor.vertices), np.bool_)
    size = polygon_size(len(seen))
    _see_vertices(
        *_flat(floor), floor.wall_ends, floor.wall_edges, *floor.grid,
        exact_coordinate(x), exact_coordinate(y),
        np.empty((size, 3)), np.empty((size, 4), np.int64), seen,
    )  # fmt: skip
    return seen


def vertex_visibility(floor: Triangulation) -> NDArray[np.bool_]:
    """Which vertices see each other, shape (n, n), symmetric; each sees itself."""
    seen = np.zeros((len(floor.vertices), len(floor.vertices)), np.bool_)
    _see_all_pairs(*_flat(floor), floor.wall_ends, floor.wall_edges, *floor.grid, seen)
    return seen


def _flat(floor: Triangulation) -> tuple[Floats, Ints, Ints]:
    return floor.vertices, floor.triangles.reshape(-1), floor.twins.reshape(-1)


def _ray_end(
    floor: Triangulation, kind: int, index: int, parameter: float, start: tuple[float, float]
) -> RayEnd:
    if kind == REACHED:
        return RayEnd(-1, -1, 0.0, start)
    if kind == AT_VERTEX:
        x, y = floor.vertices[index].tolist()
        return RayEnd(index, -1, 0.0, (x, y))
    (ax, ay), (bx, by) = floor.vertices[[index, floor.wall_ends[index]]].tolist()
    point = (ax + parameter * (bx - ax), ay + parameter * (by - ay))
    return RayEnd(-1, index, parameter, point)


@kernel
def follow(
    vertices: Floats, corners: Ints, twins: Ints, place: int, start: int,
    ax: float, ay: float, bx: float, by: float, to_end: bool,
) -> tuple[int, int, float]:  # fmt: skip
    """How the line from a towards b ends, at which vertex or wall, and how far along the wall.

    (`REACHED`, -1, 0), (`AT_VERTEX`, vertex, 0) or (`AT_WALL`, wall, part of the way along it).
    With `to_end` it may end at b, else it goes on to where the floor ends. It starts at a, whose
    place is `place` and half-edge `start` (from `locate`); or at a vertex on the line behind a,
    `place` `ON_VERTEX` and `start` a half-edge that leaves it.
    """
    h = start
    at_vertex = place == ON_VERTEX
    if not at_vertex:
        at_vertex, h = _leave_place(vertices, corners, twins, place, start, ax, ay, bx, by)
        if h < 0:  # off the floor at once, from a wall
            return AT_WALL, -1 - twins[start], _part(vertices, corners, start, ax, ay, bx, by)
        if at_vertex and to_end and _is_past(vertices, corners[h], ax, ay, bx, by):
            return REACHED, -1, 0.0
    while True:
        p = corners[h]
        if at_vertex:
            if to_end and vertices[p, 0] == bx and vertices[p, 1] == by:
                return REACHED, -1, 0.0
            at_vertex, h = _leave_vertex(vertices, corners, twins, h, ax, ay, bx, by)
            if h < 0:
                return AT_VERTEX, p, 0.0
        else:
            q = corners[_next(h)]
            px, py = vertices[p, 0], vertices[p, 1]
            if to_end and orientation(px, py, vertices[q, 0], vertices[q, 1], bx, by) >= 0:
                return REACHED, -1, 0.0
            if twins[h] < 0:
                return AT_WALL, -1 - twins[h], _part(vertices, corners, h, ax, ay, bx, by)
            at_vertex, h = _leave_side(vertices, corners, twins, h, ax, ay, bx, by)
        if at_vertex and to_end and _is_past(vertices, corners[h], ax, ay, bx, by):
            return REACHED, -1, 0.0


# The line is at a vertex, `at_vertex` with a half-edge that leaves it, or about to go through the
# inside of a side, from its left to its right. The next three say where it is next.


@kernel
def _leave_place(
    vertices: Floats, corners: Ints, twins: Ints, place: int, start: int,
    ax: float, ay: float, bx: float, by: float,
) -> tuple[bool, int]:  # fmt: skip
    """From inside a triangle or a side; (False, -1) from a wall off the floor."""
    if place == ON_SIDE:
        u = corners[start]
        w = corners[_next(start)]
        wx, wy = vertices[w, 0], vertices[w, 1]
        side = orientation(vertices[u, 0], vertices[u, 1], wx, wy, bx, by)
        if side == 0:
            return True, _next(start) if _beyond(ax, ay, bx, by, ax, ay, wx, wy) else start
        if side > 0:
            return _through(vertices, corners, start, ax, ay, bx, by)
        if twins[start] < 0:
            return False, -1
        return _through(vertices, corners, twins[start], ax, ay, bx, by)
    h = start
    for _ in range(3):
        p = corners[h]
        px, py = vertices[p, 0], vertices[p, 1]
        side = orientation(ax, ay, bx, by, px, py)
        if side == 0 and _beyond(ax, ay, bx, by, ax, ay, px, py):
            return True, h
        q = corners[_next(h)]
        if side < 0 and orientation(ax, ay, bx, by, vertices[q, 0], vertices[q, 1]) > 0:
            return False, h
        h = _next(h)
    return False, -1  # never: the line leaves the triangle


@kernel
def _leave_side(
    vertices: Floats, corners: Ints, twins: Ints, h: int,
    ax: float, ay: float, bx: float, by: float,
) -> tuple[bool, int]:  # fmt: skip
    """Through side h, which is no wall."""
    return _through(vertices, corners, twins[h], ax, ay, bx, by)


@kernel
def _through(
    vertices: Floats, corners: Ints, g: int, ax: float, ay: float, bx: float, by: float
) -> tuple[bool, int]:
    """On through the triangle that the line has come into over its side g."""
    far = _next(_next(g))
    p = corners[far]
    side = orientation(ax, ay, bx, by, vertices[p, 0], vertices[p, 1])
    if side == 0:
        return True, far
    return False, _next(g) if side > 0 else far


@kernel
def _leave_vertex(
    vertices: Floats, corners: Ints, twins: Ints, start: int,
    ax: float, ay: float, bx: float, by: float,
) -> tuple[bool, int]:  # fmt: skip
    """On from the vertex that half-edge `start` leaves; (False, -1) where the floor ends there."""
    h = start
    while twins[h] >= 0:  # clockwise to the wall that leaves the vertex
        h = _next(twins[h])
    v = corners[h]
    vx, vy = vertices[v, 0], vertices[v, 1]
    p = corners[_next(h)]
    right = orientation(ax, ay, bx, by, vertices[p, 0], vertices[p, 1])
    if right == 0 and _beyond(ax, ay, bx, by, vx, vy, vertices[p, 0], vertices[p, 1]):
        return True, _next(h)
    while h >= 0:
        back = _next(_next(h))
        p = corners[back]
        left = orientation(ax, ay, bx, by, vertices[p, 0], vertices[p, 1])
        if left == 0 and _beyond(ax, ay, bx, by, vx, vy, vertices[p, 0], vertices[p, 1]):
            return True, back
        if right < 0 and left > 0:
            return False, _next(h)
        right = left
        h = twins[back]
    return False, -1


@kernel
def _next(h: int) -> int:
    """The half-edge after h around its triangle."""
    return h + 1 if h % 3 < 2 else h - 2


@kernel
def _beyond(
    ax: float, ay: float, bx: float, by: float, px: float, py: float, qx: float, qy: float
) -> bool:
    """Whether q lies farther than p in the direction from a to b; all four are on one line."""
    if ax != bx:
        return qx > px if bx > ax else qx < px
    return qy > py if by > ay else qy < py


@kernel
def _is_past(vertices: Floats, v: int, ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether vertex v, on the line from a to b, is beyond b."""
    return _beyond(ax, ay, bx, by, bx, by, vertices[v, 0], vertices[v, 1])


@kernel
def _part(
    vertices: Floats, corners: Ints, h: int, ax: float, ay: float, bx: float, by: float
) -> float:
    """How far along side h the line from a through b crosses it, 0 to 1."""
    p = corners[h]
    q = corners[_next(h)]
    dx = bx - ax
    dy = by - ay
    right = (vertices[p, 0] - ax) * dy - (vertices[p, 1] - ay) * dx
    left = dx * (vertices[q, 1] - ay) - dy * (vertices[q, 0] - ax)
    if right + left > 0.0:
        return min(max(right / (right + left), 0.0), 1.0)
    return 0.5


@kernel
def _see_vertices(
    vertices: Floats, corners: Ints, twins: Ints, wall_ends: Ints, wall_edges: Ints,
    frame: Floats, cell_starts: Ints, cell_triangles: Ints, x: float, y: float,
    out: Floats, facts: Ints, seen: NDArray[np.bool_],
) -> None:  # fmt: skip
    _, count = expand(
        vertices, corners, twins, wall_ends, frame, cell_starts, cell_triangles, x, y, out, facts
    )
    for i in range(count):
        if facts[i, 0] >= 0:
            seen[facts[i, 0]] = True
    for i in range(count):
        v = facts[i, 0]
        if v < 0:
            continue
        vx, vy = vertices[v, 0], vertices[v, 1]
        if vx == x and vy == y:
            continue
        if facts[i - 1 if i > 0 else count - 1, 2] == v or facts[(i + 1) % count, 2] == v:
            continue  # the ray goes on to a wall, over no vertex
        # Beyond its last vertex a ray may go on without width. From a vertex that was seen
        # already the ray is followed for that one.
        at_vertex = True
        h = wall_edges[v]
        while True:
            if at_vertex:
                at_vertex, h = _leave_vertex(vertices, corners, twins, h, x, y, vx, vy)
            elif twins[h] >= 0:
                at_vertex, h = _leave_side(vertices, corners, twins, h, x, y, vx, vy)
            else:
                break
            if h < 0:
                break
            if at_vertex:
                if seen[corners[h]]:
                    break
                seen[corners[h]] = True


@kernel
def _see_all_pairs(
    vertices: Floats, corners: Ints, twins: Ints, wall_ends: Ints, wall_edges: Ints,
    frame: Floats, cell_starts: Ints, cell_triangles: Ints, seen: NDArray[np.bool_],
) -> None:  # fmt: skip
    out = np.empty((2 * vertices.shape[0], 3))
    facts = np.empty((2 * vertices.shape[0], 4), np.int64)
    for v in range(vertices.shape[0]):
        _see_vertices(
            vertices, corners, twins, wall_ends, wall_edges, frame, cell_starts, cell_triangles,
            vertices[v, 0], vertices[v, 1], out, facts, seen[v],
        )  # fmt: skip
