"""Rings of points: where they turn, which way they run, and what is wrong with them.

A ring is an array (n, 2) of float64 [m]; its last point is joined to its first, which is not
repeated. The sign of a turn is exact: a float filter, and rationals where it cannot tell.
"""

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

Ring = NDArray[np.float64]  # (n, 2) [m]

# Over twice the bound of [Shewchuk1997] on the error of an orientation, relative to its products.
_TURN_ERROR = 4 * float(np.finfo(np.float64).eps)
FARTHEST_M = 1e9  # [m] greater coordinates are no floor, and their products could overflow


class Fault(NamedTuple):
    """Something that keeps rings from bounding one floor."""

    ring: int  # 0 is the outer ring, hole i is i + 1
    problem: str
    remedy: str


def ring_name(ring: int) -> str:
    """What messages call a ring: `outer`, `holes[0]`, `holes[1]`, ..."""
    return "outer" if ring == 0 else f"holes[{ring - 1}]"


def turns(ring: Ring) -> NDArray[np.int8]:
    """The turn at each point, shape (n,): 1 to the left, -1 to the right, 0 straight on or back.

    >>> turns(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0]])).tolist()
    [1, 0, 1, 1]
    """
    before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
    return orientations(before, ring, after)


def orientations(a: Ring, b: Ring, c: Ring) -> NDArray[np.int8]:
    """The exact sign of (b - a) x (c - a) for each row, shape (n,)."""
    left = (a[:, 0] - c[:, 0]) * (b[:, 1] - c[:, 1])
    right = (a[:, 1] - c[:, 1]) * (b[:, 0] - c[:, 0])
    value = left - right
    # Below the smallest products underflow makes the relative bound void.
    limit = _TURN_ERROR * (np.abs(left) + np.abs(right)) + 1e-290
    signs = np.sign(value).astype(np.int8)
    for row in np.flatnonzero(np.abs(value) <= limit).tolist():
        signs[row] = _exact_orientation(*a[row].tolist(), *b[row].tolist(), *c[row].tolist())
    return signs


def _exact_orientation(ax: float, ay: float, bx: float, by: float, cx: float, cy: float) -> int:
    x, y = Fraction(cx), Fraction(cy)
    value = (Fraction(ax) - x) * (Fraction(by) - y) - (Fraction(ay) - y) * (Fraction(bx) - x)
    return (value > 0) - (value < 0)


def signed_area(ring: Ring) -> float:
    """The area inside a ring [m^2], negative where it runs clockwise."""
    x, y = (ring - ring[0]).T
    return float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])) / 2.0


def segments_of(rings: Iterable[Ring]) -> NDArray[np.float64]:
    """The edges of the rings, shape (n, 4): x0, y0, x1, y1, edge i leaving point i."""
    return np.concatenate([np.hstack((ring, np.roll(ring, -1, axis=0))) for ring in rings])


def find_fault(rings: Sequence[Ring]) -> Fault | None:
    """The first thing that keeps the rings from bounding one floor, `rings[0]` outside; or none.

    In this order: fewer than three points, a number that is not finite or is huge, a point twice
    in a ring, edges that cross, touch or overlap (of one ring or of two), wrong orientation (outer
    counter-clockwise, holes clockwise), a hole outside the outer ring or inside another hole.
    """
    for index, ring in enumerate(rings):
        fault = _fault_of_points(index, ring)
        if fault is not None:
            return fault
    return _fault_of_edges(rings) or _fault_of_orientation(rings) or _fault_of_nesting(rings)


def point_text(point: NDArray[np.float64]) -> str:
    """A point as messages show it."""
    return f"({point[0]:.9g}, {point[1]:.9g})"


def _fault_of_points(index: int, ring: Ring) -> Fault | None:
    if len(ring) < 3:
        return Fault(index, f"has {len(ring)} points", "give three or more")
    bad = np.flatnonzero(~(np.abs(ring) <= FARTHEST_M).all(axis=1))
    if len(bad):
        what = f"point {bad[0]} is {point_text(ring[bad[0]])}"
        return Fault(index, what, f"give finite numbers of metres, at most {FARTHEST_M:g}")
    order = np.lexsort((ring[:, 1], ring[:, 0]))
    same = np.flatnonzero((ring[order[1:]] == ring[order[:-1]]).all(axis=1))
    if len(same) == 0:
        return None
    first, second = sorted(int(order[same[0] + step]) for step in (0, 1))
    if second - first in (1, len(ring) - 1):
        closed = first == 0 and second == len(ring) - 1
        what = "the last point repeats the first" if closed else f"point {second} repeats the last"
        return Fault(index, f"{what}, {point_text(ring[first])}", "leave it out")
    return Fault(
        index,
        f"touches itself: points {first} and {second} are both {point_text(ring[first])}",
        "part it there, or run it through repair_polygon_map",
    )


