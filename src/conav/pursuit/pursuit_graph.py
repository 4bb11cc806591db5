"""The pursuit graph: who is where and what is contaminated, and the drives that change it.

[Pellier2005], section 3.2. Its nodes are reached from where a team starts, its edges are drives of
one pursuer along an edge of the navigation graph. What is contaminated is a number whose bits a
labelling defines; a node is final when that is 0.
"""

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from conav.pursuit.known_map import Move, Team
from conav.pursuit.navigation_graph import NavigationGraph
from conav.pursuit.shadow_moves import Point

State = tuple[Team, int]  # places by number, growing; what is contaminated


class Labelling(Protocol):
    """What is contaminated, as bits, and what drives do to it."""

    def begin(self, team: tuple[Point, ...]) -> int: ...

    def after(self, others: tuple[Point, ...], a: Point, b: Point, contaminated: int) -> int: ...


@dataclass(frozen=True)
class PursuitGraph:
    """States reached from the first one, by breadth."""

    states: tuple[State, ...]
    edges: tuple[tuple[tuple[int, Move], ...], ...]  # of each state where drives lead
    complete: bool  # False where the limit of states ended it

    @property
    def final(self) -> tuple[int, ...]:
        """The states in which nothing is contaminated."""
        return tuple(i for i, (_, dirty) in enumerate(self.states) if dirty == 0)


def make_pursuit_graph(
    graph: NavigationGraph,
    labels: Labelling,
    team: Sequence[int],
    *,
    standing: Sequence[int] = (),
    within: Sequence[int] | None = None,
    contaminated: int | None = None,
    limit: int,
    go_on: Callable[[int], bool] | None = None,
) -> PursuitGraph:
    """The pursuit graph of a team, with at most `limit` states.

    `standing` are places of others, who see and never move; `within` the places the team may go
    to, all without it; `contaminated` what is so at the beginning, all that labels say without it.
    Final states have no successors. `go_on`, told how many states there are, ends it by False.
    """
    allowed = None if within is None else frozenset(within)
    first = tuple(sorted(team))
    if contaminated is None:
        contaminated = labels.begin(_points(graph, (*first, *standing)))
    states: list[State] = [(first, contaminated)]
    numbers = {states[0]: 0}
    edges: list[tuple[tuple[int, Move], ...]] = []
    while len(edges) < len(states):
        places, dirty = states[len(edges)]
        out: list[tuple[int, Move]] = []
        if dirty != 0:
            if go_on is not None and len(edges) % 64 == 0 and not go_on(len(states)):
                return _cut(states, edges)
            for move, after in drives(graph, labels, places, dirty, standing, allowed):
                if after not in numbers:
                    if len(states) >= limit:
                        return _cut(states, [*edges, tuple(out)])
                    numbers[after] = len(states)
                    states.append(after)
                out.append((numbers[after], move))
        edges.append(tuple(out))
    return PursuitGraph(tuple(states), tuple(edges), True)


def drives(
    graph: NavigationGraph,
    labels: Labelling,
    places: Team,
    dirty: int,
    standing: Sequence[int],
    allowed: frozenset[int] | None,
) -> list[tuple[Move, State]]:
    """The drives possible in a state, and the states they lead to."""
    found: list[tuple[Move, State]] = []
    for start in dict.fromkeys(places):
        rest = list(places)
        rest.remove(start)
        others = _points(graph, (*rest, *standing))
        for end in graph.joined[start].tolist():
            if allowed is None or end in allowed:
                after = labels.after(others, graph.points[start], graph.points[end], dirty)
                found.append((Move(start, end), (tuple(sorted((*rest, end))), after)))
    return found


def shortest_clearing(graph: NavigationGraph, pursuit: PursuitGraph) -> tuple[Move, ...] | None:
    """The drives to the nearest final state, by Dijkstra's algorithm; None without one."""
    final = set(pursuit.final)
    waiting: list[tuple[float, int]] = [(0.0, 0)]
    costs = {0: 0.0}
    before: dict[int, tuple[int, Move]] = {}
    done: set[int] = set()
    while waiting:
        cost, state = heapq.heappop(waiting)
        if state in final:
            moves: list[Move] = []
            while state != 0:
                state, move = before[state]
                moves.append(move)
            return tuple(moves[::-1])
        if state in done:
            continue
        done.add(state)
        if state >= len(pursuit.edges):
            continue  # beyond the limit of states
        for after, move in pursuit.edges[state]:
            paid = cost + float(graph.lengths[move.start, move.end])
            if after not in costs or paid < costs[after]:
                costs[after] = paid
                before[after] = (state, move)
                heapq.heappush(waiting, (paid, after))
    return None


def _points(graph: NavigationGraph, places: Sequence[int]) -> tuple[Point, ...]:
    return tuple(graph.points[place] for place in places)


def _cut(states: list[State], edges: list[tuple[tuple[int, Move], ...]]) -> PursuitGraph:
    return PursuitGraph(tuple(states), tuple(edges), False)
