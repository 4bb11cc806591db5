"""Weak acyclicity: whether better responses can always lead to an equilibrium."""

from dataclasses import dataclass

import numpy as np

from conav.games.game import Game, Profile, first_where, tabulate
from conav.games.responses import at_rest


@dataclass(frozen=True)
class WeakAcyclicity:
    """Whether a game is weakly acyclic, with what shows it."""

    holds: bool
    longest: int  # steps of the longest of the shortest paths to an equilibrium, where there is one
    witness: Profile | None  # the first profile without a better-response path to an equilibrium


def weak_acyclicity(game: Game, tolerance: float = 0.0) -> WeakAcyclicity:
    """Whether from every profile a better-response path ends at a pure Nash equilibrium.

    Definition 2.3 of [Philip2014], after [Fabrikant2010], decided by enumeration: a search over
    the better-response graph, backwards from all equilibria at once. A change counts as better
    when it gains more than `tolerance`.
    """
    utilities = tabulate(game)
    reached = at_rest(utilities, tolerance)
    longest = 0
    while not reached.all():
        grown = reached.copy()
        for player, own in enumerate(utilities):
            # The best this player can change to among the profiles known to lead to an end.
            best = np.where(reached, own, -np.inf).max(axis=player, keepdims=True)
            grown |= best - own > tolerance
        if (grown == reached).all():
            return WeakAcyclicity(False, longest, first_where(~reached))
        reached = grown
        longest += 1
    return WeakAcyclicity(True, longest, None)
