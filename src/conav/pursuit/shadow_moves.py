"""Shadows, and what becomes of them while one pursuer moves.

A shadow is a component of what no pursuer sees. While pursuer i drives from a to b on a straight
segment and the others stand, the floor that is seen all the time contains what the others see, and
what i sees from both ends: if q sees a and b, the borders of the triangle q a b lie on the floor,
and so does its inside unless a hole lies in it. Whether one does is the same for all points of a
cell of the views, since no hole gets through the triangle's sides. An evader stays in one component
of the rest, so it may pass from an old shadow to a new one only where both meet such a component.

The rule leaves out what is seen in passing, so it may keep too much contaminated, never too little;
halving the segment makes it sharper.

Some walls may be frontiers: sides of what is known of a floor, with floor beyond that nobody has
seen. All beyond is one region, which nobody sees. What is hidden and reaches a frontier hangs
together with it. That is one shadow, `beyond`, the last by number, and it stays contaminated.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.triangulation import Triangulation
from conav.geometry.view_cells import NO_CELL, ViewCells, cell_border, join_cells, view_cells
from conav.geometry.visibility import VisibilityPolygon, visibility_polygon

Point = tuple[float, float]
Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

BEYOND = -2  # the label of what hangs together with unknown floor
SAME = 1e-7  # of the floor's size: two rounded measures of one shadow differ by less


@dataclass(frozen=True)
class Shadows:
    """The shadows of a team that stands.

    Shadows are numbered in the order of their measures: area, first moments, and bounding box.
    Where there are frontiers the last one is the shadow beyond them, which has no measures.
    """

    measures: Floats  # (n, 7)
    beyond_area: float | None = None  # [m^2] of what is known of the shadow beyond, if there is one

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.measures) + (self.beyond_area is not None)

    @property
    def beyond(self) -> int:
        """The shadow beyond frontiers, as a bit; 0 where there is none."""
        return 0 if self.beyond_area is None else 1 << len(self.measures)

    @property
    def areas(self) -> Floats:
        """Of each [m^2]; of the shadow beyond what is known of it."""
        known = self.measures[:, 0]
        return known if self.beyond_area is None else np.append(known, self.beyond_area)


@dataclass
class ShadowMoves:
    """The shadows of teams on one floor, kept as they are found."""

    floor: Triangulation
    halvings: int = 3  # how often a move is halved at most where halves may tell more
    frontiers: NDArray[np.bool_] | None = None  # (walls,) which are; None: none
    views: dict[Point, VisibilityPolygon] = field(default_factory=dict[Point, VisibilityPolygon])
    standing: dict[tuple[Point, ...], Shadows] = field(
        default_factory=dict[tuple[Point, ...], Shadows]
    )
    arrangements: int = 0

    def view(self, point: Point) -> VisibilityPolygon:
        """What a point sees."""
        if point not in self.views:
            self.views[point] = visibility_polygon(self.floor, *point)
        return self.views[point]

    def shadows(self, team: tuple[Point, ...]) -> Shadows:
        """The shadows of pursuers at these points, whoever stands where."""
        team = tuple(sorted(set(team)))
        if team not in self.standing:
            self.arrangements += 1
            cells = view_cells(self.floor, [self.view(point) for point in team])
            labels = self._join(cells, cells.seen_by == 0)
            each = cells_measures(self.floor, cells)
            measures = _measures(each, labels)
            area = None if self.frontiers is None else float(each[labels == BEYOND, 0].sum())
            self.standing[team] = Shadows(measures[np.lexsort(measures.T[::-1])], area)
        return self.standing[team]

    def hidden(self, team: tuple[Point, ...]) -> tuple[ViewCells, list[list[int]]]:
        """The cells of a team's views, and of each the shadows that it may be part of, by number.

        Cells that are seen are part of none; rounding may leave several.
        """
        cells = view_cells(self.floor, [self.view(point) for point in sorted(set(team))])
        labels = self._join(cells, cells.seen_by == 0)
        return cells, _numbers(cells_measures(self.floor, cells), labels, self.shadows(team))

    def enter(self, team: tuple[Point, ...], newcomer: Point) -> list[int]:
        """As `move`, when one more pursuer begins to look and nobody moves."""
        cells, of_all = self.hidden((*team, newcomer))
        places = sorted({*team, newcomer})
        seen = sum(1 << i for i, place in enumerate(places) if place in team)
        old = self._join(cells, cells.seen_by & np.int64(seen) == 0)
        before = self.shadows(team)
        of_team = _numbers(cells_measures(self.floor, cells), old, before)
        rows = [0] * before.count
        for olds, news in zip(of_team, of_all, strict=True):
            for number in olds:
                for new in news:
                    rows[number] |= 1 << new
        if before.beyond:
            rows[-1] |= self.shadows((*team, newcomer)).beyond
        return rows

    def _join(self, cells: ViewCells, chosen: NDArray[np.bool_]) -> Ints:
        """As `join_cells`; those that hang together with what is beyond frontiers get BEYOND."""
        labels = join_cells(cells, chosen)
        if self.frontiers is None:
            return labels
        at = _cells_at(
            cells.n_cells, cells.cells, cells.following, cells.nodes, cells.node_places,
            2 * len(cells.left), self.floor.wall_ends, self.frontiers,
        )  # fmt: skip
        reach = np.isin(labels, np.unique(labels[at & chosen])) & chosen
        rest = labels >= 0
        rest &= ~reach
        result = np.full(len(labels), -1, np.int64)
        result[rest] = np.unique(labels[rest], return_inverse=True)[1]
        result[reach] = BEYOND
        return result

    def move(self, others: tuple[Point, ...], a: Point, b: Point) -> list[int]:
        """For each old shadow the new ones, as bits, that an evader in it may be in afterwards.

        `others` stand while one pursuer drives from a to b, which sees a.
        """
        return self._move(others, a, b, self.halvings)

    def _move(self, others: tuple[Point, ...], a: Point, b: Point, halvings: int) -> list[int]:
        rows, ambiguous = self._whole(others, a, b)
        if not ambiguous or halvings == 0:
            return rows
        middle = ((a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0)
        if middle in (a, b) or len(self.view(middle).walls) == 0:
            return rows  # rounding took the middle of a segment along a wall off the floor
        first = self._move(others, a, middle, halvings - 1)
        second = self._move(others, middle, b, halvings - 1)
        return [row & apply(second, between) for row, between in zip(rows, first, strict=True)]

    def _whole(self, others: tuple[Point, ...], a: Point, b: Point) -> tuple[list[int], bool]:
        """The rule for the whole segment, and whether halves may say less."""
        self.arrangements += 1
        stand = tuple(sorted(set(others)))
        before, after = self.shadows((*stand, a)), self.shadows((*stand, b))
        views = [self.view(point) for point in (*stand, a, b)]
        cells = view_cells(self.floor, views)
        n = len(stand)
        from_a, from_b = np.int64(1 << n), np.int64(1 << (n + 1))
        standing = np.int64((1 << n) - 1)
        by_others = cells.seen_by & standing != 0
        by_a, by_b = cells.seen_by & from_a != 0, cells.seen_by & from_b != 0
        always = np.logical_or(by_others, by_a & by_b)
        if int(self.floor.rings[-1]) > 0:
            for cell in np.flatnonzero(by_a & by_b & ~by_others).tolist():
                always[cell] = not self._hole_between(cells, cell, a, b)
        measures = cells_measures(self.floor, cells)
        old = _numbers(measures, self._join(cells, ~(by_others | by_a)), before)
        new = _numbers(measures, self._join(cells, ~(by_others | by_b)), after)
        free = self._join(cells, ~always)
        olds, news = _meet(free, old), _meet(free, new)
        olds[-1] |= before.beyond
        news[-1] |= after.beyond
        rows = [0] * before.count
        ambiguous = False
        for ins, outs in zip(olds, news, strict=True):
            # Halves can only tell more where a component joins several shadows on either side.
            ambiguous |= ins.bit_count() > 1 and outs != 0
            rest = ins
            while rest:
                bit = rest & -rest
                rows[bit.bit_length() - 1] |= outs
                rest ^= bit
        return rows, ambiguous

    def _hole_between(self, cells: ViewCells, cell: int, a: Point, b: Point) -> bool:
        """Whether a hole lies in the triangle of a and b with the points of a cell that sees both.

        Where rounding leaves a doubt the answer is yes, which claims less to be seen.
        """
        border = cell_border(self.floor, cells, cell)
        inside = _inner_point(border)
        if inside is None:
            return True
        first = np.flatnonzero(np.diff(self.floor.rings)) + 1  # a vertex of each hole
        ax, ay = np.array(a), np.array(b)
        corners = (ax, ay, np.array(inside))
        tests = self.floor.vertices[first]
        sides = [_side(corners[i], corners[(i + 1) % 3], tests) for i in range(3)]
        slack = 1e-9 * float(np.ptp(self.floor.vertices))
        in_one = np.all([side >= -slack for side in sides], axis=0)
        in_other = np.all([side <= slack for side in sides], axis=0)
        return bool(np.logical_or(in_one, in_other).any())


def apply(rows: list[int], contaminated: int) -> int:
    """The shadows, as bits, that may hold somebody after a move, given those that did before."""
    result = 0
    while contaminated:
        bit = contaminated & -contaminated
        result |= rows[bit.bit_length() - 1]
        contaminated ^= bit
    return result


def _side(a: Floats, b: Floats, points: Floats) -> Floats:
    """Signed distances [m] of points from the line through a and b, 0 where these are one."""
    d = b - a
    length = float(np.sqrt(d @ d))
    if length == 0.0:
        return np.zeros(len(points))
    return (d[0] * (points[:, 1] - a[1]) - d[1] * (points[:, 0] - a[0])) / length


def _inner_point(border: Floats) -> Point | None:
    """A point well inside a polygon, or None where it is too thin to tell."""
    import shapely

    parts = shapely.get_parts(shapely.make_valid(shapely.Polygon(border)))
    polygons = [part for part in parts if isinstance(part, shapely.Polygon) and not part.is_empty]
    if not polygons:
        return None
    largest = max(polygons, key=lambda part: part.area)
    point = largest.representative_point()
    if largest.exterior.distance(point) < 1e-9:
        return None
    return float(point.x), float(point.y)


def shadow_numbers(
    moves: ShadowMoves, cells: ViewCells, labels: Ints, team: tuple[Point, ...]
) -> list[list[int]]:
    """For each label of cells, shape (cells,), the numbers of the team's shadow that it is."""
    return _same_shadows(_measures(cells_measures(moves.floor, cells), labels), moves.shadows(team))


