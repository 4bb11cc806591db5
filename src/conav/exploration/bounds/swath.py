"""The swath bound: a moving robot brings few new cells a step into its sensor's range.

Give every cell c a set F(c) of places that contains all places that see it, and call c caught when
some robot has been in F(c): a cell that was seen has been caught. A move from p to q catches at
most the gain |{c : q in F(c), p not in F(c)}|, and only when nobody was at q before. So after k
steps no more is seen than was caught at the starts, plus the largest gains that the team's travel
in k steps can pay for, each place's once.

With F(c) all places within range of c this is the textbook's bound, N0 + n g k cells after k steps
with g = |(D + e) \\ D| cells for a move e of the disc D; N0 must count the whole discs around the
starts, not only what is seen in them, or it is wrong behind corners. Here F(c) is smaller: of the
places within range of c, those from which a place that sees c can be reached without leaving the
range. Places in the next room, whose door is farther off, drop out; and no move inside the range
enters F(c), so that gains remain those of a disc's rim.
"""

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.bounds.travel import most_travel
from conav.exploration.bounds.views import Places, Sight, sensors_of
from conav.exploration.types import ExplorationProblem
from conav.geometry.directions import DCOL, DROW, SQRT2
from conav.geometry.sight import disc_cells, visible_cells
from conav.maps.planning_grid import PlanningGrid
from conav.robots.sensor import Sensor

Curve = tuple[NDArray[np.float64], NDArray[np.float64]]
MOST_KEPT = 8  # curves per planning grid
_gains: WeakKeyDictionary[PlanningGrid, dict[tuple[Sensor, bytes, bytes], Curve]] = (
    WeakKeyDictionary()
)


@dataclass(frozen=True, eq=False)
class Swath:
    """What a team catches: at its starts, and at most by driving so far."""

    caught: int  # N0: observable cells caught at the starts
    rates: NDArray[np.float64]  # (n_robots,) cells of travel a step
    team: NDArray[np.int64]  # (n_robots,) which row of the curves is each robot's
    travel: tuple[NDArray[np.float64], ...]  # per sensor, ascending cells of travel, first 0
    gained: tuple[NDArray[np.float64], ...]  # the most observable cells caught with that travel

    def seen_by(self, steps: float) -> int:
        """The most observable cells the team can have seen after a number of steps."""
        most = self.caught
        for sensor, (travel, gained) in enumerate(zip(self.travel, self.gained, strict=True)):
            rates = self.rates[self.team == sensor]
            budget = sum(most_travel(steps, float(rate)) for rate in rates)
            most += int(np.interp(budget, travel, gained) + 1e-6)
        return most


def swath_steps(swath: Swath, needed: int) -> float:
    """The step before which fewer than `needed` cells can have been seen; inf for never."""
    if swath.caught >= needed:
        return 0.0
    high = 1
    while swath.seen_by(high) < needed:
        high *= 2
        if high > 2**60:
            return float("inf")
    low = high // 2
    while high - low > 1:
        middle = (low + high) // 2
        if swath.seen_by(middle) >= needed:
            high = middle
        else:
            low = middle
    return float(high)


def swath_of(problem: ExplorationProblem, places: Places, observable: NDArray[np.uint8]) -> Swath:
    """The swath of a team; a pass over the observable cells for each sensor.

    The gains do not depend on where in a part of the map a team starts. They are kept for as long
    as its planning grid lives, so that for other starts only the cells around these are passed.
    """
    plan = problem.plan
    caught = np.zeros(observable.size, dtype=np.uint8)
    team = np.zeros(len(problem.robots), dtype=np.int64)
    curves: list[Curve] = []
    cells = np.flatnonzero(observable.reshape(-1))
    kept = _gains.setdefault(plan, {})
    for number, (sensor, robots) in enumerate(sensors_of(problem).items()):
        team[robots] = number
        starts = [problem.starts[robot] for robot in robots]
        key = (sensor, places.cells.tobytes(), observable.tobytes())
        if key not in kept:
            if len(kept) >= MOST_KEPT:
                kept.clear()
            gains = catch_gains(plan, sensor, places, cells, starts, caught)
            kept[key] = _curve(gains[:, :4].max(axis=1), gains.max(axis=1))
        else:
            near = cells[_in_range(plan, sensor, starts, cells)]
            catch_gains(plan, sensor, places, near, starts, caught)
        curves.append(kept[key])
    return Swath(
        caught=int(caught.sum()),
        rates=problem.rates,
        team=team,
        travel=tuple(travel for travel, _ in curves),
        gained=tuple(gained for _, gained in curves),
    )


