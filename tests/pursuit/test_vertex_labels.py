"""The paper's labels, to the letter, against plain definitions; and where they are wrong."""

from collections import Counter
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.geometry.triangulation import triangulate
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.catalogue import make_method
from conav.pursuit.clear_by_vertex_labels import ClearByVertexLabels
from conav.pursuit.clear_known_map import ClearKnownMap
from conav.pursuit.known_map import KnownMapSearch
from conav.pursuit.navigation_graph import (
    NavigationGraph,
    known_navigation_graph,
    parts_without,
)
from conav.pursuit.pursuit_graph import make_pursuit_graph, shortest_clearing
from conav.pursuit.roadmap import make_roadmap
from conav.pursuit.shadow_labels import ShadowLabels
from conav.pursuit.shadow_moves import Point, ShadowMoves
from conav.pursuit.starts import default_start
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult
from conav.pursuit.verify import verify_schedule
from conav.pursuit.vertex_labels import Paths, VertexLabels, label_all
from conav.pursuit.vertex_sight import VertexSight

from .floors import NINE, block_floor

READINGS: tuple[Paths, ...] = ("all", "hidden", "partly-hidden")


def labels_of(floor: PolygonMap, paths: Paths) -> VertexLabels:
    mesh = triangulate(floor.vertices, floor.ring_starts)
    graph = known_navigation_graph(floor, mesh, [default_start(floor)])
    point_of = {tuple(row): v for v, row in enumerate(floor.vertices.tolist())}
    vertices = [point_of[p] for p, c in zip(graph.points, graph.critical, strict=True) if c]
    return label_all(graph, VertexSight(mesh, tuple(vertices)), paths)


def bits(flags: list[bool]) -> int:
    return sum(1 << i for i, flag in enumerate(flags) if flag)


class Plain:
    """The definitions, with shapely: a triangle on the floor is one that everything is seen in."""

    def __init__(self, floor: PolygonMap, points: list[Point]) -> None:
        self.space = floor.polygon.buffer(1e-9)
        self.points = points
        ring_of = {tuple(p): ring for ring in floor.rings for p in ring.tolist()}
        self.sides: list[tuple[Point, Point]] = []
        for point in points:
            ring = [tuple(p) for p in ring_of[point].tolist()]
            at = ring.index(point)
            self.sides.append((ring[at - 1], ring[(at + 1) % len(ring)]))

    def sees_all(self, place: Point, a: Point, b: Point) -> bool:
        return self.space.covers(shapely.MultiPoint([place, a, b]).convex_hull)

    def clear(self, team: tuple[Point, ...]) -> int:
        return bits(
            [
                all(any(self.sees_all(p, point, side) for p in team) for side in sides)
                for point, sides in zip(self.points, self.sides, strict=True)
            ]
        )

    def after(
        self, others: tuple[Point, ...], a: Point, b: Point, contaminated: int, paths: Paths
    ) -> int:
        n = len(self.points)
        watched = [
            self.sees_all(p, a, b) or any(self.sees_all(o, p, p) for o in others)
            for p in self.points
        ]
        whole = self.clear((*others, a)) & self.clear((*others, b))
        open_to = {
            "all": [True] * n,
            "hidden": [not w for w in watched],
            "partly-hidden": [not whole >> i & 1 for i in range(n)],
        }[paths]
        reached = {i for i in range(n) if contaminated >> i & 1 and open_to[i]}
        while True:
            new = {
                j
                for j in range(n)
                if j not in reached
                and open_to[j]
                and any(
                    self.sees_all(self.points[i], self.points[j], self.points[j]) for i in reached
                )
            }
            if not new:
                break
            reached |= new
        kept = bits(
            [
                not contaminated >> i & 1 and (i not in reached or watched[i])
                for i in range(n)
            ]
        )  # fmt: skip
        return ((1 << n) - 1) & ~kept & ~self.clear((*others, b))


