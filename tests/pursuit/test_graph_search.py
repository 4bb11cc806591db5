"""Search on graphs: the search number by exhaustion, spanning trees by the verifier."""

from collections import deque
from collections.abc import Sequence
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.geometry.triangulation import triangulate
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap
from conav.pursuit.catalogue import make_method
from conav.pursuit.clear_by_spanning_trees import ClearBySpanningTrees
from conav.pursuit.spanning_tree_search import (
    SpanningTreeSearch,
    Step,
    random_spanning_tree,
    searchers_from,
)
from conav.pursuit.starts import default_start
from conav.pursuit.tree_search_number import tree_search_number
from conav.pursuit.triangle_graph import TriangleGraph
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult
from conav.pursuit.verify import verify_schedule

from .floors import block_floor

Edges = list[tuple[int, int]]


def random_tree(rng: np.random.Generator, size: int) -> Edges:
    return [(int(rng.integers(i)), i) for i in range(1, size)]


def can_clear(edges: Edges, searchers: int) -> bool:
    """Whether so many suffice, by looking at all states: who is where, which edges are clear."""
    size = 1 + max(max(edge) for edge in edges)
    beside = [[i for i, edge in enumerate(edges) if v in edge] for v in range(size)]

    def settled(at: Sequence[int], clear: frozenset[int]) -> frozenset[int]:
        left = set(clear)
        while True:
            lost = {
                i
                for v in range(size)
                if v not in at and any(j not in left for j in beside[v])
                for i in beside[v]
                if i in left
            }
            if not lost:
                return frozenset(left)
            left -= lost

    begin = tuple([size] * searchers)  # none is on the tree
    reached = {(begin, frozenset[int]())}
    waiting = deque(reached)
    while waiting:
        at, clear = waiting.popleft()
        if len(clear) == len(edges):
            return True
        after: list[tuple[list[int], frozenset[int]]] = []
        for i, here in enumerate(at):
            rest = [*at[:i], *at[i + 1 :]]
            after.append(([*rest, size], clear))
            after += [([*rest, v], clear) for v in range(size) if here == size]
            for number in beside[here] if here < size else ():
                a, b = edges[number]
                after.append(([*rest, a + b - here], clear | {number}))
        for places, edges_clear in after:
            state = (tuple(sorted(places)), settled(places, edges_clear))
            if state not in reached:
                reached.add(state)
                waiting.append(state)
    return False


@pytest.mark.parametrize("seed", range(12))
def test_the_search_number_is_what_exhaustion_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    edges = random_tree(rng, int(rng.integers(2, 9)))
    number = tree_search_number(edges)
    assert can_clear(edges, number)
    assert number == 1 or not can_clear(edges, number - 1)


def complete(depth: int) -> Edges:
    """Three copies of the one before, each joined to a new root by an edge."""
    if depth == 1:
        return [(0, 1), (0, 2), (0, 3)]
    edges: Edges = []
    for copy in range(3):
        size = 1 + max(max(edge) for edge in complete(depth - 1))
        shift = 1 + copy * size
        edges += [(0, shift), *((a + shift, b + shift) for a, b in complete(depth - 1))]
    return edges


