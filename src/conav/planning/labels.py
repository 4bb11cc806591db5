"""Labels: which regions a robot is in, and how that changes along a straight line.

A label is a mask, bit i for region i of the discs, then the polygons. Regions are closed: their
border belongs to them. Two borders that the line meets within `SAME` of each other count as met
together, and there regions are entered before others are left, as a closed border shared by two
regions has it. Where rounding could change what is found (a corner on the line, or an end on a
border) the line has no word, and is not used.
"""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.errors import InputError
from conav.geometry.clearance import point_segment_square
from conav.planning.types import Region

SAME = 1e-9  # [m]
MAX_REGIONS = 62
MAX_EVENTS = 64
UNCLEAR = -1
_BITS = 2 * MAX_EVENTS


class Regions(NamedTuple):
    """Arrays for kernels, in the order in which these take them; bits in the order of rows."""

    discs: NDArray[np.float64]  # (n, 3) x, y, radius [m]
    rings: NDArray[np.float64]  # (m, 6) first side, end of sides, least x, y, greatest x, y [m]
    sides: NDArray[np.float64]  # (k, 4) x0, y0, x1, y1 [m] of the polygons


def in_order_of_bits(regions: Iterable[Region]) -> tuple[Region, ...]:
    """The regions as labels number them: discs, then polygons."""
    return tuple(sorted(regions, key=lambda region: region.disc is None))


def build_regions(regions: Sequence[Region]) -> Regions:
    """The regions, in the order of bits, as arrays. Raises `InputError` above `MAX_REGIONS`."""
    if len(regions) > MAX_REGIONS:
        raise InputError(
            "regions", f"a task speaks of {len(regions)}, and at most {MAX_REGIONS} are followed"
        )
    discs = [region.disc for region in regions if region.disc is not None]
    polygons = [region.polygon for region in regions if region.polygon is not None]
    ends = np.cumsum([0, *map(len, polygons)])
    rings = [
        [ends[i], ends[i + 1], *ring.min(axis=0), *ring.max(axis=0)]
        for i, ring in enumerate(polygons)
    ]
    sides = [np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in polygons]
    return Regions(
        np.array(discs, dtype=np.float64).reshape(-1, 3),
        np.array(rings, dtype=np.float64).reshape(-1, 6),
        np.concatenate([np.empty((0, 4)), *sides]),
    )


@kernel
def point_label(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    x: float,
    y: float,
) -> int:
    """The label of a place."""
    mask = 0
    for i in range(len(discs)):
        dx = x - discs[i, 0]
        dy = y - discs[i, 1]
        if dx * dx + dy * dy <= discs[i, 2] * discs[i, 2]:
            mask |= 1 << i
    for i in range(len(rings)):
        if in_polygon(rings, sides, i, x, y):
            mask |= 1 << (len(discs) + i)
    return mask


@kernel
def in_polygon(
    rings: NDArray[np.float64], sides: NDArray[np.float64], polygon: int, x: float, y: float
) -> bool:
    """Whether a place is in that polygon or on its border."""
    if (
        x < rings[polygon, 2]
        or y < rings[polygon, 3]
        or x > rings[polygon, 4]
        or y > rings[polygon, 5]
    ):
        return False
    inside = False
    for side in range(int(rings[polygon, 0]), int(rings[polygon, 1])):
        x0, y0, x1, y1 = sides[side]
        if point_segment_square(x, y, x0, y0, x1, y1) == 0.0:
            return True
        if (y0 > y) != (y1 > y):
            turn = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
            if (turn > 0.0) == (y1 > y0):
                inside = not inside
    return inside


@kernel
def on_border(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    x: float,
    y: float,
) -> bool:
    """Whether a place is so near a border that rounding could decide its label."""
    for i in range(len(discs)):
        dx = x - discs[i, 0]
        dy = y - discs[i, 1]
        if abs(math.sqrt(dx * dx + dy * dy) - discs[i, 2]) <= SAME:
            return True
    for i in range(len(rings)):
        if (
            x < rings[i, 2] - SAME
            or y < rings[i, 3] - SAME
            or x > rings[i, 4] + SAME
            or y > rings[i, 5] + SAME
        ):
            continue
        for side in range(int(rings[i, 0]), int(rings[i, 1])):
            x0, y0, x1, y1 = sides[side]
            if point_segment_square(x, y, x0, y0, x1, y1) <= SAME * SAME:
                return True
    return False


@kernel
def meets_regions(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    ax: float,
    ay: float,
    bx: float,
    by: float,
) -> bool:
    """Whether the boxes around a line and around a region meet: else it has no word to find."""
    left = min(ax, bx) - SAME
    right = max(ax, bx) + SAME
    low = min(ay, by) - SAME
    high = max(ay, by) + SAME
    for i in range(len(discs)):
        x = discs[i, 0]
        y = discs[i, 1]
        r = discs[i, 2]
        if left <= x + r and right >= x - r and low <= y + r and high >= y - r:
            return True
    for i in range(len(rings)):
        if (
            left <= rings[i, 4]
            and right >= rings[i, 2]
            and low <= rings[i, 5]
            and high >= rings[i, 3]
        ):
            return True
    return False


