"""The swath bound: a moving robot brings few new cells a step into its sensor's range.

Call a cell caught when some robot has been within sensor range of it, whatever stands between: a
cell that was seen has been caught. A move from p to q catches at most the gain, the observable
cells of D(q) that are not in D(p), where D is the disc of the sensor on this grid; and nothing when
somebody was at q before. So after k steps no more is seen than N0, the observable cells in the
whole discs around the starts, plus the largest gains that the team's travel in k steps can pay for,
each place's once.

N0 must count the whole discs. With what is seen in them at first instead, the bound is wrong behind
corners: a step round one shows at once what was in range all the time. And gains must be those of
the grid: on a continuous plane the rim is 2 r wide, on the grid 2 floor(r) + 1 cells, which is
more.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.bounds.travel import most_travel
from conav.exploration.bounds.views import Places, Sight, sensors_of
from conav.exploration.types import ExplorationProblem
from conav.geometry.directions import DCOL, DROW, SQRT2
from conav.geometry.sight import disc_cells
from conav.maps.planning_grid import PlanningGrid
from conav.robots.sensor import Sensor

Curve = tuple[NDArray[np.float64], NDArray[np.float64]]


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
    """The swath of a team: a pass over the places for each sensor."""
    plan = problem.plan
    caught = np.zeros(observable.size, dtype=np.bool_)
    team = np.zeros(len(problem.robots), dtype=np.int64)
    curves: list[Curve] = []
    for number, (sensor, robots) in enumerate(sensors_of(problem).items()):
        team[robots] = number
        for robot in robots:
            caught[_in_range(plan, sensor, problem.starts[robot])] = True
        gains = catch_gains(plan, sensor, places, observable)
        curves.append(_curve(gains[:, :4].max(axis=1), gains.max(axis=1)))
    return Swath(
        caught=int(np.count_nonzero(caught & (observable.reshape(-1) == 1))),
        rates=problem.rates,
        team=team,
        travel=tuple(travel for travel, _ in curves),
        gained=tuple(gained for _, gained in curves),
    )


def _in_range(plan: PlanningGrid, sensor: Sensor, place: int) -> NDArray[np.int32]:
    """The fine cells of the whole disc around a planning cell."""
    sight = Sight(plan, sensor)
    row, col = divmod(place, plan.lattice.cols)
    fine_row, fine_col = int(plan.lattice.fine_row[row]), int(plan.lattice.fine_col[col])
    return sight.out[: disc_cells(plan.walls, fine_row, fine_col, sight.limits, sight.out)]


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
    plan: PlanningGrid, sensor: Sensor, places: Places, observable: NDArray[np.uint8]
) -> NDArray[np.int32]:
    """How many observable cells are caught by each move, shape (n_places, 8).

    Entry (i, k) is for the move to place i from its neighbour in direction k, 0 where there is
    none.
    """
    ahead = np.zeros((observable.shape[0], observable.shape[1] + 1), dtype=np.int32)
    np.cumsum(observable, axis=1, out=ahead[:, 1:])
    return _catch_gains(
        ahead,
        plan.moves,
        plan.lattice.fine_row,
        plan.lattice.fine_col,
        places.cells,
        Sight(plan, sensor).limits,
    )


@kernel
def _catch_gains(
    ahead: NDArray[np.int32],
    moves: NDArray[np.uint8],
    fine_row: NDArray[np.int32],
    fine_col: NDArray[np.int32],
    places: NDArray[np.int64],
    limits: NDArray[np.int32],
) -> NDArray[np.int32]:
    # ahead[r, c]: observable cells of row r before column c.
    rows = ahead.shape[0]
    last = ahead.shape[1] - 1
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    reach = limits.shape[0] - 1
    gains = np.zeros((places.shape[0], 8), dtype=np.int32)
    for i in range(places.shape[0]):
        row = fine_row[places[i] // cols]
        col = fine_col[places[i] % cols]
        for k in range(8):
            if not flat[places[i]] & (1 << k):
                continue
            from_row = fine_row[places[i] // cols + DROW[k]]
            from_col = fine_col[places[i] % cols + DCOL[k]]
            gain = 0
            for r in range(max(row - reach, 0), min(row + reach, rows - 1) + 1):
                # Columns in range of the new place, less those in range of the old one.
                limit = limits[abs(r - row)]
                begin = max(col - limit, 0)
                end = min(col + limit + 1, last)
                if begin >= end:
                    continue
                gain += ahead[r, end] - ahead[r, begin]
                if abs(r - from_row) <= reach:
                    limit = limits[abs(r - from_row)]
                    begin = max(begin, from_col - limit)
                    end = min(end, from_col + limit + 1)
                    if begin < end:
                        gain -= ahead[r, end] - ahead[r, begin]
            gains[i, k] = gain
    return gains
