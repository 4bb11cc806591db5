"""A pursuit as one picture: who drove where, what is contaminated, and an evader who gets away."""

import os
from collections.abc import Iterable

import numpy as np
import shapely
from numpy.typing import NDArray

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.pictures.floor_plan import FloorCanvas, page_colour
from conav.pictures.palette import CURVE, PAGE, TEXT, UNKNOWN_GROUND, WALL, Colours
from conav.pursuit.sensor import Sensor
from conav.pursuit.survey import Survey, begin_survey
from conav.pursuit.verify_escape_check import EvaderPath
from conav.runs.types import LegRecord, PursuitRun

_CONTAMINATED = (246, 200, 178)
_CLEAR = (196, 226, 214)
_FRONTIER = (213, 94, 0)


def save_pursuit_still(
    run: PursuitRun,
    path: str | os.PathLike[str],
    escape: EvaderPath | None = None,
    *,
    after: int | None = None,
    max_pixels: int = 1200,
) -> None:
    """Draw a pursuit, as it is after so many legs or at its end, to a PNG.

    What the team sees or nobody said anything of is white, what it cannot see and takes for clear
    green, what may be contaminated red. On a floor not known before, what nobody has seen is dark
    grey, with frontier windows orange. Each pursuer's way is in its colour, with a small dot where
    it entered and a large one where it is; the evader's way is dark and dashed, with a cross where
    it begins.

    Raises `InputError` for a run whose floor cannot be read, for more legs than it has, and for a
    path that cannot be written.
    """
    try:
        floor = run.header["floor"]
        plan = PolygonMap(floor["outer"], floor["holes"], str(floor["name"]))
        names = [str(one["name"]) for one in run.header["pursuers"]]
    except (KeyError, TypeError) as error:
        raise InputError(run.path, f"holds no floor ({error!r})", "the file is damaged") from None
    count = len(run.legs) if after is None else after
    if not 0 <= count <= len(run.legs):
        raise InputError(f"after {count}", f"is none of {len(run.legs)} drives", "give 0 or more")
    legs = run.legs[:count]
    canvas = FloorCanvas(plan.bounds, max_pixels=max_pixels)
    survey = None if run.header.get("known", True) or not run.legs else _survey(plan, run, legs)
    unseen = page_colour(PAGE if survey is None else CURVE)
    canvas.fill([plan.outer], unseen)
    if survey is not None:
        canvas.fill(survey.known.rings, page_colour(PAGE), holes=unseen)
    for one in sorted(run.beliefs.get(count - 1, ()), key=lambda one: -_area(one.rings[0])):
        canvas.fill(one.rings, _CLEAR if one.clear else _CONTAMINATED, holes=page_colour(PAGE))
    for hole in plan.holes:
        canvas.fill([hole], page_colour(UNKNOWN_GROUND))
    canvas.outline(plan.rings, page_colour(WALL), 2.0)
    if survey is not None:
        for segment in survey.frontier_segments:
            canvas.line(segment, _FRONTIER, 3.0)
    _ways(canvas, legs, len(names))
    if escape is not None:
        dark = page_colour(TEXT)
        for dash in _dashes(escape.places, 12.0 / canvas.pixels_per_m):
            canvas.line(dash, dark, 2.0)
        (x, y), r = escape.places[0].tolist(), 6.0 / canvas.pixels_per_m
        for turn in (1.0, -1.0):
            canvas.line([(x - r, y - turn * r), (x + r, y + turn * r)], dark, 2.0)
    canvas.footer(_words(run, plan.name, count, survey))
    canvas.save(path)


def _words(run: PursuitRun, name: str, count: int, survey: Survey | None) -> str:
    at = "" if count == len(run.legs) else f" of {len(run.legs)}"
    words = f"{name} after {count}{at} drives"
    if run.beliefs.get(count - 1):
        words += "; red contaminated, green clear"
    if survey is not None and not survey.complete:
        words += "; grey not seen, orange frontiers"
    return words


def _survey(plan: PolygonMap, run: PursuitRun, legs: list[LegRecord]) -> Survey:
    """What was seen from the ends of these legs by those who were there."""
    sensor = Sensor(plan)
    first = run.legs[0]
    places = [first.before[i] for i in np.flatnonzero(first.active).tolist()]
    for leg in legs:
        for i in np.flatnonzero(leg.active).tolist():
            places += [leg.before[i], leg.after[i]]
    survey: Survey | None = None
    for place in dict.fromkeys((float(x), float(y)) for x, y in places):
        scan = sensor.look(place)
        if len(scan.corners):
            survey = begin_survey(scan) if survey is None else survey.add(scan)
    if survey is None:
        raise InputError(run.path, "has pursuers off its floor", "verify the run")
    return survey


def _ways(canvas: FloorCanvas, legs: list[LegRecord], pursuers: int) -> None:
    colours = Colours(pursuers)
    for i in range(pursuers):
        red, green, blue = colours.rgb[colours.line(i)].tolist()
        own = [leg for leg in legs if len(leg.active) > i and leg.active[i]]
        for leg in own:
            canvas.line((leg.before[i], leg.after[i]), (red, green, blue), 2.0)
        if own:
            canvas.discs(own[0].before[i : i + 1], (red, green, blue), 3.5)
            canvas.discs(own[-1].after[i : i + 1], (red, green, blue), 6.5)


def _area(ring: NDArray[np.float64]) -> float:
    return float(shapely.area(shapely.Polygon(ring))) if len(ring) > 2 else 0.0


def _dashes(way: NDArray[np.float64], length: float) -> Iterable[NDArray[np.float64]]:
    """Every other piece of that length along a way."""
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))))
    for k in range(0, int(along[-1] / length) + 1, 2):
        begin, end = k * length, min((k + 1) * length, float(along[-1]))
        at = np.array([begin, *along[(along > begin) & (along < end)], end])
        yield np.stack([np.interp(at, along, way[:, i]) for i in range(2)], axis=1)
