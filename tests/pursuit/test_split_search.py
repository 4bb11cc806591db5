"""Guards that part a floor, and one searcher in a part."""

import numpy as np
import pytest

from conav.geometry.triangulation import triangulate
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.bounds import least_pursuers
from conav.pursuit.drives import moves_of
from conav.pursuit.lone_search import components, left_of, search_alone
from conav.pursuit.roadmap import make_roadmap
from conav.pursuit.schedule import schedule_of
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.split_search import SplitSearch
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer
from conav.pursuit.verify import verify_schedule


def search_of(name: str) -> tuple[PolygonMap, SplitSearch]:
    floor = load_floor_plan(name)
    mesh = triangulate(floor.vertices, floor.ring_starts)
    roadmap = make_roadmap(floor, mesh, [default_start(floor)], middles=False)
    return floor, SplitSearch(ShadowMoves(mesh), roadmap, 3.0)


@pytest.mark.parametrize(
    ("name", "size"), [("comb:4", 1), ("spider:2,2,2", 2), ("triples:3", 3), ("streets:3", 2)]
)
def test_guards_and_a_searcher_clear_floors(name: str, size: int) -> None:
    floor, search = search_of(name)
    drives = search.clear(size, breadth=8, each=500, budget=10**6)
    assert drives is not None
    assert max(who for who, _ in drives) < size
    team = [Pursuer(f"p{i}", default_start(floor)) for i in range(size)]
    moves = moves_of(search.roadmap, [0] * size, drives)
    assert moves is not None
    schedule = schedule_of(team, search.roadmap.points, moves)
    assert verify_schedule(floor, schedule, (None,) * size).verdict == "captured"
    if size > 1:
        assert search.clear(size - 1, breadth=8, each=500, budget=10**6) is None


def test_a_budget_ends_it() -> None:
    _, search = search_of("triples:3")
    assert search.clear(3, breadth=8, each=500, budget=1) is None
    assert search.ended
    assert search.clear(3, breadth=8, each=500, budget=10**6) is not None
    assert not search.ended


def test_parts_of_parts() -> None:
    """A guard in the middle of a spider leaves its three arms, and a second one parts an arm."""
    _, search = search_of("spider:2,2,2")
    moves = search.moves
    middle = moves.number((0.0, 0.0))
    arms = components(moves, (middle,))
    assert len(arms) == 3
    whole = components(moves, ())
    assert [one.guards for one in whole] == [()]
    bits, area = left_of(moves, whole[0], middle)
    assert bits == 0b111
    assert area == pytest.approx(sum(arm.area for arm in arms))
    numbers = [moves.number(point) for point in search.roadmap.points]
    for arm in arms:
        found = search_alone(
            moves, search.roadmap, numbers, arm, weight=3.0, most=100, windows=10**5
        )
        assert found.way is not None
        assert left_of(moves, arm, numbers[found.way[0]])[1] < arm.area


def test_holes_that_need_two() -> None:
    assert least_pursuers(load_floor_plan("comb:3")) == 1
    assert least_pursuers(load_floor_plan("ring")) == 2
    u_shape = [(3, 3), (3, 7), (4, 7), (4, 4), (6, 4), (6, 7), (7, 7), (7, 3)]
    around = PolygonMap([(0, 0), (10, 0), (10, 10), (0, 10)], [u_shape])
    assert least_pursuers(around) == 1  # not proved


def test_nested_triples_need_as_many_as_they_are_deep() -> None:
    for depth in (1, 2, 3):
        outer = load_floor_plan(f"triples:{depth}").outer
        assert least_pursuers(PolygonMap(outer)) == depth
        # Whichever corner comes first.
        assert least_pursuers(PolygonMap(np.roll(outer, 3, axis=0))) == depth
        if depth > 1:
            # The theorem is about these corners and no others.
            moved = outer.copy()
            moved[0] += 0.01
            assert least_pursuers(PolygonMap(moved)) == 1
