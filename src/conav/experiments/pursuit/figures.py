"""The reproduction's pictures: the paper's figures on made floors, and plots of what was played."""

from math import log2, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import shapely

from conav.experiments.pursuit.interleaving import Cleared, against_exploring_first
from conav.experiments.pursuit.results import Results, ratio_of, was_split
from conav.experiments.pursuit.world import (
    GRAPHS,
    INTERLEAVING,
    LABELS,
    MESSAGES,
    METHODS,
    TEAMS,
    is_random,
)
from conav.geometry.triangulation import triangulate
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pictures.delegation_figure import save_delegation
from conav.pictures.plots import Series, save_points
from conav.pictures.pursuit_figures import (
    Moment,
    save_components,
    save_critical_event,
    save_graphs,
    save_moments,
    save_view,
    save_way_past,
)
from conav.pictures.pursuit_still import save_pursuit_still
from conav.pursuit.beliefs import shadow_polygons
from conav.pursuit.clear_known_map import ClearKnownMap
from conav.pursuit.delegation import Delegation
from conav.pursuit.navigation_graph import known_navigation_graph
from conav.pursuit.pursuit_graph import make_pursuit_graph
from conav.pursuit.recorder import record_pursuit
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.splitting import SplittingByVertexLabels
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult, Schedule
from conav.pursuit.verify import verify_schedule
from conav.pursuit.vertex_labels import label_all
from conav.pursuit.vertex_sight import VertexSight
from conav.runs.reader import read_run
from conav.runs.types import PursuitRun

CAPTIONS = (
    ("figure-1.png", "Figure 1: a pursuer on `rooms:3`, in grey what it sees, and the critical "
     "vertices."),
    ("figure-2.png", "Figure 2: one pursuer drives a lap of `ring`, and an evader keeps out of its "
     "sight all the time: the way is the verifier's."),
    ("figure-3.png", "Figure 3: a critical event on `spider:1,1,2`: a pursuer crosses the line of "
     "a wall, and what lies along that wall is hidden."),
    ("figure-4.png", "Figure 4: states of a pursuit of `rooms:3` by one pursuer: white is seen, "
     "red contaminated, green clear."),
    ("figure-5.png", "Figure 5: the navigation graph of `comb:2` and its pursuit graph with the "
     "paper's labels."),
    ("figure-6-7.png", "Figures 6 and 7: the delegation protocol, from the program's tables."),
    ("labels.png", "Not in the paper: on `spider:2,2,2` all of its labels are clear, and an evader "
     "gets away on the dashed way."),
    ("figure-8.png", "Figure 8: a guard on `spider:2,2,2` and the parts it leaves, each for a "
     "pursuer of its own."),
    ("figure-9.png", "Figure 9: delegation on `triples:3`, each time a guard takes its post: a "
     "pursuer whose part is clear stands guard elsewhere."),
)  # fmt: skip
"""File names, and what the pictures show."""


def draw(folder: Path, results: Results) -> None:
    """Draws all pictures into the folder. Raises `InputError` without matplotlib."""
    _figure_1(folder / "figure-1.png")
    _figure_2(folder / "figure-2.png")
    _figure_3(folder / "figure-3.png")
    _figure_4(folder / "figure-4.png")
    _wrong_claim(folder / "labels.png")
    _figures_8_and_9(folder / "figure-8.png", folder / "figure-9.png")
    _figure_5(folder / "figure-5.png")
    save_delegation(folder / "figure-6-7.png")
    _plot_interleaving(folder / "interleaving.png", results)
    _plot_graphs(folder / "graphs.png", results)
    _plot_messages(folder / "messages.png", results)
    _plot_teams(folder / "teams.png", results)


def _problem(name: str) -> PursuitProblem:
    floor = load_floor_plan(name)
    return PursuitProblem(floor, (Pursuer("pursuer_1", default_start(floor)),), name=name)


def _figure_1(path: Path) -> None:
    floor = load_floor_plan("rooms:3")
    save_view(floor, default_start(floor), path, "rooms:3: seen, and critical vertices")


