"""An office floor: its corridors, and what lies along them and between them."""

import numpy as np

from conav.maps.builtin.office_furniture import Cells, Kind, Opening, Room, Site, furnish
from conav.maps.builtin.office_rooms import draw_hall, draw_row, inner_wall
from conav.maps.occupancy_grid import FREE, OCCUPIED, OccupancyGrid

_OUTER_WALL_M = 0.2  # [m]
_CORRIDOR_M = (1.6, 2.4)  # [m]
_ROW_M = 2.7  # [m] no row of rooms is less deep, its wall to the corridor included
_RING_ROW_M = (3.4, 5.4)  # [m] depth of the rows outside a ring of corridors
_BLOCK_M = 3.2  # [m] no block inside it is thinner


def office(
    width_m: float, height_m: float, resolution: float, rng: np.random.Generator
) -> OccupancyGrid:
    """An office floor: corridors 1.6 to 2.4 m wide, furnished rooms, doors of 0.8 to 1 m.

    Sizes in metres, rounded to whole cells; at least 12 cells a side. A floor wide enough has
    corridors in a ring, rooms outside it along the outer walls, and inside it blocks of rooms and
    open halls; a narrower one has a corridor along its middle or its side; the smallest is a suite
    of rooms. There are a lobby and an open-plan hall where they fit. Free cells are one 4-connected
    part, and a robot of radius 0.2 m reaches every room.
    """
    rows, cols = round(height_m / resolution), round(width_m / resolution)
    cells = np.full((rows, cols), OCCUPIED, np.uint8)
    site = Site(resolution, rng)
    outer = site.cells(_OUTER_WALL_M)
    floor = cells[outer:-outer, outer:-outer]
    if rows > cols:
        floor = floor.T
    floor = floor[:: site.pick(0, 1) * 2 - 1, :: site.pick(0, 1) * 2 - 1]

    deep, corridor, row = floor.shape[0], site.cells(_CORRIDOR_M[0]), _least_row(site)
    if deep >= 2 * site.cells(_RING_ROW_M[0], least=3) + 2 * corridor + _least_block(site):
        _ring(floor, site)
    elif deep >= 2 * row + corridor:
        _spine(floor, site)
    elif deep >= row + corridor:
        _gallery(floor, site)
    else:
        draw_row(floor, site, None)
    return OccupancyGrid(cells, resolution, name="office")


def _least_row(site: Site) -> int:
    return site.cells(_ROW_M, least=2 + inner_wall(site))


def _least_block(site: Site) -> int:
    return site.cells(_BLOCK_M, least=2 + 2 * inner_wall(site))


def _corridor(site: Site, most: int) -> int:
    """A width for a corridor, `most` at most where that is not below the least."""
    least = site.cells(_CORRIDOR_M[0])
    return site.pick(least, max(least, min(most, site.cells(_CORRIDOR_M[1]))))


def _ring(floor: Cells, site: Site) -> None:
    """Draws corridors in a ring, a row of rooms on each side outside it, blocks inside it."""
    least, most = (site.cells(metres, least=3) for metres in _RING_ROW_M)
    widths: list[int] = []  # of the corridors along each axis
    spans: list[tuple[int, int]] = []  # of the ring along each axis
    for size in floor.shape:
        spare = size - 2 * least - _least_block(site)
        widths.append(_corridor(site, spare // 2))
        spare -= 2 * widths[-1]
        before = site.pick(0, min(most - least, spare))
        after = site.pick(0, min(most - least, spare - before))
        spans.append((least + before, size - least - after))
    (south, north), (west, east) = spans
    if site.chance(20):
        west = 0  # one side has no rooms: its corridor runs along the windows
    floor[south:north, west:east] = FREE
    block = floor[south + widths[0] : north - widths[0], west + widths[1] : east - widths[1]]
    block[...] = OCCUPIED
    _block(block, site)

    rows = [
        (floor[south - 1 :: -1, :], (west, east)),
        (floor[north:, :], (west, east)),
        (floor[south:north, east:].T, (0, north - south)),
    ]
    if west > 0:
        rows.append((floor[south:north, west - 1 :: -1].T, (0, north - south)))
    # The halls go to the long rows first, at one side of the floor or the other.
    order = [*site.order(2), *(2 + i for i in site.order(len(rows) - 2))]
    for rank, i in enumerate(order):
        row, corridor = rows[i]
        many = int(row.shape[1] * site.resolution / 40)
        halls: tuple[Kind, ...] = ("open",) * (many + (rank == 1))
        draw_row(row, site, corridor, halls=("lobby", *halls) if rank == 0 else halls)


def _block(block: Cells, site: Site) -> None:
    """Draws what stands between corridors: cut by corridors while it is large, then rooms."""
    if block.shape[0] > block.shape[1]:
        block = block.T
    deep, long = block.shape
    corridor = _corridor(site, site.cells(_CORRIDOR_M[1]))
    for size, limit_m, axis in ((long, site.pick(14, 30), 1), (deep, 12.5, 0)):
        least, spare = _least_block(site), size - corridor
        if size * site.resolution > limit_m and spare >= 2 * least:
            turned = block if axis == 0 else block.T
            at = min(spare - least, max(least, spare * site.pick(40, 60) // 100))
            turned[at : at + corridor] = FREE
            _block(turned[:at], site)
            _block(turned[at + corridor :], site)
            return

    wall, row = inner_wall(site), _least_row(site)
    inner = block[:, wall:-wall]
    corridor_span = (0, inner.shape[1])
    if deep >= site.cells(5.0) and site.chance(20):
        draw_hall(block, "open", site)
    elif deep >= 2 * row + wall and (deep >= site.cells(6.4) or site.chance(50)):
        at = max(row, min(deep - wall - row, (deep - wall) * site.pick(42, 58) // 100))
        draw_row(inner[:at], site, corridor_span)
        draw_row(inner[at + wall :][::-1], site, corridor_span)
    else:
        draw_row(inner, site, corridor_span, back=True)


def _spine(floor: Cells, site: Site) -> None:
    """Draws a corridor along the middle, rooms on both sides, on long floors a hall at an end."""
    row, wall = _least_row(site), inner_wall(site)
    spare = floor.shape[0] - 2 * row
    corridor = _corridor(site, spare)
    spare -= corridor
    low = row + spare * site.pick(35, 65) // 100
    high = low + corridor

    rows = floor
    if floor.shape[1] * site.resolution >= 18:
        depth = site.between(6.0, 9.0)
        hall = Room(floor[:, -depth:].T, "lobby", [Opening("front", low, high)])
        hall.cells[...] = FREE
        furnish(hall, site)
        rows = floor[:, : -depth - wall]
        floor = floor[:, :-depth]
    floor[low:high] = FREE
    halls: tuple[Kind, ...] = ("open",) * max(1, int(rows.shape[1] * site.resolution / 40))
    draw_row(rows[:low][::-1], site, (0, rows.shape[1]), halls=halls)
    draw_row(rows[high:], site, (0, rows.shape[1]))


def _gallery(floor: Cells, site: Site) -> None:
    """Draws a corridor along one side and a row of rooms along the other."""
    corridor = _corridor(site, floor.shape[0] - _least_row(site))
    floor[:corridor] = FREE
    draw_row(floor[corridor:], site, (0, floor.shape[1]), halls=("lobby",))
