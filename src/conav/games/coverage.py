"""The coverage game: every player picks a set of points, the team gets what is new in the union.

Sets are Python integers, bit p standing for point p. The number of new points is monotone and
submodular in the sets picked, so at least half of the optimum is certain twice over: for picking
one after the other ([Fisher1978]) and for every pure equilibrium of the wonderful life utilities
([Vetta2002]).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from conav.games.game import Game, Profile, check_actions
from conav.games.wonderful_life import ABSENT, wonderful_life_game


@dataclass(frozen=True)
class Coverage:
    """What each player can cover.

    Raises `ValueError` when there is no player, a player has no set, or a number is negative.
    """

    sets: tuple[tuple[int, ...], ...]  # sets[i][a]: points that player i covers with action a
    known: int = 0  # points that count for nothing any more

    def __post_init__(self) -> None:
        check_actions(self.actions)
        if self.known < 0 or any(points < 0 for own in self.sets for points in own):
            raise ValueError("sets of points are integers of 0 or more, a bit for each point")

    @property
    def actions(self) -> tuple[int, ...]:
        return tuple(len(own) for own in self.sets)


def point_sets(rows: ArrayLike) -> tuple[int, ...]:
    """One integer for each row of booleans, shape (n_sets, n_points); bit p is column p.

    >>> point_sets([[True, False, False], [False, True, True]])
    (1, 6)
    """
    table = np.asarray(rows, dtype=np.bool_)
    if table.ndim != 2:
        raise ValueError(f"rows of points have two dimensions, not {table.ndim}")
    packed = np.packbits(table, axis=1, bitorder="little")
    return tuple(int.from_bytes(row.tobytes(), "little") for row in packed)


def covered(coverage: Coverage, profile: Profile) -> int:
    """The number of new points the players cover together; players may be `ABSENT`."""
    union = 0
    for own, action in zip(coverage.sets, profile, strict=True):
        if action != ABSENT:
            union |= own[action]
    return (union & ~coverage.known).bit_count()


def coverage_game(coverage: Coverage) -> Game:
    """The game in which a player gets the number of new points that nobody else covers.

    This is the wonderful life utility of `covered`, and so an exact potential game with it. It is
    not utility (7) of [Philip2014], which does not look at what the others choose.
    """
    return wonderful_life_game(coverage.actions, lambda profile: covered(coverage, profile))


def greedy(coverage: Coverage) -> Profile:
    """Each player's best choice given those before it, in the players' order; ties to the lower.

    At least half of the optimum ([Fisher1978], the locally greedy algorithm), in any order.
    """
    union = coverage.known
    profile: list[int] = []
    for own in coverage.sets:
        gains = [(points & ~union).bit_count() for points in own]
        action = gains.index(max(gains))
        union |= own[action]
        profile.append(action)
    return tuple(profile)
