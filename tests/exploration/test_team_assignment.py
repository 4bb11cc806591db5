"""Who asks, who computes, who is told, and what a robot makes of it."""

import pickle
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import conav
from conav.exploration.belief import STOOD, TARGET
from conav.exploration.frontier_targets import Targets
from conav.exploration.greedy import assign_nearest_pairs
from conav.exploration.nearest import Nearest
from conav.exploration.team_assignment import Assign, Order, Request, TeamMemory, team_step
from conav.exploration.types import Action, TeamView
from conav.geometry.grid_search import SearchSpace, search
from conav.maps.ascii_art import ascii_starts, parse_ascii
from conav.maps.occupancy_grid import UNKNOWN
from conav.messages.message import HEADER_BYTES, Message
from conav.simulation.engine import StepEvents, engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import STILL_STEPS
from conav.simulation.world_state import WorldState, new_world

ROOMS = """
#####################
#.........#.........#
#.........#.........#
#...................#
#.........#.........#
#.abc.....#.........#
#####.#########.#####
#.........#.........#
#.........#.........#
#...................#
#.........#.........#
#####################
"""


def corridor(inside: str) -> str:
    wall = "#" * (len(inside) + 2)
    return f"{wall}\n#{inside}#\n{wall}"


class Call(NamedTuple):
    """An assignment that was computed."""

    step: int
    by: int
    robots: tuple[int, ...]
    positions: tuple[int, ...]
    goals: tuple[int, ...]


class Team:
    """A strategy with any rule of assignment, which notes what is computed."""

    def __init__(self, rule: Assign) -> None:
        self.rule = rule
        self.calls: list[Call] = []

    def start(self, view: TeamView, rng: np.random.Generator) -> TeamMemory:
        return TeamMemory()

    def step(
        self, memory: TeamMemory, view: TeamView, inbox: Sequence[Message], rng: np.random.Generator
    ) -> tuple[TeamMemory, Action, Sequence[Message]]:
        def assign(
            targets: Targets, view: TeamView, robots: Sequence[int], positions: np.ndarray
        ) -> np.ndarray:
            assert targets.costs.shape == (len(robots), len(targets.cells))
            goals = self.rule(targets, view, robots, positions)
            call = (tuple(robots), tuple(positions.tolist()), tuple(goals.tolist()))
            self.calls.append(Call(view.step, view.robot, *call))
            return goals

        return team_step(memory, view, inbox, assign)


def farthest(
    targets: Targets, view: TeamView, robots: Sequence[int], positions: np.ndarray
) -> np.ndarray:
    """As bad a rule as can be: everybody to the target farthest from itself."""
    costs = np.where(np.isfinite(targets.costs), targets.costs, -1.0)
    return targets.cells[costs.argmax(axis=1)]


def at_random(
    targets: Targets, view: TeamView, robots: Sequence[int], positions: np.ndarray
) -> np.ndarray:
    """Any targets, or none, whether or not they can be reached."""
    rng = np.random.default_rng([view.step, view.robot])
    return rng.choice(np.append(targets.cells, -1), len(robots))


def nobody(
    targets: Targets, view: TeamView, robots: Sequence[int], positions: np.ndarray
) -> np.ndarray:
    return np.full(len(robots), -1)


def world(strategy: Any, picture: str = ROOMS, **more: Any) -> WorldState:
    starts = [(c + 0.5, r + 0.5) for r, c in ascii_starts(picture).values()]
    settings = {"range_m": 3.0, "speed_mps": 1.0, "seed": 1} | more
    problem, _ = exploration_problem(
        parse_ascii(picture), robots=len(starts), starts=starts, **settings
    )
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    return new_world(problem, strategy, seen)


def walk(
    state: WorldState, steps: int, check: Callable[[StepEvents], None] | None = None
) -> list[StepEvents]:
    engine = engine_for(state)
    events = []
    for _ in range(steps):
        events.append(engine.sense_and_decide(state, []))
        if check is not None:
            check(events[-1])
        if state.covered[0] == state.n_observable or state.finished.all():
            break
        engine.move(state, events[-1].actions)
    return events


