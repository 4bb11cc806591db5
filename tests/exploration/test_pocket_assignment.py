"""Pockets as tasks from the beginning, and the assignment by distance advantage."""

from itertools import pairwise, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import conav
from conav.errors import InputError
from conav.exploration.belief import OPEN, STOOD, TARGET, Belief
from conav.exploration.catalogue import make_strategy
from conav.exploration.frontier_tasks import Tasks, find_tasks
from conav.exploration.nearest import Nearest
from conav.exploration.pocket_assignment import assign_tasks, mean_distances
from conav.exploration.types import TeamView
from conav.geometry.distance_field import fill_distances
from conav.geometry.ground import Ground
from conav.geometry.jump_graph import JumpGraph
from conav.geometry.sight import segment_is_clear
from conav.maps.builtin.catalogue import builtin_map
from conav.maps.occupancy_grid import UNKNOWN
from conav.simulation.engine import engine_for
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.world_state import WorldState, new_world


def explored(steps: int, seed: int = 1, **more) -> WorldState:
    """An office some way into a run of `nearest`."""
    grid = builtin_map("office", width_m=16, height_m=12, seed=seed)
    problem, _ = exploration_problem(grid, robots=3, range_m=3.0, seed=seed, **more)
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, Nearest(), seen)
    engine = engine_for(state)
    for _ in range(steps):
        events = engine.sense_and_decide(state, [])
        engine.move(state, events.actions)
    engine.sense_and_decide(state, [])
    return state


def distance_fields(belief: Belief, starts: np.ndarray) -> np.ndarray:
    """Path lengths [planning cells] from each start to every cell over known moves, inf if none."""
    fields = np.empty((len(starts), belief.moves.size))
    for start, field in zip(starts, fields, strict=True):
        fill_distances(belief.ground, np.array([start], dtype=np.int64), field)
    return fields


def view_of(state: WorldState) -> TeamView:
    return engine_for(state)._view(state, 0)


@pytest.mark.parametrize("steps", [0, 40, 120])
@pytest.mark.parametrize("cell_m", [0.3, 0.25, 0.1])
def test_places_are_what_they_say(steps: int, cell_m: float) -> None:
    state = explored(steps, cell_m=cell_m)
    view = view_of(state)
    belief, lattice = view.belief, view.lattice
    tasks = find_tasks(view, state.cells)
    fields = distance_fields(belief, state.cells)
    assert tasks.first[0] == 0
    assert tasks.first[-1] == len(tasks.places)
    marks = belief.marks.reshape(-1)
    clear = np.where(belief.cells == 1, 1, 0).astype(np.uint8)
    stood_on: set[int] = set()
    for task in range(len(tasks)):
        places = tasks.places[tasks.first[task] : tasks.first[task + 1]]
        assert len(set(places.tolist())) == len(places) > 0
        assert np.isfinite(fields[:, places]).any(axis=0).all()
        hidden = int(tasks.looks_for[task])
        if hidden < 0:
            assert (marks[places] & TARGET != 0).all()
            assert not stood_on & set(places.tolist())
            stood_on |= set(places.tolist())
            continue
        assert belief.cells.reshape(-1)[hidden] == UNKNOWN
        r, c = divmod(hidden, lattice.fine_cols)
        for place in places.tolist():
            assert marks[place] & OPEN
            assert not marks[place] & STOOD
            row, col = divmod(place, lattice.cols)
            assert segment_is_clear(clear, r, c, lattice.fine_row[row], lattice.fine_col[col])
    wanted = np.flatnonzero((marks & TARGET != 0) & np.isfinite(fields).any(axis=0))
    assert stood_on == set(wanted.tolist())


def test_pockets_are_tasks_long_before_the_end() -> None:
    tasks = find_tasks(view_of(state := explored(80)), state.cells)
    assert (tasks.looks_for >= 0).sum() >= 2
    assert (tasks.looks_for < 0).sum() >= 2


def test_costs_are_those_of_the_nearest_place() -> None:
    state = explored(60)
    view = view_of(state)
    tasks = find_tasks(view, state.cells)
    costs = tasks.costs
    fields = distance_fields(view.belief, state.cells)
    for robot in range(3):
        for task in range(len(tasks)):
            places = tasks.places[tasks.first[task] : tasks.first[task + 1]]
            assert costs[robot, task] == fields[robot, places].min()
            if np.isfinite(costs[robot, task]):
                place = int(tasks.nearest[robot, task])
                assert fields[robot, place] == costs[robot, task]


def test_advantage_is_the_mean_distance_from_the_others() -> None:
    state = explored(60)
    view = view_of(state)
    tasks = find_tasks(view, state.cells)
    found = mean_distances(tasks)
    nearest = tasks.costs.argmin(axis=0)
    total = np.zeros(len(tasks))
    for other in range(len(tasks)):
        place = int(tasks.nearest[nearest[other], other])
        field = distance_fields(view.belief, np.array([place]))
        total += [field[0, tasks.places[one:end]].min() for one, end in pairwise(tasks.first)]
    assert found == pytest.approx(total / (len(tasks) - 1))


