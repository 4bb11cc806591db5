"""Splitting: parts are what guards leave, plans end and capture; the paper's lose regions."""

from collections.abc import Sequence

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.geometry.triangulation import triangulate
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.beliefs import hidden_now
from conav.pursuit.bounds import least_pursuers
from conav.pursuit.catalogue import make_method
from conav.pursuit.navigation_graph import known_navigation_graph
from conav.pursuit.shadow_moves import Point, ShadowMoves
from conav.pursuit.split_tree import Guarded, Sweep, in_parallel, in_sequence, posts, sweeps
from conav.pursuit.splitting import Splitting, SplittingByVertexLabels
from conav.pursuit.standing_guards import StandingGuards
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult
from conav.pursuit.verify import verify_schedule

from .floors import NINE, ROOMS, block_floor


def solved(floor: PolygonMap, method: object, most: int | None = None) -> PursuitResult:
    team = (Pursuer("pursuer_1", default_start(floor)),)
    return method.solve(PursuitProblem(floor, team, most=most))  # type: ignore[attr-defined]


def verdict(floor: PolygonMap, result: PursuitResult) -> str:
    return str(verify_schedule(floor, result.schedule, (None,) * len(result.pursuers)).verdict)


def guards_on(floor: PolygonMap) -> StandingGuards:
    mesh = triangulate(floor.vertices, floor.ring_starts)
    graph = known_navigation_graph(floor, mesh, [default_start(floor)])
    return StandingGuards(ShadowMoves(mesh), graph)


def contaminated(guards: StandingGuards, team: Sequence[Point], chosen: int) -> shapely.Geometry:
    regions = hidden_now(guards.shadows, tuple(team), chosen)
    return shapely.union_all([shapely.Polygon(r.outer, r.holes) for r in regions if not r.clear])


# --- what standing guards cut a floor into --------------------------------------------------------


@pytest.mark.parametrize("name", ["rooms:3", "ring", "streets:2", "triples:2"])
def test_places_are_those_in_the_closure_of_shadows(name: str) -> None:
    floor = load_floor_plan(name)
    guards = guards_on(floor)
    points = guards.graph.points
    rng = np.random.default_rng(5)
    for count in (1, 1, 2):
        team = [points[i] for i in rng.choice(len(points), count, replace=False)]
        for number in range(guards.everything(team).bit_length()):
            region = contaminated(guards, team, 1 << number)
            near = [
                i
                for i in range(len(points))
                if guards.graph.critical[i]
                and shapely.distance(region, shapely.Point(points[i])) < 1e-7
            ]
            found = [i for i in guards.places(team, 1 << number) if guards.graph.critical[i]]
            assert found == near


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_guards_who_come_and_go_carry_contamination(seed: int) -> None:
    """What is hidden before and after stays what it is, and nothing else is contaminated."""
    rng = np.random.default_rng(seed)
    guards = guards_on(block_floor(rng, 4, 0.05))
    points = guards.graph.points
    before, after = (
        [points[i] for i in rng.choice(len(points), int(rng.integers(3)), replace=False)]
        for _ in range(2)
    )
    chosen = int(rng.integers(0, 2**62)) & guards.everything(before)
    old = contaminated(guards, before, chosen)
    new = contaminated(guards, after, guards.carried(before, after, chosen))
    hidden_after = contaminated(guards, after, guards.everything(after))
    assert shapely.area(shapely.difference(shapely.intersection(old, hidden_after), new)) < 1e-9
    for region in shapely.get_parts(new):
        assert shapely.area(region) < 1e-9 or shapely.area(shapely.intersection(region, old)) > 0
    assert guards.carried(before, before, chosen) == chosen


def test_a_shadow_between_windows_has_no_place_and_is_seen_from_others() -> None:
    """Three guards see all walls of this floor, and not a triangle in its middle."""
    guards = guards_on(NINE)
    team = [(-5.0, 0.0), (4.5, -4.3301), (3.5, 6.0622)]
    assert guards.everything(team) == 1
    assert guards.area(team, 1) == pytest.approx(1.732, abs=1e-3)
    places = guards.places(team, 1)
    assert places
    for place in places:
        after = [*team, guards.graph.points[place]]
        assert guards.area(after, guards.carried(team, after, 1)) < 1.732


def test_nobody_guards_the_whole_floor() -> None:
    floor = load_floor_plan("ring")
    guards = guards_on(floor)
    assert guards.everything(()) == 1
    assert guards.area((), 1) == pytest.approx(floor.area)
    assert guards.places((), 1) == list(range(len(guards.graph.points)))


# --- splitting by geometry ------------------------------------------------------------------------

GOLD = {
    # floor: pursuers in sequence, pursuers in parallel
    "comb:6": (1, 1),
    "rooms:3": (1, 1),
    "ring": (2, 2),
    "streets:2": (2, 2),
    "spider:2,2,2": (2, 4),
    "triples:2": (2, 4),
}