def _figure_2(path: Path) -> None:
    floor = load_floor_plan("ring")
    x0, y0, x1, y1 = floor.bounds
    dx, dy = (x1 - x0) / 8, (y1 - y0) / 8
    corners = [(x0 + dx, y0 + dy), (x1 - dx, y0 + dy), (x1 - dx, y1 - dy), (x0 + dx, y1 - dy)]
    lap = np.array([*corners, corners[0]])
    schedule = Schedule(np.arange(5.0), lap[:, None], np.ones((4, 1), np.bool_))
    escape = verify_schedule(floor, schedule, (None,)).escape
    if escape is not None:
        save_way_past(floor, lap, escape.places, path, "ring: a lap, and an evader")


def _figure_3(path: Path) -> None:
    """Across the line of the wall before a reflex vertex, on its far side."""
    floor = load_floor_plan("spider:1,1,2")
    v = int(np.flatnonzero(floor.turns < 0)[0])
    corner, before = floor.vertices[v], floor.vertices[v - 1]
    along = (corner - before) / np.hypot(*(corner - before))
    side = np.array([-along[1], along[0]])
    apart = [corner + 0.35 * along + step * side for step in (0.15, -0.35)]
    places = [(float(x), float(y)) for x, y in apart]
    save_critical_event(floor, places, path, "spider:1,1,2: before and after")


def _figure_4(path: Path) -> None:
    problem = _problem("rooms:3")
    result = ClearKnownMap().solve(problem)
    legs = len(result.schedule.active)
    shown = sorted({round(step * (legs - 1) / 5) for step in range(6)})
    moments = [_moment(result, leg + 1, f"after {leg + 1} of {legs} drives") for leg in shown]
    save_moments(problem.floor, moments, path)


def _moment(result: PursuitResult, at: int, words: str) -> Moment:
    """What is so at one of a schedule's times."""
    positions = result.schedule.positions
    there = result.schedule.active[at - 1]
    return Moment(
        [(float(x), float(y)) for x, y in positions[at, there]],
        result.beliefs.get(at - 1, ()),
        [positions[at - 1 : at + 1, i] for i in np.flatnonzero(there).tolist()],
        words,
    )


def _figure_5(path: Path) -> None:
    floor = load_floor_plan("comb:2")
    mesh = triangulate(floor.vertices, floor.ring_starts)
    graph = known_navigation_graph(floor, mesh, [default_start(floor)])
    numbers = {tuple(point): v for v, point in enumerate(floor.vertices.tolist())}
    critical = np.flatnonzero(graph.critical).tolist()
    sight = VertexSight(mesh, tuple(numbers[graph.points[node]] for node in critical))
    pursuit = make_pursuit_graph(graph, label_all(graph, sight), [0], limit=1000)
    save_graphs(
        floor, graph, pursuit, path,
        "comb:2. N: clear, C: contaminated, a letter for each of S1, S2 ...; p: the start. "
        "Framed: final states.",
    )  # fmt: skip


def _wrong_claim(path: Path) -> None:
    problem = _problem("spider:2,2,2")
    result = SplittingByVertexLabels().solve(problem)
    escape = verify_schedule(problem.floor, result.schedule, (None,) * len(result.pursuers)).escape
    if escape is None:
        return
    with TemporaryDirectory() as folder:
        run = Path(folder) / "pursuit.mcap"
        record_pursuit(
            run, problem, result, method="splitting", settings={"labels": "paper"}, seed=0,
            compute_s=0.0,
        )  # fmt: skip
        read = read_run(run)
        assert isinstance(read, PursuitRun)
        save_pursuit_still(read, path, escape, max_pixels=800)


def _figures_8_and_9(parts: Path, guards: Path) -> None:
    problem = _problem("spider:2,2,2")
    result = Delegation(order="parallel").solve(problem)
    guard = _posts(result)[0][1]
    save_components(
        problem.floor, guard, _parts(problem.floor, guard), parts,
        "spider:2,2,2: a guard, and the parts beyond what it sees",
    )  # fmt: skip
    problem = _problem("triples:3")
    result = Delegation().solve(problem)
    moments = [
        _moment(result, at, f"{who} takes its post, {result.schedule.times[at]:.0f} s")
        for at, _, who in _posts(result)
    ]
    save_moments(problem.floor, moments, guards, columns=2)


