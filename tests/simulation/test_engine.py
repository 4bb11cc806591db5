"""One step of the world, and what holds after every step."""

import pickle
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import pytest

from conav.exploration.nearest import Nearest
from conav.exploration.types import Action, Strategy, TeamView
from conav.geometry.directions import STAY
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN
from conav.messages.message import HEADER_BYTES, Message
from conav.simulation.engine import StepEvents, engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.radio_network import MAX_ROUNDS
from conav.simulation.world_state import WorldState, generator_for, new_world

ROOMS = """
###########################
#..........#......#.......#
#..........#......#.......#
#..........#..............#
#.................#.......#
#..........#......#####.###
#..........#......#.......#
#####.######......#.......#
#.................#.......#
#..........#..............#
#..........#......#.......#
###########################
"""
ROOM = "########\n" + "#......#\n" * 4 + "########"


def world(strategy: Strategy, picture: str = ROOM, **problem: Any) -> WorldState:
    settings: dict[str, Any] = {"robots": 3, "range_m": 3.0, "speed_mps": 1.0, "seed": 1}
    given, _ = exploration_problem(parse_ascii(picture), **(settings | problem))
    observable = observable_cells(given.plan, given.starts, given.robots[0].sensor)
    return new_world(given, strategy, observable)


def tick(state: WorldState) -> StepEvents:
    """One whole step with an engine of its own: engines hold nothing of a run."""
    engine = engine_for(state)
    events = engine.sense_and_decide(state, [])
    engine.move(state, events.actions)
    return events


def plain(events: StepEvents) -> tuple[Any, ...]:
    """Events that can be compared."""
    return (
        events.step,
        events.cells.tolist(),
        events.headings.tolist(),
        [scan and (scan.cell, scan.seen.tolist()) for scan in events.scans],
        [tuple(map(int, told)) for told in events.told],
        [tuple(action) for action in events.actions],
        events.messages,
        events.bytes,
    )


VARIANTS = [
    {"radio": "perfect"},
    {"radio": 4.0},
    {"radio": 4.0, "motion": "4-connected"},
    {"radio": 2.0, "motion": "forward-turn", "robots": 5},
    {"radio": 6.0, "sensor": "disc", "robots": 8},
]


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_same_seed_gives_the_same_steps(variant: dict[str, Any]) -> None:
    one, other = (world(Nearest(), ROOMS, **variant) for _ in range(2))
    for _ in range(40):
        assert plain(tick(one)) == plain(tick(other))


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_pickled_world_goes_on_alike(variant: dict[str, Any]) -> None:
    state = world(Nearest(), ROOMS, **variant)
    for number in range(45):
        if number % 15 == 7:
            copy = pickle.loads(pickle.dumps(state))
            kept = pickle.dumps(copy)
        events = tick(state)
        if number >= 7:
            assert plain(tick(copy)) == plain(events)
    # Stepping the one did not reach into the other.
    late = pickle.loads(kept)
    for _ in range(8):
        tick(late)
    assert late.cells.tolist() == state.cells.tolist()
    assert late.bytes == state.bytes
    assert [belief.known for belief in late.beliefs] == [belief.known for belief in state.beliefs]


@pytest.mark.parametrize("variant", VARIANTS)
def test_what_holds_after_every_step(variant: dict[str, Any]) -> None:
    state = world(Nearest(), ROOMS, **variant)
    plan = state.problem.plan
    engine = engine_for(state)
    covered = 0
    seen = np.zeros(plan.walls.size, bool)
    discovered = np.zeros(state.n_robots, int)
    own: list[set[int]] = [set() for _ in range(state.n_robots)]
    wanted = state.observable.reshape(-1) == 1
    for _ in range(60):
        believed = [belief.cells.copy() for belief in state.beliefs]
        events = engine.sense_and_decide(state, [])
        for robot, scan in enumerate(events.scans):
            if scan is None:
                continue
            # Everything reported was unknown to the robot before.
            assert (believed[robot].reshape(-1)[scan.seen] == UNKNOWN).all()
            assert len(set(scan.seen.tolist())) == len(scan.seen)
            assert scan.cell == state.cells[robot]
            seen[scan.seen] = True
            discovered[robot] += np.count_nonzero(wanted[scan.seen])
            own[robot] |= set(scan.seen.tolist())
        assert state.covered[0] == np.count_nonzero(seen & wanted)
        assert state.covered[0] >= covered
        covered = int(state.covered[0])
        assert np.array_equal(state.discovered, discovered)
        for robot, belief in enumerate(state.beliefs):
            known = belief.cells != UNKNOWN
            assert np.array_equal(belief.cells[known], plan.walls[known])
            assert (believed[robot][believed[robot] != UNKNOWN] != UNKNOWN).all()
            assert not (known & (believed[robot] == UNKNOWN) & ~seen.reshape(known.shape)).any()
            # What it saw itself counts at least once, and no more than the team has seen.
            mine = np.count_nonzero(wanted[sorted(own[robot])])
            assert mine <= state.sensed[robot] <= covered
            # Nobody is taken for a wall, and everybody knows the ground underfoot.
            row, col = divmod(int(state.cells[robot]), plan.lattice.cols)
            fine = plan.lattice.fine_row[row], plan.lattice.fine_col[col]
            assert belief.cells[fine] == FREE
            for cell in state.cells:
                row, col = divmod(int(cell), plan.lattice.cols)
                fine = plan.lattice.fine_row[row], plan.lattice.fine_col[col]
                assert belief.cells[fine] != OCCUPIED
            assert not belief.moves.reshape(-1)[cell] & ~plan.moves.reshape(-1)[cell]
        moved = engine.move(state, events.actions)
        assert moved == np.count_nonzero(state.cells != events.cells)


