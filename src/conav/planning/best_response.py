"""The best a robot can do on its graph while the others' trajectories stand.

One pass in the order of time over pairs of a vertex and a state of the task's automaton, since
every edge goes forward in time: the least cost to each, and the edge it came by. The paper
enumerates all paths, of which there are exponentially many [Zhu2014, Algorithm 3]; the answer is
the same. An edge is tested against the others only when no cheaper way in is clear, and a pair only
looked at when its cost and the rest of the way, as if nobody were about, stay below what is known.

With `tolerated` above 0 others may be run into that many times: of all paths then one with the
fewest edges that hit somebody, counted once for each robot they hit, and of those a cheapest.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.games.splitmix64 import draw, unit
from conav.planning.arranged import Arranged
from conav.planning.graph_arrays import ONE_CHANGE
from conav.planning.steering import MAX_PIECES, connection
from conav.planning.traffic import Traffic, hits
from conav.planning.types import PIECE
from conav.tasks.automaton import INITIAL, Automaton

LEAST_GAIN = 1e-9
"""[m or s] what a better response must gain: less is rounding."""


@dataclass(frozen=True, eq=False)
class Response:
    """A path on a graph, by numbers of vertices from the start's, and what it costs."""

    path: NDArray[np.int64]  # (n,) n >= 1
    cost: float  # the first component
    conflicts: int  # edges and robots they hit; 0 unless some were tolerated


@dataclass(frozen=True, eq=False)
class Roads:
    """A graph in the order of time with a cost, and what the rest of the way costs alone.

    `remaining`, (vertices, states), is the least cost from each pair to the end of the task when
    nobody else is about, infinite where it cannot be done.
    """

    arranged: Arranged
    costs: NDArray[np.float64]  # (edges,)
    remaining: NDArray[np.float64]
    automaton: Automaton
    start_state: int

    @property
    def alone(self) -> float:
        """The least cost on this graph when nobody else is about, infinite for none."""
        return float(self.remaining[0, self.start_state])


def edge_costs(arranged: Arranged, component: str) -> NDArray[np.float64]:
    """What each edge costs, (edges,): `length` [m] or `duration` [s]."""
    if component == "length":
        return arranged.lengths
    times = arranged.states[:, 2]
    heads = np.repeat(np.arange(len(times)), np.diff(arranged.starts))
    return times[heads] - times[arranged.sources]


def make_roads(arranged: Arranged, automaton: Automaton, costs: NDArray[np.float64]) -> Roads:
    """The graph made ready for responses in one cost, (edges,) of each edge."""
    remaining = remaining_costs(
        arranged.letters,
        arranged.ends,
        arranged.starts,
        arranged.sources,
        costs,
        arranged.words,
        arranged.letters_of_words,
        automaton.transition,
        automaton.accepting,
        automaton.sink,
    )
    start = int(automaton.transition[INITIAL, arranged.letters[0]])
    return Roads(arranged, costs, remaining, automaton, start)


def best_response(
    roads: Roads,
    traffic: Traffic,
    robot: int,
    limits: NDArray[np.float64],
    heed: NDArray[np.bool_],
    bound: float,
    counters: NDArray[np.int64],
    tolerated: int = 0,
) -> Response | None:
    """A cheapest path that meets none of the heeded robots, if it costs less than `bound`.

    `counters`, (2,), grows by the edges and rests tested against others and by the pairs reached.
    """
    arranged = roads.arranged
    if not roads.alone < bound:
        return None
    path, cost, conflicts = _search(
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
        tolerated,
        counters,
    )
    if len(path) == 0:
        return None
    return Response(arranged.vertices[path], cost, conflicts)


@kernel
def random_costs(lengths: NDArray[np.float64], seed: np.uint64) -> NDArray[np.float64]:
    """Each length times a random number from 1 to 2: cheapest paths then differ, and wait."""
    costs = np.empty(len(lengths))
    for edge in range(len(lengths)):
        costs[edge] = lengths[edge] * (1.0 + unit(draw(seed, edge)))
    return costs


@kernel
def state_after(
    state: int,
    tail_letter: int,
    head_letter: int,
    word: int,
    letters_of_words: NDArray[np.int32],
    transition: NDArray[np.int32],
) -> int:
    """The automaton's state after an edge."""
    if word == ONE_CHANGE:
        return state if tail_letter == head_letter else transition[state, head_letter]
    for i in range(word + 1, word + 1 + letters_of_words[word]):
        state = transition[state, letters_of_words[i]]
    return state


@kernel
def remaining_costs(
    letters: NDArray[np.int32],
    ends: NDArray[np.bool_],
    starts: NDArray[np.int64],
    sources: NDArray[np.int32],
    costs: NDArray[np.float64],
    words: NDArray[np.int32],
    letters_of_words: NDArray[np.int32],
    transition: NDArray[np.int32],
    accepting: NDArray[np.bool_],
    sink: NDArray[np.bool_],
) -> NDArray[np.float64]:
    """The least cost from each vertex and state to the end of the task, (vertices, states)."""
    size = len(letters)
    states = len(accepting)
    remaining = np.full((size, states), np.inf)
    for head in range(size - 1, -1, -1):
        for state in range(states):
            if accepting[state] and ends[head]:
                remaining[head, state] = 0.0
        for edge in range(starts[head], starts[head + 1]):
            tail = int(sources[edge])
            for state in range(states):
                if sink[state]:
                    continue
                after = state_after(
                    state,
                    int(letters[tail]),
                    int(letters[head]),
                    int(words[edge]),
                    letters_of_words,
                    transition,
                )
                cost = costs[edge] + remaining[head, after]
                if cost < remaining[tail, state]:
                    remaining[tail, state] = cost
    return remaining


