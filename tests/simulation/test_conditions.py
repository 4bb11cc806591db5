"""Robots that die, stall, join and run empty: what becomes of them, of the others, of the map."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import conav
from conav.exploration.hungarian import Hungarian
from conav.exploration.nearest import Nearest
from conav.exploration.types import Action, ExplorationProblem
from conav.maps.ascii_art import parse_ascii
from conav.simulation.conditions import ABSENT, ACTIVE, DEAD, STALLED
from conav.simulation.engine import Engine, engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.finish_bounds import finish_bounds
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import run_exploration
from conav.simulation.world_state import WorldState, new_world
from conav.status import Status

CORRIDOR = "." * 21
EAST, WEST, STAY = 0, 2, -1


class Script:
    """Robots make the moves they are told, one a step."""

    def __init__(self, *moves: str) -> None:
        self.moves = moves

    def start(self, view: Any, rng: Any) -> None:
        return None

    def step(self, memory: None, view: Any, inbox: Any, rng: Any) -> Any:
        moves = self.moves[view.robot]
        letter = moves[view.step] if view.step < len(moves) else "."
        return memory, Action({"E": EAST, "W": WEST, ".": STAY}[letter]), ()


def corridor(
    columns: list[int], strategy: Any, *faults: str, **options: Any
) -> tuple[Engine, WorldState]:
    """Robots in a corridor of cells of 1 m, one cell wide; a step is 1 s."""
    grid = parse_ascii(CORRIDOR, resolution=1.0)
    problem, _ = exploration_problem(
        grid,
        robots=len(columns),
        starts=[(column + 0.5, 0.5) for column in columns],
        cell_m=1.0,
        speed_mps=1.0,
        range_m=2.0,
        faults=faults,
        **options,
    )
    return world(problem, strategy)


def world(problem: ExplorationProblem, strategy: Any) -> tuple[Engine, WorldState]:
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, strategy, observable)
    return engine_for(state), state


def tick(engine: Engine, state: WorldState) -> Any:
    events = engine.sense_and_decide(state, [])
    engine.move(state, events.actions)
    return events


def test_others_drive_through_what_is_broken() -> None:
    engine, state = corridor(
        [4, 6, 8], Script("EEEEEEEE", "E" * 8, "E" * 8), "robot_1:stalls:0", "robot_2:dies:1"
    )
    for _ in range(8):
        tick(engine, state)
    assert state.cells.tolist() == [12, 6, 9]  # the dead one drove once
    assert state.condition.tolist() == [ACTIVE, STALLED, DEAD]


def test_in_order_they_could_not_pass() -> None:
    engine, state = corridor([4, 6], Script("EEEEEEEE", "........"), "robot_1:stalls:100")
    for _ in range(8):
        tick(engine, state)
    assert state.cells[0] < state.cells[1]  # it was pushed


def test_one_goes_on_when_its_place_is_free() -> None:
    """A stall ends while another stands there: it ends when that one has left."""
    engine, state = corridor([4, 6], Script("EE...E", "EEEEEEEE"), "robot_1:stalls:0:3")
    seen = [int(tick(engine, state).condition[1]) for _ in range(8)]
    assert seen == [STALLED] * 6 + [ACTIVE] * 2
    assert state.cells.tolist() == [9, 8]  # it pushes the one that passed it before it


def test_one_that_joins_waits_until_its_place_is_free() -> None:
    engine, state = corridor([4, 6], Script("EE..E...", "...EEEEE"), "robot_1:joins:3")
    conditions, looked = [], []
    for _ in range(8):
        events = tick(engine, state)
        conditions.append(int(events.condition[1]))
        looked.append(events.scans[1] is not None)
    assert conditions == [ABSENT] * 5 + [ACTIVE] * 3
    assert looked[:6] == [False] * 5 + [True]


def test_one_that_is_not_there_neither_hears_nor_is_heard() -> None:
    engine, state = corridor([4, 8], Script("....", "...."), "robot_1:joins:2")
    told = [tick(engine, state).told for _ in range(4)]
    assert told[0] == told[1] == []
    assert told[2] == [(0, 1, 1, 1), (1, 0, 0, 1)]
    assert state.heard_step.tolist() == [[3, 3], [3, 3]]
    assert state.started == [True, True]


def test_a_mind_that_joins_starts_then() -> None:
    engine, state = corridor([4, 8], Script("....", "...."), "robot_1:joins:2")
    tick(engine, state)
    assert state.started == [True, False]


def test_what_only_the_dead_knew_is_lost() -> None:
    engine, state = corridor([4, 16], Script("....", "...."), "robot_1:dies:1", radio=2.0)
    tick(engine, state)
    assert state.covered[0] == 10  # five cells each
    tick(engine, state)
    assert state.covered[0] == 5
    assert (state.sensed_by != 0).any(axis=0).sum() == 5
    state.cells[0] = 13
    state.must_look[0] = True
    tick(engine, state)
    assert state.covered[0] == 10


def test_what_the_dead_have_told_is_not() -> None:
    engine, state = corridor([4, 16], Script("....", "...."), "robot_1:dies:1")
    for _ in range(3):
        tick(engine, state)
    assert state.covered[0] == 10


def test_what_the_dead_have_sent_counts_when_it_arrives() -> None:
    engine, state = corridor([4, 16], Script(*[""] * 2), "robot_1:dies:1", delay_s=3.0)
    covered = []
    for _ in range(5):
        tick(engine, state)
        covered.append(int(state.covered[0]))
    assert covered == [10, 5, 5, 10, 10]


def test_batteries_run_down_by_time_and_by_distance() -> None:
    engine, state = corridor([4, 10], Script("EEEEEEEE", "........"))
    problem = replace(
        state.problem,
        robots=tuple(
            replace(robot, energy_j=60.0, drive_j_per_m=10.0, on_w=10.0)
            for robot in state.problem.robots
        ),
    )
    engine, state = world(problem, Script("EEEEEEEE", "........"))
    for _ in range(9):
        tick(engine, state)
    assert state.died_at.tolist() == [3, 6]  # 20 J a step and 10 J a step
    assert state.cells.tolist() == [7, 10]


def test_all_dead_is_stuck() -> None:
    done = conav.explore(
        "cave", robots=2, seed=1, faults=["robot_0:dies:3", "robot_1:dies:7"], range_m=2.0
    )
    assert done.status is Status.STUCK
    assert done.metrics.time_s == pytest.approx(7.2)  # the first step at or after 7 s
    names = [(event["robot"], event["event"]) for event in done.summary()["robot_events"]]
    assert names == [("robot_0", "died"), ("robot_1", "died")]


def test_a_team_waits_for_who_joins_late() -> None:
    """Robot 1 is alone in its half; robot 0 is done long before it comes."""
    grid = parse_ascii("....#....", resolution=1.0)
    done = conav.explore(
        grid,
        robots=2,
        starts=[(0.5, 0.5), (8.5, 0.5)],
        cell_m=1.0,
        speed_mps=1.0,
        range_m=1.0,
        faults=["robot_1:joins:5000"],
    )
    assert done.status is Status.DONE
    assert done.metrics.time_s > 5000
    without = conav.explore(
        grid,
        robots=2,
        starts=[(0.5, 0.5), (8.5, 0.5)],
        cell_m=1.0,
        speed_mps=1.0,
        range_m=1.0,
        faults=["robot_1:dies:0"],
    )
    assert without.status is Status.STUCK
    assert without.metrics.coverage == 0.5


def test_bounds_hold_in_teams_that_break() -> None:
    options: dict[str, Any] = {"robots": 3, "seed": 2, "range_m": 3.0}
    good, _ = exploration_problem("cave", **options)
    faults = ("robot_0:dies:30", "robot_1:stalls:10:60", "robot_2:joins:20")
    bad, _ = exploration_problem("cave", faults=faults, **options)
    bounds = finish_bounds(bad, (90,), effort="quick")[90]
    best = finish_bounds(good, (90,), effort="quick")[90]
    assert best.upper_s is not None
    assert bounds.lower_s <= best.upper_s
    assert bounds.upper_s is None or bounds.lower_s <= bounds.upper_s
    run = run_exploration(bad, Nearest(), name="nearest")
    assert run.metrics.t90_s is not None
    assert bounds.lower_s <= run.metrics.t90_s
    dead, _ = exploration_problem(
        "cave", faults=tuple(f"robot_{i}:dies:5" for i in range(3)), **options
    )
    assert finish_bounds(dead, (90,), effort="quick")[90].upper_s is None


def test_two_groups_out_of_reach_have_a_leader_each() -> None:
    """Each group's lowest robot assigns; when it dies, the next one does."""
    grid = parse_ascii("\n".join(["." * 40] * 5), resolution=1.0)
    problem, _ = exploration_problem(
        grid,
        robots=5,
        starts=[(0.5, 0.5), (1.5, 2.5), (38.5, 0.5), (38.5, 2.5), (38.5, 4.5)],
        cell_m=1.0,
        speed_mps=1.0,
        range_m=3.0,
        radio=8.0,
        faults=["robot_2:dies:3"],
    )
    engine, state = world(problem, Hungarian())
    for _ in range(3):
        tick(engine, state)
    leads = [memory.assigned >= 0 for memory in state.memories]
    assert leads == [True, False, True, False, False]
    for _ in range(4):
        tick(engine, state)
    assert [memory.assigned >= 3 for memory in state.memories[2:]] == [False, True, False]
    assert np.flatnonzero(state.in_touch[4]).tolist() == [3, 4]
