"""Rows of rooms and halls of an office: where walls and doors stand.

Both are drawn into views of the map. The view of a row is turned so that its row 0 is the wall to
the corridor, whichever way the corridor lies on the map.
"""

import math
from itertools import pairwise

from conav.maps.builtin.office_furniture import Cells, Kind, Opening, Room, Side, Site, furnish
from conav.maps.occupancy_grid import FREE, OCCUPIED

_WALL_M = 0.1  # [m] between rooms
_DOOR_M = (0.8, 1.0)  # [m] least and greatest clear width
_GATE_M = (1.6, 2.4)  # [m] the same for the openings of a hall
_GATE_EVERY_M = 6.0  # [m] of a hall's wall
_MODULE_M = 1.3  # [m] room widths are multiples of it, as window fronts have them
_HALL_MODULES = (5, 8)
# Rooms by width in modules, each as often as it is listed.
_ROOMS: tuple[tuple[int, Kind], ...] = (
    (2, "office"),
    (2, "office"),
    (2, "office"),
    (2, "store"),
    (3, "office"),
    (3, "office"),
    (3, "meeting"),
    (4, "office"),
    (4, "meeting"),
    (5, "meeting"),
)


def inner_wall(site: Site) -> int:
    """The thickness of the walls between rooms [cells]."""
    return site.cells(_WALL_M)


def draw_row(
    row: Cells,
    site: Site,
    corridor: tuple[int, int] | None,
    *,
    back: bool = False,
    halls: tuple[Kind, ...] = (),
) -> None:
    """Draws rooms side by side, with doors and furniture, into a solid part of the map.

    `row` is a view (depth, length) whose row 0 lies next to the corridor, which is there from the
    first to before the second column of `corridor`, or nowhere. With `back` another corridor runs
    behind the last row. The view's ends have walls already. `halls` are drawn among the rooms as
    far as there is space. Every room is reached from the corridor, some of them through others.
    """
    wall = inner_wall(site)
    front, rear = (wall if corridor else 0), (wall if back else 0)
    inside = row[front : row.shape[0] - rear, :]
    shares = _shares(row.shape[1], site, halls)
    rooms = [Room(inside[:, start:end], kind) for start, end, kind in shares]
    for room in rooms:
        room.cells[...] = FREE

    reached = [False] * len(rooms)
    if corridor:
        for i, (room, (start, end, _)) in enumerate(zip(rooms, shares, strict=True)):
            if room.kind == "office" and i > 0 and reached[i - 1] and site.chance(8):
                continue  # entered through a neighbour, as a director's room through the office
            sides: list[Side] = ["front", "back"] if back else ["front"]
            if back and room.kind in ("office", "store"):
                sides = [sides[site.pick(0, 1)]]
            for side in sides:
                low, high = max(start, corridor[0]), min(end, corridor[1])
                for door in _doors(low, high, room.kind, site):
                    lines = row[:front] if side == "front" else row[row.shape[0] - rear :]
                    lines[:, door[0] : door[1]] = FREE
                    room.openings.append(Opening(side, door[0] - start, door[1] - start))
                    reached[i] = True
    _link(inside, rooms, shares, reached, site)

    for room in rooms:
        for part in _divided(room, site):
            furnish(part, site)


def draw_hall(block: Cells, kind: Kind, site: Site) -> None:
    """Draws a furnished hall into a solid block with corridors, or the like, on all four sides."""
    wall = inner_wall(site)
    room = Room(block[wall:-wall, wall:-wall], kind)
    room.cells[...] = FREE
    walls: tuple[tuple[Side, Cells], ...] = (
        ("front", block[:wall, wall:-wall]),
        ("back", block[-wall:, wall:-wall]),
        ("left", block[wall:-wall, :wall].T),
        ("right", block[wall:-wall, -wall:].T),
    )
    for side, lines in walls:
        for low, high in _doors(0, lines.shape[1], kind, site):
            lines[:, low:high] = FREE
            room.openings.append(Opening(side, low, high))
    furnish(room, site)


