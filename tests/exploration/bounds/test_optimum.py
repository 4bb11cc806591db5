"""The true optimum of small worlds, by trying everything, lies between the bounds."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from conav.exploration.bounds.bounds import cells_needed, lower_bounds
from conav.exploration.types import ExplorationProblem
from conav.geometry.directions import STAY
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import PlanningGrid, planning_grid
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.finish_bounds import Effort, finish_bounds
from conav.simulation.no_traffic import pass_through
from conav.simulation.observable import observable_cells
from conav.simulation.sensing import Looker, look

TOO_MANY = 20_000  # states of one robot
SHORT = Effort(rounds=20)

State = tuple[int, int, float]  # planning cell, heading, travel credit


class TooLarge(Exception):
    """There are more states than a test has time for."""


def looks(problem: ExplorationProblem, robot: int, observable: np.ndarray) -> dict[int, int]:
    """What the simulation shows a robot from each place, a bit for each observable cell."""
    plan = problem.plan
    sensor = problem.robots[robot].sensor
    looker = Looker(
        min(sensor.range_m / plan.lattice.resolution, sum(plan.walls.shape)),
        plan.walls.size,
        sensor.occlusion,
    )
    number = np.cumsum(observable.reshape(-1)) - 1
    result: dict[int, int] = {}
    for place in np.flatnonzero(plan.standable).tolist():
        row, col = divmod(place, plan.lattice.cols)
        count = look(
            plan.walls,
            np.full(plan.walls.shape, 2, dtype=np.uint8),  # all unknown
            int(plan.lattice.fine_row[row]),
            int(plan.lattice.fine_col[col]),
            looker.occlusion,
            looker.limits,
            looker.lows,
            looker.highs,
            looker.out,
            looker.fresh,
            observable,
            np.zeros((1, plan.walls.size), dtype=np.uint8),
            0,
            np.zeros(1, dtype=np.int64),
            np.zeros(1, dtype=np.int64),
            np.zeros(1, dtype=np.int64),
        )
        seen = 0
        for cell in looker.fresh[:count].tolist():
            if observable.reshape(-1)[cell]:
                seen |= 1 << int(number[cell])
        result[place] = seen
    return result


def moves_of(problem: ExplorationProblem, robot: int, state: State) -> set[State]:
    """Where a robot can be a step later, by the simulation's own rule for robots alone."""
    plan = problem.plan
    ways = int(plan.moves.reshape(-1)[state[0]])
    result: set[State] = set()
    for wish in (STAY, *range(8)):
        cells = np.array([state[0]], dtype=np.int32)
        heading = np.array([state[1]], dtype=np.int8)
        credit = np.array([state[2]])
        pass_through(
            cells,
            np.array([wish], dtype=np.int8),
            np.array([ways], dtype=np.uint8),
            plan.lattice.cols,
            heading,
            np.array([problem.robots[robot].motion.turn_costs_step], dtype=np.uint8),
            problem.rates[robot : robot + 1],
            credit,
            np.zeros(1),
            np.zeros(1, dtype=np.uint8),
        )
        result.add((int(cells[0]), int(heading[0]), round(float(credit[0]), 9)))
    return result


def largest(masks: set[int]) -> list[int]:
    """The sets, as bits, that are not part of another."""
    kept: list[int] = []
    for mask in sorted(masks, key=lambda item: -item.bit_count()):
        if not any(mask & other == mask for other in kept):
            kept.append(mask)
    return kept


def seen_sets(
    problem: ExplorationProblem, robot: int, observable: np.ndarray
) -> Iterator[list[int]]:
    """Step by step, all that one robot can have seen by then; parts of something else left out."""
    seen_from = looks(problem, robot, observable)
    start = problem.starts[robot]
    # A robot may face any way at first.
    headings = range(4) if problem.robots[robot].motion.turn_costs_step else (0,)
    states: dict[State, list[int]] = {(start, h, 0.0): [seen_from[start]] for h in headings}
    following: dict[State, set[State]] = {}
    while True:
        yield largest({mask for masks in states.values() for mask in masks})
        reached: dict[State, set[int]] = {}
        for state, masks in states.items():
            if state not in following:
                following[state] = moves_of(problem, robot, state)
            for after in following[state]:
                reached.setdefault(after, set()).update(
                    mask | seen_from[after[0]] for mask in masks
                )
        states = {state: largest(masks) for state, masks in reached.items()}
        if sum(map(len, states.values())) > TOO_MANY:
            raise TooLarge


