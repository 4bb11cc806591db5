"""Floor plans to files."""

from pathlib import Path

from conav.errors import InputError
from conav.maps.geojson import to_geojson
from conav.maps.polygon_json import to_polygon_json
from conav.maps.polygon_map import PolygonMap
from conav.maps.write_whole import write_whole

FLOOR_PLAN_WRITERS = {".json": to_polygon_json, ".geojson": to_geojson}


def write_floor_plan(plan: PolygonMap, path: str | Path) -> Path:
    """The path of the file written: plain JSON for `.json`, GeoJSON for `.geojson`.

    Read back, it gives the same rings bit by bit. Raises `InputError` for another suffix and where
    the file cannot be written.
    """
    path = Path(path)
    writer = FLOOR_PLAN_WRITERS.get(path.suffix.lower())
    if writer is None:
        known = " or ".join(FLOOR_PLAN_WRITERS)
        problem = f"{path.suffix or 'no suffix'} is not a format of floor plans that is written"
        raise InputError(path, problem, f"end the name in {known}")
    if path.is_dir():
        raise InputError(path, "is a folder", "give the name of a file")
    write_whole({path: (writer(plan) + "\n").encode()})
    return path
