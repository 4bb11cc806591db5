"""Maps drawn as text: by hand, there and back, and drawings that make no sense."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from conav.errors import InputError
from conav.maps.ascii_art import ascii_starts, parse_ascii, read_ascii, to_ascii
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

ROOM = """
#####
#a ?#
#.Z.#
"""


def test_a_room_by_hand():
    grid = parse_ascii(ROOM, resolution=0.5, origin=(1, 2, 0.5), name="room")
    assert grid.cells.tolist() == [
        [OCCUPIED, FREE, FREE, FREE, OCCUPIED],
        [OCCUPIED, FREE, FREE, UNKNOWN, OCCUPIED],
        [OCCUPIED] * 5,
    ]
    assert (grid.resolution, grid.origin, grid.name) == (0.5, (1, 2, 0.5), "room")


def test_starts_are_row_and_column_from_the_bottom():
    assert ascii_starts(ROOM) == {"Z": (0, 2), "a": (1, 1)}
    assert list(ascii_starts("bBaA")) == ["A", "B", "a", "b"]
    assert ascii_starts("..#") == {}


def test_back_to_text():
    assert to_ascii(parse_ascii(ROOM)) == "#####\n#..?#\n#...#"


@given(
    arrays(np.uint8, array_shapes(min_dims=2, max_dims=2, max_side=15), elements=st.integers(0, 2))
)
def test_there_and_back(cells: np.ndarray):
    grid = OccupancyGrid(cells, 0.3)
    assert np.array_equal(parse_ascii(to_ascii(grid), resolution=0.3).cells, grid.cells)


@pytest.mark.parametrize("text", ["", "\n\n"])
def test_nothing_drawn(text: str):
    with pytest.raises(InputError, match="has no rows; draw a map"):
        parse_ascii(text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("...\n..", "line 2, column 3: the row has 2 characters, the first row has 3"),
        ("\n..\n...", "line 3, column 3: the row has 3 characters, the first row has 2"),
        ("..\n\n..", "line 2, column 1: the row has 0 characters"),
        ("..\n.@", "line 2, column 2: '@' means nothing here"),
        ("..\n\t.", r"line 2, column 1: '\t' means nothing here"),
        ("..\n.\u00e9", "line 2, column 2: '\u00e9' means nothing here"),
        (".\r.", r"line 1, column 2: '\r' means nothing here"),
        ("a.\n.a", "line 2, column 2: robot 'a' a second time"),
        ("aba", "line 1, column 3: robot 'a' a second time"),
    ],
)
def test_drawings_that_make_no_sense(text: str, words: str, tmp_path: Path):
    for call in (lambda: parse_ascii(text, name="drawing"), lambda: ascii_starts(text)):
        with pytest.raises(InputError) as caught:
            call()
        assert words in str(caught.value)
        assert caught.value.remedy
    path = tmp_path / "drawing.txt"
    path.write_text(text, encoding="utf-8", newline="")
    with pytest.raises(InputError) as caught:
        read_ascii(path)
    assert str(caught.value).startswith(f"{path}: {words}")


def test_bad_numbers_are_input_errors():
    for arguments in ({"resolution": 0}, {"origin": (0, 0, float("nan"))}, {"origin": "abc"}):
        with pytest.raises(InputError, match=r"^room: "):
            parse_ascii("..", name="room", **arguments)  # pyright: ignore[reportArgumentType]


def test_files(tmp_path: Path):
    path = tmp_path / "room.txt"
    path.write_bytes(b"\xef\xbb\xbf" + ROOM.replace("\n", "\r\n").encode())
    grid = read_ascii(str(path), resolution=2)
    assert np.array_equal(grid.cells, parse_ascii(ROOM).cells)
    assert (grid.name, grid.resolution) == ("room", 2.0)


def test_files_that_are_no_text(tmp_path: Path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"a\.txt: is not a text file; use \. or space"):
        read_ascii(path)
    with pytest.raises(InputError, match=r"b\.txt: does not exist"):
        read_ascii(tmp_path / "b.txt")
    path.write_text("..")
    with pytest.raises(InputError, match=r"a\.txt: resolution is nan"):
        read_ascii(path, resolution=float("nan"))


@given(st.one_of(st.text(max_size=30), st.text(".#? a\n\r", max_size=30)))
@settings(max_examples=200)
def test_any_text(text: str):
    try:
        grid = parse_ascii(text)
    except InputError as error:
        remedy = error.remedy
    else:
        assert all(grid.cells[cell] == FREE for cell in ascii_starts(text).values())
        return
    assert remedy
