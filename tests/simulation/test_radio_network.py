"""Who knows what after each step, against a naive twin that floods sets of scans."""

import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.exploration.belief import Belief, new_scratch
from conav.exploration.types import Action, ExplorationProblem, TeamView
from conav.geometry.sight import (
    lateral_limits,
    new_gap_space,
    sight_buffer_size,
    visible_cells,
)
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import UNKNOWN, OccupancyGrid
from conav.maps.planning_grid import planning_grid
from conav.messages.message import Message, report_bytes, scan_bytes
from conav.robots.radio import Radio
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.engine import Engine, StepEvents, engine_for
from conav.simulation.observable import observable_cells
from conav.simulation.radio_network import MAX_ROUNDS, links
from conav.simulation.world_state import WorldState, new_world


@dataclass(frozen=True)
class Sit:
    """Stays where it is."""

    def start(self, view: TeamView, rng: np.random.Generator) -> int:
        return 0

    def step(
        self, memory: int, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[int, Action, Sequence[Message]]:
        return memory, Action(), ()


def world(
    grid: OccupancyGrid,
    cells: Sequence[int],
    ranges: Sequence[float | None],
    *,
    sensor_range: float = 2.5,
    cell_m: float = 1.0,
) -> WorldState:
    plan = planning_grid(grid, cell_m=cell_m, radius_m=0.05)
    robots = tuple(
        Robot(
            f"robot_{i}",
            radius_m=0.05,
            sensor=Sensor("range", True, sensor_range),
            radio=Radio("any", reach),
        )
        for i, reach in enumerate(ranges)
    )
    problem = ExplorationProblem(plan, robots, tuple(int(cell) for cell in cells), 1, 1e6)
    return new_world(problem, Sit(), observable_cells(plan, problem.starts, robots[0].sensor))


def tick(engine: Engine, state: WorldState, following: Sequence[int] | None = None) -> StepEvents:
    """One step; then the robots are put elsewhere, as far as they please."""
    events = engine.sense_and_decide(state, [])
    if following is not None:
        put = np.array(following, np.int32)
        state.must_look[:] = put != state.cells
        state.cells[:] = put
    else:
        state.must_look[:] = False
    state.step += 1
    return events


def full_view(state: WorldState, cell: int) -> np.ndarray:
    """All fine cells in view of a planning cell."""
    plan = state.problem.plan
    lattice = plan.lattice
    row, col = divmod(cell, lattice.cols)
    limits = lateral_limits(state.problem.robots[0].sensor.range_m / lattice.resolution)
    out = np.zeros(sight_buffer_size(limits), np.int32)
    count = visible_cells(
        plan.walls,
        int(lattice.fine_row[row]),
        int(lattice.fine_col[col]),
        limits,
        new_gap_space(limits),
        new_gap_space(limits),
        out,
    )
    return np.unique(out[:count]).astype(np.int32)


class Flood:
    """Each robot's knowledge as a set of (origin, number of the scan)."""

    def __init__(self, state: WorldState) -> None:
        n = state.n_robots
        self.looked: list[list[int]] = [[] for _ in range(n)]  # cells, in order
        self.knows: list[set[tuple[int, int]]] = [set() for _ in range(n)]
        self.heard: dict[tuple[int, int], tuple[int, int]] = {}  # (i, j) -> cell, step
        self.views: dict[int, np.ndarray] = {}

    def step(self, state: WorldState, cells: np.ndarray, must_look: np.ndarray) -> None:
        """Robots look and tell each other; `cells` and `must_look` are those before the step."""
        n = state.n_robots
        for i in np.flatnonzero(must_look):
            self.knows[i].add((int(i), len(self.looked[i])))
            self.looked[i].append(int(cells[i]))
        reaches = [robot.radio.range_m for robot in state.problem.robots]
        lattice = state.problem.plan.lattice
        places = [lattice.position(int(cell)) for cell in cells]
        near = {
            (i, j)
            for i in range(n)
            for j in range(n)
            if i != j
            and all(
                reach is None or 0 < reach >= np.hypot(*np.subtract(places[i], places[j])) - 1e-9
                for reach in (reaches[i], reaches[j])
            )
        }
        for i, j in [*near, *((i, i) for i in range(n))]:
            self.heard[i, j] = (int(cells[j]), state.step - 1)
        for _ in range(MAX_ROUNDS):
            before = [set(known) for known in self.knows]
            for i, j in near:
                self.knows[i] |= before[j]

    def check(self, state: WorldState) -> None:
        n = state.n_robots
        plan = state.problem.plan
        for i in range(n):
            for j in range(n):
                held = sum(origin == j for origin, _ in self.knows[i])
                assert state.held[i, j] == held
                cell, step = self.heard.get((i, j), (-1, -1))
                assert (state.heard_cell[i, j], state.heard_step[i, j]) == (cell, step)
            belief = Belief(plan)
            scratch = new_scratch(plan)
            for origin, number in sorted(self.knows[i]):
                cell = self.looked[origin][number]
                if cell not in self.views:
                    self.views[cell] = full_view(state, cell)
                belief.hear(plan, cell, self.views[cell], scratch)
            assert content(state.beliefs[i]) == content(belief)
            for j in range(i):
                same = np.array_equal(state.held[i], state.held[j])
                assert (state.beliefs[i] is state.beliefs[j]) == same


def content(belief: Belief) -> tuple[Any, ...]:
    arrays = (belief.cells, belief.frontier, belief.frontier_count, belief.marks, belief.moves)
    return (*(array.tolist() for array in arrays), belief.opened, belief.known)


def random_world(
    rng: np.random.Generator, ranges: Sequence[float | None] | None
) -> WorldState | None:
    rows, cols = (int(rng.integers(2, 9)) for _ in range(2))
    walls = (rng.random((rows, cols)) < 0.2).astype(np.uint8)
    places = np.flatnonzero(walls == 0)
    if len(places) == 0:
        return None
    n = int(rng.integers(1, 7))
    if ranges is None:
        ranges = [float(rng.choice([0.0, 1.0, 1.5, 3.0]))] * n
    cells = rng.choice(places, n)
    return world(OccupancyGrid(walls, 1.0), cells, (list(ranges) * n)[:n])


def follow(rng: np.random.Generator, state: WorldState, steps: int) -> None:
    """Robots jump about, some staying; so groups split and merge in every way."""
    engine = engine_for(state)
    flood = Flood(state)
    places = np.flatnonzero(state.problem.plan.standable)
    for _ in range(steps):
        cells, must_look = state.cells.copy(), state.must_look.copy()
        stay = rng.random(state.n_robots) < 0.3
        following = np.where(stay, cells, rng.choice(places, state.n_robots))
        tick(engine, state, following)
        flood.step(state, cells, must_look)
        flood.check(state)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_limited_radio_equals_a_flood(seed: int) -> None:
    rng = np.random.default_rng(seed)
    state = random_world(rng, None)
    if state is not None:
        follow(rng, state, 8)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_teams_of_unlike_radios_equal_a_flood(seed: int) -> None:
    """A link takes both ends."""
    rng = np.random.default_rng(seed)
    state = random_world(rng, [None, 2.0, 3.0, 0.5, None])
    if state is not None:
        follow(rng, state, 6)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_perfect_radio_equals_one_shared_map(seed: int) -> None:
    rng = np.random.default_rng(seed)
    state = random_world(rng, [None])
    if state is None:
        return
    engine = engine_for(state)
    plan = state.problem.plan
    shared = np.zeros(plan.walls.size, bool)
    places = np.flatnonzero(plan.standable)
    for _ in range(6):
        for cell in state.cells[state.must_look]:
            shared[full_view(state, int(cell))] = True
        cells = state.cells.copy()
        tick(engine, state, rng.choice(places, state.n_robots))
        for robot in range(state.n_robots):
            expected = np.where(shared.reshape(plan.walls.shape), plan.walls, UNKNOWN)
            assert np.array_equal(state.beliefs[robot].cells, expected)
            assert np.array_equal(state.heard_cell[robot], cells)
            assert (state.heard_step[robot] == state.step - 1).all()
    assert len({id(belief) for belief in state.beliefs}) == 1


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_pickled_network_goes_on_alike(seed: int) -> None:
    """Who shares a belief with whom survives as well."""
    rng = np.random.default_rng(seed)
    state = random_world(rng, None)
    if state is None:
        return
    places = np.flatnonzero(state.problem.plan.standable)
    engine = engine_for(state)
    for _ in range(3):
        tick(engine, state, rng.choice(places, state.n_robots))
    other = pickle.loads(pickle.dumps(state))
    engines = (engine, engine_for(other))
    for _ in range(4):
        following = rng.choice(places, state.n_robots)
        for each, world_ in zip(engines, (state, other), strict=True):
            tick(each, world_, following)
        for one, two in zip(state.beliefs, other.beliefs, strict=True):
            assert content(one) == content(two)
        assert state.messages == other.messages
        assert state.bytes == other.bytes


CORRIDOR = parse_ascii("." * 50)


def line(*cols: int, reach: float | None, sensor_range: float = 1.0) -> WorldState:
    return world(CORRIDOR, cols, [reach] * len(cols), sensor_range=sensor_range)


def known(state: WorldState, robot: int) -> set[int]:
    return set(np.flatnonzero(state.beliefs[robot].cells != UNKNOWN).tolist())


def test_links_by_hand() -> None:
    state = line(0, 3, 5, 20, reach=3.0)
    assert links(state).tolist() == [
        [False, True, False, False],
        [True, False, True, False],
        [False, True, False, False],
        [False, False, False, False],
    ]
    assert links(line(0, 49, reach=None)).tolist() == [[False, True], [True, False]]


def test_links_count_metres_not_cells() -> None:
    grid = parse_ascii("." * 12, resolution=0.5)
    at_two_metres = world(grid, [0, 4], [2.0, 2.0], cell_m=0.5)
    assert links(at_two_metres)[0, 1]
    assert not links(world(grid, [0, 5], [2.0, 2.0], cell_m=0.5))[0, 1]
    assert not links(world(grid, [0, 4], [2.0, 1.5], cell_m=0.5)).any()


def test_out_of_reach_they_know_different_things() -> None:
    state = line(5, 15, reach=3.0)
    tick(engine_for(state), state)
    assert known(state, 0) == {4, 5, 6}
    assert known(state, 1) == {14, 15, 16}
    assert state.heard_cell.tolist() == [[5, -1], [-1, 15]]
    assert state.heard_step.tolist() == [[0, -1], [-1, 0]]


def test_news_is_relayed_within_the_step() -> None:
    state = line(5, 8, 11, 14, reach=3.0)
    tick(engine_for(state), state)
    for robot in range(4):
        assert known(state, robot) == {4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}
    assert len({id(belief) for belief in state.beliefs}) == 1
    # Where a robot stands is heard from itself only.
    assert state.heard_cell[0].tolist() == [5, 8, -1, -1]


def test_news_crosses_at_most_the_rounds_of_a_step() -> None:
    state = line(*range(40), reach=1.0, sensor_range=0.0)
    engine = engine_for(state)
    tick(engine, state)
    assert known(state, 0) == set(range(MAX_ROUNDS + 1))
    assert known(state, 39) == set(range(39 - MAX_ROUNDS, 40))
    tick(engine, state)
    assert known(state, 0) == set(range(40))


def test_a_messenger_carries_news_between_groups() -> None:
    state = line(0, 2, 40, reach=2.0)
    engine = engine_for(state)
    tick(engine, state, [0, 38, 40])
    assert state.beliefs[0] is state.beliefs[1]
    assert known(state, 2) == {39, 40, 41}
    tick(engine, state, [0, 20, 40])
    # The messenger has moved on; what it now learns does not leak back to robot 0.
    assert known(state, 0) == {0, 1, 2, 3}
    assert known(state, 1) == known(state, 2) == {0, 1, 2, 3, 37, 38, 39, 40, 41}
    assert state.beliefs[1] is state.beliefs[2]
    tick(engine, state, [0, 2, 40])
    assert known(state, 1) == {0, 1, 2, 3, 19, 20, 21, 37, 38, 39, 40, 41}
    assert known(state, 2) == {0, 1, 2, 3, 37, 38, 39, 40, 41}
    tick(engine, state, [0, 2, 40])
    assert known(state, 0) == known(state, 1)
    assert state.beliefs[0] is state.beliefs[1]
    assert state.heard_step[0].tolist() == [3, 3, -1]


def cost(events: StepEvents) -> tuple[int, int]:
    return events.messages, events.bytes


def sizes(events: StepEvents) -> list[int]:
    return [scan_bytes(len(scan.seen)) for scan in events.scans if scan is not None]


def test_sizes_by_hand() -> None:
    assert report_bytes(2) == 24 + 8 + 8
    assert report_bytes(10) == 24 + 8 + 40
    assert scan_bytes(0) == 8
    assert scan_bytes(100) == 408


def test_what_two_robots_send_over_a_perfect_radio() -> None:
    state = line(5, 15, reach=None)
    events = tick(engine_for(state), state)
    assert sizes(events) == [20, 20]  # three cells each
    assert cost(events) == (2, 2 * 40 + 20 + 20)
    assert cost(tick(engine_for(state), state)) == (2, 2 * 40)  # nobody has moved
    assert (state.messages, state.bytes) == (4, 200)


def test_what_three_robots_send_over_a_perfect_radio() -> None:
    state = line(5, 15, 25, reach=None)
    events = tick(engine_for(state), state)
    # Each report, with its scan, goes to two others; a report has 24 + 8 + 12 bytes.
    assert cost(events) == (6, 2 * (3 * 44 + 60))


def test_what_one_robot_alone_sends() -> None:
    for reach in (None, 3.0):
        assert cost(tick(engine_for(state := line(5, reach=reach)), state)) == (0, 0)
    state = line(5, 15, reach=3.0)
    assert cost(tick(engine_for(state), state)) == (0, 0)


def test_what_two_robots_send_over_a_limited_radio() -> None:
    state = line(5, 8, reach=3.0)
    engine = engine_for(state)
    events = tick(engine, state)
    # Two reports, then two answers with a scan each; nobody has anything left to tell.
    assert sizes(events) == [20, 20]
    assert cost(events) == (4, 4 * 40 + 40)
    assert sorted(events.told) == [(0, 1, 1, 1), (1, 0, 0, 1)]
    events = tick(engine, state)
    assert cost(events) == (2, 2 * 40)
    assert events.told == []


def test_what_three_robots_in_a_row_send() -> None:
    state = line(5, 8, 11, reach=3.0)
    events = tick(engine_for(state), state)
    # Four reports over two links; four answers: the middle gets two scans, the ends one each; the
    # middle reports to both ends that it has more, and sends the missing scan on. Twelve messages,
    # six scans of three cells.
    assert sizes(events) == [20, 20, 20]
    assert cost(events) == (12, 12 * 44 + 6 * 20)
    assert sorted(events.told) == [
        (0, 1, 1, 1),
        (0, 1, 2, 1),
        (1, 0, 0, 1),
        (1, 2, 2, 1),
        (2, 1, 0, 1),
        (2, 1, 1, 1),
    ]


def test_scans_missed_for_long_come_in_one_answer() -> None:
    state = line(5, 30, reach=3.0)
    engine = engine_for(state)
    for following in ([6, 30], [7, 30], [8, 10]):
        assert cost(tick(engine, state, following)) == (0, 0)
    events = tick(engine, state)
    # Robot 0 tells four scans: three cells, then one new cell each time; robot 1 two of three.
    assert cost(events) == (4, 4 * 40 + (20 + 12 + 12 + 12) + (20 + 20))
    assert sorted(events.told) == [(0, 1, 1, 2), (1, 0, 0, 4)]


@pytest.mark.parametrize("reach", [None, 100.0])
def test_all_in_reach_know_the_same_under_either_radio(reach: float | None) -> None:
    state = line(3, 20, 41, reach=reach)
    engine = engine_for(state)
    tick(engine, state, [4, 20, 41])
    tick(engine, state)
    assert known(state, 0) == known(state, 1) == known(state, 2)
    assert known(state, 0) == {2, 3, 4, 5, 19, 20, 21, 40, 41, 42}


# --- radios switched off ------------------------------------------------------------------------


@dataclass(frozen=True)
class Whisper:
    """Robots switch their radios off at times drawn in advance; each greets the others."""

    seed: int
    may_be_quiet: bool = True

    def start(self, view: TeamView, rng: np.random.Generator) -> np.ndarray:
        return np.random.default_rng([self.seed, view.robot]).random(100) < 0.4

    def step(
        self, memory: np.ndarray, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[np.ndarray, Action, Sequence[Message]]:
        said = []
        if not inbox:
            others = [robot for robot in range(len(view.heard_cell)) if robot != view.robot]
            said = [Message(view.robot, to, view.time_s, _Nothing()) for to in others]
        return memory, Action(quiet=bool(memory[view.step])), said


class _Nothing:
    size_bytes = 0


def whispering(seed: int, n: int, reach: float | None, strategy: Any) -> tuple[WorldState, Any]:
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid((rng.random((9, 9)) < 0.15).astype(np.uint8), 1.0)
    plan = planning_grid(grid, cell_m=1.0, radius_m=0.05)
    spots = np.flatnonzero(plan.standable)
    cells = rng.choice(spots, n, replace=False)
    state = world(grid, cells.tolist(), [reach] * n)
    state = new_world(state.problem, strategy, state.observable)
    return state, (rng, spots)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("reach", [None, 3.0])
def test_robots_whose_radio_is_off_neither_tell_nor_hear(seed: int, reach: float | None) -> None:
    n = 4
    state, (rng, spots) = whispering(seed, n, reach, Whisper(seed))
    engine = engine_for(state)
    knows: list[set[tuple[int, int]]] = [set() for _ in range(n)]
    looks = [0] * n
    off = np.zeros(n, dtype=bool)
    silent = 0
    heard = np.full((n, n), -1)
    for step in range(12):
        cells = state.cells.copy()
        for i in np.flatnonzero(state.must_look):
            knows[i].add((int(i), looks[i]))
            looks[i] += 1
        places = np.stack(np.divmod(cells, state.problem.plan.lattice.cols), axis=1)
        near = np.linalg.norm(places[:, None] - places[None], axis=2) <= (reach or 100)
        near &= ~off[:, None] & ~off[None, :] & ~np.eye(n, dtype=bool)
        assert np.array_equal(links(state), near)
        events = tick(engine, state, rng.choice(spots, n, replace=False).tolist())
        for _ in range(n):
            before = [set(known) for known in knows]
            for i, j in np.argwhere(near):
                knows[i] |= before[j]
        heard[near | np.eye(n, dtype=bool)] = step
        assert np.array_equal(state.heard_step, heard)
        assert state.held.tolist() == [
            [sum(origin == r for origin, _ in known) for r in range(n)] for known in knows
        ]
        for i in range(n):
            fresh = Belief(state.problem.plan)
            for r in range(n):
                for scan in state.scans[r][: state.held[i, r]]:
                    fresh.hear(state.problem.plan, scan.cell, scan.seen, engine.scratch)
            assert np.array_equal(fresh.cells, state.beliefs[i].cells)
        assert {message.sender for message in events.said} == set(np.flatnonzero(~off).tolist())
        off = np.array([action.quiet for action in events.actions])
        state.quiet[:] = off
        silent += int(off.sum())
    assert silent > 5


def test_a_strategy_says_in_advance_that_it_switches_radios_off() -> None:
    state, _ = whispering(0, 3, None, Whisper(0, may_be_quiet=False))
    engine = engine_for(state)
    state.step = int(np.flatnonzero(np.random.default_rng([0, 0]).random(100) < 0.4)[0])
    with pytest.raises(ValueError, match="may_be_quiet"):
        tick(engine, state)
