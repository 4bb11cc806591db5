"""Algorithm 1 of [Philip2014]: like Algorithm 2, but blind to obstacles until it may choose."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import conav
from conav.errors import InputError
from conav.exploration.potential_1 import Potential1
from conav.exploration.types import Strategy
from conav.geometry.directions import STAY
from conav.maps.ascii_art import ascii_starts, parse_ascii
from conav.simulation.engine import engine_for
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
FIELD = "\n".join(["." * 15] * 7 + ["." * 7 + "a" + "." * 7] + ["." * 15] * 7)


def world(strategy: Strategy, picture: str, heading: int | None = None, **more: Any) -> WorldState:
    """A robot at the letter of the picture, with that heading or, as drawn, at random."""
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


class Step(NamedTuple):
    """What the robot did in a step; place and heading are those before it."""

    place: tuple[int, int]
    heading: int
    ahead: bool  # nothing is in front of it
    wish: int
    decided: bool
    bound: bool  # it was in the second step of a sequence


def steps(state: WorldState, count: int) -> Iterator[Step]:
    engine = engine_for(state)
    cols = state.problem.plan.lattice.cols
    for _ in range(count):
        old = state.memories[0]
        decisions, free = (old.decisions, old.free_steps) if old else (0, 0)
        events = engine.sense_and_decide(state, [])
        memory = state.memories[0]
        cell, heading = int(events.cells[0]), int(events.headings[0])
        row, col = divmod(cell, cols)
        yield Step(
            (row, col),
            heading,
            bool(state.beliefs[0].moves.item(cell) >> heading & 1),
            events.actions[0].direction,
            memory.decisions > decisions,
            memory.free_steps == free,
        )
        engine.move(state, events.actions)


def test_it_starts_with_a_random_heading_and_goes_forward() -> None:
    headings = []
    for seed in range(60):
        state = world(Potential1(epsilon=1.0), FIELD, seed=seed)
        (first,) = steps(state, 1)
        assert first.wish == first.heading
        assert not first.decided
        headings.append(first.heading)
    assert set(headings) == {E, N, W, S}


def test_it_goes_on_trying_in_front_of_a_wall() -> None:
    state = world(Potential1(epsilon=0.0), ".....\n.a...\n.....", E)
    walked = list(steps(state, 40))
    assert [step.place for step in walked] == [(1, min(1 + t, 4)) for t in range(40)]
    assert {step.wish for step in walked} == {E}
    assert state.memories[0].decisions == 0


def test_a_team_that_never_turns_gets_stuck_and_says_so() -> None:
    done = conav.explore(
        parse_ascii(FIELD), strategy="potential-1", settings={"epsilon": 0}, **PAPER
    )
    assert done.status == "stuck"


def test_in_front_of_a_wall_it_waits_for_its_turn_to_choose() -> None:
    waits = []
    for seed in range(300):
        state = world(Potential1(epsilon=0.2), "........\n.......a\n........", E, seed=seed)
        state.step = 1
        wait = 0
        for step in steps(state, 200):
            if step.decided:
                # Left, right and back are left to it.
                assert step.wish in (N, S, W)
                break
            assert (step.place, step.wish) == ((1, 7), E)
            wait += 1
        waits.append(wait)
    # Geometric: 0.8 / 0.2 steps on average, with a deviation of 4.5.
    assert abs(sum(waits) / 300 - 4.0) < 5 * 4.5 / 300**0.5


def test_blocked_sequences_are_left_out() -> None:
    # In the dead end only turning round can be played, whatever else it would show.
    for seed in range(8):
        picture = "?????\n#####\n#..a#\n#####\n?????"
        state = world(Potential1(epsilon=1.0), picture, E, seed=seed)
        walked = list(steps(state, 4))
        # In the first step everybody goes forward, walls or not.
        assert [step.wish for step in walked] == [E, W, W, W]
        assert [step.place for step in walked] == [(2, 3), (2, 3), (2, 3), (2, 2)]
        assert [step.decided for step in walked[:3]] == [False, True, False]


def test_shut_in_it_stays() -> None:
    state = world(Potential1(epsilon=1.0), "###\n#a#\n###", E)
    assert [step.wish for step in steps(state, 3)] == [E, STAY, STAY]
    assert state.cells.tolist() == [4]


def test_it_turns_where_it_would_discover_most() -> None:
    # A robot in a field of which it knows the disc around it: two steps forward show most.
    for heading in range(4):
        state = world(Potential1(epsilon=1.0), FIELD, heading)
        state.step = 1
        (first,) = steps(state, 1)
        assert first.decided
        assert first.wish == heading
    # Near a corner: north shows five new points, two steps on four, back four, south two.
    picture = "\n".join(["........"] * 5 + [".....a.."] + ["........"])
    state = world(Potential1(epsilon=1.0), picture, E)
    state.step = 1
    walked = list(steps(state, 2))
    assert [step.wish for step in walked] == [N, N]
    assert [step.decided for step in walked] == [True, False]


def test_exploring_always_it_decides_at_every_free_step() -> None:
    state = world(Potential1(epsilon=1.0), FIELD, seed=3)
    walked = list(steps(state, 300))
    for step in walked[1:]:
        assert step.decided == (not step.bound)
    assert any(not step.ahead for step in walked)


def test_drawn_once_per_sequence_it_decides_at_most_every_second_step() -> None:
    state = world(Potential1(epsilon=1.0, draw="sequence"), FIELD, seed=3)
    walked = list(steps(state, 300))
    for before, after in pairwise(walked):
        if after.ahead and not before.bound:
            assert after.bound
            assert not after.decided
    assert sum(step.decided for step in walked) > 100


def visited_after_all_is_seen(strategy: Potential1, seed: int) -> set[tuple[int, int]]:
    """Where a robot goes in an empty square of 9 x 9, all in range from the start, after 300."""
    square = "\n".join(["." * 9] * 4 + ["....a...."] + ["." * 9] * 4)
    walked = list(steps(world(strategy, square, seed=seed, range_m=12.0), 900))
    return {step.place for step in walked[300:]}


def test_the_literal_tie_rule_locks_into_an_orbit() -> None:
    for seed in range(4):
        places = visited_after_all_is_seen(Potential1(epsilon=0.5, tie="baseline"), seed)
        assert all(r in (0, 8) or c in (0, 8) or 4 in (r, c) for r, c in places)
        assert len(visited_after_all_is_seen(Potential1(epsilon=0.5), seed)) > 60


@pytest.mark.parametrize("settings", [{}, {"epsilon": 0.5, "draw": "sequence"}])
def test_finishes_and_is_accepted(settings: dict[str, Any], tmp_path: Path) -> None:
    grid = conav.builtin_map("three-obstacles", width_m=20, height_m=20, seed=2)
    out = tmp_path / "run.mcap"
    done = conav.explore(grid, strategy="potential-1", settings=settings, seed=2, out=out, **PAPER)
    assert done.status == "done"
    assert done.metrics.coverage == 1.0
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()


def test_a_real_kind_of_map_is_accepted(tmp_path: Path) -> None:
    out = tmp_path / "run.mcap"
    conav.explore(
        "office",
        strategy="potential-1",
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
    check_strategy(Potential1(epsilon=0.3), motion="forward-turn")


@pytest.mark.parametrize("settings", [{"epsilon": "2"}, {"epsilon": "often"}, {"tie": "forward"}])
def test_settings_out_of_range_name_the_page(settings: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r"docs/strategies/potential-1\.md"):
        conav.explore("maze", strategy="potential-1", settings=settings)
