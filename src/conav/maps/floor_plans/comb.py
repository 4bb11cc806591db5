"""A straight corridor with deep teeth.

One searcher sweeps it from end to end with all of the corridor in sight; guards who stand still
need one a tooth.
"""

from conav.maps.polygon_map import PolygonMap


def comb(teeth: int) -> PolygonMap:
    """The comb with that many teeth, 4 teeth + 4 corners: a corridor 1 m wide, teeth 4 m deep.

    >>> len(comb(6).outer)
    28
    """
    outer: list[tuple[float, float]] = [(0, 0), (2 * teeth + 1, 0), (2 * teeth + 1, 1)]
    for tooth in reversed(range(teeth)):
        x = 2 * tooth + 1
        outer += [(x + 1, 1), (x + 1, 5), (x, 5), (x, 1)]
    outer.append((0, 1))
    return PolygonMap(outer, name=f"comb:{teeth}")
