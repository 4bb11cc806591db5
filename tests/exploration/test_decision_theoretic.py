"""Utility less cost against Burgard's steps done slowly; lost teammates; end to end."""

from math import inf, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conav
from conav.errors import InputError
from conav.exploration import decision_theoretic
from conav.exploration.decision_theoretic import DecisionMemory, DecisionTheoretic
from conav.exploration.frontier_targets import Targets
from conav.exploration.types import TeamView
from conav.exploration.utility_reduction import Seen, assign_by_utility, probability
from conav.maps.ascii_art import ascii_starts, parse_ascii
from conav.messages.message import Message
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import new_world

COLS = 10
NOBODY = np.empty(0, np.int64)


def fading(reach: float) -> Seen:
    """As decision-theoretic coordination has it."""
    return Seen(reach, np.ones(1), slope=1.0)


NOTHING = Seen(1.0, np.zeros(1))


def chance(seen: Seen, distance: float) -> float:
    """The probability P(d)."""
    if distance > seen.reach:
        return 0.0
    part = int(distance / seen.reach * len(seen.share))
    return float([*seen.share, seen.share[-1]][part]) - seen.slope * distance / seen.reach


def targets_with(cells: list[int], costs: list[list[float]]) -> Targets:
    return Targets(np.array(cells), np.arange(len(cells)), len(cells), np.array(costs))


