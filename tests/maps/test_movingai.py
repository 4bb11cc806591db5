"""MovingAI maps by hand, and files with something wrong in them."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from conav.errors import InputError
from conav.maps.movingai import read_movingai
from conav.maps.occupancy_grid import FREE, OCCUPIED

HEADER = "type octile\nheight 2\nwidth 4\nmap\n"


def saved(folder: Path, text: str | bytes) -> Path:
    path = folder / "tiny.map"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def test_letters_and_rows_by_hand(tmp_path: Path):
    grid = read_movingai(saved(tmp_path, HEADER + ".GS@\nOTW.\n"))
    assert grid.cells.tolist() == [
        [OCCUPIED, OCCUPIED, OCCUPIED, FREE],  # the last row of the file is row 0
        [FREE, FREE, FREE, OCCUPIED],
    ]
    assert (grid.resolution, grid.origin, grid.name) == (1.0, (0, 0, 0), "tiny")
    assert grid.warnings == ()


@pytest.mark.parametrize(
    "text",
    [
        HEADER.replace("\n", "\r\n") + ".GS@\r\nOTW.\r\n",
        "TYPE Octile\nWidth 4\n HEIGHT\t2 \nMap\n.GS@\nOTW.",
        "\ufeff" + HEADER + ".GS@ \nOTW.\n\n \n",
    ],
)
def test_other_ways_to_write_it(tmp_path: Path, text: str):
    grid = read_movingai(saved(tmp_path, text), resolution=0.5)
    assert grid.cells.tolist() == [[1, 1, 1, 0], [0, 0, 0, 1]]
    assert grid.resolution == 0.5


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["line 1, column 1: no line 'map'", "begin the file with"]),
        (".GS@\nOTW.\n", ["line 1, column 1: '.GS@' in the header"]),
        (b"\x89PNG\r\n\x1a\n\x00\xff", ["line 1, column 1", "in the header"]),
        ("type octile\nheight 2\nwidth 4\n.GS@\nOTW.\n", ["line 4, column 1: '.GS@'"]),
        ("type octile\nheight 2\nwidth 4\n", ["no line 'map'"]),
        ("type octile\nheight 2\nmap\n....\n", ["line 3, column 1: no width before 'map'"]),
        ("height 2\nwidth 4\nmap\n", ["no type before 'map'"]),
        (HEADER.replace("octile", "tile"), ["type is 'tile', only octile"]),
        (HEADER.replace("height 2", "height two"), ["height is 'two'", "positive integer"]),
        (HEADER.replace("width 4", "width 0"), ["width is '0'"]),
        (HEADER.replace("width 4", "width -4"), ["width is '-4'"]),
        (HEADER.replace("width 4", "width " + "9" * 50), ["width is"]),
        (HEADER.replace("width 4", "width 999999999"), ["over 400,000,000 cells"]),
        ("type octile\ntype octile\n", ["line 2, column 1: 'type octile'"]),
        ("type octile\nheight\n", ["line 2, column 1: 'height'"]),
        (HEADER + ".GS@\nOTW\n", ["line 6, column 4: the row has 3 letters", "width 4"]),
        (HEADER + ".GS@.\nOTW.\n", ["line 5, column 5: the row has 5 letters"]),
        (HEADER + ".GS@\n", ["line 6, column 1: the file ends after 1 rows", "height 2"]),
        (HEADER, ["line 5, column 1: the file ends after 0 rows"]),
        (HEADER + ".GS@\nOTW.\n....\n", ["line 7, column 1: a row more", "height 2"]),
        (HEADER + ".GS@\nOxW.\n", ["line 6, column 2: unknown terrain 'x'", "use . G S"]),
        (HEADER + ".GS@\nO W.\n", ["line 6, column 2: unknown terrain ' '"]),
        (HEADER + ".G\u00e9\nOTW.\n", ["line 5, column 3: unknown terrain"]),
    ],
)
def test_broken_files(tmp_path: Path, text: str | bytes, words: list[str]):
    path = saved(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_movingai(path)
    error = str(caught.value)
    assert error.startswith(f"{path}: ")
    assert caught.value.remedy
    assert all(word in error for word in words), error


def test_missing_file_and_bad_resolution(tmp_path: Path):
    with pytest.raises(InputError, match="does not exist"):
        read_movingai(tmp_path / "a.map")
    with pytest.raises(InputError, match=r"tiny\.map: resolution is -1"):
        read_movingai(saved(tmp_path, HEADER + ".GS@\nOTW.\n"), resolution=-1)


@given(
    arrays(
        "U1", array_shapes(min_dims=2, max_dims=2, max_side=9), elements=st.sampled_from(".GS@OTW")
    )
)
@settings(deadline=None, max_examples=50)
def test_every_cell_lands_where_the_file_has_it(
    tmp_path_factory: pytest.TempPathFactory, letters: np.ndarray
):
    rows, cols = letters.shape
    body = "\n".join("".join(row) for row in letters.tolist())
    text = f"type octile\nheight {rows}\nwidth {cols}\nmap\n{body}\n"
    grid = read_movingai(saved(tmp_path_factory.getbasetemp(), text))
    for (row, col), letter in np.ndenumerate(letters):
        assert grid.cells[rows - 1 - row, col] == (FREE if letter in ".GS" else OCCUPIED)


@given(st.one_of(st.binary(max_size=80), st.text("typeoctilhgwdmap 0123\n.@T", max_size=80)))
@settings(deadline=None, max_examples=200)
def test_any_bytes(tmp_path_factory: pytest.TempPathFactory, data: bytes | str):
    path = saved(tmp_path_factory.getbasetemp(), data)
    try:
        read_movingai(path)
    except InputError as error:
        text = str(error)
    else:
        return
    assert text.startswith(f"{path}: ")