@pytest.mark.parametrize("radio", ["perfect", 5.0])
def test_what_is_kept_does_not_matter(radio: str | float) -> None:
    """Tasks and mean distances in the course of a run against those of a belief without memory."""
    grid = builtin_map("office", width_m=16, height_m=12, seed=3)
    problem, _ = exploration_problem(grid, robots=3, range_m=3.0, seed=3, radio=radio)
    seen = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    state = new_world(problem, Nearest(), seen)
    engine = engine_for(state)
    kept = compared = 0
    for step in range(120):
        events = engine.sense_and_decide(state, [])
        if step % 4 == 0:
            view = view_of(state)
            forgetful = view._replace(belief=view.belief.copy())
            kept += len(view.belief.derived)
            tasks, anew = find_tasks(view, state.cells), find_tasks(forgetful, state.cells)
            for name in ("places", "first", "looks_for"):
                assert np.array_equal(getattr(tasks, name), getattr(anew, name))
            assert np.array_equal(tasks.costs, anew.costs)
            if len(tasks) > 1:
                compared += 1
                assert np.array_equal(mean_distances(tasks), mean_distances(anew))
        engine.move(state, events.actions)
    assert compared > 15
    assert kept > 0


def hand_made(costs: list[list[float]]) -> Tasks:
    """Task j is done at planning cell j."""
    table = np.array(costs, dtype=np.float64)
    n = table.shape[1]
    nearest = np.tile(np.arange(n), (len(table), 1))
    paths = JumpGraph(Ground((1, n)), np.arange(n + 1), np.arange(n))
    return Tasks(np.arange(n), np.arange(n + 1), np.arange(n) - 1, table, nearest, paths)


numbers = st.one_of(st.just(float("inf")), st.integers(-5, 20).map(float))


@given(
    st.integers(1, 4).flatmap(
        lambda n: st.lists(st.lists(numbers, min_size=n, max_size=n), min_size=1, max_size=4)
    )
)
def test_assignment_against_all_permutations(costs: list[list[float]]) -> None:
    tasks = hand_made(costs)
    table = np.array(costs)
    orders = assign_tasks(tasks, table)
    robots, n = table.shape
    best: tuple[int, float] | None = None  # fewest left out, then least total
    slots = list(range(n)) + [-1] * robots
    for chosen in set(permutations(slots, robots)):
        values = [table[i, j] for i, j in enumerate(chosen) if j >= 0]
        if np.isinf(values).any():
            continue
        key = (robots - len(values), float(sum(values)))
        best = key if best is None else min(best, key)
    assert best is not None
    # Robots beyond those go to their cheapest task, whoever else does.
    distinct: dict[int, list[int]] = {}
    for robot, order in enumerate(orders):
        if order.goal < 0:
            assert np.isinf(table[robot]).all()
        else:
            assert np.isfinite(table[robot, order.goal])
            assert order.looks_for == order.goal - 1
            distinct.setdefault(order.goal, []).append(robot)
    assert len(distinct) == robots - best[0]
    alone = sum(min(table[robot, goal] for robot in who) for goal, who in distinct.items())
    if all(len(who) == 1 for who in distinct.values()):
        assert alone == pytest.approx(best[1])


@pytest.mark.parametrize("name", ["office", "cave", "maze"])
@pytest.mark.parametrize(("robots", "radio"), [(1, "perfect"), (4, "perfect"), (4, 6.0)])
def test_finishes_and_is_accepted(name: str, robots: int, radio, tmp_path) -> None:
    path = tmp_path / "run.mcap"
    done = conav.explore(
        builtin_map(name, width_m=14, height_m=12, seed=1),
        strategy="pocket-assignment",
        robots=robots,
        range_m=4.0,
        radio=radio,
        seed=2,
        out=path,
    )
    assert done.status == "done"
    report = conav.verify_exploration(conav.read_run(path))
    assert report.accepted, report.lines()


def test_pockets_make_the_end_earlier() -> None:
    """The reason for the strategy, on an office and four teams; the runs are always the same."""
    times = {
        name: sum(
            conav.explore("office", strategy=name, robots=3, range_m=3.5, seed=seed).metrics.time_s
            for seed in range(3)
        )
        for name in ("hungarian", "pocket-assignment")
    }
    assert times["pocket-assignment"] < 0.8 * times["hungarian"]


def test_a_negative_weight_is_refused() -> None:
    with pytest.raises(InputError, match=r"pocket-assignment\.md"):
        make_strategy("pocket-assignment", {"advantage": "-1"})