def _same_shadows(measures: Floats, shadows: Shadows) -> list[list[int]]:
    """For rows of measures the numbers of the shadows with the same; several where in doubt."""
    scale = float(np.abs(shadows.measures).max(initial=1.0))
    found: list[list[int]] = []
    for row in measures:
        apart = np.abs(shadows.measures - row).max(axis=1)
        close = np.flatnonzero(apart <= SAME * scale).tolist()
        assert shadows.count > 0, "a shadow that the standing team does not have"
        # Where rounding hides which one it is it may be any, which claims less to be clear.
        found.append(close if close else list(range(shadows.count)))
    return found


def _numbers(cell_measures: Floats, labels: Ints, shadows: Shadows) -> list[list[int]]:
    """For each cell the numbers of the standing team's shadow it is part of."""
    of_label = _same_shadows(_measures(cell_measures, labels), shadows)
    beyond = [shadows.count - 1]
    return [
        of_label[label] if label >= 0 else beyond if label == BEYOND else []
        for label in labels.tolist()
    ]


def _meet(components: Ints, numbers: list[list[int]]) -> list[int]:
    """For each component the shadows it meets, as bits; last for the one beyond frontiers."""
    bits = [0] * (int(components.max(initial=-1)) + 2)
    for component, of_cell in zip(components.tolist(), numbers, strict=True):
        if component != NO_CELL:
            for number in of_cell:
                bits[-1 if component == BEYOND else component] |= 1 << number
    return bits


