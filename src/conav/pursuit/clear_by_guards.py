"""Standing guards: pursuers drive to posts from which they see everything."""

from dataclasses import dataclass
from typing import Literal

from conav.pursuit.beliefs import beliefs_of
from conav.pursuit.bounds import least_pursuers
from conav.pursuit.catalogue import OnProgress
from conav.pursuit.drives import moves_of
from conav.pursuit.guard_posts import guard_posts
from conav.pursuit.roadmap import make_roadmap
from conav.pursuit.schedule import schedule_of
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.team import known_floor, out_of_budget, team_of
from conav.pursuit.types import PursuitProblem, PursuitResult
from conav.status import Status


@dataclass(frozen=True)
class ClearByGuards:
    """Standing guards at critical vertices [Couto2011]."""

    cover: Literal["greedy", "fewest"] = "greedy"
    """How posts are chosen: greedily, or as few critical vertices as there can be."""

    def solve(
        self, problem: PursuitProblem, on_progress: OnProgress | None = None
    ) -> PursuitResult:
        """Drives to the posts, one pursuer after the other.

        Infeasible is said for no floor: more guards than allowed does not mean that no plan exists.
        Raises `InputError` for a problem this method is not for: an unknown floor, limited range or
        reach, a start off the floor.
        """
        mesh = known_floor(problem)
        first = len(problem.pursuers)
        if on_progress is not None and not on_progress(first, 0):
            return out_of_budget(problem.pursuers, "it was stopped", {})
        starts = [(float(one.start[0]), float(one.start[1])) for one in problem.pursuers]
        roadmap = make_roadmap(problem.floor, mesh, starts, middles=False)
        posts = guard_posts(mesh, roadmap.points, exact=self.cover == "fewest")
        if posts is None:
            return out_of_budget(problem.pursuers, "more than 62 guards are needed", {})
        size = max(first, len(posts.places))
        counters = {"guards": len(posts.places), "guards_needed": posts.least}
        if problem.most is not None and size > problem.most:
            reason = f"{size} guards are needed, and {problem.most} may be sent"
            return out_of_budget(problem.pursuers, reason, counters)
        pursuers = team_of(problem, size)
        begin = [roadmap.points.index((float(x), float(y))) for x, y in (p.start for p in pursuers)]
        moves = moves_of(roadmap, begin, [(who, [post]) for who, post in enumerate(posts.places)])
        if moves is None:
            return out_of_budget(problem.pursuers, "a post cannot be reached", counters)
        schedule = schedule_of(pursuers, roadmap.points, moves)
        least = min(least_pursuers(problem.floor), size)
        return PursuitResult(
            Status.DONE,
            "",
            schedule,
            pursuers,
            lower_bound=least,
            minimal_proved=size == least,
            counters=counters | {"moves": len(moves), "places": len(roadmap.points)},
            beliefs=beliefs_of(ShadowMoves(mesh), schedule),
        )
