"""The cells into which the views of several viewpoints part a floor, exactly.

A cell is a piece of floor that no window runs through: each viewpoint sees all of it or none of it
with some width. Cells come from the arrangement of all windows as chords; where rings hang
together by no chord, edges of the triangulation are added as chords that nobody sees, so that
every cell has one border, without holes. The border is walked, floor on the left, over nodes:
vertices with chords, places where chords end on walls, and crossings of chords. Which chord comes
next at a node, which crossing comes first on a chord and which points coincide are exact signs of
given points (`conav.geometry.chords`); computed coordinates decide nothing.

Unions of cells answer what regions are hidden from a team, and which of them hang together.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.errors import InputError
from conav.geometry.arrangement import arrange, on_one_wall
from conav.geometry.chords import Chords, find_crossings, find_root, side_of_line
from conav.geometry.triangulation import Triangulation
from conav.geometry.visibility import WINDOW, VisibilityPolygon, window_ends

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

MOST_VIEWS = 62
NO_CELL = -1


class ViewCells(NamedTuple):
    """The cells of several views. Bit i of a number stands for view i.

    Pieces are the parts of chords between nodes, each between two cells. Half-edge 2 p runs along
    piece p, its left cell `left[p]`; 2 p + 1 runs back. The other half-edges
    run along rings.
    """

    n_cells: int
    seen_by: Ints  # (n_cells,) the views each cell is part of
    areas: Floats  # (n_cells,) [m^2], rounded
    left: Ints  # (pieces,) the cell on the left
    right: Ints  # (pieces,) the cell on the right
    changes: Ints  # (pieces,) the views that see one side only; 0 for an added chord
    cells: Ints  # (half-edges,) the cell of each half-edge
    following: Ints  # (half-edges,) the next one on the cell's border
    nodes: Ints  # (half-edges,) the node where it starts
    node_points: Floats  # (nodes, 2) [m], rounded
    node_places: Ints  # (nodes,) 2 v at vertex v, 2 w + 1 on wall w, -1 off the rings


def view_cells(floor: Triangulation, views: Sequence[VisibilityPolygon]) -> ViewCells:
    """The cells of the views, up to 62 visibility polygons on this floor.

    A viewpoint off the floor sees no cell. Raises `InputError` for more views.

    >>> from conav.geometry.triangulation import triangulate
    >>> from conav.geometry.visibility import visibility_polygon
    >>> corner = triangulate([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], [0, 6])
    >>> cells = view_cells(corner, [visibility_polygon(corner, *p) for p in [(2, 1), (1, 2)]])
    >>> sorted(zip(cells.seen_by.tolist(), cells.areas.tolist()))
    [(1, 1.0), (2, 1.0), (3, 1.0)]
    """
    if len(views) > MOST_VIEWS:
        raise InputError("views", f"are {len(views)}", f"give at most {MOST_VIEWS}")
    n = len(floor.vertices)
    viewpoints = np.array([view.viewpoint for view in views]).reshape(-1, 2)
    points = np.concatenate((floor.vertices, viewpoints))
    size = sum(len(view.walls) for view in views)
    columns = np.empty((5, size), np.int64)
    owners = np.empty(size, np.int64)
    # For each view a vertex from which it sees a wall start, or else to which it sees one end.
    anchors = np.full((len(views), 2), -1, np.int64)
    count = 0
    for i, view in enumerate(views):
        count = _add_windows(
            floor.vertices, *view.viewpoint, view.vertices, view.hit_walls, view.walls,
            n + i, 1 << i, columns, owners, count, anchors[i],
        )  # fmt: skip
    tails, heads, starts, ends, walls = columns[:, :count].copy()
    windows = Chords(tails, heads, starts, ends, walls, owners[:count].copy())
    chords = _without_copies(points, windows)
    pairs = find_crossings(points, floor.wall_ends, chords, 0)
    added = _missing_links(
        floor.rings, floor.triangles.reshape(-1), floor.twins.reshape(-1), chords, pairs
    )
    if len(added):
        tails, heads = added.T
        fields = (tails, heads, tails, heads, np.full(len(added), -1), np.zeros(len(added), int))
        every = Chords(*map(np.concatenate, zip(chords, fields, strict=True)))
        more = find_crossings(points, floor.wall_ends, every, len(chords.starts))
        chords, pairs = every, np.concatenate((pairs, more))
    if len(chords.starts) == 0:
        return _one_cell(floor, views)
    return ViewCells(*arrange(points, floor.wall_ends, floor.rings, chords, pairs, anchors))


def join_cells(cells: ViewCells, chosen: NDArray[np.bool_]) -> Ints:
    """A label per cell, shape (n_cells,): one for chosen cells that hang together, -1 for others.

    `chosen` has shape (n_cells,). Labels count from 0 in the order of each one's first cell. Cells
    hang together along pieces; those that only meet at a point do not.
    """
    return _join(cells.left, cells.right, chosen)


def shadows(cells: ViewCells) -> Ints:
    """The shadow each cell is part of, shape (n_cells,); -1 for cells that some viewpoint sees.

    A shadow is a region that no viewpoint sees; shadows count from 0 in the order of their first
    cells. As in `conav.geometry.hidden_regions`, sight without width parts no shadows.
    """
    return join_cells(cells, cells.seen_by == 0)


def cell_border(floor: Triangulation, cells: ViewCells, cell: int) -> Floats:
    """The border of a cell, counter-clockwise, shape (k, 2) [m]; it may touch itself."""
    if len(cells.left) == 0:
        return floor.vertices.copy()
    border: list[Floats] = []
    begin = int(np.flatnonzero(cells.cells == cell)[0])
    h = begin
    while True:
        border.append(cells.node_points[cells.nodes[h]])
        after = int(cells.following[h])
        if h >= 2 * len(cells.left):
            # Along the ring: the vertices without chords.
            node, end_node = int(cells.nodes[h]), int(cells.nodes[after])
            end = int(cells.node_places[end_node])
            v = int(cells.node_places[node]) // 2
            here = on_one_wall(cells.node_places, node, end_node)
            while not here:
                v = int(floor.wall_ends[v])
                if end == 2 * v:
                    break
                border.append(floor.vertices[v])
                here = end == 2 * v + 1
        h = after
        if h == begin:
            return np.array(border)


def _one_cell(floor: Triangulation, views: Sequence[VisibilityPolygon]) -> ViewCells:
    """All of a floor with one ring of which every viewpoint sees all or nothing."""
    seen_by = sum(1 << i for i, view in enumerate(views) if len(view.walls) > 0)
    x, y = (floor.vertices - floor.vertices[0]).T
    area = float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2.0
    none = np.empty(0, np.int64)
    return ViewCells(
        1, np.array([seen_by], np.int64), np.array([area]), none, none, np.empty(0, np.int64),
        none, none, none, np.empty((0, 2)), none,
    )  # fmt: skip


@kernel
def _add_windows(
    vertices: Floats, x: float, y: float, corner_vertices: Ints, hit_walls: Ints, walls: Ints,
    row: int, view: int, columns: Ints, owners: Ints, count: int, anchor: Ints,
) -> int:  # fmt: skip
    """The new count of chords with the windows of a view; and its anchor."""
    k = walls.shape[0]
    sides = np.empty(k, np.int64)
    near = np.empty(k, np.int64)
    far = np.empty(k, np.int64)
    outward = np.empty(k, np.bool_)
    windows = window_ends(vertices, x, y, corner_vertices, walls, sides, near, far, outward)
    for w in range(windows):
        columns[0, count] = row
        columns[1, count] = corner_vertices[near[w]]
        columns[2, count] = corner_vertices[near[w]]
        columns[3, count] = corner_vertices[far[w]]
        columns[4, count] = hit_walls[far[w]]
        owners[count] = view
        count += 1
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


def _without_copies(points: Floats, chords: Chords) -> Chords:
    """The chords, those that are the same piece of floor made one.

    Between its ends a chord meets neither vertex nor wall, so two that overlap are the same piece:
    they join the same vertices, or lead from one vertex along one line to one wall.
    """
    at_vertex = chords.ends >= 0
    one = np.where(at_vertex, np.minimum(chords.starts, chords.ends), chords.starts)
    two = np.where(at_vertex, np.maximum(chords.starts, chords.ends), -1 - chords.walls)
    order = np.lexsort((two, one))
    kept = np.ones(len(order), np.bool_)
    views = chords.views.copy()
    _merge_copies(points, chords, order, one, two, kept, views)
    columns = (column[kept] for column in (*chords[:5], views))
    return Chords(*columns)


@kernel
def _merge_copies(
    points: Floats, chords: Chords, order: Ints, one: Ints, two: Ints, kept: NDArray[np.bool_],
    views: Ints,
) -> None:  # fmt: skip
    for first in range(order.shape[0]):
        i = order[first]
        if not kept[i]:
            continue
        for second in range(first + 1, order.shape[0]):
            j = order[second]
            if one[j] != one[i] or two[j] != two[i]:
                break
            if (
                kept[j]
                and chords.ends[i] < 0
                and side_of_line(points, chords.tails[i], chords.heads[i], chords.tails[j]) != 0
            ):
                continue
            if kept[j]:
                kept[j] = False
                views[i] ^= views[j]


@kernel
def _missing_links(rings: Ints, corners: Ints, twins: Ints, chords: Chords, pairs: Ints) -> Ints:
    """Sides of triangles, rows of two vertices, that join rings which hang together by no chord."""
    parents = np.arange(rings[-1] + 1)
    for i in range(chords.starts.shape[0]):
        end = chords.ends[i] if chords.ends[i] >= 0 else chords.walls[i]
        parents[find_root(parents, rings[chords.starts[i]])] = find_root(parents, rings[end])
    for p in range(pairs.shape[0]):
        one = find_root(parents, rings[chords.starts[pairs[p, 0]]])
        parents[one] = find_root(parents, rings[chords.starts[pairs[p, 1]]])
    added = np.empty((rings[-1], 2), np.int64)
    count = 0
    for h in range(corners.shape[0]):
        if twins[h] > h:
            one = find_root(parents, rings[corners[h]])
            other = find_root(parents, rings[corners[twins[h]]])
            if one != other:
                parents[one] = other
                added[count, 0] = corners[h]
                added[count, 1] = corners[twins[h]]
                count += 1
    return added[:count].copy()


@kernel
def _join(left: Ints, right: Ints, chosen: NDArray[np.bool_]) -> Ints:
    n = chosen.shape[0]
    parents = np.arange(n)
    for p in range(left.shape[0]):
        a, b = left[p], right[p]
        if chosen[a] and chosen[b]:
            parents[find_root(parents, a)] = find_root(parents, b)
    labels = np.full(n, NO_CELL, np.int64)
    of_root = np.full(n, -1, np.int64)
    count = 0
    for cell in range(n):
        if chosen[cell]:
            root = find_root(parents, cell)
            if of_root[root] < 0:
                of_root[root] = count
                count += 1
            labels[cell] = of_root[root]
    return labels
