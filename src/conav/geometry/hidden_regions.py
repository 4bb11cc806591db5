"""The hidden regions of one viewpoint, from its windows and the order of corners along the rings.

What a viewpoint does not see falls into regions. A visibility polygon has no holes, so the border
of a region that faces it is one closed walk: back along a window, on along the ring it comes to,
floor on the left, to the next corner of the polygon, back along the window that ends there. No
point is computed on the way and no polygon cut, so which windows share a region is exact.

A line of sight without width is no part of the polygon and parts no regions here: regions may be
larger than the floor that is truly unseen, never smaller.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.compiled import kernel
from conav.geometry.chords import find_root
from conav.geometry.point_grid import ON_VERTEX, OUTSIDE, locate
from conav.geometry.predicates import orientation
from conav.geometry.sight_lines import AT_VERTEX, REACHED, follow
from conav.geometry.triangulation import Triangulation
from conav.geometry.visibility import WINDOW, VisibilityPolygon, exact_coordinate

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

NOT_HIDDEN = -1


class HiddenRegions(NamedTuple):
    """The regions a viewpoint does not see, numbered from 0 in the order of their first windows.

    A place on the rings is a number: 2 v for vertex v, 2 v + 1 for the inside of wall v.
    """

    seen: VisibilityPolygon
    n_regions: int
    regions: Ints  # (k,) the region beyond each side of the polygon, NOT_HIDDEN beyond walls
    following: Ints  # (k,) the window after each one on its region's walk, -1 for walls
    order: Ints  # (k,) corners in the order of the rings
    places: Ints  # (k,) the place of each of these, growing


def hidden_regions(floor: Triangulation, seen: VisibilityPolygon) -> HiddenRegions:
    """The hidden regions of a viewpoint, given its visibility polygon on this floor.

    No regions where everything is seen, nor for a viewpoint off the floor.

    >>> from conav.geometry.triangulation import triangulate
    >>> from conav.geometry.visibility import visibility_polygon
    >>> outer, hole = [(0, 0), (9, 0), (9, 9), (0, 9)], [(3, 3), (3, 6), (6, 6), (6, 3)]
    >>> floor = triangulate(outer + hole, [0, 4, 8])
    >>> hidden_regions(floor, visibility_polygon(floor, 1, 4)).n_regions  # two windows, one region
    1
    """
    k = len(seen.walls)
    places = np.where(seen.vertices >= 0, 2 * seen.vertices, 2 * seen.hit_walls + 1)
    order = np.argsort(places, kind="stable")
    places = places[order]
    following = np.empty(k, np.int64)
    regions = np.full(k, NOT_HIDDEN, np.int64)
    count = _walk(
        floor.vertices, floor.rings, *seen.viewpoint, seen.through, seen.walls, order, places,
        following, regions,
    )  # fmt: skip
    return HiddenRegions(seen, count, regions, following, order, places)


@kernel
def _walk(
    vertices: Floats, rings: Ints, x: float, y: float, through: Ints, walls: Ints, order: Ints,
    places: Ints, following: Ints, regions: Ints,
) -> int:  # fmt: skip
    """The number of regions; fills the last two arrays, and puts hits on one wall in order."""
    k = walls.shape[0]
    # Hits on one wall follow each other counter-clockwise around the viewpoint, as corners do; but
    # the polygon may begin between two of them.
    begin = 0
    while begin < k:
        end = begin + 1
        while end < k and places[end] == places[begin]:
            a = through[order[end - 1]]
            b = through[order[end]]
            if _turn(vertices, x, y, a, b) < 0:
                break
            end += 1
        split = end
        while end < k and places[end] == places[begin]:
            end += 1
        for _ in range(split, end):  # once or twice around a few hits
            last = order[end - 1]
            for i in range(end - 1, begin, -1):
                order[i] = order[i - 1]
            order[begin] = last
        begin = end
    # A ring is a run of places; after its last corner comes its first.
    first = 0
    for i in range(k):
        ring = rings[places[i] // 2]
        if rings[places[first] // 2] != ring:
            first = i
        last = i + 1 == k or rings[places[i + 1] // 2] != ring
        after = order[first] if last else order[i + 1]
        side = order[i]
        if walls[side] == WINDOW:
            following[side] = after - 1 if after > 0 else k - 1
        else:
            following[side] = -1
    count = 0
    for i in range(k):
        if walls[i] == WINDOW and regions[i] == NOT_HIDDEN:
            side = i
            while regions[side] == NOT_HIDDEN:
                regions[side] = count
                side = following[side]
            count += 1
    return count


@kernel
def _turn(vertices: Floats, x: float, y: float, a: int, b: int) -> int:
    return orientation(x, y, vertices[a, 0], vertices[a, 1], vertices[b, 0], vertices[b, 1])


def hidden_rings(floor: Triangulation, hidden: HiddenRegions) -> Ints:
    """The hidden region each ring lies in, shape (rings,); `NOT_HIDDEN` for rings partly seen.

    Exact. Rays from every hidden vertex, towards the viewpoint and away from it, end at walls of
    the same region; together they reach every ring of a region.
    """
    labels = np.full(int(floor.rings[-1]) + 1, NOT_HIDDEN, np.int64)
    if len(set(floor.rings[hidden.places // 2].tolist())) < len(labels) and hidden.n_regions > 0:
        _label_rings(
            floor.vertices, floor.triangles.reshape(-1), floor.twins.reshape(-1), floor.wall_edges,
            floor.rings, hidden.seen.through, *hidden.seen.viewpoint, hidden.n_regions,
            hidden.regions, hidden.order,
            hidden.places, labels,
        )  # fmt: skip
    return labels


def regions_at(floor: Triangulation, hidden: HiddenRegions, points: ArrayLike) -> Ints:
    """The hidden region of each point, rows of (x, y) [m]; `NOT_HIDDEN` if seen or off the floor.

    Exact; a point that is seen along a line without width counts as seen. From a hidden point
    towards the viewpoint no window is crossed before a wall, for windows lead to the viewpoint too;
    and the ring of that wall knows its region.
    """
    at = np.array(points, dtype=np.float64).reshape(-1, 2)
    for row in at:
        row[:] = exact_coordinate(row[0]), exact_coordinate(row[1])
    found = np.full(len(at), NOT_HIDDEN, np.int64)
    if hidden.n_regions > 0:
        _regions_at(
            floor.vertices, floor.triangles.reshape(-1), floor.twins.reshape(-1), floor.rings,
            hidden.seen.through, *floor.grid, *hidden.seen.viewpoint, hidden.regions, hidden.order,
            hidden.places, hidden_rings(floor, hidden), at, found,
        )  # fmt: skip
    return found


@kernel
def _region_along(
    vertices: Floats, rings: Ints, through: Ints, x: float, y: float, regions: Ints, order: Ints,
    places: Ints, place: int, px: float, py: float,
) -> int:  # fmt: skip
    """The region along the ring where the line from the viewpoint through p meets it at a place.

    -1 where the ring has no corners or is seen there.
    """
    ring = rings[place // 2]
    k = places.shape[0]
    i = 0  # of the first corner there or beyond
    last = k
    while i < last:
        middle = (i + last) // 2
        if places[middle] < place:
            i = middle + 1
        else:
            last = middle
    while i < k and places[i] == place:
        # Of the hits on this wall, those that come before on it lie clockwise.
        a = through[order[i]]
        if a >= 0 and orientation(x, y, vertices[a, 0], vertices[a, 1], px, py) < 0:
            break
        i += 1
    i -= 1
    if i < 0 or rings[places[i] // 2] != ring:
        # Before the ring's first corner: as after its last one.
        i += 1
        if i == k or rings[places[i] // 2] != ring:
            return NOT_HIDDEN
        while i + 1 < k and rings[places[i + 1] // 2] == ring:
            i += 1
    return regions[order[i]]


@kernel
def _label_rings(
    vertices: Floats, corners: Ints, twins: Ints, wall_edges: Ints, rings: Ints, through: Ints,
    x: float, y: float, count: int, regions: Ints, order: Ints, places: Ints, labels: Ints,
) -> None:  # fmt: skip
    """Fills `labels` as `hidden_rings` returns them, by uniting regions and rings on one ray."""
    n = vertices.shape[0]
    is_corner = np.zeros(n, np.bool_)
    with_corners = np.zeros(labels.shape[0], np.bool_)
    for place in places:
        with_corners[rings[place // 2]] = True
        if place % 2 == 0:
            is_corner[place // 2] = True
    # Nodes: the regions, then the rings that are wholly hidden.
    parents = np.arange(count + labels.shape[0])
    for v in range(n):
        if is_corner[v]:
            continue
        vx, vy = vertices[v, 0], vertices[v, 1]
        node = _node(
            vertices, rings, through, x, y, regions, order, places, with_corners, count,
            2 * v, vx, vy,
        )  # fmt: skip
        for away in range(2):
            if away == 0:
                kind, at, _ = follow(
                    vertices, corners, twins, ON_VERTEX, wall_edges[v], vx, vy, x, y, True
                )
            else:
                kind, at, _ = follow(
                    vertices, corners, twins, ON_VERTEX, wall_edges[v], x, y, vx, vy, False
                )
            if kind == REACHED:  # seen after all, along a line without width
                break
            place = 2 * at if kind == AT_VERTEX else 2 * at + 1
            if place != 2 * v:
                other = _node(
                    vertices, rings, through, x, y, regions, order, places, with_corners, count,
                    place, vx, vy,
                )  # fmt: skip
                parents[find_root(parents, other)] = find_root(parents, node)
    for region in range(count):
        root = find_root(parents, region)
        for ring in range(labels.shape[0]):
            if not with_corners[ring] and find_root(parents, count + ring) == root:
                labels[ring] = region


@kernel
def _node(
    vertices: Floats, rings: Ints, through: Ints, x: float, y: float, regions: Ints, order: Ints,
    places: Ints, with_corners: NDArray[np.bool_], count: int, place: int, px: float, py: float,
) -> int:  # fmt: skip
    if with_corners[rings[place // 2]]:
        return _region_along(
            vertices, rings, through, x, y, regions, order, places, place, px, py
        )  # fmt: skip
    return count + rings[place // 2]


@kernel
def _regions_at(
    vertices: Floats, corners: Ints, twins: Ints, rings: Ints, through: Ints, frame: Floats,
    cell_starts: Ints, cell_triangles: Ints, x: float, y: float, regions: Ints, order: Ints,
    places: Ints, ring_labels: Ints, points: Floats, found: Ints,
) -> None:  # fmt: skip
    for i in range(points.shape[0]):
        px, py = points[i, 0], points[i, 1]
        place, start = locate(vertices, corners, frame, cell_starts, cell_triangles, px, py)
        if place == OUTSIDE or (px == x and py == y):
            continue
        kind, at, _ = follow(vertices, corners, twins, place, start, px, py, x, y, True)
        if kind == REACHED:
            continue
        found[i] = ring_labels[rings[at]]
        if found[i] == NOT_HIDDEN:
            on_ring = 2 * at if kind == AT_VERTEX else 2 * at + 1
            found[i] = _region_along(
                vertices, rings, through, x, y, regions, order, places, on_ring, px, py
            )


def region_border(floor: Triangulation, hidden: HiddenRegions, region: int) -> list[Floats]:
    """The border of a hidden region, rings of points [m], the region on their left; the walk first.

    The walk runs counter-clockwise where the region lies inside it. It may touch itself at
    vertices. The rings after it are those that lie wholly in the region. Hits are rounded.
    """
    seen = hidden.seen
    k = len(seen.walls)
    rank = np.empty(k, np.int64)
    rank[hidden.order] = np.arange(k)
    start = int(np.flatnonzero(hidden.regions == region)[0])
    walk: list[Floats] = []
    side = start
    while True:
        walk += [seen.corners[(side + 1) % k], seen.corners[side]]
        next_side = int(hidden.following[side])
        end = (next_side + 1) % k
        # The vertices of the ring between the two corners.
        from_wall = int(max(seen.vertices[side], seen.hit_walls[side]))
        on_one_wall = seen.hit_walls[end] == from_wall and rank[side] < rank[end]
        if not on_one_wall:
            v = int(floor.wall_ends[from_wall])
            while v != seen.vertices[end]:
                walk.append(floor.vertices[v])
                if v == seen.hit_walls[end]:
                    break
                v = int(floor.wall_ends[v])
        side = next_side
        if side == start:
            break
    inside = np.flatnonzero(hidden_rings(floor, hidden) == region)
    return [np.array(walk), *(floor.vertices[floor.rings == ring] for ring in inside)]
