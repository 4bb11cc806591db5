"""Maps of ROS map_server: each mode by hand, round trips, and files broken in every way we know."""

import os
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from PIL import Image

from conav.errors import InputError
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from conav.maps.ros_map_server import read_ros_map, write_ros_map

YAML = {
    "image": "a.png",
    "resolution": "0.05",
    "origin": "[0, 0, 0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}


def write_pair(folder: Path, pixels: object, **keys: str | None) -> Path:
    """The yaml of a pair whose picture has these pixels; a key given as None is left out."""
    Image.fromarray(np.array(pixels, dtype=np.uint8)).save(folder / "a.png")
    lines = [f"{key}: {value}" for key, value in {**YAML, **keys}.items() if value is not None]
    path = folder / "a.yaml"
    path.write_text("\n".join(lines) + "\n")
    return path


def cells_of(folder: Path, pixels: object, **keys: str | None) -> list[list[int]]:
    return read_ros_map(write_pair(folder, pixels, **keys)).cells.tolist()


# p = (255 - v) / 255: 255 -> 0, 206 -> 0.192, 205 -> 0.19608, 90 -> 0.647, 89 -> 0.651, 0 -> 1
SHADES = [[255, 206, 205, 90, 89, 0]]


def test_trinary_by_hand(tmp_path: Path):
    assert cells_of(tmp_path, SHADES) == [[FREE, FREE, UNKNOWN, UNKNOWN, OCCUPIED, OCCUPIED]]
    assert cells_of(tmp_path, SHADES, mode="trinary") == cells_of(tmp_path, SHADES)


@pytest.mark.parametrize("negate", ["1", "true", "Yes", "on"])
def test_negate_swaps_dark_and_bright(tmp_path: Path, negate: str):
    shades = [[0, 49, 50, 165, 166, 255]]  # p = v / 255: 0, 0.192, 0.19608, 0.647, 0.651, 1
    expected = [[FREE, FREE, UNKNOWN, UNKNOWN, OCCUPIED, OCCUPIED]]
    assert cells_of(tmp_path, shades, negate=negate) == expected


def test_thresholds_are_strict(tmp_path: Path):
    # 153 -> p = 0.4 and 204 -> p = 0.2, both exactly on a threshold: unknown
    keys = {"occupied_thresh": "0.4", "free_thresh": "0.2"}
    cells = cells_of(tmp_path, [[152, 153, 204, 205]], **keys)
    assert cells == [[OCCUPIED, UNKNOWN, UNKNOWN, FREE]]


def test_the_bottom_row_of_the_picture_is_row_0(tmp_path: Path):
    assert cells_of(tmp_path, [[0, 254], [205, 254]]) == [[UNKNOWN, FREE], [OCCUPIED, FREE]]


def test_scale_has_three_values_and_says_so(tmp_path: Path):
    path = write_pair(tmp_path, [[255, 100, 0, 0]], mode="scale")
    grid = read_ros_map(path)
    assert grid.cells.tolist() == [[FREE, UNKNOWN, OCCUPIED, OCCUPIED]]
    assert any("25.0%" in note and "scale" in note for note in grid.warnings)


def test_scale_reads_what_is_not_opaque_as_unknown(tmp_path: Path):
    pixels = [[[255] * 3 + [255], [255] * 3 + [254], [0] * 3 + [0], [0] * 3 + [255]]]
    path = write_pair(tmp_path, pixels, mode="scale")
    assert read_ros_map(path).cells.tolist() == [[FREE, UNKNOWN, UNKNOWN, OCCUPIED]]
    assert read_ros_map(path).warnings == ()


def test_raw_is_percent(tmp_path: Path):
    cells = cells_of(tmp_path, [[0, 19, 20, 65, 66, 100, 101, 255]], mode="Raw")
    expected = [FREE, FREE, UNKNOWN, UNKNOWN, OCCUPIED, OCCUPIED, UNKNOWN, UNKNOWN]
    assert cells == [expected]


def test_raw_does_not_negate(tmp_path: Path):
    path = write_pair(tmp_path, [[0, 100]], mode="raw", negate="1")
    grid = read_ros_map(path)
    assert grid.cells.tolist() == [[FREE, OCCUPIED]]
    assert any("negate has no effect" in note for note in grid.warnings)


def test_transparency_lies_on_white_where_map_server_averages_it(tmp_path: Path):
    # opaque black, opaque 205, clear black, half black: 127 of 255 covers 128 of white
    black, grey = [0, 0, 0, 255], [205, 205, 205, 255]
    path = write_pair(tmp_path, [[black, grey, [0, 0, 0, 0], [0, 0, 0, 127]]])
    grid = read_ros_map(path)
    assert grid.cells.tolist() == [[OCCUPIED, UNKNOWN, FREE, UNKNOWN]]
    # map_server: (3 * 0 + 255) / 4 -> p 0.75; (3 * 205 + 255) / 4 -> p 0.147, free;
    # 0 -> p 1, occupied; (0 + 127) / 4 -> p 0.875, occupied: three of four differ
    assert any("75.0% of the cells otherwise" in note for note in grid.warnings)
    assert any("50.0% of the picture is transparent" in note for note in grid.warnings)


def test_an_opaque_picture_with_alpha_read_alike_gives_no_warning(tmp_path: Path):
    assert read_ros_map(write_pair(tmp_path, [[[0, 0, 0, 255], [255] * 4]])).warnings == ()


def test_colours_are_averaged(tmp_path: Path):
    # means 85 -> p 0.667; 170 -> 0.333; 213 -> 0.165
    path = write_pair(tmp_path, [[[255, 0, 0], [255, 255, 0], [255, 255, 129]]])
    grid = read_ros_map(path)
    assert grid.cells.tolist() == [[OCCUPIED, UNKNOWN, FREE]]
    assert any("coloured" in note for note in grid.warnings)


def test_sixteen_bit_pgm(tmp_path: Path):
    path = write_pair(tmp_path, [[0]], image="deep.pgm")
    # p: 1, 0.19608 (205 * 257), 0.19599 (one shade in 65536 brighter than 0.196)
    shades = [0, 205 * 257, 52691, 65535]
    (tmp_path / "deep.pgm").write_bytes(b"P5\n4 1\n65535\n" + struct.pack(">4H", *shades))
    assert read_ros_map(path).cells.tolist() == [[OCCUPIED, UNKNOWN, FREE, FREE]]


def test_numbers_are_read_as_people_mean_them(tmp_path: Path):
    keys = {"resolution": "1e-3", "origin": "[012, -.5, +1E-1]", "free_thresh": "'.1'"}
    grid = read_ros_map(write_pair(tmp_path, SHADES, **keys))
    assert (grid.resolution, grid.origin) == (0.001, (12.0, -0.5, 0.1))


def test_a_block_list_comments_and_windows_lines(tmp_path: Path):
    path = write_pair(tmp_path, SHADES, origin="\n - 1\n - 2\n - 3")
    text = "# a map\n---\n" + path.read_text().replace("\n", " # why\r\n").replace(": # why", ":")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert read_ros_map(path).origin == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"free_thresh": "0.25"}, ["16.7%", "grey 205", "set free_thresh: 0.196 in a.yaml"]),
        ({"occupied_thresh": None}, ["no occupied_thresh", "Write occupied_thresh: 0.65"]),
        ({"free_thresh": None}, ["no free_thresh", "Write free_thresh: 0.196"]),
        ({"negate": None}, ["no negate", "Write negate: 0"]),
        ({"origin": "[1, 2]"}, ["no yaw", "Write [1.0, 2.0, 0.0]"]),
        ({"origin": "[1, 2, 90]"}, ["yaw", "radians"]),
        ({"occupied_treshold": "1"}, ["'occupied_treshold'", "Did you mean occupied_thresh?"]),
        ({"extra": "{a: [1, {b: c}]}"}, ["'extra'", "Remove it"]),
        ({"free_thresh": "0"}, ["No cell is free", "free_thresh"]),
    ],
)
def test_what_is_odd_is_warned_of(tmp_path: Path, keys: dict[str, str | None], words: list[str]):
    (note,) = read_ros_map(write_pair(tmp_path, SHADES, **keys)).warnings
    assert all(word in note for word in words), note


