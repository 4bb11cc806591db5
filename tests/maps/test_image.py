"""Bare pictures: kinds of pixels by hand, greys that no threshold fits, files that are none."""

import os
import struct
import subprocess
import sys
import zlib
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from PIL import Image

from conav.errors import InputError
from conav.maps.image import load_picture, read_image, threshold_table
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN

TRIO = np.array([[0, 205, 254]], dtype=np.uint8)
TRIO_CELLS = [[OCCUPIED, UNKNOWN, FREE]]


def save(folder: Path, image: Image.Image, name: str = "a.png") -> Path:
    image.save(folder / name)
    return folder / name


@pytest.mark.parametrize("mode", ["L", "LA", "RGB", "RGBA"])
@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp"])
def test_greys_read_alike_in_every_mode(tmp_path: Path, mode: str, suffix: str):
    path = tmp_path / f"a{suffix}"
    Image.fromarray(TRIO).convert(mode).save(path, lossless=True)
    grid = read_image(path, resolution=0.1)
    assert grid.cells.tolist() == TRIO_CELLS
    assert (grid.resolution, grid.origin, grid.name) == (0.1, (0, 0, 0), "a")
    assert grid.warnings == ()


@pytest.mark.parametrize("name", ["a.gif", "a.bmp", "a.pgm", "a.ppm", "a.PNG"])
def test_other_formats(tmp_path: Path, name: str):
    path = save(tmp_path, Image.fromarray(TRIO), name)
    assert read_image(path, resolution=1).cells.tolist() == TRIO_CELLS


def test_jpeg(tmp_path: Path):
    image = Image.fromarray(np.kron(TRIO, np.ones((16, 16), np.uint8)))
    for name, mode in (("a.jpg", "L"), ("b.jpeg", "RGB"), ("c.jpg", "CMYK")):
        path = tmp_path / name
        image.convert(mode).save(path, quality=100)
        assert read_image(path, resolution=1).cells[0, ::16].tolist() == TRIO_CELLS[0]


def test_one_bit(tmp_path: Path):
    image = Image.fromarray(np.array([[0, 255], [255, 255]], np.uint8)).convert("1")
    for name in ("a.png", "a.pbm", "a.tif"):
        cells = read_image(save(tmp_path, image, name), resolution=1).cells
        assert cells.tolist() == [[FREE, FREE], [OCCUPIED, FREE]]


def test_text_pgm_with_a_comment_and_maxval_100(tmp_path: Path):
    path = tmp_path / "a.pgm"
    path.write_bytes(b"P2\n# drawn by hand\n3 1\n100\n0 80 100\n")
    assert read_image(path, resolution=1).cells.tolist() == TRIO_CELLS  # 80 % is 204: p 0.2


@pytest.mark.parametrize("name", ["a.png", "a.tif", "a.pgm"])
def test_sixteen_bits(tmp_path: Path, name: str):
    image = Image.fromarray(TRIO.astype(np.uint16) * 257)
    picture = load_picture(save(tmp_path, image, name))
    assert (picture.white, picture.levels.tolist()) == (65535, [[0, 52685, 65278]])
    assert read_image(tmp_path / name, resolution=1).cells.tolist() == TRIO_CELLS


@pytest.mark.parametrize("mode", ["I", "F"])
def test_pixels_that_are_no_shades(tmp_path: Path, mode: str):
    path = save(tmp_path, Image.new(mode, (2, 2)), "a.tif")
    with pytest.raises(InputError, match=r"a\.tif: has pixels of the kind .*; save it as 8-bit"):
        read_image(path, resolution=1)


def test_palette_and_palette_with_a_clear_colour(tmp_path: Path):
    image = Image.fromarray(TRIO).convert("P")
    assert read_image(save(tmp_path, image), resolution=1).cells.tolist() == TRIO_CELLS
    image.save(tmp_path / "b.png", transparency=205)
    grid = read_image(tmp_path / "b.png", resolution=1)
    assert grid.cells.tolist() == [[OCCUPIED, FREE, FREE]]
    assert any("33.3% of the picture is transparent" in note for note in grid.warnings)


def test_transparency_lies_on_white(tmp_path: Path):
    # black at alpha 255, 160, 50, 49, 0: shades 0, 95, 205, 206, 255
    pixels = np.zeros((1, 5, 2), np.uint8)
    pixels[0, :, 1] = [255, 160, 50, 49, 0]
    grid = read_image(save(tmp_path, Image.fromarray(pixels, "LA")), resolution=1)
    assert grid.cells.tolist() == [[OCCUPIED, UNKNOWN, UNKNOWN, FREE, FREE]]
    (note,) = grid.warnings
    assert "80.0% of the picture is transparent" in note
    assert "without an alpha channel" in note


