"""An escape as an explicit path of the evader, made of points that stay hidden and ways between."""

from collections import deque
from itertools import pairwise
from typing import cast

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.maps.polygon_map import PolygonMap
from conav.pursuit.types import Schedule
from conav.pursuit.verify_decide import Decision, witness
from conav.pursuit.verify_escape_check import EvaderPath, escape_faults, evader_path
from conav.pursuit.verify_lattice import Point
from conav.pursuit.verify_polygons import face_polygons
from conav.pursuit.verify_step import Stepper
from conav.pursuit.verify_timeline import Ranges

Places = list[tuple[float, float]]

HASTIEST = 40  # powers of two by which a way may be faster than the motion it falls into


def escape_path(
    decision: Decision, stepper: Stepper, plan: PolygonMap, schedule: Schedule, ranges: Ranges
) -> EvaderPath | None:
    """A path along the route of an escape that its check accepts; None where none was found.

    The evader waits at a point that stays hidden during each motion and changes to the next point
    within the shadow that holds both, in a time so short that the shadow hardly moves.
    """
    pieces, route = decision.pieces, decision.route
    stays: list[Point] = []
    for k, piece in enumerate(pieces):
        point = witness(piece, route[k], route[k + 1], stepper)
        assert point is not None
        stays.append(point)
    ways = [_way(decision, stepper, k, stays[k], stays[k + 1]) for k in range(len(pieces) - 1)]
    if any(way is None for way in ways):
        return None
    for haste in range(4, HASTIEST, 6):
        path = _timed(decision, stepper, schedule, stays, [way or [] for way in ways], haste)
        if path is not None and not escape_faults(plan, schedule, ranges, path):
            return path
    return None


def _way(decision: Decision, stepper: Stepper, k: int, a: Point, b: Point) -> Places | None:
    """Places between a and b within the shadow after piece k, through the sides of triangles."""
    if a == b:
        return []
    step = decision.pieces[k].step(stepper)
    shadow = shapely.union_all(
        face_polygons(step, np.flatnonzero(step.regions.new == decision.route[k + 1]))
    )
    triangles = cast(
        "list[shapely.Polygon]", list(shapely.constrained_delaunay_triangles(shadow).geoms)
    )
    ends = [_holder(triangles, point) for point in (a, b)]
    sides: dict[frozenset[tuple[float, float]], list[int]] = {}
    for t, triangle in enumerate(triangles):
        corners = list(triangle.exterior.coords)
        for (ax, ay), (bx, by) in pairwise(corners):
            sides.setdefault(frozenset(((ax, ay), (bx, by))), []).append(t)
    near: list[list[tuple[int, tuple[float, float]]]] = [[] for _ in triangles]
    for side, holders in sides.items():
        if len(holders) == 2:
            (ax, ay), (bx, by) = side
            middle = ((ax + bx) / 2, (ay + by) / 2)
            near[holders[0]].append((holders[1], middle))
            near[holders[1]].append((holders[0], middle))
    came: dict[int, tuple[int, tuple[float, float]] | None] = {ends[0]: None}
    queue = deque([ends[0]])
    while queue and ends[1] not in came:
        at = queue.popleft()
        for other, middle in near[at]:
            if other not in came:
                came[other] = (at, middle)
                queue.append(other)
    if ends[1] not in came:
        return None
    way: Places = []
    back = came[ends[1]]
    while back is not None:
        way.append(back[1])
        back = came[back[0]]
    return way[::-1]


def _holder(triangles: list[shapely.Polygon], point: Point) -> int:
    distances = [triangle.distance(shapely.Point(point)) for triangle in triangles]
    return int(np.argmin(distances))


def _timed(
    decision: Decision,
    stepper: Stepper,
    schedule: Schedule,
    stays: list[Point],
    ways: list[Places],
    haste: int,
) -> EvaderPath | None:
    """The evader's path when ways take the 2^-haste of a motion; None where times run together."""
    times: list[float] = [float(schedule.times[0])]
    places: list[tuple[float, float]] = [stays[0]]
    pieces = decision.pieces
    for k, piece in enumerate(pieces):
        begin, end = _span(schedule, decision, k)
        share = (end - begin) * 2.0**-haste
        if piece.instant:
            if k > 0:
                # Be there before the moment: at it one is hidden from old and new pursuers.
                before, _ = _span(schedule, decision, k - 1)
                start = begin - (begin - before) * 2.0**-haste
                _walk(times, places, start, begin, [*ways[k - 1], stays[k]])
            continue
        if k > 0:
            _walk(times, places, begin, begin + share, [*ways[k - 1], stays[k]])
        if end > times[-1]:
            times.append(end)
            places.append(stays[k])
    if any(b <= a for a, b in pairwise(times)):
        return None
    return evader_path(times, stepper.lattice.metres(np.array(places, dtype=np.float64)))


def _span(schedule: Schedule, decision: Decision, k: int) -> tuple[float, float]:
    piece = decision.pieces[k]
    begin = float(schedule.times[piece.leg])
    if piece.instant:
        return begin, begin
    end = float(schedule.times[piece.leg + 1])
    first, last = (float(part) for part in piece.part)
    return begin + (end - begin) * first, end if last == 1.0 else begin + (end - begin) * last


def _walk(
    times: list[float],
    places: list[tuple[float, float]],
    begin: float,
    end: float,
    way: Places | NDArray[np.float64],
) -> None:
    """Add the way to the path, from the last place on, between two times."""
    if tuple(way[-1]) == tuple(places[-1]) and len(way) == 1:
        return
    if times[-1] > begin:
        # The wait before, which was noted up to its end, ends sooner.
        del times[-1], places[-1]
    if times[-1] < begin:
        times.append(begin)
        places.append(places[-1])
    for n, place in enumerate(way, start=1):
        times.append(begin + (end - begin) * n / len(way))
        places.append((float(place[0]), float(place[1])))
    times[-1] = end
