"""Gains of turn sequences by packed rows and by kept numbers, for `decision_cost`."""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.turn_sequences import BLOCKED
from conav.geometry.directions import DCOL, DROW, STRAIGHT
from conav.maps.occupancy_grid import OCCUPIED

_ALL_ONES = np.uint64(2**64 - 1)
_EVERY_2ND = np.uint64(0x5555555555555555)
_EVERY_2ND_PAIR = np.uint64(0x3333333333333333)
_LOW_HALVES = np.uint64(0x0F0F0F0F0F0F0F0F)
_LOW_BITS = np.uint64(0x0101010101010101)


def packed_rows(points: NDArray[np.bool_]) -> NDArray[np.uint64]:
    """The points (rows, cols) as bits, the lowest first, (rows, words)."""
    rows, cols = points.shape
    whole = np.zeros((rows, -(-cols // 64) * 64), dtype=np.bool_)
    whole[:, :cols] = points
    packed = np.packbits(whole, axis=1, bitorder="little")
    return packed.view(np.dtype("<u8")).astype(np.uint64)


@kernel
def _ones(word: np.uint64) -> np.uint64:
    """How many bits of the word are 1; compilers know these lines and make one instruction."""
    word = word - ((word >> np.uint64(1)) & _EVERY_2ND)
    word = (word & _EVERY_2ND_PAIR) + ((word >> np.uint64(2)) & _EVERY_2ND_PAIR)
    word = (word + (word >> np.uint64(4))) & _LOW_HALVES
    return (word * _LOW_BITS) >> np.uint64(56)


@kernel
def _count_disc(
    words: NDArray[np.uint64],
    cols: int,
    limits: NDArray[np.int32],
    r1: int,
    c1: int,
    r2: int,
    c2: int,
) -> tuple[int, int]:
    """The bits in the disc around (r1, c1), or in that and the one around its straight neighbour
    (r2, c2), and the words looked at. With r2 = -1 there is one disc.

    Discs of neighbours overlap or touch in every row they share, so a row of both is one stretch.
    """
    reach = limits.shape[0] - 1
    two = r2 >= 0
    count = np.uint64(0)
    looked = 0
    low = min(r1, r2) if two else r1
    high = max(r1, r2) if two else r1
    for r in range(max(low - reach, 0), min(high + reach, words.shape[0] - 1) + 1):
        first = cols
        last = -1
        d = abs(r - r1)
        if d <= reach:
            first = c1 - limits[d]
            last = c1 + limits[d]
        d = abs(r - r2)
        if two and d <= reach:
            first = min(first, c2 - limits[d])
            last = max(last, c2 + limits[d])
        first = max(first, 0)
        last = min(last, cols - 1)
        w = first >> 6
        end = last >> 6
        looked += end - w + 1
        mask = _ALL_ONES << np.uint64(first & 63)
        while w < end:
            count += _ones(words[r, w] & mask)
            mask = _ALL_ONES
            w += 1
        count += _ones(words[r, w] & mask & (_ALL_ONES >> np.uint64(63 - (last & 63))))
    return int(count), looked


@kernel
def packed_gains(
    words: NDArray[np.uint64],
    cells: NDArray[np.uint8],
    row: int,
    col: int,
    heading: int,
    bits: int,
    limits: NDArray[np.int32],
    gains: NDArray[np.int64],
) -> int:
    """The number of words looked at; fills `gains` (4,) as `sequence_gains` would.

    `words` are the unknown points of `cells` in `packed_rows`. Planning cells are the map's own;
    `bits` are the straight moves the robot can make, and the points these lead to are known.
    """
    rows, cols = cells.shape
    looked = 0
    for turn in range(4):
        k = (heading + turn) & 3
        if bits & (1 << k) == 0:
            gains[turn] = BLOCKED
            continue
        r2 = row + 2 * DROW[k]
        c2 = col + 2 * DCOL[k]
        if turn > 0 or not (0 <= r2 < rows and 0 <= c2 < cols) or cells[r2, c2] == OCCUPIED:
            r2 = -1
        found, touched = _count_disc(words, cols, limits, row + DROW[k], col + DCOL[k], r2, c2)
        gains[turn] = found
        looked += touched
    return looked


@kernel
def gains_by_packed_rows(
    words: NDArray[np.uint64],
    cells: NDArray[np.uint8],
    places: NDArray[np.int64],
    limits: NDArray[np.int32],
    gains: NDArray[np.int64],
    looked: NDArray[np.int64],
) -> None:
    """Write the gains of all decisions by packed rows, and the words looked at."""
    for i in range(places.shape[0]):
        row, col, heading = places[i, 0], places[i, 1], places[i, 2]
        looked[i] = packed_gains(words, cells, row, col, heading, STRAIGHT, limits, gains[i])


@kernel
def count_discs(
    words: NDArray[np.uint64], limits: NDArray[np.int32], left: NDArray[np.int32]
) -> None:
    """Fills `left` (rows, cols) with the bits within range of each place."""
    rows, cols = left.shape
    for r in range(rows):
        for c in range(cols):
            left[r, c] = _count_disc(words, cols, limits, r, c, -1, -1)[0]


@kernel
def gains_by_kept_numbers(
    unknown: NDArray[np.uint8],
    left: NDArray[np.int32],
    places: NDArray[np.int64],
    pad: int,
    width: int,
    crescent: NDArray[np.uint64],
    gains: NDArray[np.int64],
    looked: NDArray[np.int64],
) -> None:
    """Write the gains by kept numbers, and how many were looked at, as games in bulk decide."""
    ahead_of = np.array([1, width, -1, -width]).astype(np.uint64)
    for i in range(places.shape[0]):
        here = np.uint64((places[i, 0] + pad) * width + places[i, 1] + pad)
        heading = places[i, 2]
        forward = ahead_of[heading]
        leftward = ahead_of[(heading + 1) & 3]
        gain = int(left[here + forward])
        second = here + forward + forward
        looked[i] = 5
        # Where nothing is left around the second place the crescent holds nothing.
        if left[second] > 0:
            for j in range(crescent.shape[1]):
                gain += int(unknown[second + crescent[heading, j]])
            looked[i] += crescent.shape[1]
        gains[i, 0] = gain
        gains[i, 1] = left[here + leftward]
        gains[i, 2] = left[here - forward]
        gains[i, 3] = left[here - leftward]


@kernel
def lower(left: NDArray[np.int32], points: NDArray[np.uint64], disc: NDArray[np.uint64]) -> None:
    """Lowers the numbers of all places within range of each point."""
    for i in range(points.shape[0]):
        for j in range(disc.shape[0]):
            left[points[i] + disc[j]] -= 1
