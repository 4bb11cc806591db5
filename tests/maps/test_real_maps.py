"""Maps that people made and published, read as they are.

The expected numbers are those of the tables in `SOURCES.md` of the data; each row names the file
as that table does, so that its origin can be looked up.
"""

import os
from pathlib import Path

import numpy as np
import pytest

from conav.errors import InputError
from conav.maps.image import read_image
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from conav.maps.read_map import READERS, read_map

GREY_205 = "are the grey 205 that map savers write for unknown"

# Of the map_server pairs: pixels across and up, m/px, origin, free, occupied, unknown
PAIRS = {
    "maps/navigation2/tb3_sandbox": (384, 384, 0.05, (-10, -10, 0), 0.054, 0.006, 0.941),
    "maps/navigation2/depot": (604, 307, 0.05, (0, 0, 0), 0.968, 0.032, 0.000),
    "maps/aws_small_house/map": (500, 500, 0.05, (-12.5, -12.5, 0), 0.252, 0.014, 0.734),
    "maps/patrolling_sim/cumberland": (688, 499, 0.075, (0, 0, 0), 0.950, 0.031, 0.018),
    "maps/patrolling_sim/broughton": (1000, 800, 0.1, (0, 0, 0), 0.950, 0.031, 0.020),
    "maps/patrolling_sim/DIAG_labs": (1000, 800, 0.05, (0, 0, 0), 0.161, 0.011, 0.828),
    "maps/patrolling_sim/1r5": (239, 249, 0.05, (0, 0, 0), 0.738, 0.120, 0.142),
    "maps/patrolling_sim/move_base_arena": (
        215,
        210,
        0.05,
        (-5.375, -5.25, 0),
        0.843,
        0.050,
        0.107,
    ),
    "maps/navigation_tutorials/lse_arena": (80, 60, 0.05, (0, 0, 0), 0.928, 0.072, 0.000),
    "maps/comprobo22/mac_1st_floor_final": (
        903,
        1706,
        0.03,
        (-1.12, -39.4, 0),
        0.989,
        0.011,
        0.000,
    ),
    "maps/comprobo22/gauntlet": (71, 76, 0.05, (-1.36, -3.09, 0), 0.902, 0.098, 0.000),
    "maps/explore_bench/corner": (250, 250, 0.1, (-12.5, -12.5, 0), 0.447, 0.037, 0.516),
    "maps/explore_bench/room_with_corner": (250, 250, 0.1, (-12.5, -12.5, 0), 0.587, 0.048, 0.364),
}

# Of the bare pictures: pixels across and up, free, occupied, unknown, words of the warning
PICTURES = {
    "navigation_tutorials/willow-full.pgm": (584, 526, 0.439, 0.023, 0.539, ""),
    "ipa/Freiburg79_scan.png": (800, 544, 0.295, 0.020, 0.685, ""),
    "ipa/lab_intel.png": (763, 708, 0.594, 0.019, 0.387, ""),  # grey with alpha, all opaque
    "ipa/lab_a_scan_furnitures.png": (824, 708, 0.611, 0.017, 0.372, ""),  # colour, all grey
    "ipa/office_b.png": (1194, 685, 0.570, 0.011, 0.419, ""),
    "ipa/office_h_furnitures.png": (1030, 1028, 0.551, 0.051, 0.397, ""),  # colour and alpha
    "stage/hospital_section.png": (1086, 443, 0.964, 0.036, 0.000, ""),
    "stage/cave.png": (500, 500, 0.979, 0.021, 0.000, ""),
    "stage/autolab.png": (809, 689, 0.957, 0.043, 0.000, ""),  # 1-bit
    "ir2_dungeon/complex_1.png": (1000, 1000, 0.476, 0.524, 0.000, "127, is read as occupied"),
    "ir2_dungeon/corridor_1.png": (640, 480, 0.417, 0.583, 0.000, "127, is read as occupied"),
}

# Of the MovingAI maps: columns, rows, free
MOVINGAI = {
    "mapf/den312d.map": (65, 81, 0.464),
    "mapf/brc202d.map": (530, 481, 0.169),
    "mapf/lak303d.map": (194, 194, 0.393),
    "mapf/Berlin_1_256.map": (256, 256, 0.725),
    "mapf/room-64-64-8.map": (64, 64, 0.789),
    "mapf/room-32-32-4.map": (32, 32, 0.666),
    "mapf/maze-128-128-2.map": (128, 128, 0.663),
    "mapf/random-64-64-20.map": (64, 64, 0.798),
    "mapf/random-32-32-20.map": (32, 32, 0.800),
    "mapf/warehouse-10-20-10-2-1.map": (161, 63, 0.562),
    "mapf/empty-8-8.map": (8, 8, 1.000),
    "bg512/AR0011SR.map": (512, 512, 0.460),
}


