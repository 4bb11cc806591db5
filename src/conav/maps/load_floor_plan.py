"""The floor plan behind a name as the command line gives it: built-in, or a file."""

import os
from pathlib import Path

from conav.errors import InputError
from conav.maps.builtin.catalogue import BUILTIN, builtin_map
from conav.maps.floor_plans.catalogue import (
    FLOOR_PLANS,
    builtin_floor_plan,
    is_floor_plan_name,
)
from conav.maps.polygon_map import PolygonMap
from conav.maps.polygonise import polygonise
from conav.maps.read_floor_plan import FloorPlanReading, read_floor_plan


def load_floor_plan(
    source: str | os.PathLike[str] | PolygonMap,
    reading: FloorPlanReading | None = None,
    *,
    seed: int = 0,
) -> PolygonMap:
    """The plan behind a built-in name, a file or a plan itself.

    Built-in are the floor plans (`comb:6`) and the grid maps (`office`, made with `seed` and
    polygonised). A file beats a built-in name when its name has a suffix.

    Raises `InputError` for what is none of these.

    >>> load_floor_plan("comb:2").bounds
    (0.0, 0.0, 5.0, 5.0)
    """
    if isinstance(source, PolygonMap):
        return source
    reading = FloorPlanReading() if reading is None else reading
    name = str(source)
    if is_floor_plan_name(name):
        return builtin_floor_plan(name)
    if name in BUILTIN:
        return polygonise(
            builtin_map(name, resolution=reading.resolution, seed=seed), reading.cells
        )
    if not Path(name).suffix and not Path(name).exists():
        raise InputError(
            f"floor plan {name!r}",
            "is neither a file nor built in",
            f"built-in: {', '.join((*FLOOR_PLANS, *BUILTIN))}",
        )
    return read_floor_plan(Path(name), reading)
