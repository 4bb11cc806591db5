"""Wonderful life utilities make a potential game of any welfare."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from conav.games.game import Profile, deviate, profiles
from conav.games.potential import find_potential, is_potential
from conav.games.wonderful_life import ABSENT, wonderful_life_game


def test_what_the_team_would_lack() -> None:
    # Welfare: the largest action taken.
    game = wonderful_life_game((3, 3), lambda profile: max(profile))
    assert game.utility(0, (2, 1)) == 1.0  # 2 - 1
    assert game.utility(1, (2, 1)) == 0.0
    assert game.utility(0, (0, 0)) == 0.0


shapes = st.lists(st.integers(1, 4), min_size=1, max_size=4).map(tuple)


@given(shapes, st.integers(0, 2**32 - 1))
def test_any_welfare_is_the_exact_potential(actions: tuple[int, ...], seed: int) -> None:
    # One more than the actions of each: the last index is what ABSENT, -1, reads.
    table = np.random.default_rng(seed).normal(size=[count + 1 for count in actions])

    def welfare(profile: Profile) -> float:
        return table[profile]

    game = wonderful_life_game(actions, welfare)
    for profile in profiles(game):
        for i, count in enumerate(actions):
            assert game.utility(i, profile) == table[profile] - table[deviate(profile, i, ABSENT)]
            for action in range(count):
                other = deviate(profile, i, action)
                gain = game.utility(i, other) - game.utility(i, profile)
                assert abs(gain - (welfare(other) - welfare(profile))) < 1e-9
    assert is_potential(game, welfare)
    assert find_potential(game).potential is not None


def test_a_share_of_the_welfare_has_not_its_potential() -> None:
    # The check can fail: sharing equally what two cover is no wonderful life utility.
    game = wonderful_life_game((2, 2), lambda profile: float(profile == (1, 1)))
    assert is_potential(game, lambda profile: float(profile == (1, 1)))
    assert not is_potential(game, lambda profile: float(profile == (1, 1)) / 2.0)
