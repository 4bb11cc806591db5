"""`conav scenes`."""

import json as json_module
from pathlib import Path
from textwrap import fill
from typing import Annotated, Any

from cyclopts import Parameter

from conav.cli.numbers import Whole
from conav.errors import InputError

_THEN = {"stay": "stays", "vanish": "vanishes"}


def scenes(
    scene: str | None = None,
    /,
    *,
    robots: Whole | None = None,
    seed: Whole = 0,
    out: Path | None = None,
    png: Path | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """List the scenes that are made on the spot, or say what a scene holds and convert it.

    Parameters
    ----------
    scene
        A scene file (TOML, JSON, db-CBS yaml, CG:SHOP 2021 json, MovingAI .scen) or a made scene's
        name, with settings if you like: random-discs:8,obstacles=20. Without one the made scenes
        are listed.
    robots
        How many robots: of a made scene, or the first ones of a file.
    seed
        Seed of a made scene.
    out
        Write the scene as TOML.
    png
        Draw the scene to a picture; without a scene, draw all made ones into this folder.
    json
        Print one JSON object.
    """
    if scene is None:
        if out is not None:
            raise InputError("--out", "there is no scene to write", "name a scene")
        return _list(png, json)
    from conav.planning.load_scene import load_scene

    problem = load_scene(scene, robots=robots, seed=seed)
    facts = scene_facts(problem)
    if out is not None:
        from conav.planning.scene_writer import write_scene

        facts["written"] = str(write_scene(problem, out))
    if png is not None:
        from conav.pictures.plan_picture import save_plan_picture

        save_plan_picture(problem, png)
        facts["picture"] = str(png)
    if json:
        print(json_module.dumps(facts))
    else:
        _print_facts(facts)
    return 0


def scene_facts(problem: Any) -> dict[str, Any]:
    """What a scene holds, for people and programs."""
    x0, y0, x1, y1 = problem.floor.bounds
    return {
        "job": "scenes",
        "scene": problem.name,
        "floor": problem.floor.name,
        "bounds": [x0, y0, x1, y1],
        "area_m2": problem.floor.area,
        "walls": len(problem.floor.segments),
        "discs": len(problem.discs),
        "horizon_s": problem.horizon_s,
        "margin_m": problem.margin_m,
        "costs": list(problem.costs),
        "robots": [
            {
                "name": robot.name,
                "start": list(robot.start),
                "radius_m": robot.radius_m,
                "speed_mps": robot.speed_mps,
                "motion": robot.motion,
                "task": robot.task,
                "regions": sorted(robot.regions),
                "after_arrival": robot.after_arrival,
            }
            for robot in problem.robots
        ],
        "couplings": [
            {"kind": each.kind, "robots": list(each.robots), "within_m": each.within_m,
             "regions": [one.name for one in (each.region, each.other_region) if one is not None]}
            for each in problem.couplings
        ],
        "warnings": list(problem.floor.warnings),
    }  # fmt: skip


def _list(png: Path | None, json: bool) -> int:
    from conav.planning.scenes.catalogue import SCENES, make_scene, scene_class, scene_settings
    from conav.planning.scenes.frozen_scenes import FROZEN

    rows: list[dict[str, Any]] = []
    for name in SCENES:
        about = (scene_class(name).__doc__ or "").split("\n\n")[0]
        rows.append({"name": name, "description": about, "settings": scene_settings(name)})
    if png is not None:
        from conav.pictures.plan_picture import save_plan_picture

        if not png.is_dir():
            raise InputError(png, "is no folder", "name a folder that exists for the pictures")
        for row in rows:
            row["picture"] = str(png / f"{row['name']}.png")
            save_plan_picture(make_scene(row["name"]), row["picture"])
    if json:
        frozen = {name: recipe._asdict() for name, recipe in FROZEN.items()}
        print(json_module.dumps({"job": "scenes", "made": rows, "frozen": frozen}))
        return 0
    for row in rows:
        print(fill(f"{row['name']}: {row['description']}", 98, subsequent_indent="  "))
        settings = ", ".join(f"{key}={_said(value)}" for key, value in row["settings"].items())
        print(fill(settings, 98, initial_indent="  ", subsequent_indent="  "))
    print(
        "frozen: inash-discs-0 to inash-discs-19 and inash-intersection, which conav reproduce\n"
        "  inash plays"
    )
    print("plan one: conav plan random-discs:8,obstacles=20 --png plan.png")
    return 0


def _said(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "any" if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def _coupling(coupling: dict[str, Any]) -> str:
    a, b = coupling["robots"]
    regions = coupling["regions"]
    if coupling["kind"] == "meet":
        return f"{a} and {b} meet in {regions[0]}, within {coupling['within_m']:g} m"
    if coupling["kind"] == "near":
        return f"{a} and {b} stay within {coupling['within_m']:g} m of each other"
    return f"{a} is not in {regions[0]} before {b} has been in {regions[-1]}"


def _print_facts(facts: dict[str, Any]) -> None:
    x0, y0, x1, y1 = facts["bounds"]
    count = facts["discs"]
    discs = f" and {count} disc{'s' if count > 1 else ''}" if count else ""
    print(
        f"{facts['scene']}, {x1 - x0:g} x {y1 - y0:g} m, {facts['area_m2']:.4g} m2 of floor: "
        f"{facts['walls']} walls{discs}"
    )
    print(
        f"  {facts['horizon_s']:g} s, margin {facts['margin_m']:g} m, "
        f"cost {' and '.join(facts['costs'])}"
    )
    robots = facts["robots"]
    for robot in robots[:16]:
        then = _THEN[robot["after_arrival"]]
        start = ", ".join(f"{value:.4g}" for value in robot["start"])
        print(
            f"  {robot['name']}: {robot['task']}; {robot['motion']} from {start}, radius "
            f"{robot['radius_m']:.3g} m, {robot['speed_mps']:g} m/s, then {then}"
        )
    if len(robots) > 16:
        print(f"  and {len(robots) - 16} more robots")
    for each in facts["couplings"]:
        print(f"  {_coupling(each)}")
    for warning in facts["warnings"]:
        print(f"  warning: {warning}")
    if "written" in facts:
        print(f"  written: {facts['written']}")
    if "picture" in facts:
        print(f"  picture: {facts['picture']}")
