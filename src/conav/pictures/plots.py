"""Plots of measurements: curves with bands, points with error bars. Needs the extra `[plot]`.

Only matplotlib's objects are used, never pyplot, so nothing is shown and no figure is remembered.
Settings of the person's own, such as a matplotlibrc file, do not count, and the files carry neither
date nor version: the same data gives the same file. matplotlib keeps its settings per process;
make plots in one thread at a time.
"""

import os
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import log10
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.errors import InputError
from conav.pictures.output import checked_path, whole_file
from conav.pictures.palette import CURVE, SOFT_TEXT, STRIP, TEXT, Colours

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH = 1280
"""Of a picture [pixels]: twice the width at which it is still easy to read."""
HEIGHT = 800
"""Of a picture [pixels], more where many labels need it."""

Colour = tuple[float, float, float]
Range = tuple[float | None, float | None]

_DPI = 160  # makes the text 12 pixels high at half the width
_MARGIN = 0.1  # [inches] around everything
_ROW = 42  # [pixels] for a label
_NOTE_LENGTH = 104  # letters across the picture
_TICKS_LENGTH = 72  # letters along the x axis
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
_FEW = 8  # so many different x get a tick each


@dataclass(frozen=True)
class Series:
    """One line of a plot: `y` over `x`, and from `low` to `high` around it where both are given.

    `x` may be names in `save_points`. NaN leaves a gap.
    """

    label: str
    x: ArrayLike | Sequence[str]
    y: ArrayLike
    low: ArrayLike | None = None
    high: ArrayLike | None = None


@dataclass(frozen=True)
class _Line:
    """A series as arrays that were checked, all of shape (n,)."""

    label: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    low: NDArray[np.float64] | None
    high: NDArray[np.float64] | None


def save_curves(
    path: str | os.PathLike[str],
    series: Sequence[Series],
    *,
    xlabel: str,
    ylabel: str,
    title: str = "",
    note: str = "",
    log_x: bool = False,
    log_y: bool = False,
    y_range: Range = (None, None),
) -> None:
    """Draw curves with their bands, each labelled at its end, to a PNG or SVG.

    `note` is a small line below, for what the bands mean and where the numbers are from. Raises
    `InputError` without matplotlib, for series that do not fit together, and for a path that
    cannot be written.
    """
    lines = [_checked(one, None, log_x, log_y) for one in _some(series)]
    colours = series_colours(len(lines))
    with figure_file(path, height=max(HEIGHT, 200 + _ROW * len(lines))) as figure:
        axes = _plot_axes(figure, xlabel, ylabel, title, note)
        for line, colour in zip(lines, colours, strict=True):
            if line.low is not None and line.high is not None:
                axes.fill_between(
                    line.x, line.low, line.high, color=colour, alpha=0.18, linewidth=0.0
                )
        for line, colour in zip(lines, colours, strict=True):
            marker = "o" if len(line.x) == 1 else ""  # a line would not be seen
            axes.plot(line.x, line.y, color=colour, linewidth=1.8, marker=marker)
        axes.margins(x=0.0)
        _scale(axes, log_x, log_y, y_range)
        _label_ends(figure, axes, lines, colours, [""] * len(lines))