def requests(events: StepEvents) -> list[tuple[int, int]]:
    return [(m.sender, m.receiver) for m in events.said if isinstance(m.body, Request)]


def orders(events: StepEvents) -> dict[tuple[int, int], int]:
    found = {(m.sender, m.receiver): m.body.goal for m in events.said if isinstance(m.body, Order)}
    assert len(found) == sum(isinstance(m.body, Order) for m in events.said)
    return found


def test_at_first_all_ask_the_lowest_and_are_told() -> None:
    team = Team(assign_nearest_pairs)
    state = world(team)
    (first,) = walk(state, 1)
    assert requests(first) == [(1, 0), (2, 0)]
    assert len(team.calls) == 1
    call = team.calls[0]
    assert (call.by, call.robots) == (0, (0, 1, 2))
    assert call.positions == tuple(first.cells.tolist())
    assert orders(first) == {(0, 1): call.goals[1], (0, 2): call.goals[2]}
    assert len(first.said) == 4
    assert [action.goal for action in first.actions] == list(call.goals)
    assert len(set(call.goals)) == 3


def test_sizes_of_messages() -> None:
    state = world(Team(assign_nearest_pairs))
    (first,) = walk(state, 1)
    assert Request().size_bytes == 0
    assert Order(7).size_bytes == 4
    assert [message.size_bytes for message in first.said].count(HEADER_BYTES) == 2
    assert [message.size_bytes for message in first.said].count(HEADER_BYTES + 4) == 2
    # 3 x 2 reports, 2 requests, 2 orders.
    assert first.messages == 6 + 2 + 2


def test_the_lowest_computes_once_whenever_somebody_needs_a_target_and_tells_all() -> None:
    team = Team(assign_nearest_pairs)
    state = world(team, range_m=2.0)
    quiet = 0

    def check(events: StepEvents) -> None:
        nonlocal quiet
        calls = [call for call in team.calls if call.step == events.step]
        told = orders(events)
        assert all(receiver == 0 and sender > 0 for sender, receiver in requests(events))
        assert len(calls) <= 1
        if not calls:
            quiet += not requests(events)
            # Asked when there are no targets left, it tells them that there are none.
            assert set(told.values()) <= {-1}
            assert bool(told) >= bool(requests(events))
            return
        assert (calls[0].by, calls[0].robots) == (0, (0, 1, 2))
        assert told == {(0, robot): calls[0].goals[robot] for robot in (1, 2)}
        for action, goal in zip(events.actions, calls[0].goals, strict=True):
            if goal >= 0:
                assert action.goal == goal

    walk(state, 200, check)
    assert state.covered[0] == state.n_observable
    assert len(team.calls) > 4
    assert quiet > 0
    assert state.memories[0].assignments >= len(team.calls)
    assert [memory.assignments for memory in state.memories[1:]] == [0, 0]


def test_who_needs_no_target_does_not_ask() -> None:
    """A robot asks exactly when its goal is reached or resolved, or it was pushed."""
    state = world(Team(assign_nearest_pairs), range_m=1.0)
    goals: dict[int, int] = {}
    kept = 0

    def check(events: StepEvents) -> None:
        nonlocal kept
        asking = {sender for sender, _ in requests(events)}
        for robot in (1, 2):
            goal = goals.get(robot, -1)
            marks = state.beliefs[robot].marks.reshape(-1)
            # A goal that is a target needs no replacing; robots here are never pushed.
            if goal >= 0 and marks[goal] & TARGET:
                assert robot not in asking
                kept += 1
            elif goal >= 0 and marks[goal] & STOOD:
                assert robot in asking
        goals.update(enumerate(action.goal for action in events.actions))

    walk(state, 200, check)
    assert kept > 20


