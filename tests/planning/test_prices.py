"""Prices of anarchy: hand-known instances, and everything by brute force on random games."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.planning.grid_motion import apart, cost, grid_of_text
from conav.planning.grid_prices import (
    CORRIDOR_WITH_BAY,
    CROSS,
    INSTANCES,
    OPEN,
    RING,
    grid_game,
    grid_prices,
    paths_within,
)
from conav.planning.prices import (
    PathGame,
    equilibria,
    is_equilibrium,
    prices,
    profiles,
    social_optima,
)


def dominates(a, b):
    return bool(np.all(a <= b) and np.any(a < b))


def slow_profiles(game):
    for profile in product(*(range(len(costs)) for costs in game.costs)):
        if all(
            game.apart[i][j][profile[i], profile[j]]
            for i in range(game.size)
            for j in range(game.size)
            if i != j
        ):
            yield profile


def slow_equilibria(game):
    everything = set(slow_profiles(game))
    for profile in sorted(everything):
        better = False
        for robot in range(game.size):
            for path in range(len(game.costs[robot])):
                other = (*profile[:robot], path, *profile[robot + 1 :])
                if other in everything and dominates(
                    game.costs[robot][path], game.costs[robot][profile[robot]]
                ):
                    better = True
        if not better:
            yield profile


def slow_optima(game):
    sums = {profile: tuple(game.cost(profile)) for profile in slow_profiles(game)}
    return sorted(
        {
            total
            for total in sums.values()
            if not any(dominates(np.array(o), np.array(total)) for o in sums.values())
        }
    )


def random_game(seed, robots, paths, components):
    rng = np.random.default_rng(seed)
    counts = [int(rng.integers(1, paths + 1)) for _ in range(robots)]
    costs = tuple(rng.integers(0, 5, (count, components)).astype(float) for count in counts)
    table = [[np.empty((0, 0), bool)] * robots for _ in range(robots)]
    for i in range(robots):
        for j in range(i):
            table[i][j] = rng.random((counts[i], counts[j])) < 0.6
            table[j][i] = table[i][j].T
    return PathGame(costs, tuple(map(tuple, table)))


@given(
    seed=st.integers(0, 2**32 - 1),
    robots=st.integers(1, 4),
    components=st.integers(1, 3),
)
@settings(max_examples=150, deadline=None)
def test_optima_and_equilibria_equal_brute_force(seed, robots, components):
    game = random_game(seed, robots, 5, components)
    everything = list(slow_profiles(game))
    assert list(profiles(game)) == everything
    assert list(equilibria(game)) == list(slow_equilibria(game))
    assert [tuple(game.cost(p)) for p in social_optima(game)] == slow_optima(game)
    for profile in everything:
        assert is_equilibrium(game, profile) == (profile in set(slow_equilibria(game)))
    found = prices(game)
    assert (found is None) == (not everything)
    if found is not None and components == 1:
        assert found.best_equilibrium == found.optimum  # the price of stability is 1
        assert found.worst_equilibrium == max(float(game.cost(p)[0]) for p in slow_equilibria(game))
        assert found.equilibria == len(list(slow_equilibria(game)))


def test_every_social_optimum_is_an_equilibrium_also_of_vectors():
    held = 0
    for seed in range(200):
        game = random_game(seed, 3, 6, 2)
        for profile in social_optima(game):
            assert is_equilibrium(game, profile)
            held += 1
    assert held > 200


# solo sum, optimum, worst equilibrium, as found by another program for the same instances
KNOWN = {
    (CORRIDOR_WITH_BAY.name, 2): (8, 11, 11),
    (CORRIDOR_WITH_BAY.name, 4): (8, 11, 15),
    (CORRIDOR_WITH_BAY.name, 6): (8, 11, 19),
    (CROSS.name, 3): (8, 9, 9),
    (RING.name, 4): (8, 8, 8),
    (OPEN.name, 2): (8, 10, 14),
}


@pytest.mark.parametrize(("problem", "slack"), INSTANCES)
def test_known_prices(problem, slack):
    row = grid_prices(problem, slack)
    assert row is not None
    solo, optimum, worst = KNOWN[problem.name, slack]
    assert (row.solo, row.found.optimum, row.found.worst_equilibrium) == (solo, optimum, worst)
    assert row.found.price_of_stability == 1.0
    assert row.found.price_of_anarchy == worst / optimum
    assert row.certain


def test_paths_of_the_corridor_by_hand():
    # Slack 0: straight on. Slack 1: one wait, in one of the four cells before the goal.
    assert [len(paths_within(CORRIDOR_WITH_BAY, 0, slack)) for slack in (0, 1)] == [1, 5]
    # Slack 2: two waits in 10 ways, three turns back, one after the goal's cell, one in the bay.
    assert len(paths_within(CORRIDOR_WITH_BAY, 0, 2)) == 5 + 10 + 3 + 1 + 1


def test_the_table_of_a_grid_is_that_of_its_paths():
    built = grid_game(OPEN, 1)
    for i, a in enumerate(built.paths):
        assert built.game.costs[i][:, 0].tolist() == [cost(path) for path in a]
        for j, b in enumerate(built.paths):
            if i != j:
                expected = [[apart(p, q) for q in b] for p in a]
                assert built.game.apart[i][j].tolist() == expected


def test_no_paths_apart():
    swap = grid_of_text("ab\n\nBA", horizon=9)
    assert grid_prices(swap, 4) is None
