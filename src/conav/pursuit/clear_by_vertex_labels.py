"""Clearing a known floor as [Pellier2005] labels it, which may be wrong.

The pursuit graph of one pursuer is made whole, then that of two, and so on, until there is a final
state; Dijkstra's algorithm finds the drives to it. What is done then is what the labels claim. The
verifier decides whether it is true.
"""

from dataclasses import dataclass

import numpy as np

from conav.pursuit.catalogue import OnProgress
from conav.pursuit.navigation_graph import known_navigation_graph
from conav.pursuit.pursuit_graph import make_pursuit_graph, shortest_clearing
from conav.pursuit.schedule import schedule_of
from conav.pursuit.team import known_floor, may_grow, out_of_budget, team_of
from conav.pursuit.types import PursuitProblem, PursuitResult
from conav.pursuit.vertex_labels import Paths, label_all
from conav.pursuit.vertex_sight import VertexSight
from conav.status import Status


@dataclass(frozen=True)
class ClearByVertexLabels:
    """The pursuit graph over labels of critical vertices, one team size after the other."""

    paths: Paths = "all"
    """Through which vertices evaders get to clear ones: all, hidden or partly-hidden."""
    limit: int = 20000
    """States of a pursuit graph; a team whose graph has more counts as one that cannot do it."""

    def __post_init__(self) -> None:
        if self.limit < 1:
            raise ValueError(f"limit is {self.limit}; give 1 or more")

    def solve(
        self, problem: PursuitProblem, on_progress: OnProgress | None = None
    ) -> PursuitResult:
        """A plan after which all labels are clear, as the team claims.

        Raises `InputError` for a problem this method is not for: an unknown floor, limited range or
        reach, a start off the floor.
        """
        mesh = known_floor(problem)
        starts = [(float(x), float(y)) for x, y in (one.start for one in problem.pursuers)]
        graph = known_navigation_graph(problem.floor, mesh, starts)
        vertices = tuple(np.flatnonzero(problem.floor.turns < 0).tolist())
        index = {graph.points[node]: node for node in range(len(graph.points))}
        points = [tuple(problem.floor.vertices[v].tolist()) for v in vertices]
        order = np.argsort([index[point] for point in points], kind="stable").tolist()
        labels = label_all(graph, VertexSight(mesh, tuple(vertices[i] for i in order)), self.paths)
        states, size = 0, len(starts)
        while True:
            pursuers = team_of(problem, size)
            begin = [index[(float(one.start[0]), float(one.start[1]))] for one in pursuers]

            def told(count: int, size: int = size) -> bool:
                return on_progress is None or on_progress(size, count)

            found = make_pursuit_graph(graph, labels, begin, limit=self.limit, go_on=told)
            states += len(found.states)
            moves = shortest_clearing(graph, found)
            if moves is not None:
                counters = {"moves": len(moves), "states": states, "places": len(graph.points)}
                schedule = schedule_of(pursuers, graph.points, moves)
                return PursuitResult(
                    Status.DONE,
                    "",
                    schedule,
                    pursuers,
                    lower_bound=1,
                    minimal_proved=False,
                    counters=counters,
                )
            stopped = not found.complete and len(found.states) < self.limit
            if stopped or not may_grow(problem, size):
                reason = "it was stopped" if stopped else _tried(size)
                return out_of_budget(pursuers, reason, {"states": states})
            size += 1


def _tried(count: int) -> str:
    word = "pursuer" if count == 1 else "pursuers"
    return f"no pursuit graph of up to {count} {word} has a final state"
