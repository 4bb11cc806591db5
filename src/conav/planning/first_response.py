"""The first path found that costs less than the present one, as the paper has it.

Algorithm 3 of [Zhu2014] goes through the paths from the root and takes the first that improves.
The paper does not say in which order; here it is depth first, the vertices after a vertex in the
order of their numbers. What cannot improve is not entered: a pair of vertex and automaton state
whose cost and remaining cost alone reach the present cost, or that was left in vain at no more cost
before. Whether some path improves is decided exactly as by `conav.planning.best_response`.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.best_response import Response, Roads, state_after
from conav.planning.steering import MAX_PIECES, connection
from conav.planning.traffic import Traffic, hits
from conav.planning.types import PIECE


def first_response(
    roads: Roads,
    traffic: Traffic,
    robot: int,
    limits: NDArray[np.float64],
    heed: NDArray[np.bool_],
    bound: float,
    counters: NDArray[np.int64],
) -> Response | None:
    """The first path that meets none of the heeded robots and costs less than `bound`."""
    arranged = roads.arranged
    if not roads.alone < bound:
        return None
    path, cost = _descend(
        arranged.vertices,
        arranged.states,
        arranged.letters,
        arranged.ends,
        arranged.starts,
        arranged.sources,
        roads.costs,
        arranged.words,
        arranged.letters_of_words,
        roads.automaton.transition,
        roads.automaton.accepting,
        roads.remaining,
        roads.start_state,
        limits,
        *traffic.arrays,
        robot,
        heed,
        traffic.stays[robot],
        traffic.horizon_s,
        bound,
        counters,
    )
    return Response(arranged.vertices[path], cost, 0) if len(path) else None


@kernel
def _descend(
    vertices: NDArray[np.int64],
    states: NDArray[np.float64],
    letters: NDArray[np.int32],
    ends: NDArray[np.bool_],
    starts: NDArray[np.int64],
    sources: NDArray[np.int32],
    costs: NDArray[np.float64],
    words: NDArray[np.int32],
    letters_of_words: NDArray[np.int32],
    transition: NDArray[np.int32],
    accepting: NDArray[np.bool_],
    remaining: NDArray[np.float64],
    start_state: int,
    limits: NDArray[np.float64],
    tracks: NDArray[np.float64],
    sizes: NDArray[np.int64],
    firsts: NDArray[np.int64],
    boxes: NDArray[np.float64],
    bodies: NDArray[np.float64],
    span: float,
    robot: int,
    heed: NDArray[np.bool_],
    stays: bool,
    horizon: float,
    bound: float,
    counters: NDArray[np.int64],
) -> tuple[NDArray[np.int64], float]:
    """The path by ranks (empty for none), and its cost."""
    size = len(letters)
    edges = len(sources)
    # The edges out of each vertex, in the order of the vertices they go to.
    outs = np.zeros(size + 1, np.int64)
    heads = np.empty(edges, np.int32)
    for head in range(size):
        for edge in range(starts[head], starts[head + 1]):
            outs[sources[edge] + 1] += 1
            heads[edge] = head
    for vertex in range(size):
        outs[vertex + 1] += outs[vertex]
    rank = np.empty(size, np.int64)
    for i in range(size):
        rank[vertices[i]] = i
    at = outs[:-1].copy()
    out_edges = np.empty(edges, np.int64)
    for number in range(size):
        head = rank[number]
        for edge in range(starts[head], starts[head + 1]):
            out_edges[at[sources[edge]]] = edge
            at[sources[edge]] += 1
    clear = np.full(edges, -1, np.int8)
    in_vain = np.full((size, len(accepting)), np.inf)  # the least cost at which it was left
    pieces = np.empty((MAX_PIECES, PIECE))
    rest = np.zeros((1, PIECE))
    # The present path: at each depth a vertex, a state, a cost, and the next edge to try.
    on_path = np.zeros(size, np.int64)
    on_state = np.zeros(size, np.int64)
    on_cost = np.zeros(size)
    tried = np.zeros(size, np.int64)
    on_state[0] = start_state
    tried[0] = outs[0]
    depth = 0
    arrived = True  # at a new place, which may be the end
    while depth >= 0:
        tail = int(on_path[depth])
        state = int(on_state[depth])
        cost = on_cost[depth]
        if arrived:
            counters[1] += 1
            arrived = False
            if accepting[state] and ends[tail] and cost < bound:
                free = True
                if stays and states[tail, 2] < horizon:
                    rest[0, 0] = states[tail, 2]
                    rest[0, 1] = horizon
                    rest[0, 2] = states[tail, 0]
                    rest[0, 3] = states[tail, 1]
                    counters[0] += 1
                    free = (
                        hits(tracks, sizes, firsts, boxes, bodies, span, robot, heed, rest, 1, 1)
                        == 0
                    )
                if free:
                    return on_path[: depth + 1].copy(), cost
        if tried[depth] == outs[tail + 1]:
            in_vain[tail, state] = min(in_vain[tail, state], cost)
            depth -= 1
            continue
        edge = out_edges[tried[depth]]
        tried[depth] += 1
        head = int(heads[edge])
        after = state_after(
            state,
            int(letters[tail]),
            int(letters[head]),
            int(words[edge]),
            letters_of_words,
            transition,
        )
        next_cost = cost + costs[edge]
        if next_cost + remaining[head, after] >= bound or next_cost >= in_vain[head, after]:
            continue
        if clear[edge] < 0:
            count = connection(limits, states, tail, head, pieces)
            counters[0] += 1
            hit = hits(tracks, sizes, firsts, boxes, bodies, span, robot, heed, pieces, count, 1)
            clear[edge] = 1 if hit == 0 else 0
        if clear[edge] == 0:
            continue
        depth += 1
        on_path[depth] = head
        on_state[depth] = after
        on_cost[depth] = next_cost
        tried[depth] = outs[head]
        arrived = True
    return np.empty(0, np.int64), np.inf
