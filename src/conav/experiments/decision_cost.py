"""What a decision of Algorithm 2 costs, [Philip2014] section 3.1.

Three ways to the same four numbers, the gains of `sequence_gains`:
- squares: every point of the five squares of (16) is looked at, as strategies do;
- packed: the undiscovered points are bits, a row of a disc is a few masked words whose ones are
  counted, and the two discs of the baseline are counted as one shape;
- kept: for every place the number of undiscovered points within range of it is kept up to date, as
  games in bulk do. A decision reads five of these and the crescent its second step adds; the price
  is paid when a point is discovered, which lowers the numbers of a disc.

Counters are exact and equal on every machine. Times are wall times of warm calls, the best of those
that fit into some time, and say little more than their order of magnitude.
"""

from collections.abc import Sequence
from time import perf_counter
from types import SimpleNamespace
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.experiments.timing import Progress, timed
from conav.exploration.belief import Belief
from conav.exploration.turn_sequences import (
    BLOCKED,
    TurnMemory,
    points_in_square,
    sequence_gains,
)
from conav.exploration.types import TeamView
from conav.geometry.directions import DCOL, DROW, STRAIGHT
from conav.geometry.sight import lateral_limits
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN
from conav.maps.planning_grid import Lattice
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.bulk_potential import DiscShape, disc_shape

RANGES = (1, 2, 4, 8, 16, 32, 64)
SIDES = (64, 256, 1024, 4096)
_LEAP = 5  # points between a robot's decisions
_ALL_ONES = np.uint64(2**64 - 1)
_EVERY_2ND = np.uint64(0x5555555555555555)
_EVERY_2ND_PAIR = np.uint64(0x3333333333333333)
_LOW_HALVES = np.uint64(0x0F0F0F0F0F0F0F0F)
_LOW_BITS = np.uint64(0x0101010101010101)


class DecisionCost(NamedTuple):
    """What one decision costs on one map; counters are medians over the decisions."""

    side: int  # the map has side * side points
    s_range: int
    points: int  # squares: points looked at
    words: int  # packed: 64-bit words looked at
    kept: int  # kept: numbers and points looked at
    lowered: int  # kept: numbers lowered for each point that is discovered
    strategy_us: float  # squares: the whole call that a strategy makes, `sequence_gains`
    squares_us: float  # that less a call where all sequences are blocked: looking at the points
    packed_us: float
    kept_us: float
    lowered_us: float  # lowering the numbers for one point that is discovered

    @property
    def expected_points(self) -> int:
        """20 (sRange^2 + sRange): what section 3.1 counts away from borders and obstacles."""
        return 5 * points_in_square(self.s_range)

    def break_even(self, other_us: float) -> float:
        """Points discovered per decision up to which kept numbers are cheaper than that."""
        return (other_us - self.kept_us) / self.lowered_us


class Knowledge(NamedTuple):
    """A half known map without obstacles in the forms the three ways read, and decisions on it."""

    s_range: int
    cells: NDArray[np.uint8]  # (side, side) FREE or UNKNOWN
    words: NDArray[np.uint64]  # (side, words in a row) a bit for each unknown point
    unknown: NDArray[np.uint8]  # (padded size,) 1 for each unknown point
    left: NDArray[np.int32]  # (padded size,) unknown points within range of each place
    limits: NDArray[np.int32]  # of the sensor
    shape: DiscShape
    places: NDArray[np.int64]  # (decisions, 3) row, column and heading of the robot


class Counted(NamedTuple):
    """The outcome of decisions made in one of the ways."""

    gains: NDArray[np.int64]  # (decisions, 4) undiscovered points, by sequence
    looked: NDArray[np.int64]  # (decisions,) points, words or numbers looked at
    us: float  # time of one decision [us]
    idle_us: float = 0.0  # the part of it that is not looking at anything


def cost_by_range(
    ranges: Sequence[int] = RANGES,
    *,
    side: int = 512,
    decisions: int = 400,
    budget_s: float = 0.5,
    seed: int = 1,
    progress: Progress | None = None,
) -> list[DecisionCost]:
    """A row for each sensor range, on maps of one size."""
    return [decision_cost(side, s, decisions, budget_s, seed, progress) for s in ranges]


def cost_by_map_size(
    sides: Sequence[int] = SIDES,
    ranges: Sequence[int] = (2, 16),
    *,
    decisions: int = 400,
    budget_s: float = 0.5,
    seed: int = 1,
    progress: Progress | None = None,
) -> list[DecisionCost]:
    """A row for each sensor range and map size: the same decisions on maps of all sizes."""
    return [
        decision_cost(side, s, decisions, budget_s, seed, progress, roam=min(sides))
        for s in ranges
        for side in sides
    ]


