"""Standing guards: known numbers, brute force, published optima, and the verifier."""

import os
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from conav.geometry.mutual_sight import mutual_sight
from conav.geometry.sight_lines import sees
from conav.geometry.triangulation import triangulate
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.clear_by_guards import ClearByGuards
from conav.pursuit.guard_posts import guard_posts
from conav.pursuit.shadow_moves import ShadowMoves
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem
from conav.pursuit.verify import verify_schedule

from .floors import block_floor


def critical(floor: PolygonMap) -> list[tuple[float, float]]:
    return [(x, y) for x, y in floor.vertices[floor.turns < 0].tolist()]


@pytest.mark.parametrize(
    ("name", "fewest"), [("comb:6", 6), ("rooms:3", 4), ("ring", 2), ("spider:2,2,2", 4)]
)
def test_guards_of_known_floors(name: str, fewest: int) -> None:
    floor = load_floor_plan(name)
    for cover in ("fewest", "greedy"):
        team = (Pursuer("one", default_start(floor)),)
        result = ClearByGuards(cover).solve(PursuitProblem(floor, team))
        assert result.status == "done"
        size = len(result.pursuers)
        assert size == fewest if cover == "fewest" else size >= fewest
        assert verify_schedule(floor, result.schedule, (None,) * size).verdict == "captured"


@pytest.mark.parametrize("seed", range(6))
def test_no_smaller_choice_of_vertices_sees_everything(seed: int) -> None:
    floor = block_floor(np.random.default_rng(seed), size=5)
    mesh = triangulate(floor.vertices, floor.ring_starts)
    places = critical(floor)
    posts = guard_posts(mesh, places, exact=True)
    greedy = guard_posts(mesh, places)
    assert posts is not None
    assert greedy is not None
    moves = ShadowMoves(mesh)
    for found in (posts, greedy):
        assert moves.shadows([places[post] for post in found.places]).count == 0
    assert posts.least == len(posts.places) <= len(greedy.places)
    smaller = combinations(places, len(posts.places) - 1)
    assert all(moves.shadows(team).count > 0 for _, team in zip(range(300), smaller, strict=False))


def test_places_that_do_not_see_everything() -> None:
    floor = load_floor_plan("comb:4")
    mesh = triangulate(floor.vertices, floor.ring_starts)
    for exact in (False, True):
        assert guard_posts(mesh, critical(floor)[:2], exact=exact) is None


def test_too_few_may_be_sent() -> None:
    floor = load_floor_plan("comb:4")
    team = (Pursuer("one", default_start(floor)),)
    result = ClearByGuards().solve(PursuitProblem(floor, team, most=3))
    assert result.status == "out_of_budget"
    assert "3 may be sent" in result.reason


@pytest.mark.skipif("CONAV_DATA" not in os.environ, reason="needs the published floors")
@pytest.mark.parametrize(
    ("name", "points"), [("random-20-8", 3), ("randsimple-60-23", 7), ("random-60-2", 8)]
)
def test_published_optima(name: str, points: int) -> None:
    """Guards anywhere are at most as many as guards at vertices [Tozoni2016]."""
    path = Path(os.environ["CONAV_DATA"]) / "agp" / "with_solution" / f"{name}.pol"
    floor = load_floor_plan(str(path))
    mesh = triangulate(floor.vertices, floor.ring_starts)
    everywhere = [(x, y) for x, y in floor.vertices.tolist()]
    posts = guard_posts(mesh, everywhere, exact=True)
    assert posts is not None
    assert points <= posts.least <= points + 2


def test_sight_of_all_pairs_is_that_of_each() -> None:
    floor = block_floor(np.random.default_rng(1))
    mesh = triangulate(floor.vertices, floor.ring_starts)
    rng = np.random.default_rng(2)
    low, high = floor.vertices.min(axis=0), floor.vertices.max(axis=0)
    some = np.concatenate((floor.vertices[:6], rng.uniform(low, high, (8, 2))))
    seen = mutual_sight(mesh, some, some)
    for i, a in enumerate(some.tolist()):
        for j, b in enumerate(some.tolist()):
            assert seen[i, j] == sees(mesh, tuple(a), tuple(b))
