"""From moves to a schedule."""

from collections.abc import Sequence

import numpy as np

from conav.pursuit.known_map import Move
from conav.pursuit.shadow_moves import Point
from conav.pursuit.types import Pursuer, Schedule


def schedule_of(
    pursuers: Sequence[Pursuer], points: Sequence[Point], moves: Sequence[Move]
) -> Schedule:
    """The schedule in which pursuers make these moves one after the other, at top speed.

    A move from a place is made by the first pursuer there. Everybody sees all the time. Without
    moves there is one leg of no duration, in which they look round.
    """
    at = np.array([one.start for one in pursuers], dtype=np.float64)
    positions, times = [at.copy()], [0.0]
    for move in moves:
        start, end = np.array(points[move.start]), np.array(points[move.end])
        mover = int(np.flatnonzero((at == start).all(axis=1))[0])
        length = float(np.sqrt(((end - start) ** 2).sum()))
        at[mover] = end
        positions.append(at.copy())
        times.append(times[-1] + length / pursuers[mover].speed_mps)
    if not moves:
        positions.append(at.copy())
        times.append(0.0)
    active = np.ones((len(times) - 1, len(pursuers)), np.bool_)
    return Schedule(np.array(times), np.array(positions), active)