@kernel
def segment_word(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    ax: float,
    ay: float,
    bx: float,
    by: float,
    first: int,
    last: int,
    places: NDArray[np.float64],
    word: NDArray[np.int64],
) -> int:
    """How many times the label changes from a to b, or `UNCLEAR`; `word` gets the new labels.

    `first` and `last` are the labels of a and b. `places` and `word` are memory to work in, for
    `MAX_EVENTS` and 3 * `MAX_EVENTS` numbers.
    """
    dx = bx - ax
    dy = by - ay
    square = dx * dx + dy * dy
    if square == 0.0:
        return 0 if first == last else UNCLEAR
    events = _crossings(discs, rings, sides, ax, ay, bx, by, places, word)
    if events <= 0:
        return UNCLEAR if events < 0 or first != last else 0
    bits = word[_BITS:]
    for i in range(1, events):  # insertion sort: there are hardly ever more than two
        place = places[i]
        bit = bits[i]
        j = i - 1
        while j >= 0 and places[j] > place:
            places[j + 1] = places[j]
            bits[j + 1] = bits[j]
            j -= 1
        places[j + 1] = place
        bits[j + 1] = bit
    same = SAME / math.sqrt(square)
    mask = first
    count = 0
    i = 0
    while i < events:
        end = i + 1
        while end < events and places[end] - places[end - 1] <= same:
            end += 1
        entered = 0
        left = 0
        for j in range(i, end):
            # Met twice at one place, a region is touched: entered and left, or never left.
            if (mask | entered) & bits[j]:
                left |= bits[j]
            else:
                entered |= bits[j]
        if entered:
            mask |= entered
            word[count] = mask
            count += 1
        if left:
            mask &= ~left
            word[count] = mask
            count += 1
        i = end
    return count if mask == last else UNCLEAR


@kernel
def _crossings(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    ax: float,
    ay: float,
    bx: float,
    by: float,
    places: NDArray[np.float64],
    word: NDArray[np.int64],
) -> int:
    """How many borders the line from a to b meets, in no order, or `UNCLEAR`.

    Where goes into `places`, the bit of the region into the last third of `word`.
    """
    dx = bx - ax
    dy = by - ay
    square = dx * dx + dy * dy
    events = 0
    for i in range(len(discs)):
        cx = discs[i, 0]
        cy = discs[i, 1]
        r = discs[i, 2]
        away = r + SAME
        if (
            max(ax, bx) < cx - away
            or min(ax, bx) > cx + away
            or max(ay, by) < cy - away
            or min(ay, by) > cy + away
            or point_segment_square(cx, cy, ax, ay, bx, by) >= away * away
        ):
            continue
        along = ((cx - ax) * dx + (cy - ay) * dy) / square
        off = abs((cx - ax) * dy - (cy - ay) * dx) / math.sqrt(square)
        if abs(off - r) <= SAME:
            if 0.0 < along < 1.0:
                return UNCLEAR
            continue
        if off > r:
            continue
        half = math.sqrt((r * r - off * off) / square)
        for end in range(2):
            place = along - half if end == 0 else along + half
            if 0.0 <= place <= 1.0:
                if events == MAX_EVENTS:
                    return UNCLEAR
                places[events] = place
                word[_BITS + events] = 1 << i
                events += 1
    for i in range(len(rings)):
        if (
            max(ax, bx) < rings[i, 2] - SAME
            or max(ay, by) < rings[i, 3] - SAME
            or min(ax, bx) > rings[i, 4] + SAME
            or min(ay, by) > rings[i, 5] + SAME
        ):
            continue
        for side in range(int(rings[i, 0]), int(rings[i, 1])):
            x0, y0, x1, y1 = sides[side]
            if point_segment_square(x0, y0, ax, ay, bx, by) <= SAME * SAME:
                return UNCLEAR
            over_0 = dx * (y0 - ay) - dy * (x0 - ax)
            over_1 = dx * (y1 - ay) - dy * (x1 - ax)
            if (over_0 > 0.0) == (over_1 > 0.0):
                continue
            ex = x1 - x0
            ey = y1 - y0
            place = ((x0 - ax) * ey - (y0 - ay) * ex) / (dx * ey - dy * ex)
            if 0.0 <= place <= 1.0:
                if events == MAX_EVENTS:
                    return UNCLEAR
                places[events] = place
                word[_BITS + events] = 1 << (len(discs) + i)
                events += 1
    return events
