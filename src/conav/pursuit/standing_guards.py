"""What standing guards cut a floor into.

An evader that nobody sees stays in its component of what the guards do not see, as long as they
stand. So each component is a problem of its own, and whoever clears it may drive anywhere.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from conav.geometry.view_cells import cell_border, view_cells
from conav.geometry.view_cells import shadows as shadows_of
from conav.pursuit.navigation_graph import NavigationGraph
from conav.pursuit.shadow_moves import Point, ShadowMoves

Guards = tuple[Point, ...]


@dataclass
class StandingGuards:
    """The shadows of standing guards, and the places of a navigation graph in them.

    Shadows are numbers of `ShadowMoves.shadows`, sets of them bits. Nobody's shadow is the whole
    floor.
    """

    shadows: ShadowMoves
    graph: NavigationGraph
    _places: dict[Guards, list[frozenset[int]]] = field(
        default_factory=dict[Guards, list[frozenset[int]]], repr=False
    )

    def everything(self, guards: Sequence[Point]) -> int:
        """All shadows of these guards, as bits."""
        return (1 << self.shadows.shadows(_team(guards)).count) - 1

    def area(self, guards: Sequence[Point], chosen: int) -> float:
        """Of chosen shadows together [m^2]."""
        return sum(self.areas(guards, chosen))

    def areas(self, guards: Sequence[Point], chosen: int) -> list[float]:
        """Of each chosen shadow [m^2]."""
        areas = self.shadows.shadows(_team(guards)).areas.tolist()
        return [area for number, area in enumerate(areas) if chosen >> number & 1]

    def places(self, guards: Sequence[Point], chosen: int) -> list[int]:
        """The places in or on the border of chosen shadows, growing.

        Where nobody stands that is every place; where there is none, those that see in. Critical
        vertices in a shadow hang together by edges within it, as shortest ways turn there.
        """
        team = _team(guards)
        if not team:
            return list(range(len(self.graph.points)))
        if team not in self._places:
            self._places[team] = self._find_places(team)
        found = frozenset[int]().union(
            *(places for i, places in enumerate(self._places[team]) if chosen >> i & 1)
        )
        return sorted(found) if found or not chosen else self._lookouts(team, chosen)

    def _lookouts(self, team: Guards, chosen: int) -> list[int]:
        """The places that see some of shadows that have no place: windows of several bound them.

        Such shadows are convex, and the corner at which one of these windows begins sees in.
        """
        whole = self.area(team, chosen)
        seeing: list[int] = []
        for place, point in enumerate(self.graph.points):
            after = (*team, point)
            if self.area(after, self.carried(team, after, chosen)) < whole * (1.0 - 1e-9):
                seeing.append(place)
        return seeing

    def carried(self, before: Sequence[Point], after: Sequence[Point], chosen: int) -> int:
        """The shadows somebody in chosen ones may be in when others stand guard, as bits.

        Those who leave and those who come see at that moment, and nobody moves.
        """
        old, new = _team(before), _team(after)
        if old == new:
            return chosen
        team = _team((*old, *new))
        cells = view_cells(self.shadows.floor, [self.shadows.view(point) for point in team])
        of_old = sum(1 << i for i, point in enumerate(team) if point in old)
        of_new = sum(1 << i for i, point in enumerate(team) if point in new)
        was, will = shadows_of(cells, of_old).tolist(), shadows_of(cells, of_new).tolist()
        result = 0
        for cell in np.flatnonzero(cells.seen_by == 0).tolist():
            if chosen >> was[cell] & 1:
                result |= 1 << will[cell]
        return result

    def windows(
        self, guards: Sequence[Point], chosen: int, post: Point
    ) -> tuple[tuple[Point, Point], ...]:
        """The segments [m] that part what a further guard sees of chosen shadows from the rest."""
        old, new = _team(guards), _team((*guards, post))
        cells = view_cells(self.shadows.floor, [self.shadows.view(point) for point in new])
        of_old = sum(1 << i for i, point in enumerate(new) if point in old)
        was = shadows_of(cells, of_old).tolist()
        inside = [number >= 0 and bool(chosen >> number & 1) for number in was]
        found: list[tuple[Point, Point]] = []
        for piece, (left, right) in enumerate(
            zip(cells.left.tolist(), cells.right.tolist(), strict=True)
        ):
            hidden = [cells.seen_by[left] == 0, cells.seen_by[right] == 0]
            if inside[left] and inside[right] and hidden[0] != hidden[1]:
                ends = cells.node_points[cells.nodes[2 * piece : 2 * piece + 2]].tolist()
                found.append(((ends[0][0], ends[0][1]), (ends[1][0], ends[1][1])))
        return tuple(found)

    def _find_places(self, team: Guards) -> list[frozenset[int]]:
        cells = view_cells(self.shadows.floor, [self.shadows.view(point) for point in team])
        numbers = shadows_of(cells)
        index = {point: i for i, point in enumerate(self.graph.points)}
        found: list[set[int]] = [set() for _ in range(self.shadows.shadows(team).count)]
        for cell in np.flatnonzero(numbers >= 0).tolist():
            border = cell_border(self.shadows.floor, cells, cell).tolist()
            found[int(numbers[cell])] |= {index[x, y] for x, y in border if (x, y) in index}
        return [frozenset(places) for places in found]


def _team(points: Sequence[Point]) -> Guards:
    return tuple(sorted(set(points)))
