"""Shapes as masks: how much of each pixel a line, a disc or a word covers.

Coordinates are in pixels, x to the right and y down, with whole numbers at pixel borders.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import pairwise
from math import ceil, floor
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from PIL import ImageFont

_FINE = 64  # places a pixel is divided into
_STRETCH = 48  # [pixels]
_TIMES = 4  # as large as its mask a polygon is drawn


class Mask(NamedTuple):
    """Coverage 0 to 255 of the pixels from (`left`, `top`) on."""

    cover: NDArray[np.uint8]  # (height, width)
    left: int
    top: int


def stroke(x0: float, y0: float, x1: float, y1: float, half_width: float) -> Mask:
    """A line with round ends; a disc where both ends are the same. Exact to 1/64 of a pixel."""
    left, top = floor(x0), floor(y0)
    # Animations draw few shapes many times: whole pixels off, they are found again.
    near = [round(value * _FINE) for value in (x0 - left, y0 - top, x1 - left, y1 - top)]
    shape = _stroke(near[0], near[1], near[2], near[3], half_width)
    return Mask(shape.cover, shape.left + left, shape.top + top)


def disc(x: float, y: float, radius: float) -> Mask:
    """A disc."""
    return stroke(x, y, x, y, radius)


def ring_around(x: float, y: float, radius: float, half_width: float) -> Mask:
    """A circle drawn as a line along the inside of its border."""
    outer, inner = disc(x, y, radius), disc(x, y, max(radius - 2 * half_width, 0.0))
    cover = outer.cover.copy()
    rows, cols = inner.cover.shape
    top, left = inner.top - outer.top, inner.left - outer.left
    cover[top : top + rows, left : left + cols] -= inner.cover
    return Mask(cover, outer.left, outer.top)


def line(points: NDArray[np.float64], half_width: float) -> Mask:
    """A line through points, shape (n, 2), without beads where its stretches meet."""
    reach = ceil(half_width) + 2
    low, high = np.floor(points.min(axis=0)), np.ceil(points.max(axis=0))
    left, top = int(low[0]) - reach, int(low[1]) - reach
    cover = np.zeros((int(high[1]) + reach - top, int(high[0]) + reach - left), dtype=np.uint8)
    for x0, y0, x1, y1 in stretches([(x, y) for x, y in points.tolist()]):
        part = stroke(x0, y0, x1, y1, half_width)
        rows, cols = part.cover.shape
        row, col = part.top - top, part.left - left
        box = np.s_[row : row + rows, col : col + cols]
        np.maximum(cover[box], part.cover, out=cover[box])
    return Mask(cover, left, top)


def stretches(points: Sequence[tuple[float, float]]) -> Iterator[tuple[float, float, float, float]]:
    """The stretches between points, none so long that its bounding box is mostly empty."""
    for (x0, y0), (x1, y1) in pairwise(points):
        count = max(ceil(max(abs(x1 - x0), abs(y1 - y0)) / _STRETCH), 1)
        dx, dy = (x1 - x0) / count, (y1 - y0) / count
        for k in range(count):
            yield x0 + k * dx, y0 + k * dy, x0 + (k + 1) * dx, y0 + (k + 1) * dy


def polygon(rings: Sequence[NDArray[np.float64]]) -> Mask:
    """What the first ring, shape (n, 2), surrounds, without what the others do."""
    from PIL import Image, ImageDraw

    low, high = rings[0].min(axis=0), rings[0].max(axis=0)
    left, top = floor(float(low[0])), floor(float(low[1]))
    size = (ceil(float(high[0])) - left + 1, ceil(float(high[1])) - top + 1)
    picture = Image.new("L", (size[0] * _TIMES, size[1] * _TIMES))
    draw = ImageDraw.Draw(picture)
    for index, ring in enumerate(rings):
        # Pillow's whole numbers are the middles of pixels.
        corners = (ring - (left, top)) * _TIMES - 0.5
        draw.polygon([(x, y) for x, y in corners.tolist()], fill=0 if index else 255)
    return Mask(np.asarray(picture.resize(size, Image.Resampling.BOX)), left, top)


def line_of_text(text: str, left: int, top: int, size: int) -> Mask:
    """A line of text whose ascenders begin at `top`."""
    return Mask(_letters(text, size), left, top)


def words_width(text: str, size: int) -> int:
    """The width of a line of text [pixels]."""
    return int(np.ceil(_font(size).getlength(text)))


def line_height(size: int) -> int:
    """The height of a line of text [pixels]."""
    return sum(_font(size).getmetrics())


def shortened(text: str, size: int, width: int) -> str:
    """The text, its end replaced by an ellipsis where it is wider than that many pixels."""
    if words_width(text, size) <= width:
        return text
    while text and words_width(text + "...", size) > width:
        text = text[:-1]
    return text.rstrip() + "..."


@lru_cache(maxsize=2048)
def _stroke(x0: int, y0: int, x1: int, y1: int, half_width: float) -> Mask:
    ax, ay, dx, dy = x0 / _FINE, y0 / _FINE, (x1 - x0) / _FINE, (y1 - y0) / _FINE
    reach = half_width + 1.0
    left, top = floor(ax + min(dx, 0.0) - reach), floor(ay + min(dy, 0.0) - reach)
    right, bottom = ceil(ax + max(dx, 0.0) + reach), ceil(ay + max(dy, 0.0) + reach)
    x = np.arange(left, right) + (0.5 - ax)
    y = (np.arange(top, bottom) + (0.5 - ay))[:, None]
    square = dx * dx + dy * dy
    along = np.clip((x * dx + y * dy) / square, 0.0, 1.0) if square > 0.0 else 0.0
    far = np.sqrt((x - along * dx) ** 2 + (y - along * dy) ** 2)
    # A pixel whose centre is half a pixel inside the border is covered whole, to a good measure.
    cover = np.clip((half_width + 0.5 - far) * 255.0 + 0.5, 0.0, 255.0).astype(np.uint8)
    cover.flags.writeable = False
    return Mask(cover, left, top)


@lru_cache(maxsize=512)
def _letters(text: str, size: int) -> NDArray[np.uint8]:
    from PIL import Image, ImageDraw

    font = _font(size)
    ascent, descent = font.getmetrics()
    picture = Image.new("L", (max(int(font.getlength(text)) + 2, 1), ascent + descent))
    ImageDraw.Draw(picture).text((0, ascent), text, fill=255, font=font, anchor="ls")
    return np.asarray(picture)


@lru_cache(maxsize=16)
def _font(size: int) -> "ImageFont.FreeTypeFont":
    from PIL import ImageFont

    font = ImageFont.load_default(size)
    assert isinstance(font, ImageFont.FreeTypeFont)  # given a size it is never the bitmap font
    return font