@pytest.mark.parametrize("rule", [assign_nearest_pairs, farthest, at_random])
@pytest.mark.parametrize("radio", ["perfect", 5.0, "off"])
def test_a_goal_that_has_become_worthless_is_replaced(rule: Assign, radio: str | float) -> None:
    state = world(Team(rule), radio=radio)
    driven = 0

    def check(events: StepEvents) -> None:
        nonlocal driven
        for robot, action in enumerate(events.actions):
            if action.finished:
                continue
            belief = state.beliefs[robot]
            drive = state.memories[robot].drive
            mark = int(belief.marks.reshape(-1)[action.goal])
            assert not mark & STOOD
            assert action.goal != events.cells[robot]
            if drive.looks_for >= 0:
                assert belief.cells.reshape(-1)[drive.looks_for] == UNKNOWN
            else:
                assert mark & TARGET or drive.beside
            driven += 1

    walk(state, 400, check)
    assert state.covered[0] == state.n_observable
    assert driven > 20


def test_a_goal_that_a_teammate_resolves_is_given_up_at_once() -> None:
    # Both are sent to the right end, a robot behind the other; when the first has seen it, the
    # second is sent to the left at once.
    picture = corridor(".......b...a............")

    def rightmost(
        targets: Targets, view: TeamView, robots: Sequence[int], positions: np.ndarray
    ) -> np.ndarray:
        return np.full(len(robots), targets.cells[-1])

    state = world(Team(rightmost), picture)
    seen = []

    def check(events: StepEvents) -> None:
        seen.append([action.goal % state.problem.plan.lattice.cols for action in events.actions])

    events = walk(state, 60, check)
    turned = next(i for i, goals in enumerate(seen) if goals[1] < 8)
    # Then the other has just seen the end, and nobody has stood there.
    assert max(goals[1] for goals in seen[:turned]) > 15
    assert 26 - 3 - 2 - 1 <= events[turned].cells[0] % state.problem.plan.lattice.cols < 25
    assert events[turned].cells[1] % state.problem.plan.lattice.cols < 20


def chain(rule: Assign, picture: str, radio: float = 6.0, **more: Any) -> tuple[Team, WorldState]:
    team = Team(rule)
    return team, world(team, picture, radio=radio, **more)


def apart(
    targets: Targets, view: TeamView, robots: Sequence[int], positions: np.ndarray
) -> np.ndarray:
    """Targets that tell who computed: the lowest for one, the highest for another."""
    return np.full(len(robots), targets.cells[0 if view.robot == 0 else -1])


def test_in_a_chain_the_middle_asks_one_and_orders_another() -> None:
    team, state = chain(apart, corridor("......a....b....c......"))
    (first,) = walk(state, 1)
    assert requests(first) == [(1, 0), (2, 1)]
    assert [(call.by, call.robots) for call in team.calls] == [(0, (0, 1)), (1, (0, 1, 2))]
    low, high = team.calls[0].goals[0], team.calls[1].goals[0]
    assert low != high
    # The middle tells who asked it, and neither the one it asked nor itself.
    assert orders(first) == {(0, 1): low, (1, 2): high}
    assert [action.goal for action in first.actions] == [low, low, high]


def test_in_a_chain_with_the_lowest_in_the_middle_it_orders_both() -> None:
    team, state = chain(apart, corridor("......b....a....c......"))
    (first,) = walk(state, 1)
    assert requests(first) == [(1, 0), (2, 0)]
    assert [(call.by, call.robots) for call in team.calls] == [(0, (0, 1, 2))]
    assert set(orders(first)) == {(0, 1), (0, 2)}


def test_in_a_chain_with_the_highest_in_the_middle_nobody_else_is_told() -> None:
    # The last asks the first only; the second hears no lower one and leads itself and the last.
    team, state = chain(apart, corridor("......a....c....b......"))
    (first,) = walk(state, 1)
    assert requests(first) == [(2, 0)]
    assert sorted((call.by, call.robots) for call in team.calls) == [(0, (0, 2)), (1, (1, 2))]
    assert set(orders(first)) == {(0, 2), (1, 2)}


def test_two_that_ask_at_once_are_answered_by_one_computation() -> None:
    # Robot 1 hears 0 and leads for 2 and 3, who do not.
    team, state = chain(apart, corridor("......a....b....c.d......"), 7.0)
    (first,) = walk(state, 1)
    assert requests(first) == [(1, 0), (2, 1), (3, 1)]
    assert [(call.by, call.robots) for call in team.calls] == [(0, (0, 1)), (1, (0, 1, 2, 3))]
    assert set(orders(first)) == {(0, 1), (1, 2), (1, 3)}


