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
from conav.geometry.chords import find_root
from conav.geometry.triangulation import Triangulation
from conav.geometry.view_chords import ViewTable, chords_of, linked_chords
from conav.geometry.visibility import VisibilityPolygon

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
    table = ViewTable(floor)
    for view in views:
        table.add(view)
    return cells_of_table(table, np.arange(len(views)))


def cells_of_table(table: ViewTable, viewpoints: Ints) -> ViewCells:
    """The cells of these viewpoints' views, up to 62, by their numbers in the table."""
    floor = table.floor
    areas, seen_by, *others = part_floor(
        table.points, floor.wall_ends, floor.rings, floor.triangles.reshape(-1),
        floor.twins.reshape(-1), table.starts, table.windows, table.anchors, viewpoints,
    )  # fmt: skip
    return ViewCells(len(areas), seen_by, areas, *others)


@kernel
def part_floor(
    points: Floats, wall_ends: Ints, rings: Ints, corners: Ints, twins: Ints, starts: Ints,
    windows: Ints, anchors: Ints, viewpoints: Ints,
) -> tuple[Floats, Ints, Ints, Ints, Ints, Ints, Ints, Ints, Floats, Ints]:  # fmt: skip
    """Areas of cells, and the fields of `ViewCells` from `seen_by` on without them.

    Arrays of a `ViewTable` and of its triangulation; `viewpoints` are numbers of the table.
    """
    chords = chords_of(points, wall_ends, starts, windows, viewpoints)
    linked, pairs = linked_chords(points, wall_ends, rings, corners, twins, chords)
    if linked.starts.shape[0] == 0:
        return _one_cell(points, wall_ends, anchors, viewpoints)
    return arrange(points, wall_ends, rings, linked, pairs, anchors[viewpoints])


@kernel
def _one_cell(
    points: Floats, wall_ends: Ints, anchors: Ints, viewpoints: Ints
) -> tuple[Floats, Ints, Ints, Ints, Ints, Ints, Ints, Ints, Floats, Ints]:
    """All of a floor with one ring of which every viewpoint sees all or nothing."""
    seen_by = 0
    for i in range(viewpoints.shape[0]):
        if max(anchors[viewpoints[i], 0], anchors[viewpoints[i], 1]) >= 0:
            seen_by |= 1 << i
    ox, oy = points[0]
    twice = 0.0
    for v in range(wall_ends.shape[0]):
        ax, ay = points[v]
        bx, by = points[wall_ends[v]]
        twice += (ax - ox) * (by - oy) - (ay - oy) * (bx - ox)
    none = np.empty(0, np.int64)
    return (
        np.array([twice / 2.0]), np.array([seen_by]), none, none, none, none, none, none,
        np.empty((0, 2)), none,
    )  # fmt: skip


def join_cells(cells: ViewCells, chosen: NDArray[np.bool_]) -> Ints:
    """A label per cell, shape (n_cells,): one for chosen cells that hang together, -1 for others.

    `chosen` has shape (n_cells,). Labels count from 0 in the order of each one's first cell. Cells
    hang together along pieces; those that only meet at a point do not.
    """
    return join(cells.left, cells.right, chosen)


def shadows(cells: ViewCells, viewers: int | None = None) -> Ints:
    """The shadow each cell is part of, shape (n_cells,); -1 for cells that some viewpoint sees.

    A shadow is a region that none of the viewpoints sees whose bits `viewers` has; by default none
    at all. They count from 0 in the order in which they are met along the rings, then along
    windows sorted by vertices and walls. So a number means the same in any cells that have the
    windows of these viewers, whatever other views they are parted by. As in
    `conav.geometry.hidden_regions`, sight without width parts no shadows.
    """
    mask = (1 << MOST_VIEWS) - 1 if viewers is None else viewers
    return number_shadows(
        cells.seen_by, cells.left, cells.right, cells.changes, cells.cells, cells.following,
        cells.nodes, cells.node_places, mask,
    )  # fmt: skip


def cell_border(floor: Triangulation, cells: ViewCells, cell: int) -> Floats:
    """The border of a cell, counter-clockwise, shape (k, 2) [m]; it may touch itself."""
    if len(cells.left) == 0:
        return floor.vertices.copy()
    begin = int(np.flatnonzero(cells.cells == cell)[0])
    return border_from(
        begin, floor.vertices, floor.wall_ends, cells.following, cells.nodes, cells.node_points,
        cells.node_places, 2 * len(cells.left),
    )  # fmt: skip


@kernel
def border_from(
    begin: int, points: Floats, wall_ends: Ints, following: Ints, nodes: Ints,
    node_points: Floats, places: Ints, along_rings: int,
) -> Floats:  # fmt: skip
    """The border of the cell of a half-edge; those from `along_rings` on run along rings."""
    border = np.empty((64, 2))
    count = 0
    h = begin
    while True:
        after = following[h]
        v = -1
        node = nodes[h]
        while True:
            # The node, then, along the ring, the vertices without chords.
            if count == border.shape[0]:
                longer = np.empty((2 * count, 2))
                longer[:count] = border
                border = longer
            if v < 0:
                border[count] = node_points[node]
                here = h < along_rings or on_one_wall(places, node, nodes[after])
                v = places[node] // 2
            else:
                border[count] = points[v]
                here = places[nodes[after]] == 2 * v + 1
            count += 1
            if here:
                break
            v = wall_ends[v]
            if places[nodes[after]] == 2 * v:
                break
        h = after
        if h == begin:
            return border[:count].copy()


@kernel
def number_shadows(
    seen_by: Ints, left: Ints, right: Ints, changes: Ints, cells: Ints, following: Ints,
    nodes: Ints, places: Ints, mask: int,
) -> Ints:  # fmt: skip
    """As `shadows`, for the fields of `ViewCells` and a mask of viewers."""
    labels = join(left, right, seen_by & mask == 0)
    number_of = np.full(labels.shape[0], NO_CELL, np.int64)  # by label
    count = 0
    pieces = left.shape[0]
    if pieces == 0:
        return labels
    # Along the rings, each from the stretch that comes round to its beginning.
    begin = 2 * pieces
    for h in range(2 * pieces, cells.shape[0]):
        if h + 1 == cells.shape[0] or nodes[following[h]] != nodes[h + 1]:
            for k in range(begin - 1, h):
                label = labels[cells[h if k < begin else k]]
                if label >= 0 and number_of[label] < 0:
                    number_of[label] = count
                    count += 1
            begin = h + 1
    # Along windows: from the vertex where it starts, the smaller one where it joins two.
    first = 0
    for last in range(pieces):
        end = places[nodes[2 * last + 1]]
        if end < 0:
            continue
        backward = end % 2 == 0 and end < places[nodes[2 * first]]
        if changes[first] & mask != 0:
            for k in range(last - first + 1):
                p = last - k if backward else first + k
                for side in range(2):
                    label = labels[left[p] if (side == 0) != backward else right[p]]
                    if label >= 0 and number_of[label] < 0:
                        number_of[label] = count
                        count += 1
        first = last + 1
    for cell in range(labels.shape[0]):
        if labels[cell] >= 0:
            labels[cell] = number_of[labels[cell]]
    return labels


@kernel
def join(left: Ints, right: Ints, chosen: NDArray[np.bool_]) -> Ints:
    """As `join_cells`, for two fields of `ViewCells`."""
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