def test_search_numbers_known() -> None:
    assert tree_search_number([]) == 1
    assert tree_search_number([(i, i + 1) for i in range(30)]) == 1
    assert [tree_search_number(complete(depth)) for depth in (1, 2, 3, 4)] == [2, 3, 4, 5]
    with pytest.raises(ValueError, match="no tree"):
        tree_search_number([(0, 1), (1, 2), (2, 0)])
    with pytest.raises(ValueError, match="no tree"):
        tree_search_number([(0, 1), (2, 3)])


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_parsons_theorem(seed: int) -> None:
    """More than k are needed iff three branches at some vertex need k or more each."""
    rng = np.random.default_rng(seed)
    edges = random_tree(rng, int(rng.integers(2, 40)))
    number = tree_search_number(edges)

    def branches(vertex: int) -> list[int]:
        found: list[int] = []
        for first in [edge for edge in edges if vertex in edge]:
            part, ends = [first], {first[0] + first[1] - vertex}
            while True:
                more = [e for e in edges if e not in part and vertex not in e and {*e} & ends]
                if not more:
                    break
                part += more
                ends |= {v for edge in more for v in edge}
            found.append(tree_search_number(part))
        return sorted(found, reverse=True)

    thirds = [found[2] for v in range(len(edges) + 1) if len(found := branches(v)) > 2]
    assert number == 1 + max(thirds, default=0)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_graphs_are_cleared_and_nothing_is_contaminated_again(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = int(rng.integers(2, 15))
    edges = {*random_tree(rng, size)}
    pairs = list(combinations(range(size), 2))
    edges |= {pairs[i] for i in rng.integers(len(pairs), size=int(rng.integers(size))).tolist()}
    neighbours = [sorted({a + b - v for a, b in edges if v in (a, b)}) for v in range(size)]
    tree = random_spanning_tree(neighbours, rng)
    assert sum(len(row) for row in tree) == 2 * (size - 1)
    at, clear = [0], {0}

    def moved(step: Step) -> None:
        while len(at) <= step.searcher:
            at.append(0)
        assert step.goal in tree[step.origin]
        at[step.searcher] = step.goal
        clear.add(step.goal)
        # By definition: whoever may be in a vertex gets to its neighbours that nobody is in.
        assert all(v in at for v in clear if any(one not in clear for one in neighbours[v]))

    search = SpanningTreeSearch(neighbours, tree, [0], lambda free, v, g: free[0], moved)
    search.clear()
    assert len(clear) == size
    if len(edges) == size - 1:
        assert len(at) == searchers_from(tree, 0)[0]
        if len(edges) > 0:
            assert len(at) >= tree_search_number(sorted(edges))


def searched(floor: PolygonMap, **chosen: object) -> PursuitResult:
    team = (Pursuer("pursuer_1", default_start(floor)),)
    most = chosen.pop("most", None)
    problem = PursuitProblem(floor, team, most=most)  # type: ignore[arg-type]
    return make_method("spanning-trees", settings=chosen).solve(problem)


GOLD = {  # pursuers, search number of the tree of triangles
    "spider:2,2,2": (2, 2),
    "rooms:3": (4, 3),
    "comb:6": (3, 2),
    "ring": (2, None),
    "streets:3": (4, None),
    "triples:3": (4, 3),
}


@pytest.mark.parametrize(("name", "numbers"), GOLD.items())
def test_floors_are_cleared_by_searchers_of_triangles(
    name: str, numbers: tuple[int, int | None]
) -> None:
    floor = load_floor_plan(name)
    result = searched(floor, trees=20)
    assert (len(result.pursuers), result.counters.get("search_number")) == numbers
    found = verify_schedule(floor, result.schedule, (None,) * len(result.pursuers))
    assert found.verdict == "captured"


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_random_floors_are_cleared(seed: int) -> None:
    floor = block_floor(np.random.default_rng(seed), 5)
    result = searched(floor, trees=3)
    assert result.status == "done"
    found = verify_schedule(floor, result.schedule, (None,) * len(result.pursuers))
    assert found.verdict == "captured"


def test_more_trees_are_no_worse_and_seeds_repeat() -> None:
    floor = load_floor_plan("streets:3")
    few, many, again = (searched(floor, trees=n, seed=7) for n in (1, 40, 40))
    assert len(many.pursuers) <= len(few.pursuers)
    assert np.array_equal(many.schedule.positions, again.schedule.positions)
    scarce = searched(floor, most=1)
    assert scarce.status == "out_of_budget"
    assert "along the best of these trees" in scarce.reason
    with pytest.raises(ValueError, match="1 or more"):
        ClearBySpanningTrees(trees=0)
    with pytest.raises(ValueError, match="0 or more"):
        ClearBySpanningTrees(seed=-1)


def test_the_graph_of_triangles() -> None:
    for name, simple in (("comb:3", True), ("ring", False)):
        floor = load_floor_plan(name)
        graph = TriangleGraph.of(triangulate(floor.vertices, floor.ring_starts))
        assert (len(graph.edges) == len(graph.neighbours) - 1) is simple
        for a, b in graph.edges:
            assert len(graph.door(a, b)) == 2
        way = graph.way(0, len(floor.vertices) - 1)
        assert sum(graph.distances[a, b] for a, b in pairwise(way)) == pytest.approx(
            graph.distances[0, len(floor.vertices) - 1]
        )


def test_pursuers_may_start_apart() -> None:
    floor = load_floor_plan("streets:3")
    first = default_start(floor)
    corners = [tuple(corner) for corner in floor.outer[:3].tolist()]
    team = tuple(Pursuer(f"pursuer_{i}", at) for i, at in enumerate([first, *corners]))  # type: ignore[arg-type]
    result = ClearBySpanningTrees(trees=20).solve(PursuitProblem(floor, team))
    assert len(result.pursuers) == 4
    found = verify_schedule(floor, result.schedule, (None,) * 4)
    assert found.verdict == "captured"
