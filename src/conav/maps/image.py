"""Bare pictures as maps, and what every reader of files needs: their bytes and their grey levels.

Darkness means occupied, as in ROS map_server: a pixel of shade v (0 black, 1 white) is occupied
with p = 1 - v, and two thresholds turn p into occupied, free or unknown.
"""

import math
import threading
import warnings
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

if TYPE_CHECKING:
    from PIL.Image import Image

_PICTURE_TYPES = ("pgm", "png", "bmp", "gif", "jpg", "jpeg", "tif", "tiff", "webp", "pbm", "ppm")
PICTURE_SUFFIXES = tuple(f".{kind}" for kind in _PICTURE_TYPES)
MAX_CELLS = 20_000 * 20_000
OCCUPIED_THRESHOLD = 0.65  # what map savers write
FREE_THRESHOLD = 0.196  # just below the p of grey 205, which map savers write for unknown
FEW_LEVELS = 8  # a picture with at most so many greys was drawn by a program, not scanned

# Pillow also knows formats that run other programs (EPS); a map has no business there.
_FORMATS = ("PPM", "PNG", "BMP", "GIF", "JPEG", "TIFF", "WEBP")
_SPREAD = 16  # channels this close are a grey with JPEG noise, not a colour
_pillow_lock = threading.Lock()


@dataclass(frozen=True)
class Picture:
    """The grey levels of a picture, row 0 at the top as in the file."""

    levels: NDArray[np.uint8 | np.uint16]  # (rows, cols), 0 black to `white`
    white: int  # 255, 65535 for 16-bit greys, 765 where red, green and blue were added
    alpha: NDArray[np.uint8] | None  # (rows, cols), 255 opaque; None without transparency
    warnings: tuple[str, ...] = ()


def read_image(
    path: str | Path,
    *,
    resolution: float | None,
    occupied_threshold: float = OCCUPIED_THRESHOLD,
    free_threshold: float = FREE_THRESHOLD,
) -> OccupancyGrid:
    """The map that a picture without a yaml shows, `resolution` in metres per pixel.

    A pixel is occupied where its p (see above) is over `occupied_threshold`, free where it is under
    `free_threshold`, else unknown. Transparent pixels are laid on white, colours averaged. Where
    that leaves nothing free, or unknown cells and nothing occupied, in a picture of at most
    `FEW_LEVELS` greys, the darkest grey is occupied and the others are free, with a warning. The
    origin is (0, 0, 0).

    Raises `InputError` for a missing resolution, a file that is no picture, thresholds out of order
    and a picture without a free cell.
    """
    path = Path(path)
    if resolution is None:
        raise InputError(
            path,
            "a picture does not say how large a pixel is",
            "give --resolution METRES_PER_PIXEL, or a map_server yaml that names the picture",
        )
    resolution = checked_resolution(path, resolution)
    if not 0 <= free_threshold < occupied_threshold <= 1:
        raise InputError(
            path,
            f"free_threshold {free_threshold} and occupied_threshold {occupied_threshold} are out"
            " of order",
            "give 0 <= free_threshold < occupied_threshold <= 1",
        )
    picture = lay_on_white(load_picture(path))
    table = threshold_table(picture.white, occupied_threshold, free_threshold)
    table, note = _fitted(path, picture, table, free_threshold)
    notes = (*picture.warnings, note) if note else picture.warnings
    cells = np.flipud(table[picture.levels])
    return OccupancyGrid(cells, resolution, name=path.stem, warnings=notes)


