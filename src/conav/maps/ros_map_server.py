"""Maps of ROS map_server: a yaml that says how to read the picture beside it; reader and writer.

The keys mean what they mean to nav2_map_server (`map_io.cpp`) and to map_server of ROS 1: a pixel
of shade v has the occupancy p = (255 - v) / 255, with `negate` p = v / 255.

YAML 1.1 reads `1e-3` as text, `012` as ten and `12:30` as 750, so every scalar is taken as text and
numbers are read here.
"""

import difflib
import math
import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.maps.image import (
    FREE_THRESHOLD,
    OCCUPIED_THRESHOLD,
    PICTURE_SUFFIXES,
    Picture,
    file_bytes,
    lay_on_white,
    load_picture,
    percent,
    threshold_table,
)
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from conav.maps.write_whole import write_whole

SAVED_SHADES = {FREE: 254, OCCUPIED: 0, UNKNOWN: 205}  # what map savers write
MODES = ("trinary", "scale", "raw")
_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode")
_TRUE, _FALSE = ("1", "true", "yes", "on", "y"), ("0", "false", "no", "off", "n")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_YAML_LIMIT = 100_000  # bytes; such a yaml has about 150
_MEANINGFUL = 0.005  # a share of the pixels that is worth a warning
_Entries = dict[str, str | list[str] | None]  # None stands for anything deeper than a list


@dataclass(frozen=True)
class RosMapYaml:
    """What a map_server yaml says."""

    path: Path
    image: Path  # exists
    resolution: float  # [m] side of a pixel
    origin: tuple[float, float, float]  # x [m], y [m], yaw [rad] of the lower left corner
    negate: bool
    occupied_thresh: float  # 0..1
    free_thresh: float  # 0..1, below occupied_thresh
    mode: str  # one of MODES
    warnings: tuple[str, ...]


def read_ros_map(path: str | Path, *, outside_folder: bool = False) -> OccupancyGrid:
    """The map that a map_server yaml and its picture describe.

    Each mode ends in three values:

    - `trinary`: occupied where p > occupied_thresh, free where p < free_thresh, else unknown.
    - `scale`: the same, and what is not opaque is unknown. map_server grades what lies between.
    - `raw`: a pixel 0 to 100 is the occupancy in percent and over 100 unknown; the thresholds are
      applied to percent / 100, `negate` is not, as in nav2.

    Transparency is laid on white except in mode scale; map_server, in mode trinary, averages it in
    as if it were a fourth colour. The picture must lie in the folder of the yaml or below it,
    unless `outside_folder`. What is odd but readable is said in `warnings` of the grid.

    Raises `InputError` for all that cannot be read, with the file, the key and a remedy.
    """
    settings = read_ros_yaml(path, outside_folder=outside_folder)
    picture = load_picture(settings.image)
    notes = list(settings.warnings)
    if picture.alpha is not None and settings.mode != "scale":
        if settings.mode == "trinary":
            notes += _alpha_notes(settings, picture)
        picture = lay_on_white(picture)
    table = _table(settings, picture.white)
    cells = table[picture.levels]
    if picture.alpha is not None:
        cells[picture.alpha < 255] = UNKNOWN
    notes += [*picture.warnings, *_notes(settings, picture, table, cells)]
    return OccupancyGrid(
        np.flipud(cells), settings.resolution, settings.origin, settings.path.stem, tuple(notes)
    )


