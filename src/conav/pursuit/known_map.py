"""Clearing a known floor with a team of given size: search over places and contaminated shadows.

A state is who stands where and which shadows may hold somebody, one bit each. One pursuer at a time
drives to a place its own sees; what that does to the bits is `shadow_moves`. A state is not looked
at where one with the same places and no more contamination was reached for no more cost. There are
finitely many states, so the search ends: with a plan, or with the proof that none exists on this
roadmap, which says nothing of other roadmaps.
"""

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from conav.pursuit.roadmap import Roadmap
from conav.pursuit.shadow_moves import ShadowMoves

Team = tuple[int, ...]  # places by number, growing: pursuers are alike


Goal = Callable[[Team, int], bool]


class Move(NamedTuple):
    """One pursuer drives from a place to one it sees."""

    start: int
    end: int


@dataclass(frozen=True)
class Clearing:
    """What a search found: moves, None where there is no plan or the budget ended first."""

    moves: tuple[Move, ...] | None
    exhausted: bool  # whether every state of this roadmap was looked at
    expanded: int


@dataclass
class KnownMapSearch:
    """Searches on one roadmap; what moves do to shadows is kept between them."""

    shadows: ShadowMoves
    roadmap: Roadmap

    def __post_init__(self) -> None:
        self._numbers = [self.shadows.number(point) for point in self.roadmap.points]
        # What is smaller [m^2] is due to rounding.
        self._least_area = 1e-9 * float(np.prod(np.ptp(self.shadows.floor.vertices, axis=0)))

    def clear(
        self,
        team: Sequence[int],
        *,
        weight: float,
        budget: int,
        dirty: int | None = None,
        goal: Goal | None = None,
        on_progress: Callable[[int], bool] | None = None,
    ) -> Clearing:
        """A plan for pursuers that start at these places.

        In the beginning somebody may be in all shadows, or in those of `dirty`, by bits. The plan
        ends where `goal` says so of the places and the shadows; by default where `is_clear` does.

        States are taken by metres driven plus `weight` times the square root of the contaminated
        area [m]: 0 finds the shortest of all plans on the roadmap, more finds some plan sooner.
        It ends where views with `budget` windows were laid over each other, or where
        `on_progress`, told how many states were expanded, says False.
        """
        begin = tuple(sorted(team))
        full = (1 << self.shadows.numbered_shadows(self._viewpoints(begin)).count) - 1
        full = full if dirty is None else dirty
        reaches = self.is_clear if goal is None else goal
        waiting: list[tuple[float, int, float, Team, int]] = []
        parents: list[tuple[int, Move | None]] = [(-1, None)]
        reached: dict[Team, list[tuple[int, float]]] = {}
        heapq.heappush(waiting, (self._rank(0.0, begin, full, weight), 0, 0.0, begin, full))
        expanded, last = 0, self.shadows.windows + budget
        while waiting:
            _, number, cost, places, dirty = heapq.heappop(waiting)
            if reaches(places, dirty):
                return Clearing(_moves(parents, number), False, expanded)
            known = reached.setdefault(places, [])
            if any(bits & dirty == bits and paid <= cost for bits, paid in known):
                continue
            known[:] = [one for one in known if not (one[0] & dirty == dirty and one[1] >= cost)]
            known.append((dirty, cost))
            if self.shadows.windows >= last or (
                on_progress is not None and expanded % 64 == 0 and not on_progress(expanded)
            ):
                return Clearing(None, False, expanded)
            expanded += 1
            for start in dict.fromkeys(places):
                for end in self.roadmap.joined[start].tolist():
                    after, bits = self._after(places, start, end, dirty)
                    paid = cost + float(self.roadmap.lengths[start, end])
                    if any(
                        one & bits == one and spent <= paid for one, spent in reached.get(after, ())
                    ):
                        continue
                    parents.append((number, Move(start, end)))
                    rank = self._rank(paid, after, bits, weight)
                    heapq.heappush(waiting, (rank, len(parents) - 1, paid, after, bits))
        return Clearing(None, True, expanded)

    def is_clear(self, places: Team, dirty: int) -> bool:
        """Whether nobody is hidden on the known part of the floor: what may be is beyond it."""
        if dirty == 0:
            return True
        shadows = self.shadows.numbered_shadows(self._viewpoints(places))
        if dirty & ~(shadows.exposed | shadows.beyond):
            return False
        exposed = [area for i, area in enumerate(shadows.areas) if shadows.exposed >> i & 1]
        return sum(exposed) <= self._least_area

    def _after(self, places: Team, start: int, end: int, dirty: int) -> tuple[Team, int]:
        rest = list(places)
        rest.remove(start)
        others, numbers = tuple(rest), self._numbers
        after = self.shadows.numbered_after(
            self._viewpoints(others), numbers[start], numbers[end], dirty
        )
        return tuple(sorted((*others, end))), after

    def _viewpoints(self, places: Team) -> Team:
        return tuple(sorted({self._numbers[place] for place in places}))

    def _rank(self, cost: float, places: Team, dirty: int, weight: float) -> float:
        if weight == 0.0 or dirty == 0:
            return cost
        areas = self.shadows.numbered_shadows(self._viewpoints(places)).areas
        area = sum(float(areas[i]) for i in range(len(areas)) if dirty >> i & 1)
        return cost + weight * max(area, 0.0) ** 0.5


def _moves(parents: list[tuple[int, Move | None]], number: int) -> tuple[Move, ...]:
    moves: list[Move] = []
    while True:
        number, move = parents[number]
        if move is None:
            return tuple(reversed(moves))
        moves.append(move)
