"""What traces of bulk games show beside coverage: overlap, and how often play is an equilibrium."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.types import ExplorationProblem
from conav.geometry.sight import lateral_limits
from conav.maps.occupancy_grid import OCCUPIED
from conav.simulation.bulk_improved import OFF_MAP
from conav.simulation.bulk_potential import BulkGames, disc_shape, padded
from conav.simulation.observable import observable_cells


@dataclass(frozen=True)
class Replay:
    """Measures of each game, one number per step; arrays of shape (games, steps + 1)."""

    sensed: NDArray[np.uint32]  # observable cells each robot has seen itself, added up
    overlap: NDArray[np.float32]  # share of the cells in robots' ranges that are in several
    regret: NDArray[np.uint32]  # largest regret among robots not in mid-turn, by (7); 0 at the end


def replay(problem: ExplorationProblem, games: BulkGames) -> Replay:
    """The measures of games played with `trace`, shared map, on this problem.

    A step is at a Nash equilibrium of the game with utilities (7) when the regret is 0: nobody who
    was free to choose could have discovered more points, given what all knew, with another
    sequence. Robots in mid-turn have no choice.
    """
    plan = problem.plan
    cols = plan.moves.shape[1]
    sensor = problem.robots[0].sensor
    limits = lateral_limits(min(sensor.range_m / plan.lattice.resolution, sum(plan.moves.shape)))
    shape = disc_shape(limits, cols)
    size = games.covered.shape
    found = Replay(
        np.zeros(size, dtype=np.uint32),
        np.zeros(size, dtype=np.float32),
        np.zeros(size, dtype=np.uint32),
    )
    _replay(
        padded(plan.walls == OCCUPIED, shape.pad, OFF_MAP),
        padded(observable_cells(plan, problem.starts, sensor), shape.pad, 0),
        shape.pad,
        shape.width,
        shape.disc.view(np.int64),
        shape.crescent.view(np.int64),
        cols,
        games.cells,
        games.headings,
        found.sensed,
        found.overlap,
        found.regret,
    )
    return found


@kernel
def _replay(
    walls: NDArray[np.uint8],
    free: NDArray[np.uint8],
    pad: int,
    width: int,
    disc: NDArray[np.int64],
    crescent: NDArray[np.int64],
    cols: int,
    cells: NDArray[np.int32],
    headings: NDArray[np.int8],
    sensed: NDArray[np.uint32],
    overlap: NDArray[np.float32],
    regret: NDArray[np.uint32],
) -> None:
    games, times, n = cells.shape
    ahead_of = np.array([1, width, -1, -width])
    own = np.zeros((n, walls.shape[0]), dtype=np.uint8)
    known = np.zeros(walls.shape[0], dtype=np.uint8)
    stamp = np.zeros(walls.shape[0], dtype=np.int64)
    now = 0
    at = np.zeros(n, dtype=np.int64)
    gains = np.zeros(4, dtype=np.int64)
    for game in range(games):
        own[:] = 0
        known[:] = 0
        total = 0
        for t in range(times):
            now += 1
            together = 0
            distinct = 0
            for i in range(n):
                at[i] = (cells[game, t, i] // cols + pad) * width + cells[game, t, i] % cols + pad
                for j in range(disc.shape[0]):
                    p = at[i] + disc[j]
                    if walls[p] == OFF_MAP:
                        continue
                    known[p] = 1
                    together += 1
                    if stamp[p] != now:
                        stamp[p] = now
                        distinct += 1
                    if own[i, p] == 0:
                        own[i, p] = 1
                        total += free[p]
            sensed[game, t] = total
            overlap[game, t] = 1.0 - distinct / together
            if t == times - 1:
                break
            worst = 0
            for i in range(n):
                h = headings[game, t, i]
                # A robot that turned in the last step is bound to go forward.
                if t > 0 and headings[game, t - 1, i] != h:
                    continue
                for k in range(4):
                    gains[k] = -1
                    d = (h + k) & 3
                    p = at[i] + ahead_of[d]
                    if walls[p] != 0:
                        continue
                    gains[k] = 0
                    for j in range(disc.shape[0]):
                        q = p + disc[j]
                        if walls[q] != OFF_MAP and known[q] == 0:
                            gains[k] += 1
                    p += ahead_of[d]
                    if k == 0 and (walls[p] == 0 or (walls[p] == 1 and known[p] == 0)):
                        for j in range(crescent.shape[1]):
                            q = p + crescent[d, j]
                            if walls[q] != OFF_MAP and known[q] == 0:
                                gains[k] += 1
                played = gains[(headings[game, t + 1, i] - h) & 3]
                worst = max(worst, gains.max() - max(played, 0))
            regret[game, t] = worst
