"""How few pursuers can certainly not clear a floor."""

from conav.geometry.star_shaped import star_centre
from conav.maps.polygon_map import PolygonMap


def least_pursuers(floor: PolygonMap) -> int:
    """2 where a hole is star-shaped, else 1.

    Around a hole that is star-shaped around a point o one pursuer can be evaded for ever: the
    evader keeps to the point of the hole's border that lies, from o, opposite to the pursuer. A ray
    from o leaves the hole once, so this point moves continuously, and the straight line from the
    pursuer to it passes through o, which is no floor.
    """
    return 2 if any(star_centre(hole[::-1]) is not None for hole in floor.holes) else 1
