"""Whether some point sees all of a polygon's border from inside, exactly."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.geometry.predicates import orientation

Floats = NDArray[np.float64]


def star_centre(ring: ArrayLike) -> tuple[float, float] | None:
    """A point strictly inside all of a ring's edges' half-planes, or None where none was found.

    `ring` has shape (n, 2) [m] and runs counter-clockwise. A polygon with such a point is
    star-shaped around it; that the point is one is decided exactly. Where the polygon's kernel has
    an inside, rounding can only miss it if it is far thinner than the polygon.

    >>> star_centre([(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)])
    (0.5, 0.5)
    >>> star_centre([(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]) is None
    True
    """
    points = np.asarray(ring, dtype=np.float64)
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    kernel = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    edges = list(zip(points, np.roll(points, -1, axis=0), strict=True))
    for a, b in edges:
        kernel = _left_of(kernel, a, b)
        if len(kernel) < 3:
            return None
    low, high = kernel.min(axis=0), kernel.max(axis=0)
    for centre in (kernel.mean(axis=0), (low + high) / 2.0):
        x, y = centre.tolist()
        if all(orientation(a[0], a[1], b[0], b[1], x, y) > 0 for a, b in edges):
            return x, y
    return None


def _left_of(polygon: Floats, a: Floats, b: Floats) -> Floats:
    """The part of a convex polygon left of the line from a to b."""
    d = b - a
    sides = d[0] * (polygon[:, 1] - a[1]) - d[1] * (polygon[:, 0] - a[0])
    kept: list[Floats] = []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if sides[i] >= 0.0:
            kept.append(polygon[i])
        if (sides[i] > 0.0 > sides[j]) or (sides[i] < 0.0 < sides[j]):
            part = sides[i] / (sides[i] - sides[j])
            kept.append(polygon[i] + part * (polygon[j] - polygon[i]))
    return np.array(kept).reshape(-1, 2)
