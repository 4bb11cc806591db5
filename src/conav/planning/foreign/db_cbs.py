"""Scenes of db-CBS (github.com/IMRCLab/db-CBS, `example/*.yaml`), every robot as a disc."""

import os
from math import sqrt
from pathlib import Path
from typing import Any, cast

import numpy as np
import yaml

from conav.errors import InputError
from conav.maps.image import file_bytes
from conav.planning.floor import floor_between
from conav.planning.types import PlanningProblem, PlanningRobot, Region

SPEED_MPS = 0.5
GOAL_RADIUS_M = 0.1
HORIZON_FACTOR = 6.0
"""The horizon is that many times as long as the longest straight way from a start to its goal."""
SHORTEST_S = 60.0

_UNICYCLE = sqrt(0.25 * 0.25 + 0.125 * 0.125)  # about a box of 0.5 x 0.25 m
RADII_M = {
    "single_integrator_0": 0.1,
    "double_integrator_0": 0.15,
    "unicycle_first_order_0": _UNICYCLE,
    "unicycle_first_order_0_sphere": 0.4,
    "unicycle_second_order_0": _UNICYCLE,
    "car_first_order_0": _UNICYCLE,
    "car_first_order_with_1_trailers_0": _UNICYCLE,
}
"""Robot type -> radius of its disc [m]; see `read_db_cbs` for what the discs are."""

_LENGTHS = {
    "single_integrator_0": 2,
    "double_integrator_0": 4,
    "unicycle_second_order_0": 5,
    "car_first_order_with_1_trailers_0": 4,
}


def read_db_cbs(path: str | os.PathLike[str]) -> PlanningProblem:
    """The problem in a db-CBS yaml, with holonomic discs that stay in a small disc at their goal.

    The scenes say a robot's type and not its size: spheres keep their radius, boxes get the disc
    around them, and a car with a trailer the disc around the car alone, for one around both would
    be half empty and would put most of those scenes out of reach. Headings and velocities of starts
    and goals are left out, every robot drives at up to 0.5 m/s in any direction, and a goal is a
    disc of radius 0.1 m. As there, `min` and `max` bound the robots' centres: the floor reaches
    beyond them by the radius of the smallest robot, so others have a little less room.

    Raises `InputError` that names the place, for other robot types and obstacles too.
    """
    path = Path(path)
    content = _table(path, "", _content(path))
    world = _table(path, "environment", content.get("environment"))
    low = _numbers(path, "environment.min", world.get("min"), (2,))
    high = _numbers(path, "environment.max", world.get("max"), (2,))
    if not (low[0] < high[0] and low[1] < high[1]):
        raise InputError(f"{path}: environment", "max is not beyond min", "correct them")
    items = _items(path, "robots", content.get("robots"))
    if not items:
        raise InputError(f"{path}: robots", "there is none", "list at least one")
    robots = tuple(_robot(path, f"robots[{i}]", f"robot_{i}", item) for i, item in enumerate(items))
    boxes = _items(path, "environment.obstacles", world.get("obstacles"))
    walls = [_box(path, f"environment.obstacles[{i}]", box) for i, box in enumerate(boxes)]
    grow = min(robot.radius_m for robot in robots)
    x0, y0, x1, y1 = low[0] - grow, low[1] - grow, high[0] + grow, high[1] + grow
    floor = floor_between(
        [(x0, y0), (x1, y0), (x1, y1), (x0, y1)],
        walls=walls,
        robots=robots,
        name=path.stem,
    )
    return PlanningProblem(floor, robots, horizon_s=_horizon(robots), name=path.stem)


def _robot(path: Path, place: str, name: str, item: Any) -> PlanningRobot:
    table = _table(path, place, item)
    kind = table.get("type")
    if kind not in RADII_M:
        raise InputError(
            f"{path}: {place}.type", f"{kind!r} is no robot that is read here",
            "known: " + ", ".join(RADII_M),
        )  # fmt: skip
    length = (_LENGTHS.get(kind, 3),)
    start = _numbers(path, f"{place}.start", table.get("start"), length)
    goal = _numbers(path, f"{place}.goal", table.get("goal"), length)
    return PlanningRobot(
        name=name,
        start=(start[0], start[1]),
        task="F goal",
        regions={"goal": Region("goal", disc=(goal[0], goal[1], GOAL_RADIUS_M))},
        radius_m=RADII_M[kind],
        speed_mps=SPEED_MPS,
    )


def _box(path: Path, place: str, item: Any) -> list[tuple[float, float]]:
    table = _table(path, place, item)
    if table.get("type") != "box":
        raise InputError(f"{path}: {place}.type", f"{table.get('type')!r} is not read", "use box")
    x, y = _numbers(path, f"{place}.center", table.get("center"), (2,))
    width, height = _numbers(path, f"{place}.size", table.get("size"), (2,))
    if width <= 0 or height <= 0:
        raise InputError(f"{path}: {place}.size", "is not positive", "give width and height [m]")
    dx, dy = width / 2, height / 2
    return [(x - dx, y - dy), (x + dx, y - dy), (x + dx, y + dy), (x - dx, y + dy)]


def _horizon(robots: tuple[PlanningRobot, ...]) -> float:
    longest = 0.0
    for robot in robots:
        goal = robot.regions["goal"].disc
        assert goal is not None
        dx, dy = goal[0] - robot.start[0], goal[1] - robot.start[1]
        longest = max(longest, sqrt(dx * dx + dy * dy))
    # Whole seconds, for people.
    return float(max(SHORTEST_S, np.ceil(HORIZON_FACTOR * longest / SPEED_MPS)))


def _content(path: Path) -> object:
    try:
        return yaml.safe_load(file_bytes(path).decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise InputError(path, "is not UTF-8 text", "give a db-CBS yaml") from None
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f", line {mark.line + 1}" if mark is not None else ""
        problem = getattr(error, "problem", None) or "it is nested too deep or has a bad value"
        raise InputError(path, f"is no yaml{where}: {problem}", "mend that line") from None


def _table(path: Path, place: str, value: object) -> dict[str, Any]:
    if isinstance(value, dict):
        return cast("dict[str, Any]", value)
    where = f"{path}: {place}" if place else str(path)
    what = "is missing" if value is None else "is no table"
    raise InputError(where, what, "a db-CBS scene has environment and robots, with keys in both")


def _items(path: Path, place: str, value: object) -> list[Any]:
    if value is None:
        return []
    if not isinstance(value, list):
        raise InputError(f"{path}: {place}", "is no list", "write one item a line, after a dash")
    return cast("list[Any]", value)


def _numbers(path: Path, place: str, value: object, lengths: tuple[int, ...]) -> list[float]:
    items = cast("list[Any]", value) if isinstance(value, list) else []
    numbers = [float(item) for item in items if type(item) in (int, float)]
    if len(numbers) != len(items) or len(numbers) not in lengths:
        raise InputError(
            f"{path}: {place}", f"is {value!r}, not {lengths[0]} numbers", "write a list of numbers"
        )
    if not np.isfinite(numbers).all():
        raise InputError(f"{path}: {place}", f"is {value!r}", "give finite numbers")
    return numbers
