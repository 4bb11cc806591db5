"""Exact and ordinal potential games.

A potential is a function of the profile whose change tells what a player gains that alone changes
its action: equal to the gain (exact) or of the same sign (ordinal). [Philip2014] states Definition
2.4 only for profiles in which all the others play their baseline action, and over whole numbers;
here it is the definition of [Monderer1996], over all profiles.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from conav.games.game import Game, Profile, Welfare, first_where, profile_table, tabulate


@dataclass(frozen=True)
class Violation:
    """A change of one player's action in which utility and potential do not agree."""

    player: int
    profile: Profile
    action: int  # what the player changes to
    utility_change: float
    potential_change: float


@dataclass(frozen=True)
class PotentialSearch:
    """An exact potential of a game, or the violation that shows there is none."""

    potential: NDArray[np.float64] | None  # (*actions), 0 in profile (0, ..., 0); read-only
    violation: Violation | None


def potential_violation(
    game: Game, potential: Welfare, tolerance: float = 1e-9
) -> Violation | None:
    """A change after which utility and potential differ by more than `tolerance`, or `None`.

    All players, all their pairs of actions and all actions of the others are tried; the violation
    is the largest in the first place that has one. `tolerance` is in units of utility and allows
    for rounding.
    """
    utilities = tabulate(game)
    phi = profile_table(game.actions, potential)
    for player, own in enumerate(utilities):
        # The two change alike exactly if their difference does not depend on the player's action.
        gap = own - phi
        spread = gap.max(axis=player, keepdims=True) - gap.min(axis=player, keepdims=True)
        place = first_where(spread > tolerance)
        if place is not None:
            line = gap[(*place[:player], slice(None), *place[player + 1 :])]
            before, after = int(line.argmin()), int(line.argmax())
            return _violation(own, phi, player, place, before, after)
    return None


def is_potential(game: Game, potential: Welfare, tolerance: float = 1e-9) -> bool:
    """Whether the function is an exact potential of the game: equation (11) in all profiles."""
    return potential_violation(game, potential, tolerance) is None


def find_potential(game: Game, tolerance: float = 1e-9) -> PotentialSearch:
    """The exact potential of the game that is 0 in profile (0, ..., 0), or why there is none.

    Gains are summed along one path to each profile, player by player ([Monderer1996], Theorem 2.8).
    A potential is unique up to a constant (Lemma 2.7), so if this one fails none exists.
    """
    phi = np.zeros(game.actions)
    for player, own in enumerate(tabulate(game)):
        # The players before have moved to their action already, the ones after are still at 0.
        after = game.n_players - player - 1
        gains = own[(slice(None),) * (player + 1) + (0,) * after]
        gains = gains - gains[..., :1]
        phi += gains.reshape(gains.shape + (1,) * after)
    violation = potential_violation(game, phi, tolerance)
    if violation is not None:
        return PotentialSearch(None, violation)
    phi.flags.writeable = False
    return PotentialSearch(phi, None)


def ordinal_violation(game: Game, potential: Welfare, tolerance: float = 1e-9) -> Violation | None:
    """A change after which utility and potential do not go the same way, or `None`.

    Changes of at most `tolerance` count as none. [Monderer1996], section 2.
    """
    phi = profile_table(game.actions, potential)
    for player, own in enumerate(tabulate(game)):
        for before, after in combinations(range(game.actions[player]), 2):
            gain, rise = (
                table.take([after], axis=player) - table.take([before], axis=player)
                for table in (own, phi)
            )
            place = first_where(_sign(gain, tolerance) != _sign(rise, tolerance))
            if place is not None:
                return _violation(own, phi, player, place, before, after)
    return None


def is_ordinal_potential(game: Game, potential: Welfare, tolerance: float = 1e-9) -> bool:
    """Whether the function is an ordinal potential: it rises exactly when the player gains."""
    return ordinal_violation(game, potential, tolerance) is None


def _sign(change: NDArray[np.float64], tolerance: float) -> NDArray[np.int8]:
    return (change > tolerance).astype(np.int8) - (change < -tolerance)


def _violation(
    own: NDArray[np.float64],
    phi: NDArray[np.float64],
    player: int,
    place: Profile,
    before: int,
    after: int,
) -> Violation:
    start = (*place[:player], before, *place[player + 1 :])
    end = (*place[:player], after, *place[player + 1 :])
    return Violation(
        player, start, after, float(own[end] - own[start]), float(phi[end] - phi[start])
    )
