"""Responses, regret and equilibria: by hand and by brute force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conav.games.game import Game, deviate, game_from_tables, profiles
from conav.games.responses import (
    best_responses,
    better_responses,
    equilibria,
    is_equilibrium,
    regrets,
)

DILEMMA = game_from_tables([[[3, 0], [5, 1]], [[3, 5], [0, 1]]])
PENNIES = game_from_tables([[[1, -1], [-1, 1]], [[-1, 1], [1, -1]]])
BATTLE = game_from_tables([[[2, 0], [0, 1]], [[1, 0], [0, 2]]])
# Three drivers, two roads; each pays the number of drivers on its road.
ROADS = Game((2, 2, 2), lambda player, profile: -profile.count(profile[player]))

games = (
    st.lists(st.integers(1, 3), min_size=1, max_size=3)
    .flatmap(lambda actions: arrays(np.int8, (len(actions), *actions), elements=st.integers(-2, 2)))
    .map(game_from_tables)
)


def test_prisoners_dilemma() -> None:
    assert better_responses(DILEMMA, 0, (0, 0)) == (1,)
    assert best_responses(DILEMMA, 1, (1, 0)) == (1,)
    assert regrets(DILEMMA, (0, 0)) == (2.0, 2.0)
    assert regrets(DILEMMA, (0, 1)) == (1.0, 0.0)
    assert equilibria(DILEMMA) == [(1, 1)]


def test_matching_pennies_has_no_pure_equilibrium() -> None:
    assert equilibria(PENNIES) == []
    assert regrets(PENNIES, (0, 0)) == (0.0, 2.0)
    assert not is_equilibrium(PENNIES, (0, 0))


def test_battle_of_the_sexes_has_two() -> None:
    assert equilibria(BATTLE) == [(0, 0), (1, 1)]
    assert is_equilibrium(BATTLE, (1, 1))


def test_three_drivers_split() -> None:
    assert regrets(ROADS, (0, 0, 0)) == (2.0, 2.0, 2.0)
    assert regrets(ROADS, (0, 1, 0)) == (0.0, 0.0, 0.0)
    assert len(equilibria(ROADS)) == 6
    assert not {(0, 0, 0), (1, 1, 1)} & set(equilibria(ROADS))


def test_equal_is_not_better() -> None:
    flat = game_from_tables([[1, 1, 2]])
    assert better_responses(flat, 0, (0,)) == (2,)
    assert better_responses(flat, 0, (2,)) == ()
    assert best_responses(game_from_tables([[2, 1, 2]]), 0, (1,)) == (0, 2)


def test_the_tolerance_is_in_utility() -> None:
    game = game_from_tables([[0.0, 0.5]])
    assert better_responses(game, 0, (0,), tolerance=0.4) == (1,)
    assert better_responses(game, 0, (0,), tolerance=0.5) == ()
    assert best_responses(game, 0, (0,), tolerance=0.5) == (0, 1)
    assert is_equilibrium(game, (0,), tolerance=0.5)
    assert equilibria(game, tolerance=0.5) == [(0,), (1,)]
    assert equilibria(game, tolerance=0.4) == [(1,)]


@given(games)
def test_responses_against_the_definitions(game: Game) -> None:
    found = set(equilibria(game))
    for profile in profiles(game):
        for i in range(game.n_players):
            gains = {
                a: game.utility(i, deviate(profile, i, a)) - game.utility(i, profile)
                for a in range(game.actions[i])
            }
            top = max(gains.values())
            assert better_responses(game, i, profile) == tuple(a for a in gains if gains[a] > 0)
            assert best_responses(game, i, profile) == tuple(a for a in gains if gains[a] == top)
            assert regrets(game, profile)[i] == top
        assert (profile in found) == is_equilibrium(game, profile)
        assert (profile in found) == (max(regrets(game, profile)) == 0)


@pytest.mark.parametrize("player", [-1, 2])
def test_players_that_do_not_exist_are_refused(player: int) -> None:
    with pytest.raises(ValueError, match="is none of 0 to 1"):
        better_responses(DILEMMA, player, (0, 0))
