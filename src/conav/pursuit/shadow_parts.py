"""Parts of a floor that are shadows of guards: true geometry, so nothing is lost."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

from conav.pursuit.known_map import Move
from conav.pursuit.shadow_labels import ShadowLabels
from conav.pursuit.standing_guards import StandingGuards
from conav.pursuit.sweep import sweep

Cut = Literal["geometry", "degree", "stuck"]
"""Where a guard is posted: see `ShadowParts`."""


class ShadowPart(NamedTuple):
    """Shadows of guards who stand at these places, as bits."""

    guards: tuple[int, ...]
    shadows: int


@dataclass
class ShadowParts:
    """Shadows of standing guards as parts.

    The guard is posted where the largest shadow that is left is smallest (`geometry`), at the place
    that sees most others of the part (`degree`, [Pellier2005] section 3.3), or where the stuck
    pursuer is (`stuck`, section 4). Any place of a part sees some of it, so parts shrink.
    """

    guards: StandingGuards
    labels: ShadowLabels
    cut: Cut
    weight: float
    budget: int
    go_on: Callable[[int], bool]
    expanded: int = 0
    largest: int = 0  # states expanded for one part

    def whole(self) -> ShadowPart:
        """The whole floor."""
        return ShadowPart((), 1)

    def places(self, part: ShadowPart) -> list[int]:
        return self.guards.places(self._points(part.guards), part.shadows)

    def standing(self, part: ShadowPart) -> tuple[int, ...]:
        return part.guards

    def contaminated(self, part: ShadowPart, entry: int) -> int:
        """The shadows of the guards with one more who came to `entry`, inside the part."""
        posts = self._points(part.guards)
        return self.guards.carried(posts, (*posts, self.guards.graph.points[entry]), part.shadows)

    def swept(self, part: ShadowPart, entry: int) -> tuple[Move, ...] | None:
        found = sweep(
            self.guards.graph,
            self.labels,
            entry,
            standing=part.guards,
            within=self.places(part),
            contaminated=self.contaminated(part, entry),
            weight=self.weight,
            budget=self.budget,
            go_on=lambda count: self.go_on(self.expanded + count),
        )
        self.expanded += found.expanded
        self.largest = max(self.largest, found.expanded)
        return found.moves

    def post(self, part: ShadowPart, entry: int) -> int:
        graph = self.guards.graph
        places = [place for place in self.places(part) if place not in part.guards]
        if self.cut == "stuck" and entry in places:
            return entry
        if self.cut != "geometry":
            inside = set(places)
            return min(
                places,
                key=lambda place: (-len(inside.intersection(graph.joined[place].tolist())), place),
            )
        return min(places, key=lambda place: (*self._left(part, place), place))

    def beyond(self, part: ShadowPart, post: int) -> list[ShadowPart]:
        guards = (*part.guards, post)
        left = self.guards.carried(self._points(part.guards), self._points(guards), part.shadows)
        return [ShadowPart(guards, 1 << i) for i in range(left.bit_length()) if left >> i & 1]

    def _left(self, part: ShadowPart, place: int) -> tuple[float, float]:
        """The area of the largest shadow left, and of all [m^2]."""
        guards = self._points((*part.guards, place))
        left = self.guards.carried(self._points(part.guards), guards, part.shadows)
        areas = self.guards.areas(guards, left)
        return max(areas, default=0.0), sum(areas)

    def _points(self, places: tuple[int, ...]) -> tuple[tuple[float, float], ...]:
        return tuple(self.guards.graph.points[place] for place in places)