def _posts(result: PursuitResult) -> list[tuple[int, tuple[float, float], str]]:
    """When guards took their posts, by number of the schedule's times, where, and who."""
    numbers = {one.name: i for i, one in enumerate(result.pursuers)}
    found: list[tuple[int, tuple[float, float], str]] = []
    for entry in result.history:
        if entry["what"] == "holds":
            at = int(np.searchsorted(result.schedule.times, float(entry["time_s"]) - 1e-9))
            x, y = result.schedule.positions[at, numbers[entry["pursuer"]]].tolist()
            found.append((at, (x, y), str(entry["pursuer"])))
    return found


def _parts(floor: PolygonMap, guard: tuple[float, float]) -> list[np.ndarray]:
    """The components of what a guard does not see, as rings; the floor has no holes."""
    mesh = triangulate(floor.vertices, floor.ring_starts)
    return [
        shapely.get_coordinates(part.exterior)
        for whole in shadow_polygons(ShadowMoves(mesh), (guard,))
        for part in shapely.get_parts(whole)
        if isinstance(part, shapely.Polygon)
    ]


def _plot_interleaving(path: Path, results: Results) -> None:
    compared = against_exploring_first([Cleared(**row) for row in results.rows(INTERLEAVING)])
    if not any(one.ratios for one in compared):
        return
    names = [str(one.edb) for one in compared]
    means = [
        ratio_of(own, [1.0] * len(own))
        for own in (
            [ratio for floor, ratio in one.ratios.items() if is_random(floor)] for one in compared
        )
    ]
    series = [
        Series(
            "random floors, mean", names, [one.value for one in means],
            [one.low for one in means], [one.high for one in means],
        )
    ]  # fmt: skip
    for floor in dict.fromkeys(floor for one in compared for floor in one.ratios):
        if floor in ("comb:6", "rooms:3", "spider:2,2,2", "streets:2"):
            own = [one.ratios.get(floor, float("nan")) for one in compared]
            series.append(Series(floor, names, own))
    bounded = all(np.isfinite([one.low, one.high]).all() for one in means)
    save_points(
        path, series if bounded else series[1:] or series, xlabel="exploration depth bound",
        ylabel="distance over that of exploring first",
        title="Does exploring and clearing in turn shorten the distance?",
        note="Bars: 95 % by Student, of geometric means. Below 1: shorter.",
    )  # fmt: skip


def _plot_graphs(path: Path, results: Results) -> None:
    series: list[Series] = []
    for kind in LABELS:
        rows = results.rows(GRAPHS, kind)
        split = [row for row in rows if was_split(row)]
        for what, own, name in (("whole", rows, "whole"), ("all parts", split, "parts_total")):
            if own:
                x, y = [row["vertices"] for row in own], [row[name] for row in own]
                series.append(Series(f"{kind}, {what}", x, y))
    if series:
        save_points(
            path, series, xlabel="critical vertices n", ylabel="states", log_y=True,
            title="Pursuit graphs of one pursuer", note="Graphs end at 20,000 states.",
        )  # fmt: skip


def _plot_messages(path: Path, results: Results) -> None:
    by_floor: dict[str, list[dict[str, Any]]] = {}
    for row in results.rows(MESSAGES):
        if row["messages"] and not is_random(row["floor"]):
            by_floor.setdefault(row["floor"], []).append(row)
    series = [
        Series(floor, [row["pursuers"] for row in own], [row["messages"] for row in own])
        for floor, own in by_floor.items()
    ]
    if series:
        save_points(
            path, series, xlabel="pursuers", ylabel="messages", log_x=True, log_y=True,
            connect=True, title="Messages of the delegation protocol",
        )  # fmt: skip


def _plot_teams(path: Path, results: Results) -> None:
    series: list[Series] = []
    for method in METHODS[:3]:
        rows = [
            row
            for row in results.rows(TEAMS, method)
            if row["verdict"] == "captured" and not is_random(row["floor"])
        ]
        if rows:
            x = [sqrt(row["holes"]) + log2(row["corners"]) for row in rows]
            series.append(Series(method, x, [row["pursuers"] for row in rows]))
    if series:
        save_points(
            path, series, xlabel="sqrt h + log2 n", ylabel="pursuers",
            title="Team sizes on made floors, captured by the verifier",
        )  # fmt: skip