def slowly(
    cells: list[int],
    costs: list[list[float]],
    beta: float,
    seen: Seen,
    taken: list[int],
) -> list[int]:
    """The steps of the paper one by one."""

    def gap(a: int, b: int) -> float:
        return sqrt((a // COLS - b // COLS) ** 2 + (a % COLS - b % COLS) ** 2)

    utility = dict.fromkeys(cells, 1.0)
    for place in taken:
        for cell in cells:
            utility[cell] -= chance(seen, gap(cell, place))
    goals = [-1] * len(costs)
    while True:
        best: tuple[float, int, int] | None = None
        for robot, row in enumerate(costs):
            if goals[robot] >= 0:
                continue
            for cell, cost in zip(cells, row, strict=True):
                if cost < inf and (best is None or utility[cell] - beta * cost > best[0]):
                    best = (utility[cell] - beta * cost, robot, cell)
        if best is None:
            return goals
        _, robot, cell = best
        goals[robot] = cell
        for other in cells:
            utility[other] -= chance(seen, gap(other, cell))


SHARES = np.array([1.0, 0.75, 0.5, 0.5, 0.25])


@pytest.mark.parametrize("beta", [0.0, 0.25, 1.0, 7.0])
@pytest.mark.parametrize("seen", [fading(1.5), fading(4.0), Seen(4.0, SHARES)])
def test_assignments_are_those_of_the_paper(beta: float, seen: Seen) -> None:
    rng = np.random.default_rng(int(beta * 8 + seen.reach))
    without = repeated = 0
    for _ in range(150):
        robots, count = int(rng.integers(1, 5)), int(rng.integers(1, 8))
        cells = sorted(rng.choice(COLS * COLS, count, replace=False).tolist())
        costs = rng.integers(1, 5, (robots, count)) / 4
        costs[rng.random(costs.shape) < rng.choice([0.0, 0.5])] = inf
        taken = rng.choice(COLS * COLS, rng.integers(0, 3)).tolist()
        goals = assign_by_utility(
            targets_with(cells, costs.tolist()),
            costs,
            beta,
            COLS,
            seen,
            np.array(taken, np.int64),
        ).tolist()
        assert goals == slowly(cells, costs.tolist(), beta, seen, taken)
        without += -1 in goals
        repeated += len({goal for goal in goals if goal >= 0}) < len(goals) - goals.count(-1)
    assert without > 2
    assert repeated > 2


def test_a_target_given_away_is_left_to_one() -> None:
    # Both are nearest to cell 0; 1 is close to it, 9 is not. Costs in sensor ranges of 4 cells.
    targets = targets_with([0, 1, 9], [[0.25, 0.5, 1.0], [0.5, 0.75, 1.2]])
    assert assign_by_utility(targets, targets.costs, 1.0, COLS, fading(4), NOBODY).tolist() == [
        0,
        9,
    ]
    # Where nothing is seen from anywhere both take it.
    assert assign_by_utility(targets, targets.costs, 1.0, COLS, NOTHING, NOBODY).tolist() == [0, 0]


def test_taken_cells_make_what_is_near_less_useful() -> None:
    targets = targets_with([0, 9], [[0.5, 0.6]])
    assert assign_by_utility(targets, targets.costs, 1.0, COLS, fading(4), NOBODY).tolist() == [0]
    taken = np.array([1])
    assert assign_by_utility(targets, targets.costs, 1.0, COLS, fading(4), taken).tolist() == [9]
    # Rows count too: place 11 is sqrt(2) from cell 0.
    taken = np.array([11])
    assert assign_by_utility(targets, targets.costs, 1.0, COLS, fading(1.4), taken).tolist() == [0]
    assert assign_by_utility(targets, targets.costs, 1.0, COLS, fading(4), taken).tolist() == [9]


def test_ties_go_to_the_lower_robot_then_to_the_lower_cell() -> None:
    targets = targets_with([3, 8], [[1.0, 1.0], [1.0, 1.0]])
    assert assign_by_utility(targets, targets.costs, 1.0, COLS, fading(2), NOBODY).tolist() == [
        3,
        8,
    ]


def test_beta_0_ignores_distance() -> None:
    targets = targets_with([0, 5, 9], [[9.0, 1.0, 5.0], [1.0, 2.0, 30.0]])
    shuffled = targets_with([0, 5, 9], [[1.0, 7.0, 2.0], [9.0, 1.0, 1.0]])
    assert assign_by_utility(targets, targets.costs, 0.0, COLS, fading(3), NOBODY).tolist() == (
        assign_by_utility(shuffled, shuffled.costs, 0.0, COLS, fading(3), NOBODY).tolist()
    )


def test_beta_0_does_not_send_a_robot_where_it_cannot_go() -> None:
    targets = targets_with([0, 5], [[inf, 3.0]])
    assert assign_by_utility(targets, targets.costs, 0.0, COLS, NOTHING, NOBODY).tolist() == [5]


def test_a_beta_that_overflows_is_refused_or_works() -> None:
    """It must not go round for ever because everything is worth minus infinity."""
    targets = targets_with([0, 5], [[3.0, 2.0], [40.0, 30.0]])
    beta = float(np.finfo(float).max)
    try:
        DecisionTheoretic(beta=beta)
    except ValueError:
        return
    assert assign_by_utility(targets, targets.costs, beta, COLS, NOTHING, NOBODY).tolist() == [5, 5]


def asked(
    picture: str,
    strategy: DecisionTheoretic,
    memory: DecisionMemory,
    step: int = 0,
    **more: Any,
) -> tuple[DecisionMemory, list[Message], int]:
    """What robot 0 does in the first step, with this memory, hearing only itself."""
    starts = [(c + 0.5, r + 0.5) for r, c in ascii_starts(picture).values()]
    problem, _ = exploration_problem(
        parse_ascii(picture),
        robots=len(starts),
        starts=starts,
        radio="off",
        **({"range_m": 3.0} | more),
    )
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, strategy, seen)
    engine_for(state).sense_and_decide(state, [])
    view = TeamView(
        0,
        0.0,
        0,
        problem.robots[0],
        int(state.cells[0]),
        0,
        state.beliefs[0],
        problem.plan.lattice,
        state.heard_cell[0],
        np.zeros(5, np.int32),  # the lost were heard just before
        state.in_touch[0],
    )
    view = view._replace(step=step, time_s=float(step))
    new, action, said = strategy.step(memory, view, [], np.random.default_rng(0))
    assert isinstance(new, DecisionMemory)
    return new, list(said), action.goal


def corridor(inside: str) -> str:
    wall = "#" * (len(inside) + 2)
    return f"{wall}\n#{inside}#\n{wall}"


MIDDLE = corridor(".......a.......")  # its targets are 3 to the left and 3 to the right


def ends(memory: DecisionMemory, **more: Any) -> int:
    """The column robot 0 goes to in the corridor."""
    new, _, goal = asked(MIDDLE, DecisionTheoretic(), memory, **more)
    assert new.assignments == 1
    return goal % 17


def test_last_targets_of_lost_teammates_lower_utilities() -> None:
    row = 17
    assert ends(DecisionMemory()) == 5
    assert ends(DecisionMemory(sent={1: row + 4})) == 11
    assert ends(DecisionMemory(sent={1: row + 12})) == 5
    assert ends(DecisionMemory(sent={1: row + 4, 2: row + 11})) == 5
    # Its own last target does not count.
    assert ends(DecisionMemory(sent={0: row + 5})) == 5


def test_after_a_long_silence_last_targets_are_nobodys() -> None:
    row = 17
    sent = {1: row + 4}
    assert ends(DecisionMemory(sent=sent), step=120) == 11
    assert ends(DecisionMemory(sent=sent), step=121) == 5


def test_a_lost_teammate_without_a_target_lowers_nothing() -> None:
    # One row: cell -1 would be row -1 and the last column, near the target on the right.
    picture = ".......a....."
    for sent in ({1: 3}, {1: 3, 2: -1, 3: -1, 4: -1}):
        _, _, goal = asked(picture, DecisionTheoretic(), DecisionMemory(sent=sent))
        assert goal == 10


def test_it_remembers_where_all_were_sent() -> None:
    memory, _, goal = asked(MIDDLE, DecisionTheoretic(), DecisionMemory(sent={2: 20}))
    assert memory.sent == {0: goal, 2: 20}


def test_a_teammate_that_goes_out_of_reach_is_remembered() -> None:
    """A whole run with a short radio, watched: what is taken is what the lost were sent to."""
    taken: list[list[int]] = []
    problem, _ = exploration_problem(
        conav.builtin_map("cave", width_m=12, height_m=12, seed=2),
        robots=4,
        range_m=2.0,
        radio=3.0,
        seed=2,
    )
    strategy = DecisionTheoretic()
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, strategy, seen)
    engine = engine_for(state)
    original = decision_theoretic.assign_by_utility

    def watched(*given: Any) -> np.ndarray:
        taken.append(given[-1].tolist())
        return original(*given)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(decision_theoretic, "assign_by_utility", watched)
        for _ in range(200):
            events = engine.sense_and_decide(state, [])
            engine.move(state, events.actions)
    assert any(taken)
    assert not all(taken)
    assert all(goal >= 0 for lost in taken for goal in lost)


