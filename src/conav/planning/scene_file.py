"""Scenes in our own format, TOML or JSON: read here, written by `scene_writer`."""

import difflib
import json
import os
import tomllib
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from conav.errors import InputError
from conav.maps.builtin.catalogue import BUILTIN, builtin_map
from conav.maps.floor_plans.catalogue import FLOOR_PLANS, builtin_floor_plan, is_floor_plan_name
from conav.maps.image import file_bytes
from conav.maps.polygon_map import PolygonMap
from conav.maps.read_floor_plan import is_floor_plan_file, read_floor_plan
from conav.maps.read_map import read_map
from conav.planning.floor import floor_between, floor_of_grid, turned
from conav.planning.scene_errors import scene_error
from conav.planning.scene_format import (
    SCENE,
    CouplingEntry,
    FloorEntry,
    RobotDefaults,
    RobotEntry,
    SceneFile,
    Shape,
)
from conav.planning.types import (
    DOUBLE_INTEGRATOR,
    DUBINS_CAR,
    SINGLE_INTEGRATOR,
    Coupling,
    PlanningProblem,
    PlanningRobot,
    Region,
)
from conav.tasks.parse import parse_formula

GOAL, TO_GOAL = "goal", "F goal"
"""What `goal` in a robot's table is short for: a region and a task."""

MAX_BYTES = 100_000_000

_START = {
    SINGLE_INTEGRATOR: ("x, y", (2,)),
    DOUBLE_INTEGRATOR: ("x, y or x, y, vx, vy", (2, 4)),
    DUBINS_CAR: ("x, y or x, y, heading", (2, 3)),
}


def read_scene_file(path: str | os.PathLike[str]) -> PlanningProblem:
    """The problem in a `.toml` or `.json` scene file (`conav schema scene` has its keys).

    A region of the scene belongs to the robots whose task names it; a robot's own regions are all
    its own. Paths of maps are relative to the scene file. Raises `InputError` that names the file,
    the key and the remedy.
    """
    path = Path(path)
    scene = parsed_scene(path, _content(path))
    place = str(path)
    robots = tuple(_robot(place, scene, index) for index in range(len(scene.robots)))
    _check_names(place, robots)
    floor = _floor(path, scene, robots, scene.name or path.stem)
    discs = [wall.disc for wall in scene.walls if wall.disc is not None]
    return PlanningProblem(
        floor=floor,
        robots=robots,
        horizon_s=scene.horizon_s,
        discs=np.array(discs, dtype=np.float64).reshape(-1, 3),
        costs=scene.costs,
        margin_m=scene.margin_m,
        name=scene.name or path.stem,
        couplings=tuple(
            _coupling(place, scene, index, robots) for index in range(len(scene.couplings))
        ),
    )


def parsed_scene(path: Path, content: Mapping[str, Any]) -> SceneFile:
    """What a file says, checked against the format. Raises `InputError` for what does not fit."""
    try:
        # As JSON, for there strict reading takes lists for tuples, and text never for a number.
        return SCENE.validate_json(json.dumps(content, default=str), strict=True)
    except ValidationError as error:
        raise scene_error(path, error) from None


