"""View sets and earliest steps against looks from every place."""

import numpy as np
import pytest

from conav.exploration.bounds.views import Places, Sight, group_views, look_cells, survey
from conav.exploration.types import ExplorationProblem
from conav.geometry.sight import disc_cells, visible_cells
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import planning_grid
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor


def random_problem(
    seed: int, ratio: float, sensors: tuple[Sensor, ...], speeds: tuple[float, ...]
) -> ExplorationProblem:
    rng = np.random.default_rng(seed)
    cells = (rng.random((14, 17)) < 0.2).astype(np.uint8)
    plan = planning_grid(OccupancyGrid(cells, 0.5), cell_m=0.5 * ratio, radius_m=0.1)
    free = np.flatnonzero(plan.standable)
    starts = tuple(int(rng.choice(free)) for _ in sensors)
    robots = tuple(
        Robot(f"r{i}", 0.1, speed, MOTIONS["8-connected"], sensor)
        for i, (sensor, speed) in enumerate(zip(sensors, speeds, strict=True))
    )
    return ExplorationProblem(plan, robots, starts, 0, 1e3, "none")


def look(problem: ExplorationProblem, sensor: Sensor, centre: int) -> set[int]:
    walls = problem.plan.walls
    sight = Sight(problem.plan, sensor)
    row, col = divmod(centre, walls.shape[1])
    if sensor.occlusion:
        count = visible_cells(walls, row, col, sight.limits, sight.lows, sight.highs, sight.out)
    else:
        count = disc_cells(walls, row, col, sight.limits, sight.out)
    return set(sight.out[:count].tolist())


NEAR = Sensor("range", occlusion=True, range_m=1.6)
FAR = Sensor("range", occlusion=True, range_m=4.0)
DISC = Sensor("disc", occlusion=False, range_m=1.3)


@pytest.mark.parametrize("ratio", [1.0, 0.7, 1.6, 2.0])
@pytest.mark.parametrize("sensors", [(NEAR,), (FAR, FAR), (NEAR, DISC)])
def test_survey_is_the_nearest_place_that_sees_a_cell(
    ratio: float, sensors: tuple[Sensor, ...]
) -> None:
    problem = random_problem(4, ratio, sensors, (1.0, 0.5)[: len(sensors)])
    plan = problem.plan
    places = Places.of(problem)
    found = survey(problem, places)
    labels = plan.labels.reshape(-1)
    assert set(places.cells.tolist()) == set(
        np.flatnonzero(np.isin(labels, labels[list(problem.starts)])).tolist()
    )
    first = np.full(plan.walls.size, np.inf)
    views = np.zeros(plan.walls.size, dtype=int)
    steps = [steps_from_start(problem, robot) for robot in range(len(sensors))]
    for sensor in set(sensors):
        for place, centre in zip(places.cells.tolist(), places.centres.tolist(), strict=True):
            soonest = min(
                steps[robot][place] for robot in range(len(sensors)) if sensors[robot] == sensor
            )
            for cell in look(problem, sensor, centre):
                views[cell] += 1
                first[cell] = min(first[cell], soonest)
    assert found.views.tolist() == views.tolist()
    assert found.first.tolist() == first.tolist()


def steps_from_start(problem: ExplorationProblem, robot: int) -> list[float]:
    """Whole steps to each planning cell by Bellman and Ford, for a robot that need not turn."""
    plan = problem.plan
    rows, cols = plan.moves.shape
    least = np.full((rows, cols), np.inf)
    least.reshape(-1)[problem.starts[robot]] = 0.0
    for _ in range(rows * cols):
        before = least.copy()
        for row in range(rows):
            for col in range(cols):
                for k, (dr, dc) in enumerate(
                    [(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1)]
                ):
                    if plan.moves[row, col] & (1 << k):
                        length = least[row, col] + (1.0 if k < 4 else 2**0.5)
                        least[row + dr, col + dc] = min(least[row + dr, col + dc], length)
        if np.array_equal(before, least):
            break
    return np.ceil(least.reshape(-1) / problem.rates[robot] - 1e-6).tolist()


@pytest.mark.parametrize("ratio", [1.0, 0.7, 1.6])
@pytest.mark.parametrize("sensor", [NEAR, FAR, DISC])
@pytest.mark.parametrize("every", [1, 9])  # more cells than places, and fewer
def test_looking_from_a_cell_and_from_the_places_agree(
    ratio: float, sensor: Sensor, every: int
) -> None:
    problem = random_problem(4, ratio, (sensor,), (1.0,))
    places = Places.of(problem)
    free = np.flatnonzero(problem.plan.walls.reshape(-1) == 0)[::every]
    # Places outnumber cells where they are smaller, too.
    assert (len(free) < len(places.cells)) == (every == 9 or ratio < 1.0)
    group = np.full(problem.plan.walls.size, -1, dtype=np.int32)
    group[free] = np.arange(len(free))
    sees = group_views(problem.plan, sensor, places, group, len(free))
    for number, cell in enumerate(free.tolist()):
        around = look(problem, sensor, cell)
        mutual = [centre in around for centre in places.centres.tolist()]
        assert sees[number].tolist() == mutual


@pytest.mark.parametrize("taken", [1.0, 0.1])
def test_a_group_is_seen_where_any_of_its_cells_is(taken: float) -> None:
    problem = random_problem(9, 1.6, (NEAR,), (1.0,))
    places = Places.of(problem)
    rng = np.random.default_rng(0)
    walls = problem.plan.walls.reshape(-1)
    group = rng.integers(-1, 5, size=walls.size).astype(np.int32)
    group[(walls == 1) | (rng.random(walls.size) > taken)] = -1
    assert (np.count_nonzero(group >= 0) < len(places.cells)) == (taken < 1.0)
    sees = group_views(problem.plan, NEAR, places, group, 5)
    for i, centre in enumerate(places.centres.tolist()):
        held = {int(group[cell]) for cell in look(problem, NEAR, centre)} - {-1}
        assert set(np.flatnonzero(sees[:, i]).tolist()) == held


@pytest.mark.parametrize("ratio", [1.0, 0.7, 1.6])
@pytest.mark.parametrize("sensors", [(NEAR,), (NEAR, DISC)])
def test_a_survey_of_some_cells_knows_these_and_nothing_of_others(
    ratio: float, sensors: tuple[Sensor, ...]
) -> None:
    problem = random_problem(4, ratio, sensors, (1.0, 0.5)[: len(sensors)])
    places = Places.of(problem)
    free = np.flatnonzero(problem.plan.walls.reshape(-1) == 0)[::7]
    whole = survey(problem, places)
    part = survey(problem, places, free)
    assert part.known.nonzero()[0].tolist() == free.tolist()
    assert part.first[free].tolist() == whole.first[free].tolist()
    assert part.views[free].tolist() == whole.views[free].tolist()
    assert not part.first[~part.known].any()


def test_looks_are_counted_from_some_of_them() -> None:
    problem = random_problem(4, 1.0, (NEAR, DISC), (1.0, 1.0))
    places = Places.of(problem)
    few = Places(places.cells[:30], places.centres[:30])
    exact = sum(len(look(problem, sensor, c)) for sensor in (NEAR, DISC) for c in few.centres)
    # A cell on the border of two octants may be touched twice.
    assert exact / 30 <= look_cells(problem, few) <= 1.5 * exact / 30
