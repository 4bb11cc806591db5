"""Clearing known floors: team sizes known from elsewhere, plans confirmed by the verifier."""

from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest

from conav.errors import InputError
from conav.geometry.triangulation import triangulate
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.catalogue import make_method, settings_of
from conav.pursuit.clear_known_map import ClearKnownMap
from conav.pursuit.known_map import KnownMapSearch
from conav.pursuit.recorder import record_pursuit
from conav.pursuit.roadmap import make_roadmap
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult
from conav.pursuit.verify import verify_pursuit, verify_schedule
from conav.runs.reader import read_run
from conav.runs.types import PursuitRun

from .floors import LEFT_TO_RIGHT, ROOMS


def cleared(
    floor: PolygonMap,
    pursuers: int = 1,
    most: int | None = None,
    method: ClearKnownMap | None = None,
) -> PursuitResult:
    team = tuple(Pursuer(f"pursuer_{i}", default_start(floor)) for i in range(1, pursuers + 1))
    return (method or ClearKnownMap()).solve(PursuitProblem(floor, team, most=most))


def verdict(floor: PolygonMap, result: PursuitResult) -> str:
    return str(verify_schedule(floor, result.schedule, (None,) * len(result.pursuers)).verdict)


SPIDERS = list(product((1, 2), repeat=3))
GOLD = {
    "comb:6": 1,
    "rooms:3": 1,
    "ring": 2,
    "streets:2": 2,
    "triples:2": 2,
    **{f"spider:{a},{b},{c}": 1 if min(a, b, c) <= 1 else 2 for a, b, c in SPIDERS},
}
"""Floor -> the fewest pursuers, by exhaustive search elsewhere or by argument."""


@pytest.mark.parametrize(("name", "fewest"), GOLD.items())
def test_teams_are_as_small_as_they_can_be(name: str, fewest: int) -> None:
    floor = load_floor_plan(name)
    result = cleared(floor)
    assert result.status == "done"
    assert len(result.pursuers) == fewest
    assert verdict(floor, result) == "captured"
    assert result.minimal_proved
    assert result.lower_bound == fewest
    assert result.schedule.distance_m > 0


def test_where_everything_is_seen_nobody_moves() -> None:
    for outer in (
        [(0, 0), (4, 0), (4, 3), (0, 3)],
        [(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)],
    ):
        floor = PolygonMap(outer)
        team = (Pursuer("one", (0.5, 0.5)),)
        result = ClearKnownMap().solve(PursuitProblem(floor, team))
        assert result.status == "done"
        assert result.counters["moves"] == 0
        assert result.schedule.distance_m == 0.0
        assert verdict(floor, result) == "captured"


@pytest.mark.parametrize("name", ["ring", "spider:2,2,2"])
def test_too_few_pursuers_are_told(name: str) -> None:
    result = cleared(load_floor_plan(name), most=1)
    assert result.status == "infeasible"
    assert result.lower_bound == 2
    assert "1 pursuer cannot" in result.reason
    assert not result.minimal_proved
    assert cleared(load_floor_plan(name), most=2).status == "done"


def test_what_no_search_finds_is_not_called_impossible() -> None:
    larger = PolygonMap(load_floor_plan("triples:3").outer * 1.5)
    result = cleared(larger, most=2, method=ClearKnownMap(budget=2000))
    assert result.status == "out_of_budget"
    assert "2 pursuers" in result.reason
    assert result.lower_bound == 2


def test_nested_triples_are_infeasible_for_smaller_teams_by_theorem() -> None:
    floor = load_floor_plan("triples:3")
    result = cleared(floor, most=2, method=ClearKnownMap(budget=2000))
    assert result.status == "infeasible"
    assert "2 pursuers cannot" in result.reason
    assert result.lower_bound == 3
    enough = cleared(floor)
    assert (len(enough.pursuers), enough.lower_bound, enough.minimal_proved) == (3, 3, True)
    assert verdict(floor, enough) == "captured"


def test_a_team_larger_than_needed_is_used() -> None:
    floor = load_floor_plan("rooms:3")
    result = cleared(floor, pursuers=3, most=3)
    assert len(result.pursuers) == 3
    assert verdict(floor, result) == "captured"


def test_the_shortest_plan_is_no_longer_than_others() -> None:
    floor = load_floor_plan("rooms:3")
    shortest = cleared(floor, method=ClearKnownMap(weight=0.0, places="vertices"))
    quick = cleared(floor, method=ClearKnownMap(places="vertices"))
    assert shortest.schedule.distance_m <= quick.schedule.distance_m + 1e-9
    assert verdict(floor, shortest) == "captured"


def test_without_a_budget_guards_are_posted() -> None:
    floor = load_floor_plan("streets:3")
    result = cleared(floor, method=ClearKnownMap(budget=1))
    assert result.status == "done"
    assert len(result.pursuers) > 2
    assert verdict(floor, result) == "captured"


@pytest.mark.parametrize(
    "name", ["rooms:3", "ring", "streets:3", "corridor-tree:seed=3,segments=8"]
)
def test_driving_back_joins_the_same_shadows(name: str) -> None:
    floor = load_floor_plan(name)
    mesh = triangulate(floor.vertices, floor.ring_starts)
    roadmap = make_roadmap(floor, mesh, [default_start(floor)], middles=True)
    rng = np.random.default_rng(0)
    moves = ShadowMoves(mesh, halvings=0)
    for _ in range(12):
        a, other = rng.integers(len(roadmap.points), size=2).tolist()
        b = int(rng.choice(roadmap.joined[a]))
        points = roadmap.points
        there = moves.move((points[other],), points[a], points[b])
        back = moves.move((points[other],), points[b], points[a])
        assert all(
            bool(row >> j & 1) == bool(back[j] >> i & 1)
            for i, row in enumerate(there)
            for j in range(len(back))
        )