def given_to_the_rule(range_m: float, cell_m: float, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    calls: list[Any] = []

    def watched(*given: Any) -> np.ndarray:
        calls.append(given)
        return assign_by_utility(*given)

    monkeypatch.setattr(decision_theoretic, "assign_by_utility", watched)
    asked(MIDDLE, DecisionTheoretic(beta=2.0), DecisionMemory(), range_m=range_m, cell_m=cell_m)
    return calls[-1]


def test_the_probability_of_seeing_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    targets, values, beta, _, seen, _ = given_to_the_rule(4.0, 1.0, monkeypatch)
    distance = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 100.0]
    chances = [probability(away, *seen) for away in distance]
    assert chances == [1.0, 0.75, 0.5, 0.25, 0.0, 0.0, 0.0]
    assert beta == 2.0
    # Costs in sensor ranges.
    assert targets.costs.tolist() == [[4.0, 4.0]]
    assert values.tolist() == [[1.0, 1.0]]


def test_lengths_are_in_sensor_ranges_whatever_the_cell(monkeypatch: pytest.MonkeyPatch) -> None:
    _, values, _, _, seen, _ = given_to_the_rule(4.0, 0.5, monkeypatch)
    assert [probability(away, *seen) for away in (0.0, 4.0, 8.0)] == [1.0, 0.5, 0.0]
    assert np.allclose(values.min(), 1.0, atol=0.2)


def test_with_a_huge_beta_everybody_goes_to_its_nearest(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, _ = exploration_problem(
        conav.builtin_map("office", width_m=10, height_m=10, seed=1), robots=4, range_m=2.0, seed=1
    )
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    shared: dict[float, int] = {}
    for beta in (1e6, 1.0):
        calls: list[tuple[Targets, list[int]]] = []

        def watched(*given: Any, calls: list[Any] = calls) -> np.ndarray:
            goals = assign_by_utility(*given)
            calls.append((given[0], goals.tolist()))
            return goals

        monkeypatch.setattr(decision_theoretic, "assign_by_utility", watched)
        state = new_world(problem, DecisionTheoretic(beta=beta), seen)
        engine = engine_for(state)
        for _ in range(60):
            engine.move(state, engine.sense_and_decide(state, []).actions)
        nearest = 0
        for targets, goals in calls:
            for row, goal in zip(targets.costs, goals, strict=True):
                nearest += goal < 0 or row[targets.cells.tolist().index(goal)] == row.min()
        shared[beta] = 4 * len(calls) - nearest
        assert len(calls) > 5
    assert shared[1e6] == 0
    assert shared[1.0] > 0


@pytest.mark.parametrize(
    "settings", [{"beta": -0.1}, {"beta": "inf"}, {"beta": "nan"}, {"beta": "much"}]
)
def test_settings_out_of_range_name_the_page(settings: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r"docs/strategies/decision-theoretic\.md") as caught:
        conav.explore("maze", strategy="decision-theoretic", settings=settings)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("beta", [0.0, 0.01, 50.0])
def test_finishes_whatever_beta(beta: float) -> None:
    grid = conav.builtin_map("office", width_m=9, height_m=9, seed=3)
    done = conav.explore(
        grid,
        strategy="decision-theoretic",
        settings={"beta": beta},
        robots=3,
        range_m=1.8,
        seed=3,
        max_time_s=5000.0,
    )
    assert done.status == "done"


@pytest.mark.parametrize("name", ["office", "cave", "maze", "three-obstacles"])
@pytest.mark.parametrize("radio", ["perfect", 6.0])
def test_finishes_and_is_accepted(name: str, radio: str | float, tmp_path: Path) -> None:
    size = 20 if name == "three-obstacles" else 8
    for robots in (1, 2, 4) if radio == "perfect" else (2, 4):
        grid = conav.builtin_map(name, width_m=size, height_m=size, seed=robots)
        out = tmp_path / f"{robots}.mcap"
        done = conav.explore(
            grid,
            strategy="decision-theoretic",
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
