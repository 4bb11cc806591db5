"""The graph of a floor's triangles: which share a side that is no wall."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from conav.geometry.triangulation import Triangulation

Edge = tuple[int, int]


@dataclass(frozen=True, eq=False)
class TriangleGraph:
    """Triangles of a triangulation as vertices of a graph; a tree on floors without holes.

    A pursuer on a corner of a triangle sees all of it, as it is convex. On a corner that two
    triangles share it sees both, so it gets from one into the other without losing sight of either.
    """

    mesh: Triangulation
    neighbours: tuple[tuple[int, ...], ...]  # of each triangle, growing
    distances: NDArray[np.float64]  # (v, v) [m] along sides of triangles
    _before: NDArray[np.int32]  # (v, v) on the way from the first, the corner before the second

    @classmethod
    def of(cls, mesh: Triangulation) -> "TriangleGraph":
        """The graph of a triangulation."""
        neighbours = tuple(
            tuple(sorted({other for other in row if other >= 0}))
            for row in mesh.neighbours.tolist()
        )
        a = mesh.triangles.reshape(-1)
        b = np.roll(mesh.triangles, -1, axis=1).reshape(-1)
        pairs = np.unique(np.sort(np.stack([a, b], axis=1), axis=1), axis=0)
        lengths = np.sqrt(((mesh.vertices[pairs[:, 0]] - mesh.vertices[pairs[:, 1]]) ** 2).sum(1))
        n = len(mesh.vertices)
        graph = coo_matrix((lengths, (pairs[:, 0], pairs[:, 1])), shape=(n, n)).tocsr()
        distances, before = dijkstra(graph, directed=False, return_predecessors=True)
        return cls(mesh, neighbours, distances, before)

    @property
    def edges(self) -> list[Edge]:
        """All pairs of neighbours, the smaller first, growing."""
        return [(a, b) for a, row in enumerate(self.neighbours) for b in row if a < b]

    def corners(self, triangle: int) -> tuple[int, ...]:
        """The vertices of a triangle."""
        return tuple(self.mesh.triangles[triangle].tolist())

    def door(self, a: int, b: int) -> tuple[int, ...]:
        """The vertices that two neighbours share, growing."""
        return tuple(sorted({*self.corners(a)} & {*self.corners(b)}))

    def way(self, a: int, b: int) -> list[int]:
        """The vertices from one to another along sides, by a shortest way, both ends included."""
        way = [b]
        while way[-1] != a:
            way.append(int(self._before[a, way[-1]]))
        return way[::-1]
