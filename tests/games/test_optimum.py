"""The optimum, and the quality of equilibria."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conav.games.game import game_from_tables, profiles
from conav.games.optimum import Optimum, efficiency, optimum, sum_of_utilities
from conav.games.responses import equilibria

DILEMMA = game_from_tables([[[3, 0], [5, 1]], [[3, 5], [0, 1]]])
PENNIES = game_from_tables([[[1, -1], [-1, 1]], [[-1, 1], [1, -1]]])
STAG_HUNT = game_from_tables([[[4, 0], [3, 3]], [[4, 3], [0, 3]]])


def test_the_dilemma_loses_two_thirds() -> None:
    found = efficiency(DILEMMA, sum_of_utilities(DILEMMA))
    assert found.optimum == Optimum((0, 0), 6.0)
    assert found.worst == found.best == Optimum((1, 1), 2.0)
    assert found.price_of_anarchy == found.price_of_stability == 1 / 3


def test_worst_and_best_equilibrium_differ() -> None:
    found = efficiency(STAG_HUNT, sum_of_utilities(STAG_HUNT))
    assert found.price_of_stability == 1.0
    assert found.price_of_anarchy == 6 / 8
    assert found.worst.profile == (1, 1)


def test_the_first_of_equals() -> None:
    assert optimum((2, 2), lambda profile: -abs(profile[0] - profile[1])) == ((0, 0), 0.0)


def test_ratios_that_mean_nothing_are_refused() -> None:
    with pytest.raises(ValueError, match="no pure equilibrium"):
        efficiency(PENNIES, np.ones((2, 2)))
    with pytest.raises(ValueError, match="0 or more"):
        efficiency(DILEMMA, np.array([[1.0, -1.0], [0.0, 0.0]]))
    with pytest.raises(ValueError, match="one above 0"):
        efficiency(DILEMMA, np.zeros((2, 2)))


shapes = st.lists(st.integers(1, 3), min_size=1, max_size=3).map(tuple)


@given(shapes.flatmap(lambda s: arrays(np.int8, (len(s) + 1, *s), elements=st.integers(0, 4))))
def test_against_all_profiles(tables: np.ndarray) -> None:
    game = game_from_tables(tables[1:])
    welfare = tables[0].astype(float)
    best = optimum(game.actions, welfare)
    assert best.welfare == welfare[best.profile] == max(welfare[p] for p in profiles(game))
    at_equilibria = [welfare[profile] for profile in equilibria(game)]
    if at_equilibria and best.welfare > 0.0:
        found = efficiency(game, welfare)
        assert found.price_of_anarchy == min(at_equilibria) / best.welfare
        assert found.price_of_stability == max(at_equilibria) / best.welfare
        assert found.price_of_anarchy <= found.price_of_stability <= 1.0
    table = sum_of_utilities(game)
    for profile in profiles(game):
        assert table[profile] == sum(game.utility(i, profile) for i in range(game.n_players))
