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
    cells_in_sight,
    lateral_limits,
    new_gap_space,
    sight_buffer_size,
)
from conav.maps.planning_grid import PlanningGrid
from conav.robots.sensor import Sensor

PROBES = 64  # looks from which the size of all is told


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

    def by_fine_cell(self, plan: PlanningGrid) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """The places whose centres lie in each fine cell, as a chain.

        The number of one place per fine cell, and of the next one per place; -1 for none. Planning
        cells smaller than fine ones share a fine cell.
        """
        at = np.full(plan.walls.size, -1, dtype=np.int32)
        following = np.full(len(self.centres), -1, dtype=np.int32)
        _chain(self.centres, at, following)
        return at, following


@kernel
def _chain(centres: NDArray[np.int64], at: NDArray[np.int32], following: NDArray[np.int32]) -> None:
    for i in range(centres.shape[0]):
        following[i] = at[centres[i]]
        at[centres[i]] = i


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


def look_cells(problem: ExplorationProblem, places: Places) -> float:
    """How many fine cells a look from a place touches, about: the mean over `PROBES` of them."""
    plan = problem.plan
    centres = places.centres[:: -(-len(places.centres) // PROBES)]
    total = sum(_touched(plan, sensor, centres) for sensor in sensors_of(problem))
    return max(total / max(len(centres), 1), 1.0)


def _touched(plan: PlanningGrid, sensor: Sensor, centres: NDArray[np.int64]) -> int:
    sight = Sight(plan, sensor)
    total = 0
    for centre in centres.tolist():
        row, col = divmod(centre, plan.walls.shape[1])
        total += cells_in_sight(
            plan.walls,
            row,
            col,
            sight.occlusion,
            sight.limits,
            sight.lows,
            sight.highs,
            sight.out,
        )
    return total


@dataclass(frozen=True, eq=False)
class Survey:
    """When each fine cell can be seen at the earliest, and how easy it is to see."""

    first: NDArray[np.float64]  # (fine cells,) [steps], whole; inf where nobody can see it
    views: NDArray[np.int32]  # (fine cells,) places that see it, of all sensors together

    @property
    def known(self) -> NDArray[np.bool_]:
        """Which cells were looked at, shape (fine cells,): of the others nothing is known."""
        return (self.views > 0) | np.isinf(self.first)


def survey(
    problem: ExplorationProblem, places: Places, cells: NDArray[np.int64] | None = None
) -> Survey:
    """The earliest step at which any robot can see each cell.

    A robot that starts at s sees c no sooner than it can be at the nearest place of V(c). With
    `cells`, flat free ones, looks are from these instead of from the places; the others get 0, the
    least that can be said.
    """
    plan = problem.plan
    first = np.full(plan.walls.size, np.inf)
    if cells is not None:
        first[:] = 0.0
        first[cells] = np.inf
    views = np.zeros(plan.walls.size, dtype=np.int32)
    for sensor, robots in sensors_of(problem).items():
        soonest = np.full(len(places.cells), np.inf)
        for robot in robots:
            start = np.array([problem.starts[robot]], dtype=np.int64)
            steps = travel_of(problem, robot, start)[places.cells]
            soonest = np.minimum(soonest, [whole_steps(step) for step in steps.tolist()])
        sight = Sight(plan, sensor)
        if cells is None:
            _from_places(
                plan.walls,
                places.centres,
                soonest,
                sight.occlusion,
                sight.limits,
                sight.lows,
                sight.highs,
                sight.out,
                first,
                views,
            )
        else:
            at, following = places.by_fine_cell(plan)
            _from_cells(
                plan.walls,
                cells,
                at,
                following,
                soonest,
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
def _from_places(
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
        row, col = divmod(centres[i], cols)
        count = cells_in_sight(walls, row, col, occlusion, limits, lows, highs, out)
        for j in range(count):
            cell = out[j]
            if last[cell] != i:  # a cell may come twice in a look
                last[cell] = i
                views[cell] += 1
                first[cell] = min(first[cell], soonest[i])


@kernel
def _from_cells(
    walls: NDArray[np.uint8],
    cells: NDArray[np.int64],
    at: NDArray[np.int32],
    following: NDArray[np.int32],
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
    last = np.full(soonest.shape[0], -1, dtype=np.int32)
    for i in range(cells.shape[0]):
        row, col = divmod(cells[i], cols)
        count = cells_in_sight(walls, row, col, occlusion, limits, lows, highs, out)
        for j in range(count):
            place = at[out[j]]
            while place >= 0 and last[place] != i:
                last[place] = i
                views[cells[i]] += 1
                first[cells[i]] = min(first[cells[i]], soonest[place])
                place = following[place]


def group_views(
    plan: PlanningGrid, sensor: Sensor, places: Places, group: NDArray[np.int32], groups: int
) -> NDArray[np.bool_]:
    """Whether a place sees any cell of a group, shape (groups, n_places).

    `group` (fine cells,) is the number of the group each free cell is in, -1 for none. Sight is
    mutual, so the looks are from the places or from the cells, whichever are fewer.
    """
    sight = Sight(plan, sensor)
    sees = np.zeros((groups, len(places.cells)), dtype=np.bool_)
    cells = np.flatnonzero(group >= 0)
    if len(cells) < len(places.cells):
        looks, from_groups = cells, True
    else:
        looks, from_groups = places.centres, False
    at, following = places.by_fine_cell(plan)
    _group_views(
        plan.walls,
        looks,
        from_groups,
        group,
        at,
        following,
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
    looks: NDArray[np.int64],
    from_groups: bool,
    group: NDArray[np.int32],
    at: NDArray[np.int32],
    following: NDArray[np.int32],
    occlusion: bool,
    limits: NDArray[np.int32],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    sees: NDArray[np.bool_],
) -> None:
    cols = walls.shape[1]
    for i in range(looks.shape[0]):
        row, col = divmod(looks[i], cols)
        count = cells_in_sight(walls, row, col, occlusion, limits, lows, highs, out)
        for j in range(count):
            if from_groups:
                place = at[out[j]]
                while place >= 0:
                    sees[group[looks[i]], place] = True
                    place = following[place]
            elif group[out[j]] >= 0:
                sees[group[out[j]], i] = True
