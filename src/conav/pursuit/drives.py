"""Moves over a roadmap by which pursuers come to the drives a plan is made of."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from conav.pursuit.known_map import Move
from conav.pursuit.roadmap import Roadmap
from conav.pursuit.split_search import Drive


def moves_of(
    roadmap: Roadmap, begin: Sequence[int], drives: Sequence[Drive]
) -> tuple[Move, ...] | None:
    """The moves of pursuers that begin at these places; None where a place cannot be reached.

    Each drive is made by the pursuer it names, which first goes to its beginning by a shortest way.
    """
    graph = csr_matrix(np.where(np.isfinite(roadmap.lengths), roadmap.lengths, 0.0))
    at = list(begin)
    moves: list[Move] = []
    for who, way in drives:
        _, before = dijkstra(graph, directed=False, indices=[at[who]], return_predecessors=True)
        there = [way[0]]
        while there[-1] != at[who]:
            previous = int(before[0, there[-1]])
            if previous < 0:
                return None
            there.append(previous)
        moves += [Move(a, b) for a, b in pairwise([*there[::-1], *way[1:]])]
        at[who] = way[-1]
    return tuple(moves)
