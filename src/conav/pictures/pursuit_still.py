"""A pursuit as one picture: the floor, the pursuers' ways, and an evader who gets away."""

import os
from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.pictures.output import checked_path, checked_pixels, whole_file
from conav.pictures.palette import PAGE, TEXT, UNKNOWN_GROUND, WALL, Colours
from conav.pursuit.verify_escape_check import EvaderPath
from conav.runs.types import PursuitRun

_MARGIN = 12  # pixels round the floor
_FINE = 3  # drawn so many times larger, then made smaller: smooth lines


def save_pursuit_still(
    run: PursuitRun,
    path: str | os.PathLike[str],
    escape: EvaderPath | None = None,
    *,
    max_pixels: int = 1200,
) -> None:
    """Draw a pursuit to a PNG at most `max_pixels` on a side.

    Each pursuer's way is in its colour, with a dot where it enters; the evader's way is dark and
    dashed, with a cross where it begins. Raises `InputError` for a run whose floor cannot be read
    and for a path that cannot be written.
    """
    from PIL import Image, ImageDraw

    target = checked_path(path, ".png", "a still picture")
    size = checked_pixels(max_pixels) - 2 * _MARGIN
    try:
        floor = run.header["floor"]
        plan = PolygonMap(floor["outer"], floor["holes"], str(floor["name"]))
    except (KeyError, TypeError) as error:
        raise InputError(run.path, f"holds no floor ({error!r})", "the file is damaged") from None
    x0, y0, x1, y1 = plan.bounds
    scale = size * _FINE / max(x1 - x0, y1 - y0)
    width, height = (round(extent * scale) + 2 * _MARGIN * _FINE for extent in (x1 - x0, y1 - y0))

    def pixels(points: NDArray[np.float64]) -> list[tuple[float, float]]:
        x = (points[:, 0] - x0) * scale + _MARGIN * _FINE
        y = (y1 - points[:, 1]) * scale + _MARGIN * _FINE
        return list(zip(x.tolist(), y.tolist(), strict=True))

    colours = Colours(len(run.header["pursuers"]))
    rgb = [tuple(colour) for colour in colours.rgb.tolist()]
    image = Image.new("RGB", (width, height), rgb[UNKNOWN_GROUND])
    draw = ImageDraw.Draw(image)
    draw.polygon(pixels(plan.outer), fill=rgb[PAGE])
    for hole in plan.holes:
        draw.polygon(pixels(hole), fill=rgb[UNKNOWN_GROUND])
    for ring in plan.rings:
        draw.line(pixels(np.vstack((ring, ring[:1]))), fill=rgb[WALL], width=2 * _FINE)
    thick = 2 * _FINE
    for i in range(len(run.header["pursuers"])):
        colour = rgb[colours.line(i)]
        legs = [leg for leg in run.legs if len(leg.active) > i and leg.active[i]]
        for leg in legs:
            draw.line(pixels(np.vstack((leg.before[i], leg.after[i]))), fill=colour, width=thick)
        if legs:
            (x, y), r = pixels(legs[0].before[i : i + 1])[0], 3 * thick
            draw.ellipse((x - r, y - r, x + r, y + r), fill=colour)
    if escape is not None:
        way = pixels(escape.places)
        for one, two in _dashes(way, 6 * thick):
            draw.line((one, two), fill=rgb[TEXT], width=thick)
        (x, y), r = way[0], 3 * thick
        draw.line((x - r, y - r, x + r, y + r), fill=rgb[TEXT], width=thick)
        draw.line((x - r, y + r, x + r, y - r), fill=rgb[TEXT], width=thick)
    small = image.resize((width // _FINE, height // _FINE), Image.Resampling.LANCZOS)
    with whole_file(target) as stream:
        small.save(stream, format="PNG")


def _dashes(
    way: list[tuple[float, float]], length: float
) -> Iterable[tuple[tuple[float, float], tuple[float, float]]]:
    """Every other piece of that length along a way."""
    done = 0.0
    for (ax, ay), (bx, by) in pairwise(way):
        whole = float(np.hypot(bx - ax, by - ay))
        at = 0.0
        while at < whole:
            step = min(length - done % length, whole - at)
            if int(done // length) % 2 == 0:
                one, two = at / whole, (at + step) / whole
                yield (
                    (ax + one * (bx - ax), ay + one * (by - ay)),
                    (ax + two * (bx - ax), ay + two * (by - ay)),
                )
            at += step
            done += step
