"""The catalogue of built-in floor plans, and how they are named: `comb:6`, `spider:2,2,2`.

A name is an entry's, then its whole numbers after a colon, in order or as `name=value`; what is
left out has its default: `corridor-tree:seed=3,segments=20`.
"""

import difflib
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import cast

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap


@dataclass(frozen=True)
class Number:
    """A whole number that a floor plan is made of."""

    name: str
    default: int
    least: int
    greatest: int


@dataclass(frozen=True)
class FloorPlan:
    """An entry of the catalogue: what it is, its numbers, and the function that draws it."""

    name: str
    description: str
    numbers: tuple[Number, ...]
    function: str  # "module:name", called with the numbers in order

    @property
    def example(self) -> str:
        """The full name with all defaults."""
        return self.name + (":" if self.numbers else "") + _values(self.numbers)


def _values(numbers: tuple[Number, ...]) -> str:
    plain = all(number.name != "seed" for number in numbers)
    return ",".join(
        str(number.default) if plain else f"{number.name}={number.default}" for number in numbers
    )


_HOME = "conav.maps.floor_plans"
_SEED = Number("seed", 0, 0, 2**63 - 1)
_ENTRIES = (
    FloorPlan(
        "comb",
        "A straight corridor with deep teeth on one side",
        (Number("teeth", 6, 1, 5000),),
        f"{_HOME}.comb:comb",
    ),
    FloorPlan(
        "rooms",
        "Rooms behind doors, above and below a corridor in turn",
        (Number("rooms", 3, 1, 2500),),
        f"{_HOME}.rooms:rooms",
    ),
    FloorPlan(
        "spider",
        "Three corridors with so many bends each, from one junction",
        (Number("first", 2, 0, 200), Number("second", 2, 0, 200), Number("third", 2, 0, 200)),
        f"{_HOME}.triples:spider",
    ),
    FloorPlan(
        "triples",
        "Nested triples: three copies of the one before at a junction; needs as many searchers",
        (Number("depth", 3, 1, 7),),
        f"{_HOME}.triples:triples",
    ),
    FloorPlan("ring", "A square corridor around one block", (), f"{_HOME}.streets:ring"),
    FloorPlan(
        "streets",
        "So many streets each way around square blocks",
        (Number("streets", 4, 2, 60),),
        f"{_HOME}.streets:streets",
    ),
    FloorPlan(
        "corridor-tree",
        "A random tree of corridors",
        (Number("segments", 20, 1, 3000), _SEED),
        f"{_HOME}.corridor_tree:corridor_tree",
    ),
    FloorPlan(
        "office-loops",
        "Rows of rooms along corridors that form loops, at random",
        (Number("corridors", 2, 1, 20), _SEED),
        f"{_HOME}.office_loops:office_loops",
    ),
)

FLOOR_PLANS: dict[str, FloorPlan] = {entry.name: entry for entry in _ENTRIES}


def builtin_floor_plan(name: str) -> PolygonMap:
    """The built-in floor plan of that name and numbers, equal on every machine.

    Raises `InputError` for a name, a number's name or a number the catalogue does not have.

    >>> builtin_floor_plan("spider:2,2,2").area
    37.0
    >>> builtin_floor_plan("streets:streets=3").name
    'streets:3'
    """
    family, colon, rest = name.partition(":")
    if family not in FLOOR_PLANS:
        near = difflib.get_close_matches(family.lower(), FLOOR_PLANS, n=2)
        hint = f"did you mean {' or '.join(near)}? " if near else ""
        raise InputError(
            repr(name),
            "there is no built-in floor plan of that name",
            f"{hint}known: {', '.join(FLOOR_PLANS)}",
        )
    entry = FLOOR_PLANS[family]
    values = _numbers(name, entry, rest.split(",") if colon else [])
    module, _, function = entry.function.partition(":")
    draw = cast("Callable[..., PolygonMap]", getattr(import_module(module), function))
    return draw(*values)


def is_floor_plan_name(name: str) -> bool:
    """Whether the part before a colon is the name of a built-in floor plan."""
    return name.partition(":")[0] in FLOOR_PLANS


def _numbers(name: str, entry: FloorPlan, words: list[str]) -> list[int]:
    usage = f"write it as {entry.example}"
    values = {number.name: number.default for number in entry.numbers}
    known = list(values)
    given: set[str] = set()
    for place, word in enumerate(words):
        key, equals, text = word.partition("=")
        if not equals:
            key, text = (known[place] if place < len(known) else "", word)
        key = key.strip()
        if key not in values or key in given:
            problem = f"{word!r} is one number too many" if not equals else f"{word!r} is unknown"
            problem = f"{key} is given twice" if key in given else problem
            raise InputError(name, problem, usage)
        given.add(key)
        number = entry.numbers[known.index(key)]
        try:
            values[key] = int(text)
        except ValueError:
            raise InputError(name, f"{key}: {text!r} is no whole number", usage) from None
        if not number.least <= values[key] <= number.greatest:
            raise InputError(
                name,
                f"{key} is {values[key]}",
                f"give {number.least} to {number.greatest}",
            )
    return list(values.values())
