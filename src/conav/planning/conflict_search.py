"""Conflict-based search: the least sum of costs over everybody's paths, exactly [Sharon2015].

Each robot takes its cheapest path by itself. Where two of them collide the search branches: every
branch bars one robot from something its present path does. It is exact when three things hold for
the branches a `Model` makes of a collision:

1. Every choice of paths without collisions that was allowed before is allowed in some branch, so
   no answer is lost.
2. No branch allows the present path of the robot it bars, so finitely many paths end the search.
3. The path a robot takes within its bars is a cheapest one, so a node's sum is a lower bound on
   everything below it.

Nodes are looked at in the order of their sums. So the first one without a collision is the optimum,
and the least sum of the open nodes is a lower bound at every time. Of equal sums the node with
fewer collisions comes first, then the younger one.
"""

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

Path = TypeVar("Path")
Bar = TypeVar("Bar")


class Model(Protocol[Path, Bar]):
    """What conflict-based search must know of robots and their paths."""

    @property
    def size(self) -> int:
        """The number of robots."""
        ...

    def cheapest(
        self, robot: int, bars: Sequence[Bar], others: Sequence[Path]
    ) -> tuple[float, Path] | None:
        """A cheapest path within the bars, with its cost; the others' decide between equals."""
        ...

    def collisions(self, paths: Sequence[Path]) -> int:
        """A number that is 0 when no two paths collide, and greater where more do."""
        ...

    def branches(
        self, paths: Sequence[Path], bars: Sequence[Sequence[Bar]]
    ) -> Sequence[tuple[int, Bar]]:
        """The branches at one of the collisions of these paths, of which there is one."""
        ...


@dataclass(frozen=True, eq=False)
class Searched(Generic[Path]):
    """What a search found.

    With `proved` the paths are the optimum, or None because there is none at all. Otherwise
    `lower_bound` is what every choice of paths costs at least.
    """

    paths: tuple[Path, ...] | None
    cost: float  # infinite without paths
    lower_bound: float  # infinite when it is proved that there are no paths
    proved: bool
    nodes: int


@dataclass(frozen=True, eq=False)
class _Node(Generic[Path, Bar]):
    paths: tuple[Path, ...]
    costs: tuple[float, ...]
    bars: tuple[tuple[Bar, ...], ...]


def conflict_based_search(
    model: Model[Path, Bar],
    max_nodes: int,
    known: float = float("inf"),
    least_gain: float = 0.0,
    out_of_time: Callable[[], bool] = lambda: False,
) -> Searched[Path]:
    """The optimum if it costs less than `known` by more than `least_gain`, within the nodes.

    `known` is the cost of a plan the caller has. When nothing is below it the result has no paths,
    is proved, and its lower bound is `known`, or `least_gain` less.
    """
    first: list[Path] = []
    costs: list[float] = []
    for robot in range(model.size):
        found = model.cheapest(robot, (), first)
        if found is None:
            return Searched(None, float("inf"), float("inf"), True, 0)
        costs.append(found[0])
        first.append(found[1])
    root = _Node[Path, Bar](tuple(first), tuple(costs), tuple(() for _ in first))
    open_nodes = [(sum(costs), model.collisions(first), 0, root)]
    made = 1
    nodes = 0
    while open_nodes:
        total, collisions, _, node = heapq.heappop(open_nodes)
        if total >= known - least_gain:
            return Searched(None, float("inf"), min(total, known), True, nodes)
        if collisions == 0:
            return Searched(node.paths, total, total, True, nodes)
        if nodes >= max_nodes or out_of_time():
            return Searched(None, float("inf"), total, False, nodes)
        nodes += 1
        for robot, bar in model.branches(node.paths, node.bars):
            bars = (*node.bars[robot], bar)
            others = [path for i, path in enumerate(node.paths) if i != robot]
            found = model.cheapest(robot, bars, others)
            if found is None:
                continue
            below = _Node(
                _replaced(node.paths, robot, found[1]),
                _replaced(node.costs, robot, found[0]),
                _replaced(node.bars, robot, bars),
            )
            # Rounding may not make a node cheaper than the one above it.
            entry = max(total, sum(below.costs))
            heapq.heappush(open_nodes, (entry, model.collisions(below.paths), -made, below))
            made += 1
    bound = known if known < float("inf") else float("inf")
    return Searched(None, float("inf"), bound, True, nodes)


T = TypeVar("T")


def _replaced(row: tuple[T, ...], place: int, item: T) -> tuple[T, ...]:
    return (*row[:place], item, *row[place + 1 :])