@pytest.mark.parametrize("paths", READINGS)
@pytest.mark.parametrize("name", ["ring", "rooms:3", "streets:2", "spider:2,2,1"])
def test_labels_are_what_the_definitions_say(name: str, paths: Paths) -> None:
    floor = load_floor_plan(name)
    labels = labels_of(floor, paths)
    points = [labels.graph.points[node] for node in labels.nodes]
    plain = Plain(floor, points)
    rng = np.random.default_rng(3)
    for _ in range(15):
        a, other = rng.integers(len(labels.graph.points), size=2).tolist()
        b = int(rng.choice(labels.graph.joined[a]))
        places = [labels.graph.points[i] for i in (a, b, other)]
        others = () if rng.random() < 0.5 else (places[2],)
        assert labels.clear_on_sight((*others, places[0])) == plain.clear((*others, places[0]))
        before = int(rng.integers(1 << min(len(points), 62))) & labels.begin((*others, places[0]))
        got = labels.after(others, places[0], places[1], before)
        assert got == plain.after(others, places[0], places[1], before, paths)


def test_a_drive_by_hand() -> None:
    """The ring from one corner of its hole to the next: of four vertices two were seen always."""
    floor = load_floor_plan("ring")
    hole = [tuple(p) for p in floor.holes[0].tolist()]
    for paths in READINGS:
        labels = labels_of(floor, paths)
        order = [labels.graph.points[node] for node in labels.nodes]
        bit = {point: 1 << order.index(point) for point in hole}
        everything = sum(bit.values())
        dirty = labels.begin((hole[0],))
        assert dirty == everything - bit[hole[0]]  # its own two walls are seen, no others entirely
        dirty = labels.after((), hole[0], hole[1], dirty)
        assert dirty == everything - bit[hole[0]] - bit[hole[1]]
        # The first is no longer seen, and a path leads to it from the one before it.
        dirty = labels.after((), hole[1], hole[2], dirty)
        assert dirty == bit[hole[0]] | bit[hole[3]]


def solved(
    floor: PolygonMap, starts: list[Point], most: int, method: object = None
) -> PursuitResult:
    team = tuple(Pursuer(f"pursuer_{i}", start) for i, start in enumerate(starts, 1))
    solver = method or ClearByVertexLabels()
    return solver.solve(PursuitProblem(floor, team, most=most))  # type: ignore[attr-defined]


def verdict(floor: PolygonMap, result: PursuitResult) -> str:
    return str(verify_schedule(floor, result.schedule, (None,) * len(result.pursuers)).verdict)


@pytest.mark.parametrize("paths", READINGS)
def test_a_claim_the_verifier_rejects(paths: Paths) -> None:
    """Three pursuers see all walls, and a triangle in the middle is hidden."""
    floor, starts = NINE, [(-5.0, 0.0), (4.5, -4.3301), (3.5, 6.0622)]
    claimed = solved(floor, starts, len(starts), ClearByVertexLabels(paths=paths))
    assert claimed.status == "done"
    assert not claimed.minimal_proved
    assert verdict(floor, claimed) == "escapes"
    sound = solved(floor, starts, len(starts), ClearKnownMap())
    assert sound.status == "done"
    assert verdict(floor, sound) == "captured"
    assert claimed.counters["moves"] == 0 < sound.counters["moves"]


@pytest.mark.parametrize(
    ("name", "pursuers"),
    [
        ("comb:4", (1, 1, 1)),
        ("ring", (2, 2, 2)),
        ("spider:1,1,1", (2, 1, 2)),
        ("spider:2,2,2", (3, 2, 3)),
    ],
)
def test_readings_and_the_teams_they_need(name: str, pursuers: tuple[int, ...]) -> None:
    floor = load_floor_plan(name)
    for paths, count in zip(READINGS, pursuers, strict=True):
        result = solved(floor, [default_start(floor)], 3, ClearByVertexLabels(paths=paths))
        assert len(result.pursuers) == count
        assert verdict(floor, result) == "captured"


def test_too_few_and_too_many_states() -> None:
    floor = load_floor_plan("ring")
    result = solved(floor, [default_start(floor)], 1)
    assert result.status == "out_of_budget"
    assert "no pursuit graph of up to 1 pursuer has" in result.reason
    limited = solved(floor, [default_start(floor)], 2, ClearByVertexLabels(limit=2))
    assert limited.status == "out_of_budget"
    with pytest.raises(ValueError, match="1 or more"):
        ClearByVertexLabels(limit=0)
    made = make_method("known-map", "paper", {"paths": "hidden"})
    assert made == ClearByVertexLabels(paths="hidden")


# --- navigation and pursuit graphs ----------------------------------------------------------------


