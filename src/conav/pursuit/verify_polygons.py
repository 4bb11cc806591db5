"""Faces and hidden regions as polygons in floating point: for witnesses, paths and people.

Nothing that is decided rests on these numbers: what is made of them is checked exactly.
"""

from collections.abc import Iterator

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.pursuit.verify_lattice import Point
from conav.pursuit.verify_step import Step

Ints = NDArray[np.int64]

MOST_FACES = 12  # looked at for a witness, largest first


def node_places(step: Step) -> NDArray[np.float64]:
    """The nodes of an arrangement, shape (nodes, 2), in lattice units."""
    places = np.empty((len(step.faces.nodes), 2))
    both = step.lines[step.faces.nodes].reshape(-1, 6)
    for k, (a, b, c, d, e, f) in enumerate(both.tolist()):
        # Exact integers, divided once.
        w = a * e - b * d
        places[k] = (b * f - c * e) / w, (c * d - a * f) / w
    return places


def face_polygons(step: Step, which: Ints) -> list[shapely.Polygon]:
    """These faces, in lattice units."""
    faces = step.faces
    begin = np.full(faces.faces, -1, dtype=np.int64)
    own = np.flatnonzero(faces.same == np.arange(len(faces.same)))
    begin[faces.face[own[::-1]]] = own[::-1]
    places = node_places(step)
    result: list[shapely.Polygon] = []
    for f in which.tolist():
        at = first = int(begin[f])
        corners: list[int] = []
        while True:
            corners.append(int(faces.tail[at]))
            at = int(faces.after[at])
            if at == first:
                break
        result.append(shapely.Polygon(places[_without_spurs(corners)]))
    return result


def _without_spurs(corners: list[int]) -> list[int]:
    """A closed walk without the edges it goes to and fro, ends of segments within a face."""
    walk: list[int] = []
    for corner in corners:
        walk.append(corner)
        while len(walk) > 2 and walk[-1] == walk[-3]:
            del walk[-2:]
    while len(walk) > 3 and walk[1] == walk[-1]:
        walk = walk[1:-1]
    while len(walk) > 3 and walk[0] == walk[-2]:
        walk = walk[:-2]
    return walk


def face_points(step: Step, which: Ints) -> Iterator[Point]:
    """Lattice points inside some of these faces, those of large faces first."""
    polygons = sorted(face_polygons(step, which), key=lambda one: -one.area)[:MOST_FACES]
    for polygon in polygons:
        # A region may be seen in passing save for a part near its walls.
        inside = polygon.representative_point()
        yield _rounded(inside.x, inside.y)
        centre = polygon.centroid
        if polygon.contains(centre):
            yield _rounded(centre.x, centre.y)
        corners = np.asarray(polygon.exterior.coords)[:-1]
        for x, y in corners.tolist():
            near = (0.9 * x + 0.1 * inside.x, 0.9 * y + 0.1 * inside.y)
            if shapely.contains_xy(polygon, *near):
                yield _rounded(*near)


def region_polygon(step: Step, which: Ints) -> shapely.Geometry:
    """The union of these faces, in lattice units."""
    return shapely.union_all(face_polygons(step, which))


def _rounded(x: float, y: float) -> Point:
    return round(x), round(y)