def optimum_steps(problem: ExplorationProblem, share: float, most: int = 40) -> int:
    """The least step by which a team that passes through each other sees a share, by trying all.

    Robots that do not hinder one another see together what each sees for itself, so the joint
    states need not be listed.
    """
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    needed = cells_needed(share, int(observable.sum()))
    teams = [seen_sets(problem, robot, observable) for robot in range(len(problem.robots))]
    for step in range(most):
        together = {0}
        for sets in teams:
            mine = next(sets)
            if len(together) * len(mine) > 50 * TOO_MANY:
                raise TooLarge
            together = set(largest({a | b for a in together for b in mine}))
        if max(mask.bit_count() for mask in together) >= needed:
            return step
    raise TooLarge


def team(
    plan: PlanningGrid,
    starts: list[int],
    motion: str,
    *,
    reach: float,
    occlusion: bool = True,
    speeds: tuple[float, ...] = (),
    traffic: str = "none",
) -> ExplorationProblem:
    robots = tuple(
        Robot(
            f"robot_{number}",
            radius_m=plan.radius_m,
            speed_mps=speeds[number] if speeds else 1.0,
            motion=MOTIONS[motion],
            sensor=Sensor("any", occlusion, reach),
        )
        for number in range(len(starts))
    )
    return ExplorationProblem(plan, robots, tuple(starts), 0, 1e4, traffic)


ROOMS = {
    "two rooms": """
        #########
        #...#...#
        #.......#
        #...#...#
        #########""",
    "closet": """
        ##########
        #.....#..#
        #.###.#..#
        #.#.#....#
        #.#...####
        ##########""",
    "corridor": """
        ###########
        ###.###.###
        #.........#
        ###.###.###
        ###########""",
    "spiral": """
        #######
        #.....#
        #.###.#
        #.#...#
        #.#####
        #.....#
        #######""",
}


def room(name: str) -> OccupancyGrid:
    text = "\n".join(line.strip() for line in ROOMS[name].strip().split("\n"))
    return parse_ascii(text)


@pytest.mark.parametrize("name", ROOMS)
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("reach", [1.0, 2.0, 5.0, 9.0])
@pytest.mark.parametrize("robots", [1, 2])
def test_optimum_lies_between(name: str, motion: str, reach: float, robots: int) -> None:
    plan = planning_grid(room(name), cell_m=1.0, radius_m=0.1, diagonal=MOTIONS[motion].diagonal)
    free = np.flatnonzero(plan.standable)
    starts = [int(free[0]), int(free[-1])][:robots]
    problem = team(plan, starts, motion, reach=reach)
    kept_apart = team(plan, starts, motion, reach=reach, traffic="pibt")
    alone, apart = (finish_bounds(one, effort=SHORT) for one in (problem, kept_apart))
    for share, bounds in alone.items():
        optimum = optimum_steps(problem, share / 100)
        assert bounds.lower_s <= optimum * problem.step_s + 1e-9
        assert bounds.upper_s is not None
        assert bounds.upper_s >= optimum * problem.step_s - 1e-9
        # A run with the traffic rule is no faster than the best without.
        driven = apart[share]
        assert driven.lower_s == bounds.lower_s
        assert driven.upper_s is None or driven.upper_s >= optimum * problem.step_s - 1e-9


def test_bounds_meet_where_the_way_is_forced() -> None:
    # Dead ends at both sides of the start: only the witness bound knows the way back.
    plan = planning_grid(room("closet"), cell_m=1.0, radius_m=0.1, diagonal=False)
    problem = team(plan, [int(np.flatnonzero(plan.standable)[0])], "4-connected", reach=5.0)
    bounds = finish_bounds(problem, (100,), effort=SHORT)[100]
    assert (bounds.swath_s, bounds.eccentricity_s, bounds.witness_s) == (3.0, 11.0, 15.0)
    assert bounds.by == "witness"
    assert bounds.upper_s == 15.0 == optimum_steps(problem, 1.0) * problem.step_s


