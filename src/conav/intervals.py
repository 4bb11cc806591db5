"""Estimates with 95 % intervals: shares that were counted, means and ratios over repetitions."""

from collections.abc import Callable, Sequence
from math import exp, inf, isfinite, log, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Z = 1.959963984540054  # 97.5 % of a normal distribution lie below


class Share(NamedTuple):
    """A share that was counted, with its 95 % interval."""

    successes: int
    trials: int
    share: float
    low: float
    high: float


class Estimate(NamedTuple):
    """A value with its 95 % interval, from so many independent repetitions."""

    value: float
    low: float
    high: float
    n: int


def wilson(successes: int, trials: int) -> Share:
    """The share `successes / trials` with the score interval of [Wilson1927] at 95 %.

    Raises `ValueError` unless 0 <= successes <= trials and trials > 0.
    """
    if not 0 <= successes <= trials or trials == 0:
        raise ValueError(f"{successes} of {trials} is no share")
    share = successes / trials
    square = _Z * _Z / trials
    centre = share + square / 2.0
    half = _Z * sqrt(share * (1.0 - share) / trials + square / (4.0 * trials))
    # At the ends the interval touches 0 or 1 exactly; rounding must not move it.
    low = 0.0 if successes == 0 else (centre - half) / (1.0 + square)
    high = 1.0 if successes == trials else (centre + half) / (1.0 + square)
    return Share(successes, trials, share, low, high)


def mean_interval(values: ArrayLike) -> Estimate:
    """The mean of independent values with Student's t interval at 95 %.

    With fewer than two values the interval is unbounded. Raises `ValueError` for none.
    """
    array = np.asarray(values, dtype=np.float64).reshape(-1)
    n = len(array)
    if n == 0:
        raise ValueError("no value to take the mean of")
    mean = float(array.mean())
    if n == 1:
        return Estimate(mean, -inf, inf, 1)
    from scipy.stats import t  # takes longer to import than all else here

    half = float(t.ppf(0.975, n - 1)) * float(array.std(ddof=1)) / sqrt(n)
    return Estimate(mean, mean - half, mean + half, n)


def ratio_interval(above: Sequence[float], below: Sequence[float]) -> Estimate:
    """The geometric mean of the ratios of paired positive values, with its 95 % interval.

    Raises `ValueError` for values that are not positive or not paired.
    """
    if len(above) != len(below) or min(*above, *below, inf) <= 0:
        raise ValueError("ratios need pairs of positive values")
    found = mean_interval([log(a / b) for a, b in zip(above, below, strict=True)])
    high = exp(found.high) if found.high < 700 else inf
    return Estimate(exp(found.value), exp(found.low), high, found.n)


def bootstrap_interval(
    statistic: Callable[[NDArray[np.int64]], float],
    n: int,
    rng: np.random.Generator,
    resamples: int = 2000,
) -> Estimate:
    """A statistic of `n` independent repetitions with its 95 % percentile interval [Efron1979].

    `statistic` is called with the numbers of the repetitions it is to be taken of, (n,), which in a
    resample are drawn with replacement; resamples of which it is not finite are left out. With
    fewer than two repetitions the interval is unbounded. Raises `ValueError` for none.

    >>> values = np.array([1.0, 2.0, 3.0, 6.0])
    >>> bootstrap_interval(lambda at: values[at].mean(), 4, np.random.default_rng(0)).value
    3.0
    """
    if n < 1:
        raise ValueError("no repetitions to draw from")
    value = float(statistic(np.arange(n)))
    if n == 1:
        return Estimate(value, -inf, inf, 1)
    drawn = [float(statistic(rng.integers(n, size=n))) for _ in range(resamples)]
    finite = [one for one in drawn if isfinite(one)]
    if not finite:
        return Estimate(value, -inf, inf, n)
    low, high = np.percentile(finite, [2.5, 97.5]).tolist()
    return Estimate(value, low, high, n)
