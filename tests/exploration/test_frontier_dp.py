"""Costs by value iteration, probabilities of seeing counted by hand, and end to end."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conav
from conav.errors import InputError
from conav.exploration import frontier_dp
from conav.exploration.frontier_dp import (
    RINGS,
    FrontierDP,
    ViewMemory,
    iterated_costs,
    look_around,
)
from conav.exploration.frontier_targets import find_targets
from conav.exploration.types import TeamView
from conav.exploration.utility_reduction import assign_by_utility, probability
from conav.geometry.sight import (
    cells_in_sight,
    lateral_limits,
    new_gap_space,
    sight_buffer_size,
)
from conav.maps.ascii_art import ascii_starts, parse_ascii
from conav.maps.occupancy_grid import UNKNOWN
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import WorldState, new_world

POST = """
.....
.....
..a#.
.....
.....
"""
CELL = """
.....................
.....................
.....................
.....................
.....................
.....................
.....................
.....................
........#####........
........#...#........
........#.a.#........
........#...#........
........#####........
.....................
.....................
.....................
.....................
.....................
.....................
.....................
.....................
"""


def world(picture: str, strategy: Any = None, **more: Any) -> WorldState:
    starts = [(c + 0.5, r + 0.5) for r, c in ascii_starts(picture).values()]
    problem, _ = exploration_problem(
        parse_ascii(picture), robots=len(starts), starts=starts, **({"range_m": 2.0} | more)
    )
    return started(problem, strategy)


def started(problem: Any, strategy: Any = None) -> WorldState:
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    return new_world(problem, strategy or FrontierDP(), seen)


def view_of(state: WorldState, robot: int = 0) -> TeamView:
    return TeamView(
        state.step,
        state.time_s,
        robot,
        state.problem.robots[robot],
        int(state.cells[robot]),
        int(state.headings[robot]),
        state.beliefs[robot],
        state.problem.plan.lattice,
        state.heard_cell[robot],
        state.heard_step[robot],
        state.in_touch[robot],
    )


def counted(picture: str, **more: Any) -> ViewMemory:
    """The counts after a look from the letter."""
    state = world(picture, **more)
    engine_for(state).sense_and_decide(state, [])
    memory = ViewMemory()
    look_around(memory, view_of(state), state.cells)
    return memory


def rings(counts: np.ndarray) -> dict[int, int]:
    return {int(ring): int(counts[ring]) for ring in np.flatnonzero(counts)}


def test_cells_seen_are_counted_by_hand() -> None:
    # Range 2: itself, four cells at 1, four at 1.41 and four at 2, one of them behind the post.
    memory = counted(POST)
    assert rings(memory.there) == {0: 1, 16: 4, 22: 4, 31: 4}
    assert rings(memory.seen) == {0: 1, 16: 4, 22: 4, 31: 3}


def test_counts_add_up_over_robots_and_steps() -> None:
    state = world(POST)
    engine_for(state).sense_and_decide(state, [])
    memory = ViewMemory()
    for _ in range(3):
        look_around(memory, view_of(state), np.repeat(state.cells, 2))
    assert rings(memory.there) == {0: 6, 16: 24, 22: 24, 31: 24}
    assert rings(memory.seen) == {0: 6, 16: 24, 22: 24, 31: 18}


def test_a_sensor_that_sees_through_walls_sees_all() -> None:
    memory = counted(POST, sensor="disc")
    assert np.array_equal(memory.seen, memory.there)


def test_the_border_of_the_map_is_not_counted() -> None:
    assert rings(counted("a....\n.....\n.....").there) == {0: 1, 16: 2, 22: 1, 31: 2}


@pytest.mark.parametrize("sensor", ["range", "disc"])
@pytest.mark.parametrize("range_m", [1.0, 3.0, 7.4, 40.0])
def test_counts_are_those_of_a_look_at_every_cell(sensor: str, range_m: float) -> None:
    """Near the border and far from it, with walls and without."""
    rows, cols = 19, 26
    rng = np.random.default_rng(int(range_m))
    walls = np.where(rng.random((rows, cols)) < 0.15, "#", ".")
    walls[3, 4] = "a"
    state = world("\n".join("".join(line) for line in walls), sensor=sensor, range_m=range_m)
    for _ in range(4):
        engine = engine_for(state)
        engine.move(state, engine.sense_and_decide(state, []).actions)
    view = view_of(state)
    places = [0, cols - 1, (rows - 1) * cols, 5 * cols + 9, int(state.cells[0])]
    memory = ViewMemory()
    look_around(memory, view, np.array(places, np.int32))
    limits = lateral_limits(min(range_m, rows + cols))
    gaps = new_gap_space(limits), new_gap_space(limits)
    out = np.empty(sight_buffer_size(limits), np.int32)
    seen, there = np.zeros(RINGS, np.int64), np.zeros(RINGS, np.int64)
    for row, col in (divmod(place, cols) for place in places):
        look = (view.belief.cells, row, col, sensor == "range", limits, *gaps, out)
        in_sight = set(out[: cells_in_sight(*look)].tolist())
        for r, c in np.ndindex(rows, cols):
            distance = np.sqrt((r - row) ** 2 + (c - col) ** 2)
            if distance <= range_m:
                ring = min(int(distance / (len(limits) - 1) * RINGS), RINGS - 1)
                known = view.belief.cells[r, c] != UNKNOWN
                there[ring] += 1
                seen[ring] += known and r * cols + c in in_sight
    assert memory.there.tolist() == there.tolist()
    assert memory.seen.tolist() == seen.tolist()


def test_behind_walls_less_is_seen_farther_away() -> None:
    memory = counted(CELL, range_m=8.0)
    # In the small cell everything up to a distance of 2 is seen, nothing from 3 on.
    distance = np.arange(RINGS) * 8.0 / RINGS
    near = memory.there > 0
    assert (memory.seen[near & (distance < 1.75)] == memory.there[near & (distance < 1.75)]).all()
    assert (memory.seen[distance > 3.0] == 0).all()
    assert memory.there[distance > 3.0].sum() > 100
    share = [
        memory.seen[part].sum() / memory.there[part].sum() for part in np.split(np.arange(32), 8)
    ]
    assert all(a >= b for a, b in pairwise(share))
    assert share[0] == 1.0
    assert share[-1] == 0.0


def given_to_the_rule(
    picture: str, monkeypatch: pytest.MonkeyPatch, strategy: FrontierDP | None = None, **more: Any
) -> Any:
    """What the rule of assignment is called with in the first step."""
    calls: list[Any] = []

    def watched(*given: Any) -> np.ndarray:
        calls.append(given)
        return assign_by_utility(*given)

    monkeypatch.setattr(frontier_dp, "assign_by_utility", watched)
    state = world(picture, strategy, **more)
    engine_for(state).sense_and_decide(state, [])
    return calls[0]


WIDE_POST = "\n".join(
    ["." * 11] * 3 + ["." * 11, "." * 11, ".....a#....", "." * 11, "." * 11] + ["." * 11] * 3
)


def test_the_probability_of_seeing_is_the_share_seen_so_far(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen = given_to_the_rule(WIDE_POST, monkeypatch)[4]
    assert [probability(away, *seen) for away in (0.0, 1.0, 2**0.5)] == [1.0, 1.0, 1.0]
    # Out of range nothing is seen.
    assert [probability(away, *seen) for away in (2.1, 3.0, 50.0)] == [0.0, 0.0, 0.0]
    # Of the four cells at 2 one is behind the post.
    seen = given_to_the_rule(WIDE_POST, monkeypatch, range_m=4.0)[4]
    assert [probability(away, *seen) for away in (1.0, 2.0)] == [1.0, 0.75]
    assert 0.0 < probability(3.0, *seen) < 1.0


def test_a_range_beyond_the_map_makes_no_difference_to_what_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # From inside the cell nobody has ever seen as far as 8 cells.
    picture = CELL.replace("#...#", "#....", 1)
    for range_m in (20.0, 42.0, 100.0, 1000.0):
        seen = given_to_the_rule(picture, monkeypatch, range_m=range_m)[4]
        near, far = (probability(away, *seen) for away in (1.0, 8.5))
        assert near == 1.0
        assert far < 0.5


def test_costs_are_lengths_times_the_floor(monkeypatch: pytest.MonkeyPatch) -> None:
    picture = "#" * 17 + "\n#.......a.......#\n" + "#" * 17
    for free in (0.1, 1.0, 1e-9):
        strategy = FrontierDP(beta=3.0, free=free)
        targets, values, beta, cols, _, taken = given_to_the_rule(picture, monkeypatch, strategy)
        assert targets.costs.tolist() == [[2.0, 2.0]]
        assert values.tolist() == [[2.0 * free, 2.0 * free]]
        assert (beta, cols, len(taken)) == (3.0, 17, 0)


@pytest.mark.parametrize("name", ["office", "cave", "maze"])
@pytest.mark.parametrize("motion", ["8-connected", "4-connected"])
def test_value_iteration_gives_the_costs_of_the_search(name: str, motion: str) -> None:
    problem, _ = exploration_problem(
        conav.builtin_map(name, width_m=12, height_m=12, seed=1),
        robots=3,
        range_m=2.0,
        seed=1,
        motion=motion,
        radio=3.0,
    )
    state = started(problem)
    engine = engine_for(state)
    unreachable = 0
    for step in range(40):
        engine.move(state, engine.sense_and_decide(state, []).actions)
        if step % 8 == 0:
            view = view_of(state)
            targets = find_targets(view, state.cells)
            costs = iterated_costs(view, state.cells, targets.cells)
            assert np.array_equal(np.isinf(costs), np.isinf(targets.costs))
            assert np.allclose(costs, targets.costs, rtol=1e-11, atol=0)
            assert np.isfinite(costs).any()
            unreachable += int(np.isinf(costs).sum())
    assert unreachable > 0


class Nameless:
    """A strategy whose settings do not get into the run file."""

    def __init__(self, inner: FrontierDP) -> None:
        self.start = inner.start
        self.step = inner.step


@pytest.mark.parametrize("radio", ["perfect", 4.0])
def test_literal_value_iteration_makes_the_same_run(
    radio: str | float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    grid = conav.builtin_map("cave", width_m=9, height_m=9, seed=2)
    called = []

    def counting(*given: Any) -> np.ndarray:
        called.append(given)
        return iterated_costs(*given)

    monkeypatch.setattr(frontier_dp, "iterated_costs", counting)
    digests = []
    for literal in (False, True):
        assert not called
        done = conav.explore(
            grid,
            strategy=Nameless(FrontierDP(literal=literal)),
            robots=3,
            range_m=1.8,
            radio=radio,
            seed=2,
            out=tmp_path / f"{literal}.mcap",
        )
        digests.append(done.result.digest)
    assert called
    assert digests[0] == digests[1]
    other = conav.explore(
        grid,
        strategy=Nameless(FrontierDP(beta=1e-6)),
        robots=3,
        range_m=1.8,
        radio=radio,
        seed=2,
        out=tmp_path / "other.mcap",
    )
    assert other.result.digest != digests[0]


@pytest.mark.parametrize("settings", [{"free": 1e-300}, {"free": 1.0}, {"beta": 0.0}])
def test_works_at_the_ends_of_its_settings(settings: dict[str, object]) -> None:
    grid = conav.builtin_map("maze", width_m=9, height_m=9, seed=1)
    done = conav.explore(
        grid,
        strategy="frontier-dp",
        settings=settings,
        robots=3,
        range_m=1.8,
        seed=1,
        max_time_s=5000.0,
    )
    assert done.status == "done"


@pytest.mark.parametrize(
    "settings",
    [
        {"free": 0.0},
        {"free": -0.1},
        {"free": 1.01},
        {"free": "nan"},
        {"free": "little"},
        {"beta": -1.0},
        {"beta": "inf"},
        {"beta": "nan"},
        {"literal": "perhaps"},
    ],
)
def test_settings_out_of_range_name_the_page(settings: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r"docs/strategies/frontier-dp\.md") as caught:
        conav.explore("maze", strategy="frontier-dp", settings=settings)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["office", "cave", "maze", "three-obstacles"])
@pytest.mark.parametrize("radio", ["perfect", 6.0])
def test_finishes_and_is_accepted(name: str, radio: str | float, tmp_path: Path) -> None:
    size = 20 if name == "three-obstacles" else 8
    for robots in (1, 2, 4) if radio == "perfect" else (2, 4):
        grid = conav.builtin_map(name, width_m=size, height_m=size, seed=robots)
        out = tmp_path / f"{robots}.mcap"
        done = conav.explore(
            grid,
            strategy="frontier-dp",
            robots=robots,
            range_m=size / 4,
            radio=radio,
            seed=robots,
            out=out,
        )
        assert done.status == "done"
        assert done.metrics.coverage == 1.0
        report = conav.verify_exploration(conav.read_run(out))
        assert report.accepted, report.lines()
