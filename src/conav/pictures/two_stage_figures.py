"""Figures 1, 2 and 4 of [Dai2018]: the flowchart from the program's table, the others from runs.

Needs the extra `[plot]`.
"""

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from conav.exploration.two_stage_flow import ADDED, FLOW, STAGE, Phase
from conav.pictures.palette import CURVE, PAGE, STRIP, TEXT
from conav.pictures.plots import figure_file, page_colour, series_colours, write_note

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Path = NDArray[np.float64]  # (steps, 2) [m]
Point = tuple[float, float]

_PLACES: dict[Phase, Point] = {
    Phase.VOTE: (0.0, 4.0),
    Phase.FIRST: (0.0, 2.6),
    Phase.AUCTION: (0.0, 0.9),
    Phase.APPROACH: (6.4, 0.9),
    Phase.SCAN: (6.4, 3.3),
    Phase.REST: (0.0, -0.8),
}
_WIDTH, _HEIGHT = 2.9, 0.62
_PATCH = {"facecolor": "white", "edgecolor": "none", "alpha": 0.9, "pad": 1.5}


def transitions() -> dict[tuple[Phase, Phase], list[str]]:
    """The events that lead from one phase to another, in the order of `FLOW`."""
    found: dict[tuple[Phase, Phase], list[str]] = {}
    for (phase, event), then in FLOW.items():
        found.setdefault((phase, then), []).append(event)
    return found


def save_flowchart(path: str | os.PathLike[str]) -> None:
    """Draw Figure 2, the strategy's transition table, to a PNG or SVG.

    A box for each phase and an arrow for each pair of phases with a transition between them,
    labelled with all its events; those that are not of the paper are in brackets.
    """
    with figure_file(path, height=980) as figure:
        axes = _empty_axes(figure, "Figure 2. The two-stage coordinated strategy for a robot")
        axes.set_xlim(-3.6, 8.8)
        axes.set_ylim(-1.5, 4.7)
        colours = series_colours(2)
        for phase, (x, y) in _PLACES.items():
            _box(axes, phase, x, y, colours[STAGE[phase] - 1])
        for (phase, then), events in transitions().items():
            text = "\n".join(f"({event})" if event in ADDED else event for event in events)
            _arrow(axes, phase, then, text)
        write_note(
            figure,
            "Made from the table that the program runs on. Each robot changes to stage 2 by "
            "itself. In brackets: added for radios that do not reach everybody, and for obstacles.",
        )


def _box(axes: "Axes", phase: Phase, x: float, y: float, colour: tuple[float, ...]) -> None:
    from matplotlib.patches import FancyBboxPatch

    corner = (x - _WIDTH / 2, y - _HEIGHT / 2)
    axes.add_patch(
        FancyBboxPatch(
            corner, _WIDTH, _HEIGHT, boxstyle="round,pad=0.02,rounding_size=0.12",
            facecolor=(*colour[:3], 0.12), edgecolor=colour, linewidth=1.6,
        )
    )  # fmt: skip
    axes.text(x, y + 0.06, phase, ha="center", va="center")
    axes.text(x, y - 0.2, f"stage {STAGE[phase]}", ha="center", va="center", fontsize=8.0)


def _arrow(axes: "Axes", phase: Phase, then: Phase, text: str) -> None:
    """An arrow between two boxes; where there is one back as well each keeps to its right."""
    (x0, y0), (x1, y1) = _PLACES[phase], _PLACES[then]
    back = (then, phase) in transitions()
    level, upright = y0 == y1, x0 == x1
    aside = 0.0
    if back:
        aside = 0.16 if level else 0.5
    if upright:
        way = 1.0 if y1 > y0 else -1.0
        x = x0 + aside * way
        start, end = (x, y0 + way * _HEIGHT / 2), (x, y1 - way * _HEIGHT / 2)
        # Downwards on the left, upwards on the right: no label lies between two arrows.
        place, align = (x + 0.12 * way, (y0 + y1) / 2), "left" if way > 0 else "right"
    elif level:
        way = 1.0 if x1 > x0 else -1.0
        y = y0 - aside * way
        start, end = (x0 + way * _WIDTH / 2, y), (x1 - way * _WIDTH / 2, y)
        place, align = ((x0 + x1) / 2, y - 0.14 * way), "center"
    else:
        start = (x0 - _WIDTH / 2, y0) if x1 < x0 else (x0 + _WIDTH / 2, y0)
        end = (x1 + _WIDTH / 2 - 0.25, y1 + _HEIGHT / 2)
        place = (0.6 * start[0] + 0.4 * end[0], 0.6 * start[1] + 0.4 * end[1])
        align = "center"
    colour = page_colour(TEXT)
    axes.annotate(
        "", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "shrinkA": 2.0,
                                    "shrinkB": 2.0, "linewidth": 1.3},
    )  # fmt: skip
    vertical = "center" if upright or not level else "top" if x1 > x0 else "bottom"
    axes.text(*place, text, ha=align, va=vertical, fontsize=8.5, bbox=_PATCH)


