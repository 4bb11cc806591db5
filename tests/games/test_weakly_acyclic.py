"""Weak acyclicity: by hand, and against a search from every profile."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conav.games.game import Game, Profile, deviate, game_from_tables, profiles
from conav.games.potential import find_potential
from conav.games.responses import better_responses, equilibria, is_equilibrium
from conav.games.weakly_acyclic import WeakAcyclicity, weak_acyclicity

PENNIES = game_from_tables([[[1, -1], [-1, 1]], [[-1, 1], [1, -1]]])
# Matching pennies, but player 0 may take 2 and leave.
LEAVE = game_from_tables([[[1, -1], [-1, 1], [2, 2]], [[-1, 1], [1, -1], [0, 0]]])
# Matching pennies beside an equilibrium (2, 2) that nobody goes to alone.
ASIDE = game_from_tables(
    [[[1, -1, -1], [-1, 1, -1], [-5, -5, 0]], [[-1, 1, -5], [1, -1, -5], [-1, -1, 0]]]
)
# Each of three wants to differ from the next: one of them never does.
RING = Game((2, 2, 2), lambda i, profile: float(profile[i] != profile[(i + 1) % 3]))


def steps_to_rest(game: Game, start: Profile) -> int | None:
    """The length of the shortest better-response path to an equilibrium, breadth first."""
    seen = {start}
    level = [start]
    steps = 0
    while level:
        if any(is_equilibrium(game, profile) for profile in level):
            return steps
        following = {
            deviate(profile, i, action)
            for profile in level
            for i in range(game.n_players)
            for action in better_responses(game, i, profile)
        }
        level = sorted(following - seen)
        seen |= following
        steps += 1
    return None


def test_matching_pennies_is_not_weakly_acyclic() -> None:
    assert weak_acyclicity(PENNIES) == WeakAcyclicity(False, 0, (0, 0))


def test_an_equilibrium_out_of_reach_is_not_enough() -> None:
    assert equilibria(ASIDE) == [(2, 2)]
    result = weak_acyclicity(ASIDE)
    # (0, 2), (1, 2), (2, 0) and (2, 1) lead there; the four of matching pennies do not.
    assert result == WeakAcyclicity(False, 1, (0, 0))


def test_weakly_acyclic_without_a_potential() -> None:
    assert weak_acyclicity(LEAVE) == WeakAcyclicity(True, 1, None)
    assert find_potential(LEAVE).potential is None


def test_three_players() -> None:
    assert weak_acyclicity(RING) == WeakAcyclicity(False, 0, (0, 0, 0))
    roads = Game((2, 2, 2), lambda player, profile: -profile.count(profile[player]))
    assert weak_acyclicity(roads) == WeakAcyclicity(True, 1, None)


def test_prisoners_dilemma_takes_two_steps() -> None:
    dilemma = game_from_tables([[[3, 0], [5, 1]], [[3, 5], [0, 1]]])
    assert weak_acyclicity(dilemma) == WeakAcyclicity(True, 2, None)


def test_gains_within_the_tolerance_are_none() -> None:
    assert weak_acyclicity(PENNIES, tolerance=1.9).holds is False
    assert weak_acyclicity(PENNIES, tolerance=2.0) == WeakAcyclicity(True, 0, None)


shapes = st.lists(st.integers(1, 3), min_size=1, max_size=3)
games = shapes.flatmap(
    lambda actions: arrays(np.int8, (len(actions), *actions), elements=st.integers(-2, 2))
).map(game_from_tables)


@given(games)
def test_against_a_search_from_every_profile(game: Game) -> None:
    steps = {profile: steps_to_rest(game, profile) for profile in profiles(game)}
    lost = [profile for profile, count in steps.items() if count is None]
    result = weak_acyclicity(game)
    assert result.holds == (not lost)
    assert result.witness == (lost[0] if lost else None)
    assert result.longest == max(
        (count for count in steps.values() if count is not None), default=0
    )
