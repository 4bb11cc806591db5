"""What a search through the product of graphs can be told of robots together."""

from collections.abc import Hashable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray


class Present(NamedTuple):
    """What a robot does at present: the pieces of an edge or a rest, and when it goes on."""

    step: tuple[int, int]  # of its graph, by ranks: with the robot a name for it
    pieces: NDArray[np.float64]  # (n, PIECE); none before its first edge
    until: float  # [s] infinite at rest, or when it has vanished; less than 0 before its first edge


class JointRule(Protocol):
    """What robots have to do with each other beside keeping apart."""

    def begin(self) -> Hashable:
        """What is remembered at the start."""
        ...

    def after(
        self, memory: Hashable, robot: int, new: Present, others: Sequence[Present]
    ) -> Hashable | None:
        """What is remembered when a robot begins something, None where that breaks the rule.

        `others` has everybody, in place of the robot what it did before.
        """
        ...

    def holds(self, memory: Hashable) -> bool:
        """Whether the rule is kept when all rest."""
        ...