def save_trajectories(
    path: str | os.PathLike[str], panels: Mapping[str, Sequence[Path]], side_m: float, note: str
) -> None:
    """Draw Figure 4: the paths of a team, a panel for each method, side by side.

    A ring is where a robot began, a dot where it was at the end.
    """
    with figure_file(path, height=620) as figure:
        figure.suptitle(
            "Figure 4. Trajectories from the same starts", x=0.015, ha="left", fontsize=13.0,
            fontweight="bold",
        )  # fmt: skip
        for number, (name, paths) in enumerate(panels.items(), 1):
            axes = figure.add_subplot(1, len(panels), number)
            _square(axes, side_m)
            axes.set_title(name, fontsize=11.0)
            for one, colour in zip(paths, series_colours(len(paths)), strict=True):
                _trajectory(axes, one, colour, 0.9)
        write_note(figure, note)


def save_sections(
    path: str | os.PathLike[str],
    paths: Sequence[Path],
    axis: int,
    sections: Sequence[tuple[float, float]],
    half_m: float,
    side_m: float,
    note: str,
) -> None:
    """Draw Figure 1: the rectangles that were driven in stage 1, and the sections that are left.

    `sections` are the borders <l_j, u_j> across the lanes [m]: x where `axis` is 0, y where it is
    1. `half_m` is what a lane covers on either side.
    """
    from itertools import pairwise

    with figure_file(path, height=1380) as figure:
        axes = _empty_axes(figure, "Figure 1. Exploring trajectories and sections")
        _square(axes, side_m)
        span = axes.axvspan if axis == 0 else axes.axhspan
        for number, (lower, upper) in enumerate(sections, 1):
            span(lower, upper, color=page_colour(CURVE), alpha=0.28, linewidth=0.0)
            middle = (lower + upper) / 2
            words = f"S{number}: width {upper - lower:g} m"
            x, y = (middle, side_m / 2) if axis == 0 else (side_m / 2, middle)
            axes.text(x, y, words, ha="center", va="center", rotation=90 if axis == 0 else 0,
                      bbox=_PATCH)  # fmt: skip
        for robot, (one, colour) in enumerate(
            zip(paths, series_colours(len(paths)), strict=True), 1
        ):
            for (x0, y0), (x1, y1) in pairwise(_corners(one)):
                along = (x0 == x1) if axis == 0 else (y0 == y1)
                if along:
                    axes.fill(
                        *_lane((x0, y0), (x1, y1), half_m), color=colour, alpha=0.10, linewidth=0
                    )
            _trajectory(axes, one, colour, 1.8)
            axes.annotate(
                f"R{robot}", one[0], xytext=(9, 7), textcoords="offset points", bbox=_PATCH
            )
        write_note(figure, note)


def _corners(path: Path) -> list[Point]:
    """The places where a path turns, and its two ends."""
    places: list[Point] = []
    for x, y in path.tolist():
        if places and (x, y) == places[-1]:
            continue
        if len(places) > 1:
            (a, b), (c, d) = places[-2:]
            if (c - a) * (y - d) == (d - b) * (x - c) and (c - a) * (x - c) + (d - b) * (y - d) > 0:
                places[-1] = (x, y)
                continue
        places.append((x, y))
    return places


def _lane(begin: Point, end: Point, half: float) -> tuple[list[float], list[float]]:
    """The corners of what is seen along a lane, cut square at its ends."""
    (x0, y0), (x1, y1) = begin, end
    if x0 == x1:
        return [x0 - half, x0 + half, x1 + half, x1 - half], [y0, y0, y1, y1]
    return [x0, x0, x1, x1], [y0 - half, y0 + half, y1 + half, y1 - half]


def _trajectory(axes: "Axes", path: Path, colour: tuple[float, ...], width: float) -> None:
    axes.plot(path[:, 0], path[:, 1], color=colour, linewidth=width)
    axes.plot(*path[:1].T, marker="o", markersize=8.0, color=page_colour(PAGE), markeredgewidth=2.0,
              markeredgecolor=colour, zorder=4.0)  # fmt: skip
    axes.plot(*path[-1:].T, marker="o", markersize=6.0, color=colour, zorder=4.0)


def _square(axes: "Axes", side_m: float) -> None:
    """A panel with the square area and nothing around it."""
    axes.set_aspect("equal")
    axes.set_xlim(0.0, side_m)
    axes.set_ylim(0.0, side_m)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.set_facecolor(page_colour(STRIP))
    for spine in axes.spines.values():
        spine.set_visible(True)
        spine.set_color(page_colour(TEXT))


def _empty_axes(figure: "Figure", title: str) -> "Axes":
    axes = figure.add_subplot()
    axes.spines[:].set_visible(False)
    axes.set_xticks([])
    axes.set_yticks([])
    figure.suptitle(title, x=0.015, ha="left", fontsize=13.0, fontweight="bold")
    return axes
