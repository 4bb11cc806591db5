"""The wonderful life utility: what the team would lack without this player."""

from collections.abc import Callable

from conav.games.game import Game, Profile, deviate

ABSENT = -1
"""The action of a player that is not there."""


def wonderful_life_game(actions: tuple[int, ...], welfare: Callable[[Profile], float]) -> Game:
    """The game in which player i gets phi(z) - phi(z_-i): equation (3) of [Philip2014].

    `welfare` is phi; it must accept profiles in which one player is `ABSENT`. The game is an exact
    potential game with potential phi whatever phi is, because phi(z_-i) does not depend on what
    player i does ([Wolpert2001], [Marden2007]).
    """

    def utility(player: int, profile: Profile) -> float:
        return welfare(profile) - welfare(deviate(profile, player, ABSENT))

    return Game(actions, utility)