@kernel
def _search(
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
    tolerated: int,
    counters: NDArray[np.int64],
) -> tuple[NDArray[np.int64], float, int]:
    """A cheapest path by ranks (empty for none), its cost and its conflicts."""
    size = len(letters)
    task_states = len(accepting)
    cost_to = np.full((size, task_states), np.inf)
    hits_to = np.zeros((size, task_states), np.int64)
    edge_to = np.full((size, task_states), -1, np.int64)
    from_state = np.zeros((size, task_states), np.int64)
    best_cost = bound
    best_hits = tolerated
    last = -1
    last_state = -1
    pieces = np.empty((MAX_PIECES, PIECE))
    rest = np.zeros((1, PIECE))
    most = 0
    for head in range(size):
        most = max(most, starts[head + 1] - starts[head])
    known = np.empty(most, np.int64)  # hits of each edge into a vertex, -1 while not tested
    cheapest = np.empty(task_states)
    fewest = np.empty(task_states, np.int64)
    by_edge = np.empty(task_states, np.int64)
    by_state = np.empty(task_states, np.int64)
    settled = np.empty(task_states, np.bool_)
    for head in range(size):
        first = starts[head]
        until = starts[head + 1]
        if head == 0:
            cost_to[0, start_state] = 0.0
        else:
            known[: until - first] = -1
            settled[:] = False
            while True:
                # The best way into each state, by what is known of its edge so far.
                cheapest[:] = np.inf
                by_edge[:] = -1
                for edge in range(first, until):
                    tail = int(sources[edge])
                    run_into = max(known[edge - first], 0)
                    for state in range(task_states):
                        if cost_to[tail, state] == np.inf:
                            continue
                        after = state_after(
                            state,
                            int(letters[tail]),
                            int(letters[head]),
                            int(words[edge]),
                            letters_of_words,
                            transition,
                        )
                        cost = cost_to[tail, state] + costs[edge]
                        run = hits_to[tail, state] + run_into
                        if run > best_hits or (
                            run == best_hits and cost + remaining[head, after] >= best_cost
                        ):
                            continue
                        if remaining[head, after] == np.inf:
                            continue
                        if (
                            by_edge[after] < 0
                            or run < fewest[after]
                            or (run == fewest[after] and cost < cheapest[after])
                        ):
                            cheapest[after] = cost
                            fewest[after] = run
                            by_edge[after] = edge
                            by_state[after] = state
                again = False
                for state in range(task_states):
                    edge = by_edge[state]
                    if settled[state] or edge < 0:
                        continue
                    if known[edge - first] < 0:
                        count = connection(limits, states, int(sources[edge]), head, pieces)
                        counters[0] += 1
                        known[edge - first] = hits(
                            tracks,
                            sizes,
                            firsts,
                            boxes,
                            bodies,
                            span,
                            robot,
                            heed,
                            pieces,
                            count,
                            tolerated + 1,
                        )
                    # The edge may have been tested just now, for another state even: a way that was
                    # chosen by what was known before is chosen anew.
                    run = hits_to[sources[edge], by_state[state]] + known[edge - first]
                    if run > fewest[state]:
                        again = True
                        continue
                    settled[state] = True
                    cost_to[head, state] = cheapest[state]
                    hits_to[head, state] = fewest[state]
                    edge_to[head, state] = edge
                    from_state[head, state] = by_state[state]
                if not again:
                    break
        for state in range(task_states):
            if not (accepting[state] and ends[head]) or cost_to[head, state] == np.inf:
                continue
            run = hits_to[head, state]
            cost = cost_to[head, state]
            if run > best_hits or (run == best_hits and cost >= best_cost):
                continue
            if stays and states[head, 2] < horizon:
                rest[0, 0] = states[head, 2]
                rest[0, 1] = horizon
                rest[0, 2] = states[head, 0]
                rest[0, 3] = states[head, 1]
                counters[0] += 1
                run += hits(
                    tracks,
                    sizes,
                    firsts,
                    boxes,
                    bodies,
                    span,
                    robot,
                    heed,
                    rest,
                    1,
                    tolerated + 1,
                )
            if run < best_hits or (run == best_hits and cost < best_cost):
                best_hits = run
                best_cost = cost
                last = head
                last_state = state
    reached = 0
    for head in range(size):
        for state in range(task_states):
            reached += cost_to[head, state] < np.inf
    counters[1] += reached
    if last < 0:
        return np.empty(0, np.int64), np.inf, 0
    length = 1
    head = last
    state = last_state
    while head > 0:
        edge = edge_to[head, state]
        state = from_state[head, state]
        head = sources[edge]
        length += 1
    path = np.empty(length, np.int64)
    head = last
    state = last_state
    for i in range(length - 1, -1, -1):
        path[i] = head
        if i > 0:
            edge = edge_to[head, state]
            state = from_state[head, state]
            head = sources[edge]
    return path, best_cost, best_hits
