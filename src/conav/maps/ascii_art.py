"""Maps as text, for tests, examples and teaching: `#` is a wall, letters are robots.

The letters follow POGEMA (Skrynnik et al. 2022): `.` free, `#` occupied, `a` a robot.
"""

import string
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from conav.errors import InputError
from conav.maps.image import checked_resolution, file_bytes
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

_STARTS = frozenset(string.ascii_letters)
_KNOWN = _STARTS | frozenset(". #?")
_LEGEND = "use . or space for free, # for occupied, ? for unknown and letters for robot starts"


def parse_ascii(
    text: str,
    *,
    resolution: float = 1.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    name: str = "map",
) -> OccupancyGrid:
    """The map drawn in `text`; its bottom row is row 0, `resolution` is in metres per cell.

    `.` and space are free, `#` is occupied, `?` unknown; a letter is a robot's start, a free cell.
    Empty lines before and after the drawing do not count.

    Raises `InputError`, with line and column, for rows of different lengths, other characters and
    a letter that occurs twice; also for a bad resolution or origin.

    >>> grid = parse_ascii('''
    ... ####
    ... #a?.
    ... ''')
    >>> grid.cells.tolist()
    [[1, 0, 2, 0], [1, 1, 1, 1]]
    """
    resolution = checked_resolution(name, resolution)
    rows = _rows(text, name)
    table = np.zeros(128, dtype=np.uint8)  # zero is FREE: dots, spaces and letters
    table[ord("#")] = OCCUPIED
    table[ord("?")] = UNKNOWN
    letters = np.frombuffer("".join(rows).encode("ascii"), dtype=np.uint8)
    cells = table[letters.reshape(len(rows), -1)]
    try:
        return OccupancyGrid(np.flipud(cells), resolution, origin, name)
    except (TypeError, ValueError) as error:
        raise InputError(name, str(error), "give the origin as (x, y, yaw)") from error


def read_ascii(path: str | Path, *, resolution: float = 1.0) -> OccupancyGrid:
    """The map drawn in a text file, as `parse_ascii` reads it."""
    path = Path(path)
    try:
        text = file_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(path, "is not a text file", _LEGEND) from error
    checked_resolution(path, resolution)
    _rows(text, path)  # once more, for errors that name the file
    return parse_ascii(text, resolution=resolution, name=path.stem)


def ascii_starts(text: str) -> dict[str, tuple[int, int]]:
    """The cell (row, col) of each robot letter, in the order of the alphabet; row 0 at the bottom.

    >>> ascii_starts('''
    ... #b.
    ... #.a
    ... ''')
    {'a': (0, 2), 'b': (1, 1)}
    """
    rows = _rows(text, "map")
    found = {
        letter: (len(rows) - 1 - top, row.index(letter))
        for top, row in enumerate(rows)
        for letter in _STARTS.intersection(row)
    }
    return dict(sorted(found.items()))


def to_ascii(grid: OccupancyGrid) -> str:
    """The grid as text that `parse_ascii` reads back: `.` free, `#` occupied, `?` unknown.

    >>> print(to_ascii(parse_ascii('#.?')))
    #.?
    """
    letters = np.empty(3, dtype=np.uint8)
    letters[[FREE, OCCUPIED, UNKNOWN]] = list(b".#?")
    return "\n".join(row.tobytes().decode("ascii") for row in letters[np.flipud(grid.cells)])


def _rows(text: str, place: object) -> Sequence[str]:
    """The rows of the drawing, top first, all of one length and of known characters."""
    lines = text.replace("\r\n", "\n").split("\n")
    numbered = list(enumerate(lines, start=1))
    while numbered and not numbered[-1][1]:
        numbered.pop()
    while numbered and not numbered[0][1]:
        numbered.pop(0)
    if not numbered:
        raise InputError(place, "has no rows", f"draw a map: {_LEGEND}")
    width = len(numbered[0][1])
    seen: set[str] = set()
    for number, row in numbered:
        used = set(row)
        if foreign := used - _KNOWN:
            col, character = min((row.index(character), character) for character in foreign)
            raise InputError(
                place, f"line {number}, column {col + 1}: {character!r} means nothing here", _LEGEND
            )
        if len(row) != width:
            raise InputError(
                place,
                f"line {number}, column {min(len(row), width) + 1}: the row has {len(row)}"
                f" characters, the first row has {width}",
                "make all rows equally long; a space at the end counts as a free cell",
            )
        for letter in sorted(used & _STARTS):
            if letter in seen or row.count(letter) > 1:
                raise InputError(
                    place,
                    f"line {number}, column {row.rindex(letter) + 1}: robot {letter!r} a second"
                    " time",
                    "give each robot a letter of its own and . to free cells",
                )
        seen |= used & _STARTS
    return [row for _, row in numbered]