@pytest.mark.parametrize(("name", "sizes"), GOLD.items())
def test_plans_capture(name: str, sizes: tuple[int, int]) -> None:
    floor = load_floor_plan(name)
    for cut in ("geometry", "degree", "stuck"):
        times: list[float] = []
        for order, size in zip(("sequence", "parallel"), sizes, strict=True):
            result = solved(floor, make_method("splitting", settings={"cut": cut, "order": order}))
            assert result.status == "done"
            assert len(result.pursuers) == size
            assert result.lower_bound == least_pursuers(floor)
            assert result.minimal_proved == (size == result.lower_bound)
            assert verdict(floor, result) == "captured"
            times.append(float(result.schedule.times[-1]))
        assert times[1] <= times[0] + 1e-9


def test_three_pursuers_clear_three_copies_of_three() -> None:
    floor = load_floor_plan("triples:3")
    result = solved(floor, Splitting())
    assert len(result.pursuers) == 3
    assert verdict(floor, result) == "captured"
    assert result.counters["largest"] < result.counters["states"] < 1000


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), order=st.sampled_from(["sequence", "parallel"]))
def test_it_always_ends_and_is_right(seed: int, order: str) -> None:
    """One state for each part: whatever is not seen at once is split."""
    floor = block_floor(np.random.default_rng(seed), 4, 0.05)
    method = make_method("splitting", settings={"budget": 1, "order": order})
    result = solved(floor, method)
    assert result.status == "done"
    assert verdict(floor, result) != "escapes"
    again = solved(floor, method)
    assert np.array_equal(again.schedule.positions, result.schedule.positions)


def test_a_team_that_may_not_grow() -> None:
    floor = load_floor_plan("spider:2,2,2")
    result = solved(floor, Splitting(order="parallel"), most=3)
    assert result.status == "out_of_budget"
    assert "takes 4 pursuers at once" in result.reason
    assert solved(floor, Splitting(), most=2).status == "done"
    told: list[int] = []

    def stop(size: int, count: int) -> bool:
        told.append(size)
        return False

    problem = PursuitProblem(floor, (Pursuer("one", default_start(floor)),))
    for method in (Splitting(), SplittingByVertexLabels()):
        assert method.solve(problem, stop).reason == "it was stopped"
    assert told == [1, 1]


def test_trees_are_counted() -> None:
    one = Sweep(3, (), (1,))
    plan = Guarded(1, (one, Guarded(2, (one, one)), Guarded(4, ())))
    assert in_sequence(plan) == 3
    assert in_parallel(plan) == 1 + 1 + 3 + 1
    assert list(posts(plan)) == [1, 2, 4]
    assert len(list(sweeps(plan))) == 3


# --- the paper's splitting ------------------------------------------------------------------------


@pytest.mark.parametrize("cut", ["degree", "stuck"])
def test_a_split_graph_loses_regions(cut: str) -> None:
    """Three rooms: the parts of the graph are cleared, two regions of the floor are not."""
    claimed = solved(ROOMS, make_method("splitting", "paper", {"cut": cut}))
    assert claimed.status == "done"
    assert len(claimed.pursuers) == 2
    assert verdict(ROOMS, claimed) == "escapes"
    # A guard does not take nodes from the graph that nobody visited (section 4): nothing is lost.
    careful = solved(ROOMS, make_method("splitting", "paper", {"cut": cut, "removed": "visited"}))
    assert verdict(ROOMS, careful) == "captured"
    assert len(careful.pursuers) > 2
    sound = solved(ROOMS, make_method("splitting", settings={"cut": cut}))
    assert verdict(ROOMS, sound) == "captured"
    assert len(sound.pursuers) == 1


def test_the_papers_team_at_once() -> None:
    claimed = solved(ROOMS, SplittingByVertexLabels(order="parallel", paths="hidden"))
    assert len(claimed.pursuers) == 3
    assert verdict(ROOMS, claimed) == "escapes"


def test_methods_by_name() -> None:
    assert make_method("splitting", settings={"cut": "stuck"}) == Splitting(cut="stuck")
    made = make_method("splitting", "paper", {"removed": "visited", "limit": "7"})
    assert made == SplittingByVertexLabels(removed="visited", limit=7)
    with pytest.raises(ValueError, match="1 or more"):
        Splitting(budget=0)
    with pytest.raises(ValueError, match="1 or more"):
        SplittingByVertexLabels(limit=0)
    with pytest.raises(ValueError, match="0 or more"):
        Splitting(weight=-1.0)
    with pytest.raises(ValueError, match="0 or more"):
        Splitting(halvings=-1)


def test_halves_need_no_larger_teams() -> None:
    floor = load_floor_plan("corridor-tree:seed=3,segments=20")
    coarse, fine = solved(floor, Splitting()), solved(floor, Splitting(halvings=3))
    assert verdict(floor, coarse) == verdict(floor, fine) == "captured"
    assert len(coarse.pursuers) == len(fine.pursuers)
    # They tell more, so less is looked at.
    assert fine.counters["states"] < coarse.counters["states"]
