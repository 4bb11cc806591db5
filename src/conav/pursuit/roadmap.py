"""Where pursuers may stand, and which straight drives join those places.

Places are the critical vertices of the floor, its reflex vertices, the starts,
and, where vertices do not suffice, the middles of triangles of the floor. Two are joined where they
see each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.geometry.sight_lines import sees, visible_vertices
from conav.geometry.triangulation import Triangulation
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.shadow_moves import Point


@dataclass(frozen=True, eq=False)
class Roadmap:
    """Places and the drives between them."""

    points: tuple[Point, ...]
    joined: tuple[NDArray[np.int64], ...]  # of each place those it sees, by number
    lengths: NDArray[np.float64]  # (n, n) [m] straight, inf where not joined


def make_roadmap(
    floor: PolygonMap, mesh: Triangulation, starts: Sequence[Point], *, middles: bool
) -> Roadmap:
    """The roadmap of a floor; starts first, then critical vertices, then middles of triangles."""
    points = list(dict.fromkeys(starts))
    vertices = [tuple(row) for row in floor.vertices[floor.turns < 0].tolist()]
    points += [point for point in vertices if point not in points]
    if middles or not vertices:
        centres = mesh.vertices[mesh.triangles].mean(axis=1)
        points += [tuple(row) for row in centres.tolist()]
    return join_places(mesh, points)


def join_places(mesh: Triangulation, points: Sequence[Point]) -> Roadmap:
    """The roadmap of these places, all different, on a floor."""
    n = len(points)
    index = {point: number for number, point in enumerate(points)}
    at = np.array(points)
    lengths = np.full((n, n), np.inf)
    vertex_of = [index.get(tuple(row), -1) for row in mesh.vertices.tolist()]
    vertex_of = np.array(vertex_of)
    on_vertex = vertex_of >= 0
    bare = sorted(set(range(n)) - set(vertex_of[on_vertex].tolist()))
    for i, point in enumerate(points):
        seen = np.zeros(n, np.bool_)
        seen[vertex_of[on_vertex]] = visible_vertices(mesh, *point)[on_vertex]
        for j in bare:
            seen[j] = sees(mesh, point, points[j])
        lengths[i, seen] = np.sqrt(((at[seen] - at[i]) ** 2).sum(axis=1))
        lengths[i, i] = np.inf
    lengths = np.minimum(lengths, lengths.T)
    joined = tuple(np.flatnonzero(np.isfinite(row)) for row in lengths)
    return Roadmap(tuple(points), joined, lengths)
