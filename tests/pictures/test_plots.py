"""Plots: what is drawn, files that repeat, and input that cannot be drawn."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from conav.errors import InputError
from conav.pictures.plots import (
    HEIGHT,
    WIDTH,
    Series,
    figure_file,
    save_curves,
    save_points,
    series_colours,
    spread,
)

BLUE, VERMILION = (0, 114, 178), (213, 94, 0)
AXES = {"xlabel": "time step", "ylabel": "points"}
RISING = Series("rising", [0, 1, 2], [0.0, 0.5, 1.0], [0.0, 0.4, 0.9], [0.1, 0.6, 1.0])
FLAT = Series("flat", [0, 1, 2], [0.2, 0.2, 0.2])


def pixels(path: Path) -> NDArray[np.uint8]:
    with Image.open(path) as picture:
        picture.verify()
    with Image.open(path) as picture:
        assert picture.format == "PNG"
        return np.asarray(picture.convert("RGB"))


def rows_of(image: NDArray[np.uint8], colour: tuple[int, int, int]) -> NDArray[np.intp]:
    """The rows in which a colour is found left of the labels."""
    return np.flatnonzero((image[:, : WIDTH // 2] == colour).all(axis=2).any(axis=1))


def test_curves_are_where_their_numbers_say(tmp_path: Path) -> None:
    low = Series("low", [0, 10], [1.0, 1.0])
    high = Series("high", [0, 10], [3.0, 3.0])
    save_curves(tmp_path / "c.png", [low, high], y_range=(0, 4), **AXES)
    image = pixels(tmp_path / "c.png")
    assert image.shape == (HEIGHT, WIDTH, 3)
    below, above = rows_of(image, BLUE), rows_of(image, VERMILION)
    assert np.ptp(below) < 6
    assert np.ptp(above) < 6
    assert above.max() < below.min()


def test_a_band_is_drawn_around_its_curve(tmp_path: Path) -> None:
    save_curves(tmp_path / "with.png", [RISING], **AXES)
    save_curves(tmp_path / "without.png", [Series("rising", RISING.x, RISING.y)], **AXES)
    drawn = [(pixels(tmp_path / f"{name}.png") < 250).any(axis=2) for name in ("with", "without")]
    assert drawn[0].sum() > 2 * drawn[1].sum()


def test_points_stand_side_by_side_over_a_name(tmp_path: Path) -> None:
    """Two series with the same point: both colours are seen, the first to the left."""
    series = [Series(name, ["office"], [2.0], [1.0], [3.0]) for name in ("a", "b")]
    save_points(tmp_path / "p.png", series, xlabel="map", ylabel="steps")
    # The names of the series and their marks are to the right.
    image = pixels(tmp_path / "p.png")[:, : WIDTH * 3 // 4]
    columns = [
        np.flatnonzero((image == colour).all(axis=2).any(axis=0)) for colour in (BLUE, VERMILION)
    ]
    assert columns[0].max() < columns[1].min()


@pytest.mark.parametrize("suffix", ["png", "svg"])
@pytest.mark.parametrize("save", [save_curves, save_points])
def test_the_same_data_gives_the_same_file(
    save: Callable[..., None], suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import matplotlib

    files = [tmp_path / f"{i}.{suffix}" for i in range(2)]
    save(files[0], [RISING, FLAT], title="Title", note="Note.", **AXES)
    # Neither the clock nor a person's own settings are seen in the file, and they stay.
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    monkeypatch.setitem(matplotlib.rcParams, "axes.facecolor", "red")
    monkeypatch.setitem(matplotlib.rcParams, "font.size", 20.0)
    save(files[1], [RISING, FLAT], title="Title", note="Note.", **AXES)
    assert files[0].read_bytes() == files[1].read_bytes()
    assert matplotlib.rcParams["axes.facecolor"] == "red"
    assert matplotlib.rcParams["font.size"] == 20.0


def test_svg(tmp_path: Path) -> None:
    save_curves(tmp_path / "c.svg", [RISING], **AXES)
    root = ElementTree.parse(tmp_path / "c.svg").getroot()
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert b"<dc:date>" not in (tmp_path / "c.svg").read_bytes()


@pytest.mark.parametrize("log", [False, True])
@pytest.mark.parametrize(
    "series",
    [
        [Series("one", [3], [5])],
        [Series("", [1, 2], [5, 5])],
        [Series("gap", [1, 2, 3], [1.0, np.nan, 3.0])],
        [Series("ends in a gap", [1, 2, 3], [1.0, 2.0, np.nan])],
        [Series("wide", np.geomspace(1, 1e6, 40), np.geomspace(1e-3, 1e6, 40))],
        [Series("$5 and $6_x^", [1, 2], [1, 2])],
        [Series(f"series {i}", [1, 2], [1, 1 + i % 3]) for i in range(30)],
    ],
    ids=lambda series: series[0].label or "no label",
)
def test_unusual_series_can_be_drawn(series: list[Series], log: bool, tmp_path: Path) -> None:
    for save in (save_curves, save_points):
        save(tmp_path / "c.png", series, log_x=log, log_y=log, **AXES)
        height, width, _ = pixels(tmp_path / "c.png").shape
        assert width == WIDTH
        assert height == (HEIGHT if len(series) == 1 else 200 + 42 * 30)


def draw(*series: Series, **options: Any) -> None:
    save_points("never.png", series, **AXES, **options)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: draw(), "series: there is nothing to draw; give one at least"),
        (lambda: draw(Series("a", [1], [1, 2])), r"series a: x has shape \(1,\) and y \(2,\); .*"),
        (lambda: draw(Series("a", [], [])), r"series a: x has shape \(0,\) and y \(0,\); .*"),
        (
            lambda: draw(Series("a", [1], [1], low=[0])),
            "series a: has only one of low and high; .*",
        ),
        (lambda: draw(Series("a", [1], ["b"])), "series a: y are not all numbers; give numbers"),
        (lambda: draw(Series("a", [1], [np.nan])), "series a: has no point whose .*"),
        (lambda: draw(Series("a", [1], [0]), log_y=True), "series a: y goes down to 0, .*"),
        (lambda: draw(Series("a", [-1], [1]), log_x=True), "series a: x goes down to -1, .*"),
        (lambda: draw(Series("a", ["b"], [1]), log_x=True), "log_x: names have no logarithm; .*"),
        (
            lambda: draw(Series("a", ["b"], [1]), Series("c", [1], [1])),
            "series c: has numbers as x where others have names; use one of them",
        ),
        (
            lambda: draw(Series("a", [1], [1]), log_y=True, y_range=(0, None)),
            "y_range from 0: has no logarithm; use a linear axis",
        ),
    ],
)
def test_what_cannot_be_drawn_is_said_and_no_file_made(
    call: Callable[[], None], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=f"^{said}$"):
        call()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["plot.jpg", "plot", "missing/plot.png"])
def test_paths_that_cannot_be_written(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"end the name in \.png|make it first"):
        save_curves(tmp_path / name, [FLAT], **AXES)


def test_an_error_while_drawing_leaves_the_file_as_it_was(tmp_path: Path) -> None:
    target = tmp_path / "c.png"
    target.write_bytes(b"before")
    with pytest.raises(RuntimeError), figure_file(target):
        raise RuntimeError
    assert target.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [target]


def test_without_matplotlib_the_remedy_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError) as caught:
        save_curves(tmp_path / "c.png", [FLAT], **AXES)
    assert str(caught.value) == (
        f"{tmp_path / 'c.png'}: a plot needs matplotlib, which is not installed; "
        'pip install "conav[plot]"'
    )


def test_matplotlib_is_imported_by_a_plot_only_and_pyplot_never(tmp_path: Path) -> None:
    program = f"""
import sys
import conav, conav.cli, conav.pictures.potential_figures
from conav.pictures.plots import Series, save_points
assert not [name for name in sys.modules if name.startswith("matplotlib")]
save_points({str(tmp_path / "p.png")!r}, [Series("", [1], [1])], xlabel="x", ylabel="y")
assert "matplotlib" in sys.modules
assert "matplotlib.pyplot" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_labels_are_spread() -> None:
    assert spread([], []) == []
    assert spread([0.1, 0.9], [0.2, 0.2]) == [0.1, 0.9]
    # The second is pushed up to half its height and half the other's above the first.
    assert spread([0.5, 0.5], [0.1, 0.3]) == pytest.approx([0.5, 0.7])
    # At the upper end the last one holds and pushes the others down.
    assert spread([0.5, 1.0, 1.0], [0.2, 0.2, 0.2]) == pytest.approx([0.5, 0.8, 1.0])
    assert spread([1.0, 1.0, 1.0], [0.2, 0.2, 0.2]) == pytest.approx([0.6, 0.8, 1.0])


def test_colours_are_those_of_robots() -> None:
    assert series_colours(2) == [tuple(v / 255 for v in BLUE), tuple(v / 255 for v in VERMILION)]
    assert len(set(series_colours(12))) == 12
