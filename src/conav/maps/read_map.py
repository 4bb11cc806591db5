"""Any map file, by its suffix."""

import difflib
import os
from collections.abc import Callable
from pathlib import Path

from conav.errors import InputError
from conav.maps.ascii_art import read_ascii
from conav.maps.image import PICTURE_SUFFIXES, checked_resolution, file_bytes, read_image
from conav.maps.movingai import read_movingai
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.ros_map_server import read_ros_map, read_ros_yaml

Reader = Callable[[Path, float | None, bool], OccupancyGrid]


def read_map(
    path: str | Path, *, resolution: float | None = None, outside_folder: bool = False
) -> OccupancyGrid:
    """The map in a file, read as its suffix says (`READERS`).

    `resolution` in metres per cell is for formats that have none: a bare picture needs it, for
    MovingAI and text maps it is 1 unless given; for a yaml it must be what the yaml says. A picture
    without `resolution` is read by the yaml of the same name beside it, with a warning.
    `outside_folder` lets a yaml name a picture outside its own folder.

    Raises `InputError`, with a remedy, for everything that is not a map.
    """
    path = Path(path)
    _check_file(path)
    suffix = path.suffix.lower()
    if suffix == ".scen":
        raise _scenario_error(path)
    if suffix not in READERS:
        beside = [path.with_suffix(known).name for known in READERS if _is_file(path, known)]
        raise InputError(
            path,
            f"{suffix or 'no suffix'} is not the suffix of a map",
            (f"give {beside[0]}, or " if beside else "give ") + f"one of {' '.join(READERS)}",
        )
    if resolution is not None:
        resolution = checked_resolution(path, resolution)
    return READERS[suffix](path, resolution, outside_folder)


def _read_ros(path: Path, resolution: float | None, outside_folder: bool) -> OccupancyGrid:
    grid = read_ros_map(path, outside_folder=outside_folder)
    if resolution is not None and resolution != grid.resolution:
        raise InputError(
            path,
            f"its resolution is {grid.resolution:g}, not the {resolution:g} asked for",
            f"leave out --resolution, or set resolution: {resolution:g} in {path.name}",
        )
    return grid


def _read_picture(path: Path, resolution: float | None, outside_folder: bool) -> OccupancyGrid:
    beside = [path.with_suffix(suffix) for suffix in (".yaml", ".yml") if _is_file(path, suffix)]
    if resolution is not None or not beside:
        return read_image(path, resolution=resolution)
    yaml = beside[0]
    picture = read_ros_yaml(yaml, outside_folder=outside_folder).image
    if not os.path.samefile(picture, path):
        raise InputError(
            path,
            f"{yaml.name} beside it describes another picture, {picture.name}",
            f"give {yaml.name} to read that one, or --resolution METRES_PER_PIXEL for this one",
        )
    grid = read_ros_map(yaml, outside_folder=outside_folder)
    note = (
        f"{path.name} is read as {yaml.name} beside it says. Give --resolution METRES_PER_PIXEL to"
        " read the bare picture."
    )
    return OccupancyGrid(
        grid.cells, grid.resolution, grid.origin, grid.name, (note, *grid.warnings)
    )


def _read_movingai(path: Path, resolution: float | None, outside_folder: bool) -> OccupancyGrid:
    return read_movingai(path, resolution=1.0 if resolution is None else resolution)


def _read_ascii(path: Path, resolution: float | None, outside_folder: bool) -> OccupancyGrid:
    return read_ascii(path, resolution=1.0 if resolution is None else resolution)


READERS: dict[str, Reader] = {
    ".yaml": _read_ros,
    ".yml": _read_ros,
    ".map": _read_movingai,
    ".txt": _read_ascii,
    ".ascii": _read_ascii,
    **dict.fromkeys(PICTURE_SUFFIXES, _read_picture),
}


def _is_file(path: Path, suffix: str) -> bool:
    return os.path.isfile(path.with_suffix(suffix))


def _check_file(path: Path) -> None:
    """Raises `InputError` with the nearest names where `path` is no file."""
    if os.path.isfile(path):
        return
    if os.path.isdir(path):
        maps = [name for name in _names(path) if Path(name).suffix.lower() in READERS]
        some = f"give one of its maps: {', '.join(maps[:5])}" if maps else "it holds no map"
        raise InputError(path, "is a folder", some + (" and more" if len(maps) > 5 else ""))
    if os.path.exists(path):
        raise InputError(path, "is not a regular file", "give the path of a map file")
    if not os.path.isdir(path.parent):
        raise InputError(path, f"there is no folder {path.parent}", "check the path")
    names = _names(path.parent)
    same = [name for name in names if Path(name).stem.lower() in (path.name.lower(), path.stem)]
    maps = [name for name in same if Path(name).suffix.lower() in READERS]
    near = maps or difflib.get_close_matches(path.name, names, 3)
    remedy = f"did you mean {' or '.join(near[:3])}?" if near else "check the path"
    raise InputError(path, "does not exist", remedy)


def _names(folder: Path) -> list[str]:
    try:
        return sorted(entry.name for entry in folder.iterdir() if entry.is_file())
    except OSError:
        return []


def _scenario_error(path: Path) -> InputError:
    """A `.scen` lists starts and goals; the second column of its rows names the map."""
    words = [line.split() for line in file_bytes(path).decode("utf-8", "replace").splitlines()[:5]]
    named = next((row[1] for row in words if len(row) == 9), "")
    name = named.replace("\\", "/").rsplit("/", 1)[-1]
    if not name:
        return InputError(path, "is a list of starts and goals, not a map", "give its .map file")
    beside = os.path.isfile(path.parent / name)
    return InputError(
        path,
        f"is a list of starts and goals on the map {name}, not a map",
        f"give {path.parent / name}" if beside else f"give the path of {name}",
    )
