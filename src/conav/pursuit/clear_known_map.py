"""Clearing a known floor with as few pursuers as are found to suffice.

Teams grow one by one from those the problem begins with. Each size is searched on the critical
vertices, and where these do not suffice with middles of triangles beside them. A size no plan is
found for is not proved to be too small: the budget may have ended, or other places might do. Posts
that see the whole floor end the growth, where 60 of them are enough.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from conav.pursuit.beliefs import beliefs_of
from conav.pursuit.catalogue import OnProgress
from conav.pursuit.guard_posts import guard_posts
from conav.pursuit.known_map import KnownMapSearch, Move
from conav.pursuit.roadmap import Roadmap, make_roadmap
from conav.pursuit.schedule import schedule_of
from conav.pursuit.team import known_floor, may_grow, out_of_budget, team_of
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult
from conav.status import Status


@dataclass(frozen=True)
class ClearKnownMap:
    """Search over places and contaminated shadows, one team size after the other."""

    places: Literal["auto", "vertices", "all"] = "auto"
    """Critical vertices, or middles of triangles beside them; auto tries the first first."""
    weight: float = 3.0
    """Metres that the square root of a contaminated square metre counts for; 0 looks for the
    shortest plan on the roadmap, which takes much longer."""
    budget: int = 2000
    """States expanded for each team size and roadmap."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.weight < float("inf"):
            raise ValueError(f"weight is {self.weight:g}; give 0 or more")
        if self.budget < 1:
            raise ValueError(f"budget is {self.budget}; give 1 or more")

    def solve(
        self, problem: PursuitProblem, on_progress: OnProgress | None = None
    ) -> PursuitResult:
        """A plan, and what it rests on.

        Raises `InputError` for a problem this method is not for: an unknown floor, limited range or
        reach, a start off the floor.
        """
        mesh = known_floor(problem)
        starts = [(float(one.start[0]), float(one.start[1])) for one in problem.pursuers]
        first = len(starts)
        searches: list[KnownMapSearch] = []
        for middles in (False, True):
            if self.places in ("auto", "all" if middles else "vertices"):
                roadmap = make_roadmap(problem.floor, mesh, starts, middles=middles)
                searches.append(KnownMapSearch(mesh, roadmap))
        posts: tuple[int, ...] | None = None
        expanded, size = 0, first
        while True:
            pursuers = team_of(problem, size)
            if posts is not None and size >= len(posts):
                moves = ways_to_posts(searches[0].roadmap, _begin(searches[0], pursuers), posts)
                if moves is not None:
                    return _result(problem, pursuers, searches[0], moves, expanded, searches)
            for search in searches:

                def told(count: int, size: int = size) -> bool:
                    return on_progress is None or on_progress(size, count)

                found = search.clear(
                    _begin(search, pursuers),
                    weight=self.weight,
                    budget=self.budget,
                    on_progress=told,
                )
                expanded += found.expanded
                if found.moves is not None:
                    return _result(problem, pursuers, search, found.moves, expanded, searches)
                if not found.exhausted and found.expanded < self.budget:
                    return out_of_budget(pursuers, "it was stopped", {"expanded": expanded})
            if not may_grow(problem, size):
                return out_of_budget(pursuers, no_plan(size), {"expanded": expanded})
            if size == first:
                posts = guard_posts(searches[0].roadmap, searches[0].shadows)
            size += 1


def _begin(search: KnownMapSearch, pursuers: tuple[Pursuer, ...]) -> list[int]:
    points = search.roadmap.points
    return [points.index((float(one.start[0]), float(one.start[1]))) for one in pursuers]


def ways_to_posts(roadmap: Roadmap, begin: list[int], posts: tuple[int, ...]) -> list[Move] | None:
    """Moves that take one pursuer to each post, by shortest ways; None where there is no way."""
    lengths = np.where(np.isfinite(roadmap.lengths), roadmap.lengths, 0.0)
    _, before = dijkstra(csr_matrix(lengths), directed=False, return_predecessors=True)
    moves: list[Move] = []
    for start, post in zip(begin, posts, strict=False):
        way = [post]
        while way[-1] != start:
            previous = int(before[start, way[-1]])
            if previous < 0:
                return None
            way.append(previous)
        way.reverse()
        moves += [Move(a, b) for a, b in pairwise(way)]
    return moves


def _result(
    problem: PursuitProblem,
    pursuers: tuple[Pursuer, ...],
    search: KnownMapSearch,
    moves: list[Move] | tuple[Move, ...],
    expanded: int,
    searches: list[KnownMapSearch],
) -> PursuitResult:
    schedule = schedule_of(pursuers, search.roadmap.points, moves)
    return PursuitResult(
        Status.DONE,
        "",
        schedule,
        pursuers,
        lower_bound=1,
        minimal_proved=len(pursuers) == 1,
        counters={
            "moves": len(moves),
            "expanded": expanded,
            "arrangements": sum(one.shadows.arrangements for one in searches),
            "places": len(search.roadmap.points),
        },
        beliefs=beliefs_of(search.shadows, schedule),
    )


def no_plan(count: int) -> str:
    """Why a search of a team of this size that found nothing was given up, in words."""
    word = "pursuer" if count == 1 else "pursuers"
    return f"no plan for {count} {word} was found; more pursuers or a larger budget may find one"
