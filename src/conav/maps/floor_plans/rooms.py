"""Rooms on both sides of a corridor, each behind a narrow door and wider than the door."""

from conav.maps.polygon_map import PolygonMap


def rooms(rooms: int) -> PolygonMap:
    """That many rooms of 8 m x 6 m behind doors 2 m wide, along a corridor 3 m wide.

    Rooms are 10 m apart, the first above the corridor, then below and above in turn.

    >>> len(rooms(3).outer)
    28
    """
    below: list[tuple[float, float]] = []
    above: list[tuple[float, float]] = []
    for room in range(rooms):
        x = 10 * room + 5
        if room % 2:
            x -= 1
            below += [(x - 1, 0), (x - 1, -2), (x - 4, -2), (x - 4, -8)]
            below += [(x + 4, -8), (x + 4, -2), (x + 1, -2), (x + 1, 0)]
        else:
            above += [(x - 1, 3), (x - 1, 5), (x - 4, 5), (x - 4, 11)]
            above += [(x + 4, 11), (x + 4, 5), (x + 1, 5), (x + 1, 3)]
    length = 10 * rooms
    outer = [(0, 0), *below, (length, 0), (length, 3), *reversed(above), (0, 3)]
    return PolygonMap(outer, name=f"rooms:{rooms}")
