"""Plans for clearing a known floor with a team of given size, by one search after the other."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from conav.geometry.sight_lines import sees
from conav.geometry.triangulation import Triangulation
from conav.pursuit.bounds import least_pursuers
from conav.pursuit.catalogue import OnProgress
from conav.pursuit.drives import moves_of
from conav.pursuit.guard_posts import guard_posts
from conav.pursuit.known_map import KnownMapSearch, Move
from conav.pursuit.one_pursuer import decide_one_pursuer
from conav.pursuit.roadmap import Roadmap, make_roadmap
from conav.pursuit.shadow_moves import Point, ShadowMoves
from conav.pursuit.split_search import Drive, SplitSearch
from conav.pursuit.team import LARGEST, team_of
from conav.pursuit.types import PursuitProblem

QUICK = 100  # states for a part by itself where any plan is looked for
QUICK_SHARE = 30  # times the budget, so that large floors come to a plan
MOST_PLACES = 400  # triangles; of floors with more the middles are tried only when asked for
THOROUGH = 2000  # states for a part by itself where a plan for fewer is looked for


class Limits(NamedTuple):
    """The settings of `ClearKnownMap`."""

    places: Literal["auto", "vertices", "all"]
    weight: float
    budget: int


class Plan(NamedTuple):
    """Moves over a roadmap."""

    roadmap: Roadmap
    moves: tuple[Move, ...]


class Plans:
    """Plans for one problem, by different searches; what they learn of the floor is shared."""

    def __init__(
        self,
        problem: PursuitProblem,
        mesh: Triangulation,
        limits: Limits,
        on_progress: OnProgress | None,
    ) -> None:
        self.problem, self.mesh, self.limits = problem, mesh, limits
        self.on_progress = on_progress
        self.expanded = 0
        self.stopped = False
        self.least = least_pursuers(problem.floor)
        self.shadows = ShadowMoves(mesh)
        self._starts = [(float(one.start[0]), float(one.start[1])) for one in problem.pursuers]
        self._splits: dict[bool, SplitSearch] = {}
        self._posts: tuple[int, ...] | None = None  # none there are: ()

    def quick(self, size: int) -> Plan | None:
        """By the post that looks best in each part; after the budget by posts that see all."""
        middles = self.limits.places == "all"
        plan = self._split(size, middles, breadth=1, each=QUICK, share=QUICK_SHARE)
        if plan is None and not self.stopped and (self._splits[middles].ended or size == LARGEST):
            search = self._splits[middles]
            if self._posts is None:
                posts = guard_posts(self.mesh, search.roadmap.points)
                self._posts = () if posts is None else posts.places
            if 0 < len(self._posts) <= size:
                drives = [(who, [post]) for who, post in enumerate(self._posts)]
                plan = self._plan(search, drives, size)
        return plan

    def thorough(self, size: int) -> Plan | None:
        """By several posts in each part, and by moving in turn, as far as the budget goes.

        The shortest plan may have all move in turn, so it is looked for among these alone.
        """
        choices = {"vertices": (False,), "all": (True,)}.get(self.limits.places, (False, True))
        if choices == (False, True) and len(self.mesh.triangles) > MOST_PLACES:
            choices = (False,)
        for middles in choices:
            plan = None
            if self.limits.weight > 0.0:
                plan = self._split(size, middles, breadth=8, each=THOROUGH)
            if plan is None and not self.stopped:
                plan = self._in_turn(size, middles)
            if plan is not None or self.stopped:
                return plan
        return None

    def alone(self) -> Plan | None:
        """By the cells that tell whether one pursuer can clear the floor; proves it where not."""
        decision = decide_one_pursuer(self.problem.floor)
        self.expanded += decision.states
        if decision.suffices is False:
            self.least = max(self.least, 2)
        if not decision.suffices or self.limits.weight == 0.0:
            return None
        return self._along(decision.way)

    def _along(self, way: Sequence[Point]) -> Plan | None:
        """One pursuer goes to the way's beginning and along it; None where that leaves somebody."""
        roadmap = self._search(False).roadmap
        points = list(dict.fromkeys((*roadmap.points, *way)))
        number = {point: i for i, point in enumerate(points)}
        lengths = np.full((len(points), len(points)), np.inf)
        n = len(roadmap.points)
        lengths[:n, :n] = roadmap.lengths
        seen = [i for i in range(n) if sees(self.mesh, points[i], way[0])]
        pairs = [(i, number[way[0]]) for i in seen]
        pairs += [(number[a], number[b]) for a, b in pairwise(way)]
        for i, j in pairs:
            (ax, ay), (bx, by) = points[i], points[j]
            lengths[i, j] = lengths[j, i] = ((ax - bx) ** 2 + (ay - by) ** 2) ** 0.5
        joined = tuple(np.flatnonzero(np.isfinite(row)) for row in lengths)
        extended = Roadmap(tuple(points), joined, lengths)
        begin = self._begin(extended, 1)
        moves = moves_of(extended, begin, [(0, [number[point] for point in way])])
        if moves is None:
            return None
        dirty = (1 << self.shadows.shadows([points[begin[0]]]).count) - 1
        for count, move in enumerate(moves):
            if dirty == 0:
                return Plan(extended, moves[:count])
            dirty = self.shadows.after((), points[move.start], points[move.end], dirty)
        return Plan(extended, moves) if dirty == 0 else None

    def _split(
        self, size: int, middles: bool, *, breadth: int, each: int, share: int = 1
    ) -> Plan | None:
        search = self._search(middles)
        drives = search.clear(
            size,
            breadth=breadth,
            each=each,
            budget=share * self.limits.budget,
            on_progress=lambda count: self._told(size, count),
        )
        self.expanded += search.spent
        search.spent = 0
        return None if drives is None else self._plan(search, drives, size)

    def _in_turn(self, size: int, middles: bool) -> Plan | None:
        search = self._search(middles)
        found = KnownMapSearch(self.shadows, search.roadmap).clear(
            self._begin(search.roadmap, size),
            weight=self.limits.weight,
            budget=self.limits.budget,
            on_progress=lambda count: self._told(size, count),
        )
        self.expanded += found.expanded
        return None if found.moves is None else Plan(search.roadmap, found.moves)

    def _search(self, middles: bool) -> SplitSearch:
        if middles not in self._splits:
            roadmap = make_roadmap(self.problem.floor, self.mesh, self._starts, middles=middles)
            self._splits[middles] = SplitSearch(self.shadows, roadmap, self.limits.weight)
        return self._splits[middles]

    def _plan(self, search: SplitSearch, drives: list[Drive], size: int) -> Plan | None:
        moves = moves_of(search.roadmap, self._begin(search.roadmap, size), drives)
        return None if moves is None else Plan(search.roadmap, moves)

    def _begin(self, roadmap: Roadmap, size: int) -> list[int]:
        starts = [one.start for one in team_of(self.problem, size)]
        return [roadmap.points.index((float(x), float(y))) for x, y in starts]

    def _told(self, size: int, count: int) -> bool:
        if self.on_progress is not None and not self.on_progress(size, count):
            self.stopped = True
        return not self.stopped
