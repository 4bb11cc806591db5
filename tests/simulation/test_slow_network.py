"""Radios that are late or lose messages: by hand, and what holds whatever is lost."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import conav
from conav.exploration.belief import Belief
from conav.exploration.types import Action, ExplorationProblem, TeamView
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import planning_grid
from conav.messages.message import Message, report_bytes, scan_bytes
from conav.robots.radio import Radio
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.engine import Engine, StepEvents, engine_for
from conav.simulation.observable import observable_cells
from conav.simulation.slow_network import is_lost
from conav.simulation.world_state import WorldState, new_world


class Note:
    size_bytes = 3


@dataclass(frozen=True)
class Talk:
    """Every robot greets every other once a step and notes (step, sender) of all it hears."""

    def start(self, view: TeamView, rng: np.random.Generator) -> dict[str, Any]:
        return {"step": -1, "heard": []}

    def step(
        self,
        memory: dict[str, Any],
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[dict[str, Any], Action, Sequence[Message]]:
        memory["heard"] += [(view.step, m.sender, m.sent_at_s) for m in inbox]
        if memory["step"] == view.step:
            return memory, Action(), ()
        memory["step"] = view.step
        others = [robot for robot in range(len(view.heard_cell)) if robot != view.robot]
        return memory, Action(), [Message(view.robot, to, view.time_s, Note()) for to in others]


def line(cells: Sequence[int], **radio: Any) -> WorldState:
    """Robots with a view of one cell to each side on a row of 30 cells of 1 m; a step is 1 s."""
    grid = OccupancyGrid(np.zeros((1, 30), np.uint8), 1.0)
    plan = planning_grid(grid, cell_m=1.0, radius_m=0.05)
    link = Radio(**({"name": "any", "range_m": None} | radio))
    robots = tuple(
        Robot(
            f"robot_{i}",
            radius_m=0.05,
            speed_mps=1.0,
            sensor=Sensor("range", True, 1.0),
            radio=link,
        )
        for i in range(len(cells))
    )
    problem = ExplorationProblem(plan, robots, tuple(cells), 1, 1e6)
    return new_world(problem, Talk(), observable_cells(plan, problem.starts, robots[0].sensor))


def tick(engine: Engine, state: WorldState, following: Sequence[int] | None = None) -> StepEvents:
    events = engine.sense_and_decide(state, [])
    put = state.cells if following is None else np.array(following, np.int32)
    state.must_look[:] = put != state.cells
    state.cells[:] = put
    state.step += 1
    return events


def test_everything_comes_two_steps_late() -> None:
    state = line((5, 15), delay_s=1.2)
    assert state.problem.delay_steps == 2
    engine = engine_for(state)
    first = tick(engine, state)
    assert (first.told, state.heard_step.tolist()) == ([], [[0, -1], [-1, 0]])
    assert state.in_touch.tolist() == [[True, False], [False, True]]
    # A report each way with the sender's new scan of three cells, and a greeting.
    assert (first.messages, first.bytes) == (4, 2 * (report_bytes(2) + scan_bytes(3)) + 2 * 27)
    second = tick(engine, state, (6, 15))
    assert second.told == []
    assert second.bytes == 2 * report_bytes(2) + 2 * 27
    third = tick(engine, state)
    assert third.told == [(1, 0, 0, 1), (0, 1, 1, 1)]
    assert state.heard_step.tolist() == [[2, 0], [0, 2]]
    assert state.heard_cell.tolist() == [[6, 15], [5, 15]]
    assert state.in_touch.all()
    assert state.held.tolist() == [[2, 1], [1, 1]]
    assert state.memories[0]["heard"] == [(2, 1, 0.0)]
    tick(engine, state)
    assert tick(engine, state).told == [(1, 0, 0, 2)]
    assert state.memories[1]["heard"] == [(2, 0, 0.0), (3, 0, 1.0), (4, 0, 2.0)]


def test_what_lies_farther_is_asked_for() -> None:
    """0 - 1 - 2: with a delay of 1, scans go over two links in report, request and answer."""
    state = line((5, 8, 11), range_m=3.0, delay_s=1.0)
    engine = engine_for(state)
    told = [tick(engine, state).told for _ in range(6)]
    # Sent at 0, there at 1; robot 0 hears at 2 of what 1 then held, asks, and is answered at 4.
    assert told[1] == [(1, 0, 0, 1), (0, 1, 1, 1), (2, 1, 1, 1), (1, 2, 2, 1)]
    assert told[4] == [(0, 1, 2, 1), (2, 1, 0, 1)]
    assert told[0] == told[2] == told[3] == told[5] == []
    assert (state.held == 1).all()
    assert not state.in_touch[0, 2]
    assert state.heard_step[0].tolist() == [5, 4, -1]


def test_out_of_reach_at_sending_or_silent_on_arrival() -> None:
    state = line((5, 7), range_m=3.0, delay_s=2.0)
    engine = engine_for(state)
    tick(engine, state, (5, 20))
    assert tick(engine, state).messages == 2  # of minds, in vain
    state.quiet[1] = True  # when what was sent at step 0 arrives
    assert tick(engine, state).told == [(0, 1, 1, 1)]
    state.quiet[1] = False
    assert tick(engine, state).told == []
    assert state.heard_step.tolist() == [[3, 0], [-1, 3]]
    assert state.memories[0]["heard"] == [(2, 1, 0.0)]
    assert state.memories[1]["heard"] == []


def test_lost_with_the_chance_asked_for_and_independently() -> None:
    for chance in (0.1, 0.5, 0.9):
        draws = [
            is_lost(7, chance, step, 0, a, b, kind)
            for step in range(60)
            for a in range(8)
            for b in range(8)
            for kind in range(3)
        ]
        share = sum(draws) / len(draws)
        deviation = (chance * (1 - chance) / len(draws)) ** 0.5
        assert abs(share - chance) < 4 * deviation
        lagged = sum(a and b for a, b in pairwise(draws)) / (len(draws) - 1)
        assert abs(lagged - chance**2) < 6 * deviation
    assert not any(is_lost(1, 0.0, k, 0, 1, 2, 0) for k in range(1000))
    # Each argument matters.
    base = (3, 5, 0, 1, 2, 0)
    for place in range(len(base)):
        other = [
            is_lost(*_with(base, place, value)[:1], 0.5, *_with(base, place, value)[1:])
            for value in range(40)
        ]
        assert 5 < sum(other) < 35


def _with(numbers: tuple[int, ...], place: int, value: int) -> tuple[int, ...]:
    return (*numbers[:place], value, *numbers[place + 1 :])


@pytest.mark.parametrize("delay_s", [0.0, 1.0, 3.0])
@pytest.mark.parametrize("seed", range(4))
def test_whatever_is_lost_beliefs_are_what_the_held_scans_make(delay_s: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    state = line((3, 8, 20, 27), range_m=9.0, loss=0.4, delay_s=delay_s)
    engine = engine_for(state)
    previous = state.held.copy()
    for _ in range(60):
        tick(engine, state, rng.choice(30, 4, replace=False).tolist())
        held = state.held
        assert (held >= previous).all()
        assert (held <= held.diagonal()[None, :]).all()
        previous = held.copy()
        for i in range(4):
            fresh = Belief(state.problem.plan)
            for origin in range(4):
                for scan in state.scans[origin][: held[i, origin]]:
                    fresh.hear(state.problem.plan, scan.cell, scan.seen, engine.scratch)
            assert np.array_equal(fresh.cells, state.beliefs[i].cells)
    for _ in range(60):  # and when they stand near each other everybody gets to know everything
        tick(engine, state, (10, 12, 14, 16))
    assert (state.held == state.held.diagonal()[None, :]).all()


def test_silence_by_loss_alone_does_not_break_touch() -> None:
    problem = line((5, 6), loss=0.2).problem
    assert problem.patience_steps == 4  # all of five running are lost once in three thousand
    assert replace(problem, robots=line((5, 6)).problem.robots).patience_steps == 0
    state = line((5, 6), loss=0.2)
    engine = engine_for(state)
    touched = []
    for _ in range(300):
        tick(engine, state)
        touched.append(bool(state.in_touch[0, 1]))
    assert sum(touched) > 297
    tick(engine, state)
    state.quiet[1] = True
    for _ in range(7):
        tick(engine, state)
    assert not state.in_touch[0, 1]


def test_loss_draws_from_nobodys_generator() -> None:
    """What is lost depends on nothing else: starts and strategies draw the same with it."""
    for loss in (0.0, 0.3):
        state = line((5, 6), loss=loss)
        engine = engine_for(state)
        for _ in range(10):
            tick(engine, state)
        bits = [generator.bit_generator.state["state"] for generator in state.generators]
        if loss == 0.0:
            expected = bits
    assert bits == expected


def test_the_same_run_again() -> None:
    runs = [
        conav.explore("cave", robots=3, seed=2, radio=4.0, loss=0.3, delay_s=1.0, max_time_s=100.0)
        for _ in range(2)
    ]
    assert runs[0].metrics == runs[1].metrics
