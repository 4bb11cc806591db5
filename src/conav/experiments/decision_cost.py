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

from conav.experiments.decision_kernels import (
    count_discs,
    gains_by_kept_numbers,
    gains_by_packed_rows,
    lower,
    packed_rows,
)
from conav.experiments.timing import Progress, timed
from conav.exploration.belief import Belief
from conav.exploration.turn_sequences import (
    TurnMemory,
    points_in_square,
    sequence_gains,
)
from conav.exploration.types import TeamView
from conav.geometry.directions import DCOL, DROW, STRAIGHT
from conav.geometry.sight import lateral_limits
from conav.maps.occupancy_grid import FREE, UNKNOWN
from conav.maps.planning_grid import Lattice
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.bulk_potential import DiscShape, disc_shape

RANGES = (1, 2, 4, 8, 16, 32, 64)
SIDES = (64, 256, 1024, 4096)
_LEAP = 5  # points between a robot's decisions


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
    count_discs(words, limits, left)
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
        lambda: gains_by_packed_rows(
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
        lambda: gains_by_kept_numbers(
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
    _, seconds = timed(lambda: lower(left, points, disc), budget_s)
    return seconds / len(points) * 1e6
