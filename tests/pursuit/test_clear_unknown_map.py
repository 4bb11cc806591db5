"""Floors nobody gave the team: what is sensed, what follows from it, and who is captured."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.geometry.triangulation import triangulate
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.catalogue import make_method, settings_of
from conav.pursuit.clear_unknown_map import ClearUnknownMap
from conav.pursuit.navigation_graph import NavigationGraph, surveyed_navigation_graph
from conav.pursuit.recorder import record_pursuit
from conav.pursuit.roadmap import Roadmap, make_roadmap
from conav.pursuit.sensor import Sensor
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.starts import default_start
from conav.pursuit.survey import Survey, begin_survey
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult
from conav.pursuit.verify import PursuitReport, verify_pursuit, verify_schedule
from conav.runs.reader import read_pursuit

from .floors import ROOMS, block_floor

Point = tuple[float, float]


def explored(floor: PolygonMap, start: Point, rng: np.random.Generator) -> list[Survey]:
    """Surveys of an exploration in random order, until nothing is left."""
    sensor = Sensor(floor)
    surveys = [begin_survey(sensor.look(start))]
    while not surveys[-1].complete:
        targets = surveys[-1].unexplored()
        assert targets
        place = targets[int(rng.integers(len(targets)))]
        assert place not in surveys[-1].visited
        surveys.append(surveys[-1].add(sensor.look(place)))
    return surveys


def somewhere(floor: PolygonMap, rng: np.random.Generator, on_half_units: bool) -> Point:
    x0, y0, x1, y1 = floor.bounds
    while True:
        x, y = rng.uniform((x0, y0), (x1, y1)).tolist()
        if on_half_units:
            x, y = round(2 * x) / 2, round(2 * y) / 2
        if floor.contains((x, y)):
            return x, y


def edges(graph: Roadmap | NavigationGraph) -> set[frozenset[Point]]:
    return {
        frozenset((graph.points[i], graph.points[j]))
        for i, row in enumerate(graph.joined)
        for j in row.tolist()
    }


@settings(max_examples=40)
@given(st.integers(0, 10**6), st.sampled_from([0.0, 0.03]), st.booleans())
def test_once_all_is_explored_the_graph_is_that_of_the_plan(
    seed: int, jitter: float, on_half_units: bool
) -> None:
    rng = np.random.default_rng(seed)
    floor = block_floor(rng, 5, jitter)
    start = somewhere(floor, rng, on_half_units)
    surveys = explored(floor, start, rng)
    last = surveys[-1]
    assert shapely.equals(last.known.polygon, floor.polygon)
    assert set(map(tuple, last.known.vertices.tolist())) == set(map(tuple, floor.vertices.tolist()))
    plan = make_roadmap(
        floor, triangulate(floor.vertices, floor.ring_starts), [start], middles=False
    )
    graph = surveyed_navigation_graph(last, [start])
    if (floor.turns < 0).any():
        assert set(graph.points) == set(plan.points)
        assert edges(graph) == edges(plan)
    for survey, later in pairwise(surveys):
        # Nothing is known that is not so, nothing is forgotten, nobody sees through a frontier.
        for smaller, larger in ((survey.known, later.known), (later.known, floor)):
            assert shapely.area(shapely.difference(smaller.polygon, larger.polygon)) < 1e-6
        assert set(survey.critical) <= set(later.critical) <= set(last.critical)
        assert set(survey.visited) < set(later.visited)
        assert edges(surveyed_navigation_graph(survey, [start])) <= edges(graph)


def test_the_first_look_by_hand() -> None:
    """From the middle of the corridor: of the left room what the door shows, and two windows."""
    survey = begin_survey(Sensor(ROOMS).look((5.0, 1.0)))
    assert not survey.complete
    doors = [(4.0, 3.0), (4.0, 5.0), (6.0, 3.0), (6.0, 5.0), (13.0, 0.0), (15.0, 0.0)]
    assert survey.critical == (*doors, (24.0, 3.0), (26.0, 3.0))
    near = {point for segment in survey.frontier_segments.tolist() for point in map(tuple, segment)}
    assert {(4.0, 5.0), (6.0, 5.0), (13.0, 0.0), (24.0, 3.0)} <= near
    # From (5, 1) through the door's upper corners: to the back wall at 11 m.
    assert {(2.5, 11.0), (7.5, 11.0)} <= near
    assert survey.unexplored() == ((4.0, 5.0), (6.0, 5.0), (13.0, 0.0), (24.0, 3.0))
    graph = surveyed_navigation_graph(survey, [(5.0, 1.0)])
    end = graph.points.index((24.0, 3.0))
    assert graph.distances[0, end] == pytest.approx((19.0**2 + 2.0**2) ** 0.5)
    assert graph.way(0, end) == [0, end]
    assert graph.visited.tolist() == [True] + 8 * [False]
    assert graph.critical.tolist() == [False] + 8 * [True]
    assert frozenset(((4.0, 5.0), (24.0, 3.0))) not in edges(graph)


def test_what_lies_beyond_a_frontier_stays_contaminated() -> None:
    """A corridor with an arm that nobody has looked into."""
    corner = PolygonMap([(0, 0), (6, 0), (6, 4), (5, 4), (5, 1), (0, 1)])
    survey = begin_survey(Sensor(corner).look((0.5, 0.5)))
    moves = ShadowMoves(survey.mesh, frontiers=survey.frontiers)
    shadows = moves.shadows(((0.5, 0.5),))
    # All that is known is seen, but for a sliver that rounding leaves at the frontier.
    assert sum(shadows.areas) == pytest.approx(0.0)
    assert shadows.exposed == (1 << len(shadows.areas)) - 1
    everything = (1 << shadows.count) - 1
    after = moves.shadows(((5.0, 1.0),))
    assert moves.after((), (0.5, 0.5), (5.0, 1.0), everything) == (1 << after.count) - 1
    assert after.beyond == 1
    # The same on a floor whose arm was seen and cleared: nothing is contaminated any more.
    known = ShadowMoves(triangulate(corner.vertices, corner.ring_starts))
    assert known.after((), (0.5, 0.5), (5.0, 1.0), 1) == 0


def cleared(
    floor: PolygonMap, method: ClearUnknownMap, pursuers: int = 1, most: int | None = None
) -> PursuitResult:
    team = tuple(Pursuer(f"pursuer_{i}", default_start(floor)) for i in range(1, pursuers + 1))
    return method.solve(PursuitProblem(floor, team, known=False, most=most))


def report_of(floor: PolygonMap, result: PursuitResult, file: Path) -> PursuitReport:
    problem = PursuitProblem(floor, result.pursuers[:1], known=False)
    record_pursuit(file, problem, result, method="unknown-map", settings={}, seed=0, compute_s=0.0)
    return verify_pursuit(read_pursuit(file))


GOLD = {"comb:1": 1, "comb:4": 1, "rooms:1": 1, "rooms:3": 1, "spider:1,2,2": 1, "ring": 2,
        "streets:2": 2, "spider:2,2,2": 2, "corridor-tree:seed=1,segments=16": 1}  # fmt: skip
"""Floor -> the fewest pursuers that can clear it, known."""


@pytest.mark.parametrize(("name", "fewest"), GOLD.items())
def test_gold_floors_are_captured_and_beliefs_are_true(
    name: str, fewest: int, tmp_path: Path
) -> None:
    floor = load_floor_plan(name)
    for edb in (1, 3, "unlimited"):
        result = cleared(floor, ClearUnknownMap(edb=edb))
        assert result.status == "done"
        assert len(result.pursuers) >= fewest
        assert result.explored == pytest.approx(1.0)
        report = report_of(floor, result, tmp_path / "run.mcap")
        assert report.accepted, report.lines()
        assert str(report.found.verdict) == "captured"
        # After every leg the team's belief was compared with the verifier's truth.
        beliefs = next(check for check in report.checks if check.name == "beliefs")
        assert beliefs.looked == len(result.schedule.active) + 1
        assert report.open_beliefs == 0


@settings(max_examples=12)
@given(st.integers(0, 10**6), st.sampled_from([1, 2, "unlimited"]), st.integers(1, 2))
def test_random_floors_are_captured_and_beliefs_are_true(
    tmp_path_factory: pytest.TempPathFactory, seed: int, edb: int, pursuers: int
) -> None:
    rng = np.random.default_rng(seed)
    floor = block_floor(rng, 5, 0.02 if seed % 2 else 0.0)
    start = somewhere(floor, rng, on_half_units=seed % 3 == 0)
    team = tuple(Pursuer(f"p{i}", start) for i in range(pursuers))
    method = ClearUnknownMap(edb=edb, budget=200, partial_budget=100)
    result = method.solve(PursuitProblem(floor, team, known=False))
    assert result.status == "done"
    report = report_of(floor, result, tmp_path_factory.mktemp("run") / "run.mcap")
    assert report.accepted, report.lines()
    assert str(report.found.verdict) == "captured"


def test_what_nobody_has_seen_decides_nothing() -> None:
    """Two floors that differ in the right room alone: the same drives until somebody sees it."""
    changed = ROOMS.outer.copy()
    changed[(changed == (29.0, 11.0)).all(axis=1)] = (29.0, 10.0)
    other = PolygonMap(changed)
    for edb in (1, 2, "unlimited"):
        method = ClearUnknownMap(edb=edb)
        runs = [
            method.solve(PursuitProblem(floor, (Pursuer("p", (5.0, 1.0)),), known=False))
            for floor in (ROOMS, other)
        ]
        ways = [[tuple(at) for at in run.schedule.positions[:, 0].tolist()] for run in runs]
        mesh = triangulate(ROOMS.vertices, ROOMS.ring_starts)
        moves = ShadowMoves(mesh)
        first = next(
            k
            for k, place in enumerate(ways[0])
            if shapely.Polygon(moves.view(place).corners).intersects(shapely.box(24, 8, 29, 11))
        )
        assert 0 < first < len(ways[0]) - 1
        assert ways[0][: first + 1] == ways[1][: first + 1]


def test_careful_exploration_keeps_what_is_clear() -> None:
    floor = load_floor_plan("rooms:3")
    careful = cleared(floor, ClearUnknownMap(edb=5))
    nearest = cleared(floor, ClearUnknownMap(edb="unlimited"))
    assert careful.schedule.distance_m < nearest.schedule.distance_m
    assert (careful.recontaminations or 0) < (nearest.recontaminations or 0)
    # Without care and with no vertices left to pursue after, both are the same.
    plain = cleared(floor, ClearUnknownMap(edb=5, care=0.0))
    assert np.array_equal(plain.schedule.positions, nearest.schedule.positions)


def test_newcomers_enter_where_the_first_did() -> None:
    floor = load_floor_plan("spider:2,2,2")
    result = cleared(floor, ClearUnknownMap())
    assert len(result.pursuers) == 2
    active = result.schedule.active
    enters = int(np.flatnonzero(active[:, 1])[0])
    assert 0 < enters < len(active)
    assert active[:, 0].all()
    assert active[enters:, 1].all()
    assert result.history[-1]["what"] == "enters"
    assert result.schedule.positions[enters, 1].tolist() == list(default_start(floor))


def test_too_few_pursuers_are_told() -> None:
    floor = load_floor_plan("ring")
    result = cleared(floor, ClearUnknownMap(), most=1)
    assert result.status == "out_of_budget"
    assert "1 pursuer was found" in result.reason
    assert result.explored == pytest.approx(1.0)
    assert len(result.schedule.active) > 0


def test_without_a_budget_guards_are_posted() -> None:
    floor = load_floor_plan("rooms:3")
    result = cleared(floor, ClearUnknownMap(edb="unlimited", budget=1))
    assert result.status == "done"
    assert len(result.pursuers) > 1
    found = verify_schedule(floor, result.schedule, (None,) * len(result.pursuers))
    assert str(found.verdict) == "captured"


def test_where_everything_is_seen_nobody_moves(tmp_path: Path) -> None:
    floor = PolygonMap([(0, 0), (4, 0), (4, 3), (0, 3)])
    result = cleared(floor, ClearUnknownMap())
    assert result.status == "done"
    assert result.counters["moves"] == 0
    assert report_of(floor, result, tmp_path / "run.mcap").accepted


def test_the_same_run_every_time() -> None:
    floor = load_floor_plan("spider:1,2,2")
    one, two = (cleared(floor, ClearUnknownMap()) for _ in range(2))
    assert np.array_equal(one.schedule.positions, two.schedule.positions)
    assert one.counters == two.counters


def test_progress_may_end_it() -> None:
    floor = load_floor_plan("ring")
    team = (Pursuer("p", default_start(floor)),)
    problem = PursuitProblem(floor, team, known=False)
    result = ClearUnknownMap().solve(problem, lambda size, expanded: False)
    assert result.status == "out_of_budget"
    assert result.reason == "it was stopped"


def test_what_the_method_is_not_for() -> None:
    floor = load_floor_plan("ring")
    for pursuer, words in (
        (Pursuer("far", (1.0, 1.0), range_m=2.0), "limited range or reach"),
        (Pursuer("off", (-5.0, 1.0)), "off the floor"),
    ):
        with pytest.raises(InputError, match=words):
            ClearUnknownMap().solve(PursuitProblem(floor, (pursuer,), known=False))


def test_settings() -> None:
    for text, edb in (("2", 2), ("unlimited", "unlimited")):
        method = make_method("unknown-map", settings={"edb": text, "care": "0"})
        assert settings_of(method)["edb"] == edb
    for bad, words in (
        ({"edb": "0"}, "1 or more, or unlimited"),
        ({"edb": "some"}, "setting 'edb'"),
        ({"care": -1}, "0 or more"),
        ({"partial_budget": 0}, "1 or more"),
        ({"ebd": 1}, "did you mean edb"),
    ):
        with pytest.raises(InputError, match=words):
            make_method("unknown-map", settings=bad)


def test_the_page_names_all_settings_with_their_defaults() -> None:
    page = (Path(__file__).parents[2] / "docs" / "pursuit-unknown.md").read_text()
    rows = re.findall(r"^\| `(\w+)` \| (\w+) \|", page, re.MULTILINE)
    defaults = settings_of(ClearUnknownMap())
    assert dict(rows) == {name: f"{value:g}" if isinstance(value, float) else str(value)
                          for name, value in defaults.items()}  # fmt: skip
