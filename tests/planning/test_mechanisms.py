"""Rules against anarchy: what they do to all equilibria of small games."""

import numpy as np
import pytest

from conav.planning.grid_prices import CORRIDOR_WITH_BAY, CROSS, OPEN, RING, grid_game
from conav.planning.mechanisms import (
    equilibria_under,
    marginal_delay,
    outcomes,
    right_of_way,
    side_payments,
    team_cost,
    tolls,
)
from conav.planning.prices import equilibria, prices, social_optima

from .test_prices import random_game


def some_games():
    for seed in range(60):
        game = random_game(seed, 2 + seed % 3, 5, 1)
        if social_optima(game):
            yield game


def test_payments_for_others_costs_change_no_equilibrium():
    for game in some_games():
        same = list(equilibria(game))
        pivot = marginal_delay(game)
        assert equilibria_under(game, pivot) == same
        assert equilibria_under(game, team_cost(game)) == same
        assert all(pivot(robot, profile) >= 0.0 for profile in same for robot in range(game.size))


def test_right_of_way_leaves_only_optima():
    narrowed = 0
    for game in some_games():
        plan = social_optima(game)[0]
        found = prices(game.restricted(right_of_way(game, plan)))
        before = prices(game)
        assert found is not None
        assert before is not None
        assert found.worst_equilibrium == before.optimum
        narrowed += before.worst_equilibrium > before.optimum
    assert narrowed > 5  # it had something to do


def test_right_of_way_of_any_plan_leaves_nothing_worse_than_it():
    for game in some_games():
        for plan in list(equilibria(game))[:3]:
            found = prices(game.restricted(right_of_way(game, plan)))
            assert found is not None
            assert found.worst_equilibrium <= game.cost(plan)[0]


def test_no_path_of_the_plan_is_tolled_or_barred():
    for game in some_games():
        plan = social_optima(game)[0]
        for robot, path in enumerate(plan):
            assert tolls(game, plan, 3.0)[robot][path] == 0.0
            assert path in right_of_way(game, plan)[robot]


@pytest.mark.parametrize(
    ("problem", "slack", "worst", "after_tolls"),
    [(CORRIDOR_WITH_BAY, 4, 15, 15), (OPEN, 2, 14, 10), (CROSS, 2, 9, 9), (RING, 2, 8, 8)],
)
def test_rules_on_grids(problem, slack, worst, after_tolls):
    rows = {row.rule: row for row in outcomes(grid_game(problem, slack).game)}
    assert rows["none"].worst == worst
    assert rows["marginal delay"].worst == worst
    assert rows["team cost"].worst == worst
    assert rows["tolls"].worst == after_tolls
    assert rows["right of way"].worst == rows["none"].best
    assert rows["right of way"].most_collected == 0.0


def test_tolls_leave_a_bad_equilibrium_in_the_corridor():
    built = grid_game(CORRIDOR_WITH_BAY, 4)
    game = built.game
    plan = social_optima(game)[0]
    toll = tolls(game, plan, 100.0)
    row = next(row for row in outcomes(game) if row.rule == "tolls")
    assert row.worst > game.cost(plan)[0]
    # Its robots pay, or stand in each other's way without paying; nobody can do better alone.
    priced = game.priced(toll)
    profile = row.worst_profile
    for robot in range(2):
        other = profile[1 - robot]
        free = game.apart[1 - robot][robot][other]
        own = priced.costs[robot][profile[robot], 0]
        assert (priced.costs[robot][free, 0] >= own).all()


def test_side_payments_balance_and_nobody_loses():
    before, after = np.array([9.0, 5.0, 4.0]), np.array([4.0, 6.0, 5.0])
    paid = side_payments(before, after)
    assert paid.sum() == pytest.approx(0.0)
    assert (after + paid).tolist() == pytest.approx([8.0, 4.0, 3.0])
