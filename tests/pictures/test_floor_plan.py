"""Pictures of floor plans."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.pictures.floor_plan import FloorCanvas, page_colour, save_floor_plan
from conav.pictures.palette import PAGE, UNKNOWN_GROUND, WALL

ROOM = PolygonMap(
    [(0, 0), (20, 0), (20, 10), (0, 10)], [[(5, 2), (5, 8), (10, 8), (10, 2)]], name="room"
)


def drawn(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.array(image.convert("RGB"))


def test_floor_walls_holes_and_reflex_corners_are_where_they_are(tmp_path: Path):
    save_floor_plan(ROOM, tmp_path / "a.png", max_pixels=832)
    pixels = drawn(tmp_path / "a.png")
    assert pixels.shape[1] == 832  # 20 m and two margins of 0.4 m: 40 pixels a metre

    def at(x: float, y: float) -> tuple[int, ...]:
        return tuple(pixels[round((10.4 - y) * 40), round((x + 0.4) * 40)].tolist())

    assert at(2, 5) == at(15, 1) == page_colour(PAGE)
    assert at(7.5, 5) == at(-0.2, 5) == page_colour(UNKNOWN_GROUND)
    assert at(0, 5) == at(5, 5) == at(12, 10) == page_colour(WALL)
    assert at(5, 2) == at(10, 8) == (213, 94, 0)
    assert at(20, 10) != (213, 94, 0)  # convex


def test_the_canvas_draws_lines_and_discs_over_what_is_there():
    canvas = FloorCanvas((0, 0, 10, 10), max_pixels=400, ground=(0, 0, 0))
    canvas.line([(0, 5), (10, 5)], (255, 0, 0), 4)
    canvas.discs([(5, 5)], (0, 255, 0), 6)
    canvas.footer("words " * 100)
    pixels = np.array(canvas.picture())
    assert max(pixels.shape) == 400
    middle = canvas.height // 2
    assert tuple(pixels[middle, canvas.width // 2]) == (0, 255, 0)
    assert tuple(pixels[middle, canvas.width // 4]) == (255, 0, 0)
    assert tuple(pixels[canvas.height // 4, canvas.width // 4]) == (0, 0, 0)


def test_the_scale_bar_is_as_long_as_it_says(tmp_path: Path):
    save_floor_plan(ROOM, tmp_path / "a.png", max_pixels=832)
    pixels = drawn(tmp_path / "a.png")
    dark = (pixels[-24:] == page_colour(WALL)).all(axis=2)
    longest = int(dark.sum(axis=1).max())
    assert longest == pytest.approx(5 * 40, abs=3)  # 5 m is the longest within a quarter


@pytest.mark.parametrize("long", [(1000, 1), (1, 1000)])
def test_long_plans_fit(long: tuple[int, int], tmp_path: Path):
    width, height = long
    plan = PolygonMap([(0, 0), (width, 0), (width, height), (0, height)])
    save_floor_plan(plan, tmp_path / "a.png", max_pixels=500)
    assert max(drawn(tmp_path / "a.png").shape) <= 500


def test_what_cannot_be_written(tmp_path: Path):
    for name, words in (("a.jpg", "end the name in .png"), ("no/a.png", "there is no folder")):
        with pytest.raises(InputError, match=words):
            save_floor_plan(ROOM, tmp_path / name)
    with pytest.raises(InputError, match="leaves no room"):
        save_floor_plan(ROOM, tmp_path / "a.png", max_pixels=20)