def _measures(cell_measures: Floats, labels: Ints) -> Floats:
    """The measures of the unions of cells with one label, shape (labels, 7)."""
    count = int(labels.max(initial=-1)) + 1
    chosen = labels >= 0
    sums = np.zeros((count, 3))
    np.add.at(sums, labels[chosen], cell_measures[chosen, :3])
    boxes = np.full((count, 4), np.inf)
    np.minimum.at(boxes, labels[chosen], cell_measures[chosen, 3:])
    return np.hstack((sums, boxes))


def cells_measures(floor: Triangulation, cells: ViewCells) -> Floats:
    """Of each cell area, first moments about the first vertex, and bounding box, shape (n, 7).

    The box is given as x and y of its lower left and minus those of its upper right corner.
    """
    return _cells_measures(
        floor.vertices, floor.wall_ends, cells.n_cells, cells.cells, cells.following, cells.nodes,
        cells.node_points, cells.node_places, 2 * len(cells.left),
    )  # fmt: skip


@kernel
def _cells_measures(
    vertices: Floats, wall_ends: Ints, count: int, cells: Ints, following: Ints, nodes: Ints,
    node_points: Floats, places: Ints, along_rings: int,
) -> Floats:  # fmt: skip
    out = np.zeros((count, 7))
    for cell in range(count):
        for k in range(3, 7):
            out[cell, k] = np.inf
    ox, oy = vertices[0, 0], vertices[0, 1]
    if cells.shape[0] == 0:
        v = 0
        for _ in range(vertices.shape[0]):
            end = wall_ends[v]
            _add_side(
                out[0], vertices[v, 0], vertices[v, 1], vertices[end, 0], vertices[end, 1], ox, oy
            )
            v = end
        return out
    for h in range(cells.shape[0]):
        row = out[cells[h]]
        node, after = nodes[h], nodes[following[h]]
        x, y = node_points[node, 0], node_points[node, 1]
        if h >= along_rings:
            # The vertices the ring passes between the two nodes.
            v = places[node] // 2
            end = places[after]
            if places[node] % 2 == 0:
                here = end == places[node] + 1
            else:
                here = end == places[node] and node < after
            while not here:
                v = wall_ends[v]
                if end == 2 * v:
                    break
                _add_side(row, x, y, vertices[v, 0], vertices[v, 1], ox, oy)
                x, y = vertices[v, 0], vertices[v, 1]
                here = end == 2 * v + 1
        _add_side(row, x, y, node_points[after, 0], node_points[after, 1], ox, oy)
    return out


