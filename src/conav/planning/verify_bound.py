"""A lower bound on the sum of costs, derived anew: how far each robot must drive at least.

A word that satisfies the formula names regions one after the other. From the start to the first of
them, and from one to the next, a robot drives at least the distance between, whatever the walls.
Of all words, with the labels that can occur, the cheapest counts, found backwards from the end.
"""

import heapq
from math import hypot, inf

import numpy as np
from numpy.typing import NDArray

from conav.planning.verify_backward import Table, backward_table
from conav.planning.verify_curves import segment_to_segment
from conav.planning.verify_regions import depth
from conav.planning.verify_scene import Area, Body, Scene
from conav.planning.verify_task import names_in, read_formula

MAX_REGIONS = 8  # whose sets are all looked at


def derived_bound(scene: Scene) -> float:
    """The bound on the sum of the first component of all robots' costs.

    Raises `ValueError` where a task is too large or cannot be read.
    """
    total = 0.0
    for body in scene.bodies:
        metres = least_length(body)
        total += metres if scene.costs[0] == "length" else metres / body.speed
    return total


def least_length(body: Body) -> float:
    """The metres that a robot drives at least to do its task; infinite where nothing does it."""
    formula = read_formula(body.task)
    names = sorted(names_in(formula))
    if len(names) > MAX_REGIONS or not set(names) <= set(body.areas):
        raise ValueError(f"the task of {body.name} speaks of {len(names)} regions")
    areas = [body.areas[name] for name in names]
    masks = _occurring(areas)
    x, y = body.start[:2]
    first = sum(1 << i for i, area in enumerate(areas) if depth(area, x, y) >= 0.0)
    if first not in masks:
        masks.append(first)
    table = backward_table(formula, names, masks)
    between = [[distance(a, b) for b in areas] for a in areas]
    from_start = [max(0.0, -depth(area, x, y)) for area in areas]
    return _cheapest(table, masks, first, between, from_start)


def _cheapest(
    table: Table,
    masks: list[int],
    first: int,
    between: list[list[float]],
    from_start: list[float],
) -> float:
    """Dijkstra's algorithm from the ends of words to their beginnings.

    A node is a state, its letter and the next letter on the way that has regions, -1 for none.
    """
    begin = masks.index(first)
    if table.good[table.ends[begin]]:
        return 0.0
    best: dict[tuple[int, int, int], float] = {}
    heap: list[tuple[float, tuple[int, int, int]]] = []
    for k, mask in enumerate(masks):
        heap.append((0.0, (int(table.ends[k]), k, k if mask else -1)))
    heapq.heapify(heap)
    least = inf
    while heap:
        metres, node = heapq.heappop(heap)
        if metres >= best.get(node, inf) or metres >= least:
            continue
        best[node] = metres
        state, letter, ahead = node
        if letter != begin and table.good[table.before[state, begin]]:
            regions = _bits(masks[ahead]) if ahead >= 0 else []
            least = min(least, metres + max((from_start[i] for i in regions), default=0.0))
        for k, mask in enumerate(masks):
            if k == letter:
                continue
            step = 0.0
            if mask and ahead >= 0:
                step = max(between[i][j] for i in _bits(mask) for j in _bits(masks[ahead]))
            earlier = (int(table.before[state, k]), k, k if mask else ahead)
            if metres + step < best.get(earlier, inf):
                heapq.heappush(heap, (metres + step, earlier))
    return least


def _occurring(areas: list[Area]) -> list[int]:
    """The sets of regions a place can be in, and maybe some more."""
    n = len(areas)
    apart = [[distance(a, b) > 1e-9 for b in areas] for a in areas]
    inside = [[i != j and _lies_in(areas[i], areas[j]) for j in range(n)] for i in range(n)]
    return [
        mask
        for mask in range(1 << n)
        if not any(apart[i][j] for i in _bits(mask) for j in _bits(mask))
        and not any(inside[i][j] and not mask >> j & 1 for i in _bits(mask) for j in range(n))
    ]


def distance(a: Area, b: Area) -> float:
    """The distance between two regions, 0 where they meet [m]."""
    if a.disc is not None and b.disc is not None:
        return max(0.0, hypot(a.disc[0] - b.disc[0], a.disc[1] - b.disc[1]) - a.disc[2] - b.disc[2])
    if a.disc is not None:
        return max(0.0, -depth(b, a.disc[0], a.disc[1]) - a.disc[2])
    if b.disc is not None:
        return distance(b, a)
    assert a.corners is not None
    assert b.corners is not None
    if depth(a, *b.corners[0].tolist()) >= 0.0 or depth(b, *a.corners[0].tolist()) >= 0.0:
        return 0.0
    return min(segment_to_segment(*p, *q) for p in _sides(a.corners) for q in _sides(b.corners))


def _lies_in(inner: Area, outer: Area) -> bool:
    """Whether a region certainly lies in another."""
    if inner.disc is not None:
        x, y, radius = inner.disc
        return depth(outer, x, y) >= radius
    assert inner.corners is not None
    if outer.corners is not None and not _convex(outer.corners):
        return False
    return all(depth(outer, x, y) >= 0.0 for x, y in inner.corners.tolist())


def _convex(corners: NDArray[np.float64]) -> bool:
    ahead = np.roll(corners, -1, axis=0) - corners
    after = np.roll(ahead, -1, axis=0)
    turns = ahead[:, 0] * after[:, 1] - ahead[:, 1] * after[:, 0]
    return bool((turns >= 0.0).all() or (turns <= 0.0).all())


def _sides(corners: NDArray[np.float64]) -> list[list[float]]:
    return np.hstack([corners, np.roll(corners, -1, axis=0)]).tolist()


def _bits(mask: int) -> list[int]:
    return [bit for bit in range(mask.bit_length()) if mask >> bit & 1]
