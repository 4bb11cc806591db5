"""The swath bound: its sets and gains by brute force, and the traps around it."""

from math import ceil, pi

import numpy as np
import pytest

from conav.exploration.bounds.swath import Swath, catch_gains, swath_of, swath_steps
from conav.exploration.bounds.views import Places, Sight
from conav.exploration.types import ExplorationProblem
from conav.geometry.directions import DCOL, DROW, SQRT2
from conav.geometry.sight import visible_cells
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import PlanningGrid, planning_grid
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.known_map_run import KnownMapFollower
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import run_exploration


def problem_on(
    plan: PlanningGrid,
    starts: list[int],
    reach: float,
    *,
    occlusion: bool = True,
    speeds: tuple[float, ...] = (),
) -> ExplorationProblem:
    motion = MOTIONS["8-connected" if plan.diagonal else "4-connected"]
    robots = tuple(
        Robot(
            f"r{i}",
            plan.radius_m,
            speeds[i] if speeds else 1.0,
            motion,
            Sensor("any", occlusion, reach),
        )
        for i in range(len(starts))
    )
    return ExplorationProblem(plan, robots, tuple(starts), 0, 1e5, "none")


def swath_on(problem: ExplorationProblem) -> tuple[Swath, int]:
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    return swath_of(problem, Places.of(problem), observable), int(observable.sum())


def gains_on(plan: PlanningGrid, sensor: Sensor, start: int) -> dict[int, list[int]]:
    """The gains of the moves to each place."""
    motion = MOTIONS["8-connected" if plan.diagonal else "4-connected"]
    robot = Robot("r", plan.radius_m, sensor=sensor, motion=motion)
    problem = ExplorationProblem(plan, (robot,), (start,), 0, 1.0)
    places = Places.of(problem)
    gains = catch_gains(plan, sensor, places, observable_cells(plan, [start], sensor))
    return dict(zip(places.cells.tolist(), gains.tolist(), strict=True))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("ratio", [1.0, 1.4, 2.0, 0.6])
