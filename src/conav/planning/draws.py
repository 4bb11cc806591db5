"""Random choices of a solver, one after the other from one seed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from conav.compiled import kernel
from conav.games.splitmix64 import below, draw


@dataclass(eq=False)
class Draws:
    """Choices by the draws of one seed, so they are the same on every machine."""

    seed: np.uint64
    made: int = 0

    def below(self, count: int) -> int:
        """A whole number from 0 to count - 1."""
        self.made += 1
        return int(_below(self.seed, self.made, count))

    def seed_of_next(self) -> np.uint64:
        """A seed for draws of its own."""
        self.made += 1
        return np.uint64(int(self.seed) ^ (self.made << 24))

    def shuffled(self, members: Sequence[int]) -> list[int]:
        """The members in a random order."""
        order = list(members)
        for i in range(len(order) - 1, 0, -1):
            j = self.below(i + 1)
            order[i], order[j] = order[j], order[i]
        return order


@kernel
def _below(seed: np.uint64, number: int, count: int) -> int:
    return below(draw(seed, number), count)
