"""Better-response paths: one player at a time changes to something better for it."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from conav.games.game import Game, Profile, check_profile, deviate
from conav.games.responses import better_responses
from conav.status import Status


def is_better_response_path(game: Game, path: Sequence[Profile], tolerance: float = 0.0) -> bool:
    """Whether each profile differs from the one before in one player's action, a better response.

    Definition 2.2 of [Philip2014]; a path of one profile is one. Raises `ValueError` when the path
    is empty or holds a profile that is none of the game's.
    """
    if not path:
        raise ValueError("a path holds at least one profile")
    for profile in path:
        check_profile(game, profile)
    for before, after in pairwise(path):
        changed = [i for i in range(game.n_players) if before[i] != after[i]]
        if len(changed) != 1:
            return False
        player = changed[0]
        if game.utility(player, after) - game.utility(player, before) <= tolerance:
            return False
    return True


@dataclass(frozen=True)
class BetterResponsePath:
    """A better-response path and how it ended."""

    status: Status  # done at a pure Nash equilibrium, out_of_budget otherwise
    profiles: tuple[Profile, ...]  # the start first


def better_response_path(
    game: Game,
    start: Profile,
    rng: np.random.Generator,
    max_steps: int = 10_000,
    tolerance: float = 0.0,
) -> BetterResponsePath:
    """A random better-response path from the start, of at most `max_steps` changes.

    Every better response of every player is equally likely to be the next change. So in a weakly
    acyclic game the path reaches an equilibrium with a probability that goes to 1 with `max_steps`;
    in a potential game it visits no profile twice, and as many steps as profiles are enough.
    """
    check_profile(game, start)
    path = [start]
    while True:
        changes = [
            (player, action)
            for player in range(game.n_players)
            for action in better_responses(game, player, path[-1], tolerance)
        ]
        if not changes:
            return BetterResponsePath(Status.DONE, tuple(path))
        if len(path) > max_steps:
            return BetterResponsePath(Status.OUT_OF_BUDGET, tuple(path))
        player, action = changes[int(rng.integers(len(changes)))]
        path.append(deviate(path[-1], player, action))
