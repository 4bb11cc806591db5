"""How long calls take, and how that grows."""

from collections.abc import Callable, Sequence
from time import perf_counter
from typing import NamedTuple, TypeVar

import numpy as np

T = TypeVar("T")
Progress = Callable[[str], None]


def timed(call: Callable[[], T], budget_s: float) -> tuple[T, float]:
    """What a call returns and its shortest wall time [s] among as many as fit into that time.

    The shortest, because whatever else the machine does only ever adds to it. One call goes before
    them, which compiles and fills caches.
    """
    result = call()
    best = np.inf
    until = perf_counter() + budget_s
    while True:
        start = perf_counter()
        call()
        end = perf_counter()
        best = min(best, end - start)
        if end >= until:
            return result, best


class Fit(NamedTuple):
    """y = constant * x^exponent."""

    exponent: float
    constant: float


def fit_power(x: Sequence[float], y: Sequence[float]) -> Fit:
    """The power law through the points, which must be positive and of two x at least."""
    slope, constant = np.polyfit(np.log(x), np.log(y), 1)
    return Fit(float(slope), float(np.exp(constant)))
