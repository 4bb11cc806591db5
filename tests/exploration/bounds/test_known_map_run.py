"""Upper bounds are real runs, of the simulation and accepted by the verifier."""

from pathlib import Path

import pytest

import conav
from conav.exploration.bounds.bounds import lower_bounds
from conav.exploration.bounds.known_map_plan import known_map_plan
from conav.exploration.types import ExplorationProblem
from conav.exploration.verify import verify_exploration
from conav.maps.ascii_art import parse_ascii
from conav.maps.builtin.catalogue import builtin_map
from conav.robots.motion import MOTIONS
from conav.runs.exploration_writer import ExplorationWriter
from conav.runs.reader import read_run
from conav.simulation.explore import exploration_problem
from conav.simulation.finish_bounds import Effort, finish_bounds
from conav.simulation.known_map_run import KnownMapFollower, known_map_run
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import run_exploration
from conav.simulation.world_state import generator_for

SHORT = Effort(rounds=20)


def problem_on(name: str, **options: object) -> ExplorationProblem:
    grid = builtin_map(name, width_m=9.0, height_m=9.0, resolution=0.15)
    return exploration_problem(grid, range_m=3.0, **options)[0]


@pytest.mark.parametrize("name", ["office", "maze", "cave"])
@pytest.mark.parametrize("motion", MOTIONS)
def test_teams_that_know_the_map_finish(name: str, motion: str) -> None:
    problem = problem_on(name, robots=3, motion=motion, seed=1)
    bounds = finish_bounds(problem, (100,), effort=SHORT)[100]
    run = known_map_run(problem, rounds=20)
    assert run is not None
    assert run.status == "done"
    assert run.metrics.t100_s == bounds.upper_s
    assert bounds.lower_s <= bounds.upper_s
    nearest = conav.explore(
        problem.plan.grid, range_m=3.0, robots=3, motion=motion, seed=1
    ).metrics.t100_s
    assert nearest is not None
    low, high = bounds.ratios(nearest)
    assert low <= high
    assert high >= 1.0


def test_the_verifier_accepts_the_run(tmp_path: Path) -> None:
    problem = problem_on("maze", robots=2, seed=3)
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    rng = generator_for(0, "plan")
    plan = known_map_plan(problem, observable, int(observable.sum()), rng, rounds=10)
    assert plan is not None
    follower = KnownMapFollower(plan.routes, problem.plan.moves)
    with ExplorationWriter(tmp_path / "run.mcap") as writer:
        run_exploration(problem, follower, name="known-map", writer=writer)
    report = verify_exploration(read_run(tmp_path / "run.mcap"))
    assert report.accepted, report.lines()


def test_alone_a_robot_takes_no_longer_than_its_plan() -> None:
    problem = problem_on("office", robots=1, seed=5)
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    rng = generator_for(0, "plan")
    plan = known_map_plan(problem, observable, int(observable.sum()), rng, rounds=10)
    assert plan is not None
    run = run_exploration(
        problem, KnownMapFollower(plan.routes, problem.plan.moves), name="known-map"
    )
    # The last cell may be seen before the end of the route.
    assert run.metrics.steps <= plan.steps + 1


@pytest.mark.parametrize("share", [50, 90, 99])
def test_shares_take_no_longer_than_all(share: int) -> None:
    problem = problem_on("maze", robots=2, seed=3)
    both = finish_bounds(problem, (share, 100), effort=SHORT)
    part, whole = both[share], both[100]
    assert part.upper_s is not None
    assert whole.upper_s is not None
    assert part.lower_s <= part.upper_s
    assert part.lower_s <= whole.upper_s
    assert part.upper_s <= whole.upper_s
    assert finish_bounds(problem, (share, 100), effort=SHORT) == both


def test_robots_that_meet_in_a_corridor_find_back_to_their_routes() -> None:
    grid = parse_ascii("############\n####.#######\n#..........#\n############")
    problem, _ = exploration_problem(
        grid, robots=2, range_m=1.0, starts=[(1.5, 1.5), (10.5, 1.5)], cell_m=1.0, speed_mps=1.0
    )
    # Each is sent to the other's end: they must pass at the only side pocket.
    cols = problem.plan.lattice.cols
    there = tuple(cols + col for col in range(1, 11))
    follower = KnownMapFollower((there, there[::-1]), problem.plan.moves)
    run = run_exploration(problem, follower, name="known-map")
    assert run.status == "done"
    assert run.metrics.t100_s is not None


def test_without_time_there_is_no_upper_bound() -> None:
    problem = problem_on("maze", robots=1, seed=3)
    hurried = ExplorationProblem(problem.plan, problem.robots, problem.starts, 3, 2.0)
    bounds = finish_bounds(hurried, (100,), effort=SHORT)[100]
    assert bounds.upper_s is None
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    assert bounds == lower_bounds(problem, observable)