def test_a_sound_map_gives_no_warning(tmp_path: Path):
    assert read_ros_map(write_pair(tmp_path, SHADES)).warnings == ()


def test_little_grey_205_is_no_reason_to_warn(tmp_path: Path):
    pixels = np.full((10, 100), 254)
    pixels[0, :4] = 205
    assert read_ros_map(write_pair(tmp_path, pixels, free_thresh="0.25")).warnings == ()
    pixels[0, :5] = 205
    assert len(read_ros_map(write_pair(tmp_path, pixels, free_thresh="0.25")).warnings) == 1


def refuse(path: Path, *words: str, outside_folder: bool = False) -> None:
    """Checks that the error names the file, has a remedy, is one line and holds the words."""
    with pytest.raises(InputError) as caught:
        read_ros_map(path, outside_folder=outside_folder)
    text = str(caught.value)
    assert path.parent.name in text
    assert caught.value.remedy
    assert "\n" not in text
    assert all(word in text for word in words), text


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"image": None}, ["image is missing", "image: map.pgm"]),
        ({"image": ""}, ["image has no value"]),
        ({"image": "[a, b]"}, ["image is not a single value"]),
        ({"image": "b.png"}, ["'b.png' does not exist", "set image: a.png in a.yaml"]),
        ({"image": "A.PNG"}, ["set image: a.png in a.yaml"]),
        ({"image": "."}, ["is a folder"]),
        ({"image": '"a\\0b"'}, ["is no file name"]),
        ({"image": '"\\ud800"'}, ["is no file name"]),
        ({"image": "x" * 5000}, ["is no file name"]),
        ({"image": "a.yaml"}, ["is not a picture", "PGM or PNG"]),
        ({"image": "/etc/hostname"}, ["outside the folder", "--outside-folder"]),
        ({"image": "../a.png"}, ["outside", "set image: a.png in a.yaml, or", "--outside-folder"]),
        ({"resolution": None}, ["resolution is missing"]),
        ({"resolution": "-0.05"}, ["resolution is -0.05", "above 0"]),
        ({"resolution": "0"}, ["resolution is 0"]),
        ({"resolution": ".nan"}, ["resolution is '.nan'", "like 0.05"]),
        ({"resolution": "1e999"}, ["resolution is '1e999'"]),
        ({"resolution": "0,05"}, ["with a point"]),
        ({"resolution": "12:30"}, ["resolution is '12:30'"]),
        ({"resolution": "1_000"}, ["resolution is '1_000'"]),
        ({"resolution": "five"}, ["resolution is 'five'"]),
        ({"origin": None}, ["origin is missing", "[0.0, 0.0, 0.0]"]),
        ({"origin": "0 0 0"}, ["origin is not a list of three"]),
        ({"origin": "[0]"}, ["origin is not a list of three"]),
        ({"origin": "[0, 0, 0, 1]"}, ["origin is not a list of three"]),
        ({"origin": "[0, .inf, 0]"}, ["origin is '.inf'"]),
        ({"origin": "[[0], 0, 0]"}, ["origin is not a list of three"]),
        ({"negate": "2"}, ["negate is '2'", "0 or 1"]),
        ({"occupied_thresh": "65"}, ["occupied_thresh is 65", "0.65"]),
        ({"free_thresh": "-0.1"}, ["free_thresh is -0.1", "0.196"]),
        ({"free_thresh": "0.65"}, ["free_thresh 0.65 is not below", "0.196"]),
        ({"free_thresh": "low"}, ["free_thresh is 'low'"]),
        ({"mode": "binary"}, ["mode is 'binary'", "trinary, scale or raw"]),
        ({"extra": "1\nimage: b.png"}, ["line 8", "'image' a second time", "remove one"]),
        ({"extra": "[1, 2"}, ["is not YAML", "line"]),
        ({"? [a, b]\n": "1"}, ["the key is not a word"]),
        ({"extra": '"\\U99999999"'}, ["is not YAML"]),
        ({"extra": "\t- x\n\t y: *nowhere"}, ["is not YAML"]),
    ],
)
def test_broken_yaml(tmp_path: Path, keys: dict[str, str | None], words: list[str]):
    refuse(write_pair(tmp_path, SHADES, **keys), "a.yaml", *words)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", ["is empty"]),
        (b"# nothing\n", ["is empty"]),
        (b"just words", ["is not a list of keys"]),
        (b"- a\n- b\n", ["is not a list of keys"]),
        (b"\x00\x01\x02\xff\xfe", ["is not YAML"]),
        (b"# Gr\xf6\xdfe\nimage: a.png\n", ["is not YAML text", "UTF-8"]),
        (b"[" * 1500, ["is not YAML"]),
        (b"a: 1\n---\na: 2\n", ["is not YAML"]),
        (b" " * 100_001, ["is larger than"]),
    ],
)
def test_files_that_are_no_yaml(tmp_path: Path, data: bytes, words: list[str]):
    path = tmp_path / "a.yaml"
    path.write_bytes(data)
    refuse(path, "a.yaml", *words)


