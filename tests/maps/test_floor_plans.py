"""Floor plans made by code: their corners, their sizes, and what the nested triples promise."""

from collections import deque
from itertools import pairwise

import numpy as np
import pytest

from conav.errors import InputError
from conav.maps.floor_plans.catalogue import FLOOR_PLANS, builtin_floor_plan
from conav.maps.floor_plans.lattice import Path, Point, cells_of_paths
from conav.maps.floor_plans.triples import triple_extent, triple_paths
from conav.maps.load_floor_plan import load_floor_plan
from conav.maps.polygon_map import PolygonMap, without_collinear_points

SPIDER_222 = [
    *((-8.5, -4.5), (-8.5, -3.5), (-4.5, -3.5), (-4.5, 0.5), (-0.5, 0.5), (-0.5, 4.5)),
    *((3.5, 4.5), (3.5, 8.5), (4.5, 8.5), (4.5, 3.5), (0.5, 3.5), (0.5, 0.5), (4.5, 0.5)),
    *((4.5, -3.5), (8.5, -3.5), (8.5, -4.5), (3.5, -4.5), (3.5, -0.5), (-3.5, -0.5)),
    (-3.5, -4.5),
]
ROOMS_3 = [
    *((0, 0), (13, 0), (13, -2), (10, -2), (10, -8), (18, -8), (18, -2), (15, -2), (15, 0)),
    *((30, 0), (30, 3), (26, 3), (26, 5), (29, 5), (29, 11), (21, 11), (21, 5), (24, 5)),
    *((24, 3), (6, 3), (6, 5), (9, 5), (9, 11), (1, 11), (1, 5), (4, 5), (4, 3), (0, 3)),
]


def same_ring(ring: np.ndarray, corners: list[tuple[float, float]]) -> bool:
    """Equal up to where the ring begins and which way it runs."""
    a, b = [tuple(map(float, p)) for p in ring.tolist()], [tuple(map(float, p)) for p in corners]
    turned = [a[k:] + a[:k] for k in range(len(a))]
    return b in turned or b[::-1] in turned


def test_spider_and_rooms_have_the_corners_they_are_known_by():
    assert same_ring(builtin_floor_plan("spider:2,2,2").outer, SPIDER_222)
    assert same_ring(builtin_floor_plan("rooms:3").outer, ROOMS_3)


@pytest.mark.parametrize("bends", [(0, 0, 0), (1, 0, 3), (3, 3, 3), (1, 2, 5)])
def test_a_spider_has_two_corners_a_bend(bends: tuple[int, int, int]):
    plan = builtin_floor_plan(f"spider:{bends[0]},{bends[1]},{bends[2]}")
    assert len(plan.outer) == 8 + 2 * sum(bends)
    assert plan.area == 1 + 4 * (3 + sum(bends))


@pytest.mark.parametrize("teeth", [1, 2, 7])
def test_comb(teeth: int):
    plan = builtin_floor_plan(f"comb:{teeth}")
    assert len(plan.outer) == 4 * teeth + 4
    assert plan.area == (2 * teeth + 1) + 4 * teeth
    assert int((plan.turns < 0).sum()) == 2 * teeth


@pytest.mark.parametrize("streets", [2, 3, 6])
def test_streets(streets: int):
    plan = builtin_floor_plan(f"streets:{streets}")
    side = 4 * (streets - 1) + 1
    assert len(plan.holes) == (streets - 1) ** 2
    assert plan.area == side**2 - 9 * (streets - 1) ** 2


@pytest.mark.parametrize("seed", range(8))
def test_corridor_trees_are_trees_of_corridors(seed: int):
    plan = builtin_floor_plan(f"corridor-tree:segments=30,seed={seed}")
    assert plan.holes == ()
    assert plan.area == 1 + 2 * 30
    assert (np.abs(plan.segments[:, :2] - plan.segments[:, 2:]).min(axis=1) == 0).all()


@pytest.mark.parametrize("seed", range(8))
def test_offices_are_one_floor_with_loops(seed: int):
    plan = builtin_floor_plan(f"office-loops:corridors=3,seed={seed}")
    assert len(plan.holes) >= 2
    assert plan.bounds[:3] == (0, 0, 36)


@pytest.mark.parametrize("entry", FLOOR_PLANS.values(), ids=lambda entry: entry.name)
def test_every_entry_is_drawn_as_named_and_the_same_each_time(entry):
    one, again = builtin_floor_plan(entry.example), load_floor_plan(entry.example)
    assert one.name.partition(":")[0] == entry.name
    assert all((a == b).all() for a, b in zip(one.rings, again.rings, strict=True))
    bare = without_collinear_points(one)
    assert len(bare.vertices) == len(one.vertices)
    by_name = builtin_floor_plan(one.name)  # the name a plan carries makes it again
    assert np.array_equal(by_name.vertices, one.vertices)
    for number in entry.numbers:
        for value in (number.least - 1, number.greatest + 1):
            with pytest.raises(InputError, match=f"{number.name} is {value}"):
                builtin_floor_plan(f"{entry.name}:{number.name}={value}")
        if number.least > 0 or number.name != "seed":
            small = builtin_floor_plan(f"{entry.name}:{number.name}={number.least}")
            assert isinstance(small, PolygonMap)


