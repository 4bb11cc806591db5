"""From where the cells of a known map are seen, and how soon.

The view set V(c) of a fine cell c holds the planning cells from which it is seen. It is read by
looking from planning cells, as robots do, or, sight being mutual, by looking from c.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.bounds.travel import travel_from, turn_cost, whole_steps
from conav.exploration.types import ExplorationProblem
from conav.geometry.sight import (
    disc_cells,
    lateral_limits,
    new_gap_space,
    sight_buffer_size,
    visible_cells,
)
from conav.maps.planning_grid import PlanningGrid
from conav.robots.sensor import Sensor


class Sight:
    """Working space for looks with one sensor over one planning grid."""

    def __init__(self, plan: PlanningGrid, sensor: Sensor) -> None:
        self.occlusion = sensor.occlusion
        # Farther than the map is large makes no difference but to memory.
        reach = min(sensor.range_m / plan.lattice.resolution, sum(plan.walls.shape))
        self.limits = lateral_limits(reach)
        self.lows = new_gap_space(self.limits)
        self.highs = new_gap_space(self.limits)
        self.out = np.empty(sight_buffer_size(self.limits), dtype=np.int32)


@dataclass(frozen=True, eq=False)
class Places:
    """The planning cells a team can reach, and the fine cells their centres lie in."""

    cells: NDArray[np.int64]  # (n_places,) flat planning cells, ascending
    centres: NDArray[np.int64]  # (n_places,) flat fine cell of each one's centre

    @staticmethod
    def of(problem: ExplorationProblem) -> "Places":
        """The places in the connected parts that robots start in."""
        plan = problem.plan
        labels = plan.labels.reshape(-1)
        cells = np.flatnonzero(np.isin(labels, labels[list(problem.starts)]))
        rows, cols = np.divmod(cells, plan.lattice.cols)
        centres = (
            plan.lattice.fine_row[rows].astype(np.int64) * plan.lattice.fine_cols
            + plan.lattice.fine_col[cols]
        )
        return Places(cells, centres)


def sensors_of(problem: ExplorationProblem) -> dict[Sensor, list[int]]:
    """The sensors in a team, each with the numbers of the robots that carry it."""
    result: dict[Sensor, list[int]] = {}
    for number, robot in enumerate(problem.robots):
        result.setdefault(robot.sensor, []).append(number)
    return result


def travel_of(
    problem: ExplorationProblem, robot: int, sources: NDArray[np.int64]
) -> NDArray[np.float64]:
    """A robot's least travel [steps] from any of the sources to each planning cell, flat."""
    rate = float(problem.rates[robot])
    turn = turn_cost(problem.robots[robot].motion, rate)
    return travel_from(problem.plan.moves, sources, turn) / rate


@dataclass(frozen=True, eq=False)
class Survey:
    """When each fine cell can be seen at the earliest, and how easy it is to see."""

    first: NDArray[np.float64]  # (fine cells,) [steps], whole; inf where nobody can see it
    views: NDArray[np.int32]  # (fine cells,) places that see it, of all sensors together


def survey(problem: ExplorationProblem, places: Places) -> Survey:
    """The earliest step at which any robot can see each cell.

    A robot that starts at s sees c no sooner than it can be at the nearest place of V(c).
    """
    plan = problem.plan
    first = np.full(plan.walls.size, np.inf)
    views = np.zeros(plan.walls.size, dtype=np.int32)
    for sensor, robots in sensors_of(problem).items():
        soonest = np.full(len(places.cells), np.inf)
        for robot in robots:
            start = np.array([problem.starts[robot]], dtype=np.int64)
            steps = travel_of(problem, robot, start)[places.cells]
            soonest = np.minimum(soonest, [whole_steps(step) for step in steps.tolist()])
        order = np.argsort(soonest, kind="stable")
        sight = Sight(plan, sensor)
        _survey(
            plan.walls,
            places.centres[order],
            soonest[order],
            sight.occlusion,
            sight.limits,
            sight.lows,
            sight.highs,
            sight.out,
            first,
            views,
        )
    return Survey(first, views)


@kernel
def _survey(
    walls: NDArray[np.uint8],
    centres: NDArray[np.int64],
    soonest: NDArray[np.float64],
    occlusion: bool,
    limits: NDArray[np.int32],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    first: NDArray[np.float64],
    views: NDArray[np.int32],
) -> None:
    cols = walls.shape[1]
    last = np.full(walls.size, -1, dtype=np.int32)
    for i in range(centres.shape[0]):
        row = centres[i] // cols
        col = centres[i] % cols
        if occlusion:
            count = visible_cells(walls, row, col, limits, lows, highs, out)
        else:
            count = disc_cells(walls, row, col, limits, out)
        for j in range(count):
            cell = out[j]
            if last[cell] != i:  # a cell may come twice in a look
                last[cell] = i
                views[cell] += 1
                first[cell] = min(first[cell], soonest[i])


def group_views(
    plan: PlanningGrid, sensor: Sensor, places: Places, group: NDArray[np.int32], groups: int
) -> NDArray[np.bool_]:
    """Whether a place sees any cell of a group, shape (groups, n_places).

    `group` (fine cells,) is the number of the group each cell is in, -1 for none.
    """
    sight = Sight(plan, sensor)
    sees = np.zeros((groups, len(places.cells)), dtype=np.bool_)
    _group_views(
        plan.walls,
        places.centres,
        group,
        sight.occlusion,
        sight.limits,
        sight.lows,
        sight.highs,
        sight.out,
        sees,
    )
    return sees


@kernel
def _group_views(
    walls: NDArray[np.uint8],
    centres: NDArray[np.int64],
    group: NDArray[np.int32],
    occlusion: bool,
    limits: NDArray[np.int32],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    sees: NDArray[np.bool_],
) -> None:
    cols = walls.shape[1]
    for i in range(centres.shape[0]):
        row = centres[i] // cols
        col = centres[i] % cols
        if occlusion:
            count = visible_cells(walls, row, col, limits, lows, highs, out)
        else:
            count = disc_cells(walls, row, col, limits, out)
        for j in range(count):
            if group[out[j]] >= 0:
                sees[group[out[j]], i] = True