@pytest.mark.parametrize("radio", [4.0, 7.0])
def test_with_a_limited_radio_all_keep_to_the_protocol(radio: float) -> None:
    """Who hears whom follows from the places; asks, computations and orders follow from that."""
    team = Team(assign_nearest_pairs)
    big = conav.builtin_map("cave", width_m=14, height_m=14, seed=3)
    problem, _ = exploration_problem(big, robots=5, range_m=2.0, radio=radio, seed=3)
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, team, seen)
    shapes = set()

    def check(events: StepEvents) -> None:
        row, col = np.divmod(events.cells, problem.plan.lattice.cols)
        gap = np.hypot(row[:, None] - row, col[:, None] - col) * problem.plan.lattice.cell_m
        heard = gap <= radio + 1e-9
        near = [np.flatnonzero(line).tolist() for line in heard]
        asked = requests(events)
        told = orders(events)
        calls = {call.by: call for call in team.calls if call.step == events.step}
        assert len(calls) == sum(call.step == events.step for call in team.calls)
        for sender, receiver in asked:
            assert receiver == near[sender][0] < sender
            assert (receiver, sender) in told
        for robot, call in calls.items():
            assert list(call.robots) == near[robot]
            assert list(call.positions) == events.cells[near[robot]].tolist()
            receivers = {to for by, to in told if by == robot}
            if near[robot][0] == robot:
                assert receivers == set(near[robot]) - {robot}
            else:
                assert receivers == {by for by, to in asked if to == robot}
        for (sender, receiver), goal in told.items():
            if sender in calls:
                assert goal == calls[sender].goals[calls[sender].robots.index(receiver)]
            else:
                assert goal == -1
        shapes.update(tuple(line) for line in near)

    walk(state, 600, check)
    assert state.covered[0] == state.n_observable
    assert len(shapes) > 4


def test_without_radio_everybody_computes_for_itself() -> None:
    team = Team(assign_nearest_pairs)
    state = world(team, radio="off")

    def check(events: StepEvents) -> None:
        assert not events.said

    walk(state, 100, check)
    assert {call.by for call in team.calls} == {0, 1, 2}
    assert all(call.robots == (call.by,) for call in team.calls)


def trace(state: WorldState, steps: int) -> list[tuple[list[int], list[int]]]:
    events = walk(state, steps)
    return [(e.cells.tolist(), [action.goal for action in e.actions]) for e in events]


@pytest.mark.parametrize("radio", ["off", "perfect"])
def test_without_a_target_a_robot_goes_to_the_nearest(radio: str) -> None:
    picture = ROOMS if radio == "off" else ROOMS.replace("b", ".").replace("c", ".")
    # Pushed off its path, a robot of a team goes on to where it was going; `nearest` looks anew.
    options = {"radio": radio, "traffic": "none"}
    assert trace(world(Team(nobody), picture, **options), 400) == trace(
        world(Nearest(), picture, **options), 400
    )


def test_an_order_that_cannot_be_followed_means_the_nearest() -> None:
    def where_they_stand(
        targets: Targets, view: TeamView, robots: Sequence[int], positions: np.ndarray
    ) -> np.ndarray:
        return positions.astype(np.int64)

    def in_a_wall(
        targets: Targets, view: TeamView, robots: Sequence[int], positions: np.ndarray
    ) -> np.ndarray:
        return np.zeros(len(robots), np.int64)

    right = trace(world(Team(nobody)), 400)
    assert trace(world(Team(where_they_stand)), 400) == right
    assert trace(world(Team(in_a_wall)), 400) == right


def test_one_without_a_target_goes_to_its_own_nearest() -> None:
    def only_the_first(
        targets: Targets, view: TeamView, robots: Sequence[int], positions: np.ndarray
    ) -> np.ndarray:
        goals = np.full(len(robots), -1)
        goals[0] = targets.cells[-1]
        return goals

    state = world(Team(only_the_first))
    (first,) = walk(state, 1)
    belief = state.beliefs[0]
    space = SearchSpace(belief.moves.size)
    for robot in (1, 2):
        nearest = search(belief.moves, int(first.cells[robot]), belief.marks, TARGET, space)
        assert first.actions[robot].goal == nearest
    assert first.actions[0].goal == max(np.flatnonzero(belief.marks & TARGET))


