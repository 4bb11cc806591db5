"""Medians and ratios with 95 % intervals that assume no distribution."""

from collections.abc import Sequence
from math import comb, exp, inf

import numpy as np
from numpy.typing import NDArray

from conav.intervals import Estimate

ENOUGH = 6
"""With fewer values nothing lies in between the least and the greatest with 95 %."""

RESAMPLES = 4000
_AT_ONCE = 4_000_000  # numbers drawn


def median_interval(values: Sequence[float]) -> Estimate:
    """The median with its 95 % interval: between two of the values, by their ranks.

    The k-th least and the k-th greatest of n values have the median between them unless fewer than
    k values, each with probability 1/2, lie on one side; k is the greatest for which that is at
    most 5 %. Exact whatever the distribution, and the interval of times that are known only to
    be at least the time limit is right, too. Unbounded with fewer than `ENOUGH` values. Raises
    `ValueError` for none.
    """
    n = len(values)
    if n == 0:
        raise ValueError("no value to take the median of")
    ordered = sorted(values)
    middle = float(np.median(ordered))
    # Integers, as 2 ** n times the probability: at most 1/40 on either side.
    k, below = 0, 1
    while 40 * below <= 2**n:
        k += 1
        below += comb(n, k)
    if k == 0:
        return Estimate(middle, -inf, inf, n)
    return Estimate(middle, ordered[k - 1], ordered[n - k], n)


def ratio_bootstrap(above: Sequence[float], below: Sequence[float]) -> Estimate:
    """The geometric mean of the ratios of paired positive values, with its 95 % interval.

    The interval is the percentile bootstrap (Efron 1979) over the pairs. Its generator has a seed
    of its own, so the same pairs give the same interval. Unbounded with fewer than `ENOUGH` pairs.
    Raises `ValueError` for none, and for values that are not positive or not paired.
    """
    if len(above) != len(below) or not above or min(*above, *below) <= 0:
        raise ValueError("ratios need pairs of positive values")
    logs = np.log(np.array(above)) - np.log(np.array(below))
    n = len(logs)
    value = exp(float(logs.mean()))
    if n < ENOUGH:
        return Estimate(value, -inf, inf, n)
    low, high = np.percentile(_resampled_means(logs), [2.5, 97.5])
    return Estimate(value, exp(float(low)), exp(float(high)), n)


def _resampled_means(values: NDArray[np.float64]) -> NDArray[np.float64]:
    rng = np.random.Generator(np.random.PCG64(0))
    n = len(values)
    rows = max(_AT_ONCE // n, 1)
    parts = [
        values[rng.integers(n, size=(min(rows, RESAMPLES - done), n))].mean(axis=1)
        for done in range(0, RESAMPLES, rows)
    ]
    return np.concatenate(parts)
