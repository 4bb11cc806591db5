"""How large pursuit graphs are, of a whole floor and of the parts that guards leave.

[Pellier2005], section 4: O(2^n) of n critical vertices, and O(k 2^(n/k)) of k parts.
"""

from collections.abc import Iterator, Sequence
from time import perf_counter
from typing import Any, Literal, NamedTuple

import numpy as np

from conav.geometry.triangulation import Triangulation, triangulate
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.graph_parts import GraphPart, GraphParts
from conav.pursuit.navigation_graph import NavigationGraph, known_navigation_graph
from conav.pursuit.pursuit_graph import Labelling, make_pursuit_graph
from conav.pursuit.shadow_labels import ShadowLabels
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.shadow_parts import ShadowPart, ShadowParts
from conav.pursuit.split_tree import Guarded, Parts, Plan, split
from conav.pursuit.standing_guards import StandingGuards
from conav.pursuit.starts import default_start
from conav.pursuit.vertex_labels import VertexLabels
from conav.pursuit.vertex_sight import VertexSight


class GraphSize(NamedTuple):
    """Pursuit graphs of one pursuer on one floor."""

    floor: str
    labels: str
    vertices: int  # critical ones
    whole: int  # states of the whole floor's graph
    complete: bool  # False: there are more than that
    guards: int
    parts: int  # k
    parts_total: int  # states of all parts' graphs
    parts_largest: int
    whole_s: float  # wall time of making the graph of the whole floor
    parts_s: float  # of making those of all parts


class _Floor:
    """A floor and what graphs of it are made with."""

    def __init__(self, name: str) -> None:
        self.plan: PolygonMap = load_floor_plan(name)
        self.mesh: Triangulation = triangulate(self.plan.vertices, self.plan.ring_starts)
        self.graph: NavigationGraph = known_navigation_graph(
            self.plan, self.mesh, [default_start(self.plan)]
        )
        self.numbers = {tuple(p): v for v, p in enumerate(self.plan.vertices.tolist())}

    def sight_of(self, nodes: Sequence[int]) -> VertexSight:
        return VertexSight(
            self.mesh, tuple(self.numbers[self.graph.points[node]] for node in nodes)
        )


def graph_sizes(
    names: Sequence[str], labels: Literal["shadows", "paper"] = "shadows", limit: int = 20000
) -> list[GraphSize]:
    """The sizes for floors by name; a graph ends at `limit` states.

    Parts are those of `conav pursue --method splitting` with these labels. Guards that stand before
    a part see, but its graph is of the one pursuer who clears it.
    """
    return [_by_shadows(name, limit) if labels == "shadows" else _by_vertices(name, limit)
            for name in names]  # fmt: skip


def _by_shadows(name: str, limit: int) -> GraphSize:
    floor = _Floor(name)
    shadows = ShadowMoves(floor.mesh, 0)
    guards = StandingGuards(shadows, floor.graph)
    parts = ShadowParts(guards, ShadowLabels(shadows), "geometry", 3.0, 500, lambda _: True)
    plan = split(floor.graph, parts, parts.whole(), 0)
    begun = perf_counter()
    fresh = ShadowLabels(ShadowMoves(floor.mesh, 0))
    whole = make_pursuit_graph(floor.graph, fresh, [0], limit=limit)
    whole_s = perf_counter() - begun
    sizes: list[int] = []
    begun = perf_counter()
    fresh = ShadowLabels(ShadowMoves(floor.mesh, 0))
    for part, entry in _leaves(parts, plan, parts.whole(), 0):
        assert isinstance(part, ShadowPart)
        made = make_pursuit_graph(
            floor.graph,
            fresh,
            [entry],
            standing=part.guards,
            within=parts.places(part),
            contaminated=parts.contaminated(part, entry),
            limit=limit,
        )
        sizes.append(len(made.states))
    return _row(name, "shadows", floor, whole, sizes, plan, whole_s, perf_counter() - begun)


def _by_vertices(name: str, limit: int) -> GraphSize:
    floor = _Floor(name)
    parts = GraphParts(floor.graph, floor.sight_of, "degree", "seen", "all", limit, lambda _: True)
    plan = split(floor.graph, parts, parts.whole(), 0)

    def labels(part: GraphPart) -> Labelling:
        return VertexLabels(floor.graph, floor.sight_of(part.nodes), part.nodes, "all")

    begun = perf_counter()
    whole = make_pursuit_graph(floor.graph, labels(parts.whole()), [0], limit=limit)
    whole_s = perf_counter() - begun
    sizes: list[int] = []
    begun = perf_counter()
    for part, entry in _leaves(parts, plan, parts.whole(), 0):
        assert isinstance(part, GraphPart)
        made = make_pursuit_graph(
            floor.graph,
            labels(part),
            [entry],
            standing=part.guards,
            within=part.nodes,
            limit=limit,
        )
        sizes.append(len(made.states))
    return _row(name, "paper", floor, whole, sizes, plan, whole_s, perf_counter() - begun)


def _row(
    name: str,
    labels: str,
    floor: _Floor,
    whole: Any,
    sizes: list[int],
    plan: Plan,
    whole_s: float,
    parts_s: float,
) -> GraphSize:
    return GraphSize(
        name,
        labels,
        int(np.count_nonzero(floor.graph.critical)),
        len(whole.states),
        whole.complete,
        _guards(plan),
        len(sizes),
        sum(sizes),
        max(sizes, default=0),
        whole_s,
        parts_s,
    )


def _leaves(
    parts: Parts[Any], plan: Plan, part: Any, near: int
) -> Iterator[tuple[ShadowPart | GraphPart, int]]:
    """The parts that are swept, and where they are entered."""
    if not isinstance(plan, Guarded):
        yield part, plan.entry
        return
    for one, of_plan in zip(parts.beyond(part, plan.post), plan.parts, strict=True):
        yield from _leaves(parts, of_plan, one, plan.post)


def _guards(plan: Plan) -> int:
    if not isinstance(plan, Guarded):
        return 0
    return 1 + sum(_guards(part) for part in plan.parts)