def _fitted(
    path: Path, picture: Picture, table: NDArray[np.uint8], free_threshold: float
) -> tuple[NDArray[np.uint8], str]:
    """The table, or one for the few greys of the picture where the thresholds do not fit them."""
    present = np.zeros(picture.white + 1, dtype=np.bool_)
    present[picture.levels] = True
    used = np.flatnonzero(present)
    values = set(table[used].tolist())
    if FREE in values and (OCCUPIED in values or UNKNOWN not in values):
        return table, ""
    in_255 = [f"{255 * int(level) / picture.white:g}" for level in used]
    # Grey 205 tells the picture of a map saver, whose greys mean what the thresholds say.
    if 2 <= used.size <= FEW_LEVELS and "205" not in in_255:
        lacking = "dark enough to be occupied" if FREE in values else "bright enough to be free"
        table = np.full(picture.white + 1, FREE, dtype=np.uint8)
        table[used[0]] = OCCUPIED
        return table, (
            f"{path.name}: no pixel is {lacking}, so the darkest of its {used.size} grey levels,"
            f" {in_255[0]}, is read as occupied and the others ({', '.join(in_255[1:])}) as free."
            f" If that is wrong, write {path.stem}.yaml beside it with an occupied_thresh and a"
            " free_thresh that fit."
        )
    if FREE in values:
        return table, (
            f"{path.name}: no pixel is dark enough to be occupied; what is not free is unknown. If"
            f" that is wrong, write {path.stem}.yaml beside it with an occupied_thresh that fits."
        )
    raise InputError(
        path,
        f"no pixel is bright enough to be free (the brightest is {in_255[-1]} of 255, free begins"
        f" above {255 * (1 - free_threshold):.1f})",
        f"brighten the floor of the picture, or write {path.stem}.yaml beside it with an"
        " occupied_thresh and a free_thresh that fit",
    )


def threshold_table(
    white: int, occupied: float, free: float, *, negate: bool = False
) -> NDArray[np.uint8]:
    """The cell value of each grey level 0 to `white`: occupied where p > `occupied`, free where
    p < `free`, else unknown; p is the darkness, with `negate` the brightness."""
    levels = np.arange(white + 1)
    p = (levels if negate else white - levels) / white
    table = np.full(white + 1, UNKNOWN, dtype=np.uint8)
    table[p < free] = FREE
    table[p > occupied] = OCCUPIED
    return table


