"""The stage game of the rendezvous: sequences, utilities, potential."""

from math import hypot, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.games.better_response_path import better_response_path
from conav.games.game import Profile, game_from_tables, tabulate
from conav.games.potential import is_potential
from conav.games.rendezvous import (
    TIE,
    TwoStep,
    rendezvous_game,
    rendezvous_potential,
    sequences,
)
from conav.games.weakly_acyclic import weak_acyclicity
from conav.status import Status


def test_sequences_away_from_the_border() -> None:
    east = (TwoStep(0, 7, 5), TwoStep(1, 5, 6), TwoStep(2, 4, 5), TwoStep(3, 5, 4))
    assert sequences(5, 5, 0, 10, 10) == east
    south = (TwoStep(0, 5, 3), TwoStep(1, 6, 5), TwoStep(2, 5, 6), TwoStep(3, 4, 5))
    assert sequences(5, 5, 3, 10, 10) == south


def test_sequences_at_the_border() -> None:
    # One step from it: forward goes as far as it can.
    assert sequences(8, 5, 0, 10, 10)[0] == TwoStep(0, 9, 5)
    # Facing it: no forward.
    assert [end.turn for end in sequences(9, 5, 0, 10, 10)] == [1, 2, 3]
    # In a corner, and in a corridor.
    assert sequences(9, 9, 0, 10, 10) == (TwoStep(2, 8, 9), TwoStep(3, 9, 8))
    assert sequences(0, 0, 1, 3, 1) == (TwoStep(3, 1, 0),)


def test_utilities_by_hand() -> None:
    # Robot 0 at (0, 0) facing east, robot 1 at (4, 0) facing west, robot 2 at (2, 2) facing south.
    game = rendezvous_game([(0, 0), (4, 0), (2, 2)], [0, 2, 3], 5, 5)
    assert game.actions == (2, 2, 4)  # forward and +90, forward and -90, all
    assert game.utility(0, (0, 0, 0)) == 0.0  # all at (2, 0)
    assert game.utility(0, (0, 0, 1)) == -sqrt(1 + 4)  # robot 2 turns east: (3, 2)
    assert game.utility(1, (1, 0, 0)) == -hypot(2, 1)  # robot 0 turns north: (0, 1)
    assert game.utility(2, (1, 1, 0)) == -2 * hypot(2, 1)  # robot 1 turns north: (4, 1)


@st.composite
def states(draw: st.DrawFn):
    width, height = draw(st.sampled_from([(2, 1), (1, 4), (3, 3), (6, 5), (12, 12)]))
    robots = draw(st.integers(2, 4))
    place = st.tuples(st.integers(0, width - 1), st.integers(0, height - 1))
    positions = draw(st.lists(place, min_size=robots, max_size=robots))
    headings = draw(st.lists(st.integers(0, 3), min_size=robots, max_size=robots))
    return positions, headings, width, height


@settings(deadline=None)
@given(states(), st.integers(0, 99))
def test_every_state_is_an_exact_potential_game(state, seed: int) -> None:
    game = rendezvous_game(*state)

    def potential(profile: Profile) -> float:
        return rendezvous_potential(*state, profile)

    assert is_potential(game, potential)
    assert weak_acyclicity(game, TIE).holds
    rng = np.random.default_rng(seed)
    start = tuple(int(rng.integers(count)) for count in game.actions)
    walk = better_response_path(game, start, rng, tolerance=TIE)
    assert walk.status is Status.DONE


def test_one_robot_that_counts_twice_spoils_the_potential() -> None:
    # The check above can fail.
    state = ([(2, 2), (4, 2), (3, 5)], [0, 1, 2], 8, 8)
    utilities = tabulate(rendezvous_game(*state)).copy()
    utilities[1] *= 2.0
    assert not is_potential(
        game_from_tables(utilities), lambda profile: rendezvous_potential(*state, profile)
    )


@pytest.mark.parametrize(
    ("state", "message"),
    [
        (([(0, 0)], [0], 1, 1), "no room to move"),
        (([(0, 0), (1, 0)], [0], 3, 3), "2 positions and 1 headings"),
        (([(3, 0)], [0], 3, 3), "not on the grid of 3 x 3"),
        (([(0, 0)], [4], 3, 3), "heading 4"),
    ],
)
def test_bad_states_are_refused(state, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        rendezvous_game(*state)
