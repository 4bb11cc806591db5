"""Clearing one shadow of standing guards with one pursuer: best first over its pursuit graph."""

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from conav.pursuit.known_map import Move
from conav.pursuit.navigation_graph import NavigationGraph
from conav.pursuit.pursuit_graph import drives
from conav.pursuit.shadow_labels import ShadowLabels


@dataclass(frozen=True)
class Swept:
    """What a search found: drives, None where there are none or the budget ended first."""

    moves: tuple[Move, ...] | None
    expanded: int


def sweep(
    graph: NavigationGraph,
    labels: ShadowLabels,
    start: int,
    *,
    standing: Sequence[int],
    within: Sequence[int],
    contaminated: int,
    weight: float,
    budget: int,
    go_on: Callable[[int], bool],
) -> Swept:
    """Drives after which nothing that was contaminated at the beginning still is.

    The pursuer begins at `start` and goes to places of `within` only; others stand. `contaminated`
    are shadows of all of them. States are taken by metres driven plus `weight` times the square
    root of the contaminated area, and passed over where one at the same place with no more
    contamination was reached for no more metres. `go_on`, told how many states were expanded, ends
    it by False.
    """
    allowed = frozenset(within)
    posts = tuple(graph.points[place] for place in standing)

    def rank(cost: float, place: int, dirty: int) -> float:
        areas = labels.shadows.shadows((*posts, graph.points[place])).areas.tolist()
        left = sum(area for i, area in enumerate(areas) if dirty >> i & 1)
        return cost + weight * max(left, 0.0) ** 0.5

    parents: list[tuple[int, Move | None]] = [(-1, None)]
    waiting = [(rank(0.0, start, contaminated), 0, 0.0, start, contaminated)]
    reached: dict[int, list[tuple[int, float]]] = {}
    expanded = 0
    while waiting:
        _, number, cost, place, dirty = heapq.heappop(waiting)
        if dirty == 0:
            moves: list[Move] = []
            number, move = parents[number]
            while move is not None:
                moves.append(move)
                number, move = parents[number]
            return Swept(tuple(moves[::-1]), expanded)
        if _beaten(reached.get(place, ()), dirty, cost):
            continue
        reached.setdefault(place, []).append((dirty, cost))
        if expanded >= budget or not go_on(expanded):
            break
        expanded += 1
        for move, (places, after) in drives(graph, labels, (place,), dirty, standing, allowed):
            paid = cost + float(graph.lengths[move.start, move.end])
            if not _beaten(reached.get(places[0], ()), after, paid):
                parents.append((number, move))
                heapq.heappush(
                    waiting,
                    (rank(paid, places[0], after), len(parents) - 1, paid, places[0], after),
                )
    return Swept(None, expanded)


def _beaten(known: Sequence[tuple[int, float]], dirty: int, cost: float) -> bool:
    return any(bits & dirty == bits and paid <= cost for bits, paid in known)
