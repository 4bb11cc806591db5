"""Plans over a known map see what they say, by routes that can be driven."""

from itertools import pairwise

import numpy as np
import pytest

from conav.exploration.bounds import known_map_plan as module
from conav.exploration.bounds.known_map_plan import known_map_plan
from conav.exploration.bounds.views import Places, Sight
from conav.exploration.types import ExplorationProblem
from conav.geometry.directions import DCOL, DROW, SQRT2
from conav.geometry.sight import visible_cells
from conav.maps.builtin.catalogue import builtin_map
from conav.robots.motion import MOTIONS
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells


def maze(motion: str, robots: int) -> tuple[ExplorationProblem, np.ndarray]:
    grid = builtin_map("maze", width_m=9.0, height_m=9.0, resolution=0.15)
    problem, _ = exploration_problem(grid, robots=robots, range_m=3.0, motion=motion, seed=1)
    return problem, observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)


def seen_along(problem: ExplorationProblem, observable: np.ndarray, cells: list[int]) -> set[int]:
    plan = problem.plan
    sight = Sight(plan, problem.robots[0].sensor)
    seen: set[int] = set()
    for cell in cells:
        row, col = divmod(cell, plan.lattice.cols)
        count = visible_cells(
            plan.walls,
            int(plan.lattice.fine_row[row]),
            int(plan.lattice.fine_col[col]),
            sight.limits,
            sight.lows,
            sight.highs,
            sight.out,
        )
        seen |= {c for c in sight.out[:count].tolist() if observable.reshape(-1)[c]}
    return seen


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("robots", [1, 3])
@pytest.mark.parametrize("share", [0.8, 1.0])
def test_routes_are_moves_and_see_enough(motion: str, robots: int, share: float) -> None:
    problem, observable = maze(motion, robots)
    needed = int(share * observable.sum())
    plan = known_map_plan(problem, observable, needed, np.random.default_rng(0), rounds=20)
    assert plan is not None
    cols = problem.plan.lattice.cols
    longest = 0.0
    for start, route in zip(problem.starts, plan.routes, strict=True):
        assert route[0] == start
        length = 0.0
        for a, b in pairwise(route):
            ways = [
                k
                for k in range(8)
                if problem.plan.moves.reshape(-1)[a] & (1 << k)
                and a + DROW[k] * cols + DCOL[k] == b
            ]
            assert ways
            length += 1.0 if ways[0] < 4 else SQRT2
        longest = max(longest, length)
    seen = seen_along(problem, observable, [cell for route in plan.routes for cell in route])
    assert len(seen) == plan.seen >= needed
    if not MOTIONS[motion].turn_costs_step:
        assert plan.steps == pytest.approx(longest)


def test_more_rounds_are_no_worse_and_seeds_repeat() -> None:
    problem, observable = maze("8-connected", 2)
    needed = int(observable.sum())
    plans = [
        known_map_plan(problem, observable, needed, np.random.default_rng(3), rounds=rounds)
        for rounds in (0, 40, 40)
    ]
    assert plans[1] == plans[2]
    assert plans[0] is not None
    assert plans[1] is not None
    assert plans[1].steps <= plans[0].steps


def test_maps_too_large_for_the_table_are_looked_at_from_fewer_places(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    problem, observable = maze("8-connected", 2)
    needed = int(observable.sum())
    monkeypatch.setattr(module, "MOST_BYTES", 2**15)
    plan = known_map_plan(problem, observable, needed, np.random.default_rng(0), rounds=5)
    assert plan is not None
    assert plan.seen == needed
    cells = [cell for route in plan.routes for cell in route]
    assert len(seen_along(problem, observable, cells)) == needed
    terrain = module._Terrain(problem, observable)
    assert len(terrain.lookouts) < len(Places.of(problem).cells) / 4


def test_no_plan_where_too_little_can_be_seen() -> None:
    problem, observable = maze("8-connected", 1)
    rng = np.random.default_rng(0)
    assert known_map_plan(problem, observable, int(observable.sum()) + 1, rng, rounds=1) is None
    nothing = known_map_plan(problem, np.zeros_like(observable), 0, rng, rounds=3)
    assert nothing is not None
    assert nothing.routes == ((problem.starts[0],),)
