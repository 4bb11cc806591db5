"""How regular paths are: where a robot turns, by how much, and where it starts a local map.

A path is the array of a robot's positions step by step, shape (steps + 1, 2) [m]; standing still is
no turn.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

Path = NDArray[np.float64]

# Eighths of a full turn of a move's direction, by the signs of its dx and dy.
_EIGHTHS = {
    (1, 0): 0, (1, 1): 1, (0, 1): 2, (-1, 1): 3, (-1, 0): 4, (-1, -1): 5, (0, -1): 6, (1, -1): 7,
}  # fmt: skip


@dataclass(frozen=True)
class Turns:
    """The turns of a path."""

    count: int
    angle: float  # [rad], all turns added up, each from 0 to pi
    length_m: float


def directions(path: Path) -> list[int]:
    """The direction of each step's move in eighths of a full turn, -1 for none."""
    signs = np.sign(np.round(np.diff(path, axis=0), 9)).astype(int).tolist()
    return [_EIGHTHS.get((dx, dy), -1) for dx, dy in signs]


def turn_between(before: int, after: int) -> int:
    """The eighths of a full turn between two directions, 0 to 4."""
    apart = abs(before - after) % 8
    return min(apart, 8 - apart)


def turns_of(path: Path) -> Turns:
    """The turns of a path, and its length."""
    driven = [k for k in directions(path) if k >= 0]
    parts = [turn_between(a, b) for a, b in pairwise(driven)]
    steps = np.diff(path, axis=0)
    length = float(np.sqrt((steps**2).sum(axis=1)).sum())
    return Turns(sum(part > 0 for part in parts), sum(parts) * pi / 4, length)


def lengths(path: Path) -> NDArray[np.float64]:
    """The length driven up to each step [m], shape (steps + 1,)."""
    steps = np.sqrt((np.diff(path, axis=0) ** 2).sum(axis=1))
    return np.concatenate([np.zeros(1), np.cumsum(steps)])


def changes(keys: Sequence[Hashable]) -> int:
    """How often something new is set out for: keys that differ from the last one that was not None.

    >>> changes([None, "a", "a", None, "a", "b", "a"])
    3
    """
    count = 0
    last: Hashable = None
    for key in keys:
        if key is not None and key != last:
            count += 1
            last = key
    return count


def stretches(path: Path, reach_m: float) -> int:
    """How many local maps a path needs when each ends where the robot gets out of its reach.

    The first is around the start; the next starts where the robot is farther than `reach_m` from
    where the last one did.
    """
    count = 1
    x, y = path[0].tolist()
    for a, b in path.tolist():
        if (a - x) ** 2 + (b - y) ** 2 > reach_m * reach_m:
            count += 1
            x, y = a, b
    return count


def spread(values: Sequence[float]) -> float:
    """The standard deviation of each one's share of the sum; 0 is even, and for a sum of 0."""
    total = sum(values)
    if total == 0:
        return 0.0
    shares = [value / total for value in values]
    mean = sum(shares) / len(shares)
    return sqrt(sum((share - mean) ** 2 for share in shares) / len(shares))
