"""Games in normal form, and their tables.

Players and actions are numbered from 0. A profile holds one action per player. Whatever enumerates
profiles works on tables and is exact; it is meant for small games.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from math import prod

import numpy as np
from numpy.typing import ArrayLike, NDArray

Profile = tuple[int, ...]
Welfare = Callable[[Profile], float] | NDArray[np.float64]
"""A function of the profile, or its table, shape (*actions)."""

LARGEST_TABLE = 20_000_000
"""Numbers in the largest table that is made: 160 MB."""


@dataclass(frozen=True)
class Game:
    """A finite game: how many actions each player has, and what each gets.

    Players maximise their utility. `utility` must give the same number whenever it is asked the
    same. Raises `ValueError` when there is no player or a player has no action.
    """

    actions: tuple[int, ...]  # (n_players,) number of actions of each
    utility: Callable[[int, Profile], float]  # of a player in a profile

    def __post_init__(self) -> None:
        check_actions(self.actions)

    @property
    def n_players(self) -> int:
        return len(self.actions)


def check_actions(actions: tuple[int, ...]) -> None:
    """Nothing; raises `ValueError` when there is no player or a player has no action."""
    if not actions:
        raise ValueError("a game needs a player")
    for player, count in enumerate(actions):
        if count < 1:
            raise ValueError(f"player {player} has {count} actions; every player needs one")


def check_profile(game: Game, profile: Profile) -> None:
    """Nothing; raises `ValueError` when the profile is none of the game's."""
    if len(profile) != game.n_players:
        raise ValueError(
            f"profile {profile} has {len(profile)} actions for {game.n_players} players"
        )
    for player, (action, count) in enumerate(zip(profile, game.actions, strict=True)):
        if not 0 <= action < count:
            raise ValueError(f"player {player} has actions 0 to {count - 1}, profile has {action}")


def profiles(game: Game) -> Iterator[Profile]:
    """All profiles of the game, the last player's action changing fastest."""
    return product(*(range(count) for count in game.actions))


def deviate(profile: Profile, player: int, action: int) -> Profile:
    """The profile with this player's action replaced."""
    return (*profile[:player], action, *profile[player + 1 :])


@dataclass(frozen=True, eq=False)
class Tables:
    """Utilities read from a table of shape (n_players, *actions); use `game_from_tables`."""

    utilities: NDArray[np.float64]

    def __call__(self, player: int, profile: Profile) -> float:
        return self.utilities.item((player, *profile))


def game_from_tables(utilities: ArrayLike) -> Game:
    """The game with these utilities, shape (n_players, *actions); they are copied.

    `utilities[i][a0][a1]...` is what player i gets in profile (a0, a1, ...). Raises `ValueError`
    when the shape belongs to no game or a utility is not finite.

    >>> game = game_from_tables([[[3, 0], [5, 1]], [[3, 5], [0, 1]]])  # prisoner's dilemma
    >>> game.actions, game.utility(0, (1, 0))
    ((2, 2), 5.0)
    """
    table = np.array(utilities, dtype=np.float64)
    if table.ndim < 2 or table.shape[0] != table.ndim - 1:
        raise ValueError(
            f"utilities of shape {table.shape}: n players need shape (n, actions of 0, ..., of n-1)"
        )
    check_actions(table.shape[1:])
    _lock(table, "utility")
    return Game(table.shape[1:], Tables(table))


def tabulate(game: Game) -> NDArray[np.float64]:
    """The utilities of all players in all profiles, shape (n_players, *actions), read-only.

    Raises `ValueError` when the table would be too large or a utility is not finite.
    """
    if isinstance(game.utility, Tables):
        return game.utility.utilities
    table = _empty((game.n_players, *game.actions))
    for profile in profiles(game):
        for player in range(game.n_players):
            table[(player, *profile)] = game.utility(player, profile)
    _lock(table, "utility")
    return table


def profile_table(actions: tuple[int, ...], welfare: Welfare) -> NDArray[np.float64]:
    """The values of a function of the profile, shape `actions`, read-only.

    A table is checked and copied. Raises `ValueError` when a table has another shape, would be too
    large, or a value is not finite.
    """
    check_actions(actions)
    if callable(welfare):
        table = _empty(actions)
        for profile in np.ndindex(actions):
            table[profile] = welfare(profile)
    else:
        table = np.array(welfare, dtype=np.float64)
        if table.shape != actions:
            raise ValueError(f"the table has shape {table.shape}, the game's actions are {actions}")
    _lock(table, "value")
    return table


def first_where(mask: NDArray[np.bool_]) -> Profile | None:
    """The first index, in the order of `profiles`, at which the mask is true."""
    flat = int(mask.argmax())
    index = tuple(int(i) for i in np.unravel_index(flat, mask.shape))
    return index if mask[index] else None


def _empty(shape: tuple[int, ...]) -> NDArray[np.float64]:
    if prod(shape) > LARGEST_TABLE:
        raise ValueError(f"{prod(shape)} numbers are too many to tabulate: at most {LARGEST_TABLE}")
    return np.empty(shape)


def _lock(table: NDArray[np.float64], what: str) -> None:
    bad = first_where(~np.isfinite(table))
    if bad is not None:
        raise ValueError(f"the {what} at {bad} is {table[bad]}, not a finite number")
    table.flags.writeable = False
