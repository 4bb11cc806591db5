"""The potential game with frontiers: the game is Algorithm 2, and what comes after it finishes."""

import os
from collections import Counter, deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import conav
import conav.exploration.potential_frontier as module
import conav.geometry.distance_field as distance_field
import conav.geometry.grid_search as grid_search
import conav.geometry.jump_graph as jump_graph
from conav.errors import InputError
from conav.exploration.belief import TARGET
from conav.exploration.frontier_targets import cut_into_pieces
from conav.exploration.potential import Potential
from conav.exploration.potential_frontier import FrontierGameMemory, PotentialFrontier
from conav.exploration.types import Strategy
from conav.geometry.directions import DCOL, DROW
from conav.maps.ascii_art import ascii_starts, parse_ascii
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import WorldState, new_world

PAPER: dict[str, Any] = {
    "motion": "forward-turn",
    "sensor": "disc",
    "range_m": 2.0,
    "cell_m": 1.0,
    "speed_mps": 1.0,
    "traffic": "none",
}
S_RANGE = 2


def world(strategy: Strategy, map: Any = "three-obstacles", **more: Any) -> WorldState:
    problem, _ = exploration_problem(map, **(PAPER | {"robots": 3, "seed": 1} | more))
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    return new_world(problem, strategy, seen)


class Before(NamedTuple):
    """A robot's memory before a step."""

    driving: bool
    drives: int
    decisions: int
    points: int
    free: int


def before(memory: FrontierGameMemory | None) -> Before:
    if memory is None:
        return Before(False, 0, 0, 0, 0)
    return Before(
        memory.driving, memory.drives, memory.decisions, memory.points_checked, memory.free_steps
    )


class Moment(NamedTuple):
    """A robot in one step."""

    robot: int
    cell: int
    heading: int
    before: Before
    after: FrontierGameMemory
    direction: int
    goal: int


def moments(state: WorldState, steps: int) -> Iterator[list[Moment]]:
    """The robots in each step, after their decisions and before their moves."""
    engine = engine_for(state)
    for _ in range(steps):
        old = [before(memory) for memory in state.memories]
        events = engine.sense_and_decide(state, [])
        assert not events.said
        yield [
            Moment(
                robot,
                int(events.cells[robot]),
                int(events.headings[robot]),
                old[robot],
                state.memories[robot],
                events.actions[robot].direction,
                events.actions[robot].goal,
            )
            for robot in range(state.n_robots)
        ]
        if state.covered[0] == state.n_observable:
            return
        engine.move(state, events.actions)


def plain_gains(state: WorldState, robot: int, cell: int, heading: int) -> dict[int, int]:
    """(17) less its first term, over the whole grid; sequences that cannot be played are absent."""
    known = state.beliefs[robot].cells != 2
    walls = state.problem.plan.walls == 1
    rows, cols = known.shape
    y, x = np.indices(known.shape)
    r, c = divmod(cell, cols)
    gains: dict[int, int] = {}
    for turn in range(4):
        k = (heading + turn) % 4
        places = [(r + s * DROW[k], c + s * DCOL[k]) for s in ((1, 2) if turn == 0 else (1,))]
        free = [
            0 <= a < rows and 0 <= b < cols and not (known[a, b] and walls[a, b]) for a, b in places
        ]
        if not free[0]:
            continue
        near = np.zeros(known.shape, bool)
        for (a, b), ok in zip(places, free, strict=True):
            if ok:
                near |= (y - a) ** 2 + (x - b) ** 2 <= S_RANGE**2
        gains[turn] = int((near & ~known).sum())
    return gains


@pytest.mark.parametrize("epsilon", [0.1, 0.3, 1.0])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_until_the_first_drive_it_is_potential_step_by_step(epsilon: float, seed: int) -> None:
    mixed = moments(world(PotentialFrontier(epsilon=epsilon, patience=6), seed=seed), 400)
    state = world(Potential(epsilon=epsilon), seed=seed)
    engine = engine_for(state)
    same = 0
    for now in mixed:
        if any(moment.after.drives for moment in now):
            break
        events = engine.sense_and_decide(state, [])
        assert [moment.cell for moment in now] == events.cells.tolist()
        assert [moment.direction for moment in now] == [a.direction for a in events.actions]
        engine.move(state, events.actions)
        same += 1
    assert same > 15


