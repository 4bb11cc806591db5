"""The best of many equilibria."""

import math

import numpy as np

from conav.planning.grid_game import gains, grid_equilibria
from conav.planning.grid_optimum import grid_optimum
from conav.planning.grid_paths import grid_paths
from conav.planning.grid_prices import OPEN, grid_game, grid_prices
from conav.planning.plan import plan
from conav.planning.prices import is_equilibrium
from conav.planning.types import PlanningProblem, PlanningRobot
from conav.status import Status


def test_the_best_start_is_an_equilibrium_and_no_start_was_better(scenes):
    problem = scenes.antipodal(6)
    found = plan(problem, "inash-restarts", seed=4, samples=300, starts=12)
    scenes.check(problem, found)
    assert found.status == Status.DONE
    assert found.epsilon.tolist() == [0.0] * 6
    sums = [
        sum(row[0] for row in entry["costs"])
        for entry in found.history
        if entry["stage"] in ("start", "last answers", "best start")
    ]
    assert found.counters["equilibria"] > 3
    assert len({round(total, 6) for total in sums}) > 1  # starts matter
    assert math.isclose(found.costs.sum(), min(sums), abs_tol=1e-6)
    one = plan(problem, "inash-restarts", seed=4, samples=300, starts=0)
    assert found.costs.sum() <= one.costs.sum() + 1e-9
    again = plan(problem, "inash-restarts", seed=4, samples=300, starts=12)
    assert np.array_equal(found.costs, again.costs)


def test_a_goal_in_a_wall_is_infeasible(scenes):
    robot = PlanningRobot("a", (2.0, 2.0), "F goal", scenes.disc("goal", 30, 30), 0.4)
    problem = PlanningProblem(scenes.square, (robot,), 60.0)
    assert plan(problem, "inash-restarts").status == Status.INFEASIBLE


def test_equilibria_of_a_grid_lie_between_its_prices():
    row = grid_prices(OPEN, 2)
    built = grid_game(OPEN, 2)
    numbers = [{tuple(path.tolist()): k for k, path in enumerate(own)} for own in built.paths]
    found = grid_equilibria(OPEN, starts=20, seed=3)
    assert len(found) > 10
    inside = 0
    for one in found:
        assert gains(grid_paths(OPEN), one.paths) == [0, 0, 0]
        assert sum(one.costs) >= row.found.optimum
        keys = [tuple(path.tolist()) for path in one.paths]
        if all(key in own for key, own in zip(keys, numbers, strict=True)):
            inside += 1
            assert sum(one.costs) <= row.found.worst_equilibrium
            profile = tuple(own[key] for key, own in zip(keys, numbers, strict=True))
            assert is_equilibrium(built.game, profile)
    assert inside > 5
    assert sum(found[0].costs) == sum(grid_optimum(OPEN).costs)
