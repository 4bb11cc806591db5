"""The cells of a floor without holes within which a viewpoint's windows hang on the same vertices.

Two kinds of lines bound them [Guibas1999]: walls extended beyond reflex vertices, where a wall goes
out of sight, and lines that touch two reflex vertices, extended beyond both, where one of them goes
out of sight behind the other. Both are windows of vertices, so they are exact chords.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.arrangement import arrange
from conav.geometry.chords import Chords, find_crossings
from conav.geometry.inner_point import inner_point
from conav.geometry.predicates import orientation
from conav.geometry.triangulation import Triangulation
from conav.geometry.view_cells import border_from
from conav.geometry.view_chords import ViewTable, merge_copies
from conav.geometry.visibility import expand, polygon_size, visibility_polygon, window_ends

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


class CriticalCells(NamedTuple):
    """Cells, and the chords between them.

    An event is a pair of vertices: beyond the second one the first goes out of sight, and with it,
    where the two are the ends of a wall, this wall. Pieces, half-edges and nodes are as in
    `conav.geometry.view_cells.ViewCells`.
    """

    events: Ints  # (e, 2) vertices
    chord_of: Ints  # (e,) the chord of each event
    chord_ends: Ints  # (chords,) the vertex where a chord ends, -1 for a wall
    left: Ints  # (pieces,) the cell on the left
    right: Ints  # (pieces,) the cell on the right
    chords: Ints  # (pieces,) the chord that each piece is of
    cells: Ints  # (half-edges,) the cell of each half-edge
    nodes: Ints  # (half-edges,) the node where it starts
    node_points: Floats  # (nodes, 2) [m], rounded
    node_places: Ints  # (nodes,) 2 v at vertex v, 2 w + 1 on wall w, -1 off the rings
    points: Floats  # (cells, 2) [m] inside each cell
    widths: Floats  # (cells,) [m] how far that point is from the cell's border along both axes
    starts: Ints  # (cells + 1,) where the windows of each cell begin in `gaps`
    gaps: Ints  # the vertices on which windows of a viewpoint in each cell hang, growing


def critical_cells(floor: Triangulation, most: int) -> CriticalCells | None:
    """The cells of a floor with one ring and no straight vertices.

    None for a floor that is one cell, and where there are more than `most` events or lines cross
    more than ten times as often.
    """
    table = ViewTable(floor)
    for x, y in floor.vertices.tolist():
        table.add(visibility_polygon(floor, x, y))
    n = len(floor.vertices)
    events, ends = _events(floor.vertices, floor.wall_ends, table.starts[: n + 1], table.windows)
    if not 0 < len(events) <= most:
        return None
    chords, chord_of = _chords(floor.vertices, floor.wall_ends, events, ends)
    pairs = find_crossings(floor.vertices, floor.wall_ends, chords, 0)
    if len(pairs) > 10 * most:
        return None
    fields = _cells(
        floor.vertices, floor.wall_ends, floor.rings, floor.triangles.reshape(-1),
        floor.twins.reshape(-1), floor.grid.frame, floor.grid.starts, floor.grid.triangles,
        chords, pairs, np.empty((polygon_size(n), 3)), np.empty((polygon_size(n), 4), np.int64),
    )  # fmt: skip
    return CriticalCells(events, chord_of, chords.ends, *fields)


@kernel
def _chords(vertices: Floats, wall_ends: Ints, events: Ints, ends: Ints) -> tuple[Chords, Ints]:
    """The chords of events, each numbered in its field `views`; the chord of each event."""
    every = Chords(
        events[:, 0].copy(), events[:, 1].copy(), events[:, 1].copy(), ends[:, 0].copy(),
        ends[:, 1].copy(), np.zeros(events.shape[0], np.int64),
    )  # fmt: skip
    merged, chord_of = merge_copies(vertices, wall_ends, every)
    numbered = Chords(
        merged.tails, merged.heads, merged.starts, merged.ends, merged.walls,
        np.arange(merged.starts.shape[0]),
    )  # fmt: skip
    return numbered, chord_of


@kernel
def _events(vertices: Floats, wall_ends: Ints, starts: Ints, windows: Ints) -> tuple[Ints, Ints]:
    """The events; where the window of the first vertex by the second ends: far vertex and wall."""
    n = vertices.shape[0]
    before = np.empty(n, np.int64)
    for v in range(n):
        before[wall_ends[v]] = v
    events = np.empty((windows.shape[0], 2), np.int64)
    ends = np.empty((windows.shape[0], 2), np.int64)
    count = 0
    for w in range(n):
        reflex = _side(vertices, before[w], w, wall_ends[w]) < 0
        for k in range(starts[w], starts[w + 1]):
            v = windows[k, 0]
            if not (v == wall_ends[w] or v == before[w]):
                one = _side(vertices, w, v, before[w])
                two = _side(vertices, w, v, wall_ends[w])
                if not reflex or one * two < 0:
                    continue
            events[count, 0] = w
            events[count, 1] = v
            ends[count, 0] = windows[k, 1]
            ends[count, 1] = windows[k, 2]
            count += 1
    return events[:count].copy(), ends[:count].copy()


@kernel
def _side(vertices: Floats, a: int, b: int, c: int) -> int:
    return orientation(
        vertices[a, 0], vertices[a, 1], vertices[b, 0], vertices[b, 1], vertices[c, 0],
        vertices[c, 1],
    )  # fmt: skip


@kernel
def _cells(
    vertices: Floats, wall_ends: Ints, rings: Ints, corners: Ints, twins: Ints, frame: Floats,
    cell_starts: Ints, cell_triangles: Ints, chords: Chords, pairs: Ints, out: Floats, facts: Ints,
) -> tuple[Ints, Ints, Ints, Ints, Ints, Floats, Ints, Floats, Floats, Ints, Ints]:  # fmt: skip
    """The fields of `CriticalCells` from `left` on."""
    areas, _, left, right, chord_of, cells, following, nodes, node_points, places = arrange(
        vertices, wall_ends, rings, chords, pairs, np.empty((0, 2), np.int64)
    )
    n = areas.shape[0]
    begins = np.empty(n, np.int64)
    for h in range(cells.shape[0]):
        begins[cells[h]] = h
    points = np.empty((n, 2))
    widths = np.empty(n)
    starts = np.zeros(n + 1, np.int64)
    gaps = np.empty(8 * n + 16, np.int64)
    size = out.shape[0]
    numbers = np.empty((3, size), np.int64)
    outward = np.empty(size, np.bool_)
    for cell in range(n):
        border = border_from(
            begins[cell], vertices, wall_ends, following, nodes, node_points, places,
            2 * left.shape[0],
        )  # fmt: skip
        x, y, widths[cell] = inner_point(border)
        points[cell, 0] = x
        points[cell, 1] = y
        _, k = expand(
            vertices, corners, twins, wall_ends, frame, cell_starts, cell_triangles, x, y, out,
            facts,
        )  # fmt: skip
        windows = window_ends(
            vertices, x, y, facts[:k, 0].copy(), facts[:k, 3].copy(), numbers[0], numbers[1],
            numbers[2], outward,
        )  # fmt: skip
        begin = starts[cell]
        if begin + windows > gaps.shape[0]:
            longer = np.empty(2 * (begin + windows), np.int64)
            longer[:begin] = gaps[:begin]
            gaps = longer
        for w in range(windows):
            gaps[begin + w] = facts[numbers[1, w], 0]
        gaps[begin : begin + windows] = np.sort(gaps[begin : begin + windows])
        starts[cell + 1] = begin + windows
    return (
        left, right, chord_of, cells, nodes, node_points, places, points, widths, starts,
        gaps[: starts[n]].copy(),
    )  # fmt: skip
