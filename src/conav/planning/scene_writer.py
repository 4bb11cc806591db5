"""Planning problems as TOML scenes, which `scene_file` reads back to the same numbers."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.maps.write_whole import write_whole
from conav.planning.types import Coupling, PlanningProblem, PlanningRobot, Region

_OWN = ("name", "start", "task", "regions")
_SAME = tuple(item.name for item in fields(PlanningRobot) if item.name not in _OWN)


def write_scene(problem: PlanningProblem, path: str | os.PathLike[str]) -> Path:
    """The path of the TOML file the scene was written to.

    Raises `InputError` for another suffix and for a path that cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() != ".toml":
        raise InputError(path, "scenes are written as TOML", "end the name in .toml")
    write_whole({path: scene_text(problem).encode()})
    return path


def scene_text(problem: PlanningProblem) -> str:
    """A scene as TOML. The floor is written as its rings; floats keep every digit."""
    defaults = {key: getattr(problem.robots[0], key) for key in _SAME}
    # What the first robot has that not all have is no default.
    defaults = {
        key: value
        for key, value in defaults.items()
        if all(getattr(robot, key) == value for robot in problem.robots)
    }
    lines = [
        _pair("name", problem.name),
        _pair("horizon_s", problem.horizon_s),
        _pair("margin_m", problem.margin_m),
        f"costs = [{', '.join(_text(cost) for cost in problem.costs)}]",
        "",
        "[floor]",
        _pair("name", problem.floor.name),
        f"outline = {_rows(problem.floor.outer)}",
    ]
    if problem.floor.holes:
        holes = ",\n".join(_rows(ring) for ring in problem.floor.holes)
        lines.append(f"holes = [\n{holes},\n]")
    for disc in problem.discs.tolist():
        lines += ["", "[[walls]]", f"disc = {_row(disc)}"]
    lines += ["", "[defaults]", *(_pair(key, value) for key, value in defaults.items())]
    for robot in problem.robots:
        lines += ["", *_robot(robot, defaults)]
    for coupling in problem.couplings:
        lines += ["", *_coupling(coupling)]
    return "\n".join(lines) + "\n"


def _robot(robot: PlanningRobot, defaults: Mapping[str, object]) -> list[str]:
    own = {key: getattr(robot, key) for key in _SAME if key not in defaults}
    lines = [
        "[[robots]]",
        _pair("name", robot.name),
        f"start = {_row(robot.start)}",
        _pair("task", robot.task),
        *(_pair(key, value) for key, value in own.items()),
    ]
    if robot.regions:
        lines.append("[robots.regions]")
        lines += [f"{_key(key)} = {_shape(region)}" for key, region in robot.regions.items()]
    return lines


def _coupling(coupling: Coupling) -> list[str]:
    lines = [
        "[[couplings]]",
        _pair("kind", coupling.kind),
        f"robots = [{', '.join(_text(name) for name in coupling.robots)}]",
    ]
    for key in ("region", "other_region"):
        region = getattr(coupling, key)
        if region is not None:
            lines.append(f"{key} = {_shape(region)}")
    if coupling.within_m is not None:
        lines.append(_pair("within_m", coupling.within_m))
    return lines


def _shape(region: Region) -> str:
    if region.disc is not None:
        return f"{{ disc = {_row(region.disc)} }}"
    assert region.polygon is not None
    # An inline table is one line.
    corners = ", ".join(_row(corner) for corner in region.polygon.tolist())
    return f"{{ polygon = [{corners}] }}"


def _pair(key: str, value: str | float) -> str:
    return f"{key} = {_text(value) if isinstance(value, str) else _number(value)}"


def _rows(points: NDArray[np.float64]) -> str:
    body = "".join(f"  {_row(point)},\n" for point in points.tolist())
    return f"[\n{body}]"


def _row(numbers: Iterable[float]) -> str:
    return f"[{', '.join(_number(number) for number in numbers)}]"


def _number(value: float) -> str:
    # repr is the shortest text that is read back to the same number.
    return repr(float(value))


def _key(name: str) -> str:
    bare = name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if bare else _text(name)


def _text(text: str) -> str:
    """A basic TOML string: what it may not hold as it is, it holds by its number."""
    escapes = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r"}
    return '"' + "".join(_letter(letter, escapes) for letter in text) + '"'


def _letter(letter: str, escapes: Mapping[str, str]) -> str:
    if letter in escapes:
        return escapes[letter]
    if ord(letter) < 0x20 or ord(letter) == 0x7F:
        return f"\\u{ord(letter):04X}"
    return letter
