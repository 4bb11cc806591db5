"""What stands in the rooms of an office: desks, tables, shelves, pillars.

The rule that keeps every room in one piece: a piece of furniture either touches a wall or leaves a
gap a robot passes through, never touches two walls that face each other, and keeps that gap to
every other piece; and nothing stands in front of a door.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from conav.maps.occupancy_grid import OCCUPIED

Side = Literal["front", "back", "left", "right"]
Kind = Literal["office", "meeting", "store", "open", "lobby"]
Cells = NDArray[np.uint8]

_GAP_M = 0.75  # [m] clear width around furniture
_DOOR_CLEAR_M = 0.9  # [m] nothing stands so far in front of a door
_COARSEST_M = 0.5  # [m] in larger cells a desk would look like a wall
_SIDES: tuple[Side, ...] = ("front", "back", "left", "right")


@dataclass(frozen=True)
class Site:
    """How metres become cells, and where chance comes from."""

    resolution: float  # [m]
    rng: np.random.Generator

    def cells(self, metres: float, least: int = 1) -> int:
        """A length in whole cells, `least` at least."""
        return max(least, round(metres / self.resolution))

    def between(self, low_m: float, high_m: float, least: int = 1) -> int:
        """A length drawn between two, in whole cells."""
        return self.pick(self.cells(low_m, least), self.cells(high_m, least))

    def pick(self, low: int, high: int) -> int:
        """A whole number from `low` to `high`, both included."""
        return int(self.rng.integers(low, high + 1))

    def chance(self, percent: int) -> bool:
        return self.pick(0, 99) < percent

    def order(self, count: int) -> list[int]:
        """The numbers from 0 to before `count` in an order drawn."""
        return [int(i) for i in self.rng.permutation(count)]


@dataclass(frozen=True)
class Opening:
    """A door or gap in a side of a room, from cell `low` to before cell `high` along that side."""

    side: Side
    low: int
    high: int


@dataclass
class Room:
    """The floor of a room: a view of the map whose row 0 lies along the front."""

    cells: Cells  # (depth, width)
    kind: Kind
    openings: list[Opening] = field(default_factory=list[Opening])


_Box = tuple[int, int, int, int]  # first row, first column, past-the-end row, past-the-end column


class _Fitting:
    """A room that is being furnished: what is taken, and whether another piece fits."""

    def __init__(self, room: Room, site: Site) -> None:
        self.cells = room.cells
        self.site = site
        self.depth, self.width = room.cells.shape
        self.gap = math.ceil(_GAP_M / site.resolution)
        self.kept_clear = [self._before(opening) for opening in room.openings]
        self.pieces: list[_Box] = []

    def _before(self, opening: Opening) -> _Box:
        reach, spare = self.site.cells(_DOOR_CLEAR_M), self.site.cells(0.1, least=0)
        across = (0, reach)
        if opening.side in ("back", "right"):
            end = self.depth if opening.side == "back" else self.width
            across = (end - reach, end)
        along = (opening.low - spare, opening.high + spare)
        if opening.side in ("front", "back"):
            return (across[0], along[0], across[1], along[1])
        return (along[0], across[0], along[1], across[1])

    def put(self, *parts: _Box) -> bool:
        """Draws a piece made of touching parts, if the box around them all fits."""
        box = (
            min(part[0] for part in parts),
            min(part[1] for part in parts),
            max(part[2] for part in parts),
            max(part[3] for part in parts),
        )
        if not self._fits(box):
            return False
        self.pieces.append(box)
        for top, left, bottom, right in parts:
            self.cells[top:bottom, left:right] = OCCUPIED
        return True

    def _fits(self, box: _Box) -> bool:
        for low, high, end in ((box[0], box[2], self.depth), (box[1], box[3], self.width)):
            before, after = low, end - high
            if before < 0 or after < 0 or before == after == 0:
                return False
            if 0 < before < self.gap or 0 < after < self.gap:
                return False
        return not (
            any(_overlap(box, other, 0) for other in self.kept_clear)
            or any(_overlap(box, other, self.gap) for other in self.pieces)
        )

    def against(self, side: Side, piece: list[_Box], *, corner: bool = True) -> bool:
        """Puts a piece with its back to a wall where it fits, in a corner or elsewhere."""
        low = 0 if corner else self.gap
        high = self._wall(side) - max(part[2] for part in piece) - low
        if high < low:
            return False
        spots = [low, high, (low + high) // 2]
        spots = [spots[i] for i in self.site.order(3)]
        spots += [self.site.pick(low, high) for _ in range(4)]
        return any(self.stand(side, piece, spot) for spot in spots)

    def stand(self, side: Side, piece: list[_Box], at: int) -> bool:
        """Puts a piece with its back to a wall, `at` cells along it, if it fits there.

        Its parts are boxes along the wall and away from it.
        """
        parts = [(low + at, near, high + at, far) for low, near, high, far in piece]
        return self.put(*(self._turned(side, part) for part in parts))

    def _wall(self, side: Side) -> int:
        return self.width if side in ("front", "back") else self.depth

    def _turned(self, side: Side, part: _Box) -> _Box:
        """A box given along and away from a wall, in rows and columns of the room."""
        low, near, high, far = part
        if side == "front":
            return (near, low, far, high)
        if side == "back":
            return (self.depth - far, low, self.depth - near, high)
        if side == "left":
            return (low, near, high, far)
        return (low, self.width - far, high, self.width - near)


def _overlap(one: _Box, other: _Box, gap: int) -> bool:
    return (
        one[0] < other[2] + gap
        and other[0] < one[2] + gap
        and one[1] < other[3] + gap
        and other[1] < one[3] + gap
    )


def furnish(room: Room, site: Site) -> None:
    """Draws the furniture of a room into it, as much of it as fits; none in coarse cells."""
    if site.resolution > _COARSEST_M:
        return
    _RECIPES[room.kind](_Fitting(room, site), site)


def _office(room: _Fitting, site: Site) -> None:
    """Desks at the walls, two together in larger rooms, and shelves."""
    area_m2 = room.depth * room.width * site.resolution * site.resolution
    if area_m2 > 18 and site.chance(60) and room.against("back", _pod(site), corner=False):
        area_m2 -= 12
    for side in _shuffled(("left", "right", "back"), site)[: max(1, int(area_m2 / 7))]:
        room.against(side, _desk(site))
    for side in _shuffled(_SIDES, site)[: max(1, int(area_m2 / 9))]:
        room.against(side, _shelf(site))


def _meeting(room: _Fitting, site: Site) -> None:
    """A table in the middle with chairs, as wide as the room allows, and a cupboard."""
    wide = room.width >= room.depth
    long_m = min(3.2, max(room.width, room.depth) * site.resolution - 2.4)
    for deep_m, chairs in ((1.2, True), (0.9, True), (0.7, False)):
        if _table(room, site, max(1.2, long_m), deep_m, chairs=chairs, wide=wide):
            break
    room.against(_shuffled(_SIDES, site)[0], _shelf(site))


def _store(room: _Fitting, site: Site) -> None:
    """Shelves along the walls."""
    for side in ("left", "right", "back"):
        for _ in range(3):
            room.against(side, _shelf(site))


def _open(room: _Fitting, site: Site) -> None:
    """Rows of desks: islands with aisles between, or desks that stand out from the back wall."""
    if not _islands(room, site):
        piece = _pod(site)
        length = max(part[2] for part in piece)
        count = room.width // (length + site.cells(1.0))
        for at in _spread(room.width, count, length):
            room.stand("back", piece, at)
    for side in _shuffled((*_SIDES, *_SIDES), site):
        room.against(side, _shelf(site))


def _lobby(room: _Fitting, site: Site) -> None:
    """A reception desk, pillars in a row, benches and plants along the walls."""
    desk, deep = site.cells(2.4), site.cells(0.7)
    behind = max(room.gap, site.cells(1.2))
    at = (room.width - desk) // 2
    room.put((room.depth - behind - deep, at, room.depth - behind, at + desk))
    pillar, front = site.cells(0.4), max(room.gap, site.cells(1.0))
    for part in (1, 3):
        at = room.width * part // 4 - pillar // 2
        room.put((front, at, front + pillar, at + pillar))
    for side in _shuffled(("left", "right", "back"), site):
        room.against(side, [(0, 0, site.cells(1.6), site.cells(0.7))])
    for side in _shuffled(("left", "right", "back", "back"), site):
        room.against(side, [(0, 0, pillar, pillar)])


_RECIPES: dict[Kind, Callable[[_Fitting, Site], None]] = {
    "office": _office,
    "meeting": _meeting,
    "store": _store,
    "open": _open,
    "lobby": _lobby,
}


def _shuffled(sides: tuple[Side, ...], site: Site) -> list[Side]:
    return [sides[i] for i in site.order(len(sides))]


def _chairs(site: Site) -> bool:
    """Whether a cell is small enough to show a chair."""
    return site.resolution <= 0.2


def _shelf(site: Site) -> list[_Box]:
    return [(0, 0, site.between(0.8, 1.6), site.cells(0.4))]


def _desk(site: Site) -> list[_Box]:
    """A desk with its back to the wall and a chair before it."""
    long, deep, seat = site.cells(1.6), site.cells(0.8), site.cells(0.5)
    middle = (long - seat) // 2
    chair = [(middle, deep, middle + seat, deep + seat)] if _chairs(site) else []
    return [(0, 0, long, deep), *chair]


def _pod(site: Site) -> list[_Box]:
    """Two desks side by side, standing out from the wall, with chairs on both sides.

    Not for a corner, where a chair would cut off the space between itself and the back wall.
    """
    long, deep, seat = site.cells(1.6), site.cells(0.8), site.cells(0.5)
    if not _chairs(site):
        return [(0, 0, 2 * deep, long)]
    low, end, middle = seat, seat + 2 * deep, (long - seat) // 2
    chairs = [(at, middle, at + seat, middle + seat) for at in (0, end)]
    return [(low, 0, end, long), *chairs]


def _table(
    room: _Fitting, site: Site, long_m: float, deep_m: float, *, chairs: bool, wide: bool
) -> bool:
    """A table in the middle of the room, chairs along both long sides; whether it fitted."""
    long, deep, seat = site.cells(long_m), site.cells(deep_m), site.cells(0.45)
    length, depth = (room.width, room.depth) if wide else (room.depth, room.width)
    low, near = (length - long) // 2, (depth - deep) // 2
    parts = [(near, low, near + deep, low + long)]
    count = max(1, int(long_m / 0.75)) if chairs and _chairs(site) else 0
    for chair in range(count):
        at = low + long * (2 * chair + 1) // (2 * count) - seat // 2
        parts += [(row, at, row + seat, at + seat) for row in (near - seat, near + deep)]
    if not wide:
        parts = [(left, top, right, bottom) for top, left, bottom, right in parts]
    return room.put(*parts)


def _islands(room: _Fitting, site: Site) -> bool:
    """Desks back to back in the middle of a hall, as many as it holds; whether there are any."""
    desk, deep = site.cells(1.6), site.cells(0.8)
    seat = site.cells(0.5) if _chairs(site) else 0
    across, aisle = 2 * (deep + seat), max(room.gap, site.cells(1.1))
    rows = (room.depth - 2 * room.gap + aisle) // (across + aisle)

    def in_a_row(desks: int) -> int:
        return (room.width - 2 * room.gap + aisle) // (desks * desk + aisle)

    desks = max((1, 2, 3), key=lambda desks: desks * in_a_row(desks))
    cols = in_a_row(desks)
    placed = 0
    for row in _spread(room.depth, rows, across):
        low, high = row + seat, row + across - seat
        for col in _spread(room.width, cols, desks * desk):
            parts = [(low, col, high, col + desks * desk)]
            for chair in range(desks if seat else 0):
                at = col + chair * desk + (desk - seat) // 2
                parts += [(at_row, at, at_row + seat, at + seat) for at_row in (row, high)]
            if not site.chance(10):
                placed += room.put(*parts)
    return placed > 0


def _spread(length: int, count: int, size: int) -> list[int]:
    """Where so many things of that size start along a length, with equal space around them."""
    spare = length - count * size
    return [spare * (i + 1) // (count + 1) + size * i for i in range(count)]
