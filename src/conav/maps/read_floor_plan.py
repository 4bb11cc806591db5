"""Any floor plan file, by its suffix and, where a suffix has several formats, by its content."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from conav.errors import InputError
from conav.maps.agplib import read_agplib
from conav.maps.file_text import file_json, file_text
from conav.maps.geojson import geojson_plan, read_geojson
from conav.maps.houseexpo import houseexpo_plan
from conav.maps.lon_lat import Coordinates
from conav.maps.polygon_json import polygon_from_json
from conav.maps.polygon_map import PolygonMap
from conav.maps.polygonise import Polygonising, polygonise
from conav.maps.read_map import READERS, read_map
from conav.maps.visilibity import looks_like_points, read_environment
from conav.maps.wkt import read_wkt


@dataclass(frozen=True)
class FloorPlanReading:
    """How to read a floor plan file; each setting is for the formats that need it."""

    part: int | None = None  # of several outer rings (GeoJSON, WKT), from 0; else the largest
    coordinates: Coordinates = "auto"  # of GeoJSON and WKT
    resolution: float | None = None  # [m] of a cell, for grid maps that do not say
    outside_folder: bool = False  # a yaml may name a picture outside its own folder
    cells: Polygonising = field(default_factory=Polygonising)  # what to make of a grid's cells


Reader = Callable[[Path, FloorPlanReading], PolygonMap]


def read_floor_plan(path: str | Path, reading: FloorPlanReading | None = None) -> PolygonMap:
    """The floor plan in a file: of polygons (`FLOOR_PLAN_READERS`), or of a grid map, polygonised.

    `.json` is GeoJSON, a HouseExpo plan or plain JSON by its keys; `.txt` is a list of points or a
    drawn map by its first line. What was odd or repaired is in the plan's `warnings`.

    Raises `InputError`, with a remedy, for everything that is no floor plan.
    """
    path = Path(path)
    reading = FloorPlanReading() if reading is None else reading
    reader = FLOOR_PLAN_READERS.get(path.suffix.lower())
    if reader is not None:
        return reader(path, reading)
    if path.suffix.lower() == ".sol" and path.is_file():
        raise InputError(
            path, "is a list of guards, not a floor plan", f"give {path.with_suffix('.pol').name}"
        )
    if path.suffix.lower() not in READERS and path.is_file():
        raise InputError(
            path,
            f"{path.suffix or 'no suffix'} is not the suffix of a floor plan or a map",
            f"give one of {' '.join((*FLOOR_PLAN_READERS, *READERS))}",
        )
    return _read_grid(path, reading)


def is_floor_plan_file(path: str | Path) -> bool:
    """Whether a file holds polygons, as opposed to a grid map or nothing we know."""
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".txt":
        return path.is_file() and looks_like_points(file_text(path, "a map"))
    return suffix in FLOOR_PLAN_READERS


def _read_grid(path: Path, reading: FloorPlanReading) -> PolygonMap:
    grid = read_map(path, resolution=reading.resolution, outside_folder=reading.outside_folder)
    return polygonise(grid, reading.cells)


def _read_json(path: Path, reading: FloorPlanReading) -> PolygonMap:
    value = file_json(path, "a floor plan")
    if "outer" in value:
        return polygon_from_json(value, path)
    if "verts" in value:
        return houseexpo_plan(value, path)
    if "type" in value:
        return geojson_plan(value, path, part=reading.part, coordinates=reading.coordinates)
    keys = ", ".join(sorted(value)[:5]) or "none"
    raise InputError(
        path,
        f"is no floor plan (its keys: {keys})",
        "a floor plan has outer, or verts (HouseExpo), or type (GeoJSON)",
    )


def _read_text(path: Path, reading: FloorPlanReading) -> PolygonMap:
    if path.is_file() and looks_like_points(file_text(path, "a floor plan")):
        return read_environment(path)
    return _read_grid(path, reading)


FLOOR_PLAN_READERS: dict[str, Reader] = {
    ".geojson": lambda path, reading: read_geojson(
        path, part=reading.part, coordinates=reading.coordinates
    ),
    ".json": _read_json,
    ".wkt": lambda path, reading: read_wkt(
        path, part=reading.part, coordinates=reading.coordinates
    ),
    ".pol": lambda path, reading: read_agplib(path),
    ".environment": lambda path, reading: read_environment(path),
    ".dat": lambda path, reading: read_environment(path),
    ".xy": lambda path, reading: read_environment(path),
    ".txt": _read_text,
}
