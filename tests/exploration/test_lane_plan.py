"""What a leader plans from what it knows, and that plans survive robots that stall and die."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from conav.exploration.frontier_tasks import find_tasks
from conav.exploration.lane_pieces import Piece, find_pieces, lay_lanes, wanted_cells
from conav.exploration.lane_plan import (
    LanePlan,
    Leg,
    _carry_on,
    _kept_cuts,
    _left_behind,
    plan_lanes,
)
from conav.exploration.lanes_and_pockets import LanesAndPockets, LanesMemory
from conav.exploration.sweep_drive import Sweep
from conav.exploration.sweep_routes import Routes, no_routes
from conav.exploration.team_assignment import Order
from conav.exploration.types import ExplorationProblem, TeamView
from conav.exploration.verify import verify_exploration
from conav.maps.occupancy_grid import OCCUPIED, UNKNOWN, OccupancyGrid
from conav.runs.exploration_writer import ExplorationWriter
from conav.runs.reader import read_run
from conav.runs.types import ExplorationRun
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import ExplorationResult, run_exploration
from conav.simulation.world_state import WorldState, new_world
from conav.status import Status


def empty(rows: int, cols: int) -> NDArray[np.uint8]:
    return np.zeros((rows, cols), dtype=np.uint8)


def problem_of(cells: NDArray[np.uint8], **options: Any) -> ExplorationProblem:
    """Map cells and planning cells of 1 m, a range of 4 m."""
    made, _ = exploration_problem(
        OccupancyGrid(cells, 1.0),
        **{"robots": 2, "range_m": 4.0, "cell_m": 1.0, "speed_mps": 1.0, "seed": 1} | options,
    )
    return made


def begun(cells: NDArray[np.uint8], steps: int = 0, **options: Any) -> WorldState:
    """A run some steps on, everybody having looked and decided."""
    problem = problem_of(cells, **options)
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, LanesAndPockets(), seen)
    engine = engine_for(state)
    for _ in range(steps):
        engine.move(state, engine.sense_and_decide(state, []).actions)
    engine.sense_and_decide(state, [])
    return state


def view_of(state: WorldState, robot: int = 0) -> TeamView:
    return engine_for(state)._view(state, robot)


def planned(state: WorldState, plan: LanePlan) -> list[Sweep | Order | None]:
    robots = range(len(state.cells))
    return plan_lanes(plan, view_of(state), robots, state.cells, np.random.default_rng(0))


@cache
def empty_world(rows: int, cols: int, cell_m: float) -> TeamView:
    return view_of(begun(empty(rows, cols), cell_m=cell_m))


# --- given up ---------------------------------------------------------------------------------


@settings(deadline=None, max_examples=40)
@given(
    st.sampled_from((1.0, 2.5, 3.0)),
    st.integers(0, 1),
    st.integers(-2, 12),
    st.integers(-2, 12),
    st.integers(0, 20),
)
def test_give_up_marks_the_rows_of_the_lane(
    ratio: float, axis: int, low: int, high: int, lane: int
) -> None:
    view = empty_world(30, 35, ratio)
    plan = LanePlan(lay_lanes(axis, 4.0, view.lattice))
    assert plan.lanes is not None
    lane %= len(plan.lanes.middle)
    across = int(plan.lanes.middle[lane])
    plan.give_up(Sweep(axis, across, low, high, low, high), view)
    along_of = view.lattice.row_of if axis == 0 else view.lattice.col_of
    strip_of = view.lattice.col_of if axis == 0 else view.lattice.row_of
    edges = plan.lanes.edges
    expected = np.zeros((30, 35), dtype=np.uint8)
    for r, c in np.ndindex(expected.shape):
        along, side = (r, c) if axis == 0 else (c, r)
        expected[r, c] = low <= along_of[along] <= high and edges[lane] <= side < edges[lane + 1]
    assert np.array_equal(plan.mask(view), expected)
    assert strip_of[edges[lane]] <= across <= strip_of[edges[lane + 1] - 1]


def test_what_others_have_swept_in_other_lanes_is_left_alone() -> None:
    view = view_of(begun(empty(30, 30)))
    plan = LanePlan()
    plan.give_up(Sweep(0, 3, 2, 9, 2, 9), view)  # no lanes yet
    assert plan.given_up is None
    plan.lanes = lay_lanes(0, 4.0, view.lattice)
    plan.give_up(Sweep(1, 3, 2, 9, 2, 9), view)
    assert not plan.mask(view).any()
    plan.give_up(Sweep(0, 3, 2, 9, 2, 9), view)
    plan.give_up(Sweep(0, 27, 0, 29, 0, 1), view)
    assert plan.mask(view).sum() == 8 * 7 + 2 * 8  # lanes of 7, 8, 7 and 8


# --- from plan to plan ------------------------------------------------------------------------


def test_cuts_are_kept_where_pieces_are_not_driven_one_after_the_other() -> None:
    plan = LanePlan(
        routes={
            0: [Leg(0, 0, 9, 0), Leg(0, 10, 19, 0), Leg(1, 0, 4, 1)],
            2: [Leg(0, 20, 29, 0), Leg(2, 15, 20, 1), Leg(1, 5, 9, 0), Leg(2, 5, 14, 1)],
        }
    )
    # Lane 0: 0 | 10 is one drive, 20 is another robot's. Lane 1: two robots'. Lane 2: one robot's,
    # with something in between.
    assert _kept_cuts(plan, 3) == [[20], [5], [15]]
    assert _kept_cuts(LanePlan(), 2) == [[], []]


def carried(plan: LanePlan, robots: list[int], pieces: list[Piece]) -> Routes:
    routes = no_routes(len(robots), len(pieces))
    _carry_on(plan, robots, pieces, routes)
    return routes


def stops(routes: Routes) -> list[list[tuple[int, int]]]:
    return [
        list(zip(numbers[:count].tolist(), ways[:count].tolist(), strict=True))
        for numbers, ways, count in zip(
            routes.pieces, routes.turned, routes.count.tolist(), strict=True
        )
    ]


def test_pieces_are_carried_on_in_their_order() -> None:
    plan = LanePlan(
        routes={
            1: [Leg(0, 0, 19, 0), Leg(1, 0, 19, 1)],
            4: [Leg(2, 0, 29, 1), Leg(0, 20, 39, 0)],
            7: [Leg(3, 0, 9, 0)],
        }
    )
    pieces = [
        Piece(0, 12, 22, 12, 22),  # more of it was robot 1's
        Piece(0, 23, 39, 23, 39),
        Piece(1, 0, 9, 0, 9),
        Piece(1, 10, 19, 10, 19),
        Piece(1, 20, 29, 20, 29),  # nobody's
        Piece(2, 0, 9, 0, 9),
        Piece(2, 15, 29, 15, 29),
        Piece(3, 0, 9, 0, 9),  # of a robot that is not here
    ]
    # A lane driven from its high end is carried on from its high end.
    assert stops(carried(plan, [1, 4], pieces)) == [
        [(0, 0), (3, 1), (2, 1)],
        [(6, 1), (5, 1), (1, 0)],
    ]
    assert stops(carried(plan, [4], pieces)) == [[(6, 1), (5, 1), (0, 0), (1, 0)]]
    assert stops(carried(LanePlan(), [0, 1], pieces)) == [[], []]


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_an_unchanged_plan_is_carried_on_unchanged(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pieces: list[Piece] = []
    for lane in range(4):
        low = 0
        for length in rng.integers(1, 9, int(rng.integers(0, 4))).tolist():
            low += int(rng.integers(0, 3))
            pieces.append(Piece(lane, low, low + length - 1, low, low + length - 1))
            low += length
    routes: dict[int, list[Leg]] = {0: [], 3: [], 5: []}
    expected: list[list[tuple[int, int]]] = [[], [], []]
    for number in rng.permutation(len(pieces)).tolist():
        robot, way = int(rng.integers(3)), int(rng.integers(2))
        piece = pieces[number]
        routes[(0, 3, 5)[robot]].append(Leg(piece.lane, piece.low, piece.high, way))
        expected[robot].append((number, way))
    assert stops(carried(LanePlan(routes=routes), [0, 3, 5], pieces)) == expected


# --- plans ------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [0, 1])
def test_the_first_plan_lays_lanes_along_the_longer_side(axis: int) -> None:
    cells = empty(60, 18)
    state = begun(cells if axis == 0 else np.ascontiguousarray(cells.T))
    plan = LanePlan()
    orders = planned(state, plan)
    assert plan.lanes is not None
    assert plan.lanes.axis == axis
    assert all(isinstance(order, Sweep) and order.axis == axis for order in orders)


@pytest.mark.parametrize("robots", [1, 3])
def test_routes_hold_every_piece_once(robots: int) -> None:
    state = begun(empty(50, 40), robots=robots)
    plan = LanePlan()
    orders = planned(state, plan)
    assert plan.lanes is not None
    assert list(plan.routes) == list(range(robots))
    legs = sorted(leg[:3] for route in plan.routes.values() for leg in route)
    assert len(set(legs)) == len(legs) >= 4 * robots
    # Together they hold what is to be seen, and only that.
    view = view_of(state)
    held = empty(50, 40)
    for lane, low, high in legs:
        strip = slice(plan.lanes.edges[lane], plan.lanes.edges[lane + 1])
        oriented = held if plan.lanes.axis == 0 else held.T
        oriented[low : high + 1, strip] += 1
    assert held.max() == 1
    assert held[view.belief.cells == UNKNOWN].all()
    # The order is the first leg.
    for robot, order in enumerate(orders):
        leg = plan.routes[robot][0]
        assert isinstance(order, Sweep)
        assert (order.across, order.low, order.high) == (plan.lanes.middle[leg.lane], *leg[1:3])
        assert order.end >= order.begin if not leg.turned else order.end <= order.begin


def test_lanes_stay_and_routes_go_on() -> None:
    state = begun(empty(50, 40), robots=2)
    plan = LanePlan()
    before = planned(state, plan)
    lanes = plan.lanes
    again = planned(state, plan)
    assert plan.lanes is lanes
    # Nothing has changed but that there was more time to think: nobody turns round.
    for one, two in zip(before, again, strict=True):
        assert isinstance(one, Sweep)
        assert isinstance(two, Sweep)
        assert (one.axis, one.across) == (two.axis, two.across)


def test_nothing_is_wanted_nothing_is_planned() -> None:
    state = begun(empty(7, 7), robots=1)
    view = view_of(state)
    plan = LanePlan(routes={0: [Leg(0, 0, 3, 0)]})
    plan.mask(view)[:] = 1
    assert planned(state, plan) == [None]
    assert plan.routes == {}
    assert plan.lanes is None
    # Less than a row of cells is no piece either.
    plan.mask(view)[0, :3] = 0
    assert planned(state, plan) == [None]


def test_pieces_given_up_are_not_planned_again() -> None:
    state = begun(empty(40, 40), robots=2)
    plan = LanePlan()
    view = view_of(state)
    for _ in range(5):
        if planned(state, plan) == [None, None]:
            break
        lanes = plan.lanes
        assert lanes is not None
        for lane, low, high, _ in [leg for route in plan.routes.values() for leg in route]:
            plan.give_up(Sweep(lanes.axis, int(lanes.middle[lane]), low, high, low, high), view)
    else:
        raise AssertionError("it plans for ever")
    wanted = wanted_cells(view.belief.cells, state.cells.tolist(), plan.mask(view))
    assert plan.lanes is not None
    lanes = plan.lanes
    assert not find_pieces(lanes, wanted, view.lattice, [[] for _ in lanes.middle], 1000)


def test_more_robots_than_there_is_to_do() -> None:
    state = begun(empty(12, 12), robots=6)
    orders = planned(state, LanePlan())
    assert len(orders) == 6
    view = view_of(state)
    unknown = int((view.belief.cells == UNKNOWN).sum())
    assert (unknown > 0) == any(order is not None for order in orders)


def test_what_is_left_behind_is_visited_once_no_sweep_will_see_it() -> None:
    state = begun(empty(40, 40), steps=30, robots=1)
    view = view_of(state)
    unknown = (view.belief.cells == UNKNOWN).astype(np.uint8)
    for axis in (0, 1):
        lanes = lay_lanes(axis, 4.0, view.lattice)
        assert _left_behind(lanes, view, state.cells, unknown) == []  # sweeps may see all of it
        tasks = find_tasks(view, state.cells)
        found = _left_behind(lanes, view, state.cells, np.zeros_like(unknown))
        assert len(found) == len(tasks) > 1  # there are no walls here
        for task, (where, order) in enumerate(found):
            assert order == Order(int(tasks.nearest[0, task]), int(tasks.looks_for[task]))
            assert where == (divmod(order.goal, 40) if axis == 0 else divmod(order.goal, 40)[::-1])
        # Those within 4 of what a sweep will see are left to it.
        row, col = divmod(found[0][1].goal, 40)
        near = np.zeros_like(unknown)
        near[max(row - 4, 0), col] = 1
        left = [order for _, order in _left_behind(lanes, view, state.cells, near)]
        for _, order in found:
            r, c = divmod(order.goal, 40)
            if order.looks_for < 0:
                close = max(abs(r - max(row - 4, 0)), abs(c - col)) <= 4
                assert (order in left) == (not close)


# --- whole runs -------------------------------------------------------------------------------


def field_with_posts() -> NDArray[np.uint8]:
    cells = empty(44, 50)
    rng = np.random.default_rng(3)
    for r, c in rng.integers(2, 41, (7, 2)).tolist():
        cells[r : r + 2, c : c + 3] = OCCUPIED
    return cells


def played(
    folder: Path, cells: NDArray[np.uint8], **options: Any
) -> tuple[ExplorationResult, ExplorationRun, list[Any]]:
    """A run that saw everything and was accepted, and the memories of its minds at the end."""
    last: list[list[Any]] = []
    path = folder / "run.mcap"
    with ExplorationWriter(path) as writer:
        result = run_exploration(
            problem_of(cells, max_time_s=4000.0, **options),
            LanesAndPockets(),
            name="lanes-and-pockets",
            writer=writer,
            progress=lambda state: last.append(state.memories),
        )
    run = read_run(path)
    report = verify_exploration(run)
    assert report.accepted, report.lines()
    assert result.status is Status.DONE
    assert result.metrics.coverage == 1.0
    return result, run, last[-1]


@pytest.mark.parametrize("robot", [0, 1, 2])
def test_a_robot_that_stalls_does_not_keep_the_others(robot: int, tmp_path: Path) -> None:
    """Whoever it is: the leader leads on. They need little longer than they would without it."""
    alone, _, _ = played(tmp_path, field_with_posts(), robots=2)
    faults = (f"robot_{robot}:stalls:20",)
    result, run, _ = played(tmp_path, field_with_posts(), robots=3, faults=faults)
    where = np.stack([step.cells for step in run.steps])
    assert (where[20:, robot] == where[20, robot]).all()
    assert result.metrics.time_s <= 1.25 * alone.metrics.time_s


@pytest.mark.parametrize("radio", ["perfect", 15.0])
def test_the_leader_dies(radio: str | float, tmp_path: Path) -> None:
    faults = ("robot_0:dies:60", "robot_1:dies:90")
    result, _, memories = played(tmp_path, field_with_posts(), robots=4, faults=faults, radio=radio)
    assert [event.robot for event in result.events] == ["robot_0", "robot_1"]
    assert all(isinstance(memory, LanesMemory) for memory in memories)
    # Each of them has led, and laid lanes of its own.
    for robot in (0, 1, 2):
        assert memories[robot].assignments > 0
        assert memories[robot].plan.lanes is not None
    if radio == "perfect":  # else what the dead knew may be lost
        alone, _, _ = played(tmp_path, field_with_posts(), robots=2)
        assert result.metrics.time_s <= 1.25 * alone.metrics.time_s


def test_a_robot_that_stalls_for_a_while_and_one_that_comes_late(tmp_path: Path) -> None:
    faults = ("robot_1:stalls:10:150", "robot_2:joins:40")
    result, _, _ = played(tmp_path, field_with_posts(), robots=3, faults=faults)
    assert len(result.events) == 3
    alone, _, _ = played(tmp_path, field_with_posts(), robots=1)
    assert result.metrics.time_s <= 0.75 * alone.metrics.time_s