def test_a_small_share_is_not_called_nothing(tmp_path: Path):
    image = Image.new("LA", (100, 100), (255, 255))
    image.putpixel((0, 0), (255, 0))
    (note,) = read_image(save(tmp_path, image), resolution=1).warnings
    assert note.startswith("under 0.1% of the picture is transparent")


def test_colours_are_averaged_with_a_warning(tmp_path: Path):
    # means: 85 -> p 0.667; 170 -> p 0.333; 210 -> p 0.176 (its luma, 192, would be unknown)
    pixels = np.array([[[255, 0, 0], [0, 255, 255], [255, 155, 220]]], np.uint8)
    grid = read_image(save(tmp_path, Image.fromarray(pixels)), resolution=1)
    assert grid.cells.tolist() == [[OCCUPIED, UNKNOWN, FREE]]
    (note,) = grid.warnings
    assert "100.0% of the pixels of a.png are coloured" in note


def test_the_first_of_several_pictures_is_read(tmp_path: Path):
    first = Image.fromarray(TRIO)
    first.save(tmp_path / "a.tif", save_all=True, append_images=[Image.new("L", (5, 5))])
    grid = read_image(tmp_path / "a.tif", resolution=1)
    assert grid.cells.tolist() == TRIO_CELLS
    assert grid.warnings == ("a.tif holds 2 pictures; the first is read.",)


def test_row_0_is_the_bottom_row(tmp_path: Path):
    path = save(tmp_path, Image.fromarray(TRIO.T.copy()))
    assert read_image(path, resolution=1).cells.tolist() == [[FREE], [UNKNOWN], [OCCUPIED]]


def test_thresholds_are_arguments(tmp_path: Path):
    path = save(tmp_path, Image.fromarray(TRIO))
    cells = read_image(path, resolution=1, occupied_threshold=0.1, free_threshold=0.05).cells
    assert cells.tolist() == [[OCCUPIED, OCCUPIED, FREE]]
    with pytest.raises(InputError, match="out of order; give"):
        read_image(path, resolution=1, occupied_threshold=0.1)


