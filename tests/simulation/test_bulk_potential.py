"""Games in bulk are, step for step, the games that the ordinary engine plays."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from conav.exploration.catalogue import make_strategy
from conav.exploration.marginal_contribution import MarginalContribution
from conav.exploration.nearest import Nearest
from conav.exploration.potential import Potential
from conav.exploration.potential_improved import PotentialImproved
from conav.exploration.turn_sequences import LEFT_OUT
from conav.exploration.types import ExplorationProblem
from conav.exploration.uncoordinated_alone import UncoordinatedAlone
from conav.maps.ascii_art import ascii_starts, parse_ascii
from conav.maps.builtin.catalogue import builtin_map
from conav.maps.occupancy_grid import FREE, OccupancyGrid
from conav.robots.motion import MOTIONS
from conav.robots.radio import radio
from conav.robots.sensor import sensor
from conav.simulation.bulk_potential import BulkGames, BulkStrategy, play_games
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import run_exploration
from conav.simulation.world_state import new_world

FIELD = "\n".join(["." * 23] * 4 + ["...a.b......c.........."] + ["." * 23] * 3)
# Wider than 64 columns, with the robots around the 64th.
WIDE = "\n".join(
    ["." * 90] * 2
    + ["." * 30 + "##" + "." * 58]
    + ["." * 61 + "a.b.c" + "." * 24]
    + ["." * 66 + "#" * 10 + "." * 14]
)
HIGH = "\n".join([".." + "#." * 2] * 3 + ["......"] * 20 + ["..abc."] + [".##..."] * 4 + ["....##"])
# Dead ends, rooms of one cell with and without a robot, walls and gaps at the border, unknowns.
ODD = """
.#..#...#.....#
.#a.#.#.#.###.#
....#.#...#d#..
#####.#######..
....#.#b..#...#
.##...#.#.#.#.#
.#..#####...#.?
...##.....#c#??
"""
LANE = "." * 20 + "a..b" + "." * 8
MAPS = {"field": FIELD, "wide": WIDE, "high": HIGH, "odd": ODD, "lane": LANE}
RANGES = (1.0, 2.0, 2.5, 3.0, 5.0)
EPSILONS = (0.0, 0.1, 0.5, 1.0)
TIES = ("random", "baseline")
DRAWS = ("step", "sequence")
BIG_SEEDS = (2**32 - 1, 2**32, 2**40 + 7, 2**63)

RULES: list[tuple[str, dict[str, object]]] = [
    *(
        (name, {"epsilon": epsilon, "tie": tie, "draw": draw})
        for name in ("potential-1", "potential", "potential-improved")
        for epsilon, tie, draw in product(EPSILONS, TIES, DRAWS)
    ),
    *(
        ("better-response", {"epsilon": epsilon, "draw": draw})
        for epsilon, draw in product(EPSILONS, DRAWS)
    ),
    *((name, {"tie": tie}) for name in ("uncoordinated", "uncoordinated-alone") for tie in TIES),
]


def paper_problem(
    grid: OccupancyGrid, starts: Sequence[tuple[int, int]], **more: Any
) -> ExplorationProblem:
    """The world of the paper, robots at (row, col)."""
    side = grid.resolution
    how = {"sensor": "disc", "motion": "forward-turn", "traffic": "none", "range_m": 2 * side}
    problem, _ = exploration_problem(
        grid,
        robots=len(starts),
        starts=[((c + 0.5) * side, (r + 0.5) * side) for r, c in starts],
        **(how | {"cell_m": side, "radius_m": 0.1 * side, "speed_mps": side} | more),
    )
    return problem


def drawn(picture: str, robots: int = 3, **more: Any) -> ExplorationProblem:
    """Robots at the letters in turn, so that surplus ones stand on others."""
    places = list(ascii_starts(picture).values())
    starts = [places[i % len(places)] for i in range(robots)]
    return paper_problem(parse_ascii(picture), starts, **more)


def strategy_of(name: str, values: dict[str, object]) -> BulkStrategy:
    strategy: Any = make_strategy(name, values)
    return strategy


class Played(NamedTuple):
    """One game of the ordinary engine, as `BulkGames` describes it."""

    covered: list[int]
    decisions: int
    turns: int
    free_steps: int
    left_out: int
    cells: NDArray[np.int32]
    headings: NDArray[np.int8]


def play_one(problem: ExplorationProblem, strategy: Any, seed: int, steps: int) -> Played:
    """The game by the engine; its minds are asked once more at the end, which is not counted."""
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(replace(problem, seed=seed), strategy, seen)
    engine = engine_for(state)
    covered: list[int] = []
    cells: list[NDArray[np.int32]] = []
    headings: list[NDArray[np.int8]] = []
    tally = (0, 0, 0)
    for step in range(steps + 1):
        if step == steps and steps > 0:
            minds = state.memories
            tally = (
                sum(mind.decisions for mind in minds),
                sum(mind.turns for mind in minds),
                sum(mind.free_steps for mind in minds),
            )
        events = engine.sense_and_decide(state, [])
        covered.append(int(state.covered[0]))
        cells.append(events.cells)
        headings.append(events.headings)
        engine.move(state, events.actions)
    left_out = 0
    if isinstance(strategy, PotentialImproved):
        # With the perfect radio everybody keeps the same sets.
        states = [mind.state for mind in state.memories]
        assert all(np.array_equal(states[0], other) for other in states)
        left_out = int(((states[0] == LEFT_OUT) & (seen == 1)).sum())
    return Played(covered, *tally, left_out, np.array(cells), np.array(headings))


def assert_same(
    problem: ExplorationProblem, strategy: BulkStrategy, seeds: Sequence[int], steps: int
) -> BulkGames:
    games = play_games(problem, strategy, seeds, steps, trace=True)
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    assert games.observable == seen.sum()
    for game, seed in enumerate(seeds):
        one = play_one(problem, strategy, seed, steps)
        assert np.array_equal(games.cells[game], one.cells)
        assert np.array_equal(games.headings[game], one.headings)
        assert games.covered[game].tolist() == one.covered
        assert games.decisions[game] == one.decisions
        assert games.turns[game] == one.turns
        assert games.free_steps[game] == one.free_steps
        assert games.left_out[game] == one.left_out
    return games


# --- the same games -------------------------------------------------------------------------------


@pytest.mark.parametrize("number", range(len(RULES)), ids=lambda k: f"{RULES[k][0]}-{k}")
def test_every_setting_on_every_map(number: int) -> None:
    name, values = RULES[number]
    strategy = strategy_of(name, values)
    for k, (of, picture) in enumerate(MAPS.items()):
        # All ranges and team sizes meet all maps and, over the rules, each other.
        problem = drawn(
            picture,
            robots=1 + (2 * k + number) % 5,
            range_m=RANGES[(k + number // 5) % 5],
            radio="off" if name == "uncoordinated-alone" else "perfect",
        )
        seeds = [number, BIG_SEEDS[number % 4]] if of == "odd" else [number]
        games = assert_same(problem, strategy, seeds, 90)
        if of != "odd" and values.get("epsilon") != 0.0:  # else few robots go far
            assert len(np.unique(games.cells)) > 5


@pytest.mark.parametrize("s_range", RANGES)
@pytest.mark.parametrize("name", sorted({name for name, _ in RULES}))
def test_long_games_on_the_map_of_the_paper(name: str, s_range: float) -> None:
    alone = name == "uncoordinated-alone"
    problem, _ = exploration_problem(
        builtin_map("three-obstacles", width_m=30, height_m=22, seed=4),
        sensor="disc",
        motion="forward-turn",
        traffic="none",
        cell_m=1.0,
        speed_mps=1.0,
        range_m=s_range,
        radio="off" if alone else "perfect",
        seed=4,
    )
    games = assert_same(problem, strategy_of(name, {}), [int(s_range)], 500)
    assert games.turns[0] > 20
    assert games.covered[0, -1] > games.observable / 2


@settings(max_examples=300, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    rule=st.sampled_from(RULES),
    resolution=st.sampled_from([1.0, 0.1, 0.3]),
    s_range=st.sampled_from([1.0, 1.5, 2.0, 2.5, 3.0, 5.0, 40.0]),
    robots=st.integers(1, 5),
    off=st.booleans(),
)
def test_small_random_worlds(
    seed: int,
    rule: tuple[str, dict[str, object]],
    resolution: float,
    s_range: float,
    robots: int,
    off: bool,
) -> None:
    rng = np.random.default_rng(seed)
    rows, cols = rng.integers(1, 10, 2).tolist()
    cells = (rng.random((rows, cols)) < rng.choice([0.0, 0.2, 0.45])).astype(np.uint8)
    cells.flat[int(rng.integers(cells.size))] = FREE
    free = np.argwhere(cells == FREE).tolist()
    # With replacement: robots may start on one another.
    starts = [tuple(free[k]) for k in rng.integers(len(free), size=robots).tolist()]
    name, values = rule
    silent = name == "uncoordinated-alone" or (off and name != "potential-improved")
    problem = paper_problem(
        OccupancyGrid(cells, resolution),
        starts,
        # Products like 3 * 0.1 are a little more or less than three cells.
        range_m=s_range * resolution,
        radio="off" if silent else "perfect",
    )
    assert_same(problem, strategy_of(name, values), [seed], 40)


def test_with_the_radio_off_every_strategy_knows_only_its_own() -> None:
    for name, values in RULES:
        if name != "potential-improved" and values.get("epsilon", 0.5) == 0.5:
            assert_same(drawn(FIELD, radio="off"), strategy_of(name, values), [3], 100)


def test_shared_knowledge_and_none_are_told_apart() -> None:
    # Were the radio ignored, both comparisons above could hold of the wrong game.
    one, other = (
        play_games(drawn(FIELD, radio=how), Potential(epsilon=0.5), range(20), 100, trace=True)
        for how in ("perfect", "off")
    )
    assert not np.array_equal(one.cells, other.cells)


def test_names_make_the_generators() -> None:
    problem = drawn(FIELD, robots=3)
    names = ("", "Zoë", "x" * 70)
    robots = tuple(
        replace(robot, name=name) for robot, name in zip(problem.robots, names, strict=True)
    )
    assert_same(replace(problem, robots=robots), Potential(epsilon=0.5), [1, 2**40 + 7], 100)


def test_wide_robots_still_pass_between_walls() -> None:
    problem = drawn(ODD, robots=4, radius_m=0.499)
    assert_same(problem, Potential(epsilon=0.5), [1], 200)


def test_improved_robots_leave_points_out() -> None:
    # With walls around, which are points but not observable.
    picture = FIELD.replace(".." * 5, "....#.....")
    for s_range, steps in product((2.0, 3.0), (3, 8)):
        problem = drawn(picture, robots=5, range_m=s_range)
        games = assert_same(problem, PotentialImproved(epsilon=1.0), range(12), steps)
        # The counter would agree trivially if no game left anything out.
        assert np.count_nonzero(games.left_out) > 2


# --- what is told of them -------------------------------------------------------------------


@pytest.mark.parametrize("name", ["potential", "potential-improved", "uncoordinated-alone"])
def test_covered_is_what_the_discs_along_the_way_hold(name: str) -> None:
    problem = drawn(HIGH, range_m=2.5, radio="off" if name == "uncoordinated-alone" else "perfect")
    games = play_games(problem, strategy_of(name, {}), range(5), 60, trace=True)
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor) == 1
    y, x = np.indices(observable.shape)
    for game in range(5):
        seen = np.zeros_like(observable)
        for step in range(61):
            for cell in games.cells[game, step].tolist():
                r, c = divmod(cell, observable.shape[1])
                seen |= (y - r) ** 2 + (x - c) ** 2 <= 2.5**2
            assert games.covered[game, step] == (seen & observable).sum()


def test_two_calls_are_equal() -> None:
    for strategy in (Potential(epsilon=0.5), PotentialImproved(epsilon=0.5)):
        one, other = (play_games(drawn(FIELD), strategy, range(10), 80, trace=True) for _ in "ab")
        for a, b in zip(vars(one).values(), vars(other).values(), strict=True):
            assert np.array_equal(a, b)


@pytest.mark.parametrize("name", sorted({name for name, _ in RULES}))
def test_a_game_does_not_depend_on_the_others_of_the_call(name: str) -> None:
    problem = drawn(ODD, range_m=2.0, radio="off" if name == "uncoordinated-alone" else "perfect")
    strategy = strategy_of(name, {})
    seeds = [5, 0, 2**63, 5, 17]
    together = play_games(problem, strategy, seeds, 70, trace=True)
    for game, seed in enumerate(seeds):
        alone = play_games(problem, strategy, [seed], 70, trace=True)
        for of, value in vars(together).items():
            if of != "observable":
                assert np.array_equal(value[game], getattr(alone, of)[0]), of


def test_neither_seed_nor_time_limit_of_the_problem_matter() -> None:
    problem = drawn(FIELD)
    other = replace(problem, seed=99, max_time_s=1.0)
    one, two = (play_games(p, Potential(), [4], 80, trace=True) for p in (problem, other))
    assert np.array_equal(one.cells, two.cells)


def test_shapes_and_types() -> None:
    problem = drawn(FIELD)
    games = play_games(problem, Potential(), [1, 2], 7)
    assert games.covered.shape == (2, 8)
    assert games.cells.shape == games.headings.shape == (2, 0, 3)
    traced = play_games(problem, Potential(), [1, 2], 7, trace=True)
    assert traced.cells.shape == traced.headings.shape == (2, 8, 3)
    assert np.array_equal(games.covered, traced.covered)
    assert traced.cells[:, 0].tolist() == [list(problem.starts)] * 2
    assert play_games(problem, Potential(), [], 7).covered.shape == (0, 8)


def test_a_shorter_game_is_the_beginning_of_a_longer_one() -> None:
    for strategy in (Potential(epsilon=0.5), PotentialImproved(epsilon=0.5)):
        long = play_games(drawn(FIELD), strategy, range(5), 60, trace=True)
        short = play_games(drawn(FIELD), strategy, range(5), 25, trace=True)
        assert np.array_equal(short.cells, long.cells[:, :26])
        assert np.array_equal(short.covered, long.covered[:, :26])


def test_a_game_of_no_steps() -> None:
    for strategy in (Potential(), PotentialImproved()):
        assert_same(drawn(FIELD), strategy, [0, 1], 0)


def test_a_game_goes_on_when_all_is_seen() -> None:
    games = assert_same(drawn(LANE, range_m=5.0), Potential(), [2], 400)
    assert games.covered[0, 200] == games.observable
    assert len(np.unique(games.cells[0, 200:])) > 5


def test_a_robot_that_is_shut_in_sees_and_stays() -> None:
    problem = drawn("....\n.##.\n#a#.\n.##.", robots=2, range_m=1.0)
    for strategy in (Potential(epsilon=1.0), PotentialImproved(epsilon=1.0)):
        games = assert_same(problem, strategy, [0, 1], 20)
        assert (games.cells == 5).all()
        assert (games.turns == 0).all()
        assert (games.covered == 1).all()
        assert (games.observable, games.free_steps.tolist()) == (1, [40, 40])


# --- time to a share ----------------------------------------------------------------------------


def with_coverage(covered: list[list[int]], observable: int) -> BulkGames:
    games = len(covered)
    nothing = np.zeros(games, dtype=np.int64)
    return BulkGames(
        np.array(covered, dtype=np.uint32),
        observable,
        nothing,
        nothing,
        nothing,
        nothing[:, None],
        nothing,
        np.zeros((games, 0, 1), dtype=np.int32),
        np.zeros((games, 0, 1), dtype=np.int8),
    )


def test_time_to_is_the_first_step_with_enough() -> None:
    games = with_coverage([[1, 5, 9, 10], [9, 9, 9, 9], [0, 0, 0, 1], [10, 10, 10, 10]], 10)
    assert games.time_to(0.9).tolist() == [2, 0, np.inf, 0]
    assert games.time_to(1.0).tolist() == [3, np.inf, np.inf, 0]
    assert games.time_to(0.1).tolist() == [0, 0, 3, 0]
    assert games.time_to(0.0).tolist() == [0, 0, 0, 0]


@pytest.mark.parametrize("percent", [90, 95, 99, 100])
def test_shares_are_not_lost_to_rounding(percent: int) -> None:
    for observable in range(1, 1500):
        enough = -(-percent * observable // 100)
        games = with_coverage([[enough - 1, enough, observable]], observable)
        assert games.time_to(percent / 100).tolist() == [1]


def test_times_are_those_of_the_metrics() -> None:
    problem = drawn(FIELD, max_time_s=2000.0)
    for seed in range(4):
        done = run_exploration(replace(problem, seed=seed), Potential(), name="potential")
        games = play_games(problem, Potential(), [seed], done.metrics.steps)
        assert games.covered[0].tolist() == list(done.covered)
        metrics = done.metrics
        expected = [metrics.t90_s, metrics.t95_s, metrics.t99_s, metrics.t100_s]
        assert None not in expected
        assert [games.time_to(share)[0] for share in (0.9, 0.95, 0.99, 1.0)] == expected


# --- what cannot be played ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"cell_m": 2.0}, "planning cells as large"),
        ({"cell_m": 0.5}, "planning cells as large"),
        ({"radius_m": 0.5}, "planning cells as large"),
        ({"sensor": "range"}, "disc sensor"),
        ({"traffic": "pibt"}, "traffic none"),
        ({"motion": "4-connected"}, "forward-turn"),
        ({"motion": "8-connected"}, "forward-turn"),
        ({"range_m": 0.9}, "range of a cell"),
        ({"range_m": 0.0}, "range of a cell"),
        ({"radio": 5.0}, "perfect or off"),
    ],
)
def test_other_problems_are_refused(more: dict[str, Any], says: str) -> None:
    problem = drawn(FIELD, **more)
    for strategy in (Potential(), PotentialImproved()):
        with pytest.raises(ValueError, match=says):
            play_games(problem, strategy, [0], 5)


@pytest.mark.parametrize(
    "change",
    [
        {"sensor": sensor("disc", 3.0)},
        {"sensor": sensor("range", 2.0)},
        {"radio": radio("off")},
        {"speed_mps": 0.5},
        {"radius_m": 0.05},
        {"motion": MOTIONS["4-connected"]},
    ],
)
def test_robots_that_differ_are_refused(change: dict[str, Any]) -> None:
    problem = drawn(FIELD)
    for odd in range(3):
        robots = list(problem.robots)
        robots[odd] = replace(robots[odd], **change)
        with pytest.raises(ValueError, match="games in bulk need"):
            play_games(replace(problem, robots=tuple(robots)), Potential(), [0], 5)


def test_improved_robots_need_a_radio() -> None:
    with pytest.raises(ValueError, match="improved algorithm in bulk needs the perfect radio"):
        play_games(drawn(FIELD, radio="off"), PotentialImproved(), [0], 5)
    play_games(drawn(FIELD, radio="off"), UncoordinatedAlone(), [0], 5)


@pytest.mark.parametrize("strategy", [Nearest(), MarginalContribution()])
def test_other_strategies_are_refused(strategy: Any) -> None:
    with pytest.raises(ValueError, match="no strategy of potential games"):
        play_games(drawn(FIELD), strategy, [0], 5)


def squares() -> ExplorationProblem:
    """The world of the paper at its usual size."""
    return paper_problem(builtin_map("three-obstacles", seed=4), [(1, 1), (1, 2), (2, 1)])


def test_own_sets_overlap_where_robots_saw_the_same_at_once() -> None:
    """Each robot's set against a recount: what it saw that nobody had seen the step before."""
    problem = squares()
    games = play_games(problem, Potential(), [1, 2], 300, trace=True)
    reach = int(problem.robots[0].sensor.range_m)
    for game in range(2):
        known: set[tuple[int, int]] = set()
        own: list[set[tuple[int, int]]] = [set() for _ in problem.robots]
        for cells in games.cells[game]:
            seen = [
                {
                    (r, c)
                    for r in range(cell // 40 - reach, cell // 40 + reach + 1)
                    for c in range(cell % 40 - reach, cell % 40 + reach + 1)
                    if 0 <= r < 40
                    and 0 <= c < 40
                    and (r - cell // 40) ** 2 + (c - cell % 40) ** 2 <= reach**2
                }
                for cell in cells.tolist()
            ]
            for mine, now in zip(own, seen, strict=True):
                mine |= now - known
            known.update(*seen)
        assert games.discovered[game].tolist() == [len(mine) for mine in own]


def test_time_to_a_share_that_is_no_float() -> None:
    games = play_games(squares(), Potential(), [1], 50)
    exact = replace(games, covered=np.array([[54, 55, 60]], np.uint32), observable=100)
    assert exact.time_to(0.55).tolist() == [1.0]


@pytest.mark.parametrize("seed", [-1, 1.5, 2**64])
def test_seeds_that_are_none(seed: Any) -> None:
    with pytest.raises(ValueError, match="seeds are whole numbers"):
        play_games(squares(), Potential(), [seed], 5)


def test_a_subclass_may_do_something_else() -> None:
    class Mine(Potential):
        pass

    with pytest.raises(ValueError, match="Mine is no strategy"):
        play_games(squares(), Mine(), [1], 5)