def _shares(length: int, site: Site, halls: tuple[Kind, ...]) -> list[tuple[int, int, Kind]]:
    """First and past-the-end column and kind of each room, with walls between them."""
    wall = inner_wall(site)
    module = site.cells(_MODULE_M, least=wall + 1)
    left = max(1, (length + wall) // module)
    sizes: list[tuple[int, Kind]] = []
    for kind in halls:
        size = min(site.pick(*_HALL_MODULES), left - 2)
        if size >= 4:
            sizes.append((size, kind))
            left -= size
    while left > 0:
        size, kind = _ROOMS[site.pick(0, len(_ROOMS) - 1)]
        if left - size < 2:
            size = left  # no room is one module wide, and this one is six at most
        sizes.append((size, kind))
        left -= size
    sizes = [sizes[i] for i in site.order(len(sizes))]
    ends = [0]
    for size, _ in sizes:
        ends.append(ends[-1] + size * module)
    ends[-1] = length + wall
    return [
        (start, end - wall, kind)
        for (start, end), (_, kind) in zip(pairwise(ends), sizes, strict=True)
    ]


def _doors(low: int, high: int, kind: Kind, site: Site) -> list[tuple[int, int]]:
    """First and past-the-end cell of each opening in a wall from `low` to before `high`."""
    if kind == "lobby":
        return [(low, high)] if high - low >= site.cells(_GATE_M[0]) else []
    if kind == "open":
        parts = max(1, (high - low) // site.cells(_GATE_EVERY_M))
        cuts = [low + (high - low) * part // parts for part in range(parts + 1)]
        gates = [_door(first, last, site, _GATE_M) for first, last in pairwise(cuts)]
        if all(gates):
            return [gate for gate in gates if gate]
    door = _door(low, high, site, _DOOR_M)
    return [door] if door else []


def _door(low: int, high: int, site: Site, metres: tuple[float, float]) -> tuple[int, int] | None:
    """A place for a door in a wall from `low` to before `high`, near an end of it or anywhere."""
    # Whole cells between the least and the greatest width, where there is such a number.
    least = math.ceil(metres[0] / site.resolution - 1e-9)
    most = math.floor(metres[1] / site.resolution + 1e-9)
    width = site.pick(least, most) if least <= most else site.cells(sum(metres) / 2)
    spare = high - low - width
    if spare < 0:
        return None
    jamb = min(site.cells(0.2, least=0), spare // 2)
    at = (jamb, spare - jamb, site.pick(jamb, spare - jamb))[site.pick(0, 2)]
    return low + at, low + at + width


def _link(
    inside: Cells,
    rooms: list[Room],
    shares: list[tuple[int, int, Kind]],
    reached: list[bool],
    site: Site,
) -> None:
    """Draws doors between neighbours: where one is not reached yet, and in places elsewhere."""
    reached[0] = reached[0] or not any(reached)
    links = {i for i in range(len(rooms) - 1) if site.chance(12)}
    for i in range(len(rooms) - 1):
        if reached[i] and not reached[i + 1]:
            reached[i + 1] = True
            links.add(i)
    for i in reversed(range(len(rooms) - 1)):
        if reached[i + 1] and not reached[i]:
            reached[i] = True
            links.add(i)
    for i in sorted(links):
        door = _door(0, inside.shape[0], site, _DOOR_M) or (0, inside.shape[0])
        inside[door[0] : door[1], shares[i][1] : shares[i + 1][0]] = FREE
        rooms[i].openings.append(Opening("right", *door))
        rooms[i + 1].openings.append(Opening("left", *door))


def _divided(room: Room, site: Site) -> list[Room]:
    """The room, or the two parts of it when it is deep and gets a small room at its back."""
    depth, width = room.cells.shape
    wall, small = inner_wall(site), site.between(1.6, 2.2, least=2)
    used = [site.cells(2.6)]  # the front part keeps its doors
    used += [opening.high for opening in room.openings if opening.side in ("left", "right")]
    used += [depth for opening in room.openings if opening.side == "back"]
    cut = depth - small - wall
    if room.kind in ("open", "lobby") or cut < max(used) or not site.chance(30):
        return [room]
    door = _door(0, width, site, _DOOR_M)
    if door is None:
        return [room]
    room.cells[cut : cut + wall] = OCCUPIED
    room.cells[cut : cut + wall, door[0] : door[1]] = FREE
    front = Room(room.cells[:cut], room.kind, [*room.openings, Opening("back", *door)])
    return [front, Room(room.cells[cut + wall :], "store", [Opening("front", *door)])]
