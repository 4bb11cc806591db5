"""Random office floors: rows of rooms along corridors that form loops."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conav.geometry.outline import trace_rings
from conav.maps.polygon_map import PolygonMap

UNIT = 0.25  # [m] thickness of a wall; all lengths below are in units
LENGTH = 144
CORRIDOR = 8
DOOR = 4
ROOM_WIDTH = (10, 20)
ROOM_DEPTH = (14, 20)


def office_loops(corridors: int, seed: int) -> PolygonMap:
    """An office floor 36 m long with that many parallel corridors, joined at both ends.

    Corridors are 2 m wide, rooms 2.5 m to 5 m wide behind doors of 1 m. Rooms lie along both
    sides of each corridor; a third of the neighbours in a row have a door between them, and most
    rows that stand back to back one through both. Blocks of rooms between corridors are holes.

    >>> len(office_loops(2, 0).holes) > 0
    True
    """
    rng = np.random.Generator(np.random.PCG64(seed))
    depths = [int(depth) for depth in rng.integers(*ROOM_DEPTH, size=2 * corridors, endpoint=True)]
    # From below: a row, its wall, a corridor, a wall, a row, a wall, a row, a wall, a corridor ...
    height = sum(depths) + corridors * (CORRIDOR + 2) + corridors - 1
    floor = np.zeros((height, LENGTH), dtype=np.uint8)
    bottom, behind = 0, None
    first = last = depths[0] + 1
    for corridor in range(corridors):
        below, above = depths[2 * corridor], depths[2 * corridor + 1]
        street = bottom + below + 1
        floor[street : street + CORRIDOR] = 1
        ends = [CORRIDOR + 1 if inner else 0 for inner in (corridor > 0, corridor < corridors - 1)]
        low = _row(floor, bottom, below, street - 1, ends[0], rng)
        if behind is not None:
            _through_door(floor, bottom - 1, behind, low, rng)
        top = street + CORRIDOR + 1
        behind = _row(floor, top, above, top - 1, ends[1], rng)
        bottom = top + above + 1
        last = street + CORRIDOR
    floor[first:last, :CORRIDOR] = 1
    floor[first:last, LENGTH - CORRIDOR :] = 1
    rings = [ring * UNIT for ring in trace_rings(floor, False, 1.0 / 1024.0)]
    return PolygonMap(rings[0], rings[1:], name=f"office-loops:corridors={corridors},seed={seed}")


def _row(
    floor: NDArray[np.uint8],
    bottom: int,
    depth: int,
    wall: int,
    end: int,
    rng: np.random.Generator,
) -> list[tuple[int, int]]:
    """Draws a row of rooms with doors in row `wall`; the columns [start, stop) of each room.

    `end` columns at both ends stay free for the corridors that cross.
    """
    rooms: list[tuple[int, int]] = []
    start, stop = end, LENGTH - end
    while start < stop:
        width = int(rng.integers(*ROOM_WIDTH, endpoint=True))
        # What is left must be a room with its wall, or nothing.
        width = stop - start if stop - start - width < ROOM_WIDTH[0] + 1 else width
        rooms.append((start, start + width))
        start += width + 1
    for left, right in rooms:
        floor[bottom : bottom + depth, left:right] = 1
        door = int(rng.integers(left + 1, right - DOOR, endpoint=False))
        floor[wall, door : door + DOOR] = 1
    for (_, right), _ in pairwise(rooms):
        if int(rng.integers(3)) == 0:
            door = bottom + int(rng.integers(1, depth - DOOR, endpoint=False))
            floor[door : door + DOOR, right] = 1
    return rooms


def _through_door(
    floor: NDArray[np.uint8],
    wall: int,
    below: list[tuple[int, int]],
    above: list[tuple[int, int]],
    rng: np.random.Generator,
) -> None:
    """Draws one door between rooms that stand back to back, where two share enough wall."""
    shared = [
        (max(a[0], b[0]), min(a[1], b[1]))
        for a in below
        for b in above
        if min(a[1], b[1]) - max(a[0], b[0]) >= DOOR + 2
    ]
    if shared:
        left, right = shared[int(rng.integers(len(shared)))]
        door = int(rng.integers(left + 1, right - DOOR, endpoint=False))
        floor[wall, door : door + DOOR] = 1
