"""Floor plans out of rings that are not quite right; every step is told in words.

The steps, each taken only where it is needed, so that rings without a fault stay as they are:

1. A point equal to the one before it, or within `NEAR_M` of it, is left out.
2. A point where a wall runs out and straight back on itself is left out.
3. A ring without area is left out if it is a hole; an outer one is an error.
4. Rings that run the wrong way round are turned round.
5. Rings that cross, overlap or touch, themselves or each other, are drawn over each other: the
   floor is where the outer ring winds round in the sense it mostly does, and no hole winds round.
   Where a ring laps over itself the floor is not holed. A loop that winds the other way is what a
   crossing leaves: it is left out, or an error where it has `AMBIGUOUS_SHARE` of the area.
6. Walls that meet in a single point are taken for two walls with a gap of nothing between them, and
   an evader of radius zero passes through nothing: the point is widened to a gap of `GAP_M`. With
   `close_touching` it is closed by that much instead.
7. Pieces and holes with a mean width under `SLIVER_M` are left out.
8. Of several pieces the largest is the floor. It is an error when the second has `AMBIGUOUS_SHARE`
   of their area and rings of one plan fell apart, because then nobody knows which was meant. A file
   with several outer rings is plain enough: the largest is taken, or the one that `part` names.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import ArrayLike

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.maps.rings import (
    FARTHEST_M,
    Ring,
    find_fault,
    is_counter_clockwise,
    meeting_edges,
    point_text,
    ring_name,
    segments_of,
    signed_area,
    turns,
)

NEAR_M = 1e-9  # [m] points nearer to the one before are the same point
SLIVER_M = 1e-6  # [m] what is narrower is a rounding error, no room
GAP_M = 1e-4  # [m] width of the gap at a point where walls only touch
AMBIGUOUS_SHARE = 0.1  # of the area

_TRIES = 8  # rounds of opening points that touch; one is enough unless points lie close together


def repair_polygon_map(
    outer: ArrayLike,
    holes: Sequence[ArrayLike] = (),
    *,
    name: str = "floor plan",
    close_touching: bool = False,
) -> PolygonMap:
    """A floor plan of rings with faults, its `warnings` saying what was done; see above.

    Raises `InputError` for fewer than three points, numbers that are none, a ring without area
    and a plan that falls into pieces of similar size.

    >>> plan = repair_polygon_map([(0, 0), (0, 3), (3, 3), (3, 3), (3, 0), (0, 0)])
    >>> for warning in plan.warnings:
    ...     print(warning)
    left out 2 points repeating the one before (outer)
    turned round, so that outer runs counter-clockwise and holes clockwise: outer
    """
    return floor_of_parts([[outer, *holes]], name=name, close_touching=close_touching)


def floor_of_parts(
    parts: Sequence[Sequence[ArrayLike]],
    *,
    name: str = "floor plan",
    part: int | None = None,
    close_touching: bool = False,
    notes: Sequence[str] = (),
) -> PolygonMap:
    """The floor plan of one of several polygons, each an outer ring followed by holes, repaired.

    `part` names one, counted from 0; without it the largest is taken, with a warning. `notes` go
    before the other warnings.

    Raises `InputError` as `repair_polygon_map` does, and where `part` is not there.
    """
    notes = list(notes)
    if not parts:
        raise InputError(name, "has no polygon", "give an outer ring")
    if part is not None and not 0 <= part < len(parts):
        raise InputError(
            f"{name}: part {part}", f"there are {len(parts)}", f"give 0 to {len(parts) - 1}"
        )
    rings = [
        [
            _points(f"{name}: {_label(index, len(parts), ring)}", each)
            for ring, each in enumerate(polygon)
        ]
        for index, polygon in enumerate(parts)
    ]
    if part is None:
        areas = [abs(signed_area(polygon[0])) for polygon in rings]
        part = int(np.argmax(areas))
        if len(parts) > 1:
            rest = sum(areas) - areas[part]
            notes.append(
                f"took part {part}, {areas[part]:.4g} m2, the largest of {len(parts)} outer rings;"
                f" the others have {rest:.4g} m2 together; name one to take it instead"
            )
    return _floor(rings[part], name, notes, close_touching)


def _label(part: int, parts: int, ring: int) -> str:
    return ring_name(ring) if parts == 1 else f"part {part}, {ring_name(ring)}"


def _points(place: str, points: ArrayLike) -> Ring:
    try:
        ring = np.array(points, dtype=np.float64) + 0.0
    except (TypeError, ValueError) as error:
        raise InputError(place, "holds something that is no number", "give (x, y) rows") from error
    if ring.ndim != 2 or ring.shape[1] != 2 or len(ring) < 3:
        raise InputError(place, f"has the shape {ring.shape}", "give three or more (x, y) rows")
    bad = np.flatnonzero(~(np.abs(ring) <= FARTHEST_M).all(axis=1))
    if len(bad):
        raise InputError(
            place,
            f"point {bad[0]} is {point_text(ring[bad[0]])}",
            f"give finite numbers of metres, at most {FARTHEST_M:g}",
        )
    return ring


def _floor(rings: list[Ring], name: str, notes: list[str], close: bool) -> PolygonMap:
    cleaned: list[Ring] = []
    repeats: dict[str, int] = {}
    spikes: dict[str, int] = {}
    for index, ring in enumerate(rings):
        label = ring_name(index)
        apart = _without_repeats(ring)
        bare = _without_spikes(apart)
        if len(bare) < 3:
            if index == 0:
                raise InputError(f"{name}: {label}", "has no area", "give another ring")
            notes.append(f"{label}: left out, it has no area")
            continue
        repeats[label], spikes[label] = len(ring) - len(apart), len(apart) - len(bare)
        cleaned.append(bare)
    _tell("left out {} repeating the one before", repeats, notes)
    _tell("left out {} where a wall runs back on itself", spikes, notes)
    oriented = _turned_round(cleaned, notes)
    if find_fault(oriented) is None:
        return PolygonMap(oriented[0], oriented[1:], name, tuple(notes))
    return _drawn_anew(oriented, name, notes, close)


def _tell(what: str, points: dict[str, int], notes: list[str]) -> None:
    """Adds a note on the points of each ring that has any."""
    labels = [label for label, count in points.items() if count]
    if labels:
        notes.append(f"{what.format(_count(sum(points.values()), 'point'))} ({_few(labels)})")


def _without_repeats(ring: Ring) -> Ring:
    kept: list[int] = []
    for point in range(len(ring)):
        if not kept or np.abs(ring[point] - ring[kept[-1]]).max() > NEAR_M:
            kept.append(point)
    while len(kept) > 1 and np.abs(ring[kept[-1]] - ring[kept[0]]).max() <= NEAR_M:
        kept.pop()
    return ring[kept]


def _without_spikes(ring: Ring) -> Ring:
    while len(ring) >= 3:
        back = np.roll(ring, 1, axis=0) - ring
        ahead = np.roll(ring, -1, axis=0) - ring
        folded = np.flatnonzero((turns(ring) == 0) & ((back * ahead).sum(axis=1) > 0))
        if len(folded) == 0:
            return ring
        ring = _without_repeats(np.delete(ring, folded[0], axis=0))
    return ring[:0]


def _turned_round(rings: list[Ring], notes: list[str]) -> list[Ring]:
    """The rings run as `PolygonMap` wants them to; those that cross themselves by their area."""
    result: list[Ring] = []
    turned: list[str] = []
    for index, ring in enumerate(rings):
        crosses = len(meeting_edges([ring])) > 0
        positive = signed_area(ring) > 0 if crosses else is_counter_clockwise(ring)
        result.append(ring if positive == (index == 0) else ring[::-1])
        if positive != (index == 0):
            turned.append(ring_name(index))
    if turned:
        notes.append(
            "turned round, so that outer runs counter-clockwise and holes clockwise:"
            f" {_few(turned)}"
        )
    return result


def _drawn_anew(rings: list[Ring], name: str, notes: list[str], close: bool) -> PolygonMap:
    """Steps 5 to 8."""
    told = len(notes)
    for index, ring in enumerate(rings):
        where = _meeting_points([ring])
        if where:
            notes.append(f"{ring_name(index)}: meets itself at {_list_points(where)}")
    region = _inside(rings[0], name, notes)
    for index, hole in enumerate(rings[1:], start=1):
        solid = shapely.union_all(_lobes(hole))
        if not shapely.contains_properly(region, solid):
            if not shapely.intersects(region, solid):
                notes.append(f"{ring_name(index)}: left out, it lies outside the floor")
                continue
            others = "" if shapely.covers(region, solid) else " and reaches out of it"
            notes.append(f"{ring_name(index)}: touches the walls round the floor{others}")
        region = shapely.difference(region, solid)
    if len(notes) == told:
        notes.append("rings touch or lie in each other; they were drawn over each other")
    for _ in range(_TRIES):
        pieces = _pieces(region, name, notes)
        points = _meeting_points(_rings_of(pieces))
        if not points:
            break
        end = "closed" if close else "widened to a gap of 0.1 mm"
        notes.append(f"walls touch at {_list_points(points)}; the point was {end}")
        spots = shapely.union_all([_spot(point) for point in points])
        region = shapely.difference(region, spots) if close else shapely.union(region, spots)
    pieces = _pieces(region, name, notes)
    areas = [piece.area for piece in pieces]
    if len(areas) > 1 and areas[1] >= AMBIGUOUS_SHARE * sum(areas):
        raise InputError(
            name,
            f"falls into {len(areas)} pieces, the two largest of {areas[0]:.4g} and"
            f" {areas[1]:.4g} m2, near {_centre(pieces[0])} and {_centre(pieces[1])}",
            "correct the rings so that one floor is meant",
        )
    if len(areas) > 1:
        notes.append(
            f"took the largest of {len(areas)} pieces, {areas[0]:.4g} m2; the others have"
            f" {sum(areas[1:]):.4g} m2 together"
        )
    drawn = _rings_of([shapely.orient_polygons(pieces[0])])
    outer, *holes = [_without_spikes(_without_repeats(ring)) for ring in drawn]
    return PolygonMap(outer, holes, name, tuple(notes))


def _inside(ring: Ring, name: str, notes: list[str]) -> shapely.Geometry:
    """What an outer ring winds round in the sense it mostly does."""
    lobes = _lobes(ring)
    areas = [float(shapely.area(lobe)) for lobe in lobes]
    other, main = sorted(areas)
    if main == 0:
        raise InputError(f"{name}: {ring_name(0)}", "has no area", "give another ring")
    if other >= AMBIGUOUS_SHARE * (main + other):
        raise InputError(
            f"{name}: {ring_name(0)}",
            f"crosses itself: {main:.4g} m2 lie to one side of it and {other:.4g} m2 to the other",
            "correct the ring, so that one floor is meant",
        )
    if other > 0:
        notes.append(f"left out loops behind crossings, {other:.4g} m2 together")
    return lobes[areas.index(main)]


def _lobes(ring: Ring) -> list[shapely.Geometry]:
    """Where a ring winds round counter-clockwise, and where clockwise."""
    closed = np.vstack((ring, ring[:1]))
    lines = shapely.union_all(shapely.linestrings(segments_of([ring]).reshape(-1, 2, 2)))
    faces = shapely.get_parts(shapely.polygonize([lines]))
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    windings = np.array([_winding(closed, at) for at in inside])
    return [shapely.union_all(faces[windings * sense > 0]) for sense in (1, -1)]


def _winding(closed: Ring, at: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> int:
    """How often a closed ring winds round a point, by its crossings of the ray to the right."""
    x, y = (closed - at).T
    up = (y[:-1] <= 0) & (y[1:] > 0)
    down = (y[:-1] > 0) & (y[1:] <= 0)
    side = x[:-1] * y[1:] - y[:-1] * x[1:]
    return int(np.count_nonzero(up & (side > 0)) - np.count_nonzero(down & (side < 0)))


def _meeting_points(rings: Sequence[Ring]) -> list[Ring]:
    """Where edges of rings meet that do not follow each other, in the order of (x, y)."""
    meeting = meeting_edges(rings)
    if len(meeting) == 0:
        return []
    lines = np.asarray(shapely.linestrings(segments_of(rings).reshape(-1, 2, 2)))
    crossings = shapely.intersection(lines[meeting[:, 0]], lines[meeting[:, 1]])
    return list(np.unique(shapely.get_coordinates(crossings), axis=0))


def _rings_of(pieces: Sequence[shapely.Polygon]) -> list[Ring]:
    return [
        shapely.get_coordinates(ring)[:-1]
        for piece in pieces
        for ring in (piece.exterior, *piece.interiors)
    ]


def _spot(point: Ring) -> shapely.Polygon:
    """A square on its corner around a point, `GAP_M` from side to side."""
    x, y = point.tolist()
    return shapely.Polygon([(x + GAP_M, y), (x, y + GAP_M), (x - GAP_M, y), (x, y - GAP_M)])


def _pieces(region: shapely.Geometry, name: str, notes: list[str]) -> list[shapely.Polygon]:
    """The pieces of a region, largest first, without slivers and without holes that are slivers."""
    pieces: list[shapely.Polygon] = []
    lost = 0
    for part in shapely.get_parts(region):
        if not isinstance(part, shapely.Polygon) or part.is_empty:
            continue
        if _is_sliver(part):
            lost += 1
            continue
        holes = [hole for hole in part.interiors if not _is_sliver(shapely.Polygon(hole))]
        lost += len(part.interiors) - len(holes)
        pieces.append(shapely.Polygon(part.exterior, holes))
    if lost:
        notes.append(f"left out {_count(lost, 'sliver')} under a micrometre wide")
    if not pieces:
        raise InputError(name, "has no area", "give another ring")
    return sorted(pieces, key=lambda piece: (-piece.area, piece.bounds))


def _is_sliver(piece: shapely.Polygon) -> bool:
    return 2 * piece.area < SLIVER_M * piece.exterior.length


def _centre(piece: shapely.Polygon) -> str:
    return point_text(shapely.get_coordinates(shapely.point_on_surface(piece))[0])


def _list_points(points: list[Ring]) -> str:
    return _few([point_text(point) for point in points])


def _few(words: list[str]) -> str:
    shown = ", ".join(words[:3])
    return shown if len(words) <= 3 else f"{shown} and {len(words) - 3} more"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("" if number == 1 else "s")