def _fault_of_edges(rings: Sequence[Ring]) -> Fault | None:
    for index, ring in enumerate(rings):
        back = np.roll(ring, 1, axis=0) - ring
        ahead = np.roll(ring, -1, axis=0) - ring
        folded = np.flatnonzero((turns(ring) == 0) & ((back * ahead).sum(axis=1) > 0))
        if len(folded):
            at = int(folded[0])
            return Fault(
                index,
                f"turns back on itself at point {at}, {point_text(ring[at])}",
                "leave the point out, or run it through repair_polygon_map",
            )
    meeting = meeting_edges(rings)
    if len(meeting) == 0:
        return None
    of_ring = np.repeat(np.arange(len(rings)), [len(ring) for ring in rings])
    starts = np.cumsum([0, *(len(ring) for ring in rings)])
    one, other = meeting[0].tolist()
    ring, second = int(of_ring[one]), int(of_ring[other])
    ends = segments_of(rings).reshape(-1, 2, 2)
    crossing = shapely.intersection(shapely.LineString(ends[one]), shapely.LineString(ends[other]))
    where = shapely.get_coordinates(crossing)
    place = f" at {point_text(where[0])}" if len(where) else ""
    what = f"edge {one - starts[ring]} meets "
    what += "" if ring == second else f"{ring_name(second)} "
    return Fault(
        ring, f"{what}edge {other - starts[second]}{place}", "run it through repair_polygon_map"
    )


def meeting_edges(rings: Sequence[Ring]) -> NDArray[np.intp]:
    """Pairs of edges that meet though neither follows the other, shape (m, 2), in order.

    Edges are numbered through all rings as in `segments_of`.
    """
    ends = segments_of(rings).reshape(-1, 2, 2)
    lines = np.asarray(shapely.linestrings(ends), dtype=np.object_)
    pairs = shapely.STRtree(lines).query(lines, predicate="intersects").T
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    following = np.concatenate(
        [start + np.roll(np.arange(count), -1) for start, count in _spans(rings)]
    )
    one, other = pairs.T
    apart = pairs[(following[one] != other) & (following[other] != one)]
    return apart[np.lexsort((apart[:, 1], apart[:, 0]))]


def _spans(rings: Sequence[Ring]) -> list[tuple[int, int]]:
    counts = [len(ring) for ring in rings]
    starts = np.cumsum([0, *counts[:-1]]).tolist()
    return list(zip(starts, counts, strict=True))


def is_counter_clockwise(ring: Ring) -> bool:
    """Whether a simple ring runs counter-clockwise, exactly."""
    # The least point in the order of (x, y) is a corner of the convex hull: the ring turns there.
    lowest = int(np.lexsort((ring[:, 1], ring[:, 0]))[0])
    before, after = ring[lowest - 1], ring[(lowest + 1) % len(ring)]
    return bool(orientations(before[None], ring[lowest][None], after[None])[0] > 0)


def _fault_of_orientation(rings: Sequence[Ring]) -> Fault | None:
    for index, ring in enumerate(rings):
        if is_counter_clockwise(ring) != (index == 0):
            runs, wanted = ("clockwise", "outer") if index == 0 else ("counter-clockwise", "hole")
            return Fault(
                index, f"runs {runs}", f"turn round the order of its points: {wanted} rings do not"
            )
    return None


def _fault_of_nesting(rings: Sequence[Ring]) -> Fault | None:
    if len(rings) == 1:
        return None
    # No edges meet, so one point tells for the whole ring.
    firsts = np.array([ring[0] for ring in rings[1:]])
    outer = shapely.Polygon(rings[0])
    shapely.prepare(outer)
    outside = np.flatnonzero(~shapely.contains_xy(outer, firsts[:, 0], firsts[:, 1]))
    if len(outside):
        at = int(outside[0])
        return Fault(
            at + 1, f"lies outside the outer ring at {point_text(firsts[at])}", "leave it out"
        )
    holes = np.array([shapely.Polygon(ring) for ring in rings[1:]], dtype=object)
    found = shapely.STRtree(holes).query(shapely.points(firsts), predicate="within").T
    found = found[found[:, 0] != found[:, 1]]
    if len(found) == 0:
        return None
    inner, enclosing = (int(hole) for hole in found[0])
    return Fault(
        inner + 1,
        f"lies inside holes[{enclosing}] at {point_text(firsts[inner])}",
        "leave it out",
    )
