"""Streets around square blocks: floors with holes, where the number of searchers grows with k."""

from conav.maps.polygon_map import PolygonMap

STREET = 1  # [m] width
BLOCK = 3  # [m] side


def ring() -> PolygonMap:
    """A square corridor 2 m wide around a block of 8 m; two searchers, one of them walking round.

    >>> ring().area
    80.0
    """
    outer = [(0, 0), (12, 0), (12, 12), (0, 12)]
    return PolygonMap(outer, [[(2, 2), (2, 10), (10, 10), (10, 2)]], name="ring")


def streets(streets: int) -> PolygonMap:
    """That many streets each way, 1 m wide, around (streets - 1)^2 blocks of 3 m.

    >>> plan = streets(4)
    >>> len(plan.holes), plan.bounds
    (9, (0.0, 0.0, 13.0, 13.0))
    """
    pitch = STREET + BLOCK
    side = pitch * (streets - 1) + STREET
    corners = [pitch * block + STREET for block in range(streets - 1)]
    blocks = [
        [(x, y), (x, y + BLOCK), (x + BLOCK, y + BLOCK), (x + BLOCK, y)]
        for y in corners
        for x in corners
    ]
    return PolygonMap(
        [(0, 0), (side, 0), (side, side), (0, side)], blocks, name=f"streets:{streets}"
    )
