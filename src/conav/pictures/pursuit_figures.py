"""Figures of [Pellier2005] on any floor: what is seen, what is contaminated, and both graphs."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.geometry.triangulation import triangulate
from conav.geometry.visibility import visibility_polygon
from conav.maps.polygon_map import PolygonMap
from conav.pictures.floor_plan import RGB, FloorCanvas
from conav.pictures.floor_plan import page_colour as rgb
from conav.pictures.output import checked_path, whole_file
from conav.pictures.palette import CURVE, PAGE, STRIP, TEXT, UNKNOWN_GROUND, WALL
from conav.pictures.plots import figure_file, page_colour, series_colours, write_note
from conav.pursuit.navigation_graph import NavigationGraph
from conav.pursuit.pursuit_graph import PursuitGraph
from conav.pursuit.shadow_moves import Point
from conav.pursuit.types import HiddenRegion

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CONTAMINATED: RGB = (246, 200, 178)
CLEAR: RGB = (196, 226, 214)
SEEN: RGB = (214, 222, 234)
_PARTS: tuple[RGB, ...] = (
    (246, 200, 178), (196, 226, 214), (190, 214, 240), (240, 226, 170), (226, 200, 226),
)  # fmt: skip
_CRITICAL: RGB = (213, 94, 0)
_EVADER: RGB = (204, 60, 60)


@dataclass(frozen=True)
class Moment:
    """A picture's worth of a pursuit: who stands where, what is hidden, a line of words."""

    places: Sequence[Point]
    hidden: Sequence[HiddenRegion] = ()
    ways: Sequence[ArrayLike] = ()  # each (n, 2) [m]
    words: str = ""


def save_view(
    plan: PolygonMap, place: Point, path: str | os.PathLike[str], words: str = ""
) -> None:
    """Figure 1: a pursuer, what it sees in grey, and the critical vertices as dots."""
    canvas = _floor(plan, 900)
    canvas.fill([_view(plan, place)], SEEN)
    _dress(canvas, plan)
    canvas.discs(plan.vertices[plan.turns < 0], _CRITICAL, 4.0)
    canvas.discs([place], rgb(TEXT), 6.0)
    canvas.footer(words)
    canvas.save(path)


def save_way_past(
    plan: PolygonMap,
    pursuer: ArrayLike,
    evader: ArrayLike,
    path: str | os.PathLike[str],
    words: str = "",
) -> None:
    """Figure 2: a pursuer's way, what it sees at the end in grey, and an evader's way in red."""
    way = np.asarray(pursuer, dtype=np.float64)
    canvas = _floor(plan, 700)
    canvas.fill([_view(plan, (float(way[-1, 0]), float(way[-1, 1])))], SEEN)
    _dress(canvas, plan)
    canvas.line(way, rgb(TEXT), 2.0)
    canvas.discs(way[-1:], rgb(TEXT), 6.0)
    path_of = np.asarray(evader, dtype=np.float64)
    canvas.line(path_of, _EVADER, 2.0)
    canvas.discs(path_of[:1], _EVADER, 3.5)
    canvas.discs(path_of[-1:], _EVADER, 6.0)
    canvas.footer(words)
    canvas.save(path)


def save_critical_event(
    plan: PolygonMap, places: Sequence[Point], path: str | os.PathLike[str], words: str = ""
) -> None:
    """Figure 3: what is seen from places one after the other, before and after an event."""
    panels: list[FloorCanvas] = []
    for place in places:
        canvas = _floor(plan, 560)
        canvas.fill([_view(plan, place)], SEEN)
        _dress(canvas, plan)
        canvas.discs(plan.vertices[plan.turns < 0], _CRITICAL, 4.0)
        canvas.discs([place], rgb(TEXT), 6.0)
        canvas.footer(words if not panels else "")
        panels.append(canvas)
    _save_panels(panels, path, columns=len(panels))


def save_moments(
    plan: PolygonMap, moments: Sequence[Moment], path: str | os.PathLike[str], columns: int = 3
) -> None:
    """Figure 4: moments side by side; seen is white, clear green, contaminated red."""
    panels: list[FloorCanvas] = []
    for one in moments:
        canvas = _floor(plan, 520)
        for region in one.hidden:
            colour = CLEAR if region.clear else CONTAMINATED
            canvas.fill([region.outer, *region.holes], colour, holes=rgb(PAGE))
        _dress(canvas, plan)
        for way in one.ways:
            canvas.line(way, rgb(CURVE), 2.0)
        canvas.discs(plan.vertices[plan.turns < 0], _CRITICAL, 2.5)
        canvas.discs(list(one.places), rgb(TEXT), 5.0)
        canvas.footer(one.words)
        panels.append(canvas)
    _save_panels(panels, path, columns)


def save_components(
    plan: PolygonMap,
    guard: Point,
    parts: Sequence[ArrayLike],
    path: str | os.PathLike[str],
    words: str = "",
) -> None:
    """Figure 8: a guard, what it sees in white, and the parts it leaves, a colour each."""
    canvas = _floor(plan, 800)
    for number, ring in enumerate(parts):
        canvas.fill([ring], _PARTS[number % len(_PARTS)])
    _dress(canvas, plan)
    canvas.discs(plan.vertices[plan.turns < 0], _CRITICAL, 3.0)
    canvas.discs([guard], rgb(TEXT), 6.0)
    canvas.footer(words)
    canvas.save(path)


