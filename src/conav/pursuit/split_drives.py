"""Carrying out a split plan: who walks to posts, who sweeps, one part after the other or all."""

from collections import deque
from dataclasses import dataclass, field

from conav.pursuit.navigation_graph import NavigationGraph
from conav.pursuit.rounds import Rounds
from conav.pursuit.split_tree import Guarded, Plan, Sweep


def drive_in_sequence(graph: NavigationGraph, plan: Plan, rounds: Rounds) -> None:
    """Adds rounds in which one pursuer drives at a time.

    The pursuer that is stuck goes to the post, and the next one sweeps beyond it. When all beyond a
    post is clear its guard goes on with the next part. Everybody starts at a place of the graph.
    """
    at = _places(graph, rounds)
    _clear_in_turn(graph, plan, rounds, at, 0)


def _clear_in_turn(
    graph: NavigationGraph, plan: Plan, rounds: Rounds, at: list[int], pursuer: int
) -> None:
    goal = plan.entry if isinstance(plan, Sweep) else plan.post
    way = graph.way(at[pursuer], goal)[1:]
    if isinstance(plan, Sweep):
        way += [move.end for move in plan.moves]
    for place in way:
        rounds.drive({pursuer: graph.points[place]})
    at[pursuer] = way[-1] if way else at[pursuer]
    if isinstance(plan, Guarded):
        for part in plan.parts:
            _clear_in_turn(graph, part, rounds, at, pursuer + 1)


@dataclass(eq=False)
class _Job:
    """A part that is being cleared, and what waits for it."""

    plan: Plan
    pursuer: int
    above: "_Job | None"
    way: deque[int]
    begun: bool = False  # whether the parts beyond its guard are being cleared
    open_parts: int = 0


@dataclass
class _AtOnce:
    graph: NavigationGraph
    rounds: Rounds
    at: list[int]
    free: list[int]
    jobs: list[_Job] = field(default_factory=list["_Job"])

    def give(self, plan: Plan, above: _Job | None) -> None:
        """The free pursuer that is nearest takes a part."""
        goal = plan.entry if isinstance(plan, Sweep) else plan.post
        pursuer = min(self.free, key=lambda i: (self.graph.distances[self.at[i], goal], i))
        self.free.remove(pursuer)
        way = self.graph.way(self.at[pursuer], goal)[1:]
        if isinstance(plan, Sweep):
            way += [move.end for move in plan.moves]
        self.jobs.append(_Job(plan, pursuer, above, deque(way)))

    def settle(self) -> None:
        """Guards that came begin their parts; parts that are clear free pursuers."""
        waiting = deque(self.jobs)
        while waiting:
            job = waiting.popleft()
            if job.way or job not in self.jobs:
                continue
            if isinstance(job.plan, Guarded) and not job.begun:
                job.begun, job.open_parts = True, len(job.plan.parts)
                for part in job.plan.parts:
                    self.give(part, job)
                    waiting.append(self.jobs[-1])
            if isinstance(job.plan, Sweep) or job.open_parts == 0:
                self.jobs.remove(job)
                self.free.append(job.pursuer)
                if job.above is not None:
                    job.above.open_parts -= 1
                    waiting.append(job.above)


def drive_in_parallel(graph: NavigationGraph, plan: Plan, rounds: Rounds) -> None:
    """Adds rounds in which all parts beyond a post are cleared at the same time.

    The team must be as large as `in_parallel` says. A guard that is no longer needed is free for
    the parts of guards posted later.
    """
    team = _AtOnce(graph, rounds, _places(graph, rounds), list(range(len(rounds.pursuers))))
    team.give(plan, None)
    team.settle()
    while team.jobs:
        moves = {job.pursuer: job.way.popleft() for job in team.jobs if job.way}
        rounds.drive({pursuer: graph.points[place] for pursuer, place in moves.items()})
        for pursuer, place in moves.items():
            team.at[pursuer] = place
        team.settle()


def _places(graph: NavigationGraph, rounds: Rounds) -> list[int]:
    return [graph.points.index(place) for place in rounds.places]
