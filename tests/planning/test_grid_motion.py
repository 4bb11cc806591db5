"""Grid motion: against a space-time A* of these tests, and other people's solvers."""

import heapq
import os
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.planning.conflict_search import conflict_based_search
from conav.planning.grid_game import gains, grid_equilibrium, solo_costs
from conav.planning.grid_motion import (
    GridProblem,
    apart,
    cost,
    grid_of_text,
    read_grid_scenario,
)
from conav.planning.grid_optimum import GridModel, grid_optimum
from conav.planning.grid_paths import Bars, grid_paths, past
from conav.planning.grid_prices import CORRIDOR_WITH_BAY, CROSS, OPEN, RING
from conav.status import Status

DATA = os.environ.get("CONAV_DATA")


def scenario(name):
    if DATA is None or not (Path(DATA) / "movingai" / "mapf" / name).is_file():
        pytest.skip("CONAV_DATA has no movingai/mapf")
    return Path(DATA) / "movingai" / "mapf" / name


def a_star(problem, start, goal, others):
    """Steps until a robot can be at its goal for good, past these paths; None within no horizon."""
    rows, cols = problem.free.shape

    def where(path, step):
        return int(path[min(step, len(path) - 1)])

    last = max([0, *(len(path) for path in others)])
    heap = [(0, 0, start)]
    seen = set()
    while heap:
        _, step, cell = heapq.heappop(heap)
        if (step, cell) in seen or step > problem.horizon:
            continue
        seen.add((step, cell))
        if cell == goal and all(
            where(path, later) != goal for path in others for later in range(step, last + 1)
        ):
            return step
        row, col = divmod(cell, cols)
        for dr, dc in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)):
            r, c = row + dr, col + dc
            if not (0 <= r < rows and 0 <= c < cols and problem.free[r, c]):
                continue
            to = r * cols + c
            if any(where(path, step + 1) == to for path in others):
                continue
            if any(where(p, step + 1) == cell and where(p, step) == to for p in others):
                continue
            away = abs(r - goal // cols) + abs(c - goal % cols)
            heapq.heappush(heap, (step + 1 + away, step + 1, to))
    return None


def joint_optimum(problem):
    """The least sum of costs by Dijkstra over all robots' cells together; None when there is none.

    A robot pays a step unless it is at its goal for good: the state says who has finished.
    """
    near = grid_paths(problem).near.tolist()
    size = problem.free.size
    start = (problem.starts, tuple(False for _ in problem.starts))
    best = {start: 0}
    heap = [(0, 0, start)]
    made = 0
    while heap:
        total, _, (cells, done) = heapq.heappop(heap)
        if total > best[cells, done]:
            continue
        if all(done):
            return total
        # Whoever is at its goal may finish now, and then stays.
        for finished in product(
            *(
                (True,) if done[i] else ((False, True) if cell == problem.goals[i] else (False,))
                for i, cell in enumerate(cells)
            )
        ):
            if finished == done:
                moves = product(
                    *(
                        (cell,) if done[i] else tuple(n for n in near[cell] if n < size)
                        for i, cell in enumerate(cells)
                    )
                )
                price = sum(not one for one in done)
            else:
                moves, price = (cells,), 0
            for after in moves:
                if len(set(after)) < len(after) or any(
                    finished == done and after[i] == cells[j] and after[j] == cells[i]
                    for i in range(len(cells))
                    for j in range(i)
                ):
                    continue
                state = (tuple(after), finished)
                if total + price < best.get(state, 1 << 30):
                    best[state] = total + price
                    made += 1
                    heapq.heappush(heap, (total + price, made, state))
    return None


def random_problem(seed, robots):
    rng = np.random.default_rng(seed)
    free = rng.random((3, 4)) < 0.8
    cells = np.flatnonzero(free)
    if len(cells) < robots + 1:
        return None
    starts = tuple(int(c) for c in rng.choice(cells, robots, replace=False))
    goals = tuple(int(c) for c in rng.choice(cells, robots, replace=False))
    return GridProblem(free, starts, goals, 24)


@given(seed=st.integers(0, 2**32 - 1), robots=st.integers(1, 3))
@settings(max_examples=60, deadline=None)
def test_optimum_and_equilibrium_on_small_grids(seed, robots):
    problem = random_problem(seed, robots)
    if problem is None:
        return
    expected = joint_optimum(problem)
    found = grid_optimum(problem, max_nodes=300)
    if expected is None:
        assert found.status in (Status.INFEASIBLE, Status.OUT_OF_BUDGET)
        assert not found.paths
        return
    assert found.status != Status.INFEASIBLE
    if found.status == Status.DONE:
        assert sum(found.costs) == found.lower_bound == expected
    assert found.lower_bound <= expected
    solo = solo_costs(grid_paths(problem))
    assert solo is not None
    assert sum(solo) <= expected
    plan = grid_equilibrium(problem, seed=seed % 1000)
    if plan.status == Status.DONE:
        assert sum(plan.costs) >= expected
        assert all(apart(a, b) for i, a in enumerate(plan.paths) for b in plan.paths[:i])
        assert gains(grid_paths(problem), plan.paths) == [0] * robots
        for robot in range(robots):
            others = [path for i, path in enumerate(plan.paths) if i != robot]
            alone = a_star(problem, problem.starts[robot], problem.goals[robot], others)
            assert alone == plan.costs[robot]


def test_most_small_grids_are_proved():
    proved = solvable = 0
    for seed in range(40):
        problem = random_problem(seed, 3)
        if problem is None or joint_optimum(problem) is None:
            continue
        solvable += 1
        proved += grid_optimum(problem, max_nodes=300).status == Status.DONE
    assert solvable > 15
    assert proved >= 0.9 * solvable


@pytest.mark.parametrize(
    ("problem", "optimum"), [(CORRIDOR_WITH_BAY, 11), (CROSS, 9), (RING, 8), (OPEN, 10)]
)
def test_known_optima(problem, optimum):
    found = grid_optimum(problem)
    assert (found.status, found.lower_bound, sum(found.costs)) == (Status.DONE, optimum, optimum)


def test_cheapest_path_within_bars_equals_the_plain_search():
    rng = np.random.default_rng(5)
    checked = 0
    for seed in range(60):
        problem = random_problem(seed, 3)
        if problem is None:
            continue
        grid = grid_paths(problem)
        others = []
        for robot in (1, 2):
            path = grid.cheapest(robot, Bars())
            if path is not None:
                others.append(np.concatenate([np.repeat(path[:1], rng.integers(0, 3)), path]))
        found = grid.cheapest(0, past(others))
        expected = a_star(problem, problem.starts[0], problem.goals[0], others)
        assert (None if found is None else cost(found)) == expected
        if found is not None:
            assert all(apart(found, other) for other in others)
            checked += 1
    assert checked > 20


def test_a_budget_that_ends_gives_bounds():
    text = """
    abc.
    ....
    ....

    CBA.
    ....
    ....
    """
    problem = grid_of_text(text, horizon=30)
    best = joint_optimum(problem)
    none = conflict_based_search(GridModel(grid_paths(problem)), max_nodes=1)
    assert not none.proved
    assert none.paths is None
    assert none.lower_bound <= best
    found = grid_optimum(problem, max_nodes=1)
    if found.status == Status.OUT_OF_BUDGET:
        assert found.lower_bound <= best <= sum(found.costs)
        assert "gap" in found.reason
    assert grid_optimum(problem).lower_bound == best


def test_statuses():
    assert grid_optimum(grid_of_text("a#A", horizon=9)).status == Status.INFEASIBLE
    assert grid_equilibrium(grid_of_text("a#A", horizon=9)).status == Status.INFEASIBLE
    swap = grid_of_text("ab\n\nBA", horizon=4)
    assert grid_equilibrium(swap).status == Status.OUT_OF_BUDGET
    assert grid_optimum(swap).status == Status.INFEASIBLE  # proved: the tree has an end


def test_faults_are_named():
    with pytest.raises(InputError, match="robot a"):
        grid_of_text("a..", horizon=3)
    with pytest.raises(InputError, match="different lengths"):
        grid_of_text("a..\nA.", horizon=3)
    with pytest.raises(InputError, match="is not free"):
        GridProblem(np.array([[True, False]]), (0,), (1,), 3)
    with pytest.raises(InputError, match="same goal"):
        GridProblem(np.ones((1, 4), bool), (0, 1), (3, 3), 3)


@pytest.mark.parametrize("robots", [4, 10])
def test_between_solo_costs_and_equilibrium_on_a_benchmark(robots):
    problem = read_grid_scenario(scenario("random-32-32-20-random-1.scen"), robots)
    solo = solo_costs(grid_paths(problem))
    equilibrium = grid_equilibrium(problem)
    optimum = grid_optimum(problem, max_nodes=200)
    assert solo is not None
    assert optimum.status == Status.DONE
    assert sum(solo) <= sum(optimum.costs) <= sum(equilibrium.costs)
    for robot, path in enumerate(equilibrium.paths):
        others = [other for i, other in enumerate(equilibrium.paths) if i != robot]
        goal = problem.goals[robot]
        assert a_star(problem, problem.starts[robot], goal, others) == cost(path)


@pytest.mark.parametrize("robots", [4, 10])
def test_optimum_equals_that_of_pymapf(robots):
    pymapf = pytest.importorskip("pymapf", reason="pymapf, an oracle, is not installed")
    problem = read_grid_scenario(scenario("random-32-32-20-random-1.scen"), robots)
    cols = problem.free.shape[1]
    agents = [
        pymapf.Agent(str(i), divmod(start, cols), divmod(goal, cols))
        for i, (start, goal) in enumerate(zip(problem.starts, problem.goals, strict=True))
    ]
    grid = pymapf.GridMap([[0 if cell else 1 for cell in row] for row in problem.free.tolist()])
    solution = pymapf.solve(pymapf.MAPFProblem(grid, agents))
    expected = sum(steps_until_arrival(path) for path in solution.paths.values())
    assert sum(grid_optimum(problem, max_nodes=200).costs) == expected


@pytest.mark.parametrize("robots", [4, 10, 15])
def test_optimum_equals_that_of_w9_pathfinding(robots):
    envs = pytest.importorskip(
        "w9_pathfinding.envs", reason="w9-pathfinding, an oracle, is not installed"
    )
    from w9_pathfinding.mapf import CBS

    problem = read_grid_scenario(scenario("random-32-32-20-random-1.scen"), robots)
    cols = problem.free.shape[1]
    weights = [[1 if cell else -1 for cell in row] for row in problem.free.tolist()]
    solver = CBS(envs.Grid(weights, edge_collision=True))
    starts, goals = (
        [(cell % cols, cell // cols) for cell in cells] for cells in (problem.starts, problem.goals)
    )
    paths = solver.mapf(starts, goals, max_length=300, max_time=60)
    found = grid_optimum(problem, max_nodes=500)
    assert found.status == Status.DONE
    assert sum(found.costs) == sum(steps_until_arrival(path) for path in paths)


def steps_until_arrival(path):
    last = len(path) - 1
    while last > 0 and tuple(path[last - 1]) == tuple(path[last]):
        last -= 1
    return last
