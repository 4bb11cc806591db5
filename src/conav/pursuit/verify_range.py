"""A limited range as a polygon inside its circle, for the verifier."""

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from conav.pursuit.verify_sight import REACH

SIDES = 64
"""Of the polygon; it misses up to an eighth of a percent of the range."""

# Just under tan(22.5 degrees): the half-angle tangent of a point just before the diagonal.
_EIGHTH = Fraction(12, 29)

Point = tuple[int, int]


def range_units(range_m: float, unit_m: float) -> int:
    """A range in lattice units, rounded down."""
    return int(Fraction(range_m) / Fraction(unit_m))


def inscribed_polygon(centre: Point, radius: int, corners: NDArray[np.int64]) -> list[Point]:
    """A convex polygon within a circle, counter-clockwise, its corners on lattice points.

    Empty where it holds all `corners` of the floor: then nothing is out of range. Corners beyond
    the lattice's border are moved to it; the floor lies so far from there that it is not cut.
    """
    cx, cy = centre
    radius = min(radius, 4 * REACH)
    octant = [_on_circle(radius, _EIGHTH * k / (SIDES // 8)) for k in range(SIDES // 8 + 1)]
    arc = octant + [(y, x) for x, y in octant]
    offsets = [turned for x, y in arc for turned in ((x, y), (-y, x), (-x, -y), (y, -x))]
    polygon = _hull([(_bounded(cx + x), _bounded(cy + y)) for x, y in offsets])
    for (ax, ay), (bx, by) in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        left = (bx - ax) * (corners[:, 1] - ay) - (by - ay) * (corners[:, 0] - ax)
        if (left <= 0).any():
            return polygon
    return []


def _on_circle(radius: int, half_tangent: Fraction) -> Point:
    """A lattice point on or just within the circle round the origin, from a rational point of it.

    Rounding down in both coordinates goes towards the origin.
    """
    t = half_tangent
    return int(radius * (1 - t * t) / (1 + t * t)), int(radius * 2 * t / (1 + t * t))


def _bounded(coordinate: int) -> int:
    return max(-REACH, min(REACH, coordinate))


def _hull(points: list[Point]) -> list[Point]:
    """The corners of the convex hull, counter-clockwise."""
    ordered = sorted(set(points))
    chains: list[list[Point]] = []
    for run in (ordered, ordered[::-1]):
        chain: list[Point] = []
        for x, y in run:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0:
                    break
                chain.pop()
            chain.append((x, y))
        chains.append(chain[:-1])
    return chains[0] + chains[1]
