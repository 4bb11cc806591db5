"""Rings as plain text: a point `x y` a line, rings parted by comments or empty lines.

VisiLibity's `.environment` files [Obermeyer2008] part rings by comment lines (`//`); files of one
ring without any comment are common, too. The first ring is the outer one.
"""

import re
from pathlib import Path

from conav.errors import InputError
from conav.maps.file_text import file_text
from conav.maps.polygon_map import PolygonMap
from conav.maps.repair_polygon import repair_polygon_map

_FORM = "write a point x y a line, and // or an empty line between rings"


def read_environment(path: str | Path) -> PolygonMap:
    """The polygon in a text file of points, its first ring outside and the others holes.

    Lines that begin with `//`, `#` or `%` are comments; numbers are parted by blanks, tabs or a
    comma. Raises `InputError`, with the line, for what is no point, and for rings beyond repair.
    """
    path = Path(path)
    rings: list[list[tuple[float, float]]] = [[]]
    for number, line in enumerate(file_text(path, "a polygon").splitlines(), start=1):
        point = _point(line)
        if point is not None:
            rings[-1].append(point)
        elif line.strip() and not line.lstrip().startswith(("//", "#", "%")):
            raise InputError(path, f"line {number}: {line.strip()[:40]!r} is no point", _FORM)
        elif rings[-1]:
            rings.append([])
    rings = [ring for ring in rings if ring]
    if not rings:
        raise InputError(path, "holds no point", _FORM)
    return repair_polygon_map(rings[0], rings[1:], name=path.stem)


def looks_like_points(text: str) -> bool:
    """Whether the first line that is neither empty nor a comment is a point."""
    lines = (line.strip() for line in text.splitlines())
    first = next((line for line in lines if line and not line.startswith(("//", "#", "%"))), "")
    return _point(first) is not None


def _point(line: str) -> tuple[float, float] | None:
    words = re.split(r"[\s,]+", line.strip())
    if len(words) != 2:
        return None
    try:
        return float(words[0]), float(words[1])
    except ValueError:
        return None
