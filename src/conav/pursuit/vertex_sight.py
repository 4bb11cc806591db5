"""Which critical vertices a place sees, and of which it sees the walls. All decisions exact.

A point that sees both ends of a segment on the floor sees all of it unless a hole lies in the
triangle they form: its sides are on the floor then, so walls inside belong to rings inside.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conav.geometry.predicates import orientation
from conav.geometry.sight_lines import visible_vertices
from conav.geometry.triangulation import Triangulation
from conav.pursuit.shadow_moves import Point


@dataclass
class VertexSight:
    """What places see of chosen vertices of a floor; bit i stands for vertex i of `vertices`."""

    mesh: Triangulation
    vertices: tuple[int, ...]  # of the mesh
    _seen: dict[Point, NDArray[np.bool_]] = field(
        default_factory=dict[Point, NDArray[np.bool_]], repr=False
    )

    @property
    def everything(self) -> int:
        """All vertices, as bits."""
        return (1 << len(self.vertices)) - 1

    def seen(self, place: Point) -> int:
        """The vertices seen from a place [m], as bits."""
        seen = self._all(place)
        return sum(1 << i for i, v in enumerate(self.vertices) if seen[v])

    def walls(self, place: Point) -> tuple[int, int]:
        """The vertices whose wall before, and whose wall after, is seen entirely, as bits."""
        before = np.empty_like(self.mesh.wall_ends)
        before[self.mesh.wall_ends] = np.arange(len(before))
        came = gone = 0
        for i, v in enumerate(self.vertices):
            came |= self._wall(place, int(before[v]), v) << i
            gone |= self._wall(place, v, int(self.mesh.wall_ends[v])) << i
        return came, gone

    def throughout(self, a: Point, b: Point) -> int:
        """The vertices seen all the way along a drive between two places, as bits."""
        both = self.seen(a) & self.seen(b)
        for i, v in enumerate(self.vertices):
            if both >> i & 1 and self._hole_in(a, b, self._point(v)):
                both ^= 1 << i
        return both

    def _wall(self, place: Point, v: int, w: int) -> bool:
        seen = self._all(place)
        if not (seen[v] and seen[w]):
            return False
        return not self._hole_in(place, self._point(v), self._point(w))

    def _hole_in(self, a: Point, b: Point, c: Point) -> bool:
        """Whether a hole lies in the closed triangle, whose sides are on the floor."""
        rings = self.mesh.rings
        if int(rings[-1]) == 0:
            return False
        turn = orientation(*a, *b, *c)
        if turn == 0:
            return False
        inside = np.ones(len(rings), np.bool_)
        for p, q in ((a, b), (b, c), (c, a)):
            for v, (x, y) in enumerate(self.mesh.vertices.tolist()):
                inside[v] &= orientation(*p, *q, x, y) * turn >= 0
        holes = range(1, int(rings[-1]) + 1)
        return any(bool(inside[rings == hole].all()) for hole in holes)

    def _all(self, place: Point) -> NDArray[np.bool_]:
        if place not in self._seen:
            self._seen[place] = visible_vertices(self.mesh, *place)
        return self._seen[place]

    def _point(self, v: int) -> Point:
        x, y = self.mesh.vertices[v].tolist()
        return x, y