@pytest.fixture(scope="module")
def data() -> Path:
    folder = os.environ.get("CONAV_DATA")
    if not folder:
        pytest.skip("CONAV_DATA is not set: it names the folder of published maps")
    if not Path(folder).is_dir():
        pytest.skip(f"CONAV_DATA is {folder}, which is not a folder")
    return Path(folder)


def fractions(grid: OccupancyGrid) -> tuple[float, ...]:
    return tuple(float(np.mean(grid.cells == value)) for value in (FREE, OCCUPIED, UNKNOWN))


def test_every_file_is_a_map_or_an_input_error(data: Path):
    files = [path for room in ("maps", "movingai") for path in sorted((data / room).rglob("*.*"))]
    assert files
    for path in files:
        for resolution in (None, 0.05):
            try:
                grid = read_map(path, resolution=resolution)
            except InputError as error:
                text, remedy = str(error), error.remedy
                assert str(path.parent) in text, text
                assert remedy, text
            else:
                assert path.suffix in READERS
                assert sum(fractions(grid)) == pytest.approx(1)


@pytest.mark.parametrize("name", PAIRS)
def test_pairs(data: Path, name: str):
    cols, rows, resolution, origin, *shares = PAIRS[name]
    grid = read_map(data / f"{name}.yaml")
    assert (grid.cols, grid.rows, grid.resolution) == (cols, rows, resolution)
    assert grid.origin == origin
    assert fractions(grid) == pytest.approx(shares, abs=0.0006)
    if name not in GREY_205_READ_FREE:
        assert grid.warnings == ()


GREY_205_READ_FREE = {
    "maps/navigation2/depot": "4.8%",
    "maps/comprobo22/mac_1st_floor_final": "79.2%",
    "maps/comprobo22/gauntlet": "10.0%",
}


@pytest.mark.parametrize("name", GREY_205_READ_FREE)
def test_grey_205_that_a_yaml_reads_as_free(data: Path, name: str):
    (note,) = read_map(data / f"{name}.yaml").warnings
    assert note.startswith(f"{GREY_205_READ_FREE[name]} of the pixels of {Path(name).name}.pgm")
    assert GREY_205 in note
    assert f"set free_thresh: 0.196 in {Path(name).name}.yaml" in note


def test_a_yaml_that_names_a_picture_by_another_name(data: Path):
    path = data / "maps/explore_bench/loop.yaml"
    with pytest.raises(InputError) as caught:
        read_map(path)
    assert str(caught.value) == (
        f"{path}: image: 'square_loop.pgm' does not exist; set image: loop.pgm in loop.yaml"
    )
    grid = read_map(path.with_suffix(".pgm"), resolution=0.1)
    assert (grid.cols, grid.rows) == (250, 250)
    assert fractions(grid) == pytest.approx((0.305, 0.022, 0.674), abs=0.0006)


@pytest.mark.parametrize("name", PICTURES)
def test_bare_pictures(data: Path, name: str):
    cols, rows, *shares, words = PICTURES[name]
    path = data / "maps/images_only" / name
    with pytest.raises(InputError, match="--resolution METRES_PER_PIXEL"):
        read_map(path)
    grid = read_image(path, resolution=0.05)
    assert (grid.cols, grid.rows) == (cols, rows)
    assert fractions(grid) == pytest.approx(shares, abs=0.0006)
    assert len(grid.warnings) == bool(words)
    assert words in "".join(grid.warnings)


@pytest.mark.parametrize("name", MOVINGAI)
def test_movingai(data: Path, name: str):
    cols, rows, free = MOVINGAI[name]
    grid = read_map(data / "movingai" / name)
    assert (grid.cols, grid.rows, grid.resolution) == (cols, rows, 1.0)
    assert fractions(grid) == pytest.approx((free, 1 - free, 0), abs=0.0006)
    assert grid.warnings == ()


def test_scenarios_name_their_map_and_fit_it(data: Path):
    scenarios = sorted((data / "movingai").rglob("*.scen"))
    assert scenarios
    for path in scenarios:
        with pytest.raises(InputError, match=r"is a list of starts and goals on the map") as caught:
            read_map(path)
        grid = read_map(caught.value.remedy.removeprefix("give "))
        for line in path.read_text().splitlines()[1:]:
            words = line.split()
            if not words:
                continue
            assert (grid.cols, grid.rows) == (int(words[2]), int(words[3]))
            for x, y in ((words[4], words[5]), (words[6], words[7])):
                assert grid.cells[grid.rows - 1 - int(y), int(x)] == FREE


def test_files_beside_the_maps_that_are_none(data: Path):
    folder = data / "maps/patrolling_sim"
    for name in ("cumberland", "broughton", "DIAG_labs", "1r5", "move_base_arena"):
        with pytest.raises(InputError, match=f"is not the suffix of a map; give {name}.yaml"):
            read_map(folder / f"{name}.graph")
    with pytest.raises(InputError, match=r"initial_poses\.txt: line 1, column 1: '\['"):
        read_map(folder / "initial_poses.txt")
