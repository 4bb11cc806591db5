"""Clearing a known floor by splitting it with guards until one pursuer suffices for each part."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from conav.geometry.triangulation import Triangulation
from conav.pursuit.bounds import least_pursuers
from conav.pursuit.catalogue import OnProgress
from conav.pursuit.graph_parts import GraphCut, GraphParts, Removed
from conav.pursuit.navigation_graph import NavigationGraph, known_navigation_graph
from conav.pursuit.rounds import Rounds
from conav.pursuit.shadow_labels import ShadowLabels
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.shadow_parts import Cut, ShadowParts
from conav.pursuit.split_drives import drive_in_parallel, drive_in_sequence
from conav.pursuit.split_tree import Plan, in_parallel, in_sequence, posts, split, sweeps
from conav.pursuit.standing_guards import StandingGuards
from conav.pursuit.team import LARGEST, known_floor, out_of_budget, team_of
from conav.pursuit.together import move_together
from conav.pursuit.types import PursuitProblem, PursuitResult
from conav.pursuit.vertex_labels import Paths
from conav.pursuit.vertex_sight import VertexSight
from conav.status import Status

Order = Literal["sequence", "parallel"]


class Stopped(Exception):
    """Whoever watches the search ended it."""


@dataclass(frozen=True)
class Splitting:
    """Guards by true geometry; what is called clear is clear."""

    cut: Cut = "geometry"
    """Where a guard stands: where the largest shadow left is smallest, at the place that sees most
    others, or where the stuck pursuer is."""
    order: Order = "sequence"
    """Parts beyond a guard one after the other, or all at once, each with a pursuer of its own."""
    weight: float = 3.0
    """Metres that the square root of a contaminated square metre counts for."""
    budget: int = 500
    """States expanded for each part; one with more is split."""
    halvings: int = 0
    """How often a drive is halved at most where halves tell more of what was seen in passing."""
    together: bool = False
    """Whether drives overlap in time where the floor is cleared all the same."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.weight < float("inf"):
            raise ValueError(f"weight is {self.weight:g}; give 0 or more")
        if self.budget < 1:
            raise ValueError(f"budget is {self.budget}; give 1 or more")
        if self.halvings < 0:
            raise ValueError(f"halvings is {self.halvings}; give 0 or more")

    def solve(
        self, problem: PursuitProblem, on_progress: OnProgress | None = None
    ) -> PursuitResult:
        """A plan; its team is what splitting takes, and may be larger than need be.

        Raises `InputError` for a problem this method is not for: an unknown floor, limited range or
        reach, a start off the floor.
        """
        graph, mesh = _graph(problem)
        shadows = ShadowMoves(mesh, self.halvings)
        parts = ShadowParts(
            StandingGuards(shadows, graph),
            ShadowLabels(shadows),
            self.cut,
            self.weight,
            self.budget,
            lambda count: _watched(problem, on_progress, count),
        )
        try:
            plan = split(graph, parts, parts.whole(), 0)
        except Stopped:
            return out_of_budget(problem.pursuers, "it was stopped", {"states": parts.expanded})
        counters = {"states": parts.expanded, "largest": parts.largest}
        result = _carried_out(problem, graph, plan, self.order, counters, sound=True)
        if not self.together or result.status is not Status.DONE:
            return result
        sooner = move_together(result.schedule, result.pursuers, ShadowMoves(mesh))
        counters = {**result.counters, "moves": len(sooner.active)}
        return replace(result, schedule=sooner, counters=counters)


@dataclass(frozen=True)
class SplittingByVertexLabels:
    """Splitting of the navigation graph with labels of its vertices, as [Pellier2005] has it.

    What it claims may be wrong.
    """

    cut: GraphCut = "degree"
    """Where a guard stands: at the node of highest degree, or where the stuck pursuer is."""
    removed: Removed = "seen"
    """The nodes a guard takes from the graph: all it sees, or those of them somebody visited."""
    order: Order = "sequence"
    """Parts beyond a guard one after the other, or all at once, each with a pursuer of its own."""
    paths: Paths = "all"
    """Through which vertices evaders get to clear ones: all, hidden or partly-hidden."""
    limit: int = 20000
    """States of a pursuit graph; a part whose graph has more is split."""

    def __post_init__(self) -> None:
        if self.limit < 1:
            raise ValueError(f"limit is {self.limit}; give 1 or more")

    def solve(
        self, problem: PursuitProblem, on_progress: OnProgress | None = None
    ) -> PursuitResult:
        """A plan after which all labels of all parts were clear, as the team claims.

        Raises `InputError` as `Splitting.solve`.
        """
        graph, mesh = _graph(problem)
        vertex = {tuple(point): v for v, point in enumerate(problem.floor.vertices.tolist())}

        def sight_of(nodes: Sequence[int]) -> VertexSight:
            return VertexSight(mesh, tuple(vertex[graph.points[node]] for node in nodes))

        parts = GraphParts(
            graph,
            sight_of,
            self.cut,
            self.removed,
            self.paths,
            self.limit,
            lambda count: _watched(problem, on_progress, count),
        )
        try:
            plan = split(graph, parts, parts.whole(), 0)
        except Stopped:
            return out_of_budget(problem.pursuers, "it was stopped", {"states": parts.states})
        counters = {"states": parts.states, "largest": parts.largest}
        return _carried_out(problem, graph, plan, self.order, counters, sound=False)


def _graph(problem: PursuitProblem) -> tuple[NavigationGraph, Triangulation]:
    mesh = known_floor(problem)
    starts = [(float(x), float(y)) for x, y in (one.start for one in problem.pursuers)]
    return known_navigation_graph(problem.floor, mesh, starts), mesh


def _watched(problem: PursuitProblem, on_progress: OnProgress | None, count: int) -> bool:
    if on_progress is not None and not on_progress(len(problem.pursuers), count):
        raise Stopped
    return True


def _carried_out(
    problem: PursuitProblem,
    graph: NavigationGraph,
    plan: Plan,
    order: Order,
    counters: dict[str, int],
    *,
    sound: bool,
) -> PursuitResult:
    needed = in_sequence(plan) if order == "sequence" else in_parallel(plan)
    size = max(needed, len(problem.pursuers))
    counters = {
        **counters,
        "places": len(graph.points),
        "guards": len(list(posts(plan))),
        "parts": len(list(sweeps(plan))),
    }
    if size > LARGEST or (problem.most is not None and size > problem.most):
        how = "in turn" if order == "sequence" else "at once"
        reason = f"splitting takes {needed} pursuers {how}"
        return out_of_budget(problem.pursuers, f"{reason}; allow more", counters)
    pursuers = team_of(problem, size)
    rounds = Rounds.of(pursuers)
    drive = drive_in_sequence if order == "sequence" else drive_in_parallel
    drive(graph, plan, rounds)
    counters["moves"] = len(rounds.active)
    least = min(least_pursuers(problem.floor), size)
    return PursuitResult(
        Status.DONE,
        "",
        rounds.schedule(),
        pursuers,
        lower_bound=least,
        minimal_proved=sound and size == least,
        counters=counters,
    )