@pytest.mark.parametrize("rule", [at_random, nobody, assign_nearest_pairs])
@pytest.mark.parametrize("name", ["office", "cave", "maze"])
def test_whatever_the_rule_the_team_finishes_as_nearest_does(name: str, rule: Assign) -> None:
    for robots, radio, seed in ((3, "perfect", 2), (4, 3.0, 3), (1, "off", 4)):
        grid = conav.builtin_map(name, width_m=8, height_m=8, seed=seed)
        more: dict[str, Any] = {
            "robots": robots,
            "radio": radio,
            "range_m": 1.5,
            "seed": seed,
            "max_time_s": 20_000.0,
        }
        assert conav.explore(grid, strategy=Nearest(), **more).status == "done"
        team = Team(rule)
        done = conav.explore(grid, strategy=team, **more)
        assert done.status == "done"
        # Nobody drives for ever: every computation follows something new or a place reached.
        assert len(team.calls) <= done.metrics.steps * robots
        assert done.metrics.steps < 20 * grid.cells.size**0.5 * 8


def test_robots_sent_across_each_other_in_a_door_get_on() -> None:
    grid = conav.builtin_map("office", width_m=8, height_m=8, seed=3)
    problem, _ = exploration_problem(grid, robots=4, radio=3.0, range_m=1.5, seed=3)
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, Team(farthest), seen)
    walk(state, 300)
    # All four are still in the room they began in; other rules need less for the whole map.
    assert state.covered[0] > state.n_observable / 2


def test_robots_that_block_each_other_do_not_go_round_for_ever() -> None:
    # A corridor one robot wide with robots sent across each other.
    picture = "#" * 22 + "\n#..a..b..........c.d.#\n" + "#" * 11 + "." + "#" * 10 + "\n" + "#" * 22

    def across(
        targets: Targets, view: TeamView, robots: Sequence[int], positions: np.ndarray
    ) -> np.ndarray:
        cols = view.lattice.cols
        left = positions % cols < cols // 2
        return np.where(left, targets.cells.max(), targets.cells.min())

    for radius in (0.1, 0.4):
        state = world(Team(across), picture, radius_m=radius, cell_m=1.0)
        walk(state, STILL_STEPS)
        assert state.covered[0] == state.n_observable


def test_what_cannot_be_seen_ends_in_finished_and_silence() -> None:
    """When nothing is left, nobody asks again and all say that they are finished."""
    state = world(Team(farthest))
    state.n_observable += 1  # as if there was something nobody can see
    events = walk(state, 600)
    assert state.covered[0] == state.n_observable - 1
    assert all(action.finished for action in events[-1].actions)
    assert not any(memory.drive.goal >= 0 for memory in state.memories)
    engine = engine_for(state)
    engine.move(state, events[-1].actions)
    assert not engine.sense_and_decide(state, []).said


@pytest.mark.parametrize("radio", ["perfect", 5.0])
def test_a_world_pickled_in_mid_drive_goes_on_as_it_would(radio: str | float) -> None:
    for steps in (1, 7, 23):
        state = world(Team(farthest), radio=radio)
        walk(state, steps)
        assert any(memory.drive.left > 1 for memory in state.memories)
        copy = pickle.loads(pickle.dumps(state))
        assert trace(copy, 60) == trace(state, 60)


def test_messages_are_counted_and_the_run_is_accepted(tmp_path: Path) -> None:
    grid = parse_ascii(ROOMS)
    out = tmp_path / "run.mcap"
    starts = [(2.5, 6.5), (3.5, 6.5), (4.5, 6.5)]
    done = conav.explore(
        grid, strategy=Team(at_random), robots=3, starts=starts, range_m=3.0, radio=5.0, out=out
    )
    assert done.status == "done"
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()
