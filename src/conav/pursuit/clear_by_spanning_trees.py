"""Guaranteed search with spanning trees on the graph of a floor's triangles [Hollinger2010]."""

from dataclasses import dataclass, field

import numpy as np

from conav.geometry.triangulation import Triangulation
from conav.pursuit.bounds import least_pursuers
from conav.pursuit.catalogue import OnProgress
from conav.pursuit.rounds import Rounds
from conav.pursuit.spanning_tree_search import SpanningTreeSearch, Step, random_spanning_tree
from conav.pursuit.team import LARGEST, known_floor, out_of_budget, team_of
from conav.pursuit.tree_search_number import tree_search_number
from conav.pursuit.triangle_graph import TriangleGraph
from conav.pursuit.types import PursuitProblem, PursuitResult
from conav.status import Status


@dataclass(frozen=True)
class ClearBySpanningTrees:
    """Searchers of a graph, as a baseline: all they know of sight is that triangles are convex.

    A searcher of a triangle stands on a corner of it and sees all of it. It goes over to a
    neighbour by a corner that both share, from which it sees both.
    """

    trees: int = 100
    """Spanning trees tried; on a floor without holes there is one."""
    seed: int = 0
    """Of the random trees."""

    def __post_init__(self) -> None:
        if self.trees < 1:
            raise ValueError(f"trees is {self.trees}; give 1 or more")
        if self.seed < 0:
            raise ValueError(f"seed is {self.seed}; give 0 or more")

    def solve(
        self, problem: PursuitProblem, on_progress: OnProgress | None = None
    ) -> PursuitResult:
        """The plan of the tree with the fewest searchers, of these the shortest.

        Raises `InputError` for a problem this method is not for: an unknown floor, limited range or
        reach, a start off the floor.
        """
        mesh = known_floor(problem)
        graph = TriangleGraph.of(mesh)
        rng = np.random.default_rng(self.seed)
        simple = len(graph.edges) == len(graph.neighbours) - 1
        best: _Carried | None = None
        for number in range(1 if simple else self.trees):
            if on_progress is not None and not on_progress(len(problem.pursuers), number):
                return out_of_budget(problem.pursuers, "it was stopped", {"trees": number})
            tree = graph.neighbours if simple else random_spanning_tree(graph.neighbours, rng)
            found = _Carried(graph, problem, [list(row) for row in tree])
            if best is None or found.rank < best.rank:
                best = found
        assert best is not None  # one tree at least
        counters = {"trees": 1 if simple else self.trees, "triangles": len(graph.neighbours)}
        if simple:
            counters["search_number"] = tree_search_number(graph.edges)
        size = len(best.searchers)
        if size > LARGEST or (problem.most is not None and size > problem.most):
            reason = f"{size} pursuers are needed along the best of these trees; allow more"
            return out_of_budget(problem.pursuers, reason, counters)
        pursuers = team_of(problem, size)
        rounds = Rounds.of(pursuers)
        for who, vertex in best.drives:
            x, y = mesh.vertices[vertex].tolist()
            if rounds.places[who] != (x, y):
                rounds.drive({who: (x, y)})
        least = min(least_pursuers(problem.floor), size)
        return PursuitResult(
            Status.DONE,
            "",
            rounds.schedule(),
            pursuers,
            lower_bound=least,
            minimal_proved=size == least,
            counters={**counters, "moves": len(rounds.active)},
        )


@dataclass
class _Carried:
    """A search along a tree, carried out on corners."""

    graph: TriangleGraph
    problem: PursuitProblem
    tree: list[list[int]]
    searchers: list[int] = field(default_factory=list[int])
    """The corner of each; -1 while it is at its start."""
    drives: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])
    """Who goes to which corner next."""
    length: float = 0.0

    def __post_init__(self) -> None:
        self._starts = [one.start for one in self.problem.pursuers]
        begin = [_triangle_of(self.graph.mesh, start) for start in self._starts]
        self._begin = begin
        self.searchers = [-1] * len(begin)
        search = SpanningTreeSearch(
            self.graph.neighbours, self.tree, list(begin), self._nearest, self._moved
        )
        search.clear()

    @property
    def rank(self) -> tuple[int, float]:
        """Fewer searchers first, then shorter ways."""
        return len(self.searchers), self.length

    def _nearest(self, free: list[int], vertex: int, goal: int) -> int:
        return min(free, key=lambda i: (self._way(i, vertex, goal)[0], i))

    def _way(self, who: int, vertex: int, goal: int) -> tuple[float, list[int]]:
        """A shortest way to a corner of the door, and its length [m]."""
        points, distances = self.graph.mesh.vertices, self.graph.distances
        door = self.graph.door(vertex, goal)
        at = self.searchers[who] if who < len(self.searchers) else -1
        if at >= 0:
            length, end = min((float(distances[at, end]), end) for end in door)
            return length, self.graph.way(at, end)[1:]
        here = who if who < len(self._begin) else 0
        start = np.array(self._starts[here])
        options: list[tuple[float, int, int]] = []
        for first in self.graph.corners(self._begin[here]):
            there = float(np.sqrt(((points[first] - start) ** 2).sum()))
            options += [(there + float(distances[first, end]), first, end) for end in door]
        length, first, end = min(options)
        return length, self.graph.way(first, end)

    def _moved(self, step: Step) -> None:
        if step.searcher == len(self.searchers):
            self.searchers.append(-1)
        length, way = self._way(step.searcher, step.origin, step.goal)
        self.length += length
        self.drives += [(step.searcher, corner) for corner in way]
        if way:
            self.searchers[step.searcher] = way[-1]


def _triangle_of(mesh: Triangulation, start: tuple[float, float]) -> int:
    """The triangle a point lies in, but for rounding: where it lies deepest."""
    corners = mesh.vertices[mesh.triangles]
    after = np.roll(corners, -1, axis=1)
    side, to = after - corners, np.array(start) - corners
    turn = side[..., 0] * to[..., 1] - side[..., 1] * to[..., 0]
    depth = turn / np.sqrt((side**2).sum(axis=2))
    return int(np.argmax(depth.min(axis=1)))
