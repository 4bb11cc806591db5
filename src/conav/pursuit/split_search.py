"""Clearing a floor by posting guards that part it, and clearing the parts one after the other.

A part that one searcher can clear by itself is cleared so. Else a guard is posted, which parts it
further, and each of these parts is cleared with one pursuer less; when all are clear, so is the
whole, and the guard is free. Parts do not know of each other, so a team of k need only be searched
for one pursuer at a time. This finds no plan in which two must move in turn to clear a part.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from conav.pursuit.lone_search import Alone, Component, components, left_of, search_alone
from conav.pursuit.roadmap import Roadmap
from conav.pursuit.shadow_moves import ShadowMoves, Team

Drive = tuple[int, list[int]]
"""A pursuer of the team, by number, and the places by number it goes through."""

Part = tuple[Team, int]


@dataclass
class SplitSearch:
    """Searches on one roadmap; what was found out about parts is kept between them."""

    moves: ShadowMoves
    roadmap: Roadmap
    weight: float
    spent: int = 0  # states looked at
    _alone: dict[Part, Alone] = field(default_factory=dict[Part, Alone])
    _fails: set[tuple[Part, int]] = field(default_factory=set[tuple[Part, int]])
    _posts: dict[Part, list[int]] = field(default_factory=dict[Part, list[int]])

    def __post_init__(self) -> None:
        self._numbers = [self.moves.number(point) for point in self.roadmap.points]

    def clear(
        self,
        size: int,
        *,
        breadth: int,
        each: int,
        budget: int,
        on_progress: Callable[[int], bool] | None = None,
    ) -> list[Drive] | None:
        """Drives, one after the other, by which `size` pursuers clear the floor; None for none.

        The first place of a drive may be anywhere: the pursuer goes there first. In each part
        `breadth` posts are tried; by itself a part is searched for `each` states at most. It ends
        where views with `budget` windows were laid over each other, or where `on_progress`, told
        how many states were looked at, says False.
        """
        self._breadth, self._each, self._end = breadth, each, self.moves.windows + budget
        self._on_progress, self.stopped = on_progress, False
        self._fails.clear()
        drives: list[Drive] = []
        for part in components(self.moves, ()):
            found = self._clear(part, size)
            if found is None:
                return None
            drives += found
        return drives

    def _clear(self, part: Component, size: int) -> list[Drive] | None:
        key = (part.guards, part.shadow)
        depth = len(part.guards)
        alone = self._search_alone(part, key)
        if alone is not None:
            return [(depth, alone)]
        if size == 1 or self.ended or (key, size) in self._fails:
            return None
        for post in self._best_posts(part, key)[: self._breadth]:
            drives: list[Drive] | None = [(depth, [post])]
            for inner in self._parts(part, post):
                found = self._clear(inner, size - 1)
                if found is None:
                    drives = None
                    break
                drives += found
            if drives is not None:
                return drives
            if self.ended:
                return None
        self._fails.add((key, size))
        return None

    @property
    def ended(self) -> bool:
        """Whether the last search ended before it was through."""
        return self.stopped or self.moves.windows >= self._end

    def _search_alone(self, part: Component, key: Part) -> list[int] | None:
        known = self._alone.get(key)
        windows = self._end - self.moves.windows
        if known is None or (
            known.way is None and not known.exhausted and known.expanded < self._each
        ):
            if self._on_progress is not None and not self._on_progress(self.spent):
                self.stopped = True
                return None
            known = self._alone[key] = search_alone(
                self.moves,
                self.roadmap,
                self._numbers,
                part,
                weight=self.weight,
                most=self._each,
                windows=windows,
            )
            self.spent += known.expanded
        return known.way

    def _parts(self, part: Component, post: int) -> list[Component]:
        """Those into which a guard at a place parts a part, the largest first."""
        number = self._numbers[post]
        guards = tuple(sorted({*part.guards, number}))
        bits, _ = left_of(self.moves, part, number)
        inner = [one for one in components(self.moves, guards) if bits >> one.shadow & 1]
        return sorted(inner, key=lambda one: -one.area)

    def _best_posts(self, part: Component, key: Part) -> list[int]:
        """Places that part a part, those first that leave the smallest largest part."""
        if key not in self._posts:
            ranked: list[tuple[float, float, int]] = []
            for place, number in enumerate(self._numbers):
                if number in part.guards:
                    continue
                _, left = left_of(self.moves, part, number)
                if left < part.area * (1.0 - 1e-9):
                    inner = self._parts(part, place)
                    ranked.append((inner[0].area if inner else 0.0, left, place))
            self._posts[key] = [place for _, _, place in sorted(ranked)]
        return self._posts[key]
