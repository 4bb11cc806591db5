"""Random places that keep their distances."""

from collections.abc import Callable, Iterable
from math import sqrt

import numpy as np

from conav.errors import InputError

TRIES = 20_000
"""Draws for one place before there is said to be no room."""

Point = tuple[float, float]


def placed(
    rng: np.random.Generator,
    low: Point,
    high: Point,
    allowed: Callable[[Point], bool],
    what: str,
    remedy: str,
) -> Point:
    """A uniform place in a box of those that are allowed, after at most `TRIES` draws.

    Raises `InputError` with the remedy when there was none.
    """
    for _ in range(TRIES):
        x, y = rng.random(2).tolist()
        point = (low[0] + x * (high[0] - low[0]), low[1] + y * (high[1] - low[1]))
        if allowed(point):
            return point
    raise InputError(what, "finds no place in the scene", remedy)


def distance(a: Point, b: Point) -> float:
    """Between two places, by operations that round the same on every machine."""
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]))


def apart(point: Point, others: Iterable[Point], least: float) -> bool:
    """Whether a place is at least so far from all others."""
    return all(distance(point, other) >= least for other in others)


def square(side_m: float) -> list[Point]:
    """The corners of a square from the origin, counter-clockwise."""
    return [(0.0, 0.0), (side_m, 0.0), (side_m, side_m), (0.0, side_m)]
