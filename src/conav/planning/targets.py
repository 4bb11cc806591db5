"""Places in the regions of a task, for samples and for straight ways to them."""

import math

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.clearance import point_segment_square
from conav.planning.labels import in_polygon

TRIES = 8
"""To hit a region from its bounding box."""

_DEPTH = 1e-6  # [m] straight ways end that far inside a region


@kernel
def place_in(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    target: int,
    u: float,
    v: float,
) -> tuple[float, float, bool]:
    """A place of a region's bounding box, and whether it is in the region."""
    if target < len(discs):
        dx = 2.0 * u - 1.0
        dy = 2.0 * v - 1.0
        r = discs[target, 2]
        return discs[target, 0] + r * dx, discs[target, 1] + r * dy, dx * dx + dy * dy < 1.0
    ring = target - len(discs)
    x = rings[ring, 2] + u * (rings[ring, 4] - rings[ring, 2])
    y = rings[ring, 3] + v * (rings[ring, 5] - rings[ring, 3])
    return x, y, in_polygon(rings, sides, ring, x, y)


@kernel
def nearest_in(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    target: int,
    x: float,
    y: float,
) -> tuple[float, float, bool]:
    """A place just inside a region, nearest to one outside, and whether there is one."""
    if target < len(discs):
        r = discs[target, 2]
        dx = x - discs[target, 0]
        dy = y - discs[target, 1]
        away = math.sqrt(dx * dx + dy * dy)
        if away <= r:
            return x, y, False
        keep = (r - min(_DEPTH, 0.5 * r)) / away
        return discs[target, 0] + keep * dx, discs[target, 1] + keep * dy, True
    ring = target - len(discs)
    if in_polygon(rings, sides, ring, x, y):
        return x, y, False
    best = np.inf
    found_x = x
    found_y = y
    for side in range(int(rings[ring, 0]), int(rings[ring, 1])):
        x0, y0, x1, y1 = sides[side]
        away = point_segment_square(x, y, x0, y0, x1, y1)
        if away < best:
            best = away
            dx = x1 - x0
            dy = y1 - y0
            length = math.sqrt(dx * dx + dy * dy)
            margin = min(2.0 * _DEPTH / length, 0.5)
            along = ((x - x0) * dx + (y - y0) * dy) / (length * length)
            along = min(max(along, margin), 1.0 - margin)
            # Regions lie on the left of their sides.
            found_x = x0 + along * dx - _DEPTH * dy / length
            found_y = y0 + along * dy + _DEPTH * dx / length
    return found_x, found_y, in_polygon(rings, sides, ring, found_x, found_y)
