"""Figures 6 and 7 of [Pellier2005] from the program's tables: the delegation protocol.

Needs the extra `[plot]`.
"""

import os
from typing import TYPE_CHECKING

from conav.pictures.palette import TEXT
from conav.pictures.plots import figure_file, page_colour, series_colours, write_note
from conav.pursuit.delegation_tables import ASKING, HELPING, Asking, Helping

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Point = tuple[float, float]
State = Asking | Helping

PLACES: dict[State, Point] = {
    Asking.WORKING: (-7.2, 7.6),
    Asking.ROLES: (0.0, 7.6),
    Asking.CHOICE: (0.0, 5.2),
    Asking.WAITING: (9.2, 7.6),
    Asking.MORE: (9.2, 5.2),
    Asking.IDLES: (-6.4, 2.4),
    Asking.GUARDS: (0.0, 2.4),
    Asking.STUCKS: (6.4, 2.4),
    Asking.HELPED: (0.0, 0.0),
    Helping.FREE: (16.0, 7.6),
    Helping.ASKED: (16.0, 5.2),
    Helping.OFFERED: (16.0, 2.4),
    Helping.COMING: (16.0, 0.0),
}
_LABELS: dict[tuple[State, State], float] = {
    # How far along its arrow a label stands, where the middle is taken.
    (Asking.CHOICE, Asking.WAITING): 0.28,
    (Asking.ROLES, Asking.CHOICE): 0.75,
    (Asking.CHOICE, Asking.ROLES): 0.75,
    (Asking.MORE, Asking.ROLES): 0.25,
    (Asking.CHOICE, Asking.IDLES): 0.62,
    (Asking.IDLES, Asking.CHOICE): 0.3,
    (Asking.CHOICE, Asking.STUCKS): 0.62,
    (Asking.STUCKS, Asking.CHOICE): 0.3,
    (Asking.CHOICE, Asking.GUARDS): 0.7,
    (Asking.GUARDS, Asking.CHOICE): 0.7,
}
_WIDTH, _HEIGHT = 5.5, 0.9


def transitions() -> dict[tuple[State, State], list[str]]:
    """The events that lead from one state to another, of both machines."""
    found: dict[tuple[State, State], list[str]] = {}
    for (state, event), then in ASKING.items():
        found.setdefault((state, then), []).append(event)
    for (helping, event), after in HELPING.items():
        found.setdefault((helping, after), []).append(event)
    return found


def in_box(state: State, then: State) -> bool:
    """Whether a transition is written into its state's box: many lead back to where all began."""
    return (
        then is Asking.WORKING
        or then is Helping.FREE
        or (state, then) == (Asking.HELPED, Asking.ROLES)
    )


def save_delegation(path: str | os.PathLike[str]) -> None:
    """Draw both machines of the protocol to a PNG or SVG: boxes are states, arrows events."""
    with figure_file(path, width=1600, height=960) as figure:
        axes = figure.add_subplot(1, 1, 1)
        axes.set_axis_off()
        axes.set_xlim(-10.1, 18.9)
        axes.set_ylim(-0.7, 8.2)
        figure.suptitle(
            "The delegation protocol: who asks (left), who may help (right)",
            x=0.015, ha="left", fontsize=13.0, fontweight="bold",
        )  # fmt: skip
        colours = series_colours(2)
        marks: dict[State, list[str]] = {}
        for (state, then), events in transitions().items():
            if in_box(state, then):
                where = str(then)[0] if isinstance(then, Asking) else str(then)
                marks.setdefault(state, []).append(f"{', '.join(events)}: {where}")
            else:
                _arrow(axes, state, then, "\n".join(events))
        for state, (x, y) in PLACES.items():
            colour = colours[0 if isinstance(state, Asking) else 1]
            _box(axes, str(state), "\n".join(marks.get(state, [])), x, y, colour)
        write_note(
            figure,
            "Made from the tables that the program runs on. States 1 to 7 are numbered as in "
            "Figure 6. In boxes: what leads back, and where to.",
        )


def _box(axes: "Axes", text: str, mark: str, x: float, y: float, colour: tuple[float, ...]) -> None:
    from matplotlib.patches import FancyBboxPatch

    axes.add_patch(
        FancyBboxPatch(
            (x - _WIDTH / 2, y - _HEIGHT / 2), _WIDTH, _HEIGHT,
            boxstyle="round,pad=0.02,rounding_size=0.12",
            facecolor=(*colour[:3], 0.12), edgecolor=colour, linewidth=1.6,
        )
    )  # fmt: skip
    axes.text(x, y + (0.14 if mark else 0.0), text, ha="center", va="center", fontsize=8.5)
    if mark:
        axes.text(x, y - 0.2, mark, ha="center", va="center", fontsize=7.0)


def _arrow(axes: "Axes", state: State, then: State, text: str) -> None:
    (x0, y0), (x1, y1) = PLACES[state], PLACES[then]
    both = (then, state) in transitions() and not in_box(then, state)
    bend = 0.2 if both else 0.0
    start, end = _edge(x0, y0, x1, y1), _edge(x1, y1, x0, y0)
    colour = page_colour(TEXT)
    axes.annotate(
        "", end, start,
        arrowprops={"arrowstyle": "-|>", "color": colour, "shrinkA": 2.0, "shrinkB": 2.0,
                    "linewidth": 1.2, "connectionstyle": f"arc3,rad={bend}"},
    )  # fmt: skip
    # On the curve of arc3, a parabola through its control point.
    dx, dy = end[0] - start[0], end[1] - start[1]
    cx = (start[0] + end[0]) / 2 + bend * dy
    cy = (start[1] + end[1]) / 2 - bend * dx
    t = _LABELS.get((state, then), 0.5)
    x = (1 - t) ** 2 * start[0] + 2 * t * (1 - t) * cx + t**2 * end[0]
    y = (1 - t) ** 2 * start[1] + 2 * t * (1 - t) * cy + t**2 * end[1]
    axes.text(
        x, y, text, ha="center", va="center", fontsize=7.5,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.9, "pad": 1.2},
    )  # fmt: skip


def _edge(x0: float, y0: float, x1: float, y1: float) -> Point:
    """Where the line between the middles of two boxes leaves the first."""
    dx, dy = x1 - x0, y1 - y0
    scale = min(
        (_WIDTH / 2) / abs(dx) if dx else float("inf"),
        (_HEIGHT / 2 + 0.03) / abs(dy) if dy else float("inf"),
    )
    return x0 + dx * scale, y0 + dy * scale
