"""Whether one pursuer suffices: against floors decided elsewhere, the search, and the verifier."""

from itertools import product

import numpy as np
import pytest

from conav.geometry.critical_cells import critical_cells
from conav.geometry.triangulation import triangulate
from conav.geometry.visibility import find_windows, visibility_polygon
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap, without_collinear_points
from conav.pursuit.one_pursuer import Decision, decide_one_pursuer
from conav.pursuit.roadmap import make_roadmap
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.split_search import SplitSearch
from conav.pursuit.starts import default_start
from conav.pursuit.types import Schedule
from conav.pursuit.verify import verify_schedule

from .floors import ROOMS, block_floor


def walked(floor: PolygonMap, decision: Decision) -> str:
    """What the verifier says of a decision's way."""
    positions = np.array(decision.way)[:, None, :]
    n = len(positions) - 1
    walk = Schedule(np.arange(n + 1.0), positions, np.ones((n, 1), np.bool_))
    return str(verify_schedule(floor, walk, (None,)).verdict)


def jittered(name: str, seed: int, size: float) -> PolygonMap:
    outer = load_floor_plan(name).outer
    return PolygonMap(outer + np.random.default_rng(seed).normal(0.0, size, outer.shape))


@pytest.mark.parametrize("bends", list(product((1, 2), repeat=3)))
def test_spiders_need_one_where_an_arm_has_at_most_one_bend(bends: tuple[int, ...]) -> None:
    name = "spider:" + ",".join(map(str, bends))
    decision = decide_one_pursuer(load_floor_plan(name))
    assert decision.suffices == (min(bends) <= 1)
    # In general position every way counts.
    moved = jittered(name, 1, 0.01)
    decision = decide_one_pursuer(moved)
    assert decision.suffices == (min(bends) <= 1)
    if decision.suffices:
        assert decision.exact
        assert walked(moved, decision) == "captured"


@pytest.mark.parametrize(("name", "suffices"), [("comb:5", True), ("triples:3", False)])
def test_families(name: str, suffices: bool) -> None:
    assert decide_one_pursuer(load_floor_plan(name)).suffices == suffices


def test_floors_seen_from_one_point() -> None:
    square = PolygonMap([(0, 0), (4, 0), (4, 3), (0, 3)])
    assert decide_one_pursuer(square).suffices
    corner = PolygonMap([(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)])
    decision = decide_one_pursuer(corner)
    assert decision.suffices
    assert corner.contains([decision.way[-1]])


def test_floors_with_holes_are_not_decided() -> None:
    assert decide_one_pursuer(load_floor_plan("ring")).suffices is None


def test_few_states_decide_nothing() -> None:
    assert decide_one_pursuer(load_floor_plan("spider:2,2,2"), most_states=5).suffices is None


def test_no_search_finds_what_is_excluded() -> None:
    """Random floors in general position: ways are confirmed, and nothing is found where none is."""
    seen = {True: 0, False: 0}
    for seed in (3, 11, *range(55, 70)):
        name = f"corridor-tree:segments={8 + seed % 16},seed={seed}"
        floor = jittered(name, seed, 0.03)
        decision = decide_one_pursuer(floor)
        assert decision.suffices is not None
        assert decision.exact
        seen[decision.suffices] += 1
        if decision.suffices:
            assert walked(floor, decision) == "captured"
        else:
            mesh = triangulate(floor.vertices, floor.ring_starts)
            roadmap = make_roadmap(floor, mesh, [default_start(floor)], middles=True)
            search = SplitSearch(ShadowMoves(mesh), roadmap, 3.0)
            assert search.clear(1, breadth=1, each=500, budget=10**5) is None
    assert min(seen.values()) > 0


def test_aligned_floors_are_never_said_to_need_more_than_a_plan_has() -> None:
    for seed in range(12):
        floor = block_floor(np.random.default_rng(seed), size=6)
        if floor.holes:
            continue
        mesh = triangulate(floor.vertices, floor.ring_starts)
        roadmap = make_roadmap(floor, mesh, [default_start(floor)], middles=False)
        search = SplitSearch(ShadowMoves(mesh), roadmap, 3.0)
        if search.clear(1, breadth=1, each=500, budget=10**5) is not None:
            assert decide_one_pursuer(floor).suffices is not False


def test_windows_are_the_same_all_over_a_cell() -> None:
    """By points drawn at random: same cell, same vertices with windows."""
    floor = without_collinear_points(ROOMS)
    mesh = triangulate(floor.vertices, floor.ring_starts)
    cells = critical_cells(mesh, 1000)
    assert cells is not None
    assert len(cells.widths) == 36  # as many as an overlay of the lines has
    known = {
        tuple(cells.gaps[begin:end].tolist())
        for begin, end in zip(cells.starts[:-1], cells.starts[1:], strict=True)
    }
    rng = np.random.default_rng(0)
    low, high = floor.vertices.min(axis=0), floor.vertices.max(axis=0)
    met = set()
    for x, y in rng.uniform(low, high, (1500, 2)).tolist():
        if floor.contains([(x, y)])[0]:
            windows = find_windows(mesh, visibility_polygon(mesh, x, y))
            met.add(tuple(sorted(windows.near.tolist())))
    assert met <= known
    assert len(met) > 0.7 * len(known)