def _in_range(
    plan: PlanningGrid, sensor: Sensor, starts: list[int], cells: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Which fine cells are within the sensor's range of any of some planning cells."""
    lattice = plan.lattice
    reach = sensor.range_m / lattice.resolution + 1e-6
    rows, cols = np.divmod(cells, lattice.fine_cols)
    near = np.zeros(len(cells), dtype=np.bool_)
    for start in starts:
        row, col = divmod(start, lattice.cols)
        away = (rows - lattice.fine_row[row]) ** 2 + (cols - lattice.fine_col[col]) ** 2
        near |= away <= reach * reach
    return near


def _curve(straight: NDArray[np.int32], either: NDArray[np.int32]) -> Curve:
    """The most that can be caught for a length of travel: its breakpoints (length, cells).

    Each place is entered once, by a straight move of length 1 or a diagonal one of sqrt(2) with the
    gains `straight` and `either`. Parts of a gain may be bought by parts of a length, best value
    first, which only overestimates.
    """
    slanting = either > SQRT2 * straight  # then the diagonal is the better value
    lengths = np.where(slanting, SQRT2, 1.0)
    gains = np.where(slanting, either, straight).astype(np.float64)
    more = ~slanting & (either > straight)
    lengths = np.concatenate([lengths, np.full(np.count_nonzero(more), SQRT2 - 1.0)])
    gains = np.concatenate([gains, (either - straight)[more].astype(np.float64)])
    order = np.argsort(-gains / lengths, kind="stable")
    zero = np.zeros(1)
    return (
        np.concatenate([zero, np.cumsum(lengths[order])]),
        np.concatenate([zero, np.cumsum(gains[order])]),
    )


def catch_gains(
    plan: PlanningGrid,
    sensor: Sensor,
    places: Places,
    cells: NDArray[np.int64],
    starts: list[int],
    caught: NDArray[np.uint8],
) -> NDArray[np.int32]:
    """How many of some fine cells are caught by each move, shape (planning cells, 8).

    Entry (q, k) is for the move to q from its neighbour in direction k. `caught` (fine cells,) gets
    1 for those of `cells` that are caught at `starts`.
    """
    sight = Sight(plan, sensor)
    size = plan.moves.size
    # Planning cells smaller than fine ones share a fine cell: a chain of them.
    at = np.full(plan.walls.size, -1, dtype=np.int32)
    following = np.full(size, -1, dtype=np.int32)
    for cell, centre in zip(places.cells.tolist(), places.centres.tolist(), strict=True):
        following[cell] = at[centre]
        at[centre] = cell
    started = np.zeros(size, dtype=np.uint8)
    started[starts] = 1
    return _catch_gains(
        plan.walls,
        plan.moves,
        plan.lattice.fine_row,
        plan.lattice.fine_col,
        cells,
        at,
        following,
        started,
        sight.occlusion,
        sight.limits,
        sight.lows,
        sight.highs,
        sight.out,
        caught,
    )


@kernel
def _catch_gains(
    walls: NDArray[np.uint8],
    moves: NDArray[np.uint8],
    fine_row: NDArray[np.int32],
    fine_col: NDArray[np.int32],
    cells: NDArray[np.int64],
    at: NDArray[np.int32],
    following: NDArray[np.int32],
    started: NDArray[np.uint8],
    occlusion: bool,
    limits: NDArray[np.int32],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    caught: NDArray[np.uint8],
) -> NDArray[np.int32]:
    fine_cols = walls.shape[1]
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    reach = limits.shape[0] - 1
    gains = np.zeros((flat.shape[0], 8), dtype=np.int32)
    stamp = np.full(flat.shape[0], -1, dtype=np.int32)
    queue = np.empty(flat.shape[0], dtype=np.int32)
    for i in range(cells.shape[0]):
        row = cells[i] // fine_cols
        col = cells[i] % fine_cols
        if occlusion:
            count = visible_cells(walls, row, col, limits, lows, highs, out)
        else:
            count = disc_cells(walls, row, col, limits, out)
        tail = 0
        for j in range(count):
            place = at[out[j]]
            while place >= 0 and stamp[place] != i:
                stamp[place] = i
                queue[tail] = place
                tail += 1
                place = following[place]
        head = 0
        while head < tail:
            place = queue[head]
            head += 1
            if started[place] == 1:
                caught[cells[i]] = 1
            bits = flat[place]
            for k in range(8):
                if bits & (1 << k):
                    other = place + DROW[k] * cols + DCOL[k]
                    if stamp[other] == i:
                        continue
                    dr = abs(fine_row[other // cols] - row)
                    if dr <= reach and abs(fine_col[other % cols] - col) <= limits[dr]:
                        stamp[other] = i
                        queue[tail] = other
                        tail += 1
                    else:
                        gains[place, k] += 1
    return gains
