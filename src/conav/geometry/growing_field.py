"""A field of path lengths that follows a ground to which moves are only added.

Lengths can only become shorter. So it is enough to start again from the cells that got moves, with
the lengths they have: whatever is not shorter that way has the length it had.
"""

import numpy as np
from numpy.typing import NDArray

from conav.geometry.distance_field import NO_GROUPS, NO_PLACES, spread
from conav.geometry.ground import Ground


class GrowingField:
    """Path lengths from one cell over a ground that grows; brought up to date when asked for."""

    def __init__(self, ground: Ground, start: int) -> None:
        self._ground = ground
        self._diagonals = np.empty(ground.moves.size, dtype=np.int32)
        self._distance = np.empty(ground.moves.size)
        self.restart(start)

    def restart(self, start: int) -> None:
        """Become the field from another cell; memory at hand is faster than new memory."""
        self._start = start
        self._updates = len(self._ground.added)
        self._begin()

    @staticmethod
    def bytes_of(ground: Ground) -> int:
        """The size of a field over a ground."""
        return 12 * ground.moves.size

    @property
    def distance(self) -> NDArray[np.float64]:
        """The lengths (rows * cols,) as `fill_distances` makes them."""
        self.follow()
        return self._distance

    def follow(self) -> None:
        """Take account of the moves added since the last time."""
        added = self._ground.added[self._updates :]
        if added:
            self._updates += len(added)
            seeds = added[0] if len(added) == 1 else np.concatenate(added)
            if not self._spread(seeds):
                self._begin()

    def _begin(self) -> None:
        done = False
        while not done:
            self._distance.fill(np.inf)
            self._distance[self._start] = 0.0
            self._diagonals[self._start] = 0
            done = self._spread(np.array([self._start], dtype=np.int64))

    def _spread(self, seeds: NDArray[np.int64]) -> bool:
        lengths = (self._distance, self._diagonals)
        return spread(self._ground, seeds, *lengths, None, NO_GROUPS, NO_PLACES) >= 0
