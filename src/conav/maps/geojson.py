"""Floor plans as GeoJSON [RFC7946]: Polygon, MultiPolygon, collections of them, and features.

Where features of a collection say by their property `type` that one is the `building_outline`, as
indoor maps do, the floor is the outline without the features whose type is in `SOLID`; doors,
rooms, stairs and lifts are floor. Otherwise each polygon is a floor of its own.
"""

import json
from pathlib import Path
from typing import Any, cast

import numpy as np
import shapely

from conav.errors import InputError
from conav.maps.file_text import file_json
from conav.maps.lon_lat import Coordinates, in_metres
from conav.maps.polygon_map import PolygonMap
from conav.maps.repair_polygon import floor_of_parts
from conav.maps.rings import Ring

OUTLINE = "building_outline"
SOLID = ("wall", "window", "inaccessible_space")

_REMEDY = "give a Polygon, a MultiPolygon, or features of them"
_DEGREES = ("CRS84", "4326")

Part = list[Ring]


def read_geojson(
    path: str | Path, *, part: int | None = None, coordinates: Coordinates = "auto"
) -> PolygonMap:
    """The floor plan in a GeoJSON file, the largest of several floors or the one of number `part`.

    GeoJSON means longitude and latitude, yet many files are in metres: see `in_metres` for which it
    is taken to be; a `crs` member decides. Raises `InputError` for what is no polygon.
    """
    path = Path(path)
    return geojson_plan(file_json(path, "GeoJSON"), path, part=part, coordinates=coordinates)


def geojson_plan(
    value: dict[str, Any], path: Path, *, part: int | None = None, coordinates: Coordinates = "auto"
) -> PolygonMap:
    """The floor plan in a GeoJSON object read from `path`."""
    found: list[tuple[str, Part]] = []
    others = _collect(path, value, "", found)
    if not found:
        raise InputError(path, "holds no polygon", _REMEDY)
    flat, notes = in_metres(path, [rings for _, rings in found], coordinates, _degrees(value))
    if others:
        notes.append(f"left out {others} shapes that are no polygons")
    kinds = [kind for kind, _ in found]
    if OUTLINE in kinds:
        flat = _without_solid(kinds, flat, notes)
    return floor_of_parts(flat, name=path.stem, part=part, notes=notes)


def to_geojson(plan: PolygonMap) -> str:
    """The plan as a GeoJSON Feature in metres; rings are closed, and run as RFC 7946 wants.

    A `crs` member says that coordinates are metres of a local frame, since GeoJSON alone would mean
    degrees.

    >>> text = to_geojson(PolygonMap([(0, 0), (1, 0), (0, 1)], name="a"))
    >>> json.loads(text)["geometry"]["coordinates"]
    [[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]]
    """
    rings = [[*ring.tolist(), ring[0].tolist()] for ring in plan.rings]
    return json.dumps(
        {
            "type": "Feature",
            "crs": {"type": "name", "properties": {"name": "local metres"}},
            "properties": {"name": plan.name},
            "geometry": {"type": "Polygon", "coordinates": rings},
        }
    )


def _degrees(value: dict[str, Any]) -> bool | None:
    """Whether the `crs` member says degrees; None where there is none."""
    crs = value.get("crs")
    return None if crs is None else any(word in json.dumps(crs) for word in _DEGREES)


def _collect(path: Path, value: object, kind: str, found: list[tuple[str, Part]]) -> int:
    """Adds the polygons of a GeoJSON object with their kinds; how many other shapes there were."""
    if not isinstance(value, dict):
        raise InputError(path, f"{str(value)[:40]!r} is no GeoJSON object", _REMEDY)
    item = cast("dict[str, Any]", value)
    name = item.get("type")
    if name == "FeatureCollection":
        return sum(_collect(path, each, kind, found) for each in _list(path, item, "features"))
    if name == "GeometryCollection":
        return sum(_collect(path, each, kind, found) for each in _list(path, item, "geometries"))
    if name == "Feature":
        properties = item.get("properties")
        kind = str(properties.get("type", "")) if isinstance(properties, dict) else ""
        geometry = item.get("geometry")
        return 1 if geometry is None else _collect(path, geometry, kind, found)
    if name == "Polygon":
        found.append((kind, _polygon(path, item.get("coordinates"))))
        return 0
    if name == "MultiPolygon":
        found += [(kind, _polygon(path, each)) for each in _list(path, item, "coordinates")]
        return 0
    if name in ("Point", "MultiPoint", "LineString", "MultiLineString"):
        return 1
    raise InputError(path, f"type {str(name)[:40]!r} is not one of GeoJSON", _REMEDY)


def _list(path: Path, item: dict[str, Any], key: str) -> list[Any]:
    value = item.get(key)
    if not isinstance(value, list):
        raise InputError(path, f"a {item['type']} has no list of {key}", _REMEDY)
    return cast("list[Any]", value)


def _polygon(path: Path, coordinates: object) -> Part:
    """The rings of a polygon, without heights."""
    rings: Part = []
    if not isinstance(coordinates, list) or not coordinates:
        raise InputError(path, "a Polygon has no rings", _REMEDY)
    for points in cast("list[Any]", coordinates):
        try:
            rings.append(np.array([(point[0], point[1]) for point in points], dtype=np.float64))
        except (TypeError, ValueError, IndexError, KeyError) as error:
            raise InputError(path, "a ring holds something that is no point", _REMEDY) from error
        if not np.isfinite(rings[-1]).all():
            raise InputError(path, "a ring holds a number that is not finite", _REMEDY)
        if len(rings[-1]) > 1 and (rings[-1][0] == rings[-1][-1]).all():
            rings[-1] = rings[-1][:-1]  # GeoJSON closes its rings
        if len(rings[-1]) < 3:
            raise InputError(path, f"a ring has {len(rings[-1])} points", _REMEDY)
    return rings


def _without_solid(kinds: list[str], parts: list[Part], notes: list[str]) -> list[Part]:
    """The outlines without what is solid, piece by piece."""
    shapes = [shapely.make_valid(shapely.Polygon(part[0], part[1:])) for part in parts]
    outlines = [shape for kind, shape in zip(kinds, shapes, strict=True) if kind == OUTLINE]
    solid = [shape for kind, shape in zip(kinds, shapes, strict=True) if kind in SOLID]
    floor = shapely.difference(shapely.union_all(outlines), shapely.union_all(solid))
    counts = ", ".join(f"{kinds.count(kind)} {kind}" for kind in SOLID if kind in kinds)
    rest = ", ".join(sorted({kind for kind in kinds if kind not in (*SOLID, OUTLINE)}))
    notes.append(
        f"the floor is the {OUTLINE}"
        + (f" without {counts}" if counts else "")
        + (f"; passable: {rest}" if rest else "")
    )
    return [
        [shapely.get_coordinates(ring)[:-1] for ring in (piece.exterior, *piece.interiors)]
        for piece in map(shapely.orient_polygons, shapely.get_parts(floor))
        if isinstance(piece, shapely.Polygon)
    ]
