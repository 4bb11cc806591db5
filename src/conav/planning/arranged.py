"""A graph's edges sorted for a pass in the order of time.

Vertices are called by their rank in time (of equals by number), and the edges into a vertex lie
together, in the order of the ranks they come from: what a pass finds depends on the graph alone
and not on how it grew.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.graph_arrays import EDGES, HEAD, LETTER, TAIL, VERTICES, WORD, Graph
from conav.planning.steering import may_end


class Arranged(NamedTuple):
    """Arrays for kernels."""

    vertices: NDArray[np.int64]  # (n,) the vertex of each rank
    states: NDArray[np.float64]  # (n, numbers of a state) by rank
    letters: NDArray[np.int32]  # (n,) by rank
    ends: NDArray[np.bool_]  # (n,) whether the robot may stop there, by rank
    starts: NDArray[np.int64]  # (n + 1,) of the edges into each
    sources: NDArray[np.int32]  # (edges,) ranks
    lengths: NDArray[np.float64]  # (edges,) [m]
    words: NDArray[np.int32]  # (edges,) places in `letters_of_words`, or -1
    letters_of_words: NDArray[np.int32]


def arrange(graph: Graph, limits: NDArray[np.float64]) -> Arranged:
    """The vertices and edges of the graph of a robot with these limits, in the order of time."""
    size = int(graph.counts[VERTICES])
    vertices = np.argsort(graph.states[:size, 2], kind="stable")
    count = int(graph.counts[EDGES])
    starts, sources, lengths, words = _sorted_edges(vertices, graph.edges, graph.lengths, count)
    return Arranged(
        vertices,
        graph.states[vertices],
        graph.links[vertices, LETTER],
        _ends(graph.states[vertices], limits),
        starts,
        sources,
        lengths,
        words,
        graph.words,
    )


@kernel
def _ends(states: NDArray[np.float64], limits: NDArray[np.float64]) -> NDArray[np.bool_]:
    ends = np.empty(len(states), np.bool_)
    for vertex in range(len(states)):
        ends[vertex] = may_end(limits, states, vertex)
    return ends


@kernel
def _sorted_edges(
    vertices: NDArray[np.int64],
    edges: NDArray[np.int32],
    edge_lengths: NDArray[np.float64],
    count: int,
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64], NDArray[np.int32]]:
    """Edges by the ranks of their end and start: two rounds of counting."""
    size = len(vertices)
    rank = np.empty(size, np.int32)
    for i in range(size):
        rank[vertices[i]] = i
    out = np.zeros(size + 1, np.int64)
    starts = np.zeros(size + 1, np.int64)
    for edge in range(count):
        out[rank[edges[edge, TAIL]] + 1] += 1
        starts[rank[edges[edge, HEAD]] + 1] += 1
    for i in range(size):
        out[i + 1] += out[i]
        starts[i + 1] += starts[i]
    by_source = np.empty(count, np.int32)
    for edge in range(count):
        source = rank[edges[edge, TAIL]]
        by_source[out[source]] = edge
        out[source] += 1
    at = starts[:-1].copy()
    sources = np.empty(count, np.int32)
    lengths = np.empty(count)
    words = np.empty(count, np.int32)
    for i in range(count):
        edge = by_source[i]
        end = rank[edges[edge, HEAD]]
        place = at[end]
        at[end] += 1
        sources[place] = rank[edges[edge, TAIL]]
        lengths[place] = edge_lengths[edge]
        words[place] = edges[edge, WORD]
    return starts, sources, lengths, words