@pytest.mark.parametrize("name", ["rooms:3", "ring", "streets:3"])
def test_halves_tell_no_less(name: str) -> None:
    floor = load_floor_plan(name)
    mesh = triangulate(floor.vertices, floor.ring_starts)
    roadmap = make_roadmap(floor, mesh, [default_start(floor)], middles=True)
    rng = np.random.default_rng(1)
    coarse, fine = ShadowMoves(mesh, halvings=0), ShadowMoves(mesh, halvings=3)
    for _ in range(12):
        a, other = (roadmap.points[i] for i in rng.integers(len(roadmap.points), size=2).tolist())
        b = roadmap.points[int(rng.choice(roadmap.joined[roadmap.points.index(a)]))]
        rows, finer = coarse.move((other,), a, b), fine.move((other,), a, b)
        assert all(less & row == less for row, less in zip(rows, finer, strict=True))


def test_standing_still_changes_nothing() -> None:
    floor = load_floor_plan("rooms:3")
    mesh = triangulate(floor.vertices, floor.ring_starts)
    moves = ShadowMoves(mesh)
    rows = moves.move((), (5.0, 6.0), (5.0, 6.0))
    assert rows == [1 << i for i in range(moves.shadows(((5.0, 6.0),)).count)]
    assert moves.after((), (5.0, 6.0), (5.0, 6.0), 0b1) == 0b1


def test_the_notes_of_a_known_plan() -> None:
    """The corridor with three rooms from left to right; the way round leaves somebody."""
    mesh = triangulate(ROOMS.vertices, ROOMS.ring_starts)

    def after(way: list[tuple[float, float]]) -> int:
        moves = ShadowMoves(mesh)
        dirty = (1 << moves.shadows((way[0],)).count) - 1
        for a, b in pairwise(way):
            dirty = moves.after((), a, b, dirty)
        return dirty

    way = [(float(x), float(y)) for x, y in LEFT_TO_RIGHT]
    assert after(way) == 0
    assert after([*way[:2], (25.0, 1.5), (25.0, 6.0)]) != 0  # the middle room is left out


def test_the_run_is_accepted_and_beliefs_are_true(tmp_path: Path) -> None:
    for name in ("rooms:3", "ring", "spider:2,2,2"):
        floor = load_floor_plan(name)
        result = cleared(floor)
        file = tmp_path / "run.mcap"
        problem = PursuitProblem(floor, result.pursuers)
        record_pursuit(
            file, problem, result, method="known-map", settings={}, seed=0, compute_s=0.0
        )
        run = read_run(file)
        assert isinstance(run, PursuitRun)
        report = verify_pursuit(run)
        assert report.accepted, report.lines()
        assert len(result.beliefs) == len(result.schedule.active) > 0


def test_the_same_plan_every_time() -> None:
    floor = load_floor_plan("spider:2,2,2")
    one, two = cleared(floor), cleared(floor)
    assert np.array_equal(one.schedule.positions, two.schedule.positions)
    assert one.counters == two.counters


def test_what_the_method_is_not_for() -> None:
    floor = load_floor_plan("ring")
    for pursuer, words in (
        (Pursuer("far", (1.0, 1.0), range_m=2.0), "limited range or reach"),
        (Pursuer("off", (-5.0, 1.0)), "off the floor"),
    ):
        with pytest.raises(InputError, match=words):
            ClearKnownMap().solve(PursuitProblem(floor, (pursuer,)))
    with pytest.raises(InputError, match="not known"):
        ClearKnownMap().solve(PursuitProblem(floor, (Pursuer("one", (1.0, 1.0)),), known=False))


def test_progress_may_end_it() -> None:
    floor = load_floor_plan("spider:2,2,2")
    team = (Pursuer("one", default_start(floor)),)
    told: list[tuple[int, int]] = []

    def stop(size: int, expanded: int) -> bool:
        told.append((size, expanded))
        return False

    result = ClearKnownMap().solve(PursuitProblem(floor, team), stop)
    assert result.status == "out_of_budget"
    assert result.reason == "it was stopped"
    assert told == [(1, 0)]


def test_settings() -> None:
    method = make_method(settings={"weight": "0", "budget": "7"})
    assert settings_of(method) == {"places": "auto", "weight": 0.0, "budget": 7, "together": False}
    for bad, words in (
        ({"wieght": 1}, "did you mean weight"),
        ({"budget": 0}, "1 or more"),
        ({"places": "some"}, "places"),
        ({"weight": -1}, "0 or more"),
    ):
        with pytest.raises(InputError, match=words):
            make_method(settings=bad)


def test_searches_that_end_say_so() -> None:
    floor = load_floor_plan("ring")
    mesh = triangulate(floor.vertices, floor.ring_starts)
    roadmap = make_roadmap(floor, mesh, [default_start(floor)], middles=False)
    found = KnownMapSearch(ShadowMoves(mesh), roadmap).clear([0], weight=3.0, budget=1000)
    assert found.moves is None
    assert found.exhausted
    assert not KnownMapSearch(ShadowMoves(mesh), roadmap).clear([0], weight=3.0, budget=2).exhausted
