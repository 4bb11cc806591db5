"""Shadows, and what becomes of them while one pursuer moves.

A shadow is a component of what no pursuer sees. The rule for a whole drive, `shadow_links`, leaves
out what is seen in passing, so it may keep too much contaminated, never too little; halving the
drive makes it sharper.

Some walls may be frontiers: sides of what is known of a floor, with floor beyond that nobody has
seen. All beyond is one region that nobody sees, the last shadow by number. Shadows that reach a
frontier hang together with it. They and it are contaminated always.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.geometry.triangulation import Triangulation
from conav.geometry.view_cells import ViewCells, cells_of_table
from conav.geometry.view_cells import shadows as shadows_of
from conav.geometry.view_chords import ViewTable
from conav.geometry.visibility import VisibilityPolygon, visibility_polygon
from conav.pursuit.shadow_links import cells_at, leave_out_triangles_with_holes, link_shadows

Point = tuple[float, float]
Floats = NDArray[np.float64]


class Links(NamedTuple):
    """How a drive joins old shadows and new ones, as bits, component by component."""

    old: tuple[int, ...]
    new: tuple[int, ...]

    def apply(self, contaminated: int) -> tuple[int, bool]:
        """The new shadows that may hold somebody, given the old ones that did; and doubt.

        Halves of the drive can tell more only where a component joins contaminated shadows and
        clear ones.
        """
        after, doubt = 0, False
        for old, new in zip(self.old, self.new, strict=True):
            if old & contaminated and new:
                after |= new
                doubt |= old & contaminated != old
        return after, doubt


@dataclass(frozen=True)
class Shadows:
    """The shadows of a team that stands, in the order of `conav.geometry.view_cells.shadows`."""

    areas: Floats  # (n,) [m^2]
    exposed: int = 0  # as bits, those that reach a frontier
    beyond: int = 0  # as a bit, the one beyond frontiers; 0 where there are none

    @property
    def count(self) -> int:
        """How many there are, with the one beyond frontiers."""
        return len(self.areas) + (self.beyond > 0)


Team = tuple[int, ...]
"""Viewpoints by number, growing, each once."""


@dataclass
class ShadowMoves:
    """The shadows of teams on one floor, kept as they are found.

    Viewpoints are given as points [m], or, where a method's name says so, by number.
    """

    floor: Triangulation
    halvings: int = 3  # how often a move is halved at most where halves may tell more
    frontiers: NDArray[np.bool_] | None = None  # (walls,) which are; None: none
    arrangements: int = 0  # of views laid over each other so far
    windows: int = 0  # in all of them together

    def __post_init__(self) -> None:
        self.points: list[Point] = []
        self._views: list[VisibilityPolygon] = []
        self._numbers: dict[Point, int] = {}
        self._middles: dict[tuple[int, int], int] = {}
        self._standing: dict[Team, Shadows] = {}
        self._links: dict[tuple[Team, int, int], Links] = {}
        self._table = ViewTable(self.floor)
        self._frontiers = np.zeros(0, np.bool_) if self.frontiers is None else self.frontiers
        self._holes = np.flatnonzero(np.diff(self.floor.rings)) + 1  # a vertex of each

    def number(self, point: Point) -> int:
        """Of a viewpoint, which need not be known yet."""
        if point not in self._numbers:
            view = visibility_polygon(self.floor, *point)
            self._numbers[point] = self._table.add(view)
            self._views.append(view)
            self.points.append(point)
        return self._numbers[point]

    def view(self, point: Point) -> VisibilityPolygon:
        """What a point sees."""
        return self._views[self.number(point)]

    def shadows(self, team: Sequence[Point]) -> Shadows:
        """The shadows of pursuers at these points, whoever stands where."""
        return self.numbered_shadows(self.team(team))

    def move(self, others: Sequence[Point], a: Point, b: Point) -> list[int]:
        """For each old shadow the new ones, as bits, that an evader in it may be in afterwards.

        `others` stand while one pursuer drives from a to b, which sees a.
        """
        count = self.shadows((*others, a)).count
        return [self.after(others, a, b, 1 << shadow) for shadow in range(count)]

    def after(self, others: Sequence[Point], a: Point, b: Point, contaminated: int) -> int:
        """The new shadows, as bits, that may hold somebody after a move, given the old ones."""
        return self.numbered_after(self.team(others), self.number(a), self.number(b), contaminated)

    def joined_by(self, team: Sequence[Point], newcomer: Point, contaminated: int) -> int:
        """As `after`, when one more pursuer begins to look and nobody moves."""
        numbers = self.team(team)
        return self.links(numbers, numbers[0], self.number(newcomer)).apply(contaminated)[0]

    def team(self, points: Sequence[Point]) -> Team:
        """The numbers of these viewpoints."""
        return tuple(sorted({self.number(point) for point in points}))

    def numbered_shadows(self, team: Team) -> Shadows:
        """As `shadows`."""
        if team not in self._standing:
            cells = self.cells(np.array(team, np.int64))
            labels = shadows_of(cells)
            areas = np.zeros(int(labels.max()) + 1)
            np.add.at(areas, labels[labels >= 0], cells.areas[labels >= 0])
            self._standing[team] = self._shadows(cells, labels, areas)
        return self._standing[team]

    def numbered_after(
        self, others: Team, a: int, b: int, contaminated: int, halvings: int | None = None
    ) -> int:
        """As `after`. The move is halved, up to `halvings` times, only where that may tell more."""
        bits, doubt = self.links(others, a, b).apply(contaminated)
        left = self.halvings if halvings is None else halvings
        if not doubt or left == 0:
            return bits
        middle = self.middle(a, b)
        if middle < 0:
            return bits
        half_way = self.numbered_after(others, a, middle, contaminated, left - 1)
        return bits & self.numbered_after(others, middle, b, half_way, left - 1)

    def links(self, others: Team, a: int, b: int) -> Links:
        """The rule for the whole drive, viewpoints by number.

        Where a is one of `others` nobody drives, and somebody is put down at b: it tells which new
        shadows are part of which old ones.
        """
        if (others, a, b) not in self._links:
            who = np.array((*others, a, b), np.int64)
            old, new, old_areas, new_areas, reaches = link_shadows(
                self._table.points, self.floor.wall_ends, self._holes, self._frontiers,
                self.cells(who), who,
            )  # fmt: skip
            ends = (tuple(sorted({*others, a})), tuple(sorted({*others, b})))
            if self.frontiers is None:
                self._standing.setdefault(ends[0], Shadows(old_areas))
                self._standing.setdefault(ends[1], Shadows(new_areas))
            count = 1 + max(int(old.max(initial=-1)), int(new.max(initial=-1)))
            olds, news = [0] * count, [0] * count
            for bits, components in ((olds, old.tolist()), (news, new.tolist())):
                for shadow, component in enumerate(components):
                    bits[component] |= 1 << shadow
            joined = [pair for pair in zip(olds, news, strict=True) if pair != (0, 0)]
            if self.frontiers is not None:
                # What reaches a frontier hangs together with what is beyond it.
                before, after = (self.numbered_shadows(team) for team in ends)
                open_old, open_new = before.beyond, after.beyond
                joined = []
                for component, pair in enumerate(zip(olds, news, strict=True)):
                    if component < len(reaches) and reaches[component]:
                        open_old, open_new = open_old | pair[0], open_new | pair[1]
                    elif pair != (0, 0):
                        joined.append(pair)
                joined.append((open_old, open_new))
            there = Links(tuple(pair[0] for pair in joined), tuple(pair[1] for pair in joined))
            self._links[others, a, b] = there
            self._links[others, b, a] = Links(there.new, there.old)
        return self._links[others, a, b]

    def _shadows(self, cells: ViewCells, labels: NDArray[np.int64], areas: Floats) -> Shadows:
        if self.frontiers is None:
            return Shadows(areas)
        at = cells_at(cells, self.floor.wall_ends, self._frontiers)
        exposed = sum(1 << number for number in np.unique(labels[at & (labels >= 0)]).tolist())
        return Shadows(areas, exposed, 1 << len(areas))

    def leave_out_holes(self, cells: ViewCells, a: int, b: int, both: NDArray[np.bool_]) -> None:
        """Takes cells out of `both` whose triangles with viewpoints a and b may hold a hole."""
        if len(self._holes):
            first = len(self.floor.wall_ends)
            leave_out_triangles_with_holes(
                self._table.points, self.floor.wall_ends, self._holes, cells,
                self._table.points[first + a], self._table.points[first + b], both,
            )  # fmt: skip

    def cells(self, viewpoints: NDArray[np.int64]) -> ViewCells:
        """The cells of these viewpoints' views, by number; bit i is the i-th."""
        starts = self._table.starts
        self.arrangements += 1
        self.windows += int((starts[viewpoints + 1] - starts[viewpoints]).sum())
        return cells_of_table(self._table, viewpoints)

    def middle(self, a: int, b: int) -> int:
        """The viewpoint half-way; -1 where rounding takes it to an end or off the floor."""
        key = (a, b) if a < b else (b, a)
        if key not in self._middles:
            (ax, ay), (bx, by) = self.points[a], self.points[b]
            middle = self.number(((ax + bx) / 2.0, (ay + by) / 2.0))
            off = middle in key or len(self._views[middle].walls) == 0
            self._middles[key] = -1 if off else middle
        return self._middles[key]
