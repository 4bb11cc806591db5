"""Grid maps of the MovingAI benchmarks (Sturtevant 2012, doi:10.1109/TCIAIG.2012.2197681)."""

import re
from pathlib import Path

import numpy as np

from conav.errors import InputError
from conav.maps.image import MAX_CELLS, checked_resolution, file_bytes
from conav.maps.occupancy_grid import FREE, OCCUPIED, OccupancyGrid

PASSABLE = b".GS"  # ground twice, swamp
BLOCKED = b"@OTW"  # out of bounds twice, trees; water can only be entered from water
_FOREIGN = 255
_HEADER = "begin the file with the lines 'type octile', 'height H', 'width W' and 'map'"


def read_movingai(path: str | Path, *, resolution: float = 1.0) -> OccupancyGrid:
    """The map in a MovingAI `.map` file of type octile, `resolution` in metres per cell.

    `.`, `G` and `S` are free, `@`, `O`, `T` and `W` occupied. The first row of the file is the top
    row of the map, so a scenario's cell (x, y) is `cells[rows - 1 - y, x]`.

    Raises `InputError`, with line and column, for another header, rows that are missing, too many
    or of another width, and unknown letters.
    """
    path = Path(path)
    resolution = checked_resolution(path, resolution)
    lines = file_bytes(path).removeprefix(b"\xef\xbb\xbf").split(b"\n")
    height, width, first = _header(path, lines)
    rows = [line.rstrip() for line in lines[first:]]
    while rows and not rows[-1]:
        rows.pop()
    for number, row in enumerate(rows[: height + 1], start=first + 1):
        if number > first + height:
            raise InputError(
                path,
                f"line {number}, column 1: a row more than the height {height} of the header",
                "correct the height or remove the row",
            )
        if len(row) != width:
            raise InputError(
                path,
                f"line {number}, column {min(len(row), width) + 1}: the row has {len(row)} letters,"
                f" the header says width {width}",
                "correct the row or the width",
            )
    if len(rows) < height:
        raise InputError(
            path,
            f"line {first + len(rows) + 1}, column 1: the file ends after {len(rows)} rows, the"
            f" header says height {height}",
            "copy the whole file again or correct the height",
        )
    table = np.full(256, _FOREIGN, dtype=np.uint8)
    table[list(PASSABLE)] = FREE
    table[list(BLOCKED)] = OCCUPIED
    letters = np.frombuffer(b"".join(rows), dtype=np.uint8).reshape(height, width)
    cells = table[letters]
    if cells.max() == _FOREIGN:
        row, col = divmod(int(np.argmax(cells == _FOREIGN)), width)
        raise InputError(
            path,
            f"line {first + 1 + row}, column {col + 1}: unknown terrain {chr(letters[row, col])!r}",
            "use . G S for passable and @ O T W for blocked cells",
        )
    return OccupancyGrid(np.flipud(cells), resolution, name=path.stem)


def _header(path: Path, lines: list[bytes]) -> tuple[int, int, int]:
    """Height, width and the index of the first line after the header."""
    found: dict[str, str] = {}
    for index, line in enumerate(lines):
        words = line[:100].decode("ascii", "replace").split()
        if not words:
            continue
        key = words[0].lower()
        if key == "map" and len(words) == 1:
            break
        if key not in ("type", "height", "width") or len(words) != 2 or key in found:
            shown = repr(" ".join(words)[:40])
            raise InputError(path, f"line {index + 1}, column 1: {shown} in the header", _HEADER)
        found[key] = words[1]
    else:
        raise InputError(path, f"line {len(lines)}, column 1: no line 'map'", _HEADER)
    for key in ("type", "height", "width"):
        if key not in found:
            raise InputError(path, f"line {index + 1}, column 1: no {key} before 'map'", _HEADER)
    if found["type"].lower() != "octile":
        raise InputError(path, f"its type is {found['type']!r}, only octile is read", _HEADER)
    for key in ("height", "width"):
        if not re.fullmatch(r"0*[1-9][0-9]{0,8}", found[key], re.ASCII):
            raise InputError(path, f"{key} is {found[key]!r}", f"write {key} as a positive integer")
    height, width = int(found["height"]), int(found["width"])
    if height * width > MAX_CELLS:
        raise InputError(
            path, f"height {height} times width {width} is over {MAX_CELLS:,} cells", _HEADER
        )
    return height, width, index + 1
