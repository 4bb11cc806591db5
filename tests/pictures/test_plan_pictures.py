"""Pictures and animations of plans: pixels where a hand-built scene has its things."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.pictures.canvas import ColourCanvas
from conav.pictures.marks import line, polygon, ring_around
from conav.pictures.palette import Colours
from conav.pictures.plan_animation import save_plan_animation
from conav.pictures.plan_picture import framed, save_plan_picture
from conav.pictures.plan_scene import PlanScene, tick_s
from conav.planning.trajectory import straight
from conav.planning.types import PlanningProblem, PlanningRobot, Region

WHITE, OUTSIDE, WALL, SHARED = (255, 255, 255), (203, 207, 213), (48, 54, 64), (255, 250, 214)
LINES = ((0, 114, 178), (213, 94, 0))
TINTS = ((204, 227, 240), (247, 223, 204))

# 20 x 10 m, a hole in the middle, a disc; 400 pixels for 20.8 m.
FLOOR = PolygonMap(
    [(0, 0), (20, 0), (20, 10), (0, 10)], [[(9, 4), (9, 6), (11, 6), (11, 4)]], name="yard"
)
OWN = Region("a", disc=(17.0, 2.0, 1.0))
KEPT_OUT = Region("mud", polygon=np.array([(12.0, 7.0), (15.0, 7.0), (15.0, 9.0), (12.0, 9.0)]))
BOTH = Region("dock", polygon=np.array([(1.0, 7.0), (4.0, 7.0), (4.0, 9.0), (1.0, 9.0)]))
ROBOTS = (
    PlanningRobot("r0", (2.0, 2.0), "F a & G !mud", {"a": OWN, "mud": KEPT_OUT}, radius_m=0.5),
    PlanningRobot(
        "r1", (18.0, 8.0), "F dock", {"dock": BOTH}, radius_m=0.5, after_arrival="vanish"
    ),
    PlanningRobot("r2", (7.0, 8.5), "F dock", {"dock": BOTH}, radius_m=0.5),
)
PROBLEM = PlanningProblem(
    FLOOR, ROBOTS, horizon_s=60.0, discs=np.array([[6.0, 4.5, 1.0]]), name="yard"
)
WAYS = (
    straight([(2, 2), (10, 1), (17, 2)], [0, 8, 16]),
    straight([(18, 8), (18, 6.5), (2.5, 6.5), (2.5, 8)], [0, 2, 20, 22]),
    None,
)


def drawn(path: Path) -> NDArray[np.uint8]:
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"))


def at(pixels: NDArray[np.uint8], x: float, y: float, size: int) -> tuple[int, int, int]:
    """The colour at a point [m]."""
    view, _ = framed(PROBLEM, "", size)
    px, py = view.pixel(x, y)
    red, green, blue = pixels[int(py), int(px)].tolist()
    return red, green, blue


def test_a_scene_shows_what_is_there(tmp_path: Path) -> None:
    save_plan_picture(PROBLEM, tmp_path / "a.png", max_pixels=800)
    pixels = drawn(tmp_path / "a.png")
    assert max(pixels.shape) == 800
    assert at(pixels, -0.2, 5, 800) == OUTSIDE
    assert at(pixels, 10, 5, 800) == OUTSIDE  # the hole
    assert at(pixels, 6, 4.5, 800) == OUTSIDE  # the obstacle
    assert at(pixels, 9, 5, 800) == WALL
    assert at(pixels, 6, 5.47, 800) == WALL  # its border, inside
    assert at(pixels, 2.7, 3.3, 800) == WHITE
    # A region of one robot has its tint, one of several is yellow, one to keep out of is white
    # between its lines.
    assert at(pixels, 17.5, 1.7, 800) == TINTS[0]
    assert at(pixels, 1.5, 7.5, 800) == SHARED
    view, _ = framed(PROBLEM, "", 800)
    left, bottom = view.pixel(12.2, 7.2)
    right, top = view.pixel(14.8, 7.9)
    inside = pixels[int(top) : int(bottom), int(left) : int(right)].reshape(-1, 3)
    share = (inside == LINES[0]).all(axis=1).mean()
    assert 0.02 < share < 0.4
    assert (inside == WHITE).all(axis=1).mean() > 0.5
    # A start is a ring.
    assert at(pixels, 2.0, 1.53, 800) == LINES[0]
    assert at(pixels, 2.2, 1.7, 800) == WHITE


def test_a_plan_shows_ways_and_ends(tmp_path: Path) -> None:
    save_plan_picture(PROBLEM, tmp_path / "a.png", WAYS, max_pixels=800)
    pixels = drawn(tmp_path / "a.png")
    assert at(pixels, 6, 1.5, 800) == LINES[0]
    assert at(pixels, 13.2, 6.5, 800) == LINES[1]
    assert at(pixels, 17.3, 2.3, 800) == LINES[0]  # it stays, a disc
    assert at(pixels, 2.5, 7.55, 800) == LINES[1]  # it vanished: a ring around a dot
    assert at(pixels, 2.5, 8.0, 800) == LINES[1]
    assert at(pixels, 2.28, 7.82, 800) == SHARED
    # A dot at each multiple of the time, white inside: 22 s make one every 5 s.
    assert tick_s(WAYS) == 5.0
    assert at(pixels, 2 + 5, 2 - 5 / 8, 800) == WHITE
    assert at(pixels, 2 + 4, 2 - 4 / 8, 800) == LINES[0]


def test_the_time_between_dots() -> None:
    for longest, expected in ((0.5, 0.1), (7.9, 1.0), (8.1, 2.0), (16.5, 5.0), (500, 100.0)):
        assert tick_s([straight([(0, 0), (1, 1)], [0, longest]), None]) == pytest.approx(expected)


def test_soft_edges_have_no_beads() -> None:
    # A long line is drawn in stretches; where they meet it looks as elsewhere.
    mask = line(np.array([(10.0, 10.0), (210.0, 47.0)]), 1.2)
    columns = mask.cover.sum(axis=0)[10:-10]
    assert columns.max() - columns.min() < 0.12 * columns.mean()


def test_masks_cover_as_much_as_their_shapes() -> None:
    square = np.array([(2.25, 3.5), (12.75, 3.5), (12.75, 9.25), (2.25, 9.25)])
    hole = np.array([(5.0, 5.0), (7.0, 5.0), (7.0, 8.0), (5.0, 8.0)])
    # Pillow's polygons hold the pixels of their borders, an eighth of ours on every side.
    filled = polygon([square]).cover.sum() / 255
    assert filled == pytest.approx(10.75 * 6.0, rel=0.01)
    assert filled - polygon([square, hole]).cover.sum() / 255 == pytest.approx(
        2.25 * 3.25, rel=0.01
    )
    ring = ring_around(20.3, 20.6, 10.0, 1.0).cover.sum() / 255
    assert ring == pytest.approx(np.pi * (100 - 64), rel=0.03)


def test_an_animation_moves_and_ends_as_it_should(tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    save_plan_animation(PROBLEM, path, WAYS, max_pixels=500, seconds=2.2, fps=10)
    with Image.open(path) as film:
        assert film.n_frames == 23  # type: ignore[attr-defined]
        frames = []
        for number in range(23):
            film.seek(number)
            frames.append(np.asarray(film.convert("RGB")))
    first, middle, last = frames[0], frames[11], frames[-1]
    assert at(first, 2.3, 2.2, 500) == LINES[0]
    assert at(first, 18.3, 8.2, 500) == LINES[1]
    # At 11 s: on its second stretch, its way behind it and nothing before it.
    assert at(middle, 10 + 3.1, 1 + 3 / 7, 500) == LINES[0]
    assert at(middle, 6, 1.5, 500) == LINES[0]
    assert at(middle, 15.5, 1 + 5.5 / 7, 500) == WHITE
    # In the end one stays, one is gone, and one never moved.
    assert at(last, 17.3, 2.3, 500) == LINES[0]
    assert at(last, 2.8, 8.25, 500) == SHARED
    assert at(last, 7.3, 8.7, 500) not in (WHITE, SHARED)


def test_an_animation_paints_ways_as_a_picture_does() -> None:
    # Piece by piece or at once: the same pixels.
    colours = Colours(3)
    view, _ = framed(PROBLEM, "", 600)
    whole, parts = (PlanScene(view, PROBLEM, colours) for _ in range(2))
    points = np.array([(2.0, 2.0), (10.0, 1.0), (17.0, 2.0)])
    whole.drive(0, points)
    canvas = ColourCanvas(view.page_width, view.height, colours)
    clean = canvas.pixels.copy()
    for k in range(20):
        ends = np.array([(2 + 8 * t, 2 - t) for t in (k / 20, (k + 1) / 20)])
        box = parts.drive(0, ends)
        canvas.pixels[box] = clean[box]
        parts.paint_ways(canvas, box)
    box = parts.drive(0, points[1:])
    canvas.pixels[box] = clean[box]
    parts.paint_ways(canvas, box)
    once = ColourCanvas(view.page_width, view.height, colours)
    whole.paint_ways(once)
    difference = np.abs(canvas.pixels.astype(int) - once.pixels.astype(int))
    # Ends between stretches fall on 64ths of a pixel.
    assert difference.max() <= 40
    assert (difference > 12).mean() < 1e-3


def test_many_robots_fit_and_have_no_labels(tmp_path: Path) -> None:
    goals = [Region("goal", disc=(1.0 + i % 10 * 2, 1.0 + i // 10 * 2, 0.3)) for i in range(30)]
    robots = tuple(
        PlanningRobot(f"r{i}", (0.5 + i % 10 * 2, 0.5 + i // 10 * 2), "F goal", {"goal": goal})
        for i, goal in enumerate(goals)
    )
    problem = replace(PROBLEM, robots=robots, discs=np.empty((0, 3)))
    save_plan_picture(problem, tmp_path / "a.png", max_pixels=400)
    assert drawn(tmp_path / "a.png").shape[1] == 400


def test_narrow_scenes_have_a_page_wide_enough_for_words(tmp_path: Path) -> None:
    tall = PolygonMap([(0, 0), (1, 0), (1, 30), (0, 30)])
    robot = PlanningRobot("r0", (0.5, 1.0), "F a", {"a": Region("a", disc=(0.5, 29.0, 0.4))})
    save_plan_picture(PlanningProblem(tall, (robot,), 60.0), tmp_path / "a.png", max_pixels=600)
    assert drawn(tmp_path / "a.png").shape[:2][0] <= 600
    assert drawn(tmp_path / "a.png").shape[1] >= 320


def test_what_cannot_be_drawn_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="2 trajectories: the scene has 3 robots"):
        save_plan_picture(PROBLEM, tmp_path / "a.png", WAYS[:2])
    with pytest.raises(InputError, match="no robot has a trajectory to show"):
        save_plan_animation(PROBLEM, tmp_path / "a.gif", (None, None, None))
    with pytest.raises(InputError, match=r"end the name in \.png"):
        save_plan_picture(PROBLEM, tmp_path / "a.gif")
    with pytest.raises(InputError, match="fps 99"):
        save_plan_animation(PROBLEM, tmp_path / "a.gif", WAYS, fps=99)
    assert list(tmp_path.iterdir()) == []
