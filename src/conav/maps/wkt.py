"""Floor plans as well-known text: POLYGON, MULTIPOLYGON, GEOMETRYCOLLECTION."""

import re
from pathlib import Path

import numpy as np
import shapely

from conav.errors import InputError
from conav.maps.file_text import file_text
from conav.maps.lon_lat import Coordinates, in_metres
from conav.maps.polygon_map import PolygonMap
from conav.maps.repair_polygon import floor_of_parts
from conav.maps.rings import Ring

_FORM = "write POLYGON ((x y, ...), (x y, ...)) with the outer ring first"


def read_wkt(
    path: str | Path, *, part: int | None = None, coordinates: Coordinates = "auto"
) -> PolygonMap:
    """The polygon in a file of well-known text, the largest of several or the one of number `part`.

    `SRID=4326;` before it says that coordinates are degrees. Raises `InputError` for text that is
    none, or holds no polygon.
    """
    path = Path(path)
    text = file_text(path, "well-known text").strip()
    named = re.match(r"SRID\s*=\s*(\d+)\s*;", text, re.IGNORECASE)
    declared = None if named is None else named[1] == "4326"
    try:
        geometry = shapely.from_wkt(text[named.end() :] if named else text)
    except shapely.errors.GEOSException as error:
        raise InputError(path, f"is no well-known text ({error})", _FORM) from error
    parts: list[list[Ring]] = []
    others = 0
    pending = [geometry]
    while pending:
        item = pending.pop(0)
        if isinstance(item, shapely.Polygon) and not item.is_empty:
            parts.append(
                [shapely.get_coordinates(ring)[:-1] for ring in (item.exterior, *item.interiors)]
            )
        elif isinstance(item, shapely.MultiPolygon | shapely.GeometryCollection):
            pending = [*np.asarray(shapely.get_parts(item)).tolist(), *pending]
        else:
            others += 1
    if not parts:
        raise InputError(path, "holds no polygon", _FORM)
    flat, notes = in_metres(path, parts, coordinates, declared)
    if others:
        notes.append(f"left out {others} shapes that are no polygons")
    return floor_of_parts(flat, name=path.stem, part=part, notes=notes)
