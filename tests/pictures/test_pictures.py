"""Pictures of runs built by hand: pixels, sizes, files, and paths that cannot be written."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from conav.errors import InputError
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from conav.maps.planning_grid import planning_grid
from conav.pictures.animation import save_animation
from conav.pictures.canvas import TRANSPARENT, ColourCanvas, PaletteCanvas
from conav.pictures.footer import Footer, clock, state_of, title_of
from conav.pictures.gif import GifWriter
from conav.pictures.marks import Mask, disc, shortened, stroke, words_width
from conav.pictures.palette import PAGE, TEXT, Colours, robot_colours
from conav.pictures.replay import Replay, team_of
from conav.pictures.still import save_still
from conav.pictures.view import Tiles, View, Window, fitted, window_around
from conav.runs.types import OCCUPIED_BIT, ExplorationRun, StepRecord

# Colours that a person reads off the picture; a tint is a fifth of the robot's colour in white.
UNSEEN, UNSEEN_WALL = (203, 207, 213), (186, 191, 199)
SEEN_WALL, EDGE = (48, 54, 64), (255, 250, 214)
LINES = ((0, 114, 178), (213, 94, 0))
TINTS = ((204, 227, 240), (247, 223, 204))
WHITE = (255, 255, 255)

# 40 x 20 cells, drawn at 10 pixels a cell when 400 are allowed.
COLS, ROWS, SIDE = 40, 20, 10
WALL_COL = 20


def world() -> NDArray[np.uint8]:
    cells = np.zeros((ROWS, COLS), dtype=np.uint8)
    cells[:, WALL_COL] = OCCUPIED
    return cells


def look(truth: NDArray[np.uint8], rows: range, cols: range) -> list[int]:
    """A scan of a rectangle of fine cells."""
    bit = int(OCCUPIED_BIT)
    width = truth.shape[1]
    return [(r * width + c) | (bit if truth[r, c] else 0) for r in rows for c in cols]


def record(
    step: int,
    cells: list[int],
    scans: list[list[int]],
    *,
    goals: list[int] | None = None,
    headings: list[int] | None = None,
) -> StepRecord:
    n = len(cells)
    ends = np.cumsum([len(scan) for scan in scans])
    return StepRecord(
        step=step,
        cells=np.array(cells, dtype=np.uint32),
        headings=np.array(headings or [0] * n, dtype=np.uint8),
        looked=np.array([bool(scan) for scan in scans], dtype=np.uint8),
        scan_ends=ends.astype(np.uint32),
        scans=np.array([cell for scan in scans for cell in scan], dtype=np.uint32),
        told=np.empty(0, dtype=np.uint32),
        said=np.zeros(0, np.uint32),
        wishes=np.full(n, -1, dtype=np.int8),
        goals=np.array(goals or [-1] * n, dtype=np.int32),
        finished=np.zeros(n, dtype=np.uint8),
        quiet=np.zeros(n, dtype=np.uint8),
        condition=np.zeros(n, dtype=np.uint8),
        messages=0,
        bytes=0,
    )


def make_run(
    truth: NDArray[np.uint8],
    steps: list[StepRecord],
    starts: list[int],
    *,
    cell_m: float = 1.0,
    resolution: float = 1.0,
    turning: bool = False,
    radius_m: float = 0.3,
    **result: Any,
) -> ExplorationRun:
    robot = {"radius_m": radius_m, "motion": {"turn_costs_step": turning}}
    header = {
        "job": "explore",
        "map": "by hand",
        "strategy": "nearest",
        "robots": [robot] * len(starts),
        "starts": starts,
        "cell_m": cell_m,
        "step_s": 2.0,
    }
    ended = {"status": "done", "interrupted": False, "metrics": {"coverage": 1.0}} | result
    return ExplorationRun(
        path=Path("by_hand.mcap"),
        header=header,
        cells=truth,
        resolution=resolution,
        origin=(0.0, 0.0, 0.0),
        steps=steps,
        result=ended,
        timing={},
        digest="",
        intact=True,
    )


def at(row: int, col: int) -> int:
    return row * COLS + col


def two_robots(**result: Any) -> ExplorationRun:
    """Robot 0 sees columns 0 to 20, all rows; robot 1 then columns 15 to 36 in rows 0 to 9."""
    truth = world()
    everything = look(truth, range(ROWS), range(WALL_COL + 1))
    first = record(0, [at(5, 2), at(15, 2)], [everything, []])
    second = record(1, [at(5, 3), at(15, 2)], [[], look(truth, range(10), range(15, 37))])
    third = record(2, [at(5, 10), at(12, 2)], [[], []], goals=[at(5, 16), -1])
    return make_run(truth, [first, second, third], [at(5, 2), at(15, 2)], **result)


def pixel(image: Image.Image, row: float, col: float) -> tuple[int, ...]:
    """The colour at a place given in cells, row 0 at the bottom."""
    got = image.convert("RGB").getpixel((int((col + 0.5) * SIDE), int((ROWS - 0.5 - row) * SIDE)))
    assert isinstance(got, tuple)
    return got


def still(run: ExplorationRun, folder: Path, **settings: Any) -> Image.Image:
    save_still(run, folder / "a.png", **settings)
    with Image.open(folder / "a.png") as image:
        return image.convert("RGB")


def frames(path: Path) -> tuple[list[Image.Image], list[int]]:
    """The frames as shown and how long each is [ms]."""
    images: list[Image.Image] = []
    shown: list[int] = []
    with Image.open(path) as image:
        for index in range(getattr(image, "n_frames", 1)):
            image.seek(index)
            images.append(image.convert("RGB"))
            shown.append(int(image.info["duration"]))
    return images, shown


# Replay


def test_replay_knows_cell_by_cell_who_saw_it_first():
    truth = world()
    both = [at(0, 18), at(0, 19), at(0, WALL_COL) | int(OCCUPIED_BIT)]
    run = make_run(
        truth,
        [
            record(0, [0, 1], [[both[1]], both]),
            record(1, [0, 1], [[], []]),
            record(2, [0, 1], [both, [at(3, 3)]]),
        ],
        [0, 1],
    )
    replay = Replay(run)
    assert replay.apply(run.steps[0]).tolist() == [18, 19, 20]
    assert replay.team_map[0, 17:22].tolist() == [UNKNOWN, FREE, FREE, OCCUPIED, UNKNOWN]
    # Cell 19 was seen by both in one step: the lower number counts.
    assert replay.first_seen_by[0, 17:22].tolist() == [-1, 1, 0, 1, -1]
    assert replay.free_cells == 2
    assert replay.apply(run.steps[1]).tolist() == []
    assert replay.apply(run.steps[2]).tolist() == [at(3, 3)]
    assert replay.first_seen_by[0, 18] == 1
    assert replay.free_cells == 3


def test_scans_off_the_map_are_damage():
    run = make_run(world(), [record(0, [0], [[ROWS * COLS]])], [0])
    with pytest.raises(InputError, match=r"by_hand\.mcap: has scans that are off its map"):
        Replay(run).apply(run.steps[0])


@pytest.mark.parametrize(
    ("fine", "resolution", "cell_m"), [(10, 0.1, 0.3), (11, 0.05, 0.3), (17, 0.1, 0.25), (8, 1, 1)]
)
def test_places_are_those_of_the_planning_grid(fine: int, resolution: float, cell_m: float):
    truth = np.zeros((7, fine), dtype=np.uint8)
    lattice = planning_grid(OccupancyGrid(truth, resolution), cell_m=cell_m).lattice
    last = lattice.rows * lattice.cols - 1
    run = make_run(truth, [record(0, [last], [[]])], [0], cell_m=cell_m, resolution=resolution)
    assert team_of(run).track[0, 0].tolist() == pytest.approx(lattice.position(last))
    bad = make_run(truth, [record(0, [last + 1], [[]])], [0], cell_m=cell_m, resolution=resolution)
    with pytest.raises(InputError, match="fit no exploration"):
        team_of(bad)


@pytest.mark.parametrize("key", ["map", "strategy", "robots", "starts", "cell_m", "step_s"])
def test_a_header_that_lacks_something_is_damage(key: str):
    run = two_robots()
    header = {name: value for name, value in run.header.items() if name != key}
    with pytest.raises(InputError, match="the file is damaged"):
        team_of(replace(run, header=header))


def test_only_explorations_are_drawn(tmp_path: Path):
    run = two_robots()
    run = replace(run, header=run.header | {"job": "plan"})
    with pytest.raises(InputError, match="is a run of 'plan'; give a run of conav explore"):
        save_still(run, tmp_path / "a.png")


# The still picture


def test_ground_of_a_still(tmp_path: Path):
    image = still(two_robots(), tmp_path, max_pixels=400)
    assert image.width == COLS * SIDE
    assert ROWS * SIDE < image.height <= ROWS * SIDE + 60
    assert pixel(image, 8, 5) == TINTS[0]
    assert pixel(image, 8, 18) == TINTS[0]  # seen by robot 1 too, but later
    assert pixel(image, 8, 25) == TINTS[1]
    assert pixel(image, 12, 25) == UNSEEN
    assert pixel(image, 3, WALL_COL) == SEEN_WALL
    # Cells are crisp: both sides of the border between two of them are pure.
    edge = (ROWS - 8) * SIDE - 5
    assert image.getpixel((WALL_COL * SIDE - 1, edge)) == TINTS[0]
    assert image.getpixel((WALL_COL * SIDE, edge)) == SEEN_WALL
    assert image.getpixel(((WALL_COL + 1) * SIDE - 1, edge)) == SEEN_WALL
    assert image.getpixel(((WALL_COL + 1) * SIDE, edge)) == TINTS[1]


def test_walls_nobody_saw_are_faint(tmp_path: Path):
    truth = world()
    steps = [record(0, [at(5, 2)], [look(truth, range(17), range(39))])]
    image = still(make_run(truth, steps, [at(5, 2)]), tmp_path, max_pixels=400)
    assert image.width == 400
    assert pixel(image, 3, WALL_COL) == SEEN_WALL
    assert pixel(image, 18, WALL_COL) == UNSEEN_WALL


def test_paths_starts_and_robots_of_a_still(tmp_path: Path):
    image = still(two_robots(), tmp_path, max_pixels=400)
    assert pixel(image, 5, 7) == LINES[0]  # on the way from column 2 to 10
    # From row 15 to 12, two pixels to the right so as not to hide the other's path.
    assert [image.getpixel((x, 65)) for x in (25, 27)] == [TINTS[0], LINES[1]]
    assert pixel(image, 5, 2) == WHITE  # the middle of the start's ring
    assert pixel(image, 15, 2) == WHITE
    # Discs of 3 pixels, which is what 0.3 cells are.
    y = (ROWS - 5) * SIDE - 5
    assert [image.getpixel((105 + dx, y)) for dx in (-2, 0, 1)] == [LINES[0]] * 3
    assert image.getpixel((105 + 7, y)) == TINTS[0]
    assert pixel(image, 12, 2) == LINES[1]


def test_a_robot_is_drawn_as_large_as_it_is(tmp_path: Path):
    truth = np.zeros((ROWS, COLS), dtype=np.uint8)
    steps = [record(0, [at(10, 20)], [look(truth, range(ROWS), range(COLS))])]
    image = still(make_run(truth, steps, [at(10, 20)], radius_m=2.0), tmp_path, max_pixels=400)
    x, y = 205, (ROWS - 10) * SIDE - 5
    row = [image.getpixel((x + dx, y)) for dx in range(-30, 31)]
    assert row.count(LINES[0]) in (38, 39, 40)
    assert pixel(image, 10, 22.5) == TINTS[0]


@pytest.mark.parametrize(("heading", "dx", "dy"), [(0, 1, 0), (1, 0, -1), (2, -1, 0), (3, 0, 1)])
def test_a_robot_that_has_to_turn_shows_where_it_faces(
    tmp_path: Path, heading: int, dx: int, dy: int
):
    truth = np.zeros((ROWS, COLS), dtype=np.uint8)
    scan = look(truth, range(ROWS), range(COLS))
    steps = [record(0, [at(10, 20)], [scan], headings=[heading])]
    run = make_run(truth, steps, [at(10, 20)], turning=True)
    image = still(run, tmp_path, max_pixels=400)
    x, y = 205, (ROWS - 10) * SIDE - 5
    red = [image.getpixel((x + 5 * sign * dx, y + 5 * sign * dy))[0] for sign in (1, -1)]
    assert red[0] < 100
    assert red[1] > 200


def test_goals_and_the_edge_of_the_known_show_while_there_is_more_to_do(tmp_path: Path):
    done = still(two_robots(), tmp_path, max_pixels=400)
    more = still(two_robots(status="out_of_budget"), tmp_path, max_pixels=400)
    assert pixel(done, 5, 16) == TINTS[0]
    assert pixel(more, 5, 16) == LINES[0]
    assert pixel(done, 9, 25) == TINTS[1]
    assert pixel(more, 9, 25) == EDGE
    assert pixel(more, 8, 25) == TINTS[1]
    assert pixel(more, 8, 36) == EDGE
    # The border of the map is no edge of the known.
    assert pixel(more, 0, 25) == TINTS[1]


@pytest.mark.parametrize("count", [0, 1, 2])
def test_a_run_cut_short_says_so(tmp_path: Path, count: int):
    whole = two_robots()
    run = replace(whole, steps=whole.steps[:count], result=None, intact=False)
    image = still(run, tmp_path, max_pixels=400)
    assert max(image.size) <= 400
    save_animation(run, tmp_path / "a.gif", max_pixels=400)
    images, shown = frames(tmp_path / "a.gif")
    # The first frame shows for half a second, the last for two; a step takes eight frames.
    assert (len(images), sum(shown)) == ((1, 2000) if count < 2 else (9, 500 + 7 * 50 + 2000))
    state = state_of(run, 2.0, 300, 300, end=True)
    assert state == "300 sq m seen \u00b7 2 s \u00b7 cut short"


def test_nothing_known_shows_the_map_and_the_robots(tmp_path: Path):
    image = still(replace(two_robots(), steps=[], result=None), tmp_path, max_pixels=400)
    assert pixel(image, 5, WALL_COL) == UNSEEN_WALL
    assert pixel(image, 5, 2) == LINES[0]
    assert pixel(image, 9, 9) == UNSEEN


# Words


@pytest.mark.parametrize(
    ("result", "seen", "end", "text"),
    [
        ({}, 200, True, "100 % \u00b7 1 min 15 s"),
        ({}, 199, False, "99 % \u00b7 1 min 15 s"),
        ({"metrics": {"coverage": 0.99996}}, 200, True, "99.9 % \u00b7 1 min 15 s"),
        ({"metrics": {"coverage": 0.5}}, 100, False, "25 % \u00b7 1 min 15 s"),
        ({"status": "stuck"}, 200, True, "100 % \u00b7 1 min 15 s \u00b7 stuck"),
        ({"status": "stuck"}, 200, False, "100 % \u00b7 1 min 15 s"),
        ({"status": "out_of_budget"}, 200, True, "100 % \u00b7 1 min 15 s \u00b7 out of budget"),
        (
            {"status": "out_of_budget", "interrupted": True},
            200,
            True,
            "100 % \u00b7 1 min 15 s \u00b7 interrupted",
        ),
    ],
)
def test_the_state_in_words(result: dict[str, Any], seen: int, end: bool, text: str):
    assert state_of(two_robots(**result), 75.0, seen, 200, end=end) == text


def test_times_in_words():
    assert [clock(time) for time in (0, 59.99, 60, 3599, 3600, 7380)] == [
        "0 s",
        "59 s",
        "1 min 00 s",
        "59 min 59 s",
        "1 h 00 min",
        "2 h 03 min",
    ]


def test_titles_hold_what_the_font_has():
    team = team_of(two_robots())
    assert title_of(team) == "by hand \u00b7 nearest \u00b7 2 robots"
    assert title_of(replace(team, map_name="B\u00fcro\n\u5efa")).startswith("Buro?? \u00b7")
    assert len(title_of(replace(team, map_name="x" * 500))) < 100


@pytest.mark.parametrize("width", [160, 320, 500, 800, 1600])
def test_a_footer_stays_inside_the_page(width: int):
    footer = Footer(
        "a title of some length \u00b7 nearest \u00b7 3 robots", "100 % \u00b7 1 min 15 s"
    )
    height = footer.height(width)
    canvas = ColourCanvas(width, height, Colours(1))
    footer.paint(canvas, 0, "12 % \u00b7 3 s", 25.0)
    ink = (canvas.pixels != 255).any(axis=2)
    assert ink.any()
    assert not ink[[0, 1, -2, -1]].any()
    assert not ink[:, [0, 1, -2, -1]].any()


def test_long_words_are_shortened():
    assert shortened("short", 12, 200) == "short"
    text = shortened("far too long for this little room", 12, 80)
    assert text.endswith("...")
    assert words_width(text, 12) <= 80


# Size and part of the map shown


def test_the_window_is_what_is_known_and_a_margin():
    known = np.zeros((800, 1000), dtype=np.bool_)
    known[100:200, 300:500] = True
    known[150, 350] = False
    # A margin of 3 percent of 199 columns.
    assert window_around(known) == Window(94, 206, 294, 506)


def test_little_gain_keeps_the_whole_map():
    known = np.zeros((100, 100), dtype=np.bool_)
    whole = Window(0, 100, 0, 100)
    assert window_around(known) == whole  # nothing is known
    known[:, :82] = True
    assert window_around(known) == Window(0, 100, 0, 85)  # a margin of 3: just 15 percent less
    known[:, 82] = True
    assert window_around(known) == whole


def test_a_small_building_on_a_large_map_is_cut_out(tmp_path: Path):
    truth = np.zeros((300, 400), dtype=np.uint8)
    steps = [record(0, [150 * 400 + 210], [look(truth, range(140, 160), range(200, 240))])]
    image = still(make_run(truth, steps, [150 * 400 + 210]), tmp_path, max_pixels=440)
    # 44 x 24 cells with their margin of 2, at 10 pixels.
    assert image.width == 440
    assert image.getpixel((19, 100)) == UNSEEN
    assert image.getpixel((20, 100)) == TINTS[0]
    assert image.getpixel((419, 100)) == TINTS[0]
    assert image.getpixel((420, 100)) == UNSEEN
    assert image.getpixel((200, 219)) == TINTS[0]
    assert image.getpixel((200, 220)) == UNSEEN


@pytest.mark.parametrize("shape", [(5, 5), (40, 900), (900, 40), (1201, 1700), (1, 1), (3, 2000)])
@pytest.mark.parametrize("limit", [160, 400, 801])
def test_views_fit_and_scale_by_whole_factors(shape: tuple[int, int], limit: int):
    view = fitted(Window(0, shape[0], 0, shape[1]), 0.1, limit, 320, lambda width: 30 + width // 40)
    assert view.page_width <= limit
    assert view.height + view.footer_height <= limit
    assert 1 in (view.shrink, view.grow)
    assert view.width == -(-shape[1] // view.shrink) * view.grow
    # The next larger factor would not fit.
    assert view.grow == 48 or (view.width * 2 > limit - 60) or (view.height * 2 > limit - 120)


def test_shrunk_tiles_keep_walls_and_the_edge_of_the_known():
    truth = parse_ascii(
        """
        ......#..
        ......#..
        ......#..
        .........
        .#.......
        .........
        """.replace(" ", "")
    ).cells
    run = make_run(truth, [], [0])
    view = View(Window(0, 6, 0, 9), 3, 1, 1.0, 3, 0)
    colours = Colours(1)
    replay, tiles = Replay(run), Tiles(view, truth, colours)

    def shades() -> list[list[str]]:
        names = {UNSEEN: "?", UNSEEN_WALL: "h", SEEN_WALL: "#", TINTS[0]: "."}
        ground = colours.rgb[tiles.ground(frontier=False)]
        return [[names[tuple(int(v) for v in shade)] for shade in row] for row in ground]

    def see(rows: range, cols: range) -> None:
        tiles.reveal(replay.apply(record(0, [0], [look(truth, rows, cols)])), replay)

    assert shades() == [["?", "?", "h"], ["h", "?", "?"]]
    see(range(3), range(1))
    assert shades() == [["?", "?", "h"], ["h", "?", "?"]]  # a third of a tile is too little
    see(range(3), range(4))
    assert shades() == [["?", "?", "h"], ["#", "?", "?"]]
    see(range(6), range(5))
    assert shades() == [[".", ".", "h"], ["#", ".", "?"]]
    see(range(5, 6), range(9))
    assert shades() == [[".", ".", "#"], ["#", ".", "?"]]


@pytest.mark.parametrize("shrink", [1, 2, 3, 7])
def test_tiles_kept_up_step_by_step_equal_those_made_at_once(shrink: int):
    rng = np.random.default_rng(5)
    truth = rng.integers(0, 2, (23, 31)).astype(np.uint8)
    everything = np.array(look(truth, range(23), range(31)), dtype=np.uint32)
    parts = [sorted(rng.choice(everything, 40, replace=False).tolist()) for _ in range(8)]
    run = make_run(truth, [record(k, [0, 1], [part, []]) for k, part in enumerate(parts)], [0, 1])
    view = View(Window(2, 22, 3, 30), shrink, 1, 1.0, 0, 0)
    colours = Colours(2)
    replay, tiles = Replay(run), Tiles(view, truth, colours)
    for step in run.steps:
        tiles.reveal(replay.apply(step), replay)
    at_once = Tiles(view, truth, colours)
    at_once.reveal(np.flatnonzero(replay.team_map != UNKNOWN), replay)
    np.testing.assert_array_equal(tiles.codes, at_once.codes)


# Marks and canvases


def test_a_line_along_an_axis_covers_whole_pixels():
    cover, left, top = stroke(2.0, 5.5, 6.0, 5.5, 0.5)
    row = cover[5 - top, 2 - left : 6 - left]
    assert row.tolist() == [255] * 4
    assert not cover[4 - top].any()
    assert not cover[6 - top].any()


def test_a_disc_covers_its_area():
    cover = disc(10.3, 7.8, 6.0).cover
    assert cover.sum() / 255 == pytest.approx(np.pi * 36, rel=0.01)


@pytest.mark.parametrize("kind", [ColourCanvas, PaletteCanvas])
def test_what_lies_outside_the_canvas_is_left_out(
    kind: type[ColourCanvas] | type[PaletteCanvas],
):
    canvas = kind(6, 4, Colours(1))
    blank = canvas.pixels.copy()
    full = np.full((3, 3), 255, dtype=np.uint8)
    for left, top in ((-9, 0), (9, 0), (0, -9), (0, 9), (-3, -3), (6, 4)):
        canvas.paint(Mask(full, left, top), TEXT)
        np.testing.assert_array_equal(canvas.pixels, blank)
    canvas.paint(Mask(full, -2, -2), TEXT)
    changed = canvas.pixels != blank
    assert np.argwhere(changed if changed.ndim == 2 else changed.any(axis=2)).tolist() == [[0, 0]]


# Colours


def test_sixty_four_robots_have_colours_of_their_own():
    colours = robot_colours(64)
    assert colours[:3].tolist() == [[0, 114, 178], [213, 94, 0], [0, 158, 115]]
    lines = Colours(64).rgb[-64:].astype(int)
    assert len({tuple(colour) for colour in lines.tolist()}) == 64
    apart = np.abs(lines[:, None] - lines[None]).max(axis=2)
    assert apart[~np.eye(64, dtype=bool)].min() >= 12
    # A team's colours do not depend on its size.
    assert robot_colours(5).tolist() == colours[:5].tolist()


@pytest.mark.parametrize("robots", [1, 8, 64, 100])
def test_palettes_hold_all_colours_and_leave_the_transparent_entry_free(robots: int):
    colours = Colours(robots)
    canvas = PaletteCanvas(4, 4, colours)
    assert canvas.palette.shape == (256, 3)
    np.testing.assert_array_equal(canvas.palette[: len(colours.rgb)], colours.rgb)
    canvas.paint(disc(2.0, 2.0, 1.2), colours.line(robots - 1))
    assert canvas.pixels.max() < TRANSPARENT
    assert canvas.pixels[0, 0] == PAGE


@pytest.mark.parametrize("robots", [64, 70])
def test_large_teams_are_drawn(tmp_path: Path, robots: int):
    truth = np.zeros((ROWS, COLS), dtype=np.uint8)
    first = [at(3 * (k // 10), 4 * (k % 10)) for k in range(robots)]
    places = [divmod(cell, COLS) for cell in first]
    scans = [look(truth, range(r, r + 2), range(c, c + 4)) for r, c in places]
    steps = [record(0, first, scans), record(1, [c + 1 for c in first], [[]] * robots)]
    run = make_run(truth, steps, first)
    image = still(run, tmp_path, max_pixels=400)
    lines = Colours(robots).rgb[-64:]
    for robot, (row, col) in enumerate(places):
        assert pixel(image, row, col + 1) == tuple(int(v) for v in lines[robot % 64])
    save_animation(run, tmp_path / "a.gif", max_pixels=400)
    images, _ = frames(tmp_path / "a.gif")
    row, col = places[-1]
    assert pixel(images[-1], row, col + 1) == tuple(int(v) for v in lines[(robots - 1) % 64])


# The animation


def test_an_animation_shows_the_run_from_start_to_end(tmp_path: Path):
    save_animation(two_robots(), tmp_path / "a.gif", max_pixels=400, seconds=0.8, fps=10)
    with Image.open(tmp_path / "a.gif") as image:
        assert image.info["loop"] == 0  # for ever
        assert image.size[0] == COLS * SIDE
    images, shown = frames(tmp_path / "a.gif")
    # Two moves in eight intervals: four frames to a step.
    assert shown == [500, *[100] * 7, 2000]
    assert pixel(images[0], 5, 2) == LINES[0]
    assert pixel(images[0], 8, 25) == UNSEEN
    assert pixel(images[0], 8, 5) == TINTS[0]
    assert pixel(images[3], 8, 25) == UNSEEN
    assert pixel(images[4], 8, 25) == TINTS[1]
    # Half way from column 3 to 10, six frames in.
    assert pixel(images[6], 5, 6.5) == LINES[0]
    assert pixel(images[6], 5, 9) == TINTS[0]
    assert pixel(images[8], 5, 10) == LINES[0]
    assert pixel(images[8], 5, 7) == LINES[0]
    assert pixel(images[8], 9, 25) == TINTS[1]
    assert pixel(images[7], 9, 25) == EDGE


def test_the_last_frame_is_the_still_but_for_its_footer(tmp_path: Path):
    run = two_robots(status="out_of_budget")
    image = np.asarray(still(run, tmp_path, max_pixels=400)).astype(int)
    save_animation(run, tmp_path / "a.gif", max_pixels=400)
    last = np.asarray(frames(tmp_path / "a.gif")[0][-1]).astype(int)
    ground = np.s_[: ROWS * SIDE]
    # Edges of marks take the nearest of few colours; everything else is equal.
    differ = np.abs(image[ground] - last[ground]).max(axis=2)
    assert (differ > 0).mean() < 0.01
    assert differ.max() < 64


@pytest.mark.parametrize(("fps", "seconds"), [(20, 12), (30, 0.3), (7, 1), (50, 0.1), (1, 2)])
def test_animations_last_as_long_as_asked(tmp_path: Path, fps: float, seconds: float):
    truth = world()
    # Many moves on the spot would be merged into one frame: drive to and fro.
    steps = [record(k, [at(5, 2 + 3 * (k % 5))], [[]]) for k in range(600)]
    steps[0] = record(0, [at(5, 2)], [look(truth, range(ROWS), range(COLS))])
    run = make_run(truth, steps, [at(5, 2)])
    save_animation(run, tmp_path / "a.gif", max_pixels=160, seconds=seconds, fps=fps)
    images, shown = frames(tmp_path / "a.gif")
    count = max(round(seconds * fps), 1)
    assert len(images) <= count + 1
    first = shown[0] if len(images) == count + 1 else max(500, 1000 / fps)
    assert sum(shown) == pytest.approx(first + (count - 1) * 1000 / fps + 2000, abs=20)


def test_frames_come_back_from_the_file_as_they_were(tmp_path: Path):
    rng = np.random.default_rng(3)
    palette = np.stack([np.arange(256)] * 3, axis=1).astype(np.uint8)
    frame = rng.integers(0, 255, (40, 60)).astype(np.uint8)
    originals = [frame.copy()]
    for _ in range(6):
        row, col = rng.integers(0, 30), rng.integers(0, 50)
        frame[row : row + 9, col : col + 7] = rng.integers(0, 255)
        originals.append(frame.copy())
    with (tmp_path / "a.gif").open("wb") as stream:
        gif = GifWriter(stream, 60, 40, palette, 255)
        for original in originals:
            gif.add(original, 4)
        gif.add(originals[-1], 3)
        gif.close()
    images, shown = frames(tmp_path / "a.gif")
    assert shown == [40] * 6 + [70]
    for image, original in zip(images, originals, strict=True):
        np.testing.assert_array_equal(np.asarray(image)[..., 0], original)


def test_the_same_run_makes_the_same_bytes(tmp_path: Path):
    for name in ("a", "b"):
        save_still(two_robots(), tmp_path / f"{name}.png", max_pixels=400)
        save_animation(two_robots(), tmp_path / f"{name}.gif", max_pixels=400, seconds=1)
    for suffix in (".png", ".gif"):
        first, second = (tmp_path / f"{name}{suffix}" for name in ("a", "b"))
        assert first.read_bytes() == second.read_bytes()


# Files


@pytest.mark.parametrize(
    ("save", "name", "problem"),
    [
        (save_still, "a.jpg", r"a\.jpg: \.jpg is not a format for a still picture; .* in \.png"),
        (save_still, "a", r"a: no suffix is not a format"),
        (save_animation, "a.mp4", r"\.mp4 is not a format for an animation; end the name in \.gif"),
        (save_animation, "a.webp", r"end the name in \.gif"),
        (save_still, "none/a.png", "there is no folder .*none; make it first"),
        (save_still, "folder.png", "is a folder; name a file"),
    ],
)
def test_paths_that_cannot_be_are_refused(tmp_path: Path, save: Any, name: str, problem: str):
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(InputError, match=problem):
        save(two_robots(), tmp_path / name)
    assert os.listdir(tmp_path) == ["folder.png"]


@pytest.mark.parametrize(("save", "name"), [(save_still, "a.png"), (save_animation, "a.gif")])
def test_a_failure_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, save: Any, name: str
):
    (tmp_path / name).write_text("before")

    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(InputError, match=r"cannot be written \(Permission denied\)"):
        save(two_robots(), tmp_path / name, max_pixels=200)
    assert os.listdir(tmp_path) == [name]
    assert (tmp_path / name).read_text() == "before"


@pytest.mark.parametrize(
    "settings",
    [{"max_pixels": 10}, {"seconds": 0}, {"seconds": float("nan")}, {"fps": 0}, {"fps": 99}],
)
def test_settings_no_animation_can_have_are_refused(tmp_path: Path, settings: dict[str, Any]):
    with pytest.raises(InputError, match=next(iter(settings))):
        save_animation(two_robots(), tmp_path / "a.gif", **settings)
    assert os.listdir(tmp_path) == []


def test_importing_draws_nothing_in():
    code = (
        "import sys, conav.pictures.still, conav.pictures.animation\n"
        "assert not any(name.split('.')[0] in ('PIL', 'numba', 'scipy') for name in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_dead_are_rings_and_the_absent_are_not_shown(tmp_path: Path):
    pictures = []
    for condition in range(4):
        run = two_robots()
        now = np.array([condition, 0], dtype=np.uint8)
        run = replace(run, steps=[*run.steps[:-1], run.steps[-1]._replace(condition=now)])
        pictures.append(np.asarray(still(run, tmp_path)).astype(np.int64) @ (1, 256, 65536))
    whole, stalled, dead, absent = pictures
    assert (whole == stalled).all()
    colours, counts = np.unique(whole[whole != absent], return_counts=True)
    body = colours[counts.argmax()]  # that of robot 0
    painted = [int((picture == body).sum()) for picture in (whole, dead, absent)]
    assert painted[0] > painted[1] > painted[2]
