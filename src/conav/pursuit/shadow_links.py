"""Between which shadows an evader can get while one pursuer drives and the others stand.

While pursuer i drives from a to b on a straight segment and the others stand, the floor that is
seen all the time contains what the others see, and what i sees from both ends: if q sees a and b,
the borders of the triangle q a b lie on the floor, and so does its inside unless a hole lies in it.
No hole gets through the triangle's sides, so whether one does is the same for all points of a
component of what is seen from both ends. An evader stays in one component of the rest, so it may
pass from an old shadow to a new one only where both lie in such a component.
"""

# numpy's stubs make an item an array where its index is an item of an array, as in half-edges.
# pyright: reportArgumentType=false, reportReturnType=false

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.inner_point import inner_point
from conav.geometry.view_cells import ViewCells, border_from, join, number_shadows

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

_SURELY = 1e-9  # of the floor's size: points closer than that to a line may lie on either side


@kernel
def link_shadows(
    points: Floats, wall_ends: Ints, holes: Ints, frontiers: NDArray[np.bool_], cells: ViewCells,
    viewpoints: Ints,
) -> tuple[Ints, Ints, Floats, Floats, NDArray[np.bool_]]:  # fmt: skip
    """The component of each old shadow, of each new one, the areas [m^2] of both, and of each
    component whether it has a piece of a frontier on its border.

    Of a `ViewTable` the points and the numbers of those who stand, then of where the drive begins
    and ends; the cells of these views; a vertex of each hole; and which walls are frontiers.
    Shadows are numbered as by `conav.geometry.view_cells.shadows`.
    """
    areas, seen_by, left, right = cells.areas, cells.seen_by, cells.left, cells.right
    n = viewpoints.shape[0] - 2
    standing = (1 << n) - 1
    at_begin = 1 << n
    at_end = 2 << n
    old = number_shadows(
        seen_by,
        left,
        right,
        cells.changes,
        cells.cells,
        cells.following,
        cells.nodes,
        cells.node_places,
        standing | at_begin,
    )
    new = number_shadows(
        seen_by,
        left,
        right,
        cells.changes,
        cells.cells,
        cells.following,
        cells.nodes,
        cells.node_places,
        standing | at_end,
    )
    both = seen_by & (at_begin | at_end) == at_begin | at_end
    if holes.shape[0] > 0:
        leave_out_triangles_with_holes(
            points, wall_ends, holes, cells, points[wall_ends.shape[0] + viewpoints[n]],
            points[wall_ends.shape[0] + viewpoints[n + 1]], both,
        )  # fmt: skip
    free = join(left, right, np.logical_not(np.logical_or(both, seen_by & standing != 0)))
    n_old = old.max() + 1
    n_new = new.max() + 1
    of_old = np.empty(n_old, np.int64)
    of_new = np.empty(n_new, np.int64)
    old_areas = np.zeros(n_old)
    new_areas = np.zeros(n_new)
    for cell in range(areas.shape[0]):
        if old[cell] >= 0:
            of_old[old[cell]] = free[cell]
            old_areas[old[cell]] += areas[cell]
        if new[cell] >= 0:
            of_new[new[cell]] = free[cell]
            new_areas[new[cell]] += areas[cell]
    reaches = np.zeros(free.max() + 1, np.bool_)
    if frontiers.any():
        at = cells_at(cells, wall_ends, frontiers)
        for cell in range(areas.shape[0]):
            if at[cell] and free[cell] >= 0:
                reaches[free[cell]] = True
    return of_old, of_new, old_areas, new_areas, reaches


@kernel
def cells_at(cells: ViewCells, wall_ends: Ints, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which cells have a piece of a chosen wall on their border."""
    following, nodes, places = cells.following, cells.nodes, cells.node_places
    out = np.zeros(cells.areas.shape[0], np.bool_)
    if cells.cells.shape[0] == 0:
        out[0] = chosen.any()
    for h in range(2 * cells.left.shape[0], cells.cells.shape[0]):
        node, after = nodes[h], nodes[following[h]]
        wall = places[node] // 2
        end = places[after]
        if places[node] % 2 == 0:
            here = end == places[node] + 1
        else:
            here = end == places[node] and node < after
        out[cells.cells[h]] |= chosen[wall]
        while not here:
            wall = wall_ends[wall]
            if end == 2 * wall:
                break
            out[cells.cells[h]] |= chosen[wall]
            here = end == 2 * wall + 1
    return out


@kernel
def leave_out_triangles_with_holes(
    points: Floats, wall_ends: Ints, holes: Ints, cells: ViewCells, a: Floats, b: Floats,
    both: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Takes cells out of `both` whose triangles with a and b may hold a hole."""
    areas = cells.areas
    parts = join(cells.left, cells.right, both)
    count = parts.max() + 1
    largest = np.full(count, -1, np.int64)
    for cell in range(areas.shape[0]):
        part = parts[cell]
        if part >= 0 and (largest[part] < 0 or areas[cell] > areas[largest[part]]):
            largest[part] = cell
    begins = np.full(areas.shape[0], -1, np.int64)
    for h in range(cells.cells.shape[0]):
        begins[cells.cells[h]] = h
    size = max(
        points[: wall_ends.shape[0], 0].max() - points[: wall_ends.shape[0], 0].min(),
        points[: wall_ends.shape[0], 1].max() - points[: wall_ends.shape[0], 1].min(),
    )
    clear = np.zeros(count, np.bool_)
    for part in range(count):
        border = border_from(
            begins[largest[part]], points, wall_ends, cells.following, cells.nodes,
            cells.node_points, cells.node_places, 2 * cells.left.shape[0],
        )  # fmt: skip
        x, y, width = inner_point(border)
        if width > _SURELY * size:
            clear[part] = not _hole_between(points, holes, a, b, x, y, _SURELY * size)
    for cell in range(areas.shape[0]):
        if parts[cell] >= 0:
            both[cell] = clear[parts[cell]]


@kernel
def _hole_between(
    points: Floats, holes: Ints, a: Floats, b: Floats, x: float, y: float, slack: float
) -> bool:
    """Whether the triangle of a, b and (x, y) holds a hole, or may, by `slack` [m]."""
    for hole in holes:
        hx, hy = points[hole]
        one = _distance(a[0], a[1], b[0], b[1], hx, hy)
        two = _distance(b[0], b[1], x, y, hx, hy)
        three = _distance(x, y, a[0], a[1], hx, hy)
        least = min(one, two, three)
        most = max(one, two, three)
        if least >= -slack or most <= slack:
            return True
    return False


@kernel
def _distance(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """How far (x, y) lies left of the line from a to b [m], 0 where these are one."""
    dx = bx - ax
    dy = by - ay
    length = np.sqrt(dx * dx + dy * dy)
    return (dx * (y - ay) - dy * (x - ax)) / length if length > 0.0 else 0.0