@given(st.integers(1, 1000), st.floats(0, 1), st.floats(0, 1), st.booleans())
def test_the_table_is_the_rule(white: int, one: float, other: float, negate: bool):
    free, occupied = sorted((one, other))
    table = threshold_table(white, occupied, free, negate=negate)
    for level in {0, white // 3, white // 2, white}:
        p = level / white if negate else (white - level) / white
        rule = OCCUPIED if p > occupied else FREE if p < free else UNKNOWN
        assert table[level] == rule


@given(arrays(np.uint8, array_shapes(min_dims=2, max_dims=2, max_side=9)))
@settings(deadline=None, max_examples=40)
def test_png_keeps_every_shade(tmp_path_factory: pytest.TempPathFactory, shades: np.ndarray):
    path = save(tmp_path_factory.getbasetemp(), Image.fromarray(shades), "every.png")
    assert np.array_equal(load_picture(path).levels, shades)


# Greys that the thresholds do not fit


@pytest.mark.parametrize(
    ("shades", "expected", "words"),
    [
        # no wall and nothing free at the default thresholds, or only a patch free
        ([127, 195], [OCCUPIED, FREE], "bright enough to be free"),
        ([127, 195, 208], [OCCUPIED, FREE, FREE], "the darkest of its 3 grey levels, 127,"),
        ([100, 255], [OCCUPIED, FREE], "(255) as free"),
        ([0, 180], [OCCUPIED, FREE], "write a.yaml beside it"),
    ],
)
def test_few_greys_are_fitted(tmp_path: Path, shades: list[int], expected: object, words: str):
    path = save(tmp_path, Image.fromarray(np.array([shades], np.uint8)))
    grid = read_image(path, resolution=1)
    assert grid.cells.tolist() == [expected]
    (note,) = grid.warnings
    assert words in note


@pytest.mark.parametrize("shades", [[254, 205], [255, 240], [255]])
def test_maps_without_walls_stay_as_they_are(tmp_path: Path, shades: list[int]):
    path = save(tmp_path, Image.fromarray(np.array([shades], np.uint8)))
    grid = read_image(path, resolution=1)
    assert grid.cells.tolist() == [[UNKNOWN if shade == 205 else FREE for shade in shades]]


def test_many_greys_without_walls_give_a_warning(tmp_path: Path):
    path = save(tmp_path, Image.fromarray(np.arange(100, 256, dtype=np.uint8)[None]))
    (note,) = read_image(path, resolution=1).warnings
    assert "no pixel is dark enough to be occupied" in note


@pytest.mark.parametrize("shades", [[0], [150], [0, 205], list(range(10))])
def test_nothing_free_is_an_error(tmp_path: Path, shades: list[int]):
    path = save(tmp_path, Image.fromarray(np.array([shades], np.uint8)))
    with pytest.raises(InputError, match=r"a\.png: no pixel is bright enough.*write a\.yaml"):
        read_image(path, resolution=1)


# Files that are no pictures


def refuse(path: Path, *words: str, resolution: float | None = 1.0) -> None:
    with pytest.raises(InputError) as caught:
        read_image(path, resolution=resolution)
    text = str(caught.value)
    assert text.startswith(str(path))
    assert caught.value.remedy
    assert all(word in text for word in words), text


def png_that_says(width: int, height: int) -> bytes:
    """A PNG with that size in its header and almost nothing behind it."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        crc = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + crc

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    data = zlib.compress(bytes(1000))
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    )


def sound_png() -> bytes:
    file = BytesIO()
    Image.fromarray(np.arange(100, dtype=np.uint8).reshape(10, 10)).save(file, "PNG")
    return file.getvalue()


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", ["not a picture", "save it as PGM or PNG"]),
        (b"\x00\x01\x02binary", ["not a picture"]),
        (b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n", ["not a picture"]),
        (b"<svg xmlns='http://www.w3.org/2000/svg'/>", ["not a picture"]),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", ["git lfs pull"]),
        (b"P5\n4 4\n255\n123", ["damaged or cut short", "copy it again"]),
        (b"P2\n2 2\n255\n1 2 3", ["damaged or cut short"]),
        (b"P2\n2 1\n255\n1 300", ["damaged or cut short"]),
        (b"P5\n0 4\n255\n", ["not a picture"]),
        (sound_png()[:-30], ["damaged or cut short"]),
        (png_that_says(20_001, 20_000), ["more than 400,000,000 pixels", "crop it"]),
        (png_that_says(2**31 - 1, 2**31 - 1), ["more than 400,000,000 pixels"]),
        (b"Pf\n2 1\n-1.0\n" + bytes(8), ["pixels of the kind F", "save it as 8-bit"]),
    ],
)
def test_damaged_files(tmp_path: Path, data: bytes, words: list[str]):
    path = tmp_path / "a.png"
    path.write_bytes(data)
    limit = Image.MAX_IMAGE_PIXELS
    refuse(path, *words)
    assert limit == Image.MAX_IMAGE_PIXELS


def test_pictures_up_to_the_limit_are_not_bombs(tmp_path: Path):
    # Pillow by itself refuses over 179 million pixels
    path = tmp_path / "a.pbm"
    path.write_bytes(b"P4\n13400 13400\n" + bytes(13400 * 1675))
    assert load_picture(path).levels.shape == (13400, 13400)


@pytest.mark.parametrize("resolution", [0, -1, float("nan"), float("inf"), "five", None, 10**400])
def test_resolutions_that_are_none(tmp_path: Path, resolution: float):
    path = save(tmp_path, Image.fromarray(TRIO))
    word = "--resolution METRES_PER_PIXEL" if resolution is None else "resolution is"
    refuse(path, word, resolution=resolution)


def test_missing_files_folders_and_pipes(tmp_path: Path):
    refuse(tmp_path / "a.png", "does not exist")
    refuse(tmp_path, "is not a regular file")
    os.mkfifo(tmp_path / "pipe.png")
    refuse(tmp_path / "pipe.png", "is not a regular file")
    refuse(tmp_path / ("a" * 300), "cannot be read")


@given(st.data())
@settings(deadline=None, max_examples=250)
def test_any_bytes(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject):
    picture = bytearray(sound_png())
    for _ in range(data.draw(st.integers(0, 3))):
        picture[data.draw(st.integers(8, len(picture) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.getbasetemp() / "any.png"
    path.write_bytes(data.draw(st.sampled_from([bytes(picture), bytes(picture[9:])])))
    try:
        read_image(path, resolution=1)
    except InputError as error:
        text = str(error)
    else:
        return
    assert text.startswith(f"{path}: ")


def test_reading_is_what_loads_pillow_and_yaml():
    script = (
        "import sys, conav.maps.occupancy_grid, conav.maps.read_map\n"
        "assert not {'PIL', 'yaml'} & set(sys.modules), 'loaded at import'"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