def save_graphs(
    plan: PolygonMap,
    graph: NavigationGraph,
    pursuit: PursuitGraph,
    path: str | os.PathLike[str],
    note: str = "",
) -> None:
    """Figure 5: the navigation graph on its floor, and the pursuit graph of one pursuer.

    Critical vertices are numbered S1, S2 ... as the labels' bits are; a state of the pursuit graph
    is the pursuer's place and a letter for each vertex, N clear and C contaminated, and final
    states are framed. States stand by the drives it takes to get there. Needs the extra `[plot]`.
    """
    with figure_file(path, width=1800, height=1000) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.7))
        names = node_names(graph)
        for ring in plan.rings:
            closed = np.vstack((ring, ring[:1]))
            left.plot(*closed.T, color=page_colour(WALL), linewidth=1.6)
        for a, others in enumerate(graph.joined):
            for b in others.tolist():
                if a < b:
                    line = np.array([graph.points[a], graph.points[b]])
                    left.plot(*line.T, color=page_colour(CURVE), linewidth=1.0, zorder=0.5)
        for name, (x, y), critical in zip(
            names, graph.points, graph.critical.tolist(), strict=True
        ):
            colour = series_colours(2)[1 if critical else 0]
            left.plot([x], [y], "o", color=colour, markersize=7)
            left.annotate(name, (x, y), (5, 5), textcoords="offset points", fontsize=10.0)
        left.set_aspect("equal")
        left.set_axis_off()
        left.set_title("a) navigation graph", fontsize=11.0, loc="left")
        right.set_axis_off()
        right.set_title("b) pursuit graph", fontsize=11.0, loc="left")
        _draw_states(right, names, graph, pursuit)
        write_note(figure, note)


def node_names(graph: NavigationGraph) -> list[str]:
    """Critical vertices are S1, S2 ... in the order of the graph, starts p."""
    names: list[str] = []
    for critical in graph.critical.tolist():
        names.append(f"S{sum(name != 'p' for name in names) + 1}" if critical else "p")
    return names


def depths(pursuit: PursuitGraph) -> list[int]:
    """The least number of drives that lead to each state."""
    found = [0] + [-1] * (len(pursuit.states) - 1)
    for state, edges in enumerate(pursuit.edges):  # by breadth, so depths never fall
        for after, _ in edges:
            if found[after] < 0:
                found[after] = found[state] + 1
    return found


def _draw_states(
    axes: "Axes", names: list[str], graph: NavigationGraph, pursuit: PursuitGraph
) -> None:
    layers: dict[int, list[int]] = {}
    for state, depth in enumerate(depths(pursuit)):
        layers.setdefault(depth, []).append(state)
    places: dict[int, Point] = {}
    for depth, states in layers.items():
        for k, state in enumerate(states):
            places[state] = (float(depth), len(states) / 2 - k - 0.5)
    for state, edges in enumerate(pursuit.edges):
        for after, _ in edges:
            axes.annotate(
                "", places[after], places[state],
                arrowprops={"arrowstyle": "-|>", "color": page_colour(CURVE), "linewidth": 0.8,
                            "shrinkA": 12.0, "shrinkB": 22.0},
            )  # fmt: skip
    final = set(pursuit.final)
    bits = int(graph.critical.sum())
    for state, (team, dirty) in enumerate(pursuit.states):
        letters = "".join("C" if dirty >> i & 1 else "N" for i in range(bits))
        box = {
            "boxstyle": "round,pad=0.25",
            "facecolor": page_colour(STRIP),
            "edgecolor": page_colour(TEXT if state in final else CURVE),
            "linewidth": 2.0 if state in final else 0.8,
        }
        text = f"{', '.join(names[place] for place in team)}\n{letters}"
        axes.text(*places[state], text, ha="center", va="center", fontsize=7.5, bbox=box)
    tallest = max(len(states) for states in layers.values())
    axes.set_xlim(-0.6, max(layers) + 0.6)
    axes.set_ylim(-tallest / 2 - 0.4, tallest / 2 + 0.4)


def _floor(plan: PolygonMap, pixels: int) -> FloorCanvas:
    canvas = FloorCanvas(plan.bounds, max_pixels=pixels)
    canvas.fill([plan.outer], rgb(PAGE))
    return canvas


def _dress(canvas: FloorCanvas, plan: PolygonMap) -> None:
    """Holes and walls, over what was filled."""
    for hole in plan.holes:
        canvas.fill([hole], rgb(UNKNOWN_GROUND))
    canvas.outline(plan.rings, rgb(WALL), 2.0)


def _view(plan: PolygonMap, place: Point) -> NDArray[np.float64]:
    mesh = triangulate(plan.vertices, plan.ring_starts)
    return visibility_polygon(mesh, *place).corners


def _save_panels(panels: Sequence[FloorCanvas], path: str | os.PathLike[str], columns: int) -> None:
    from PIL import Image

    target = checked_path(path, ".png", "a picture")
    pictures = [panel.picture() for panel in panels]
    width = max(one.width for one in pictures) + 8
    height = max(one.height for one in pictures) + 8
    rows = -(-len(pictures) // columns)
    page = Image.new("RGB", (width * min(columns, len(pictures)), height * rows), rgb(PAGE))
    for number, one in enumerate(pictures):
        page.paste(one, (number % columns * width + 4, number // columns * height + 4))
    with whole_file(target) as stream:
        page.save(stream, format="PNG", optimize=True)