def decision_cost(
    side: int,
    s_range: int,
    decisions: int = 400,
    budget_s: float = 0.5,
    seed: int = 1,
    progress: Progress | None = None,
    *,
    roam: int | None = None,
) -> DecisionCost:
    """What a decision costs on a map of side * side points, away from its borders.

    With `roam` the robot stays in roam * roam points of it, whose content depends on nothing else.
    Times of packed rows, kept numbers and lowering are those of compiled loops over all decisions,
    divided by their number. Each of the ways is repeated for `budget_s`. Raises `ValueError` when
    the map has too few points that are away from its borders.
    """
    if progress is not None:
        progress(f"decisions with sRange {s_range} on {side} x {side} points")
    rng = np.random.default_rng(seed)
    known = knowledge(side, roam or side, s_range, decisions, rng)
    squares = by_squares(known, budget_s)
    packed = by_packed_rows(known, budget_s)
    kept = by_kept_numbers(known, budget_s)
    return DecisionCost(
        side=side,
        s_range=s_range,
        points=int(np.median(squares.looked)),
        words=int(np.median(packed.looked)),
        kept=int(np.median(kept.looked)),
        lowered=len(known.shape.disc),
        strategy_us=squares.us,
        squares_us=squares.us - squares.idle_us,
        packed_us=packed.us,
        kept_us=kept.us,
        lowered_us=_lowered_us(known, budget_s),
    )


def knowledge(
    side: int, roam: int, s_range: int, decisions: int, rng: np.random.Generator
) -> Knowledge:
    """A map half known in square blocks, and the decisions of a robot that walks over it.

    It stays in a part of roam * roam points, where all squares are in that part: what it sees and
    does is the same whatever the side of the map. The points beside it are known, as to a robot
    that has looked around. Raises `ValueError` when there is no room for it.
    """
    # Whole words from the border, so that rows of discs are cut into words in the same places.
    at = (side - roam) // 128 * 64
    places = _walk(roam, s_range + 2, decisions, rng) + np.array([at, at, 0])
    inside = _half_known(roam, max(s_range, 4), rng)
    unknown = _half_known(side, max(s_range, 4), rng)
    unknown[at : at + roam, at : at + roam] = inside
    row, col, _ = places.T
    unknown[row, col] = False
    for k in range(4):
        unknown[row + DROW[k], col + DCOL[k]] = False
    limits = lateral_limits(float(s_range))
    shape = disc_shape(limits, side)
    words = packed_rows(unknown)
    left = np.zeros((side, side), dtype=np.int32)
    _count_discs(words, limits, left)
    return Knowledge(
        s_range=s_range,
        cells=np.where(unknown, UNKNOWN, FREE).astype(np.uint8),
        words=words,
        unknown=np.pad(unknown.astype(np.uint8), shape.pad).reshape(-1),
        left=np.pad(left, shape.pad).reshape(-1),
        limits=limits,
        shape=shape,
        places=places,
    )