def save_points(
    path: str | os.PathLike[str],
    series: Sequence[Series],
    *,
    xlabel: str,
    ylabel: str,
    title: str = "",
    note: str = "",
    log_x: bool = False,
    log_y: bool = False,
    y_range: Range = (None, None),
    connect: bool = False,
) -> None:
    """Draw points with error bars from `low` to `high` to a PNG or SVG.

    Where `x` are names, each has its place on the axis, in the order in which they first come, and
    the series stand side by side there. With `connect` a thin line joins the points of a series.
    Raises `InputError` as `save_curves` does, and when some `x` are names and others are numbers.
    """
    names = _names(_some(series))
    if names is not None and log_x:
        raise InputError("log_x", "names have no logarithm", "leave it out")
    lines = [_checked(one, names, log_x, log_y) for one in series]
    colours = series_colours(len(lines))
    markers = [_MARKERS[i % len(_MARKERS)] for i in range(len(lines))]
    with figure_file(path, height=max(HEIGHT, 200 + _ROW * len(lines))) as figure:
        from matplotlib.transforms import ScaledTranslation

        axes = _plot_axes(figure, xlabel, ylabel, title, note)
        # Side by side over a name; over a number just enough to see every bar.
        apart = min(10.0, 48.0 / len(lines)) if names is not None else min(4.0, 24.0 / len(lines))
        for i, (line, colour) in enumerate(zip(lines, colours, strict=True)):
            aside = (i - (len(lines) - 1) / 2) * apart / 72.0
            place = axes.transData + ScaledTranslation(aside, 0.0, figure.dpi_scale_trans)
            drawn: list[Artist] = []
            if connect:
                drawn += axes.plot(line.x, line.y, color=colour, linewidth=1.0, alpha=0.6)
            if line.low is not None and line.high is not None:
                drawn.append(axes.vlines(line.x, line.low, line.high, color=colour, linewidth=1.6))
            drawn += axes.plot(
                line.x, line.y, color=colour, linestyle="", marker=markers[i], markersize=6.5,
                markeredgecolor="white", markeredgewidth=0.8,
            )  # fmt: skip
            # Moved only now, so that the limits of the axes follow from the data alone.
            for artist in drawn:
                artist.set_transform(place)
        _scale(axes, log_x, log_y, y_range)
        if names is not None:
            room = max(_TICKS_LENGTH // len(names), 9)
            axes.set_xticks(range(len(names)), [fill(name, room) for name in names])
            axes.set_xlim(-0.6, len(names) - 0.4)
        else:
            _tick_each(axes, np.unique(np.concatenate([line.x for line in lines])), log_x)
        _label_ends(figure, axes, lines, colours, markers)


@contextmanager
def figure_file(
    path: str | os.PathLike[str], *, width: int = WIDTH, height: int = HEIGHT
) -> Generator["Figure", None, None]:
    """An empty matplotlib figure that becomes the file when the block ends without an error.

    The suffix says whether PNG or SVG; an SVG has the same proportions. Raises `InputError` when
    matplotlib is missing or the file cannot be written.
    """
    suffix = ".svg" if Path(path).suffix.lower() == ".svg" else ".png"
    target = checked_path(path, suffix, "a plot")
    try:
        import matplotlib
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
        from matplotlib.layout_engine import ConstrainedLayoutEngine
    except ModuleNotFoundError as error:
        problem = f"a plot needs {error.name}, which is not installed"
        raise InputError(target, problem, 'pip install "conav[plot]"') from None
    # Which window system draws is not ours to change, even for a moment.
    settings: Any = {
        name: value
        for name, value in matplotlib.rcParamsDefault.items()
        if not name.startswith("backend")
    }
    text, soft = page_colour(TEXT), page_colour(SOFT_TEXT)
    settings |= {
        "svg.hashsalt": "conav",
        "text.parse_math": False,  # a label may hold dollar signs
        "font.size": 11.0,
        "text.color": text,
        "axes.labelcolor": text,
        "axes.edgecolor": page_colour(CURVE),
        "xtick.color": page_colour(CURVE),
        "ytick.color": page_colour(CURVE),
        "xtick.labelcolor": soft,
        "ytick.labelcolor": soft,
    }
    with matplotlib.rc_context(settings):
        layout = ConstrainedLayoutEngine(w_pad=_MARGIN, h_pad=_MARGIN)
        figure = Figure((width / _DPI, height / _DPI), dpi=_DPI, layout=layout)
        FigureCanvasAgg(figure)
        yield figure
        names = ("Date", "Creator") if suffix == ".svg" else ("Software",)
        nameless: dict[str, Any] = dict.fromkeys(names)
        with whole_file(target) as stream:
            figure.savefig(stream, format=suffix[1:], metadata=nameless)


def page_colour(number: int) -> Colour:
    """A colour of the page, such as `TEXT`, as matplotlib takes it."""
    return _colour(Colours(1).rgb[number])


def series_colours(count: int) -> list[Colour]:
    """As many colours as no two people confuse, dark enough for lines on white."""
    colours = Colours(count)
    return [_colour(colours.rgb[colours.line(i)]) for i in range(count)]


def write_note(figure: "Figure", note: str) -> None:
    """Put small lines below everything; lines longer than the figure are broken."""
    if note:
        text = "\n".join(fill(part, _NOTE_LENGTH) for part in note.splitlines())
        figure.supxlabel(
            text, x=0.015, ha="left", fontsize=10.0, color=page_colour(SOFT_TEXT), linespacing=1.35
        )


def _colour(rgb: NDArray[np.uint8]) -> Colour:
    red, green, blue = (float(value) / 255.0 for value in rgb)
    return red, green, blue


def _some(series: Sequence[Series]) -> Sequence[Series]:
    if not series:
        raise InputError("series", "there is nothing to draw", "give one at least")
    return series


def _names(series: Sequence[Series]) -> list[str] | None:
    """The names that stand on the x axis in the order they first come; None where x are numbers."""
    named = [np.asarray(one.x).dtype.kind in "UO" for one in series]
    if not any(named):
        return None
    if not all(named):
        raise InputError(
            f"series {series[named.index(False)].label}",
            "has numbers as x where others have names",
            "use one of them",
        )
    return list(dict.fromkeys(str(name) for one in series for name in np.asarray(one.x).tolist()))


def _checked(series: Series, names: list[str] | None, log_x: bool, log_y: bool) -> _Line:
    """The series as arrays. Raises `InputError` when they do not fit together."""
    place = f"series {series.label}"
    if (series.low is None) != (series.high is None):
        raise InputError(place, "has only one of low and high", "give both or none")
    x: ArrayLike = series.x  # pyright: ignore[reportAssignmentType]
    if names is not None:
        x = [names.index(str(name)) for name in np.asarray(series.x).tolist()]
    columns: dict[str, NDArray[np.float64]] = {}
    for what, values in (("x", x), ("y", series.y), ("low", series.low), ("high", series.high)):
        if values is None:
            continue
        try:
            column = np.array(values, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(place, f"{what} are not all numbers", "give numbers") from None
        if column.ndim != 1 or len(column) != np.size(series.y) or len(column) == 0:
            raise InputError(
                place,
                f"{what} has shape {column.shape} and y {np.shape(series.y)}",
                "give as many of each, one at least",
            )
        if (log_x if what == "x" else log_y) and bool((column <= 0.0).any()):
            raise InputError(
                place,
                f"{what} goes down to {np.nanmin(column):g}, which has no logarithm",
                "use a linear axis",
            )
        columns[what] = column
    if not (np.isfinite(columns["x"]) & np.isfinite(columns["y"])).any():
        raise InputError(place, "has no point whose x and y are numbers", "leave the series out")
    return _Line(series.label, columns["x"], columns["y"], columns.get("low"), columns.get("high"))


def _plot_axes(figure: "Figure", xlabel: str, ylabel: str, title: str, note: str) -> "Axes":
    axes = figure.add_subplot()
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.grid(axis="y", color=page_colour(STRIP), linewidth=1.2)
    axes.set_axisbelow(True)
    axes.tick_params(axis="y", length=0.0)
    axes.set_xlabel(xlabel, labelpad=6.0)
    # Over the axis it is read without turning one's head.
    axes.annotate(ylabel, (0.0, 1.0), xytext=(0.0, 8.0), textcoords="offset points",
                  xycoords="axes fraction", va="bottom")  # fmt: skip
    if title:
        axes.set_title(title, loc="left", fontsize=13.0, fontweight="bold", pad=32.0)
    write_note(figure, note)
    return axes


def _scale(axes: "Axes", log_x: bool, log_y: bool, y_range: Range) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    low, high = y_range
    if log_y and low is not None and low <= 0.0:
        raise InputError(f"y_range from {low:g}", "has no logarithm", "use a linear axis")
    if log_x:
        axes.set_xscale("log")
    if log_y:
        axes.set_yscale("log")
    elif high is not None:
        # A line along the limit would be cut in half.
        high += 0.01 * (high - (axes.get_ylim()[0] if low is None else low))
    if low is not None or high is not None:
        axes.set_ylim(low, high)
    for axis, is_log, limits in (
        (axes.xaxis, log_x, axes.get_xlim()),
        (axes.yaxis, log_y, axes.get_ylim()),
    ):
        axis.set_major_formatter(FuncFormatter(_number))
        if is_log:
            # As many numbers between the powers of ten as there is room for.
            decades = log10(limits[1] / limits[0])
            between = (1.0,) if decades > 3.0 else (1.0, 3.0) if decades > 1.5 else (1.0, 2.0, 5.0)
            axis.set_major_locator(LogLocator(subs=between))
            axis.set_minor_locator(NullLocator())


def _number(value: float, _: int | None = None) -> str:
    return f"{value:,.10g}".replace("-", "\N{MINUS SIGN}")


def _tick_each(axes: "Axes", x: NDArray[np.float64], log_x: bool) -> None:
    """A tick for every x, where there are few and they stand apart."""
    x = x[np.isfinite(x)]
    if not 0 < len(x) <= _FEW:
        return
    place = np.log(x) if log_x else x
    if len(x) == 1 or float(np.diff(place).min()) >= 0.06 * float(place[-1] - place[0]):
        axes.set_xticks(x, [_number(float(value)) for value in x])


def _label_ends(
    figure: "Figure", axes: "Axes", lines: list[_Line], colours: list[Colour], markers: list[str]
) -> None:
    """Write each label beside the end of its line, moved up or down where labels would meet."""
    from matplotlib.lines import Line2D

    shown = [i for i, line in enumerate(lines) if line.label]
    if not shown:
        return
    texts = [
        axes.text(1.06, 0.5, fill(lines[i].label, 24), va="center", transform=axes.transAxes)
        for i in shown
    ]
    # The layout makes room for the labels; only then is it known where the lines end.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    frame = axes.bbox
    wanted: list[tuple[float, float]] = []
    for i in shown:
        x, y = lines[i].x, lines[i].y
        last = int(np.flatnonzero(np.isfinite(x) & np.isfinite(y))[-1])
        end = float(axes.transData.transform((x[last], y[last]))[1])
        # Lines that end together are told apart by which was higher on the way.
        wanted.append(((end - frame.y0) / frame.height, float(np.nanmean(y))))
    heights = [text.get_window_extent().height / frame.height for text in texts]
    order = sorted(range(len(shown)), key=lambda k: wanted[k])
    inside = [min(max(wanted[k][0], 0.0), 1.0) for k in order]
    places = spread(inside, [1.15 * heights[k] for k in order])
    for k, y in zip(order, places, strict=True):
        i = shown[k]
        texts[k].set_y(y)
        key = Line2D(
            [1.015, 1.03, 1.045], [y] * 3, color=colours[i], linewidth=1.8, clip_on=False,
            marker=markers[i], markevery=[1], linestyle="" if markers[i] else "-",
            transform=axes.transAxes,
        )  # fmt: skip
        axes.add_artist(key)


def spread(wanted: list[float], heights: list[float]) -> list[float]:
    """Places for the middles of labels, near those wanted (which must rise), so that none overlap.

    They stay between 0 and 1 where there is room.
    """
    places = list(wanted)
    for i in range(1, len(places)):
        places[i] = max(places[i], places[i - 1] + (heights[i - 1] + heights[i]) / 2)
    if places and places[-1] > 1.0:
        places[-1] = 1.0
        for i in range(len(places) - 2, -1, -1):
            places[i] = min(places[i], places[i + 1] - (heights[i] + heights[i + 1]) / 2)
    return places