def graph_of(floor: PolygonMap) -> NavigationGraph:
    mesh = triangulate(floor.vertices, floor.ring_starts)
    return known_navigation_graph(floor, mesh, [default_start(floor)])


def test_the_navigation_graph_by_hand() -> None:
    floor = load_floor_plan("ring")
    graph = graph_of(floor)
    start = default_start(floor)
    assert graph.points[0] == start
    assert graph.critical.tolist() == [False, True, True, True, True]
    assert graph.visited.tolist() == [True, False, False, False, False]
    side = 8.0
    first, second, third, fourth = range(1, 5)
    assert graph.lengths[first, second] == side
    assert np.isinf(graph.lengths[first, third])
    assert graph.distances[first, third] == 2 * side
    assert graph.way(first, third) in ([first, second, third], [first, fourth, third])
    assert graph.with_visits([third]).visited.tolist() == [True, False, False, True, False]
    assert graph.seen_from(first).tolist() == [False, True, True, False, True]


def test_parts_of_a_graph_that_is_cut() -> None:
    graph = graph_of(load_floor_plan("rooms:3"))
    nodes = tuple(np.flatnonzero(graph.critical).tolist())
    for cut in nodes:
        parts = parts_without(graph, nodes, cut, visited_only=False)
        gone = {cut, *graph.joined[cut].tolist()}
        assert sorted(node for part in parts for node in part) == [
            v for v in nodes if v not in gone
        ]
        for one, other in combinations(parts, 2):
            assert not any(np.isfinite(graph.lengths[a, b]) for a in one for b in other)
        # Nobody was anywhere: only the cut itself goes.
        (rest,) = parts_without(graph, nodes, cut, visited_only=True)
        assert rest == tuple(node for node in nodes if node != cut)


@pytest.mark.parametrize("name", ["rooms:3", "comb:4", "spider:1,2,2"])
def test_shortest_clearing_is_that_of_the_search(name: str) -> None:
    """With labels of shadows the whole pursuit graph holds the shortest plan of the search."""
    floor = load_floor_plan(name)
    mesh = triangulate(floor.vertices, floor.ring_starts)
    graph = graph_of(floor)
    labels = ShadowLabels(ShadowMoves(mesh))
    pursuit = make_pursuit_graph(graph, labels, [0], limit=5000)
    assert pursuit.complete
    moves = shortest_clearing(graph, pursuit)
    assert moves is not None
    roadmap = make_roadmap(floor, mesh, [default_start(floor)], middles=False)
    found = KnownMapSearch(ShadowMoves(mesh), roadmap).clear([0], weight=0.0, budget=10**6)
    assert found.moves is not None
    cost = sum(float(graph.lengths[m.start, m.end]) for m in moves)
    assert cost == pytest.approx(sum(float(roadmap.lengths[m.start, m.end]) for m in found.moves))


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_pursuit_graphs_are_closed(seed: int) -> None:
    """Every state is reached, final ones end, and there are no more than places times labels."""
    floor = block_floor(np.random.default_rng(seed), 4)
    labels = labels_of(floor, "hidden")
    pursuit = make_pursuit_graph(labels.graph, labels, [0], limit=3000)
    assert pursuit.complete
    assert len(set(pursuit.states)) == len(pursuit.states)
    entered = Counter(after for out in pursuit.edges for after, _ in out)
    assert all(entered[i] for i in range(1, len(pursuit.states)))
    assert all(not pursuit.edges[i] for i in pursuit.final)
    assert len(pursuit.states) <= len(labels.graph.points) << len(labels.nodes)
    # Standing pursuers see and never move; places outside `within` are not driven to.
    part = make_pursuit_graph(labels.graph, labels, [0], standing=[1], within=[0, 1], limit=3000)
    assert {places for places, _ in part.states} <= {(0,), (1,)}


def test_a_limit_ends_the_graph() -> None:
    floor = load_floor_plan("rooms:3")
    labels = labels_of(floor, "all")
    whole = make_pursuit_graph(labels.graph, labels, [0], limit=5000)
    part = make_pursuit_graph(labels.graph, labels, [0], limit=20)
    assert whole.complete
    assert not part.complete
    assert part.states == whole.states[:20]
    assert (
        make_pursuit_graph(labels.graph, labels, [0], limit=99, go_on=lambda _: False).edges == ()
    )