def _half_known(side: int, block: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Whether each of side * side points is unknown."""
    blocks = rng.random((side // block + 1, side // block + 1)) < 0.5
    return blocks.repeat(block, axis=0).repeat(block, axis=1)[:side, :side]


def _walk(side: int, margin: int, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Row, column and heading (count, 3) on a walk that turns now and then, off the borders."""
    if side < 2 * (margin + _LEAP) + 1:
        raise ValueError(f"on {side} x {side} points there is no room away from the borders")
    places = np.empty((count, 3), dtype=np.int64)
    r = c = side // 2
    k = 0
    for i in range(count):
        if rng.random() < 0.2:
            k = int(rng.integers(4))
        places[i] = r, c, k
        while True:
            row, col = r + _LEAP * DROW[k], c + _LEAP * DCOL[k]
            if margin <= min(row, col) and max(row, col) < side - margin:
                break
            k = int(rng.integers(4))
        r, c = row, col
    return places


def packed_rows(points: NDArray[np.bool_]) -> NDArray[np.uint64]:
    """The points (rows, cols) as bits, the lowest first, (rows, words)."""
    rows, cols = points.shape
    whole = np.zeros((rows, -(-cols // 64) * 64), dtype=np.bool_)
    whole[:, :cols] = points
    packed = np.packbits(whole, axis=1, bitorder="little")
    return packed.view(np.dtype("<u8")).astype(np.uint64)


def by_squares(known: Knowledge, budget_s: float = 0.0) -> Counted:
    """The decisions as a strategy makes them, each a call of `sequence_gains`.

    Timed is the whole call, with Python's part of it; of all decisions the median. The decisions
    are repeated as a whole, not one by one, which processors would learn by heart. In between are
    calls with all sequences blocked, whose time is `idle_us`.
    """
    side = len(known.cells)
    along = np.arange(side, dtype=np.int32)
    lattice = Lattice(side, side, 1.0, side, side, 1.0, along, along, along, along)
    sensor = Sensor("disc", occlusion=False, range_m=float(known.s_range))
    body = Robot("robot_0", motion=MOTIONS["forward-turn"], sensor=sensor)
    heard = np.zeros(1, dtype=np.int32)
    in_touch = np.ones(1, dtype=np.bool_)

    def views(ways: int) -> list[TeamView]:
        moves = np.full((side, side), ways, dtype=np.uint8)
        # All that gains read of a belief; a whole one of millions of points takes long to make.
        belief = cast("Belief", SimpleNamespace(cells=known.cells, moves=moves))
        return [
            TeamView(
                1, 1.0, 0, body, row * side + col, heading, belief, lattice, heard, heard, in_touch
            )
            for row, col, heading in known.places.tolist()
        ]

    pairs = list(zip(views(0), views(STRAIGHT), strict=True))
    gains = np.empty((len(pairs), 4), dtype=np.int64)
    looked = np.empty(len(pairs), dtype=np.int64)

    def decide() -> NDArray[np.float64]:
        seconds = np.empty((len(pairs), 2))
        for i, (blocked, view) in enumerate(pairs):
            memory = TurnMemory()
            start = perf_counter()
            sequence_gains(memory, blocked)
            middle = perf_counter()
            gains[i] = sequence_gains(memory, view)
            seconds[i] = middle - start, perf_counter() - middle
            looked[i] = memory.points_checked
        return seconds

    best = decide()
    until = perf_counter() + budget_s
    while perf_counter() < until:
        best = np.minimum(best, decide())
    idle, whole = np.median(best, axis=0) * 1e6
    return Counted(gains, looked, float(whole), float(idle))


def by_packed_rows(known: Knowledge, budget_s: float = 0.0) -> Counted:
    """The decisions by masked words of bits, in one compiled loop."""
    gains = np.empty((len(known.places), 4), dtype=np.int64)
    looked = np.empty(len(known.places), dtype=np.int64)
    _, seconds = timed(
        lambda: _by_packed_rows(
            known.words, known.cells, known.places, known.limits, gains, looked
        ),
        budget_s,
    )
    return Counted(gains, looked, seconds / len(looked) * 1e6)


def by_kept_numbers(known: Knowledge, budget_s: float = 0.0) -> Counted:
    """The decisions by numbers that were kept up to date, in one compiled loop."""
    gains = np.empty((len(known.places), 4), dtype=np.int64)
    looked = np.empty(len(known.places), dtype=np.int64)
    pad, width, _, crescent = known.shape
    _, seconds = timed(
        lambda: _by_kept_numbers(
            known.unknown, known.left, known.places, pad, width, crescent, gains, looked
        ),
        budget_s,
    )
    return Counted(gains, looked, seconds / len(looked) * 1e6)


def _lowered_us(known: Knowledge, budget_s: float) -> float:
    """The time of lowering the numbers around one point that is discovered [us]."""
    pad, width, disc, _ = known.shape
    points = ((known.places[:, 0] + pad) * width + known.places[:, 1] + pad).astype(np.uint64)
    left = known.left.copy()
    _, seconds = timed(lambda: _lower(left, points, disc), budget_s)
    return seconds / len(points) * 1e6


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
def _by_packed_rows(
    words: NDArray[np.uint64],
    cells: NDArray[np.uint8],
    places: NDArray[np.int64],
    limits: NDArray[np.int32],
    gains: NDArray[np.int64],
    looked: NDArray[np.int64],
) -> None:
    for i in range(places.shape[0]):
        row, col, heading = places[i, 0], places[i, 1], places[i, 2]
        looked[i] = packed_gains(words, cells, row, col, heading, STRAIGHT, limits, gains[i])


@kernel
def _count_discs(
    words: NDArray[np.uint64], limits: NDArray[np.int32], left: NDArray[np.int32]
) -> None:
    """Fills `left` (rows, cols) with the bits within range of each place."""
    rows, cols = left.shape
    for r in range(rows):
        for c in range(cols):
            left[r, c] = _count_disc(words, cols, limits, r, c, -1, -1)[0]


@kernel
def _by_kept_numbers(
    unknown: NDArray[np.uint8],
    left: NDArray[np.int32],
    places: NDArray[np.int64],
    pad: int,
    width: int,
    crescent: NDArray[np.uint64],
    gains: NDArray[np.int64],
    looked: NDArray[np.int64],
) -> None:
    """As `conav.simulation.bulk_potential` decides where nothing is in the way."""
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
def _lower(left: NDArray[np.int32], points: NDArray[np.uint64], disc: NDArray[np.uint64]) -> None:
    """Lowers the numbers of all places within range of each point."""
    for i in range(points.shape[0]):
        for j in range(disc.shape[0]):
            left[points[i] + disc[j]] -= 1