def lay_on_white(picture: Picture) -> Picture:
    """The picture with its transparency laid on white paper, with a warning if there was any."""
    if picture.alpha is None:
        return picture
    share = float(np.mean(picture.alpha < 255))
    if share == 0:
        return replace(picture, alpha=None)
    darkness = (picture.white - picture.levels.astype(np.uint32)) * picture.alpha
    levels = (picture.white - (darkness + 127) // 255).astype(picture.levels.dtype)
    note = (
        f"{percent(share)} of the picture is transparent and was laid on white. If that is wrong,"
        " save it without an alpha channel."
    )
    return Picture(levels, picture.white, None, (*picture.warnings, note))


def load_picture(path: Path) -> Picture:
    """The grey levels of a picture file; colours become the mean of red, green and blue.

    Raises `InputError` for a file that is no picture, is cut short, has more than `MAX_CELLS`
    pixels, or holds numbers that are no shades (32-bit, floating point).
    """
    data = file_bytes(path)
    if data.startswith(b"version https://git-lfs"):
        raise InputError(path, "is a Git LFS pointer, not a picture", "run git lfs pull")
    from PIL import Image

    try:
        with _patient_pillow(), Image.open(BytesIO(data), formats=_FORMATS) as image:
            if image.width * image.height > MAX_CELLS:
                raise Image.DecompressionBombError
            return _picture(path, image)
    except InputError:
        raise
    except (Image.DecompressionBombError, MemoryError) as error:
        large = isinstance(error, Image.DecompressionBombError)
        problem = f"has more than {MAX_CELLS:,} pixels" if large else "does not fit into memory"
        raise InputError(path, problem, "crop it or save it at a lower resolution") from error
    except (Image.UnidentifiedImageError, KeyError) as error:  # KeyError: Pillow without WebP
        raise InputError(
            path, "is not a picture of a known format", "save it as PGM or PNG"
        ) from error
    except Exception as error:  # each Pillow format fails in its own way on damaged files
        detail = str(error) or type(error).__name__
        raise InputError(
            path, f"is damaged or cut short ({detail})", "copy it again, or save it as PGM or PNG"
        ) from error


@contextmanager
def _patient_pillow() -> Generator[None]:
    """Lets Pillow open pictures up to `MAX_CELLS`: its own limit is a module global, so it is put
    back, and only one thread of ours changes it at a time."""
    from PIL import Image

    with _pillow_lock, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Pillow's remarks are for programmers
        before = Image.MAX_IMAGE_PIXELS
        Image.MAX_IMAGE_PIXELS = MAX_CELLS
        try:
            yield
        finally:
            Image.MAX_IMAGE_PIXELS = before


def _picture(path: Path, image: "Image") -> Picture:
    image.load()
    notes: list[str] = []
    frames = int(getattr(image, "n_frames", 1))
    if frames > 1:
        notes.append(f"{path.name} holds {frames} pictures; the first is read.")
        image.seek(0)
    if image.mode in ("1", "L") and not image.has_transparency_data:
        return Picture(np.array(image.convert("L")), 255, None, tuple(notes))
    if image.mode.startswith(("I", "F")):
        return Picture(_sixteen_bit(path, image), 65535, None, tuple(notes))
    channels = np.array(image.convert("RGBA" if image.has_transparency_data else "RGB"))
    alpha = channels[..., 3].copy() if channels.shape[2] == 4 else None
    red, green, blue = (channels[..., channel] for channel in range(3))
    spread = np.maximum(np.maximum(red, green), blue) - np.minimum(np.minimum(red, green), blue)
    if not spread.any():
        return Picture(red.copy(), 255, alpha, tuple(notes))
    coloured = float(np.mean(spread > _SPREAD))
    if coloured > 0:
        notes.append(
            f"{percent(coloured)} of the pixels of {path.name} are coloured and read as the mean of"
            " red, green and blue. Save the picture in black, white and grey if they read wrong."
        )
    total = red.astype(np.uint16) + green + blue
    return Picture(total, 765, alpha, tuple(notes))


def _sixteen_bit(path: Path, image: "Image") -> NDArray[np.uint16]:
    values: NDArray[np.generic] = np.array(image)
    # Pillow gives 16-bit PGM as 32-bit integers, already stretched to 0..65535.
    stretched_pgm = image.mode == "I" and image.format == "PPM"
    if not (image.mode.startswith("I;16") or stretched_pgm) or image.has_transparency_data:
        raise InputError(
            path, f"has pixels of the kind {image.mode}, which are no shades", "save it as 8-bit"
        )
    return values.astype(np.uint16)


def file_bytes(path: Path, *, limit: int = 2 * MAX_CELLS) -> bytes:
    """The bytes of a regular file of at most `limit` bytes, or `InputError`."""
    try:
        if not path.is_file():  # also keeps us from waiting for a pipe or a device
            problem = "is not a regular file" if path.exists() else "does not exist"
            raise InputError(path, problem, "give the path of a map file")
        if path.stat().st_size > limit:
            raise InputError(path, f"is larger than {limit:,} bytes", "check that it is the map")
        return path.read_bytes()
    except InputError:
        raise
    except (OSError, ValueError, MemoryError) as error:
        reason = getattr(error, "strerror", None) or str(error) or "too little memory"
        raise InputError(
            path, f"cannot be read ({reason})", "check the path and who may read it"
        ) from error


def percent(share: float) -> str:
    """A share of one as people write it; what is small but not nothing does not become 0."""
    return f"{share:.1%}" if share >= 0.0005 else "under 0.1%"


def checked_resolution(place: object, resolution: float) -> float:
    """The resolution as a float, or `InputError` where it is not a positive finite number."""
    try:
        value = float(resolution)
    except (TypeError, ValueError, OverflowError):
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise InputError(
            place, f"resolution is {resolution!r}", "give metres per cell above 0, such as 0.05"
        )
    return value