def read_ros_yaml(path: str | Path, *, outside_folder: bool = False) -> RosMapYaml:
    """What a map_server yaml says, or `InputError`; its picture exists but is not yet opened."""
    path = Path(path)
    entries = _entries(path)
    notes: list[str] = []
    for key in entries:
        if key not in _KEYS:
            near = difflib.get_close_matches(key, _KEYS, 1)
            hint = f"Did you mean {near[0]}?" if near else "Remove it if it is a mistake."
            notes.append(f"{path.name}: the key {_shown(key)} means nothing here. {hint}")

    def default(key: str, value: object) -> None:
        if key not in entries:
            notes.append(f"{path.name} has no {key}; {value} is used. Write {key}: {value} there.")

    image = _text(path, entries, "image", "name the picture, such as image: map.pgm")
    resolution = _number(path, "resolution", _text(path, entries, "resolution", "write 0.05"))
    if resolution <= 0:
        raise InputError(path, f"resolution is {resolution}", "give metres per pixel above 0")
    origin, more = _origin(path, entries)
    notes += more
    default("negate", 0)
    negate = _text(path, entries, "negate", "write 0 or 1", "0").lower()
    if negate not in _TRUE + _FALSE:
        raise InputError(path, f"negate is {_shown(negate)}", "write 0 or 1")
    default("occupied_thresh", OCCUPIED_THRESHOLD)
    occupied = _threshold(path, entries, "occupied_thresh", OCCUPIED_THRESHOLD)
    default("free_thresh", FREE_THRESHOLD)
    free = _threshold(path, entries, "free_thresh", FREE_THRESHOLD)
    if free >= occupied:
        raise InputError(
            path,
            f"free_thresh {free} is not below occupied_thresh {occupied}",
            f"write for example {FREE_THRESHOLD} and {OCCUPIED_THRESHOLD}",
        )
    mode = _text(path, entries, "mode", "write trinary, scale or raw", "trinary").lower()
    if mode not in MODES:
        raise InputError(path, f"mode is {_shown(mode)}", "write trinary, scale or raw")
    negated = negate in _TRUE
    if mode == "raw" and negated:
        notes.append(f"{path.name}: negate has no effect in mode raw. Set negate: 0.")
    picture = _picture_path(path, image, outside_folder)
    return RosMapYaml(
        path, picture, resolution, origin, negated, occupied, free, mode, tuple(notes)
    )


