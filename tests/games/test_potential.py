"""Potentials: by hand, by brute force, and as properties of made potential games."""

from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conav.games.game import Game, deviate, game_from_tables, profiles, tabulate
from conav.games.potential import (
    Violation,
    find_potential,
    is_ordinal_potential,
    is_potential,
    ordinal_violation,
    potential_violation,
)

DILEMMA = game_from_tables([[[3, 0], [5, 1]], [[3, 5], [0, 1]]])
PENNIES = game_from_tables([[[1, -1], [-1, 1]], [[-1, 1], [1, -1]]])
BATTLE = game_from_tables([[[2, 0], [0, 1]], [[1, 0], [0, 2]]])
UNEQUAL = game_from_tables([[[2, 0], [0, 1]], [[3, 0], [0, 6]]])  # player 1 counts three times
ROADS = Game((2, 2, 2), lambda player, profile: -profile.count(profile[player]))

shapes = st.lists(st.integers(1, 3), min_size=1, max_size=3).map(tuple)
values = st.integers(-9, 9)


@st.composite
def potential_games(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """A potential, and utilities of it plus, for each, anything that its action does not change."""
    phi = draw(shapes.flatmap(lambda shape: arrays(np.int64, shape, elements=values)))
    own = []
    for player, count in enumerate(phi.shape):
        others = (*phi.shape[:player], 1, *phi.shape[player + 1 :])
        own.append(phi + draw(arrays(np.int64, others, elements=values)).repeat(count, axis=player))
    return phi, np.array(own)


def brute_force(game: Game, phi: np.ndarray) -> bool:
    return all(
        game.utility(i, deviate(profile, i, action)) - game.utility(i, profile)
        == phi[deviate(profile, i, action)] - phi[profile]
        for profile in profiles(game)
        for i in range(game.n_players)
        for action in range(game.actions[i])
    )


def squares_close(game: Game) -> bool:
    """Whether gains along every square of two players' changes sum to 0.

    This is the criterion of Monderer and Shapley, Corollary 2.9; it knows no potential.
    """
    for profile in profiles(game):
        for i, j in combinations(range(game.n_players), 2):
            for a, b in product(range(game.actions[i]), range(game.actions[j])):
                corner = [profile, deviate(profile, i, a)]
                corner += [deviate(corner[1], j, b), deviate(profile, j, b)]
                around = [(i, 0, 1), (j, 1, 2), (i, 2, 3), (j, 3, 0)]
                if sum(
                    game.utility(who, corner[end]) - game.utility(who, corner[start])
                    for who, start, end in around
                ):
                    return False
    return True


@pytest.mark.parametrize(
    ("game", "potential"),
    [
        (DILEMMA, [[0, 2], [2, 3]]),
        (BATTLE, [[0, -1], [-2, 0]]),
        # Rosenthal's: a road with k drivers counts -1 - 2 ... - k; 6 or 3 + 1 in all.
        (ROADS, [[[0, 2], [2, 2]], [[2, 2], [2, 0]]]),
    ],
)
def test_potentials_found_by_hand(game: Game, potential: list[object]) -> None:
    found = find_potential(game)
    assert found.violation is None
    assert found.potential is not None
    assert found.potential.tolist() == potential
    assert is_potential(game, np.array(potential))


def test_matching_pennies_has_none() -> None:
    found = find_potential(PENNIES)
    assert found.potential is None
    # Player 0 first, then player 1: -2 - 2 = -4 to (1, 1), and 2 to (0, 1). From there to (1, 1)
    # it would have to be -6, and player 0 gains 2.
    assert found.violation == Violation(0, (0, 1), 1, 2.0, -6.0)
    assert not is_ordinal_potential(PENNIES, np.zeros((2, 2)))


def test_the_violation_is_a_change_that_shows_it() -> None:
    flat = np.zeros((2, 2))
    violation = potential_violation(DILEMMA, flat)
    assert violation == Violation(0, (0, 0), 1, 2.0, 0.0)
    assert ordinal_violation(DILEMMA, flat) == violation


def test_an_ordinal_potential_need_not_be_exact() -> None:
    phi = np.array([[0, -1], [-2, 0]])
    assert is_ordinal_potential(UNEQUAL, phi)
    assert not is_potential(UNEQUAL, phi)
    assert find_potential(UNEQUAL).potential is None


def test_ordinal_wants_equal_where_utilities_are_equal() -> None:
    still = game_from_tables([[1, 1]])
    assert is_ordinal_potential(still, np.array([4.0, 4.0]))
    assert ordinal_violation(still, np.array([4.0, 5.0])) == Violation(0, (0,), 1, 0.0, 1.0)


def test_tolerance() -> None:
    game = game_from_tables([[0.0, 1.0]])
    assert is_potential(game, np.array([0.0, 1.5]), tolerance=0.5)
    assert not is_potential(game, np.array([0.0, 1.5]), tolerance=0.4)
    assert not is_ordinal_potential(game, np.array([0.0, 0.4]), tolerance=0.5)
    assert is_ordinal_potential(game, np.array([0.0, 0.4]), tolerance=0.3)


@given(potential_games())
def test_made_potential_games(case: tuple[np.ndarray, np.ndarray]) -> None:
    phi, utilities = case
    game = game_from_tables(utilities)
    assert is_potential(game, phi)
    assert is_potential(game, lambda profile: phi[profile] + 7.0)
    assert is_ordinal_potential(game, phi)
    assert is_ordinal_potential(game, phi**3 + 2 * phi)
    found = find_potential(game).potential
    assert found is not None
    assert np.array_equal(found, phi - phi.flat[0])


@given(potential_games(), st.data())
def test_one_changed_utility_breaks_it(
    case: tuple[np.ndarray, np.ndarray], data: st.DataObject
) -> None:
    phi, utilities = case
    player = data.draw(st.integers(0, phi.ndim - 1))
    profile = tuple(data.draw(st.integers(0, count - 1)) for count in phi.shape)
    utilities[(player, *profile)] += data.draw(st.sampled_from([-1, 1, 5]))
    game = game_from_tables(utilities)
    several = [count > 1 for count in phi.shape]
    # Where a player has one action nothing it gets matters, and one player alone has a potential.
    assert is_potential(game, phi) == (not several[player])
    alone = sum(several) == several[player]
    assert (find_potential(game).potential is None) == (several[player] and not alone)
    violation = find_potential(game).violation
    if violation is not None:
        i, before = violation.player, violation.profile
        after = deviate(before, i, violation.action)
        assert violation.utility_change == utilities[(i, *after)] - utilities[(i, *before)]
        assert violation.utility_change != violation.potential_change


@given(
    shapes.flatmap(
        lambda s: arrays(np.int8, (len(s), *s), elements=st.sampled_from([0, 0, 0, 0, 1]))
    ),
    st.data(),
)
def test_checks_against_brute_force(utilities: np.ndarray, data: st.DataObject) -> None:
    game = game_from_tables(utilities)
    found = find_potential(game).potential
    assert (found is not None) == squares_close(game)
    if found is not None:
        assert is_potential(game, found)
        assert brute_force(game, found)
    other = data.draw(arrays(np.int8, game.actions, elements=st.sampled_from([0, 0, 1])))
    other = other.astype(float)
    assert is_potential(game, other) == brute_force(game, other)
    ordinal = all(
        np.sign(tabulate(game)[(i, *after)] - tabulate(game)[(i, *before)])
        == np.sign(other[after] - other[before])
        for before in profiles(game)
        for i in range(game.n_players)
        for after in [deviate(before, i, action) for action in range(game.actions[i])]
    )
    assert is_ordinal_potential(game, other) == ordinal