@kernel
def _add_side(
    row: Floats, ax: float, ay: float, bx: float, by: float, ox: float, oy: float
) -> None:
    """Adds the side from a to b of a polygon to its measures about o."""
    ux, uy, vx, vy = ax - ox, ay - oy, bx - ox, by - oy
    twice = ux * vy - vx * uy
    row[0] += twice / 2.0
    row[1] += twice * (ux + vx) / 6.0
    row[2] += twice * (uy + vy) / 6.0
    row[3] = min(row[3], ax)
    row[4] = min(row[4], ay)
    row[5] = min(row[5], -ax)
    row[6] = min(row[6], -ay)


@kernel
def _cells_at(
    count: int, cells: Ints, following: Ints, nodes: Ints, places: Ints, along_rings: int,
    wall_ends: Ints, chosen: NDArray[np.bool_],
) -> NDArray[np.bool_]:  # fmt: skip
    """Which cells have a piece of a chosen wall on their border."""
    out = np.zeros(count, np.bool_)
    if cells.shape[0] == 0:
        out[0] = chosen.any()
    for h in range(along_rings, cells.shape[0]):
        node, after = nodes[h], nodes[following[h]]
        wall = places[node] // 2
        end = places[after]
        if places[node] % 2 == 0:
            here = end == places[node] + 1
        else:
            here = end == places[node] and node < after
        out[cells[h]] |= chosen[wall]
        while not here:
            wall = wall_ends[wall]
            if end == 2 * wall:
                break
            out[cells[h]] |= chosen[wall]
            here = end == 2 * wall + 1
    return out
