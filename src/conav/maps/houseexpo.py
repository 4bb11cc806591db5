"""HouseExpo floor plans [HouseExpo]: one contour in metres, without holes.

Walls were drawn from pixels of 1 cm, so long walls have tiny steps; contours run clockwise, and
some repeat points, run back on themselves or cross themselves, which is repaired and said.
"""

from pathlib import Path
from typing import Any

from conav.errors import InputError
from conav.maps.file_text import file_json
from conav.maps.polygon_map import PolygonMap
from conav.maps.repair_polygon import repair_polygon_map


def read_houseexpo(path: str | Path) -> PolygonMap:
    """The floor plan in a HouseExpo JSON file: its `verts`; other keys are not read.

    Raises `InputError` where `verts` is missing or beyond repair.
    """
    path = Path(path)
    return houseexpo_plan(file_json(path, "a HouseExpo plan"), path)


def houseexpo_plan(value: dict[str, Any], path: Path) -> PolygonMap:
    """The floor plan in a HouseExpo object read from `path`."""
    if "verts" not in value:
        raise InputError(path, "has no verts", "give a HouseExpo plan")
    return repair_polygon_map(value["verts"], name=path.stem)
