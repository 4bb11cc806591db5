"""A scene from whatever names it: a file in any format that is read, or a kind that is made."""

import difflib
import json
import os
from dataclasses import replace
from pathlib import Path

from conav.errors import InputError
from conav.maps.image import file_bytes
from conav.planning.foreign.cgshop import cgshop_problem, is_cgshop, is_cgshop_solution
from conav.planning.foreign.db_cbs import read_db_cbs
from conav.planning.foreign.movingai_scenario import read_movingai_scenario
from conav.planning.scene_file import read_scene_file
from conav.planning.scenes.catalogue import SCENES, make_scene
from conav.planning.scenes.frozen_scenes import FROZEN, frozen_path
from conav.planning.types import PlanningProblem

SUFFIXES = {
    ".toml": "a scene",
    ".json": "a scene, or a CG:SHOP 2021 instance",
    ".yaml": "a db-CBS scene",
    ".yml": "a db-CBS scene",
    ".scen": "a MovingAI scenario, beside its map",
}
"""What a file of a scene is, by its suffix."""

_COUNTED = (".scen",)


def load_scene(
    source: str | os.PathLike[str], *, robots: int | None = None, seed: int = 0
) -> PlanningProblem:
    """The problem behind a file or the name of a made scene.

    A file is read as its suffix says (`SUFFIXES`). A made scene's name may be followed by settings:
    `antipodal-circle:12` is 12 robots, `random-discs:8,obstacles=20,seed=3` says more; `seed` draws
    it where the name has none. Frozen scenes (`FROZEN`) are files that come with conav, by name.
    `file.scen:10` is the first 10 entries of a scenario. `robots` does what the number after the
    colon does, for made scenes and scenarios, and for a file in another format takes only the first
    robots.

    Raises `InputError`, with a remedy, for everything that is no scene.

    >>> len(load_scene("antipodal-circle:12").robots)
    12
    """
    text = os.fspath(source)
    name, settings = _parted(text)
    path = Path(name)
    if path.suffix.lower() in SUFFIXES:
        if settings and (path.suffix.lower() not in _COUNTED or set(settings) != {"robots"}):
            raise InputError(
                text, "only a number of robots can follow the name of a .scen file, and nothing "
                "that of another", f"give {name}",
            )  # fmt: skip
        count = _whole(text, settings["robots"]) if settings else robots
        if not path.exists():
            raise _missing(path)
        return _read(path, count)
    if name in FROZEN:
        if settings and set(settings) != {"robots"}:
            raise InputError(
                text, f"{name} is frozen: only a number of robots can follow its name",
                f"for others take {FROZEN[name].scene}",
            )  # fmt: skip
        count = _whole(text, settings["robots"]) if settings else robots
        return _read(frozen_path(name), count)
    if name in SCENES:
        if robots is not None:
            settings.setdefault("robots", str(robots))
        seed = _whole(text, settings.pop("seed")) if "seed" in settings else seed
        return make_scene(name, settings, seed=seed)
    raise _unknown(text, path)


def _read(path: Path, robots: int | None) -> PlanningProblem:
    suffix = path.suffix.lower()
    if suffix == ".scen":
        return read_movingai_scenario(path, robots=robots)
    if suffix in (".yaml", ".yml"):
        problem = read_db_cbs(path)
    else:
        problem = _read_json(path) if suffix == ".json" else read_scene_file(path)
    return problem if robots is None else _first(path, problem, robots)


def _read_json(path: Path) -> PlanningProblem:
    try:
        content = json.loads(file_bytes(path).decode("utf-8-sig"))
    except (ValueError, RecursionError):
        content = None  # the reader of scenes says what is wrong
    if is_cgshop(content) or is_cgshop_solution(content):
        return cgshop_problem(path, content)
    return read_scene_file(path)


def _first(path: Path, problem: PlanningProblem, robots: int) -> PlanningProblem:
    if not 1 <= robots <= len(problem.robots):
        raise InputError(
            path, f"has {len(problem.robots)} robots, not {robots}",
            f"ask for 1 to {len(problem.robots)}",
        )  # fmt: skip
    kept = problem.robots[:robots]
    names = {robot.name for robot in kept}
    for coupling in problem.couplings:
        if not names.issuperset(coupling.robots):
            raise InputError(
                path, f"couples {' and '.join(coupling.robots)}, and the first {robots} robots "
                "are not both of them", "ask for all robots",
            )  # fmt: skip
    return replace(problem, robots=kept)


def _parted(text: str) -> tuple[str, dict[str, str]]:
    """A name and the settings after its colon; a colon of a path is none."""
    name, colon, rest = text.rpartition(":")
    if not colon or "/" in rest or "\\" in rest or os.path.exists(text):
        return text, {}
    settings: dict[str, str] = {}
    for index, part in enumerate(rest.split(",")):
        key, equals, value = part.partition("=")
        if not equals:
            if index > 0 or not part.strip().isdigit():
                raise InputError(
                    text, f"{part!r} is not name=value",
                    "write NAME:ROBOTS or NAME:ROBOTS,name=value,...",
                )  # fmt: skip
            key, value = "robots", part
        settings[key.strip().replace("-", "_")] = value.strip()
    return name, settings


def _whole(place: str, text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise InputError(place, f"{text!r} is not a whole number", "write one") from None


def _missing(path: Path) -> InputError:
    if not path.parent.is_dir():
        return InputError(path, f"there is no folder {path.parent}", "check the path")
    names = sorted(entry.name for entry in path.parent.iterdir())
    scenes = [name for name in names if Path(name).suffix.lower() in SUFFIXES]
    near = difflib.get_close_matches(path.name, scenes, n=2)
    remedy = f"did you mean {' or '.join(near)}?" if near else "check the path"
    return InputError(path, "does not exist", remedy)


def _unknown(text: str, path: Path) -> InputError:
    name = path.name
    near = difflib.get_close_matches(name, [*SCENES, *FROZEN], n=1)
    if near:
        return InputError(f"scene {text!r}", "is not known", f"did you mean {near[0]}?")
    kinds = ", ".join(SUFFIXES)
    if path.suffix and path.is_file():
        return InputError(path, f"{path.suffix} is not the suffix of a scene", f"known: {kinds}")
    made = ", ".join(SCENES)
    return InputError(
        f"scene {text!r}", "is neither a scene file nor a made scene",
        f"give a file ({kinds}) or one of: {made}",
    )  # fmt: skip
