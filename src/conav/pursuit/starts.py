"""Where pursuers enter when nobody says."""

import numpy as np

from conav.geometry.triangulation import triangulate
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.shadow_moves import Point


def default_start(floor: PolygonMap) -> Point:
    """The middle [m] of the largest triangle of the floor; of equals the first."""
    mesh = triangulate(floor.vertices, floor.ring_starts)
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    x, y = ((a + b + c) / 3.0)[int(np.argmax(twice))].tolist()
    return x, y