def test_a_missing_yaml_and_a_folder(tmp_path: Path):
    refuse(tmp_path / "a.yaml", "a.yaml", "does not exist")
    refuse(tmp_path, "is not a regular file")


def test_a_yaml_that_may_not_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = write_pair(tmp_path, SHADES)

    def refused(self: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", refused)
    refuse(path, "a.yaml", "Permission denied", "who may read it")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("floor.pgm", "set image: floor.pgm in floor.yaml"),  # the stem of the yaml
        ("sqare_floor.png", "set image: sqare_floor.png in floor.yaml"),  # nearly what it says
        ("other.png", "put the picture beside the yaml"),
        ("floor.csv", "put the picture beside the yaml"),
    ],
)
def test_a_missing_picture_is_looked_for(tmp_path: Path, name: str, words: str):
    (tmp_path / name).write_bytes(b"P5\n1 1\n255\n\xff")
    path = tmp_path / "floor.yaml"
    path.write_text("image: square_floor.pgm\nresolution: 1\norigin: [0, 0, 0]\n")
    refuse(path, "floor.yaml: image: 'square_floor.pgm' does not exist", words)


def test_pictures_outside_the_folder_need_a_yes(tmp_path: Path):
    inner = tmp_path / "inner"
    inner.mkdir()
    Image.new("L", (2, 1), 254).save(tmp_path / "b.png")
    (inner / "link.png").symlink_to(tmp_path / "b.png")
    for image in ("../b.png", str(tmp_path / "b.png"), "link.png", "../inner/link.png"):
        path = write_pair(inner, SHADES, image=image)
        refuse(path, "a.yaml", "outside the folder", "--outside-folder")
        assert read_ros_map(path, outside_folder=True).cols == 2
    path = write_pair(inner, SHADES, image="../nothing.png")
    refuse(path, "outside the folder")  # not "does not exist": nobody may probe for files
    refuse(path, "does not exist", outside_folder=True)


