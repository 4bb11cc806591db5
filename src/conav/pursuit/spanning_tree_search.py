"""Guaranteed search of a graph along a spanning tree [Hollinger2010].

A searcher clears the vertex it is on. A clear vertex with a neighbour that is not clear needs a
guard, over edges of the tree and others alike, so nothing is contaminated again. The tree tells in
which order vertices are cleared: from the root, of the branches at a vertex the one that needs most
searchers last [Barriere2002], for then the vertex's guard goes on into it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

Edge = tuple[int, int]


class Step(NamedTuple):
    """A searcher comes to a vertex from a neighbour of it, and clears it."""

    searcher: int
    origin: int
    goal: int


def random_spanning_tree(
    neighbours: Sequence[Sequence[int]], rng: np.random.Generator
) -> list[list[int]]:
    """The neighbours of each vertex in a spanning tree: edges in random order, where they close no
    circle. Not all trees are equally likely.
    """
    edges = [(a, b) for a, row in enumerate(neighbours) for b in row if a < b]
    part = list(range(len(neighbours)))
    tree: list[list[int]] = [[] for _ in neighbours]
    for number in rng.permutation(len(edges)).tolist():
        a, b = edges[number]
        one, two = _part(part, a), _part(part, b)
        if one != two:
            part[one] = two
            tree[a].append(b)
            tree[b].append(a)
    return tree


def searchers_from(tree: Sequence[Sequence[int]], root: int) -> list[int]:
    """How many searchers clear what lies beyond each vertex of a tree, all coming from the root.

    A vertex with branches that take l1 >= l2 >= ... takes max(l1, l2 + 1), a leaf 1 [Barriere2002].
    """
    parent = {root: root}
    order = [root]
    for vertex in order:
        for other in tree[vertex]:
            if other not in parent:
                parent[other] = vertex
                order.append(other)
    needs = [1] * len(tree)
    for vertex in reversed(order):
        below = sorted((needs[one] for one in tree[vertex] if one != parent[vertex]), reverse=True)
        needs[vertex] = max([1, *below[:1], *(one + 1 for one in below[1:2])])
    return needs


@dataclass
class SpanningTreeSearch:
    """A search in progress: which vertices are clear, and where searchers are."""

    neighbours: Sequence[Sequence[int]]
    tree: Sequence[Sequence[int]]
    at: list[int]  # the vertex of each searcher; the first one's is the root
    nearest: Callable[[list[int], int, int], int]
    """Which of free searchers goes to a vertex's neighbour, given the vertex."""
    moved: Callable[[Step], None]
    """Told of each step, in order."""

    def clear(self) -> None:
        """Clears the graph; more searchers begin at the root where none is free."""
        root = self.at[0]
        needs = searchers_from(self.tree, root)
        self._clear = {root}
        waiting = [root]  # clear, with neighbours in the tree that are not, in order
        while waiting:
            open_ones = self._open(waiting[-1])
            if not open_ones:
                waiting.pop()
                continue
            # A guard with one neighbour left goes on into it.
            ready = [v for v in waiting if self._may_go_on(v)]
            vertex = ready[-1] if ready else waiting[-1]
            goal = min(self._open(vertex), key=lambda one: (needs[one], one))
            if ready:
                searcher = self.at.index(vertex)
            else:
                free = [i for i in range(len(self.at)) if not self._needed(i)]
                if not free:
                    self.at.append(root)
                    free = [len(self.at) - 1]
                searcher = self.nearest(free, vertex, goal)
            self.at[searcher] = goal
            self._clear.add(goal)
            waiting.append(goal)
            self.moved(Step(searcher, vertex, goal))

    def _open(self, vertex: int) -> list[int]:
        return [one for one in self.tree[vertex] if one not in self._clear]

    def _may_go_on(self, vertex: int) -> bool:
        left = [one for one in self.neighbours[vertex] if one not in self._clear]
        return len(left) == 1 and left == self._open(vertex) and vertex in self.at

    def _needed(self, searcher: int) -> bool:
        """Whether nobody else guards a vertex that must be guarded."""
        vertex = self.at[searcher]
        if vertex not in self._clear or self.at.index(vertex) != searcher:
            return False
        return any(one not in self._clear for one in self.neighbours[vertex])


def _part(part: list[int], vertex: int) -> int:
    while part[vertex] != vertex:
        part[vertex] = part[part[vertex]]
        vertex = part[vertex]
    return vertex
