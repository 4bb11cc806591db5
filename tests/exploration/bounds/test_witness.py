"""The witness bound: its groups, its distances, and cases by hand."""

import numpy as np
import pytest

from conav.exploration.bounds.bounds import lower_bounds
from conav.exploration.bounds.travel import travel_from
from conav.exploration.bounds.views import Places, Sight, survey
from conav.exploration.bounds.witness import grown_groups, pool_of, single_cells, witness_bound
from conav.exploration.types import ExplorationProblem
from conav.geometry.sight import visible_cells
from conav.maps.ascii_art import parse_ascii
from conav.maps.builtin.catalogue import builtin_map
from conav.maps.planning_grid import planning_grid
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells


def office(robots: int = 2) -> tuple[ExplorationProblem, np.ndarray]:
    grid = builtin_map("office", width_m=12.0, height_m=12.0, resolution=0.15)
    problem, _ = exploration_problem(grid, robots=robots, range_m=4.0, seed=2)
    return problem, observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)


def star(arms: int, length: int, robots: int) -> tuple[ExplorationProblem, np.ndarray]:
    """Corridors of one length that leave a crossing in up to four directions."""
    side = 2 * length + 3
    rows = [["#"] * side for _ in range(side)]
    middle = side // 2
    for dr, dc in [(0, 1), (1, 0), (0, -1), (-1, 0)][:arms]:
        for step in range(length + 1):
            rows[middle + step * dr][middle + step * dc] = "."
    text = "\n".join("".join(row) for row in rows)
    plan = planning_grid(parse_ascii(text), cell_m=1.0, radius_m=0.1, diagonal=False)
    robot = Robot("r", 0.1, 1.0, MOTIONS["4-connected"], Sensor("any", True, 1.0))
    start = middle * side + middle
    problem = ExplorationProblem(plan, (robot,) * robots, (start,) * robots, 0, 1e4, "none")
    return problem, observable_cells(plan, problem.starts, robot.sensor)


@pytest.mark.parametrize(
    ("arms", "robots", "expected"),
    # Each arm is seen to its end from one cell before it: 9 in, 9 out.
    [(2, 1, 27), (3, 1, 45), (4, 1, 63), (4, 2, 27), (4, 3, 27), (4, 4, 9), (3, 2, 27)],
)
def test_arms_of_a_star(arms: int, robots: int, expected: float) -> None:
    problem, observable = star(arms, 10, robots)
    bounds = lower_bounds(problem, observable)
    assert bounds.witness_s == expected * problem.step_s
    assert bounds.lower_s == bounds.witness_s
    assert bounds.eccentricity_s == 9 * problem.step_s


def test_who_may_miss_a_little_can_leave_out_an_arm() -> None:
    problem, observable = star(4, 10, 1)
    assert observable.sum() == 41
    # Nine cells of an arm are not seen from the crossing. With eight to spare all arms must be
    # entered, with nine one may be left out, with nineteen two.
    steps = [
        lower_bounds(problem, observable, (41 - spare) / 41).witness_s / problem.step_s
        for spare in (0, 1, 8, 9, 18, 19)
    ]
    assert steps == sorted(steps, reverse=True)
    assert steps[0] == 63
    assert steps[1] >= 55  # groups of two cells: each arm one step shorter, in and out
    assert steps[2] >= 7
    assert 0 < steps[3] < 45
    assert steps[5] <= 9 + 18


def test_never_below_the_eccentricity_for_the_whole_map() -> None:
    problem, observable = office()
    bounds = lower_bounds(problem, observable)
    assert bounds.by == "witness"
    assert bounds.witness_s > bounds.eccentricity_s
    for most in range(1, 6):
        fewer = lower_bounds(problem, observable, witnesses=most)
        assert fewer.eccentricity_s <= fewer.witness_s <= bounds.witness_s
        assert len(fewer.witnesses) <= most
    assert lower_bounds(problem, observable, witnesses=0).witness_s == 0.0


@pytest.mark.parametrize("spare", [1, 7, 60])
def test_groups_are_apart_connected_and_as_large_as_asked(spare: int) -> None:
    problem, observable = office()
    seen = survey(problem, Places.of(problem))
    group, seeds = grown_groups(seen, observable, spare + 1)
    assert len(seeds) > 3
    from scipy import ndimage

    for number, seed in enumerate(seeds.tolist()):
        held = group == number
        assert held[seed]
        assert held.sum() == spare + 1
        assert observable.reshape(-1)[held].all()
        assert ndimage.label(held.reshape(observable.shape))[1] == 1
    alone, cells = single_cells(seen, observable)
    assert len(set(cells.tolist())) == len(cells)
    assert alone[cells].tolist() == list(range(len(cells)))
    assert seen.first[cells[0]] == seen.first[observable.reshape(-1) == 1].max()


def test_distances_of_a_pool_by_looking_from_every_place() -> None:
    problem, observable = office()
    plan = problem.plan
    places = Places.of(problem)
    seen = survey(problem, places)
    group, seeds = single_cells(seen, observable)
    pool = pool_of(problem, places, group, seeds)
    sight = Sight(plan, problem.robots[0].sensor)
    views: list[list[int]] = [[] for _ in seeds]
    for place, centre in zip(places.cells.tolist(), places.centres.tolist(), strict=True):
        row, col = divmod(centre, plan.walls.shape[1])
        count = visible_cells(
            plan.walls, row, col, sight.limits, sight.lows, sight.highs, sight.out
        )
        looked = set(sight.out[:count].tolist())
        for number, cell in enumerate(seeds.tolist()):
            if cell in looked:
                views[number].append(place)
    for robot, start in enumerate(problem.starts):
        travel = travel_from(plan.moves, np.array([start]), 0.0)
        assert pool.first[robot].tolist() == [travel[held].min() for held in views]
    for a in range(0, len(seeds), 17):
        travel = travel_from(plan.moves, np.array(views[a]), 0.0)
        assert pool.between[0, a].tolist() == [travel[held].min() for held in views]
    assert pool.sizes.tolist() == [1] * len(seeds)
    assert pool.kind.tolist() == [0, 0]


def test_robots_of_two_kinds_have_ways_of_their_own() -> None:
    problem, observable = office()
    slow = Robot("slow", 0.1, 0.2, MOTIONS["8-connected"], Sensor("range", True, 2.0))
    mixed = ExplorationProblem(
        problem.plan, (problem.robots[0], slow), problem.starts, 0, 1e4, "none"
    )
    places = Places.of(mixed)
    seen = survey(mixed, places)
    pool = pool_of(mixed, places, *single_cells(seen, observable))
    assert pool.kind.tolist() == [0, 1]
    assert (pool.between[1] >= pool.between[0] - 1e-9).all()
    assert pool.between[1].sum() > 2 * pool.between[0].sum()
    alike = lower_bounds(problem, observable)
    assert lower_bounds(mixed, observable).witness_s >= alike.witness_s


def test_large_teams_get_fewer_witnesses() -> None:
    problem, observable = office(robots=9)
    seen = survey(problem, Places.of(problem))
    found = witness_bound(problem, Places.of(problem), seen, observable, int(observable.sum()))
    assert len(found.cells) < 15
    assert found.steps >= seen.first[observable.reshape(-1) == 1].max()
