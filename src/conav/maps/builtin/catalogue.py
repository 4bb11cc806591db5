"""The catalogue of built-in maps: names, default sizes, and the function behind each name."""

import difflib
import math
import operator
from dataclasses import dataclass
from importlib import import_module
from typing import Protocol, cast

import numpy as np

from conav.errors import InputError
from conav.maps.occupancy_grid import OccupancyGrid

MIN_SIDE_M = 3.0  # [m] less is no place to drive in
MIN_SIDE_CELLS = 12  # below this walls leave no room for anything
MAX_CELLS = 100_000_000  # 100 MB of cells, and several times that while drawing them


class MapFunction(Protocol):
    """Draws a map of that size with draws from `rng` and nothing else."""

    def __call__(
        self, width_m: float, height_m: float, resolution: float, rng: np.random.Generator
    ) -> OccupancyGrid: ...


@dataclass(frozen=True)
class BuiltinMap:
    """An entry of the catalogue: what it is, how big by default, and who draws it."""

    name: str
    description: str
    width_m: float  # [m] default extent along x
    height_m: float  # [m] default extent along y
    resolution: float  # [m] default side of a cell
    function: str  # "module:name" of a `MapFunction`, imported when a map is asked for


_ENTRIES = (
    BuiltinMap(
        "office",
        "An office floor: corridors in a loop, rooms with doors, a lobby, open-plan areas, desks",
        30.0,
        20.0,
        0.1,
        "conav.maps.builtin.office:office",
    ),
    BuiltinMap(
        "cave",
        "A natural cave: chambers joined by winding passages",
        30.0,
        30.0,
        0.1,
        "conav.maps.builtin.cave:cave",
    ),
    BuiltinMap(
        "maze",
        "A maze of narrow corridors with dead ends and a few loops",
        20.0,
        20.0,
        0.1,
        "conav.maps.builtin.maze:maze",
    ),
    BuiltinMap(
        "field",
        "A large open yard inside a wall, with scattered posts and boxes",
        100.0,
        100.0,
        0.5,
        "conav.maps.builtin.field:field",
    ),
    BuiltinMap(
        "three-obstacles",
        "An open square of grid points with three rectangles and no wall around it",
        40.0,
        40.0,
        1.0,
        "conav.maps.builtin.three_obstacles:three_obstacles",
    ),
)

BUILTIN: dict[str, BuiltinMap] = {entry.name: entry for entry in _ENTRIES}


def builtin_map(
    name: str,
    *,
    width_m: float | None = None,
    height_m: float | None = None,
    resolution: float | None = None,
    seed: int = 0,
) -> OccupancyGrid:
    """The built-in map of that name, in that size, as that seed draws it.

    `width_m`, `height_m` and `resolution` are in metres; what is not given is taken from the
    catalogue. The size is rounded to whole cells. Equal arguments give maps equal bit by bit.

    Raises `InputError` for a name the catalogue does not have, a size or resolution that is not a
    positive number, a map smaller than `MIN_SIDE_M` or `MIN_SIDE_CELLS` on a side or larger than
    `MAX_CELLS`, or a negative seed.
    """
    entry = _entry(name)
    width_m = entry.width_m if width_m is None else width_m
    height_m = entry.height_m if height_m is None else height_m
    resolution = entry.resolution if resolution is None else resolution
    _check_size(entry, width_m, height_m, resolution)
    seed = operator.index(seed)
    if seed < 0:
        raise InputError(name, f"the seed must not be negative, not {seed}", "try 0")
    module, _, function = entry.function.partition(":")
    draw = cast("MapFunction", getattr(import_module(module), function))
    return draw(width_m, height_m, resolution, np.random.Generator(np.random.PCG64(seed)))


def _entry(name: str) -> BuiltinMap:
    if name in BUILTIN:
        return BUILTIN[name]
    near = difflib.get_close_matches(name.lower(), BUILTIN, n=2)
    hint = f"did you mean {' or '.join(repr(match) for match in near)}? " if near else ""
    raise InputError(
        repr(name), "there is no built-in map of that name", f"{hint}known: {', '.join(BUILTIN)}"
    )


def _check_size(entry: BuiltinMap, width_m: float, height_m: float, resolution: float) -> None:
    usual = f"the usual {entry.name} is {entry.width_m:g} x {entry.height_m:g} m"
    if not (math.isfinite(resolution) and resolution > 0):
        problem = f"the resolution must be a positive number of metres, not {resolution}"
        raise InputError(entry.name, problem, f"try {entry.resolution:g}")
    for what, metres in (("width", width_m), ("height", height_m)):
        if not (math.isfinite(metres) and metres > 0):
            problem = f"the {what} must be a positive number of metres, not {metres}"
            raise InputError(entry.name, problem, usual)
        if metres < MIN_SIDE_M:
            problem = f"a {what} of {metres:g} m is too small"
            raise InputError(entry.name, problem, f"ask for at least {MIN_SIDE_M:g} m; {usual}")
    # As floats, because a quotient may be infinite; whole numbers from here on are safe.
    cols, rows = width_m / resolution, height_m / resolution
    if cols * rows > MAX_CELLS:
        problem = f"{width_m:g} x {height_m:g} m at {resolution:g} m makes over {MAX_CELLS:,} cells"
        remedy = f"ask for a coarser resolution or a smaller map; {usual} at {entry.resolution:g} m"
        raise InputError(entry.name, problem, remedy)
    if min(round(cols), round(rows)) < MIN_SIDE_CELLS:
        problem = f"{width_m:g} x {height_m:g} m at {resolution:g} m makes too few cells"
        finest = min(width_m, height_m) / MIN_SIDE_CELLS
        remedy = f"ask for a resolution of {finest:.3g} m or finer ({MIN_SIDE_CELLS} cells a side)"
        raise InputError(entry.name, problem, remedy)
