"""What one paints on: full colour for stills, one fixed palette for animations."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from conav.pictures.marks import Mask
from conav.pictures.palette import FRONTIER, PAGE, SOFT_TEXT, TEXT, UNKNOWN_GROUND, Colours

TRANSPARENT = 255
"""Palette entry of pixels that stay as they were in the frame before."""

_LEVELS = 4  # steps of coverage on a palette: 0, a quarter, a half, three quarters, 1
_LEVEL = ((np.arange(256) * _LEVELS + 127) // 255).astype(np.uint8)  # of each coverage


class Canvas(Protocol):
    """A picture that grows by painting; colours are numbers of `Colours`."""

    width: int
    height: int

    def put(self, colours: NDArray[np.uint8], left: int, top: int) -> None:
        """Set a rectangle to these colour numbers, shape (height, width)."""
        ...

    def paint(self, mask: Mask, colour: int) -> None:
        """Paint one colour through a mask; what lies outside the picture is left out."""
        ...

    def paint_layer(
        self, cover: NDArray[np.uint8], colours: NDArray[np.uint8], left: int, top: int
    ) -> None:
        """Paint with a colour and a coverage of its own at every pixel."""
        ...


class ColourCanvas:
    """A canvas in full colour."""

    def __init__(self, width: int, height: int, colours: Colours) -> None:
        self.width, self.height = width, height
        self._rgb = colours.rgb
        self.pixels = np.empty((height, width, 3), dtype=np.uint8)
        self.pixels[:] = self._rgb[PAGE]

    def put(self, colours: NDArray[np.uint8], left: int, top: int) -> None:
        rows, cols = colours.shape
        self.pixels[top : top + rows, left : left + cols] = self._rgb[colours]

    def paint(self, mask: Mask, colour: int) -> None:
        cover, left, top = clipped(mask, self.width, self.height)
        rows, cols = cover.shape
        patch = self.pixels[top : top + rows, left : left + cols]
        patch[:] = _mixed(patch, self._rgb[colour], cover)

    def paint_layer(
        self, cover: NDArray[np.uint8], colours: NDArray[np.uint8], left: int, top: int
    ) -> None:
        rows, cols = cover.shape
        patch = self.pixels[top : top + rows, left : left + cols]
        at = np.nonzero(cover)
        patch[at] = _mixed(patch[at], self._rgb[colours[at]], cover[at])


class PaletteCanvas:
    """A canvas on a palette of at most 255 colours, made once for all frames of an animation.

    Partly covered pixels take the entry nearest to the mixture, so edges stay smooth.
    """

    def __init__(self, width: int, height: int, colours: Colours) -> None:
        self.width, self.height = width, height
        self.palette = _palette(colours)  # (256, 3)
        self._over = _mixtures(self.palette, len(colours.rgb))
        self.pixels = np.full((height, width), PAGE, dtype=np.uint8)

    def put(self, colours: NDArray[np.uint8], left: int, top: int) -> None:
        rows, cols = colours.shape
        self.pixels[top : top + rows, left : left + cols] = colours

    def paint(self, mask: Mask, colour: int) -> None:
        cover, left, top = clipped(mask, self.width, self.height)
        rows, cols = cover.shape
        patch = self.pixels[top : top + rows, left : left + cols]
        patch[:] = self._over[colour][_LEVEL[cover], patch]

    def paint_layer(
        self, cover: NDArray[np.uint8], colours: NDArray[np.uint8], left: int, top: int
    ) -> None:
        rows, cols = cover.shape
        patch = self.pixels[top : top + rows, left : left + cols]
        at = np.nonzero(cover)
        patch[at] = self._over[colours[at], _LEVEL[cover[at]], patch[at]]


def clipped(mask: Mask, width: int, height: int) -> Mask:
    """The part of a mask that lies on a picture of that size."""
    left, top = max(mask.left, 0), max(mask.top, 0)
    cover = mask.cover[top - mask.top : max(height - mask.top, 0)]
    cover = cover[:, left - mask.left : max(width - mask.left, 0)]
    # An empty rectangle keeps a place inside the picture so that slices agree.
    return Mask(cover, min(left, width), min(top, height))


def _mixed(
    below: NDArray[np.uint8], colour: NDArray[np.uint8], cover: NDArray[np.uint8]
) -> NDArray[np.uint8]:
    share = cover[..., None].astype(np.int32)
    mixed = below.astype(np.int32) * (255 - share) + colour.astype(np.int32) * share
    return ((mixed + 127) // 255).astype(np.uint8)


def _palette(colours: Colours) -> NDArray[np.uint8]:
    """The colours themselves first, then mixtures in the order they are missed, shape (256, 3)."""
    robots = range(colours.distinct)
    lines, tints = [colours.line(i) for i in robots], [colours.tint(i) for i in robots]
    pairs = [(TEXT, PAGE), (SOFT_TEXT, PAGE)]
    groups = [
        pairs,
        list(zip(lines, tints, strict=True)),
        [(PAGE, tint) for tint in tints],
        [(PAGE, line) for line in lines],
        [(line, FRONTIER) for line in lines],
        [(line, tint) for line in lines for tint in tints if line - tint != colours.distinct],
        [(line, UNKNOWN_GROUND) for line in lines],
    ]
    entries = {tuple(int(value) for value in colour): None for colour in colours.rgb}
    table = colours.rgb.astype(np.float64)
    result = [tuple(int(value) for value in colour) for colour in colours.rgb]
    for group in groups:
        for level in (2, 1, 3):
            for above, below in group:
                mixed = table[below] + (table[above] - table[below]) * (level / _LEVELS)
                entry = tuple(int(value) for value in np.rint(mixed))
                if entry not in entries:
                    entries[entry] = None
                    result.append(entry)
    result = result[:TRANSPARENT]
    result += [result[PAGE]] * (256 - len(result))
    return np.array(result, dtype=np.uint8)


def _mixtures(palette: NDArray[np.uint8], colours: int) -> NDArray[np.uint8]:
    """The entry nearest to each colour over each entry, shape (colours, levels + 1, 256)."""
    # Weights of red, green and blue as eyes judge differences.
    table = palette[:TRANSPARENT].astype(np.float32) * np.sqrt(np.array([2, 4, 3], np.float32))
    squares = (table**2).sum(axis=1)
    everything = np.arange(256, dtype=np.uint8)
    result = np.empty((colours, _LEVELS + 1, 256), dtype=np.uint8)
    result[:, 0] = everything
    for colour in range(colours):
        result[colour, _LEVELS] = colour
        for level in range(1, _LEVELS):
            mixed = table + (table[colour] - table) * np.float32(level / _LEVELS)
            nearest = np.argmin(squares - 2.0 * (mixed @ table.T), axis=1)
            result[colour, level, :TRANSPARENT] = nearest
            result[colour, level, TRANSPARENT] = TRANSPARENT
    return result