def test_robots_by_themselves_are_the_joint_states() -> None:
    plan = planning_grid(room("corridor"), cell_m=1.0, radius_m=0.1, diagonal=False)
    free = np.flatnonzero(plan.standable)
    problem = team(plan, [int(free[0]), int(free[1])], "4-connected", reach=1.0)
    observable = observable_cells(plan, problem.starts, problem.robots[0].sensor)
    for share in (0.6, 0.8, 1.0):
        needed = cells_needed(share, int(observable.sum()))
        a, b = (looks(problem, robot, observable) for robot in (0, 1))
        starts = tuple((start, 0, 0.0) for start in problem.starts)
        states = {(starts, a[problem.starts[0]] | b[problem.starts[1]])}
        step = 0
        while max(seen.bit_count() for _, seen in states) < needed:
            step += 1
            states = {
                ((one, two), seen | a[one[0]] | b[two[0]])
                for (first, second), seen in states
                for one in moves_of(problem, 0, first)
                for two in moves_of(problem, 1, second)
            }
        assert optimum_steps(problem, share) == step


@st.composite
def worlds(draw: st.DrawFn) -> ExplorationProblem:
    """Random small maps; planning cells of the map's own size, larger, smaller, and no multiple."""
    motion = draw(st.sampled_from(sorted(MOTIONS)))
    ratio = draw(st.sampled_from([1.0, 1.0, 1.5, 2.0, 0.75, 2.5]))
    side = int(draw(st.integers(3, 6)) * max(ratio, 1.0))
    shape = (side, int(draw(st.integers(3, 6)) * max(ratio, 1.0)))
    walls = draw(
        st.lists(st.booleans(), min_size=shape[0] * shape[1], max_size=shape[0] * shape[1])
    )
    more = draw(st.lists(st.booleans(), min_size=len(walls), max_size=len(walls)))
    cells = np.array([a and b for a, b in zip(walls, more, strict=True)], dtype=np.uint8)
    grid = OccupancyGrid(cells.reshape(shape), 1.0)
    plan = planning_grid(
        grid, cell_m=ratio, radius_m=0.2 * ratio, diagonal=MOTIONS[motion].diagonal
    )
    free = np.flatnonzero(plan.standable).tolist()
    assume(0 < len(free) <= 25)
    starts = draw(st.lists(st.sampled_from(free), min_size=1, max_size=2))
    return team(
        plan,
        starts,
        motion,
        reach=draw(st.sampled_from([0.0, 1.0, 1.5, 2.0, 3.7, 5.0, 8.0])),
        occlusion=draw(st.booleans()),
        speeds=draw(st.sampled_from([(1.0, 1.0), (1.0, 0.6), (0.3, 1.0)])),
    )


@settings(deadline=None, max_examples=150, suppress_health_check=list(HealthCheck))
@given(worlds(), st.sampled_from([1.0, 1.0, 0.9, 0.7, 0.5]))
def test_no_lower_bound_is_above_the_optimum(problem: ExplorationProblem, share: float) -> None:
    try:
        optimum = optimum_steps(problem, share, most=25)
    except TooLarge:
        assume(False)
        return
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    bounds = lower_bounds(problem, observable, share, witnesses=8)
    least = optimum * problem.step_s + 1e-9
    assert bounds.swath_s <= least
    assert bounds.eccentricity_s <= least
    assert bounds.witness_s <= least
    assert bounds.lower_s == max(bounds.swath_s, bounds.eccentricity_s, bounds.witness_s)


def test_all_that_can_be_seen_only_grows() -> None:
    plan = planning_grid(room("corridor"), cell_m=1.0, radius_m=0.1)
    problem = team(plan, [int(np.flatnonzero(plan.standable)[0])], "8-connected", reach=2.0)
    observable = observable_cells(plan, problem.starts, problem.robots[0].sensor)
    sets = seen_sets(problem, 0, observable)
    for before, after in pairwise([next(sets) for _ in range(5)]):
        assert all(any(old & new == old for new in after) for old in before)
