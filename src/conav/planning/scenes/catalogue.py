"""The catalogue of made scenes: names, and the class of settings behind each name."""

import difflib
from collections.abc import Mapping
from dataclasses import fields
from importlib import import_module
from typing import Any, Protocol, cast

import numpy as np

from conav.errors import InputError
from conav.planning.types import PlanningProblem

MAX_ROBOTS = 1024

SCENES: dict[str, str] = {
    "random-discs": "conav.planning.scenes.random_discs:RandomDiscs",
    "intersection": "conav.planning.scenes.intersection:Intersection",
    "antipodal-circle": "conav.planning.scenes.antipodal_circle:AntipodalCircle",
    "narrow-passage": "conav.planning.scenes.narrow_passage:NarrowPassage",
    "office-delivery": "conav.planning.scenes.office_delivery:OfficeDelivery",
}
"""Scene name -> "module:class"; nothing is imported before it is asked for."""


class SceneMaker(Protocol):
    """Settings of a kind of scene; `robots` is the first of them."""

    robots: int

    def problem(self, rng: np.random.Generator) -> PlanningProblem:
        """The scene, with draws from `rng` and nothing else."""
        ...


def scene_class(name: str) -> type[Any]:
    """The class of settings behind a scene's name. Raises `InputError` for an unknown name."""
    if name not in SCENES:
        near = difflib.get_close_matches(name, SCENES, n=1)
        hint = f"did you mean {near[0]}?" if near else "use one of: " + ", ".join(SCENES)
        raise InputError(f"scene {name!r}", "there is no made scene of that name", hint)
    module, _, attribute = SCENES[name].partition(":")
    return cast("type[Any]", getattr(import_module(module), attribute))


def scene_settings(name: str) -> dict[str, object]:
    """The settings of a made scene with their defaults."""
    return {item.name: item.default for item in fields(scene_class(name))}


def make_scene(
    name: str, settings: Mapping[str, object] | None = None, *, seed: int = 0
) -> PlanningProblem:
    """The made scene of that name, as that seed draws it; text is read as the setting's type.

    Equal arguments give equal scenes on every machine. Raises `InputError` for an unknown name, a
    misspelt setting, a value that does not fit, and when the robots find no room.

    >>> [robot.name for robot in make_scene("narrow-passage", {"robots": 2}).robots]
    ['robot_0', 'robot_1']
    """
    from pydantic import ConfigDict, TypeAdapter, ValidationError

    cls = scene_class(name)
    names = [item.name for item in fields(cls)]
    given = dict(settings or {})
    for key in given:
        if key not in names:
            near = difflib.get_close_matches(key, names, n=1, cutoff=0.5)
            hint = f"did you mean {near[0]}?" if near else f"its settings: {', '.join(names)}"
            raise InputError(f"setting {key!r}", f"scene {name} has no such setting", hint)
    if seed < 0:
        raise InputError(f"scene {name}", f"the seed must not be negative, not {seed}", "try 0")
    cls.__pydantic_config__ = ConfigDict(extra="forbid", allow_inf_nan=False)
    try:
        maker = cast("SceneMaker", TypeAdapter(cls).validate_python(given))
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        problem = first["msg"].removeprefix("Value error, ")
        if not key:
            raise InputError(f"settings of scene {name}", problem, "change one of them") from None
        raise InputError(
            f"setting {key!r} of scene {name}",
            f"got {first['input']!r}: {problem}",
            f"without it, it is {scene_settings(name)[key]}",
        ) from None
    return maker.problem(np.random.Generator(np.random.PCG64(seed)))