@pytest.mark.parametrize("occlusion", [True, False])
def test_gains_against_their_definition(seed: int, ratio: float, occlusion: bool) -> None:
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid((rng.random((12, 13)) < 0.25).astype(np.uint8), 1.0)
    plan = planning_grid(grid, cell_m=ratio, radius_m=0.1)
    sensor = Sensor("any", occlusion, 3.3)
    start = int(rng.choice(np.flatnonzero(plan.standable)))
    gains = gains_on(plan, sensor, start)
    lattice = plan.lattice
    label = plan.labels.reshape(-1)[start]
    reachable = np.flatnonzero(plan.labels.reshape(-1) == label).tolist()
    assert list(gains) == reachable
    observable = np.argwhere(observable_cells(plan, [start], sensor))
    in_range = {
        p: {
            (r, c)
            for r, c in observable.tolist()
            if (r - lattice.fine_row[p // lattice.cols]) ** 2
            + (c - lattice.fine_col[p % lattice.cols]) ** 2
            <= 3.3**2
        }
        for p in reachable
    }
    for p in reachable:
        for k in range(8):
            expected = 0
            if plan.moves.reshape(-1)[p] & (1 << k):
                q = p + DROW[k] * lattice.cols + DCOL[k]
                expected = len(in_range[p] - in_range[q])
            assert gains[p][k] == expected
    problem = problem_on(plan, [start], 3.3, occlusion=occlusion)
    swath, _ = swath_on(problem)
    assert swath.caught == len(in_range[start])


def disc(row: int, col: int, reach: float) -> set[tuple[int, int]]:
    span = range(-int(reach) - 1, int(reach) + 2)
    return {(row + r, col + c) for r in span for c in span if r * r + c * c <= reach * reach}


@pytest.mark.parametrize("ratio", [1.0, 2.0, 2.5, 3.0, 0.5, 1.3])
@pytest.mark.parametrize("reach", [2.0, 4.0, 4.6])
def test_on_open_ground_gains_are_those_of_the_disc(ratio: float, reach: float) -> None:
    """|(D + e) \\ D| for the largest offset e of consecutive centres; 2 floor(r) + 1 for e = 1."""
    side = 30
    plan = planning_grid(
        OccupancyGrid(np.zeros((side, side), dtype=np.uint8), 1.0), cell_m=ratio, radius_m=0.1
    )
    middle = plan.moves.shape[0] // 2 * plan.moves.shape[1] + plan.moves.shape[1] // 2
    gains = gains_on(plan, Sensor("any", occlusion=True, range_m=reach), middle)
    offsets = set(np.diff(plan.lattice.fine_col).tolist())
    assert len(offsets) == (1 if ratio in (1.0, 2.0, 3.0) else 2)
    still = disc(0, 0, reach)
    straight = max(len(disc(0, e, reach) - still) for e in offsets)
    slanting = max(len(disc(d, e, reach) - still) for d in offsets for e in offsets)
    assert max(max(row[:4]) for row in gains.values()) == straight
    assert max(max(row[4:]) for row in gains.values()) == slanting
    if ratio == 1.0:
        assert straight == 2 * int(reach) + 1


def test_rates_are_those_of_the_better_move() -> None:
    # r = 4.5: 9 new cells by a straight step, 13 by a diagonal of 1.41 steps, which is more.
    plan = planning_grid(
        OccupancyGrid(np.zeros((60, 60), dtype=np.uint8), 1.0), cell_m=1.0, radius_m=0.1
    )
    swath, count = swath_on(problem_on(plan, [30 * 60 + 30], 4.5))
    assert len(disc(0, 1, 4.5) - disc(0, 0, 4.5)) == 9
    assert len(disc(1, 1, 4.5) - disc(0, 0, 4.5)) == 13
    assert swath.caught == len(disc(0, 0, 4.5))
    for steps in (1, 10, 50):
        assert swath.seen_by(steps) == swath.caught + int(13 / SQRT2 * steps)
    assert swath_steps(swath, count) >= ceil((count - swath.caught) * SQRT2 / 13)


def test_what_is_seen_at_the_start_would_be_too_little() -> None:
    """A robot round the corner of a room: the discs count, not what is seen of them at first."""
    text = [
        "#" * 20,
        *["#" * 5 + "." * 14 + "#"] * 13,
        "#" * 5 + "." + "#" * 14,
        "#....." + "#" * 14,
    ]
    grid = parse_ascii("\n".join([*text, "#" * 20]))
    plan = planning_grid(grid, cell_m=1.0, radius_m=0.1, diagonal=False)
    start = 1 * plan.lattice.cols + 4
    problem = problem_on(plan, [start], 20.0)
    swath, count = swath_on(problem)
    row, col = 1, 4
    sight = Sight(plan, problem.robots[0].sensor)
    seen = visible_cells(plan.walls, row, col, sight.limits, sight.lows, sight.highs, sight.out)
    free = {c for c in sight.out[:seen].tolist() if plan.walls.reshape(-1)[c] == 0}
    route = (start, start + 1, start + 1 + 20, start + 1 + 40)
    run = run_exploration(problem, KnownMapFollower((route,), plan.moves), name="by hand")
    assert run.status == "done"
    done = next(step for step, covered in enumerate(run.covered) if covered == count)
    assert ceil((count - len(free)) / (2 * 20 + 1)) > done  # the false bound
    assert swath.caught > len(free)
    assert swath_steps(swath, count) <= done


def test_lanes_beat_the_continuous_bound_but_not_ours() -> None:
    """1 m cells, r = 4 m: a grid of 99 x 99 m is swept in lanes nine cells apart."""
    side, reach = 99, 4.0
    plan = planning_grid(
        OccupancyGrid(np.zeros((side, side), dtype=np.uint8), 1.0),
        cell_m=1.0,
        radius_m=0.1,
        diagonal=False,
    )
    route: list[int] = []
    for lane in range(11):
        row = 4 + 9 * lane
        cols = range(side) if lane % 2 == 0 else range(side - 1, -1, -1)
        route += [row * side + col for col in cols]
        if lane < 10:
            route += [(row + up) * side + cols[-1] for up in range(1, 9)]
    problem = problem_on(plan, [route[0]], reach)
    swath, count = swath_on(problem)
    run = run_exploration(problem, KnownMapFollower((tuple(route),), plan.moves), name="lanes")
    assert run.status == "done"
    steps = run.metrics.steps
    assert steps <= 11 * 98 + 10 * 9 == 1168
    assert steps < (side * side - pi * reach**2) / (2 * reach)
    assert 0.9 * steps < swath_steps(swath, count) <= steps


def test_teams_add_up_and_slow_robots_count_for_less() -> None:
    plan = planning_grid(
        OccupancyGrid(np.zeros((80, 80), dtype=np.uint8), 1.0),
        cell_m=1.0,
        radius_m=0.1,
        diagonal=False,
    )
    starts = [40 * 80 + 10, 40 * 80 + 70]
    one, count = swath_on(problem_on(plan, starts[:1], 4.0))
    two, _ = swath_on(problem_on(plan, starts, 4.0))
    slow, _ = swath_on(problem_on(plan, starts, 4.0, speeds=(1.0, 0.5)))
    for steps in (10, 20):
        gained = one.seen_by(steps) - one.caught
        assert gained == 9 * steps
        assert two.seen_by(steps) - two.caught == 2 * gained
        assert slow.seen_by(steps) - slow.caught == gained + gained // 2
    assert swath_steps(one, count) > swath_steps(slow, count) > swath_steps(two, count)


def test_two_sensors_are_counted_for_themselves() -> None:
    plan = planning_grid(
        OccupancyGrid(np.zeros((80, 80), dtype=np.uint8), 1.0),
        cell_m=1.0,
        radius_m=0.1,
        diagonal=False,
    )
    base = problem_on(plan, [40 * 80 + 10, 40 * 80 + 70], 4.0)
    far, near = base.robots[0], base.robots[1]
    near = Robot("near", near.radius_m, 1.0, near.motion, Sensor("any", True, 2.0))
    mixed = ExplorationProblem(plan, (far, near), base.starts, 0, 1e4, "none")
    swath, _ = swath_on(mixed)
    assert swath.caught == len(disc(0, 0, 4.0)) + len(disc(0, 0, 2.0))
    assert swath.seen_by(10) - swath.caught == 10 * 9 + 10 * 5


def test_what_nobody_can_catch_is_never_seen() -> None:
    plan = planning_grid(
        OccupancyGrid(np.zeros((5, 5), dtype=np.uint8), 1.0), cell_m=1.0, radius_m=0.1
    )
    swath, count = swath_on(problem_on(plan, [0], 1.0))
    assert swath_steps(swath, count) < np.inf
    assert swath_steps(swath, count + 1000) == np.inf
    assert swath_steps(swath, 0) == 0.0
