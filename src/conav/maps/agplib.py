"""Polygons of the art gallery library [Couto2011], `.pol`.

A number of points, then x and y of each, as fractions `a/b`; if more follows, a number of holes and
each hole in the same form. Either way round is accepted, as both occur.
"""

from fractions import Fraction
from pathlib import Path

from conav.errors import InputError
from conav.maps.file_text import file_text
from conav.maps.polygon_map import PolygonMap
from conav.maps.repair_polygon import repair_polygon_map

_FORM = "a .pol holds: points, x y of each as a/b; holes, and each hole likewise"


def read_agplib(path: str | Path) -> PolygonMap:
    """The polygon in a `.pol` file; each coordinate is the double nearest to its fraction.

    Raises `InputError`, with the place in the file, for what is no number, for too few or too many
    numbers, and for rings beyond repair.
    """
    path = Path(path)
    words = file_text(path, "a .pol polygon").split()
    at = 0

    def count(what: str, least: int) -> int:
        nonlocal at
        text = words[at] if at < len(words) else "nothing"
        at += 1
        if not text.isdecimal() or len(text) > 9 or int(text) < least:
            raise InputError(path, f"word {at} is {text[:40]!r}, not a number of {what}", _FORM)
        return int(text)

    def ring() -> list[tuple[float, float]]:
        nonlocal at
        size = count("points", 3)
        if at + 2 * size > len(words):
            left = len(words) - at
            raise InputError(path, f"ends after {left} of {2 * size} numbers of a ring", _FORM)
        values = [_number(path, at + i + 1, words[at + i]) for i in range(2 * size)]
        at += 2 * size
        return list(zip(values[::2], values[1::2], strict=True))

    outer = ring()
    holes = [ring() for _ in range(count("holes", 0))] if at < len(words) else []
    if at < len(words):
        raise InputError(path, f"{len(words) - at} words follow the last ring", _FORM)
    return repair_polygon_map(outer, holes, name=path.stem)


def _number(path: Path, place: int, text: str) -> float:
    try:
        if len(text) > 4000:  # Python's own limit on digits is near
            raise ValueError
        return float(Fraction(text))
    except (ValueError, ZeroDivisionError, OverflowError):
        raise InputError(path, f"word {place} is {text[:40]!r}, not a fraction", _FORM) from None
