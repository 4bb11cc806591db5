"""What is wrong with a scene file, in one line that names the key and the nearest right one."""

import difflib
from dataclasses import fields
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from conav.errors import InputError
from conav.planning.scene_format import (
    CouplingEntry,
    FloorEntry,
    RobotDefaults,
    RobotEntry,
    SceneFile,
    Shape,
)

_MISSPELT = "unexpected_keyword_argument"
# A key that is missing and a list that is too short often follow from another mistake.
_RANK = {_MISSPELT: 0, "missing": 2, "too_short": 2}
_REMEDY = {
    "float_type": "write a number without quotes",
    "int_type": "write a whole number",
    "string_type": "write it in quotes",
    "tuple_type": "write a list in brackets",
    "dataclass_type": "write a table of keys and values",
    "dict_type": "write a table of keys and values",
    "finite_number": "give a number that is neither inf nor nan",
}


def scene_error(path: Path, error: ValidationError) -> InputError:
    """The first thing to mend in a scene file, misspelt keys before what may follow from them."""
    first = min(error.errors(include_url=False), key=lambda item: _RANK.get(item["type"], 1))
    loc = first["loc"]
    if first["type"] == _MISSPELT:
        return _misspelt(path, loc)
    place = f"{path}: {shown(loc)}" if loc else str(path)
    if first["type"] == "missing":
        return InputError(f"{path}: {shown(loc[:-1])}" if loc[:-1] else path,
                          f"the key {loc[-1]} is missing", _remedy_for_missing(loc))  # fmt: skip
    problem = first["msg"].removeprefix("Value error, ")
    if first["type"] == "literal_error":
        near = _nearest(str(first["input"]), _quoted(problem))
        return InputError(place, f"{first['input']!r} is none of {', '.join(_quoted(problem))}",
                          f"did you mean {near}?" if near else "write one of them")  # fmt: skip
    problem = problem[0].lower() + problem[1:].replace("Tuple", "list")
    got = "" if isinstance(first["input"], dict) else f", got {first['input']!r}"
    return InputError(place, problem + got, _REMEDY.get(first["type"], "correct it"))


def shown(loc: tuple[str | int, ...]) -> str:
    """A place in a file as people write it.

    >>> shown(("robots", 2, "start"))
    'robots[2].start'
    """
    text = ""
    for part in loc:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def _misspelt(path: Path, loc: tuple[str | int, ...]) -> InputError:
    names = [item.name for item in fields(_table(loc[:-1]))]
    key = str(loc[-1])
    near = _nearest(key, names)
    where = f"in {shown(loc[:-1])}" if loc[:-1] else "at the top"
    return InputError(
        f"{path}: {shown(loc)}",
        f"there is no key {key} {where}",
        f"did you mean {near}?" if near else f"its keys: {', '.join(names)}",
    )


def _table(loc: tuple[str | int, ...]) -> type[Any]:
    """The type of the table at a place."""
    if not loc:
        return SceneFile
    if loc[0] == "floor":
        return FloorEntry
    if loc[0] == "defaults":
        return RobotDefaults
    if loc[0] == "couplings" and len(loc) == 2:
        return CouplingEntry
    return RobotEntry if loc[0] == "robots" and len(loc) == 2 else Shape


def _nearest(word: str, known: list[str]) -> str | None:
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    if near:
        return near[0]
    # radius for radius_m: units are easily forgotten.
    return next((name for name in known if name.startswith(word + "_")), None)


def _quoted(text: str) -> list[str]:
    return text.split("'")[1::2]


def _remedy_for_missing(loc: tuple[str | int, ...]) -> str:
    examples = {
        "floor": '[floor] with map = "office", or box = [0, 0, 20, 10]',
        "robots": "a table [[robots]] for every robot",
        "horizon_s": "horizon_s = 60, the seconds everybody has",
        "start": "start = [1.0, 2.0], metres",
    }
    return f"add {examples.get(str(loc[-1]), str(loc[-1]))}"