def test_other_seeds_make_other_plans():
    for name in ("corridor-tree", "office-loops"):
        plans = {builtin_floor_plan(f"{name}:seed={seed}").vertices.tobytes() for seed in range(5)}
        assert len(plans) == 5


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("combs:3", "did you mean comb"),
        ("comb:3,4", "'4' is one number too many; write it as comb:6"),
        ("comb:", "teeth: '' is no whole number"),
        ("comb:many", "teeth: 'many' is no whole number"),
        ("comb:tooth=3", "'tooth=3' is unknown"),
        ("spider:1,first=3", "first is given twice"),
        ("ring:3", "'3' is one number too many; write it as ring"),
    ],
)
def test_names_that_are_none(name: str, words: str):
    with pytest.raises(InputError, match=words):
        builtin_floor_plan(name)


# The condition under which triples(k) needs k searchers, as its module states it, checked on whole
# cells: a cell sees another if some point of it sees some point of the other.

Tree = dict[Point, list[Point]]


def tree_of(cells: set[Point]) -> Tree:
    tree = {
        (x, y): [at for at in ((x + 1, y), (x, y + 1), (x - 1, y), (x, y - 1)) if at in cells]
        for x, y in cells
    }
    assert sum(len(around) for around in tree.values()) == 2 * (len(cells) - 1)
    return tree


def can_be_stabbed(gates: list[tuple[Point, Point]]) -> bool:
    """Whether a line passes all gates, each (left end, right end), in doubled coordinates."""
    ends = np.array([end for gate in gates for end in gate])
    wanted = np.array([1, -1] * len(gates))
    pairs = [(a, b) for a in range(len(ends)) for b in range(len(ends))]
    a, b = ends[[p[0] for p in pairs]], ends[[p[1] for p in pairs]]
    apart = (a != b).any(axis=1)
    d = (b - a)[apart]
    to = ends[None, :, :] - a[apart][:, None, :]
    side = d[:, None, 0] * to[:, :, 1] - d[:, None, 1] * to[:, :, 0]
    return bool((side * wanted >= 0).all(axis=1).any())


def gate(a: Point, b: Point) -> tuple[Point, Point]:
    """The side that cell b shares with a, seen from a: its left and its right end."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    x, y = 2 * a[0] + dx, 2 * a[1] + dy
    return (x - dy, y + dx), (x + dy, y - dx)


def seen_from(tree: Tree, start: Point) -> set[Point]:
    seen = {start}
    waiting: deque[list[Point]] = deque([[start, around] for around in tree[start]])
    while waiting:
        path = waiting.popleft()
        steps = [(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(path)]
        # Of the gates of a straight run the first and the last say all.
        kept = [
            i
            for i in range(len(steps))
            if i in (0, len(steps) - 1) or steps[i - 1] != steps[i] or steps[i + 1] != steps[i]
        ]
        if not can_be_stabbed([gate(path[i], path[i + 1]) for i in kept]):
            continue
        seen.add(path[-1])
        waiting.extend([*path, after] for after in tree[path[-1]] if after != path[-2])
    return seen


def triples_need_searchers(paths: list[Path]) -> bool:
    """Whether the condition holds at every junction of a tree of corridors rooted at (0, 0)."""
    tree = tree_of(cells_of_paths(paths))
    sight = {cell: seen_from(tree, cell) for cell in tree}
    parent = {(0, 0): (0, 0)}
    order = [(0, 0)]
    for cell in order:
        for after in tree[cell]:
            if after != parent[cell]:
                parent[after] = cell
                order.append(after)

    def below(top: Point) -> set[Point]:
        found, edge = {top}, [top]
        for cell in edge:
            edge += [after for after in tree[cell] if after != parent[cell]]
            found.update(edge)
        return found

    for junction in order:
        branches = [after for after in tree[junction] if after != parent[junction]]
        if len(branches) < 2:
            continue
        assert len(branches) == 3
        joined: list[set[Point]] = []  # the corridor to each copy
        cores: list[set[Point]] = []
        for top in branches:
            way = {junction}
            while len(tree[top]) == 2:
                way.add(top)
                (top,) = (after for after in tree[top] if after != parent[top])
            joined.append(way)
            cores.append(below(top))
        for b in range(3):
            zone = {cell for cell in tree if sight[cell] & cores[b]}
            rest: set[Point] = set()
            for other in {0, 1, 2} - {b}:
                rest |= cores[other] | joined[other]
            if any(sight[cell] & rest for cell in zone):
                return False
    return True


@pytest.mark.parametrize("depth", [2, 3])
def test_triples_need_as_many_searchers_as_they_are_deep(depth: int):
    assert triples_need_searchers(triple_paths(depth))
    ends = [
        cell
        for cell, around in tree_of(cells_of_paths(triple_paths(depth))).items()
        if len(around) == 1
    ]
    assert len(ends) == 3 ** (depth - 1)


def test_the_condition_fails_where_corridors_bend_less():
    once: list[Path] = [
        [(0, 0), (4, 0), (4, -4)],
        [(0, 0), (0, 4), (4, 4)],
        [(0, 0), (-4, 0), (-4, -4)],
    ]
    assert not triples_need_searchers(once)


@pytest.mark.parametrize("depth", [1, 2, 3, 4, 5])
def test_copies_of_triples_keep_apart(depth: int):
    # Were two corridors to touch, cells would have more sides in common than a tree has.
    cells = cells_of_paths(triple_paths(depth))
    tree_of(cells)
    if depth > 1:
        assert max(max(abs(x), abs(y)) for x, y in cells) == triple_extent(depth)
    plan = builtin_floor_plan(f"triples:{depth}")
    assert plan.area == len(cells)
    assert plan.holes == ()
