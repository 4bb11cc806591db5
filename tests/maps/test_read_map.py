"""Any map file: which reader a suffix means, and what is said to those who give something else."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from conav.errors import InputError
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.read_map import READERS, read_map
from conav.maps.ros_map_server import write_ros_map

GRID = OccupancyGrid(np.array([[0, 1, 2], [0, 0, 0]]), 0.05, (1.0, 2.0, 0.0))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_ros_map(GRID, tmp_path / "hall")
    Image.fromarray(np.array([[0, 254]], np.uint8)).save(tmp_path / "bare.PNG")
    (tmp_path / "grid.map").write_text("type octile\nheight 1\nwidth 2\nmap\n.@\n")
    (tmp_path / "room.txt").write_text("a#\n")
    (tmp_path / "room.ascii").write_text("?#\n")
    (tmp_path / "grid.map.scen").write_text("version 1\n0\tmaps/grid.map\t2\t1\t0\t0\t0\t0\t0\n")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "resolution", "cells", "read_resolution"),
    [
        ("hall.yaml", None, GRID.cells.tolist(), 0.05),
        ("hall.yaml", 0.05, GRID.cells.tolist(), 0.05),
        ("hall.pgm", 0.3, GRID.cells.tolist(), 0.3),
        ("bare.PNG", 0.1, [[1, 0]], 0.1),
        ("grid.map", None, [[0, 1]], 1.0),
        ("grid.map", 2, [[0, 1]], 2.0),
        ("room.txt", None, [[0, 1]], 1.0),
        ("room.ascii", 0.5, [[2, 1]], 0.5),
    ],
)
def test_the_suffix_picks_the_reader(
    folder: Path, name: str, resolution: float | None, cells: object, read_resolution: float
):
    for path in (folder / name, str(folder / name)):
        grid = read_map(path, resolution=resolution)
        assert (grid.cells.tolist(), grid.resolution) == (cells, read_resolution)
        assert grid.warnings == ()


def test_the_suffixes_are_those_of_the_readers():
    pictures = {"pgm", "png", "bmp", "gif", "jpg", "jpeg", "tif", "tiff", "webp", "pbm", "ppm"}
    assert set(READERS) == {
        f".{kind}" for kind in {"yaml", "yml", "map", "txt", "ascii"} | pictures
    }


def test_a_picture_with_a_yaml_beside_it(folder: Path):
    grid = read_map(folder / "hall.pgm")
    assert (grid.resolution, grid.origin) == (0.05, (1.0, 2.0, 0.0))
    (note,) = grid.warnings
    assert note.startswith("hall.pgm is read as hall.yaml beside it says. Give --resolution")
    (folder / "hall.yaml").rename(folder / "hall.yml")
    assert read_map(folder / "hall.pgm").resolution == 0.05


def refuse(call: Callable[[], object], place: Path, *words: str) -> None:
    with pytest.raises(InputError) as caught:
        call()
    text = str(caught.value)
    assert text.startswith(f"{place}: ")
    assert caught.value.remedy
    assert all(word in text for word in words), text


def test_a_yaml_beside_it_that_describes_another_picture(folder: Path):
    (folder / "hall.pgm").rename(folder / "other.pgm")
    (folder / "hall.yaml").write_text(
        (folder / "hall.yaml").read_text().replace("hall.pgm", "other.pgm")
    )
    Image.new("L", (2, 2), 254).save(folder / "hall.pgm")
    path = folder / "hall.pgm"
    refuse(lambda: read_map(path), path, "hall.yaml beside it", "other.pgm", "--resolution")
    assert read_map(path, resolution=1).cols == 2


def test_another_resolution_than_the_yaml(folder: Path):
    path = folder / "hall.yaml"
    remedy = "set resolution: 0.1 in hall.yaml"
    refuse(lambda: read_map(path, resolution=0.1), path, "resolution is 0.05", remedy)


@pytest.mark.parametrize("name", ["hall.yaml", "hall.pgm", "grid.map", "room.txt"])
def test_a_resolution_that_is_none(folder: Path, name: str):
    path = folder / name
    refuse(lambda: read_map(path, resolution=-1), path, "resolution is -1", "above 0")


def test_a_bare_picture_needs_a_resolution(folder: Path):
    path = folder / "bare.PNG"
    refuse(lambda: read_map(path), path, "--resolution METRES_PER_PIXEL")


def test_pictures_outside_the_folder(folder: Path):
    inner = folder / "inner"
    inner.mkdir()
    path = inner / "hall.yaml"
    path.write_text((folder / "hall.yaml").read_text().replace("hall.pgm", "../hall.pgm"))
    refuse(lambda: read_map(path), path, "outside the folder", "--outside-folder")
    assert read_map(path, outside_folder=True).cells.tolist() == GRID.cells.tolist()


def test_a_scenario_names_its_map(folder: Path):
    path = folder / "grid.map.scen"
    refuse(lambda: read_map(path), path, "on the map grid.map", f"give {folder / 'grid.map'}")
    (folder / "grid.map").unlink()
    refuse(lambda: read_map(path), path, "on the map grid.map", "give the path of grid.map")
    path.write_bytes(b"\xff\x00")
    refuse(lambda: read_map(path), path, "not a map", "give its .map file")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("hall.graph", [".graph is not the suffix of a map", "give hall.yaml", ".map .txt"]),
        ("notes.docx", [".docx is not the suffix", "give one of .yaml .yml"]),
        ("Makefile", ["no suffix", "give one of .yaml"]),
    ],
)
def test_suffixes_that_are_none_of_a_map(folder: Path, name: str, words: list[str]):
    path = folder / name
    path.touch()
    refuse(lambda: read_map(path), path, *words)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("hal.yaml", ["does not exist", "did you mean hall.yaml"]),
        ("Hall", ["did you mean hall.pgm or hall.yaml?"]),
        ("grid.mpa", ["did you mean grid.map"]),
        ("room.png", ["did you mean room.ascii or room.txt?"]),
        ("zzzzzz.q", ["does not exist", "check the path"]),
        ("nowhere/hall.yaml", ["there is no folder", "nowhere", "check the path"]),
        ("nul\0.yaml", ["does not exist"]),
        ("n" * 300 + ".yaml", ["does not exist"]),
    ],
)
def test_missing_files(folder: Path, name: str, words: list[str]):
    path = folder / name
    refuse(lambda: read_map(path), path, *words)


def test_folders(folder: Path):
    some = "bare.PNG, grid.map, hall.pgm, hall.yaml, room.ascii and more"
    refuse(lambda: read_map(folder), folder, "is a folder", f"give one of its maps: {some}")
    empty = folder / "empty"
    empty.mkdir()
    refuse(lambda: read_map(empty), empty, "is a folder", "it holds no map")


def test_pipes(folder: Path):
    os.mkfifo(folder / "pipe.map")
    refuse(lambda: read_map(folder / "pipe.map"), folder / "pipe.map", "not a regular file")
