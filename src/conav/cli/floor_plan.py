"""The part of `conav maps` that is about polygonal floor plans."""

import json as json_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from conav.errors import InputError

if TYPE_CHECKING:
    from conav.maps.polygon_map import PolygonMap
    from conav.maps.read_floor_plan import FloorPlanReading


def reading_of(
    part: int | None,
    coordinates: str | None,
    evader_radius: float | None,
    unknown: str | None,
    tolerance: float | None,
    *,
    outside: bool,
    at: str | None,
) -> "FloorPlanReading":
    """The settings of the options, what is not given at its default."""
    from conav.maps.polygonise import Polygonising
    from conav.maps.read_floor_plan import FloorPlanReading

    if coordinates not in (None, "auto", "degrees", "metres"):
        raise InputError(
            f"--coordinates {coordinates}", "is not known", "give auto, degrees or metres"
        )
    given = {"evader_radius": evader_radius, "unknown": unknown, "tolerance": tolerance}
    cells: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    if at is not None:
        cells["at"] = _point(at)
    return FloorPlanReading(
        part=part,
        coordinates=coordinates or "auto",
        cells=Polygonising(outside=outside, **cells),
    )


def _point(text: str) -> tuple[float, float]:
    try:
        x, y = (float(word) for word in text.split(","))
    except ValueError:
        raise InputError(f"--at {text}", "is not X,Y", "write metres, as 3.5,-2") from None
    return x, y


def show_floor_plan(plan: "PolygonMap", out: Path | None, png: Path | None, *, json: bool) -> None:
    """Writes and draws the plan where asked, and prints what there is to say about it."""
    facts = _facts(plan)
    if out is not None:
        from conav.maps.write_floor_plan import write_floor_plan

        facts["written"] = [str(write_floor_plan(plan, out))]
    if png is not None:
        from conav.pictures.floor_plan import save_floor_plan

        save_floor_plan(plan, png)
        facts["picture"] = str(png)
    if json:
        print(json_module.dumps(facts))
    else:
        _print(facts)


def _facts(plan: "PolygonMap") -> dict[str, Any]:
    """What there is to say about a floor plan."""
    x0, y0, x1, y1 = plan.bounds
    return {
        "job": "maps",
        "floor_plan": plan.name,
        "vertices": len(plan.vertices),
        "outer_vertices": len(plan.outer),
        "holes": len(plan.holes),
        "reflex_vertices": int((plan.turns < 0).sum()),
        "straight_vertices": int((plan.turns == 0).sum()),
        "area_m2": plan.area,
        "bounds": [x0, y0, x1, y1],
        "width_m": x1 - x0,
        "height_m": y1 - y0,
        "warnings": list(plan.warnings),
    }


def _print(facts: dict[str, Any]) -> None:
    x0, y0, x1, y1 = facts["bounds"]
    holes = facts["holes"]
    straight = facts["straight_vertices"]
    print(f"{facts['floor_plan']}")
    print(
        f"  {facts['vertices']} vertices, {facts['reflex_vertices']} of them reflex"
        + (f", {straight} on straight walls" if straight else "")
        + (f"; {holes} hole{'s' if holes > 1 else ''}" if holes else "; no holes")
    )
    print(
        f"  floor {facts['area_m2']:.6g} m2, x {x0:.6g} to {x1:.6g} m, y {y0:.6g} to {y1:.6g} m:"
        f" {facts['width_m']:.6g} x {facts['height_m']:.6g} m"
    )
    for warning in facts["warnings"]:
        print(f"  warning: {warning}")
    for path in facts.get("written", []):
        print(f"  written: {path}")
    if "picture" in facts:
        print(f"  picture: {facts['picture']}")