def test_roundabout_ways_to_the_own_folder_are_fine(tmp_path: Path):
    (tmp_path / "deep").mkdir()
    Image.new("L", (2, 1), 254).save(tmp_path / "deep" / "b.png")
    for image in ("deep/b.png", "deep/../deep/b.png", str(tmp_path / "deep" / "b.png")):
        assert read_ros_map(write_pair(tmp_path, SHADES, image=image)).cols == 2


# Writing


def same(a: OccupancyGrid, b: OccupancyGrid) -> bool:
    return bool(np.array_equal(a.cells, b.cells)) and (a.resolution, a.origin) == (
        b.resolution,
        b.origin,
    )


finite = st.floats(allow_nan=False, allow_infinity=False)
grids = st.builds(
    OccupancyGrid,
    arrays(np.uint8, array_shapes(min_dims=2, max_dims=2, max_side=12), elements=st.integers(0, 2)),
    st.floats(min_value=0, exclude_min=True, allow_nan=False, allow_infinity=False),
    st.tuples(finite, finite, finite),
)


@given(
    grids, st.sampled_from(["m.yaml", "m.yml", "m.pgm", "m", "m.1", "a: b # c", "\u00e9\U0001f600"])
)
@example(OccupancyGrid(np.ones((1, 1), np.uint8), 1e-05, (1e16, -0.0, 1e-300)), "m")
@settings(deadline=None, max_examples=60)
def test_what_is_written_reads_back(
    tmp_path_factory: pytest.TempPathFactory, grid: OccupancyGrid, name: str
):
    folder = tmp_path_factory.mktemp("w")
    yaml, pgm = write_ros_map(grid, folder / name)
    assert sorted(folder.iterdir()) == sorted([yaml, pgm])
    assert (yaml.parent, yaml.stem, pgm.suffix) == (folder, pgm.stem, ".pgm")
    assert same(read_ros_map(yaml), grid)


