"""Instances of the CG:SHOP 2021 challenge: unit squares on a grid, as discs [Fekete2022]."""

import json
import os
from pathlib import Path
from typing import Any, cast

from conav.errors import InputError
from conav.maps.image import file_bytes
from conav.planning.floor import floor_between
from conav.planning.foreign.cells import DISC_CELLS, GOAL_CELLS, HORIZON_FACTOR, SHORTEST_S
from conav.planning.types import PlanningProblem, PlanningRobot, Region

BORDER_CELLS = 5
"""The grid of an instance is unbounded; the floor goes on so far around all that is in it."""

KEYS = ("starts", "targets", "obstacles")
Cell = tuple[int, int]


def is_cgshop(content: object) -> bool:
    """Whether a JSON object is an instance: it has starts, targets and obstacles."""
    return isinstance(content, dict) and all(key in content for key in KEYS)


def is_cgshop_solution(content: object) -> bool:
    """Whether a JSON object is a solution: it names an instance and has steps."""
    return isinstance(content, dict) and "instance" in content and "steps" in content


def read_cgshop(path: str | os.PathLike[str]) -> PlanningProblem:
    """The problem in a CG:SHOP 2021 `.instance.json`; a cell is a square metre about its middle.

    A robot is a disc of radius 0.35 m, not the square of side 1 m, which would fit every gap
    exactly: see `DISC_CELLS` for why what is solvable with squares stays so. Robots stay at their
    targets, discs of radius 0.1 m, and move at 1 m/s. Raises `InputError` that names the place.
    """
    path = Path(path)
    try:
        content = json.loads(file_bytes(path).decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise InputError(path, f"is no JSON ({error})", "give an .instance.json") from None
    return cgshop_problem(path, content)


def cgshop_problem(path: Path, content: object) -> PlanningProblem:
    """The problem in an instance that was read from a file."""
    if is_cgshop_solution(content):
        raise InputError(
            path, "is a solution, not a problem",
            f"give the instance, {cast('dict[str, Any]', content)['instance']}.instance.json",
        )  # fmt: skip
    if not is_cgshop(content):
        raise InputError(path, "is no CG:SHOP instance", f"it needs the keys {', '.join(KEYS)}")
    table = cast("dict[str, Any]", content)
    starts, targets, obstacles = (_cells(path, key, table[key]) for key in KEYS)
    if len(starts) != len(targets) or not starts:
        raise InputError(
            f"{path}: targets", f"there are {len(targets)} for {len(starts)} starts",
            "give one target for every start, and at least one",
        )  # fmt: skip
    everything = starts + targets + obstacles
    low = [min(cell[axis] for cell in everything) - BORDER_CELLS - 0.5 for axis in (0, 1)]
    high = [max(cell[axis] for cell in everything) + BORDER_CELLS + 0.5 for axis in (0, 1)]
    name = str(table.get("name") or path.name.removesuffix(".json").removesuffix(".instance"))
    robots = tuple(
        PlanningRobot(
            name=f"robot_{index}",
            start=(float(start[0]), float(start[1])),
            task="F goal",
            regions={"goal": Region("goal", disc=(float(target[0]), float(target[1]), GOAL_CELLS))},
            radius_m=DISC_CELLS,
        )
        for index, (start, target) in enumerate(zip(starts, targets, strict=True))
    )
    floor = floor_between(
        [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])],
        walls=[
            [(x - 0.5, y - 0.5), (x + 0.5, y - 0.5), (x + 0.5, y + 0.5), (x - 0.5, y + 0.5)]
            for x, y in obstacles
        ],
        robots=robots,
        name=name,
    )
    longest = max(abs(a[0] - b[0]) + abs(a[1] - b[1]) for a, b in zip(starts, targets, strict=True))
    horizon = max(SHORTEST_S, HORIZON_FACTOR * longest)
    return PlanningProblem(floor, robots, horizon_s=horizon, name=name)


def _cells(path: Path, key: str, value: object) -> list[Cell]:
    place = f"{path}: {key}"
    if not isinstance(value, list):
        raise InputError(place, "is no list of cells", "write [[x, y], ...]")
    cells: list[Cell] = []
    for index, item in enumerate(cast("list[Any]", value)):
        if not (isinstance(item, list) and len(item) == 2 and all(type(v) is int for v in item)):  # pyright: ignore
            raise InputError(f"{place}[{index}]", f"{item!r} is no cell", "write [x, y], whole")
        cells.append((item[0], item[1]))
    return cells
