"""A robot's cheapest path on its graph with nobody about, some places and ways being barred.

A bar on a place keeps the robot out of a disc at one time, on its way or at rest. A bar on a way
takes out one edge, or one vertex as the path's end.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.best_response import Roads, state_after
from conav.planning.steering import MAX_PIECES, connection
from conav.planning.types import PIECE

END = -1
"""Instead of a way's head: the path may not end at its tail."""


class Place(NamedTuple):
    """At this time [s] the robot is not within the radius [m] of (x, y), borders included."""

    time: float
    x: float
    y: float
    radius: float


class Way(NamedTuple):
    """The robot does not go from one vertex to the other, by ranks, or with `END` stop there."""

    tail: int
    head: int


Bar = Place | Way


def barred_path(
    roads: Roads,
    limits: NDArray[np.float64],
    stays: bool,
    horizon_s: float,
    bars: tuple[Bar, ...],
) -> tuple[NDArray[np.int64], float] | None:
    """A cheapest path within the bars, by ranks, and its cost; None when there is none."""
    places = np.array([bar for bar in bars if isinstance(bar, Place)], np.float64).reshape(-1, 4)
    ways = np.array([bar for bar in bars if isinstance(bar, Way)], np.int64).reshape(-1, 2)
    arranged = roads.arranged
    path, cost = _search(
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
        stays,
        horizon_s,
        places,
        ways,
    )
    return (path, cost) if len(path) else None


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
    stays: bool,
    horizon: float,
    places: NDArray[np.float64],
    ways: NDArray[np.int64],
) -> tuple[NDArray[np.int64], float]:
    """The path, empty for none, and its cost."""
    size = len(letters)
    task_states = len(accepting)
    cost_to = np.full((size, task_states), np.inf)
    edge_to = np.full((size, task_states), -1, np.int64)
    from_state = np.zeros((size, task_states), np.int64)
    pieces = np.empty((MAX_PIECES, PIECE))
    best = np.inf
    last = -1
    last_state = -1
    cost_to[0, start_state] = 0.0
    for head in range(size):
        for edge in range(starts[head], starts[head + 1]):
            tail: int = sources[edge]
            reached = False
            for state in range(task_states):
                reached |= cost_to[tail, state] + costs[edge] < best
            if not reached or _barred(limits, states, tail, head, places, ways, pieces):
                continue
            for state in range(task_states):
                if cost_to[tail, state] == np.inf:
                    continue
                after = state_after(
                    state,
                    letters[tail],
                    letters[head],
                    words[edge],
                    letters_of_words,
                    transition,
                )
                cost = cost_to[tail, state] + costs[edge]
                if cost < cost_to[head, after] and cost + remaining[head, after] < np.inf:
                    cost_to[head, after] = cost
                    edge_to[head, after] = edge
                    from_state[head, after] = state
        for state in range(task_states):
            if accepting[state] and ends[head] and cost_to[head, state] < best:
                x = states[head, 0]
                y = states[head, 1]
                t = states[head, 2]
                allowed = True
                for i in range(len(places)):
                    rests = t <= places[i, 0] <= horizon and (stays or places[i, 0] == t)
                    dx = x - places[i, 1]
                    dy = y - places[i, 2]
                    if rests and dx * dx + dy * dy <= places[i, 3] * places[i, 3]:
                        allowed = False
                for i in range(len(ways)):
                    if ways[i, 0] == head and ways[i, 1] == END:
                        allowed = False
                if allowed:
                    best = cost_to[head, state]
                    last = head
                    last_state = state
    if last < 0:
        return np.empty(0, np.int64), np.inf
    path = np.empty(size, np.int64)
    length = 0
    while True:
        path[size - 1 - length] = last
        length += 1
        if last == 0:
            break
        edge = edge_to[last, last_state]
        last_state = from_state[last, last_state]
        last = sources[edge]
    return path[size - length :].copy(), best


@kernel
def _barred(
    limits: NDArray[np.float64],
    states: NDArray[np.float64],
    tail: int,
    head: int,
    places: NDArray[np.float64],
    ways: NDArray[np.int64],
    pieces: NDArray[np.float64],
) -> bool:
    """Whether an edge is barred."""
    for i in range(len(ways)):
        if ways[i, 0] == tail and ways[i, 1] == head:
            return True
    count = 0
    for i in range(len(places)):
        time = places[i, 0]
        if time < states[tail, 2] or time > states[head, 2]:
            continue
        if count == 0:
            count = connection(limits, states, tail, head, pieces)
        for piece in range(count):
            if pieces[piece, 0] <= time <= pieces[piece, 1]:
                after = time - pieces[piece, 0]
                dx = pieces[piece, 2] + pieces[piece, 4] * after - places[i, 1]
                dy = pieces[piece, 3] + pieces[piece, 5] * after - places[i, 2]
                if dx * dx + dy * dy <= places[i, 3] * places[i, 3]:
                    return True
    return False