def test_seeds_differ() -> None:
    runs = set()
    for seed in range(6):
        state = world(Nearest(), ROOMS, seed=seed)
        runs.add(tuple(tuple(tick(state).cells.tolist()) for _ in range(10)))
    assert len(runs) == 6


def test_generators_follow_from_seed_and_name() -> None:
    draws = {
        (seed, name): generator_for(seed, name).random()
        for seed in (0, 1, 256)
        for name in ("robot_0", "robot_1", "starts")
    }
    assert len(set(draws.values())) == 9
    assert generator_for(1, "robot_0").random() == draws[1, "robot_0"]


def test_a_robot_that_has_not_moved_does_not_look_again() -> None:
    state = world(Script(), starts=[(1.5, 1.5), (3.5, 1.5)], robots=2)
    assert [scan is not None for scan in tick(state).scans] == [True, True]
    assert [scan is not None for scan in tick(state).scans] == [False, False]
    state.strategy = Script(moves=(0, 0, 0))
    tick(state)
    assert [scan is not None for scan in tick(state).scans] == [True, True]


class Note(NamedTuple):
    """A message body of a given size."""

    text: str
    size_bytes: int = 10


@dataclass(frozen=True)
class Script:
    """Moves in these directions, then stays."""

    moves: tuple[int, ...] = ()

    def start(self, view: TeamView, rng: np.random.Generator) -> int:
        return 0

    def step(
        self, memory: int, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[int, Action, Sequence[Message]]:
        direction = self.moves[memory] if memory < len(self.moves) else STAY
        return memory + 1, Action(direction), ()


@dataclass(frozen=True)
class PingPong:
    """Robot 0 begins in step `begin`; 0 and 1 answer each other until `last`."""

    last: int
    begin: int = 0

    def start(self, view: TeamView, rng: np.random.Generator) -> list[tuple[int, int]]:
        return []  # (step, number) of everything heard

    def step(
        self,
        memory: list[tuple[int, int]],
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[list[tuple[int, int]], Action, Sequence[Message]]:
        out = []
        if view.robot == 0 and view.step == self.begin and not memory and not inbox:
            out.append(Message(0, 1, view.time_s, Note("0")))
        for message in inbox:
            number = int(message.body.text)  # type: ignore[attr-defined]
            memory.append((view.step, number))
            assert message.sender == 1 - view.robot
            if number < self.last:
                body = Note(str(number + 1))
                out.append(Message(view.robot, message.sender, view.time_s, body))
        return memory, Action(), out


def test_messages_arrive_within_the_step() -> None:
    state = world(PingPong(last=9))
    events = tick(state)
    assert state.memories[0] == [(0, k) for k in (1, 3, 5, 7, 9)]
    assert state.memories[1] == [(0, k) for k in (0, 2, 4, 6, 8)]
    assert state.memories[2] == []
    quiet = world(Script())
    without = tick(quiet)
    assert events.messages == without.messages + 10
    assert events.bytes == without.bytes + 10 * (HEADER_BYTES + 10)
    assert (state.messages, state.bytes) == (events.messages, events.bytes)
    assert tick(state).messages == tick(quiet).messages


def test_after_thirty_two_rounds_the_rest_waits_for_the_next_step() -> None:
    state = world(PingPong(last=40, begin=1))
    tick(state)
    tick(state)
    heard = sorted([*state.memories[0], *state.memories[1]], key=lambda item: item[1])
    # Round r delivers message r - 2; the one sent in the last round is under way.
    assert heard == [(1, number) for number in range(MAX_ROUNDS - 1)]
    assert [message.body.text for _, message in state.in_flight] == [str(MAX_ROUNDS - 1)]
    state = pickle.loads(pickle.dumps(state))
    tick(state)
    heard = sorted([*state.memories[0], *state.memories[1]], key=lambda item: item[1])
    assert [step for step, _ in heard] == [1] * (MAX_ROUNDS - 1) + [2] * (42 - MAX_ROUNDS)
    assert [number for _, number in heard] == list(range(41))
    assert state.in_flight == []


@dataclass(frozen=True)
class Shout:
    """Tells every teammate its number, once a step, and notes whom it heard."""

    def start(self, view: TeamView, rng: np.random.Generator) -> dict[str, Any]:
        return {"step": -1, "heard": []}

    def step(
        self,
        memory: dict[str, Any],
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[dict[str, Any], Action, Sequence[Message]]:
        memory["heard"].append([message.sender for message in inbox])
        if memory["step"] == view.step:
            return memory, Action(0), ()
        memory["step"] = view.step
        others = [robot for robot in range(len(view.heard_cell)) if robot != view.robot]
        said = [Message(view.robot, to, view.time_s, Note("hello")) for to in others]
        return memory, Action(1), said


def test_inboxes_are_in_order_and_the_last_action_counts() -> None:
    state = world(Shout())
    events = tick(state)
    assert [memory["heard"] for memory in state.memories] == [
        [[], [1, 2]],
        [[], [0, 2]],
        [[], [0, 1]],
    ]
    assert [action.direction for action in events.actions] == [0, 0, 0]


CORRIDOR = "#" * 30 + "\n#" + "." * 28 + "#\n" + "#" * 30


def test_messages_go_only_to_robots_in_reach() -> None:
    starts = [(1.5, 1.5), (3.5, 1.5), (20.5, 1.5)]
    state = world(Shout(), CORRIDOR, starts=starts, radio=3.0)
    tick(state)
    heard = [sorted({i for inbox in memory["heard"] for i in inbox}) for memory in state.memories]
    assert heard == [[1], [0], []]


@dataclass(frozen=True)
class Forgetful:
    """Remembers nothing at all."""

    calls: list[int] = field(default_factory=list)

    def start(self, view: TeamView, rng: np.random.Generator) -> None:
        self.calls.append(view.robot)
        return

    def step(
        self, memory: None, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[None, Action, Sequence[Message]]:
        return None, Action(), ()


def test_each_mind_is_started_once() -> None:
    """Also one that has nothing to remember."""
    strategy = Forgetful()
    state = world(strategy)
    for _ in range(3):
        tick(state)
    assert strategy.calls == [0, 1, 2]


@dataclass(frozen=True)
class Look:
    """Notes its view."""

    def start(self, view: TeamView, rng: np.random.Generator) -> list[TeamView]:
        return []

    def step(
        self, memory: list[Any], view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[list[Any], Action, Sequence[Message]]:
        arrays = {"heard_cell": view.heard_cell.copy(), "heard_step": view.heard_step.copy()}
        memory.append(view._replace(**arrays))
        return memory, Action(0), ()


def test_what_a_mind_is_shown() -> None:
    state = world(
        Look(), CORRIDOR, robots=2, starts=[(1.5, 1.5), (5.5, 1.5)], radio=4.0, speed_mps=0.5
    )
    for _ in range(3):
        tick(state)
    views = state.memories[0]
    assert [view.step for view in views] == [0, 1, 2]
    assert [view.time_s for view in views] == [0.0, 2.0, 4.0]
    assert {view.robot for view in views} == {0}
    assert {view.body.name for view in views} == {"robot_0"}
    assert [view.cell for view in views] == [31, 32, 33]
    assert [view.heading for view in views][1:] == [0, 0]
    assert [view.heard_cell.tolist() for view in views] == [[31, 35], [32, 36], [33, 37]]
    assert [view.heard_step.tolist() for view in views] == [[0, 0], [1, 1], [2, 2]]


@pytest.mark.parametrize("name", ["heard_cell", "heard_step"])
def test_the_arrays_of_a_view_are_locked(name: str) -> None:
    """Else a mind could write where it and others were heard into the world."""

    class Forger(Script):
        def step(self, memory: int, view: TeamView, *rest: Any) -> Any:
            with pytest.raises(ValueError, match="read-only"):
                getattr(view, name)[0] = 7
            return memory, Action(), ()

    tick(world(Forger()))


def test_slower_robots_in_one_team() -> None:
    state = world(Script(moves=(0,) * 12), CORRIDOR, robots=2, starts=[(1.5, 1.5), (9.5, 1.5)])
    slow = state.problem.robots[1].__class__(
        "slow", radius_m=0.1, speed_mps=0.25, sensor=state.problem.robots[1].sensor
    )
    problem = state.problem.__class__(
        state.problem.plan,
        (state.problem.robots[0], slow),
        state.problem.starts,
        1,
        1e6,
    )
    assert problem.step_s == 1.0
    assert problem.rates.tolist() == [1.0, 0.25]
    state = new_world(problem, Script(moves=(0,) * 12), state.observable)
    for _ in range(8):
        tick(state)
    assert (state.cells - np.array(problem.starts)).tolist() == [8, 2]
