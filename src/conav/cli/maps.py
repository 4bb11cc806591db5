"""`conav maps`."""

import json as json_module
from collections.abc import Mapping
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
    floor_plan: Annotated[bool, Parameter(negative="")] = False,
    evader_radius: float | None = None,
    unknown: str | None = None,
    tolerance: float | None = None,
    at: str | None = None,
    part: Whole | None = None,
    coordinates: str | None = None,
    out: Path | None = None,
    png: Path | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """List the built-in maps and floor plans, or say what one holds and convert it.

    Parameters
    ----------
    map
        A map or floor plan file, or a built-in one's name, such as office or comb:6. Without one
        the built-in ones are listed and the maps drawn.
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
    floor_plan
        Make a polygonal floor plan of a grid map, exactly along the sides of its cells.
    evader_radius
        With --floor-plan: radius of those who hide [m]; over 0, corners where free cells only
        touch are closed.
    unknown
        With --floor-plan: free (the default, somebody may hide there) or wall.
    tolerance
        With --floor-plan: let walls take in dents so deep [m], for fewer vertices.
    at
        With --floor-plan: take the part of the map at this point, x,y [m].
    part
        Of a GeoJSON or WKT file with several floors, the one to take, from 0.
    coordinates
        Of a GeoJSON or WKT file: auto, degrees or metres.
    out
        Write a map as a ROS map_server pair, .yaml and .pgm, or a floor plan as .json or .geojson.
    png
        Draw it to a picture; without a map, draw all built-in ones into this folder.
    json
        Print one JSON object.
    """
    if map is None:
        if out is not None:
            raise InputError(
                "--out", "there is no map to write", "name a map: conav maps MAP --out"
            )
        return _list(png, json)
    from conav.maps.builtin.catalogue import BUILTIN
    from conav.maps.floor_plans.catalogue import FLOOR_PLANS, is_floor_plan_name
    from conav.maps.read_floor_plan import is_floor_plan_file

    polygons = map not in BUILTIN and (is_floor_plan_name(map) or is_floor_plan_file(map))
    if not polygons and map not in BUILTIN and not Path(map).suffix and not Path(map).exists():
        known = ", ".join((*BUILTIN, *FLOOR_PLANS))
        raise InputError(f"map {map!r}", "is neither a file nor built in", f"built-in: {known}")
    grid: Any = None
    for_cells = {
        "--evader-radius": evader_radius,
        "--unknown": unknown,
        "--tolerance": tolerance,
        "--at": at,
    }
    if polygons:
        _refuse({"--size": size, "--cell": cell, **for_cells}, "grid maps")
        _refuse({"--floor-plan": floor_plan or None, "--outside": outside or None}, "grid maps")
        _refuse({"--seed": seed or None}, "grid maps", "write it as corridor-tree:seed=3")
    else:
        _refuse({"--part": part, "--coordinates": coordinates}, "files of polygons")
        _refuse({} if floor_plan else for_cells, "floor plans", "add --floor-plan")
        grid = _grid(map, size, resolution, seed, outside_folder)
    if polygons or floor_plan:
        from conav.cli.floor_plan import reading_of, show_floor_plan
        from conav.maps.load_floor_plan import load_floor_plan
        from conav.maps.polygonise import polygonise

        reading = reading_of(
            part, coordinates, evader_radius, unknown, tolerance, outside=outside, at=at
        )
        plan = load_floor_plan(map, reading) if polygons else polygonise(grid, reading.cells)
        show_floor_plan(plan, out, png, json=json)
        return 0
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


def _refuse(options: Mapping[str, object], what_for: str, remedy: str = "leave it out") -> None:
    """Raises `InputError` for the first option that was given."""
    for option, value in options.items():
        if value is not None:
            raise InputError(option, f"is for {what_for}", remedy)


def _grid(
    map: str, size: str | None, resolution: float | None, seed: int, outside_folder: bool
) -> Any:
    from conav.maps.builtin.catalogue import BUILTIN, builtin_map
    from conav.simulation.explore import load_map

    width_m, height_m = parse_size(size)
    if map in BUILTIN:
        return builtin_map(
            map, width_m=width_m, height_m=height_m, resolution=resolution, seed=seed
        )
    if size is not None:
        raise InputError("--size", "is for built-in maps", "leave it out for a file")
    return load_map(map, resolution=resolution, outside_folder=outside_folder)


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
    from conav.maps.floor_plans.catalogue import FLOOR_PLANS, builtin_floor_plan

    rows: list[dict[str, Any]] = [
        {
            "name": item.name,
            "description": item.description,
            "width_m": item.width_m,
            "height_m": item.height_m,
            "resolution": item.resolution,
        }
        for item in BUILTIN.values()
    ]
    plans = [
        {"name": item.name, "description": item.description, "example": item.example}
        for item in FLOOR_PLANS.values()
    ]
    if png is not None:
        from conav.maps.builtin.catalogue import builtin_map
        from conav.pictures.floor_plan import save_floor_plan
        from conav.pictures.map_picture import save_map

        if not png.is_dir():
            raise InputError(png, "is no folder", "name a folder that exists for the pictures")
        for row in rows:
            row["picture"] = str(png / f"{row['name']}.png")
            save_map(builtin_map(str(row["name"])), Path(str(row["picture"])))
        for item in plans:
            item["picture"] = str(png / f"{item['name']}.png")
            save_floor_plan(builtin_floor_plan(item["example"]), item["picture"], max_pixels=700)
    if json:
        print(json_module.dumps({"job": "maps", "builtin": rows, "floor_plans": plans}))
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
    for item in plans:
        print(
            f"{item['name']}: {item['description']}\n  a floor plan, for example {item['example']}"
        )
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
