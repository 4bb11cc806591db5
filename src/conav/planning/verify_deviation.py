"""How far a driven way is from a planned one that began late, for the verifier.

Over a time of half-length h around its middle both motions are straight, give or take A h^2 / 2
with A a bound on the relative acceleration. The distance of straight motions is greatest at an end,
so that greatest more this amount is an upper bound; the distance at one time is a lower bound.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.verify_curves import place_at, relative_bending, velocity_at

SHARP = 1e-7
"""[m] between the bounds on a greatest distance."""

_STACK = 256
_SHORTEST = 1e-12  # [s] never halved below


@kernel
def most_apart(
    a: NDArray[np.float64], b: NDArray[np.float64], begin: float, end: float, enough: float
) -> tuple[float, float, float]:
    """Bounds on the greatest distance of two pieces between two times, and a time of the lower one.

    Distances up to `enough` are of no interest: both bounds may then be any number below it.
    """
    curved = relative_bending(a, b)
    starts = np.empty(_STACK)
    ends = np.empty(_STACK)
    starts[0] = begin
    ends[0] = end
    height = 1
    low = 0.0
    high = 0.0
    when = begin
    while height > 0:
        height -= 1
        t0 = starts[height]
        t1 = ends[height]
        h = (t1 - t0) / 2.0
        t = t0 + h
        ax, ay = place_at(a, t)
        bx, by = place_at(b, t)
        avx, avy = velocity_at(a, t)
        bvx, bvy = velocity_at(b, t)
        x = bx - ax
        y = by - ay
        vx = bvx - avx
        vy = bvy - avy
        bound = max(np.hypot(x - vx * h, y - vy * h), np.hypot(x + vx * h, y + vy * h))
        bound += curved * h * h / 2.0
        for k in range(3):
            at = t0 if k == 0 else (t if k == 1 else t1)
            ax, ay = place_at(a, at)
            bx, by = place_at(b, at)
            found = np.hypot(bx - ax, by - ay)
            if found > low:
                low = found
                when = at
        if bound <= max(low + SHARP, enough) or h < _SHORTEST or height + 2 > _STACK:
            high = max(high, bound)
            continue
        starts[height] = t0
        ends[height] = t
        starts[height + 1] = t
        ends[height + 1] = t1
        height += 2
    return low, max(high, low), when


@kernel
def deviation(
    planned: NDArray[np.float64], driven: NDArray[np.float64]
) -> tuple[float, float, float]:
    """Bounds on the greatest distance of two ways, (n, 9) and (m, 9), while both last, and when."""
    low = 0.0
    high = 0.0
    when = 0.0
    i = 0
    j = 0
    while i < len(planned) and j < len(driven):
        begin = max(planned[i, 0], driven[j, 0])
        end = min(planned[i, 1], driven[j, 1])
        if begin <= end:
            lo, hi, t = most_apart(planned[i], driven[j], begin, end, low)
            high = max(high, hi)
            if lo > low:
                low = lo
                when = t
        if planned[i, 1] <= driven[j, 1]:
            i += 1
        else:
            j += 1
    return low, high, when
