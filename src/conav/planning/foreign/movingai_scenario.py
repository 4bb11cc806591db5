"""Scenarios of the MovingAI benchmarks: starts and goals on a grid map [Stern2019]."""

import os
import re
from pathlib import Path
from typing import NamedTuple

from conav.errors import InputError
from conav.maps.image import file_bytes
from conav.maps.movingai import read_movingai
from conav.maps.occupancy_grid import FREE, OccupancyGrid
from conav.planning.floor import floor_of_grid
from conav.planning.foreign.cells import DISC_CELLS, GOAL_CELLS, HORIZON_FACTOR, SHORTEST_S
from conav.planning.types import PlanningProblem, PlanningRobot, Region

DEFAULT_ROBOTS = 8

_COLUMNS = "bucket, map, width, height, start x, start y, goal x, goal y, length"


class Entry(NamedTuple):
    """A line of a scenario; x counts columns, y rows from the top."""

    line: int
    map: str
    width: int
    height: int
    start: tuple[int, int]
    goal: tuple[int, int]
    length: float  # of the shortest 8-connected path, without cutting corners [cells]


def read_movingai_scenario(
    path: str | os.PathLike[str], *, robots: int | None = None
) -> PlanningProblem:
    """The problem of the first entries of a `.scen` file, on the map that it names.

    The map is looked for beside the file, and where the file says. A cell is a square metre, a
    robot a disc of radius 0.35 m at the middle of its cell (`DISC_CELLS`) that moves at 1 m/s and
    stays at its goal, a disc of radius 0.1 m. `robots` is how many entries, `DEFAULT_ROBOTS` unless
    given, or all of a shorter file. Entries are independent of each other in files of problems for
    one robot (`*.map.scen`), so several of those may start on top of each other.

    Raises `InputError` that names the line, for entries that do not fit the map too.
    """
    path = Path(path)
    entries = read_entries(path)
    wanted = min(DEFAULT_ROBOTS, len(entries)) if robots is None else robots
    if not 1 <= wanted <= len(entries):
        raise InputError(
            path, f"has {len(entries)} entries, not {wanted}",
            f"ask for 1 to {len(entries)} robots",
        )  # fmt: skip
    entries = entries[:wanted]
    grid = read_movingai(map_path(path, entries[0]))
    for entry in entries:
        _check_entry(path, entry, entries[0], grid)
    built = tuple(_robot(grid, index, entry) for index, entry in enumerate(entries))
    floor = floor_of_grid(grid, built)
    longest = max(entry.length for entry in entries)
    return PlanningProblem(
        floor=floor,
        robots=built,
        horizon_s=max(SHORTEST_S, HORIZON_FACTOR * longest),
        name=path.stem,
    )


def read_entries(path: Path) -> list[Entry]:
    """The lines of a scenario. Raises `InputError` that names the line."""
    lines = file_bytes(path).decode("utf-8", "replace").removeprefix("\ufeff").splitlines()
    if not lines or not re.fullmatch(r"version\s+1(\.0)?", lines[0].strip()):
        raise InputError(f"{path}, line 1", "is not 'version 1'", "give a MovingAI .scen file")
    entries: list[Entry] = []
    for number, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        words = line.split("\t") if "\t" in line else line.split()
        try:
            _, name, *numbers, length = (word.strip() for word in words)
            width, height, x0, y0, x1, y1 = (int(word) for word in numbers)
            entry = Entry(number, name, width, height, (x0, y0), (x1, y1), float(length))
        except ValueError:
            raise InputError(
                f"{path}, line {number}", "is no entry", f"its nine columns are {_COLUMNS}"
            ) from None
        entries.append(entry)
    if not entries:
        raise InputError(path, "has no entry", "give a MovingAI .scen file with some")
    return entries


def map_path(path: Path, entry: Entry) -> Path:
    """Where the map of a scenario's entry lies: beside the scenario, or where it says."""
    said = entry.map.replace("\\", "/")
    beside = path.parent / said.rsplit("/", 1)[-1]
    for candidate in (beside, path.parent / said):
        if candidate.is_file():
            return candidate
    raise InputError(
        f"{path}, line {entry.line}", f"its map {said} is not there", f"put it at {beside}"
    )


def _check_entry(path: Path, entry: Entry, first: Entry, grid: OccupancyGrid) -> None:
    place = f"{path}, line {entry.line}"
    if entry.map != first.map:
        raise InputError(place, f"is on {entry.map}, not {first.map}", "ask for fewer robots")
    if (entry.width, entry.height) != (grid.cols, grid.rows):
        raise InputError(
            place, f"says {entry.width} x {entry.height}, and the map is {grid.cols} x {grid.rows}",
            "find the map it was made for",
        )  # fmt: skip
    for what, (x, y) in (("start", entry.start), ("goal", entry.goal)):
        inside = 0 <= x < grid.cols and 0 <= y < grid.rows
        if not inside or grid.cells[grid.rows - 1 - y, x] != FREE:
            raise InputError(
                place, f"its {what} {x}, {y} is not free on the map", "find the map it was made for"
            )


def _robot(grid: OccupancyGrid, index: int, entry: Entry) -> PlanningRobot:
    start, goal = ((x + 0.5, grid.rows - 1 - y + 0.5) for x, y in (entry.start, entry.goal))
    return PlanningRobot(
        name=f"robot_{index}",
        start=start,
        task="F goal",
        regions={"goal": Region("goal", disc=(*goal, GOAL_CELLS))},
        radius_m=DISC_CELLS,
    )
