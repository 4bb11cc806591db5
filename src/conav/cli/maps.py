"""`conav maps`."""

import json as json_module
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from conav.cli.numbers import Whole
from conav.errors import InputError


def maps(
    map: str | None = None,
    /,
    *,
    resolution: float | None = None,
    size: str | None = None,
    seed: Whole = 0,
    cell: float | None = None,
    radius: float = 0.1,
    outside: Annotated[bool, Parameter(negative="")] = False,
    outside_folder: Annotated[bool, Parameter(negative="")] = False,
    out: Path | None = None,
    png: Path | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """List the built-in maps, or say what a map holds and convert it.

    Parameters
    ----------
    map
        A map file or a built-in map's name. Without one the built-in maps are listed and drawn.
    resolution
        Metres per pixel: needed for a bare picture; for a built-in map the side of its cells.
    size
        Size of a built-in map [m], for example 40x25.
    seed
        Seed of a built-in map's layout.
    cell
        Side of a planning cell [m], for the part a robot can reach.
    radius
        Radius of a robot [m], for the part a robot can reach.
    outside
        Take the largest part even when it looks like the outside of a building.
    outside_folder
        Let a map's yaml name a picture outside its own folder.
    out
        Write the map as a ROS map_server pair, .yaml and .pgm.
    png
        Draw the map to a picture; without a map, draw all built-in ones into this folder.
    json
        Print one JSON object.
    """
    if map is None:
        if out is not None:
            raise InputError(
                "--out", "there is no map to write", "name a map: conav maps MAP --out"
            )
        return _list(png, json)
    width_m, height_m = parse_size(size)
    from conav.maps.builtin.catalogue import BUILTIN, builtin_map
    from conav.simulation.explore import load_map

    if map in BUILTIN:
        grid = builtin_map(
            map, width_m=width_m, height_m=height_m, resolution=resolution, seed=seed
        )
    elif size is not None:
        raise InputError("--size", "is for built-in maps", "leave it out for a file")
    else:
        grid = load_map(map, resolution=resolution, outside_folder=outside_folder)
    facts = _facts(grid, cell, radius, outside)
    if out is not None:
        from conav.maps.ros_map_server import write_ros_map

        facts["written"] = [str(path) for path in write_ros_map(grid, out)]
    if png is not None:
        from conav.pictures.map_picture import save_map

        save_map(grid, png)
        facts["picture"] = str(png)
    if json:
        print(json_module.dumps(facts))
    else:
        _print_facts(facts)
    return 0


def parse_size(text: str | None) -> tuple[float | None, float | None]:
    """Width and height [m] of "40x25"; both `None` for no text.

    >>> parse_size("40x25.5")
    (40.0, 25.5)
    """
    if text is None:
        return None, None
    try:
        width, height = (float(part) for part in text.lower().split("x"))
    except ValueError:
        raise InputError(
            f"--size {text}", "is not WIDTHxHEIGHT", "write metres, for example 40x25"
        ) from None
    return width, height


def _list(png: Path | None, json: bool) -> int:
    from conav.maps.builtin.catalogue import BUILTIN

    rows = [
        {
            "name": item.name,
            "description": item.description,
            "width_m": item.width_m,
            "height_m": item.height_m,
            "resolution": item.resolution,
        }
        for item in BUILTIN.values()
    ]
    if png is not None:
        from conav.maps.builtin.catalogue import builtin_map
        from conav.pictures.map_picture import save_map

        if not png.is_dir():
            raise InputError(png, "is no folder", "name a folder that exists for the pictures")
        for row in rows:
            row["picture"] = str(png / f"{row['name']}.png")
            save_map(builtin_map(str(row["name"])), Path(str(row["picture"])))
    if json:
        print(json_module.dumps({"job": "maps", "builtin": rows}))
        return 0
    from conav.maps.builtin.catalogue import builtin_map
    from conav.pictures.map_picture import sketch

    for row in rows:
        print(
            f"{row['name']}: {row['description']}\n"
            f"  {row['width_m']:g} x {row['height_m']:g} m at {row['resolution']:g} m a cell by "
            f"default; --size, --resolution and --seed make others"
        )
        for line in sketch(builtin_map(str(row["name"])), width=60):
            print(f"    {line}")
    print("explore one: conav explore office --robots 3 --gif office.gif")
    return 0


def _facts(grid: Any, cell: float | None, radius: float, outside: bool) -> dict[str, Any]:
    from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN
    from conav.maps.planning_grid import default_start_area, planning_grid

    facts: dict[str, Any] = {
        "job": "maps",
        "map": grid.name,
        "cols": grid.cols,
        "rows": grid.rows,
        "resolution": grid.resolution,
        "width_m": grid.width_m,
        "height_m": grid.height_m,
        "origin": list(grid.origin),
        "free_m2": grid.area_m2(FREE),
        "occupied_m2": grid.area_m2(OCCUPIED),
        "unknown_m2": grid.area_m2(UNKNOWN),
        "cell_m": None,
        "radius_m": radius,
        "standable_cells": 0,
        "reachable_cells": 0,
        "reachable_m2": 0.0,
        "parts": 0,
        "warnings": list(grid.warnings),
    }
    plan = planning_grid(grid, cell_m=cell, radius_m=radius)
    facts["cell_m"] = plan.lattice.cell_m
    facts["standable_cells"] = int(plan.standable.sum())
    facts["parts"] = int(plan.labels.max()) + 1
    try:
        area = default_start_area(plan, outside=outside)
    except InputError as error:
        # The map itself is fine and can be converted; only a robot has no place in it.
        facts["warnings"].append(str(error))
        return facts
    facts["reachable_cells"] = len(area.cells)
    facts["reachable_m2"] = len(area.cells) * plan.lattice.cell_m**2
    facts["warnings"].extend(area.warnings)
    return facts


def _print_facts(facts: dict[str, Any]) -> None:
    x, y, yaw = facts["origin"]
    print(f"{facts['map']}")
    print(
        f"  {facts['cols']} x {facts['rows']} cells of {facts['resolution']:g} m: "
        f"{facts['width_m']:g} x {facts['height_m']:g} m, origin {x:g}, {y:g}, yaw {yaw:g}"
    )
    print(
        f"  free {facts['free_m2']:.4g} m2, occupied {facts['occupied_m2']:.4g} m2, "
        f"unknown {facts['unknown_m2']:.4g} m2"
    )
    if facts["reachable_cells"]:
        share = 100 * facts["reachable_cells"] / facts["standable_cells"]
        parts = f"{facts['parts']} separate parts" if facts["parts"] > 1 else "one part"
        print(
            f"  a robot of radius {facts['radius_m']:g} m on planning cells of "
            f"{facts['cell_m']:g} m reaches {facts['reachable_m2']:.4g} m2, {share:.4g} % of where "
            f"it can stand ({parts})"
        )
    for warning in facts["warnings"]:
        print(f"  warning: {warning}")
    for path in facts.get("written", []):
        print(f"  written: {path}")
    if "picture" in facts:
        print(f"  picture: {facts['picture']}")
