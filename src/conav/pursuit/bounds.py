"""How few pursuers can certainly not clear a floor."""

from conav.geometry.star_shaped import star_centre
from conav.maps.floor_plans.triples import triples
from conav.maps.polygon_map import PolygonMap

_NESTED = {20: 2, 80: 3}
"""Corners of nested triples -> depth: those for which the tests check the theorem's condition."""


def least_pursuers(floor: PolygonMap) -> int:
    """So many are needed: the depth of nested triples, 2 where a hole is star-shaped, else 1.

    Around a hole that is star-shaped around a point o one pursuer can be evaded for ever: the
    evader keeps to the point of the hole's border that lies, from o, opposite to the pursuer. A ray
    from o leaves the hole once, so this point moves continuously, and the straight line from the
    pursuer to it passes through o, which is no floor.

    `triples(k)` needs k. That is Parsons' theorem on trees [Parsons1976], carried over to floors as
    `conav.maps.floor_plans.triples` argues, under a condition on who sees into which copy. It is a
    theorem about these floors, not a computation on this one: a floor counts as nested triples only
    where it has the very corners of `triples(2)` or `triples(3)`.
    """
    nested = _depth_of_triples(floor)
    if nested:
        return nested
    return 2 if any(star_centre(hole[::-1]) is not None for hole in floor.holes) else 1


def _depth_of_triples(floor: PolygonMap) -> int:
    """Of nested triples, whichever corner comes first; 0 of other floors."""
    depth = _NESTED.get(len(floor.outer), 0)
    if depth == 0 or floor.holes:
        return 0
    return depth if _from_least(floor) == _from_least(triples(depth)) else 0


def _from_least(floor: PolygonMap) -> list[list[float]]:
    ring: list[list[float]] = floor.outer.tolist()
    first = ring.index(min(ring))
    return [*ring[first:], *ring[:first]]
