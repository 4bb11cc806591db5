"""Algorithm 2 of [Philip2014] in small worlds whose steps follow by hand."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import conav
from conav.errors import InputError
from conav.exploration.potential import Potential
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


class Step(NamedTuple):
    """What robot 0 did in a step; place and heading are those before it."""

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
    for seed in range(200):
        state = world(Potential(epsilon=1.0), FIELD, seed=seed)
        (first,) = steps(state, 1)
        assert first.wish == first.heading
        assert not first.decided
        headings.append(first.heading)
    for heading in range(4):
        assert abs(headings.count(heading) - 50) < 5 * 6.2


def test_a_turn_costs_a_step() -> None:
    state = world(Potential(epsilon=0.0), "........\n#.######\n.a.....#\n########", E)
    walked = list(steps(state, 12))
    assert [step.place for step in walked[:6]] == [(1, c) for c in range(1, 7)]
    # At the end of the corridor it turns round, as nothing else can be done, and comes back.
    assert [step.heading for step in walked[5:8]] == [E, W, W]
    assert [step.place for step in walked[5:8]] == [(1, 6), (1, 6), (1, 5)]
    assert (walked[5].wish, walked[6].wish) == (W, W)
    assert (walked[5].decided, walked[6].decided) == (True, False)
    assert walked[6].bound


def test_an_obstacle_turns_it_to_the_best_side() -> None:
    # North it would see five new points, back in the west four, south two.
    picture = "..........\n" * 7 + ".......a#.\n.........."
    for seed in range(8):
        state = world(Potential(epsilon=0.0), picture, E, seed=seed)
        walked = list(steps(state, 3))
        assert [step.wish for step in walked] == [N, N, N]
        assert [step.place for step in walked] == [(1, 7), (1, 7), (2, 7)]
        assert [step.decided for step in walked] == [True, False, False]


def test_a_dead_end_turns_it_round() -> None:
    for seed in range(8):
        walked = list(steps(world(Potential(epsilon=0.0), "#####\n#..a#\n#####", E, seed=seed), 3))
        assert [step.wish for step in walked] == [W, W, W]
        assert [step.place for step in walked] == [(1, 3), (1, 3), (1, 2)]


def test_shut_in_it_stays() -> None:
    state = world(Potential(epsilon=1.0), "###\n#a#\n###", E)
    assert [step.wish for step in steps(state, 3)] == [STAY] * 3


def test_without_exploring_it_goes_straight_until_an_obstacle() -> None:
    state = world(Potential(epsilon=0.0), FIELD, seed=3)
    turns = 0
    for step in steps(state, 400):
        assert step.decided == (not step.ahead)
        if step.ahead:
            assert step.wish == step.heading
        else:
            assert step.wish != step.heading
            turns += 1
    assert turns > 20
    assert state.memories[0].turns == turns


def test_exploring_always_it_decides_at_every_free_step() -> None:
    state = world(Potential(epsilon=1.0), FIELD, seed=3)
    walked = list(steps(state, 300))
    assert not walked[0].decided
    for step in walked[1:]:
        assert step.decided == (not step.bound)
    assert sum(step.decided for step in walked) > 150
    # Two forward steps in a row are two decisions: only turns bind.
    assert any(a.decided and b.decided for a, b in pairwise(walked))


def test_epsilon_is_the_share_of_free_steps_with_a_decision() -> None:
    state = world(Potential(epsilon=0.2), "\n".join(["." * 200] * 99 + ["a" + "." * 199]), N)
    free = [step for step in steps(state, 1500) if step.ahead and not step.bound]
    share = sum(step.decided for step in free) / len(free)
    assert abs(share - 0.2) < 5 * (0.16 / len(free)) ** 0.5


def test_drawn_once_per_sequence_it_decides_at_most_every_second_step() -> None:
    state = world(Potential(epsilon=1.0, draw="sequence"), FIELD, seed=3)
    walked = list(steps(state, 300))
    for before, after in pairwise(walked):
        if before.wish != STAY and after.ahead and not before.bound:
            assert after.bound
            assert not after.decided
            assert after.wish == after.heading
    assert sum(step.decided for step in walked) > 100


def visited_after_all_is_seen(strategy: Potential, seed: int) -> set[tuple[int, int]]:
    """Where a robot goes in an empty square of 9 x 9, all in range from the start, after 300."""
    square = "\n".join(["." * 9] * 4 + ["....a...."] + ["." * 9] * 4)
    walked = list(steps(world(strategy, square, seed=seed, range_m=12.0), 900))
    return {step.place for step in walked[300:]}


def test_the_literal_tie_rule_locks_into_an_orbit() -> None:
    """Where nothing new is near all sequences tie; the baseline then wins for ever."""
    for seed in range(4):
        places = visited_after_all_is_seen(Potential(epsilon=0.5, tie="baseline"), seed)
        # The border, and perhaps the line it began on.
        assert all(r in (0, 8) or c in (0, 8) or 4 in (r, c) for r, c in places)
        assert len(places) <= 32 + 7
        assert len(visited_after_all_is_seen(Potential(epsilon=0.5), seed)) > 60


def test_ties_are_drawn_among_all_but_blocked_sequences() -> None:
    # All is known, so at its first choice all four sequences are worth nothing.
    wishes = []
    for seed in range(240):
        state = world(Potential(epsilon=1.0), "...\n.a.\n...\n...\n...", N, seed=seed, range_m=9.0)
        state.step = 1
        (first,) = steps(state, 1)
        wishes.append(first.wish)
    assert all(abs(wishes.count(k) - 60) < 5 * 6.8 for k in range(4))


@pytest.mark.parametrize(
    "settings", [{}, {"epsilon": 0.3}, {"draw": "sequence"}, {"tie": "random", "epsilon": 1.0}]
)
def test_finishes_and_is_accepted(settings: dict[str, Any], tmp_path: Path) -> None:
    grid = conav.builtin_map("three-obstacles", width_m=20, height_m=20, seed=2)
    out = tmp_path / "run.mcap"
    done = conav.explore(grid, strategy="potential", settings=settings, seed=2, out=out, **PAPER)
    assert done.status == "done"
    assert done.metrics.coverage == 1.0
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()


@pytest.mark.parametrize(
    "more",
    [
        {"motion": "forward-turn", "cell_m": 0.37},
        {"motion": "8-connected", "traffic": "none", "radio": 6.0},
        {"motion": "4-connected", "radio": "off", "cell_m": 0.43, "radius_m": 0.17},
    ],
)
def test_a_real_kind_of_map_is_accepted(more: dict[str, Any], tmp_path: Path) -> None:
    out = tmp_path / "run.mcap"
    done = conav.explore(
        "office", strategy="potential", robots=4, seed=3, max_time_s=200.0, out=out, **more
    )
    assert done.metrics.coverage > 0.1
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()


@pytest.mark.parametrize("motion", ["forward-turn", "8-connected"])
def test_it_is_a_strategy_like_any_other(motion: str) -> None:
    check_strategy(Potential(epsilon=0.3), motion=motion)


@pytest.mark.parametrize(
    "settings",
    [
        {"epsilon": "2"},
        {"epsilon": -0.1},
        {"epsilon": "often"},
        {"epsilon": "nan"},
        {"tie": "forward"},
        {"draw": "never"},
    ],
)
def test_settings_out_of_range_name_the_page(settings: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r"docs/strategies/potential\.md") as caught:
        conav.explore("maze", strategy="potential", settings=settings)
    assert "\n" not in str(caught.value)


def test_decisions_are_those_of_the_equations() -> None:
    """The whole game of three robots: whoever decides plays a best sequence by (7)."""
    picture = "\n".join(
        ["." * 12] * 3
        + ["...##......."] * 3
        + ["." * 12] * 3
        + ["........##.."] * 2
        + ["abc........."]
    )
    state = world(Potential(epsilon=0.3), picture)
    engine = engine_for(state)
    steps_by = ((0, 1), (1, 0), (0, -1), (-1, 0))
    y, x = np.indices((12, 12))
    seen = np.zeros((12, 12), bool)
    walls = state.problem.plan.walls == 1
    decided = 0
    for _ in range(150):
        for cell in state.cells:
            seen |= (y - cell // 12) ** 2 + (x - cell % 12) ** 2 <= 4
        before = [memory.decisions if memory else 0 for memory in state.memories]
        events = engine.sense_and_decide(state, [])
        for robot in range(3):
            if state.memories[robot].decisions == before[robot]:
                continue
            decided += 1
            r, c = divmod(int(events.cells[robot]), 12)
            heading = int(events.headings[robot])
            values: dict[int, int] = {}
            for turn in range(4):
                dr, dc = steps_by[(heading + turn) % 4]
                places = [(r + k * dr, c + k * dc) for k in ((1, 2) if turn == 0 else (1,))]
                free = [
                    0 <= a < 12 and 0 <= b < 12 and not (seen[a, b] and walls[a, b])
                    for a, b in places
                ]
                if not free[0]:
                    continue
                near = np.zeros((12, 12), bool)
                for (a, b), ok in zip(places, free, strict=True):
                    if ok:
                        near |= (y - a) ** 2 + (x - b) ** 2 <= 4
                values[turn] = int((near & ~seen).sum())
            if 0 not in values:
                assert events.actions[robot].direction != heading
            played = (events.actions[robot].direction - heading) % 4
            assert values[played] == max(values.values())
        engine.move(state, events.actions)
    assert decided > 60