def _content(path: Path) -> dict[str, Any]:
    try:
        text = file_bytes(path, limit=MAX_BYTES).decode("utf-8-sig")
        if path.suffix.lower() == ".toml":
            return tomllib.loads(text)
        content = json.loads(text, object_pairs_hook=lambda pairs: _once(path, pairs))
    except UnicodeDecodeError:
        raise InputError(path, "is not UTF-8 text", "save it as UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(path, f"is no TOML: {error}", "mend that line") from None
    except json.JSONDecodeError as error:
        problem = f"is no JSON: {error.msg} (at line {error.lineno}, column {error.colno})"
        raise InputError(path, problem, "mend that line") from None
    except RecursionError:
        raise InputError(path, "is nested too deep", "check that it is a scene") from None
    if not isinstance(content, dict):
        raise InputError(path, "holds no table", "write an object with floor, robots, horizon_s")
    return content


def _once(path: Path, pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise InputError(path, f"has the key {twice} twice in one object", "keep one of them")
    return table


def _floor(
    path: Path, scene: SceneFile, robots: tuple[PlanningRobot, ...], name: str
) -> PolygonMap:
    entry = scene.floor
    walls = [ring for wall in scene.walls if (ring := _ring(wall)) is not None]
    try:
        if entry.map is None:
            outline = _box(entry.box) if entry.box is not None else entry.outline or ()
            name = entry.name or name
            return floor_between(outline, entry.holes, walls, robots=robots, name=name)
        plan = _mapped(path, entry, robots)
        if not walls:
            return plan
        cut = floor_between(plan.outer, plan.holes, walls, robots=robots, name=plan.name)
        return PolygonMap(cut.outer, cut.holes, cut.name, plan.warnings)
    except InputError as error:
        if error.place.startswith(str(path)):
            raise
        problem = f"{error.place}: {error.problem}"
        raise InputError(f"{path}: floor", problem, error.remedy) from None


def _mapped(path: Path, entry: FloorEntry, robots: tuple[PlanningRobot, ...]) -> PolygonMap:
    source = str(entry.map)
    if source in BUILTIN:
        width_m, height_m = entry.size or (None, None)
        grid = builtin_map(
            source,
            width_m=width_m,
            height_m=height_m,
            resolution=entry.resolution,
            seed=entry.seed or 0,
        )
        return floor_of_grid(grid, robots)
    for key in ("size", "seed"):
        if getattr(entry, key) is not None:
            raise InputError(f"{path}: floor.{key}", "is for built-in grid maps", "leave it out")
    if is_floor_plan_name(source):
        return builtin_floor_plan(source)
    if not Path(source).suffix:
        names = (*BUILTIN, *FLOOR_PLANS)
        near = difflib.get_close_matches(source.partition(":")[0], names, n=1)
        raise InputError(
            f"{path}: floor.map", f"{source!r} is neither a map file nor a built-in map",
            f"did you mean {near[0]}?" if near else f"the built-in maps: {', '.join(names)}",
        )  # fmt: skip
    file = path.parent / source
    if is_floor_plan_file(file):
        return read_floor_plan(file)
    return floor_of_grid(read_map(file, resolution=entry.resolution), robots)


def _robot(place: str, scene: SceneFile, index: int) -> PlanningRobot:
    entry = scene.robots[index]
    place = f"{place}: robots[{index}]"
    name = entry.name or f"robot_{index}"
    values = _own_or_default(entry, scene.defaults)
    own = {key: _region(key, shape) for key, shape in entry.regions.items()}
    task = values.pop("task", None)
    if entry.goal is not None:
        if GOAL in own:
            raise InputError(
                f"{place}.goal", f"{name} has a region of that name too", "keep one of them"
            )
        own[GOAL] = Region(GOAL, disc=entry.goal)
        task = entry.task or task or TO_GOAL
    if task is None:
        raise InputError(
            f"{place}.task", f"{name} has nothing to do",
            'add task = "F a" for a region a, or goal = [x, y, radius]',
        )  # fmt: skip
    shared = {key: _region(key, shape) for key, shape in scene.regions.items()}
    known = {**shared, **own}
    try:
        named = parse_formula(task, regions=known).names
    except InputError as error:
        problem = f"{error.place}: {error.problem}"
        raise InputError(f"{place}.task", problem, error.remedy, error.excerpt) from None
    regions = {key: known[key] for key in known if key in own or key in named}
    start = _start(place, entry.start, str(values.get("motion", SINGLE_INTEGRATOR)))
    return replace(PlanningRobot(name, start, task, regions), **values)


def _coupling(
    place: str, scene: SceneFile, index: int, robots: tuple[PlanningRobot, ...]
) -> Coupling:
    entry = scene.couplings[index]
    place = f"{place}: couplings[{index}]"
    names = [robot.name for robot in robots]
    for name in entry.robots:
        if name not in names:
            near = difflib.get_close_matches(name, names, n=1)
            raise InputError(
                f"{place}.robots", f"there is no robot {name}",
                f"did you mean {near[0]}?" if near else f"the robots: {', '.join(names)}",
            )  # fmt: skip
    return Coupling(
        entry.kind,
        entry.robots,
        _coupled_region(place, "region", scene, entry),
        _coupled_region(place, "other_region", scene, entry),
        entry.within_m,
    )


def _coupled_region(place: str, key: str, scene: SceneFile, entry: CouplingEntry) -> Region | None:
    value = getattr(entry, key)
    if value is None:
        return None
    if isinstance(value, Shape):
        return _region(key, value)
    if value not in scene.regions:
        near = difflib.get_close_matches(value, scene.regions, n=1)
        raise InputError(
            f"{place}.{key}", f"there is no region {value} in the scene",
            f"did you mean {near[0]}?" if near else "add it to [regions], or give a shape",
        )  # fmt: skip
    return _region(value, scene.regions[value])


def _own_or_default(entry: RobotEntry, defaults: RobotDefaults) -> dict[str, Any]:
    """What a robot and the defaults say, without what neither does."""
    values: dict[str, Any] = {}
    for item in fields(RobotDefaults):
        own = getattr(entry, item.name)
        value = getattr(defaults, item.name) if own is None else own
        if value is not None:
            values[item.name] = value
    return values


def _start(place: str, start: tuple[float, ...], motion: str) -> tuple[float, ...]:
    form, lengths = _START[motion]
    if len(start) not in lengths:
        raise InputError(
            f"{place}.start", f"has {len(start)} numbers, and a {motion} starts at {form}",
            f"write {form}",
        )  # fmt: skip
    return (*start, *(0.0,) * (lengths[-1] - len(start)))


def _check_names(place: str, robots: tuple[PlanningRobot, ...]) -> None:
    seen: dict[str, int] = {}
    for index, robot in enumerate(robots):
        if robot.name in seen:
            raise InputError(
                f"{place}: robots[{index}].name",
                f"robots[{seen[robot.name]}] is called {robot.name} too",
                "give every robot a name of its own",
            )
        seen[robot.name] = index


def _region(name: str, shape: Shape) -> Region:
    ring = _ring(shape)
    if ring is None:
        return Region(name, disc=shape.disc)
    return Region(name, polygon=turned(ring, 1))


def _ring(shape: Shape) -> NDArray[np.float64] | None:
    """The corners of a box or a polygon; None for a disc."""
    if shape.box is not None:
        return _box(shape.box)
    return None if shape.polygon is None else np.array(shape.polygon, dtype=np.float64)


def _box(box: tuple[float, float, float, float]) -> NDArray[np.float64]:
    x0, x1 = min(box[0], box[2]), max(box[0], box[2])
    y0, y1 = min(box[1], box[3]), max(box[1], box[3])
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
