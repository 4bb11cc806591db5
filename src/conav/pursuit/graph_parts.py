"""Parts of the navigation graph, as [Pellier2005] splits it: regions without a vertex are lost."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from conav.pursuit.known_map import Move
from conav.pursuit.navigation_graph import NavigationGraph, parts_without
from conav.pursuit.pursuit_graph import make_pursuit_graph, shortest_clearing
from conav.pursuit.vertex_labels import Paths, VertexLabels
from conav.pursuit.vertex_sight import VertexSight

GraphCut = Literal["degree", "stuck"]
Removed = Literal["seen", "visited"]


class GraphPart(NamedTuple):
    """Nodes of the navigation graph, and where guards stand."""

    guards: tuple[int, ...]
    nodes: tuple[int, ...]


@dataclass
class GraphParts:
    """Connected parts of the navigation graph.

    A part is cut at its node of highest degree (`degree`, section 3.3) or where the stuck pursuer
    is (`stuck`, section 4); the node and all nodes it sees are taken away, or of these only nodes
    somebody visited (`visited`, section 4). One pursuer tries a part on its own nodes, with labels
    of its own vertices.
    """

    graph: NavigationGraph
    sight_of: Callable[[Sequence[int]], VertexSight]
    cut: GraphCut
    removed: Removed
    paths: Paths
    limit: int
    go_on: Callable[[int], bool]
    states: int = 0
    largest: int = 0  # states of one pursuit graph
    visited: set[int] = field(default_factory=set[int])

    def whole(self) -> GraphPart:
        """All critical vertices."""
        nodes = [node for node, yes in enumerate(self.graph.critical.tolist()) if yes]
        self.visited |= {node for node, yes in enumerate(self.graph.visited.tolist()) if yes}
        return GraphPart((), tuple(nodes))

    def places(self, part: GraphPart) -> tuple[int, ...]:
        return part.nodes

    def standing(self, part: GraphPart) -> tuple[int, ...]:
        return part.guards

    def swept(self, part: GraphPart, entry: int) -> tuple[Move, ...] | None:
        labels = VertexLabels(self.graph, self.sight_of(part.nodes), part.nodes, self.paths)
        found = make_pursuit_graph(
            self.graph,
            labels,
            [entry],
            standing=part.guards,
            within=part.nodes,
            limit=self.limit,
            go_on=lambda count: self.go_on(self.states + count),
        )
        self.states += len(found.states)
        self.largest = max(self.largest, len(found.states))
        moves = shortest_clearing(self.graph, found)
        self.visited |= {entry, *(move.end for move in moves or ())}
        return moves

    def post(self, part: GraphPart, entry: int) -> int:
        if self.cut == "stuck" and entry in part.nodes:
            return entry
        inside = set(part.nodes)
        return min(
            part.nodes,
            key=lambda node: (-len(inside.intersection(self.graph.joined[node].tolist())), node),
        )

    def beyond(self, part: GraphPart, post: int) -> list[GraphPart]:
        self.visited.add(post)
        graph = self.graph.with_visits(sorted(self.visited))
        rest = parts_without(graph, part.nodes, post, visited_only=self.removed == "visited")
        return [GraphPart((*part.guards, post), nodes) for nodes in rest]
