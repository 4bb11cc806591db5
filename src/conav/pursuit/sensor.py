"""What a pursuer senses on a floor nobody gave it: the walls it sees, and where depth jumps.

The sensor alone holds the floor. A scan tells the pursuer's surroundings and no more: pieces of
walls, corners, and windows, the places where the depth jumps [Pellier2005, section 3.1]. Walls and
corners that are seen again are recognised; their labels say nothing else.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.geometry.triangulation import triangulate
from conav.geometry.visibility import HIT, WINDOW, visibility_polygon
from conav.maps.polygon_map import PolygonMap

Point = tuple[float, float]


class Scan(NamedTuple):
    """What is seen from a place; side i runs from corner i to corner i + 1, counter-clockwise."""

    place: Point  # [m]
    corners: NDArray[np.float64]  # (k, 2) [m]
    at_vertex: NDArray[np.bool_]  # (k,) whether a corner is one of the floor, else a window's end
    on_wall: NDArray[np.int64]  # (k,) the wall that a window ends at, -1 for corners of the floor
    walls: NDArray[np.int64]  # (k,) the wall each side is a piece of, -1 for a window


class Sensor:
    """Looks round on a floor that nobody else has."""

    def __init__(self, floor: PolygonMap) -> None:
        self._mesh = triangulate(floor.vertices, floor.ring_starts)
        self.looks = 0

    def look(self, place: Point) -> Scan:
        """The scan from a place [m]; one without corners where it is off the floor."""
        self.looks += 1
        seen = visibility_polygon(self._mesh, *place)
        return Scan(
            place,
            seen.corners,
            seen.vertices != HIT,
            np.where(seen.vertices == HIT, seen.hit_walls, -1),
            np.where(seen.walls == WINDOW, -1, seen.walls),
        )