@pytest.mark.parametrize("patience", [1, 4])
@pytest.mark.parametrize("epsilon", [0.1, 1.0])
def test_the_game_goes_on_while_something_is_gained(patience: int, epsilon: float) -> None:
    """The phases of three robots, told from gains counted over the whole grid."""
    strategy = PotentialFrontier(epsilon=epsilon, patience=patience)
    seen: Counter[str] = Counter()
    for seed in range(4):
        grid = conav.builtin_map("three-obstacles", width_m=24, height_m=24, seed=seed)
        state = world(strategy, grid, seed=seed)
        without = [0] * 3
        for now in moments(state, 2000):
            for one in now:
                if one.after.decisions == one.before.decisions:
                    # In mid-turn, or on its way; neither phase ends then.
                    assert one.after.driving == one.before.driving
                    assert one.after.drives == one.before.drives
                    seen["drive" if one.after.driving else "mid-turn"] += 1
                    continue
                gains = plain_gains(state, one.robot, one.cell, one.heading)
                most = max(gains.values())
                if one.before.driving:
                    # Arrived: on with the game if there is something, else on to the next.
                    assert one.after.driving == (most == 0)
                    seen["arrived"] += 1
                    without[one.robot] = 0
                else:
                    without[one.robot] = without[one.robot] + 1 if most == 0 else 0
                    assert one.after.driving == (without[one.robot] >= patience)
                assert one.after.drives == one.before.drives + one.after.driving
                if not one.after.driving:
                    seen["game"] += 1
                    played = (one.direction - one.heading) % 4
                    if played != 0 or (epsilon == 1.0 and one.after.free_steps > 1):
                        assert gains[played] == most
        assert state.covered[0] == state.n_observable
    assert min(seen[what] for what in ("game", "drive", "arrived", "mid-turn")) > 10


def test_it_goes_where_the_fewest_are_nearer() -> None:
    """The rank of its goal, from breadth-first searches, is the lowest; the goal the nearest."""
    chosen = 0
    states = [world(PotentialFrontier(), seed=seed) for seed in (2, 3, 4)]
    for state, now in ((one, now) for one in states for now in moments(one, 2000)):
        places = [one.cell for one in now]
        for one in now:
            if one.after.drives == one.before.drives or one.goal < 0:
                continue
            belief = state.beliefs[one.robot]
            if not belief.marks.reshape(-1)[one.goal] & TARGET:
                continue  # no frontier can be stood on
            wanted = (belief.marks & TARGET != 0).astype(np.uint8)
            cells = np.flatnonzero(wanted)
            piece, count = cut_into_pieces(cells, belief.marks.shape[1], S_RANGE)
            away = [walk(belief.moves, place) for place in places]
            costs = [
                [min(d.get(int(cell), np.inf) for cell in cells[piece == p]) for p in range(count)]
                for d in away
            ]
            ranks = [sum(costs[i][p] < costs[one.robot][p] for i in range(3)) for p in range(count)]
            mine = costs[one.robot]
            best = min(p for p in zip(ranks, mine, strict=True) if np.isfinite(p[1]))
            at = int(piece[np.searchsorted(cells, one.goal)])
            assert (ranks[at], mine[at]) == best
            assert away[one.robot][one.goal] == mine[at]
            chosen += 1
    assert chosen > 40


def walk(moves: np.ndarray, start: int) -> dict[int, float]:
    """Steps from a planning cell to all others, by straight moves."""
    cols = moves.shape[1]
    steps = {start: 0.0}
    queue = deque([start])
    while queue:
        cell = queue.popleft()
        for k in range(4):
            if int(moves.reshape(-1)[cell]) >> k & 1:
                following = cell + DROW[k] * cols + DCOL[k]
                if following not in steps:
                    steps[following] = steps[cell] + 1
                    queue.append(following)
    return steps


@pytest.mark.parametrize("s_range", [1, 2, 4])
@pytest.mark.parametrize("side", [30, 90])
def test_a_step_of_the_game_costs_what_a_decision_of_algorithm_2_costs(
    s_range: int, side: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """O(sRange^2) points whatever the map, and no search at all but when it sets out."""
    searches = [0]
    searching = (
        (grid_search, "_search"),
        (distance_field, "_spread_out"),
        (jump_graph, "_search_all"),
    )
    for owner, name in searching:
        ordinary = getattr(owner, name)

        def counted(*arguments: Any, ordinary: Any = ordinary) -> Any:
            searches[0] += 1
            return ordinary(*arguments)

        monkeypatch.setattr(owner, name, counted)
    grid = parse_ascii("\n".join(["." * side] * side))
    # One robot, so that what is counted in a step is its own.
    state = world(PotentialFrontier(), grid, robots=1, range_m=float(s_range))
    most = 0
    games = drives = 0
    counted_before = 0
    for (one,) in moments(state, 1500):
        r, c = divmod(one.cell, side)
        decided = one.after.decisions - one.before.decisions
        points = one.after.points_checked - one.before.points
        assert decided <= 1
        most = max(most, points)
        if decided and min(r, c, side - 1 - r, side - 1 - c) >= s_range + 2:
            assert points == 20 * (s_range**2 + s_range)
        if one.after.drives > one.before.drives:
            drives += 1
            assert searches[0] > counted_before
        else:
            assert searches[0] == counted_before
            games += not one.after.driving
        counted_before = searches[0]
    assert most == 20 * (s_range**2 + s_range)
    assert games > 100
    assert drives > 0 or side > 30


def test_a_game_that_brings_nothing_ends() -> None:
    """A robot that never turns drives a lane for ever beside what it would only have to turn to."""

    def after(stale: int) -> float:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, "STALE_STEPS", stale)
            return conav.explore(
                conav.builtin_map("three-obstacles", width_m=20, height_m=20, seed=2),
                strategy=PotentialFrontier(epsilon=0.0, patience=10_000),
                seed=2,
                max_time_s=6000.0,
                **PAPER,
            ).metrics.coverage

    assert module.STALE_STEPS == 64
    assert after(64) == 1.0
    assert after(10_000) < 1.0


