"""Pictures of polygonal floors: a canvas in metres, and a floor plan on it."""

import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.maps.polygon_map import PolygonMap
from conav.pictures.marks import line_height, line_of_text, shortened
from conav.pictures.output import checked_path, checked_pixels, whole_file
from conav.pictures.palette import PAGE, SOFT_TEXT, UNKNOWN_GROUND, WALL, Colours

if TYPE_CHECKING:
    from PIL.Image import Image

RGB = tuple[int, int, int]

_FINE = 3  # everything is drawn so many times larger and shrunk, which smooths edges
_TEXT = 14  # [pixels]
_MARGIN = 0.02  # of the longer side
_REFLEX: RGB = (213, 94, 0)
_BAR_M = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)


def page_colour(number: int) -> RGB:
    """The red, green and blue of one of the page's colours of `palette`."""
    red, green, blue = Colours(1).rgb[number].tolist()
    return red, green, blue


class FloorCanvas:
    """A picture of part of the plane [m], y up, with a line of text below; later shapes cover
    earlier ones.

    `bounds` are x0, y0, x1, y1 [m]; the longer side has at most `max_pixels`.
    """

    def __init__(
        self,
        bounds: tuple[float, float, float, float],
        *,
        max_pixels: int = 1200,
        ground: RGB | None = None,
    ) -> None:
        from PIL import Image, ImageDraw

        checked_pixels(max_pixels)
        x0, y0, x1, y1 = bounds
        margin = max(x1 - x0, y1 - y0) * _MARGIN
        self._footer = line_height(_TEXT) + 8
        across, up = x1 - x0 + 2 * margin, y1 - y0 + 2 * margin
        self.pixels_per_m = min(max_pixels / across, (max_pixels - self._footer) / up)
        self.width = max(round(across * self.pixels_per_m), 1)
        self.height = max(round(up * self.pixels_per_m), 1)
        self._left, self._top = x0 - margin, y1 + margin
        ground = page_colour(UNKNOWN_GROUND) if ground is None else ground
        self._image = Image.new("RGB", (self.width * _FINE, self.height * _FINE), ground)
        self._draw = ImageDraw.Draw(self._image)
        self._words = ""

    def fill(self, rings: Sequence[ArrayLike], colour: RGB, *, holes: RGB | None = None) -> None:
        """Fill the first ring, and the others with the colour of `holes` (the ground's)."""
        ground = page_colour(UNKNOWN_GROUND) if holes is None else holes
        for index, ring in enumerate(rings):
            self._draw.polygon(self._at(ring), fill=ground if index else colour)

    def outline(self, rings: Iterable[ArrayLike], colour: RGB, width: float) -> None:
        """Draw rings as closed lines, `width` in pixels."""
        for ring in rings:
            points = np.asarray(ring, dtype=np.float64)
            self.line(np.vstack((points, points[:1])), colour, width)

    def line(self, points: ArrayLike, colour: RGB, width: float) -> None:
        """Draw a line through points, shape (n, 2) [m], with rounded corners."""
        thick = max(round(width * _FINE), 1)
        self._draw.line(self._at(points), fill=colour, width=thick, joint="curve")

    def discs(self, points: ArrayLike, colour: RGB, radius: float) -> None:
        """Draw discs at points, shape (n, 2) [m], `radius` in pixels."""
        reach = radius * _FINE
        for x, y in self._at(points):
            self._draw.ellipse((x - reach, y - reach, x + reach, y + reach), fill=colour)

    def footer(self, words: str) -> None:
        """Set the text below the picture; the scale stands to its right."""
        self._words = words

    def picture(self) -> "Image":
        """The picture so far."""
        from PIL import Image, ImageDraw

        size = (max(self.width, 160), self.height + self._footer)
        page = Image.new("RGB", size, page_colour(PAGE))
        page.paste(self._image.resize((self.width, self.height), Image.Resampling.BOX))
        draw = ImageDraw.Draw(page)
        room = size[0] - 12
        length = max((bar for bar in _BAR_M if bar * self.pixels_per_m <= room / 4), default=0.0)
        if length:
            pixels = length * self.pixels_per_m
            y, right = self.height + self._footer / 2, size[0] - 6
            draw.line(
                [
                    (right - pixels, y - 4),
                    (right - pixels, y + 4),
                    (right - pixels, y),
                    (right, y),
                    (right, y - 4),
                    (right, y + 4),
                ],
                fill=page_colour(WALL),
            )
            label = f"{length:g} m"
            width = line_of_text(label, 0, 0, _TEXT).cover.shape[1]
            self._write(page, label, round(right - pixels) - width - 6)
            room = round(right - pixels) - width - 18
        self._write(page, shortened(self._words, _TEXT, max(room - 6, 1)), 6)
        return page

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the picture to a PNG. Raises `InputError` when that is not possible."""
        target = checked_path(path, ".png", "a picture")
        with whole_file(target) as stream:
            self.picture().save(stream, format="PNG", optimize=True)

    def _write(self, page: "Image", words: str, left: int) -> None:
        from PIL import Image

        mask = line_of_text(words, left, self.height + 4, _TEXT)
        page.paste(page_colour(SOFT_TEXT), (mask.left, mask.top), Image.fromarray(mask.cover))

    def _at(self, points: ArrayLike) -> list[tuple[float, float]]:
        at: NDArray[np.float64] = np.asarray(points, dtype=np.float64).reshape(-1, 2)
        scale = self.pixels_per_m * _FINE
        x, y = (at[:, 0] - self._left) * scale, (self._top - at[:, 1]) * scale
        return list(zip(x.tolist(), y.tolist(), strict=True))


def floor_canvas(plan: PolygonMap, *, max_pixels: int = 1200) -> FloorCanvas:
    """A canvas with the floor white, its walls dark and what is no floor grey."""
    canvas = FloorCanvas(plan.bounds, max_pixels=max_pixels)
    canvas.fill(plan.rings, page_colour(PAGE))
    canvas.outline(plan.rings, page_colour(WALL), _wall_width(plan, canvas))
    return canvas


def save_floor_plan(
    plan: PolygonMap, path: str | os.PathLike[str], *, max_pixels: int = 1200
) -> None:
    """Draw the plan to a PNG: floor white, walls dark, reflex corners as dots, a scale below.

    Raises `InputError` when it cannot be written.
    """
    canvas = floor_canvas(plan, max_pixels=max_pixels)
    reflex = plan.vertices[plan.turns < 0]
    canvas.discs(reflex, _REFLEX, _wall_width(plan, canvas) * 1.25)
    corners = f"{len(plan.vertices)} vertices, {len(reflex)} reflex"
    holes = f", {len(plan.holes)} holes" if plan.holes else ""
    canvas.footer(f"{plan.name}: {corners}{holes}, {plan.area:.4g} m2")
    canvas.save(path)


def _wall_width(plan: PolygonMap, canvas: FloorCanvas) -> float:
    """Thin enough for walls as short as this plan's usually are [pixels]."""
    x0, y0, x1, y1 = plan.segments.T
    usual = float(np.median(np.sqrt((x1 - x0) ** 2 + (y1 - y0) ** 2))) * canvas.pixels_per_m
    return min(max(usual / 8, 1.0), 3.0)
