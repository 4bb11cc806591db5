"""The visibility polygon of a point on a floor, by triangular expansion [Bungiu2014].

From the triangle that holds the point, the view is followed through the sides of triangles; a cone
of sight is bounded by two vertices, never by computed points, so every decision is an exact
orientation of three given points. Computed, and rounded, are only the coordinates of the points
where a ray through a vertex hits a wall.

The polygon is the closure of what is seen with some width (regularised): where the floor is seen
along a ray alone, between two walls that touch the ray from either side, nothing is added.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.point_grid import INSIDE, ON_SIDE, ON_VERTEX, OUTSIDE, locate
from conav.geometry.predicates import LEAST, orientation
from conav.geometry.triangulation import Triangulation

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

WINDOW = -1  # the wall of a side that is no wall
HIT = -1  # the vertex of a corner that is none


class VisibilityPolygon(NamedTuple):
    """What a point sees; side i runs from corner i to corner i + 1, counter-clockwise.

    A corner is a vertex of the floor, or the hit of a ray from the viewpoint through the vertex
    `through` on the wall `hit_walls`. A side is a piece of a wall, or a window: a piece of such a
    ray with hidden floor beyond it. Empty where the viewpoint is not on the floor.
    """

    viewpoint: tuple[float, float]  # [m]
    place: int  # of the viewpoint: INSIDE, ON_SIDE, ON_VERTEX of a triangle, or OUTSIDE
    corners: Floats  # (k, 2) [m]
    vertices: Ints  # (k,) or HIT
    hit_walls: Ints  # (k,) the wall a hit lies on, -1 for vertices
    through: Ints  # (k,) the vertex the ray of a hit passes last, -1 for vertices
    walls: Ints  # (k,) the wall of each side or WINDOW
    parameters: Floats  # (k,) of hits: 0 at the start of the wall to 1 at its end; 0 for vertices

    @property
    def area(self) -> float:
        """Of the polygon [m^2]."""
        if len(self.corners) == 0:
            return 0.0
        x, y = (self.corners - np.array(self.viewpoint)).T
        return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2.0


class Windows(NamedTuple):
    """The windows of a visibility polygon, counter-clockwise.

    Window i runs along a ray from the viewpoint from vertex `near`, where a wall ends the view on
    one side, to its far end: vertex `far_vertices`, or the point `far_parameters` of the way along
    wall `far_walls`. Hidden floor lies on its right or its left, looking away from the viewpoint.
    """

    sides: Ints  # (w,) the side of the polygon
    near: Ints  # (w,) a vertex
    far_vertices: Ints  # (w,) a vertex or HIT
    far_walls: Ints  # (w,) the wall of the hit or -1
    far_parameters: Floats  # (w,) 0 at the start of the wall to 1 at its end; 0 for a vertex
    hidden_right: NDArray[np.bool_]  # (w,)


def visibility_polygon(floor: Triangulation, x: float, y: float) -> VisibilityPolygon:
    """What the point (x, y) [m] sees; empty where it is not on the floor.

    Walls do not block the view along them, and points on walls and vertices see as they should.
    Coordinates smaller than 1e-60 m count as 0.

    >>> from conav.geometry.triangulation import triangulate
    >>> corner = triangulate([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], [0, 6])
    >>> seen = visibility_polygon(corner, 1.5, 0.75)
    >>> seen.corners[seen.vertices == HIT].tolist(), seen.area
    ([[0.0, 1.5]], 2.25)
    """
    x, y = exact_coordinate(x), exact_coordinate(y)
    size = polygon_size(len(floor.vertices))
    corners = np.empty((size, 3))
    facts = np.empty((size, 4), np.int64)
    place, count = expand(
        floor.vertices,
        floor.triangles.reshape(-1),
        floor.twins.reshape(-1),
        floor.wall_ends,
        floor.grid.frame,
        floor.grid.starts,
        floor.grid.triangles,
        x,
        y,
        corners,
        facts,
    )
    out = corners[:count]
    vertices, hit_walls, through, walls = facts[:count].T.copy()
    return VisibilityPolygon(
        (x, y), place, out[:, :2].copy(), vertices, hit_walls, through, walls, out[:, 2].copy()
    )


def exact_coordinate(value: float) -> float:
    """The coordinate, or 0 where it is too small for exact signs."""
    return float(value) if abs(value) >= LEAST or value != value else 0.0


def polygon_size(n: int) -> int:
    """The most corners a visibility polygon on a floor of n vertices can have."""
    # A corner is a vertex, once, or a hit, and every vertex has one hit beyond it at most.
    return 2 * n


@kernel
def expand(
    vertices: Floats,
    corners: Ints,
    twins: Ints,
    wall_ends: Ints,
    frame: Floats,
    cell_starts: Ints,
    cell_triangles: Ints,
    x: float,
    y: float,
    out: Floats,
    facts: Ints,
) -> tuple[int, int]:
    """Where the viewpoint lies, and how many corners of its polygon were written to `out`.

    Arrays of a `Triangulation`, `corners` and `twins` flat (3 m,); `out` (size, 3) gets
    x, y and parameter, `facts` (size, 4) the columns `vertices`, `hit_walls`, `through` and `walls`
    of `VisibilityPolygon`; size from `polygon_size`.
    """
    place, start = locate(vertices, corners, frame, cell_starts, cell_triangles, x, y)
    if place == OUTSIDE:
        return OUTSIDE, 0
    # Cones to follow: the half-edge the cone leaves through, its right and its left vertex. Those
    # that wait branched off triangles on one ray, which are different ones.
    pending = np.empty((corners.shape[0] // 3 + 4, 3), np.int64)
    # The vertex nearer to the viewpoint on the same ray that bounds the same cone, or -1. Written
    # for every vertex before it is read.
    nearer = np.empty(vertices.shape[0], np.int64)
    waiting = _first_cones(corners, twins, place, start, pending, nearer)
    h = 0
    right = 0
    left = 0
    count = 0
    first_right = -1
    first_wall = -1
    last_left = -1
    last_wall = -1
    while waiting > 0:
        waiting -= 1
        h = pending[waiting, 0]
        right = pending[waiting, 1]
        left = pending[waiting, 2]
        while twins[h] >= 0:
            g = twins[h]
            s = g % 3
            to_left = g + 2 if s == 0 else g - 1  # from the far corner to the left end of h
            to_right = g - 2 if s == 2 else g + 1  # from the right end of h to the far corner
            far = corners[to_left]
            fx = vertices[far, 0]
            fy = vertices[far, 1]
            side = orientation(x, y, vertices[right, 0], vertices[right, 1], fx, fy)
            if side < 0:
                h = to_left
                continue
            if side == 0:
                nearer[far] = right
                right = far
                h = to_left
                continue
            side = orientation(x, y, vertices[left, 0], vertices[left, 1], fx, fy)
            h = to_right
            if side < 0:
                nearer[far] = -1
                pending[waiting, 0] = to_left
                pending[waiting, 1] = far
                pending[waiting, 2] = left
                waiting += 1
                left = far
            elif side == 0:
                nearer[far] = left
                left = far
        wall = -1 - twins[h]
        if first_wall < 0:
            first_right = right
            first_wall = wall
        else:
            count = _turn_corner(
                vertices, wall_ends, nearer, x, y, last_left, last_wall, right, wall,
                out, facts, count,
            )  # fmt: skip
        last_left = left
        last_wall = wall
    count = _turn_corner(
        vertices, wall_ends, nearer, x, y, last_left, last_wall, first_right, first_wall,
        out, facts, count,
    )  # fmt: skip
    return place, count


@kernel
def _first_cones(
    corners: Ints, twins: Ints, place: int, start: int, pending: Ints, nearer: Ints
) -> int:
    """How many cones around the viewpoint were put on the stack, the first one last."""
    count = 0
    if place == ON_VERTEX:
        # Clockwise around the vertex to the wall that leaves it, then back to the other one.
        h = start
        while twins[h] >= 0:
            h = _next(twins[h])
        viewpoint = corners[h]
        first = corners[_next(h)]
        last = first
        while h >= 0:
            count = _add_cone(corners, _next(h), pending, nearer, count)
            back = _next(_next(h))
            last = corners[back]
            h = twins[back]
        # The walls beside the viewpoint lie on rays with a nearer vertex, itself.
        nearer[viewpoint] = -1
        nearer[first] = viewpoint
        nearer[last] = viewpoint
    else:
        if place == INSIDE:
            count = _add_cone(corners, start, pending, nearer, count)
        count = _add_cone(corners, _next(start), pending, nearer, count)
        count = _add_cone(corners, _next(_next(start)), pending, nearer, count)
        if place == ON_SIDE and twins[start] >= 0:
            beyond = _next(twins[start])
            count = _add_cone(corners, beyond, pending, nearer, count)
            count = _add_cone(corners, _next(beyond), pending, nearer, count)
    for i in range(count // 2):
        for column in range(3):
            low = pending[i, column]
            pending[i, column] = pending[count - 1 - i, column]
            pending[count - 1 - i, column] = low
    return count


@kernel
def _next(h: int) -> int:
    """The half-edge after h around its triangle."""
    return h + 1 if h % 3 < 2 else h - 2


@kernel
def _add_cone(corners: Ints, h: int, pending: Ints, nearer: Ints, count: int) -> int:
    right = corners[h]
    left = corners[_next(h)]
    nearer[right] = -1
    nearer[left] = -1
    pending[count, 0] = h
    pending[count, 1] = right
    pending[count, 2] = left
    return count + 1


@kernel
def _turn_corner(
    vertices: Floats, wall_ends: Ints, nearer: Ints, x: float, y: float,
    left: int, from_wall: int, right: int, to_wall: int,
    out: Floats, facts: Ints, count: int,
) -> int:  # fmt: skip
    """The new count of corners, after those from the end of one visible piece of wall to the next.

    The piece of `from_wall` is bounded on its left by the ray through `left`, the piece of
    `to_wall` on its right by the ray through `right`: one ray, or the two ends of the wall the
    viewpoint is on.
    """
    if wall_ends[from_wall] != left:
        _put_hit(vertices, wall_ends, x, y, left, from_wall, WINDOW, out, facts, count)
        count += 1
    # In to the first vertex on the ray,
    v = left
    while nearer[v] >= 0:
        _put_vertex(vertices, v, _wall_between(wall_ends, v, nearer[v]), out, facts, count)
        count += 1
        v = nearer[v]
    # and out again: the vertices on this way come last one first.
    steps = 0
    w = right
    while nearer[w] >= 0:
        w = nearer[w]
        steps += 1
    if w != v:
        _put_vertex(vertices, v, _wall_between(wall_ends, v, w), out, facts, count)
        count += 1
    w = right
    side = to_wall if to_wall == right else WINDOW
    for k in range(steps, -1, -1):
        _put_vertex(vertices, w, side, out, facts, count + k)
        if k > 0:
            side = _wall_between(wall_ends, nearer[w], w)
            w = nearer[w]
    count += steps + 1
    if to_wall != right:
        _put_hit(vertices, wall_ends, x, y, right, to_wall, to_wall, out, facts, count)
        count += 1
    return count


@kernel
def _wall_between(wall_ends: Ints, v: int, w: int) -> int:
    return v if wall_ends[v] == w else WINDOW


@kernel
def _put_vertex(
    vertices: Floats, v: int, side: int, out: Floats, facts: Ints, index: int
) -> None:  # fmt: skip
    out[index, 0] = vertices[v, 0]
    out[index, 1] = vertices[v, 1]
    out[index, 2] = 0.0
    facts[index, 0] = v
    facts[index, 1] = -1
    facts[index, 2] = -1
    facts[index, 3] = side


@kernel
def _put_hit(
    vertices: Floats, wall_ends: Ints, x: float, y: float, through: int, wall: int, side: int,
    out: Floats, facts: Ints, index: int,
) -> None:  # fmt: skip
    ax = vertices[wall, 0]
    ay = vertices[wall, 1]
    bx = vertices[wall_ends[wall], 0]
    by = vertices[wall_ends[wall], 1]
    dx = vertices[through, 0] - x
    dy = vertices[through, 1] - y
    right = (ax - x) * dy - (ay - y) * dx
    left = dx * (by - y) - dy * (bx - x)
    # The wall crosses the ray, so both are positive but for rounding.
    part = 0.5
    if right + left > 0.0:
        part = min(max(right / (right + left), 0.0), 1.0)
    out[index, 0] = ax + part * (bx - ax)
    out[index, 1] = ay + part * (by - ay)
    out[index, 2] = part
    facts[index, 0] = HIT
    facts[index, 1] = wall
    facts[index, 2] = through
    facts[index, 3] = side


def find_windows(floor: Triangulation, seen: VisibilityPolygon) -> Windows:
    """The windows of a visibility polygon of this floor, counter-clockwise."""
    k = len(seen.walls)
    corners = np.empty((3, k), np.int64)
    outward = np.empty(k, np.bool_)
    count = window_ends(
        floor.vertices,
        *seen.viewpoint,
        seen.vertices,
        seen.walls,
        corners[0],
        corners[1],
        corners[2],
        outward,
    )
    sides, near, far = corners[:, :count].copy()
    return Windows(
        sides,
        seen.vertices[near],
        seen.vertices[far],
        seen.hit_walls[far],
        seen.parameters[far],
        outward[:count].copy(),
    )


@kernel
def window_ends(
    vertices: Floats, x: float, y: float, corner_vertices: Ints, walls: Ints,
    sides: Ints, near: Ints, far: Ints, outward: NDArray[np.bool_],
) -> int:  # fmt: skip
    """How many windows; writes each one's side, near and far corner, and whether it runs outward.

    Hidden floor lies right of windows that run outward, away from the viewpoint, else left.
    """
    k = walls.shape[0]
    count = 0
    for i in range(k):
        if walls[i] != WINDOW:
            continue
        j = i + 1 if i + 1 < k else 0
        a = corner_vertices[i]
        b = corner_vertices[j]
        if a == HIT or b == HIT:
            out = b == HIT
        elif vertices[a, 0] != vertices[b, 0]:
            # One ray: the order of coordinates is the order along it.
            out = (x < vertices[a, 0]) == (vertices[a, 0] < vertices[b, 0])
        else:
            out = (y < vertices[a, 1]) == (vertices[a, 1] < vertices[b, 1])
        sides[count] = i
        near[count] = i if out else j
        far[count] = j if out else i
        outward[count] = out
        count += 1
    return count
