"""Better responses, regret and pure Nash equilibria.

An action is better than another when its utility is higher by more than `tolerance`. With the
default of 0 these are the definitions to the letter; utilities computed with rounding, sums of
roots for instance, need a small tolerance or ties will look like gains.
"""

import numpy as np
from numpy.typing import NDArray

from conav.games.game import Game, Profile, check_profile, deviate, tabulate


def better_responses(
    game: Game, player: int, profile: Profile, tolerance: float = 0.0
) -> tuple[int, ...]:
    """The player's actions that give it strictly more than its action in the profile.

    Definition 2.1 of [Philip2014], after [Fabrikant2010].
    """
    values = _values(game, player, profile)
    now = values[profile[player]]
    return tuple(a for a, value in enumerate(values) if value - now > tolerance)


def best_responses(
    game: Game, player: int, profile: Profile, tolerance: float = 0.0
) -> tuple[int, ...]:
    """The player's actions than which none gives it more while the others keep theirs."""
    values = _values(game, player, profile)
    top = max(values)
    return tuple(a for a, value in enumerate(values) if top - value <= tolerance)


def regrets(game: Game, profile: Profile) -> tuple[float, ...]:
    """What each player could gain by changing its own action, 0 or more, one per player."""
    gains: list[float] = []
    for player in range(game.n_players):
        values = _values(game, player, profile)
        gains.append(max(values) - values[profile[player]])
    return tuple(gains)


def is_equilibrium(game: Game, profile: Profile, tolerance: float = 0.0) -> bool:
    """Whether the profile is a pure Nash equilibrium: no regret exceeds the tolerance."""
    return max(regrets(game, profile)) <= tolerance


def at_rest(utilities: NDArray[np.float64], tolerance: float = 0.0) -> NDArray[np.bool_]:
    """Which profiles are pure Nash equilibria, shape (*actions), from a table of utilities."""
    resting = np.ones(utilities.shape[1:], dtype=np.bool_)
    for player, own in enumerate(utilities):
        resting &= own.max(axis=player, keepdims=True) - own <= tolerance
    return resting


def equilibria(game: Game, tolerance: float = 0.0) -> list[Profile]:
    """All pure Nash equilibria, by enumeration, in the order of `profiles`.

    >>> from conav.games.game import game_from_tables
    >>> equilibria(game_from_tables([[[3, 0], [5, 1]], [[3, 5], [0, 1]]]))  # prisoner's dilemma
    [(1, 1)]
    """
    return [tuple(map(int, index)) for index in np.argwhere(at_rest(tabulate(game), tolerance))]


def _values(game: Game, player: int, profile: Profile) -> list[float]:
    """What the player gets for each of its actions."""
    check_profile(game, profile)
    if not 0 <= player < game.n_players:
        raise ValueError(f"player {player} is none of 0 to {game.n_players - 1}")
    return [
        game.utility(player, deviate(profile, player, action))
        for action in range(game.actions[player])
    ]
