"""The social optimum, and how near equilibria come to it, by enumeration."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from conav.games.game import Game, Profile, Welfare, profile_table, tabulate
from conav.games.responses import equilibria


class Optimum(NamedTuple):
    """A profile and its welfare."""

    profile: Profile
    welfare: float


def optimum(actions: tuple[int, ...], welfare: Welfare) -> Optimum:
    """The profile of highest welfare, the first of equals."""
    table = profile_table(actions, welfare)
    profile = tuple(map(int, np.unravel_index(int(table.argmax()), table.shape)))
    return Optimum(profile, float(table[profile]))


def sum_of_utilities(game: Game) -> Welfare:
    """The table of what all players get together, shape (*actions)."""
    return tabulate(game).sum(axis=0)


@dataclass(frozen=True)
class Efficiency:
    """The optimum, and the worst and the best pure equilibrium."""

    optimum: Optimum
    worst: Optimum
    best: Optimum

    @property
    def price_of_anarchy(self) -> float:
        """Welfare of the worst equilibrium over the optimum, at most 1."""
        return self.worst.welfare / self.optimum.welfare

    @property
    def price_of_stability(self) -> float:
        """Welfare of the best equilibrium over the optimum, at most 1."""
        return self.best.welfare / self.optimum.welfare


def efficiency(game: Game, welfare: Welfare, tolerance: float = 0.0) -> Efficiency:
    """How good the pure equilibria are for the team.

    The ratios are of welfare, so they are at most 1; for costs they are commonly written the other
    way round. Raises `ValueError` when there is no pure equilibrium, when a welfare is negative or
    when all are 0, where ratios mean nothing.
    """
    table = profile_table(game.actions, welfare)
    found = equilibria(game, tolerance)
    if not found:
        raise ValueError("the game has no pure equilibrium")
    if table.min() < 0.0 or table.max() == 0.0:
        raise ValueError("ratios of welfare need values of 0 or more, one above 0")
    by_welfare = [Optimum(profile, float(table[profile])) for profile in found]
    return Efficiency(
        optimum(game.actions, table),
        min(by_welfare, key=lambda each: each.welfare),
        max(by_welfare, key=lambda each: each.welfare),
    )