@pytest.mark.parametrize("motion", ["4-connected", "8-connected", "forward-turn"])
@pytest.mark.parametrize("name", ["office", "cave", "maze", "field", "three-obstacles"])
def test_finishes_and_is_accepted(name: str, motion: str, tmp_path: Path) -> None:
    size = 20 if name == "three-obstacles" else 8
    for robots, radio in ((1, "perfect"), (3, "perfect"), (3, 3.0), (2, "off")):
        grid = conav.builtin_map(name, width_m=size, height_m=size, seed=robots)
        out = tmp_path / "run.mcap"
        done = conav.explore(
            grid,
            strategy="potential-frontier",
            robots=robots,
            range_m=size / 4,
            motion=motion,
            radio=radio,
            seed=robots,
            out=out,
        )
        assert done.status == "done"
        assert done.metrics.coverage == 1.0
        report = conav.verify_exploration(conav.read_run(out))
        assert report.accepted, report.lines()


@pytest.mark.parametrize(
    "trouble",
    [{"loss": 0.3}, {"delay_s": 3.0}, {"faults": ["robot_1:dies:20", "robot_2:stalls:10:30"]}],
)
def test_finishes_with_faults_and_bad_radios(trouble: dict[str, Any], tmp_path: Path) -> None:
    for name in ("office", "cave"):
        grid = conav.builtin_map(name, width_m=8, height_m=8, seed=3)
        out = tmp_path / "run.mcap"
        done = conav.explore(
            grid, strategy="potential-frontier", range_m=2.0, seed=3, out=out, **trouble
        )
        assert done.status == "done"
        report = conav.verify_exploration(conav.read_run(out))
        assert report.accepted, report.lines()


@pytest.mark.parametrize(
    "file",
    [
        "navigation2/tb3_sandbox.yaml",
        "aws_small_house/map.yaml",
        "patrolling_sim/move_base_arena.yaml",
        "explore_bench/corner.yaml",
        "comprobo22/gauntlet.yaml",
    ],
)
def test_finishes_real_maps(file: str, tmp_path: Path) -> None:
    data = os.environ.get("CONAV_DATA")
    path = Path(data or "") / "maps" / file
    if not data or not path.is_file():
        pytest.skip("needs the real maps of the folder CONAV_DATA names")
    out = tmp_path / "run.mcap"
    done = conav.explore(path, strategy="potential-frontier", range_m=2.5, seed=3, out=out)
    assert done.status == "done"
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()


def test_nothing_is_said_beyond_what_all_robots_send() -> None:
    options: dict[str, Any] = {"seed": 5, "max_time_s": 30.0, **PAPER}
    one = conav.explore("three-obstacles", strategy="potential-frontier", **options).metrics
    two = conav.explore("three-obstacles", strategy="nearest", **options).metrics
    assert one.messages == two.messages == 31 * 6


def test_a_robot_shut_in_is_finished() -> None:
    picture = "###\n#a#\n###"
    starts = [(c + 0.5, r + 0.5) for r, c in ascii_starts(picture).values()]
    state = world(PotentialFrontier(), parse_ascii(picture), robots=1, starts=starts)
    events = engine_for(state).sense_and_decide(state, [])
    assert events.actions[0].finished


@pytest.mark.parametrize(
    "settings", [{"patience": 0}, {"patience": "soon"}, {"epsilon": 1.5}, {"tie": "forward"}]
)
def test_settings_out_of_range_name_the_page(settings: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r"docs/strategies/potential-frontier\.md") as caught:
        conav.explore("maze", strategy="potential-frontier", settings=settings)
    assert "\n" not in str(caught.value)