def write_ros_map(grid: OccupancyGrid, path: str | Path) -> tuple[Path, Path]:
    """The paths of the yaml and the pgm written for the grid.

    `path` may end in .yaml, .yml, .pgm or in no suffix of ours; the pair shares its stem. Read
    back, it gives the same cells, resolution and origin. Both files are written beside their
    targets and renamed once both are complete, so a full disk leaves older files as they were.

    Raises `InputError` where the folder cannot be written, or the suffix is of another format.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if not path.name or (suffix in PICTURE_SUFFIXES and suffix != ".pgm"):
        raise InputError(path, "maps are written as yaml and pgm", "give a name ending in .yaml")
    name = path.stem if suffix in (".yaml", ".yml", ".pgm") else path.name
    yaml_path = path.with_name(f"{name}{path.suffix if suffix in ('.yaml', '.yml') else '.yaml'}")
    pgm_path = path.with_name(f"{name}{path.suffix if suffix == '.pgm' else '.pgm'}")
    for target in (path, yaml_path, pgm_path):
        if os.path.isdir(target):
            raise InputError(target, "is a folder", "give the name of a map, such as map.yaml")
    shades = np.empty(3, dtype=np.uint8)
    shades[list(SAVED_SHADES)] = list(SAVED_SHADES.values())
    pixels = shades[np.flipud(grid.cells)].tobytes()
    header = f"P5\n{grid.cols} {grid.rows}\n255\n".encode("ascii")
    write_whole({pgm_path: header + pixels, yaml_path: _yaml_text(grid, pgm_path.name)})
    return yaml_path, pgm_path


def _table(settings: RosMapYaml, white: int) -> NDArray[np.uint8]:
    """The cell value of each grey level 0 to `white`."""
    occupied, free = settings.occupied_thresh, settings.free_thresh
    if settings.mode != "raw":
        return threshold_table(white, occupied, free, negate=settings.negate)
    percent = np.floor(255 * np.arange(white + 1) / white + 0.5)
    table = np.full(white + 1, UNKNOWN, dtype=np.uint8)
    table[percent / 100 < free] = FREE
    table[(percent / 100 > occupied) & (percent <= 100)] = OCCUPIED
    return table


def _alpha_notes(settings: RosMapYaml, picture: Picture) -> list[str]:
    """Says how many cells map_server itself, averaging alpha in, would read otherwise."""
    assert picture.alpha is not None
    shade = (3 * (picture.levels / picture.white) + picture.alpha / 255) / 4
    p = shade if settings.negate else 1 - shade
    theirs = np.full(p.shape, UNKNOWN, dtype=np.uint8)
    theirs[p < settings.free_thresh] = FREE
    theirs[p > settings.occupied_thresh] = OCCUPIED
    laid = lay_on_white(picture)
    differ = theirs != _table(settings, laid.white)[laid.levels]
    share = np.count_nonzero(differ) / differ.size
    if share == 0:
        return []
    return [
        f"{settings.image.name} has an alpha channel, which ROS map_server averages in as if it"
        f" were a colour, so it would read {percent(share)} of the cells otherwise. Save the"
        " picture without an alpha channel to have it read alike everywhere."
    ]


def _notes(
    settings: RosMapYaml, picture: Picture, table: NDArray[np.uint8], cells: NDArray[np.uint8]
) -> list[str]:
    """What is odd about the cells that were read."""
    notes: list[str] = []
    name = settings.path.name
    level, rest = divmod(SAVED_SHADES[UNKNOWN] * picture.white, 255)
    if rest == 0 and table[level] == FREE:
        share = np.count_nonzero(picture.levels == level) / picture.levels.size
        if share >= _MEANINGFUL:
            notes.append(
                f"{percent(share)} of the pixels of {settings.image.name} are the grey 205 that map"
                f" savers write for unknown, and {name} reads them as free (free_thresh:"
                f" {settings.free_thresh:g}). If they are unknown, set free_thresh:"
                f" {FREE_THRESHOLD} in {name}."
            )
    if settings.mode == "scale":
        between = (table == UNKNOWN)[picture.levels]
        if picture.alpha is not None:
            between &= picture.alpha == 255
        if between.any():
            notes.append(
                f"{percent(float(between.mean()))} of the cells lie between the thresholds of"
                f" {name}; mode scale grades them, here they are unknown. Move free_thresh or"
                " occupied_thresh if they should be free or occupied."
            )
    if not (cells == FREE).any():
        notes.append(
            f"No cell is free as {name} reads {settings.image.name}. Check its negate, mode and"
            " free_thresh."
        )
    return notes


def _entries(path: Path) -> _Entries:
    """The keys of a yaml, each with its text or its list of texts."""
    data = file_bytes(path, limit=_YAML_LIMIT)
    import yaml

    fix = "write one 'key: value' per line, as map savers do"
    try:
        root = yaml.compose(data, Loader=yaml.BaseLoader)
    except yaml.MarkedYAMLError as error:
        line = f"line {error.problem_mark.line + 1}: " if error.problem_mark else ""
        detail = error.problem or error.context
        raise InputError(path, f"{line}is not YAML ({detail})", fix) from error
    except Exception as error:  # PyYAML lets ValueError, RecursionError and others out
        detail = " ".join(str(error).split())[:100]
        raise InputError(path, f"is not YAML text ({detail})", "save it as UTF-8 text") from error
    if root is None:
        raise InputError(path, "is empty", "write image, resolution and origin into it")
    if not isinstance(root, yaml.MappingNode):
        raise InputError(path, "is not a list of keys and values", fix)
    entries: _Entries = {}
    for key, value in root.value:
        line = key.start_mark.line + 1
        if not isinstance(key, yaml.ScalarNode):
            raise InputError(path, f"line {line}: the key is not a word", fix)
        name = str(key.value)
        if name in entries:
            raise InputError(path, f"line {line}: {_shown(name)} a second time", "remove one")
        entries[name] = None
        if isinstance(value, yaml.ScalarNode):
            entries[name] = str(value.value)
        elif isinstance(value, yaml.SequenceNode) and all(
            isinstance(item, yaml.ScalarNode) for item in value.value
        ):
            entries[name] = [str(item.value) for item in value.value]
    return entries


def _text(path: Path, entries: _Entries, key: str, remedy: str, missing: str = "") -> str:
    value = entries.get(key, missing)
    if not isinstance(value, str):
        raise InputError(path, f"{key} is not a single value", remedy)
    if not value:
        problem = "has no value" if key in entries else "is missing"
        raise InputError(path, f"{key} {problem}", remedy)
    return value


def _number(path: Path, key: str, text: str) -> float:
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    if not math.isfinite(value):
        remedy = "write it with a point, not a comma" if "," in text else "write it like 0.05"
        raise InputError(path, f"{key} is {_shown(text)}, not a finite number", remedy)
    return value


def _threshold(path: Path, entries: _Entries, key: str, missing: float) -> float:
    value = _number(path, key, _text(path, entries, key, f"write {missing}", str(missing)))
    if not 0 <= value <= 1:
        raise InputError(
            path, f"{key} is {value:g}, not between 0 and 1", f"write for example {missing}"
        )
    return value


def _origin(path: Path, entries: _Entries) -> tuple[tuple[float, float, float], list[str]]:
    remedy = "write origin: [x, y, yaw] in metres and radians, such as [0.0, 0.0, 0.0]"
    if "origin" not in entries:
        raise InputError(path, "origin is missing", remedy)
    texts = entries["origin"]
    if not isinstance(texts, list) or len(texts) not in (2, 3):
        raise InputError(path, "origin is not a list of three numbers", remedy)
    x, y, *rest = (_number(path, "origin", text) for text in texts)
    if not rest:
        return (x, y, 0.0), [f"{path.name}: origin has no yaw; 0 is used. Write [{x}, {y}, 0.0]."]
    yaw = rest[0]
    turned = (
        f"{path.name}: the yaw of origin, {yaw:g}, is over a turn. Check that it is in radians."
    )
    return (x, y, yaw), [turned] if abs(yaw) > 2 * math.pi else []


def _picture_path(path: Path, image: str, outside_folder: bool) -> Path:
    """Where the picture is. It is not looked for outside the folder, unless that is allowed."""
    try:
        picture = path.parent / image
        inside = picture.resolve().is_relative_to(path.parent.resolve())
        found = (inside or outside_folder) and picture.is_file()
    except (OSError, ValueError, RuntimeError) as error:  # too long, a null in it, links in a ring
        raise InputError(
            path, f"image: {_shown(image)} is no file name", "name the picture"
        ) from error
    if found:
        return picture
    beside = _picture_beside(path, image)
    if beside == image:  # a link that leads outside
        beside = None
    fix = f"set image: {beside} in {path.name}" if beside else "put the picture beside the yaml"
    if not (inside or outside_folder):
        raise InputError(
            path,
            f"image: {_shown(image)} lies outside the folder of the yaml",
            f"{fix}, or allow it with --outside-folder",
        )
    problem = "is a folder" if os.path.isdir(picture) else "does not exist"
    raise InputError(path, f"image: {_shown(image)} {problem}", fix)


def _picture_beside(path: Path, image: str) -> str | None:
    """The picture in the folder of the yaml that its `image` most likely means."""
    try:
        names = sorted(entry.name for entry in path.parent.iterdir() if entry.is_file())
    except OSError:
        return None
    names = [name for name in names if Path(name).suffix.lower() in PICTURE_SUFFIXES]
    wanted = re.split(r"[\\/]", image)[-1]
    same_name = [name for name in names if name.lower() == wanted.lower()]
    same_stem = [name for name in names if Path(name).stem in (path.stem, Path(wanted).stem)]
    return next(iter([*same_name, *same_stem, *difflib.get_close_matches(wanted, names, 1)]), None)


def _shown(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:57] + "...")


def _yaml_text(grid: OccupancyGrid, image: str) -> bytes:
    import yaml

    named = yaml.safe_dump({"image": image}, allow_unicode=True, width=math.inf)
    origin = ", ".join(_float_text(value) for value in grid.origin)
    text = (
        f"{named}mode: trinary\nresolution: {_float_text(grid.resolution)}\norigin: [{origin}]\n"
        f"negate: 0\noccupied_thresh: {OCCUPIED_THRESHOLD}\nfree_thresh: {FREE_THRESHOLD}\n"
    )
    return text.encode("utf-8")


def _float_text(value: float) -> str:
    """The shortest text that reads back as the same float; YAML 1.1 wants a point before the e."""
    text = repr(float(value))
    return text if "." in text else text.replace("e", ".0e")
