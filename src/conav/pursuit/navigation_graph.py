"""The navigation graph: critical vertices, who sees whom, and how far it is to drive.

[Pellier2005], section 3.1. Critical vertices are the reflex vertices of the floor, and pursuers
drive from one to another that it sees. The graph of a known floor is complete at once. On an
unknown floor it grows: a node counts as visited when somebody was there. The paper joins a node to
those seen from it when somebody stands there; here two are joined as soon as it is certain that
they see each other, that is when the segment between them lies in the known region, and so are two
that nobody visited. Functions take either.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from conav.geometry.triangulation import Triangulation
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.roadmap import join_places, make_roadmap
from conav.pursuit.shadow_moves import Point
from conav.pursuit.survey import Survey

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class NavigationGraph:
    """Places pursuers drive between. Those that are not critical are where pursuers start."""

    points: tuple[Point, ...]  # [m]
    critical: Flags  # (n,) whether a place is a critical vertex
    visited: Flags  # (n,) whether somebody was there
    lengths: Floats  # (n, n) [m] of straight drives, inf where two do not see each other

    @cached_property
    def joined(self) -> tuple[Ints, ...]:
        """Of each place those it sees."""
        return tuple(np.flatnonzero(np.isfinite(row)) for row in self.lengths)

    @cached_property
    def _shortest(self) -> tuple[Floats, Ints]:
        direct = np.where(np.isfinite(self.lengths), self.lengths, 0.0)
        found = dijkstra(csr_matrix(direct), directed=False, return_predecessors=True)
        return found[0], found[1].astype(np.int64)

    @property
    def distances(self) -> Floats:
        """Of shortest ways along edges, shape (n, n) [m], inf where there is none."""
        return self._shortest[0]

    def way(self, start: int, end: int) -> list[int]:
        """The places on the shortest way, both included; raises `ValueError` without one."""
        before = self._shortest[1]
        way = [end]
        while way[-1] != start:
            previous = int(before[start, way[-1]])
            if previous < 0:
                raise ValueError(f"no way leads from place {start} to place {end}")
            way.append(previous)
        return way[::-1]

    def seen_from(self, node: int) -> Flags:
        """The critical vertices joined to a place, itself among them, shape (n,)."""
        seen = np.isfinite(self.lengths[node])
        seen[node] = True
        return seen & self.critical

    def with_visits(self, nodes: Sequence[int]) -> "NavigationGraph":
        """The same graph with these places visited too."""
        visited = self.visited.copy()
        visited[list(nodes)] = True
        return replace(self, visited=visited)


def known_navigation_graph(
    floor: PolygonMap, mesh: Triangulation, starts: Sequence[Point]
) -> NavigationGraph:
    """The navigation graph of a known floor; starts are its first places, and visited."""
    roadmap = make_roadmap(floor, mesh, starts, middles=False)
    reflex = {tuple(row) for row in floor.vertices[floor.turns < 0].tolist()}
    critical = np.array([point in reflex for point in roadmap.points])
    visited = np.array([point in set(starts) for point in roadmap.points])
    return NavigationGraph(roadmap.points, critical, visited, roadmap.lengths)


def surveyed_navigation_graph(survey: Survey, places: Sequence[Point]) -> NavigationGraph:
    """The navigation graph of what is known of a floor: these places, then critical vertices."""
    roadmap = join_places(survey.mesh, list(dict.fromkeys((*places, *survey.critical))))
    flags = [
        np.array([point in known for point in roadmap.points], dtype=np.bool_)
        for known in (set(survey.critical), set(survey.visited))
    ]
    return NavigationGraph(roadmap.points, flags[0], flags[1], roadmap.lengths)


def parts_without(
    graph: NavigationGraph, nodes: Sequence[int], cut: int, *, visited_only: bool
) -> list[tuple[int, ...]]:
    """The parts into which a node and all it sees cut a part of the graph, growing inside.

    [Pellier2005], SplitEnvironment: the cut and its neighbours are taken from `nodes`, and
    connected components of the rest are returned, in the order of their first node; with
    `visited_only` neighbours nobody has visited stay (section 4).
    """
    taken = graph.seen_from(cut)
    if visited_only:
        taken = taken & graph.visited
    rest = [node for node in nodes if not taken[node] and node != cut]
    parts: list[tuple[int, ...]] = []
    left = set(rest)
    for node in rest:
        if node not in left:
            continue
        part, waiting = [node], [node]
        left.discard(node)
        while waiting:
            for other in graph.joined[waiting.pop()].tolist():
                if other in left:
                    left.discard(other)
                    part.append(other)
                    waiting.append(other)
        parts.append(tuple(sorted(part)))
    return parts
