"""The rendezvous game played by many teams.

The rules of a step are those of `rendezvous_step`. The game ends when all robots are on one point
after a step. Robots start anywhere on the grid, each for itself, so they may be together from the
start.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.games.rendezvous import check_grid
from conav.games.rendezvous_step import extent, start, step
from conav.games.splitmix64 import draw
from conav.intervals import Share, wilson


class Games(NamedTuple):
    """When the robots of each game met."""

    met: NDArray[np.int64]  # (n_games,) steps until all were on one point, -1 never
    near: NDArray[np.int64]  # (n_games,) ... until no two were more than 1 apart in x or y


def share_of_consensus(
    epsilon: float,
    games: int,
    steps: int,
    *,
    robots: int = 3,
    width: int = 20,
    height: int = 20,
    seed: int = 0,
) -> Share:
    """The share of games in which all robots are on one point within the steps, with its interval.

    Arguments as `play_games`.
    """
    played = play_games(epsilon, games, steps, robots=robots, width=width, height=height, seed=seed)
    return wilson(int((played.met >= 0).sum()), games)


def play_games(
    epsilon: float,
    games: int,
    steps: int,
    *,
    robots: int = 3,
    width: int = 20,
    height: int = 20,
    seed: int = 0,
) -> Games:
    """The outcomes of games of at most this many steps on a grid of width x height points.

    Game g is the same whatever the numbers of games and steps; games with the same seed and another
    epsilon have the same starts. Raises `ValueError` for numbers that make no sense.
    """
    if games < 1 or steps < 0:
        raise ValueError(f"{games} games of {steps} steps")
    _check(epsilon, robots, width, height, seed)
    met = np.empty(games, dtype=np.int64)
    near = np.empty(games, dtype=np.int64)
    _play_many(np.uint64(seed), float(epsilon), steps, robots, width, height, met, near)
    return Games(met, near)


def playthrough(
    epsilon: float,
    game: int,
    steps: int,
    *,
    robots: int = 3,
    width: int = 20,
    height: int = 20,
    seed: int = 0,
) -> NDArray[np.int64]:
    """Every state of one of the games of `play_games`, shape (steps made + 1, n_robots, 4).

    The columns are x, y, heading, and 1 between a turn and its move forward, else 0.
    """
    if game < 0 or steps < 0:
        raise ValueError(f"game {game} of {steps} steps")
    _check(epsilon, robots, width, height, seed)
    own_seed = np.uint64(draw(np.uint64(seed), game))
    state = np.empty((robots, 4), dtype=np.int64)
    ahead = np.empty((robots, 2), dtype=np.int64)
    start(own_seed, width, height, state)
    states = [state.copy()]
    while len(states) <= steps and extent(state) > 0:
        step(own_seed, len(states) - 1, float(epsilon), width, height, state, ahead)
        states.append(state.copy())
    return np.stack(states)


def _check(epsilon: float, robots: int, width: int, height: int, seed: int) -> None:
    check_grid(width, height)
    if not 0.0 <= epsilon <= 1.0:
        raise ValueError(f"epsilon is a probability, not {epsilon:g}")
    if robots < 2:
        raise ValueError(f"{robots} robots: two can meet")
    if not 0 <= seed < 2**64:
        raise ValueError(f"the seed {seed} is none of 0 to 2**64 - 1")


@kernel
def _play_many(
    seed: np.uint64,
    epsilon: float,
    steps: int,
    robots: int,
    width: int,
    height: int,
    met: NDArray[np.int64],
    near: NDArray[np.int64],
) -> None:
    state = np.empty((robots, 4), dtype=np.int64)
    ahead = np.empty((robots, 2), dtype=np.int64)
    for game in range(met.shape[0]):
        own_seed = draw(seed, game)
        start(own_seed, width, height, state)
        met[game] = -1
        near[game] = -1
        for t in range(steps + 1):
            longest = extent(state)
            if longest <= 1 and near[game] < 0:
                near[game] = t
            if longest == 0:
                met[game] = t
                break
            if t < steps:
                step(own_seed, t, epsilon, width, height, state, ahead)