def test_the_files_are_those_of_a_map_saver(tmp_path: Path):
    grid = OccupancyGrid(np.array([[0, 1], [2, 0]]), 0.05, (-1.5, 2.0, 1e-05))
    yaml, pgm = write_ros_map(grid, str(tmp_path / "hall.yaml"))
    assert pgm.read_bytes() == b"P5\n2 2\n255\n" + bytes([205, 254, 254, 0])
    assert yaml.read_text() == (
        "image: hall.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1.5, 2.0, 1.0e-05]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )


def test_names_without_a_suffix_of_ours_keep_their_dots(tmp_path: Path):
    grid = OccupancyGrid(np.zeros((1, 1)), 1.0)
    yaml, pgm = write_ros_map(grid, tmp_path / "floor.2")
    assert (yaml.name, pgm.name) == ("floor.2.yaml", "floor.2.pgm")
    yaml, pgm = write_ros_map(grid, tmp_path / "top.PGM")
    assert (yaml.name, pgm.name) == ("top.yaml", "top.PGM")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nowhere/m.yaml", "cannot be written"),
        ("file/m.yaml", "cannot be written"),
        ("m\0.yaml", "cannot be written"),
        ("m" * 300, "cannot be written"),
        ("m.png", "give a name ending in .yaml"),
        ("folder", "is a folder"),
        ("taken", "is a folder"),
        (".", "is a folder"),
    ],
)
def test_what_cannot_be_written(tmp_path: Path, name: str, words: str):
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    (tmp_path / "taken.yaml").mkdir()
    before = sorted(tmp_path.iterdir())
    with pytest.raises(InputError, match=words) as caught:
        write_ros_map(OccupancyGrid(np.zeros((1, 1)), 1.0), tmp_path / name)
    assert caught.value.remedy
    assert sorted(tmp_path.iterdir()) == before


def test_a_full_disk_leaves_the_old_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    old = OccupancyGrid(np.zeros((2, 3)), 0.5)
    path, _ = write_ros_map(old, tmp_path / "m")

    def full(number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left"):
        write_ros_map(OccupancyGrid(np.ones((1, 1)), 1.0), path)
    assert same(read_ros_map(path), old)
    assert len(list(tmp_path.iterdir())) == 2


# Fuzzing: nothing but InputError, whatever the bytes


def only_input_errors(path: Path) -> None:
    try:
        read_ros_map(path)
    except InputError as error:
        text, remedy = str(error), error.remedy
    else:
        return
    assert remedy
    assert path.parent.name in text


VALID_YAML = "".join(f"{key}: {value}\n" for key, value in YAML.items()).encode()
VALID_PGM = b"P5\n# c\n4 2\n255\n" + bytes([0, 205, 254, 100, 255, 0, 1, 2])


@st.composite
def mutated(draw: st.DrawFn, valid: bytes) -> bytes:
    data = bytearray(valid)
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(data)))
        stop = min(len(data), start + draw(st.integers(0, 6)))
        pieces = [
            b"",
            b":",
            b"[",
            b"\n",
            b"- ",
            b"&a ",
            b"*a",
            b"!!",
            b'"',
            b"%",
            b"\xff",
            b"9" * 9,
        ]
        data[start:stop] = draw(st.one_of(st.binary(max_size=4), st.sampled_from(pieces)))
    return bytes(data)


@given(st.one_of(st.binary(max_size=200), mutated(VALID_YAML)))
@settings(deadline=None, max_examples=250)
def test_any_yaml_bytes(tmp_path_factory: pytest.TempPathFactory, data: bytes):
    folder = tmp_path_factory.getbasetemp() / "any_yaml"
    folder.mkdir(exist_ok=True)
    (folder / "a.png").write_bytes(VALID_PGM)
    (folder / "a.yaml").write_bytes(data)
    only_input_errors(folder / "a.yaml")


@given(st.one_of(st.binary(max_size=200), mutated(VALID_PGM)))
@settings(deadline=None, max_examples=250)
def test_any_picture_bytes(tmp_path_factory: pytest.TempPathFactory, data: bytes):
    folder = tmp_path_factory.getbasetemp() / "any_picture"
    folder.mkdir(exist_ok=True)
    (folder / "a.png").write_bytes(data)
    (folder / "a.yaml").write_bytes(VALID_YAML)
    only_input_errors(folder / "a.yaml")
