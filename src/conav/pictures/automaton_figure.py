"""A task's automaton, drawn as in the figure of [Zhu2014]. Needs the extra `[plot]`."""

import os
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from conav.errors import InputError
from conav.pictures.automaton_layout import ENTRY, RADIUS, Arrow, Edge, Layout, lay_out
from conav.pictures.palette import CURVE, PAGE, SOFT_TEXT, STRIP, TEXT
from conav.pictures.plots import figure_file, page_colour
from conav.tasks.automaton import INITIAL, Automaton
from conav.tasks.formula import Formula
from conav.tasks.guard import guards

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MAX_DRAWN = 24
"""States in a picture: more are no picture any more."""

_DPI = 160  # that of `figure_file`
_SIZE = 9.0  # of labels [points]
_LINE = 22  # letters of a label on one line
_LONGEST = 100  # letters of a guard that still says something
_MARGIN = 0.2  # [inches]
_SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def save_automaton(
    path: str | os.PathLike[str], automaton: Automaton, *, title: str = "", sink: bool = False
) -> None:
    """Draw an automaton to a PNG or SVG.

    States are circles, accepting ones doubled; an arrow from nowhere leads to the initial one. An
    arrow carries the guard of its letters, or their number where the guard is long. The sink, which
    a plan has no use for, and what leads there are drawn with `sink` only, or where there is
    nothing else; a note says so.

    Raises `InputError` above `MAX_DRAWN` states, without matplotlib, and for a path that cannot be
    written.
    """
    hidden = automaton.sink & (not sink) & ~automaton.sink[INITIAL]
    shown = np.flatnonzero(~hidden).tolist()
    if len(shown) > MAX_DRAWN:
        raise InputError(
            "automaton", f"its {len(shown)} states are too many to draw",
            f"draw one with at most {MAX_DRAWN}, or look at its table",
        )  # fmt: skip
    labels = {
        (shown.index(p), shown.index(q)): _label(automaton, p, q, guard)
        for p, q, guard in guards(automaton)
        if not hidden[p] and not hidden[q]
    }
    note = ""
    if hidden.any():
        names = ", ".join(state_name(state) for state in np.flatnonzero(hidden).tolist())
        note = f"Not drawn: {names}, from which the task cannot be done any more."
    with figure_file(path, width=16, height=16) as figure:
        figure.set_layout_engine("none")
        edges = [Edge(p, q, *_extent(text)) for (p, q), text in labels.items()]
        layout = lay_out(len(shown), edges)
        low, high = _bounds(layout, edges)
        width = max(high[0] - low[0], 3.2)
        letters = int(width * 14)
        title, note = fill(title, max(letters * 3 // 4, 24)), fill(note, max(letters, 32))
        top = 0.24 * len(title.splitlines()) + (0.12 if title else 0.0)
        bottom = 0.17 * len(note.splitlines()) + (0.1 if note else 0.0)
        height = high[1] - low[1]
        # The picture is as large as what is drawn, so labels never shrink.
        size = np.ceil(np.array([width, height + top + bottom]) * _DPI / 2) * 2 / _DPI
        figure.set_size_inches(*size)
        axes = figure.add_axes((0.0, bottom / size[1], 1.0, height / size[1]))
        axes.set_axis_off()
        middle = (low[0] + high[0]) / 2
        axes.set_xlim(middle - size[0] / 2, middle + size[0] / 2)
        axes.set_ylim(low[1], high[1])
        for text, arrow in zip(labels.values(), layout.arrows, strict=True):
            _draw_arrow(axes, arrow, text)
        x, y = layout.states[INITIAL]
        _draw_line(axes, np.array([[x - RADIUS - ENTRY, y], [x - RADIUS, y]]))
        for place, state in zip(layout.states.tolist(), shown, strict=True):
            _draw_state(axes, place, automaton, state)
        left = _MARGIN / size[0]
        if title:
            figure.text(left, 1.0 - 0.1 / size[1], title, ha="left", va="top", fontsize=11.0,
                        fontweight="bold")  # fmt: skip
        if note:
            figure.text(left, 0.1 / size[1], note, ha="left", va="bottom", fontsize=8.0,
                        color=page_colour(SOFT_TEXT))  # fmt: skip


def state_name(state: int) -> str:
    """A state's name.

    >>> state_name(12)
    'q₁₂'
    """
    return "q" + str(state).translate(_SUBSCRIPTS)


def _label(automaton: Automaton, source: int, target: int, guard: Formula) -> str:
    text = label_text(guard)
    if len(text) <= _LONGEST:
        return text
    count = int((automaton.transition[source] == target).sum())
    return f"{count} of {len(automaton.letters)}\nlabel sets"


def label_text(guard: Formula) -> str:
    """A guard on as few lines as are not too long, broken before an operator."""
    lines = [""]
    for part in str(guard).replace(" & ", "\n& ").replace(" | ", "\n| ").split("\n"):
        if lines[-1] and len(lines[-1]) + len(part) >= _LINE:
            lines.append(part)
        else:
            lines[-1] = f"{lines[-1]} {part}".strip()
    return "\n".join(lines)


def _extent(text: str) -> tuple[float, float]:
    """Width and height of a label [inches]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    font = FontProperties(size=_SIZE)
    widths = [
        TextPath((0.0, 0.0), line, prop=font).get_extents().width for line in text.split("\n")
    ]
    return max(widths) / 72.0 + 0.05, len(widths) * 1.2 * _SIZE / 72.0 + 0.03


def _bounds(layout: Layout, edges: list[Edge]) -> tuple[tuple[float, float], tuple[float, float]]:
    """The lower left and the upper right corner of all that is drawn."""
    corners = [layout.states - RADIUS, layout.states + RADIUS]
    corners.append(layout.states[INITIAL : INITIAL + 1] - (RADIUS + ENTRY, 0.0))
    for edge, arrow in zip(edges, layout.arrows, strict=True):
        half = np.array([edge.width, edge.height]) / 2
        corners += [arrow.points, [arrow.label - half, arrow.label + half]]
    every = np.concatenate(corners)
    (left, down), (right, up) = every.min(axis=0) - _MARGIN, every.max(axis=0) + _MARGIN
    return (float(left), float(down)), (float(right), float(up))


def _draw_state(axes: "Axes", place: list[float], automaton: Automaton, state: int) -> None:
    from matplotlib.patches import Circle

    x, y = place
    lost = bool(automaton.sink[state])
    edge = page_colour(CURVE if lost else TEXT)
    face = page_colour(STRIP if lost else PAGE)
    rings = (RADIUS, RADIUS - 0.045) if automaton.accepting[state] else (RADIUS,)
    for radius in rings:
        axes.add_patch(
            Circle((x, y), radius, facecolor=face, edgecolor=edge, linewidth=1.2, zorder=3.0)
        )
    axes.text(x, y, state_name(state), ha="center", va="center_baseline", fontsize=10.0, zorder=4.0)


def _draw_arrow(axes: "Axes", arrow: Arrow, text: str) -> None:
    _draw_line(axes, arrow.points)
    axes.text(
        *arrow.label, text, ha="center", va="center", fontsize=_SIZE, zorder=2.5, linespacing=1.2,
        bbox={"facecolor": page_colour(PAGE), "edgecolor": "none", "pad": 1.0},
    )  # fmt: skip


def _draw_line(axes: "Axes", points: np.ndarray) -> None:
    """A line with a head at its end."""
    from matplotlib.patches import Polygon

    colour = page_colour(TEXT)
    tip = points[-1]
    before = next(p for p in points[::-1] if np.hypot(*(tip - p)) > 0.08 or p is points[0])
    along = (tip - before) / np.hypot(*(tip - before))
    side = np.array([-along[1], along[0]])
    base = tip - 0.1 * along
    far = np.hypot(*(points - tip).T) > 0.08
    line = np.concatenate([points[far], base[None]])
    axes.plot(*line.T, color=colour, linewidth=1.1, solid_capstyle="butt", zorder=2.0)
    axes.add_patch(
        Polygon([tip, base + 0.042 * side, base - 0.042 * side], color=colour, linewidth=0.0,
                zorder=2.2)
    )  # fmt: skip
