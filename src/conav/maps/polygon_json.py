"""Floor plans as plain JSON in metres: `{"outer": [[x, y], ...], "holes": [[[x, y], ...]]}`."""

import json
from pathlib import Path
from typing import Any

from conav.errors import InputError
from conav.maps.file_text import file_json
from conav.maps.polygon_map import PolygonMap
from conav.maps.repair_polygon import repair_polygon_map

_KEYS = ("outer", "holes", "name")


def read_polygon_json(path: str | Path) -> PolygonMap:
    """The floor plan in a plain JSON file; rings are repaired where they need it.

    Raises `InputError` for keys other than outer, holes and name, and for rings beyond repair.
    """
    path = Path(path)
    return polygon_from_json(file_json(path, "a floor plan"), path)


def polygon_from_json(value: dict[str, Any], path: Path) -> PolygonMap:
    """The floor plan in a plain JSON object read from `path`."""
    if foreign := sorted(set(value) - set(_KEYS)):
        raise InputError(path, f"{foreign[0]!r} means nothing here", f"use {', '.join(_KEYS)}")
    holes = value.get("holes", [])
    if "outer" not in value or not isinstance(holes, list):
        problem = "has no outer ring" if "outer" not in value else "holes is no list of rings"
        raise InputError(path, problem, 'write {"outer": [[x, y], ...], "holes": []}')
    return repair_polygon_map(value["outer"], holes, name=str(value.get("name", path.stem)))


def to_polygon_json(plan: PolygonMap) -> str:
    """The plan as plain JSON, a ring a line; numbers read back to the same bits.

    >>> print(to_polygon_json(PolygonMap([(0, 0), (1, 0), (0, 1)], name="a")))
    {"name": "a",
     "outer": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
     "holes": []}
    """
    holes = ",\n  ".join(json.dumps(hole.tolist()) for hole in plan.holes)
    return (
        f'{{"name": {json.dumps(plan.name)},\n "outer": {json.dumps(plan.outer.tolist())},\n'
        f' "holes": [{holes}]}}'
    )
