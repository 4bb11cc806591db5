"""A point well inside a polygon, rounded."""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

Floats = NDArray[np.float64]


@kernel
def inner_point(border: Floats) -> tuple[float, float, float]:
    """A point inside a polygon, and how far from its border along both axes, roughly.

    The middle of the longest piece of the level line half-way up the largest gap between the levels
    of corners.
    """
    levels = np.sort(border[:, 1])
    best = 0
    for i in range(levels.shape[0] - 1):
        if levels[i + 1] - levels[i] > levels[best + 1] - levels[best]:
            best = i
    y = (levels[best] + levels[best + 1]) / 2.0
    crossings = np.empty(border.shape[0])
    count = 0
    for i in range(border.shape[0]):
        ax, ay = border[i]
        bx, by = border[(i + 1) % border.shape[0]]
        if (ay < y) != (by < y):
            crossings[count] = ax + (y - ay) / (by - ay) * (bx - ax)
            count += 1
    crossings = np.sort(crossings[:count])
    x = border[0, 0]
    width = 0.0
    for i in range(0, count - 1, 2):
        if crossings[i + 1] - crossings[i] > width:
            width = crossings[i + 1] - crossings[i]
            x = (crossings[i] + crossings[i + 1]) / 2.0
    return x, y, min(width, levels[best + 1] - levels[best])
