"""Better response by one random sequence, after section 2.1.3 of [Philip2014]."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conav
from conav.errors import InputError
from conav.exploration.better_response import BetterResponse
from conav.exploration.types import Strategy
from conav.geometry.directions import DCOL, DROW, STAY
from conav.maps.ascii_art import ascii_starts, parse_ascii
from conav.simulation.engine import StepEvents, engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import WorldState, new_world
from conav.testing import check_strategy

E, N, W, S = range(4)
PAPER: dict[str, Any] = {
    "motion": "forward-turn",
    "sensor": "disc",
    "range_m": 2.0,
    "cell_m": 1.0,
    "speed_mps": 1.0,
    "traffic": "none",
}


def world(strategy: Strategy, picture: str, heading: int | None = None, **more: Any) -> WorldState:
    """Robots at the letters of the picture, all with that heading or, as drawn, at random."""
    starts = [(c + 0.5, r + 0.5) for r, c in ascii_starts(picture).values()]
    grid = parse_ascii(picture)
    problem, _ = exploration_problem(
        grid, robots=len(starts), starts=starts, **({"seed": 1} | PAPER | more)
    )
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, strategy, seen)
    if heading is not None:
        state.headings[:] = heading
    return state


def utilities(state: WorldState, seen: np.ndarray, row: int, col: int, heading: int) -> list[int]:
    """(7) less what is discovered already, for each sequence; -1 where it cannot be played."""
    walls = state.problem.plan.walls == 1
    y, x = np.indices(walls.shape)
    values = []
    for turn in range(4):
        k = (heading + turn) % 4
        near = np.zeros(walls.shape, bool)
        playable = True
        for count in (1, 2) if turn == 0 else (1,):
            r, c = row + count * DROW[k], col + count * DCOL[k]
            inside = 0 <= r < walls.shape[0] and 0 <= c < walls.shape[1]
            if not inside or (seen[r, c] and walls[r, c]):
                playable = playable and count == 2
                continue
            near |= (y - r) ** 2 + (x - c) ** 2 <= 4
        values.append(int((near & ~seen).sum()) if playable else -1)
    return values


def look(state: WorldState, seen: np.ndarray, events: StepEvents) -> None:
    y, x = np.indices(seen.shape)
    for cell in events.cells.tolist():
        r, c = divmod(cell, seen.shape[1])
        seen |= (y - r) ** 2 + (x - c) ** 2 <= 4


@pytest.mark.parametrize("epsilon", [0.2, 1.0])
def test_only_strictly_better_turns_are_played(epsilon: float) -> None:
    picture = "\n".join(
        ["." * 14] * 4 + ["...##........."] * 3 + ["." * 14] * 4 + ["abc..........."]
    )
    state = world(BetterResponse(epsilon=epsilon), picture, seed=4)
    seen = np.zeros(state.problem.plan.walls.shape, bool)
    engine = engine_for(state)
    turned = kept = obstacles = 0
    for _ in range(200):
        before = [(m.decisions, m.free_steps) if m else (0, 0) for m in state.memories]
        events = engine.sense_and_decide(state, [])
        look(state, seen, events)
        for robot, memory in enumerate(state.memories):
            row, col = divmod(int(events.cells[robot]), seen.shape[1])
            heading = int(events.headings[robot])
            played = (events.actions[robot].direction - heading) % 4
            values = utilities(state, seen, row, col, heading)
            if memory.decisions == before[robot][0]:
                assert played == 0
            elif values[0] < 0:
                # At an obstacle the best turn, as in Algorithm 2.
                assert played != 0
                assert values[played] == max(values)
                obstacles += 1
            elif played:
                assert values[played] > values[0]
                turned += 1
            else:
                kept += 1
        engine.move(state, events.actions)
    assert turned >= 3
    assert obstacles > 20
    assert kept > 20


def first_wishes(picture: str, heading: int, count: int, **more: Any) -> list[int]:
    """What a robot wants at its first choice, over that many seeds."""
    wishes = []
    for seed in range(count):
        state = world(BetterResponse(epsilon=1.0), picture, heading, seed=seed, **more)
        state.step = 1
        wishes.append(engine_for(state).sense_and_decide(state, []).actions[0].direction)
    return wishes


def test_one_sequence_is_drawn_evenly_and_played_if_better() -> None:
    # On to the east there is one new point, as in the south; in the north and back there are four.
    # One of the four sequences is drawn: north and back with a quarter each, else it goes on.
    wishes = first_wishes(".........\n" * 7 + ".......a.\n.........", E, 240)
    assert set(wishes) == {E, N, W}
    assert abs(wishes.count(N) - 60) < 5 * 6.8
    assert abs(wishes.count(W) - 60) < 5 * 6.8


def test_blocked_sequences_are_not_drawn() -> None:
    # In a corridor forward (two new points) and back (three) are left, half each.
    wishes = first_wishes("#######\n....a.#\n#######", E, 240)
    assert set(wishes) == {E, W}
    assert abs(wishes.count(W) - 120) < 5 * 7.8


def test_ties_change_nothing() -> None:
    # Nothing new anywhere: it goes straight, and at the border the turn is drawn.
    assert set(first_wishes(".....\n..a..\n.....", N, 40, range_m=9.0)) == {N}
    assert set(first_wishes(".....\n.....\n..a..", S, 40, range_m=9.0)) == {E, N, W}


def test_the_first_step_goes_forward_and_a_dead_end_turns_it_round() -> None:
    state = world(BetterResponse(epsilon=1.0), ".....\n..a..\n.....", S)
    engine = engine_for(state)
    assert engine.sense_and_decide(state, []).actions[0].direction == S
    assert state.memories[0].decisions == 0
    state = world(BetterResponse(epsilon=0.0), "#####\n#..a#\n#####", E)
    engine = engine_for(state)
    places = []
    for _ in range(3):
        events = engine.sense_and_decide(state, [])
        assert events.actions[0].direction == W
        places.append(int(events.cells[0]) % 5)
        engine.move(state, events.actions)
    assert places == [3, 3, 2]
    state = world(BetterResponse(epsilon=1.0), "###\n#a#\n###", E)
    assert engine_for(state).sense_and_decide(state, []).actions[0].direction == STAY


def test_without_exploring_it_turns_at_obstacles_only() -> None:
    state = world(BetterResponse(epsilon=0.0), "\n".join(["." * 9] * 8 + ["a........"]), E)
    engine = engine_for(state)
    turns = 0
    for _ in range(200):
        events = engine.sense_and_decide(state, [])
        heading = int(events.headings[0])
        ahead = state.beliefs[0].moves.item(int(events.cells[0])) >> heading & 1
        assert (events.actions[0].direction == heading) == bool(ahead)
        turns += not ahead
        engine.move(state, events.actions)
    assert state.memories[0].turns == state.memories[0].decisions == turns > 10


def test_drawn_once_per_sequence_it_decides_at_most_every_second_step() -> None:
    state = world(
        BetterResponse(epsilon=1.0, draw="sequence"),
        "\n".join(["." * 99] * 98 + ["a" + "." * 98]),
        N,
    )
    engine = engine_for(state)
    decided = []
    for _ in range(60):
        before = state.memories[0].decisions if state.memories[0] else 0
        events = engine.sense_and_decide(state, [])
        decided.append(state.memories[0].decisions > before)
        engine.move(state, events.actions)
    assert decided == [False, False] + [True, False] * 29


@pytest.mark.parametrize("settings", [{}, {"epsilon": 0.5, "draw": "sequence"}])
def test_finishes_and_is_accepted(settings: dict[str, Any], tmp_path: Path) -> None:
    grid = conav.builtin_map("three-obstacles", width_m=16, height_m=16, seed=2)
    out = tmp_path / "run.mcap"
    done = conav.explore(
        grid, strategy="better-response", settings=settings, seed=2, out=out, **PAPER
    )
    assert done.status == "done"
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()


def test_a_real_kind_of_map_is_accepted(tmp_path: Path) -> None:
    out = tmp_path / "run.mcap"
    conav.explore(
        "office",
        strategy="better-response",
        robots=3,
        seed=3,
        motion="forward-turn",
        cell_m=0.37,
        max_time_s=200.0,
        out=out,
    )
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()


def test_it_is_a_strategy_like_any_other() -> None:
    check_strategy(BetterResponse(epsilon=0.3), motion="forward-turn")


@pytest.mark.parametrize("settings", [{"epsilon": "2"}, {"epsilon": "often"}, {"draw": "never"}])
def test_settings_out_of_range_name_the_page(settings: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r"docs/strategies/better-response\.md"):
        conav.explore("maze", strategy="better-response", settings=settings)


def test_it_has_no_tie_rule() -> None:
    with pytest.raises(InputError, match="has no such setting"):
        conav.explore("maze", strategy="better-response", settings={"tie": "random"})
