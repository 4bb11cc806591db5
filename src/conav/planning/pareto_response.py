"""The best a robot can do when it wants little of several things at once.

Label setting in the order of time: each pair of a vertex and an automaton state keeps the cost
vectors of ways to it of which none is at least as good as another in every component. Candidates
are taken in lexicographic order, so none dominates one before it; with two components a candidate
is kept when its second is below the last kept one's, with more all kept ones are looked through. A
label is dropped when, with what remains alone in each component, it cannot be at least as good as
the present cost everywhere.

A better response is one that is at least as good in every component and better in one. (The paper
writes a partial order without saying whether all must be strictly better [Zhu2014, Definition 2];
this is dominance.) Of all better ones that with the least sum of its components is taken, of equals
the lexicographically first: nothing dominates it.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.best_response import LEAST_GAIN, Response, Roads, state_after
from conav.planning.steering import MAX_PIECES, connection
from conav.planning.traffic import Traffic, hits
from conav.planning.types import PIECE


def pareto_response(
    roads: tuple[Roads, ...],
    traffic: Traffic,
    robot: int,
    limits: NDArray[np.float64],
    heed: NDArray[np.bool_],
    present: NDArray[np.float64],
    counters: NDArray[np.int64],
) -> Response | None:
    """A path that meets none of the heeded robots and dominates the `present` cost vector.

    `roads` has the same graph once for each component of the cost, (components,) as `present`.
    """
    arranged = roads[0].arranged
    path, cost = _search(
        arranged.states,
        arranged.letters,
        arranged.ends,
        arranged.starts,
        arranged.sources,
        np.stack([each.costs for each in roads], axis=1),
        arranged.words,
        arranged.letters_of_words,
        roads[0].automaton.transition,
        roads[0].automaton.accepting,
        np.stack([each.remaining for each in roads], axis=2),
        roads[0].start_state,
        limits,
        *traffic.arrays,
        robot,
        heed,
        traffic.stays[robot],
        traffic.horizon_s,
        present,
        counters,
    )
    return Response(arranged.vertices[path], cost, 0) if len(path) else None


@kernel
def _can_better(
    cost: NDArray[np.float64], rest: NDArray[np.float64], present: NDArray[np.float64]
) -> bool:
    """Whether cost and rest are nowhere above the present costs, and below in one."""
    better = False
    for i in range(len(cost)):
        total = cost[i] + rest[i]
        # Equal lengths by other vertices differ by rounding, which must not hide a gain elsewhere.
        # Of two costs one may so rise by less than the other falls: the sum falls, and rounds end.
        if not total <= present[i] + LEAST_GAIN or total == np.inf:
            return False
        better |= total < present[i] - LEAST_GAIN
    return better


@kernel
def _before(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Whether a comes before b in lexicographic order."""
    for i in range(len(a)):
        if a[i] != b[i]:
            return a[i] < b[i]
    return False


@kernel
def _dominated(
    cost: NDArray[np.float64], labels: NDArray[np.float64], first: int, until: int
) -> bool:
    """Whether one of the labels, sorted and before `cost`, is nowhere above it."""
    if len(cost) <= 2:
        # The last has the least second component of all.
        return until > first and labels[until - 1, len(cost) - 1] <= cost[len(cost) - 1]
    for label in range(first, until):
        under = True
        for i in range(len(cost)):
            if labels[label, i] > cost[i]:
                under = False
                break
        if under:
            return True
    return False


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
    present: NDArray[np.float64],
    counters: NDArray[np.int64],
) -> tuple[NDArray[np.int64], float]:
    """The path by ranks (empty for none), and its first cost."""
    size = len(letters)
    task_states = len(accepting)
    parts = len(present)
    # Labels of all pairs, those of a pair together and sorted.
    label_cost = np.empty((1024, parts))
    label_from = np.empty((1024, 2), np.int64)  # the label before, the vertex
    label_first = np.zeros((size, task_states), np.int64)
    label_until = np.zeros((size, task_states), np.int64)
    used = 0
    best = np.full(parts, np.inf)
    least = np.inf  # the sum of the best
    best_label = -1
    nothing = np.zeros(parts)
    pieces = np.empty((MAX_PIECES, PIECE))
    rest = np.zeros((1, PIECE))
    for head in range(size):
        first_edge = starts[head]
        until_edge = starts[head + 1]
        room = 0
        for edge in range(first_edge, until_edge):
            tail = int(sources[edge])
            for state in range(task_states):
                room += label_until[tail, state] - label_first[tail, state]
        room = max(room, 1)
        candidates = np.empty((room, parts))
        origin = np.empty((room, 3), np.int64)  # the label before, the edge, the state after
        count = 0
        if head == 0:
            candidates[0] = 0.0
            origin[0, 0] = -1
            origin[0, 1] = -1
            origin[0, 2] = start_state
            if _can_better(candidates[0], remaining[0, start_state], present):
                count = 1
        for edge in range(first_edge, until_edge):
            tail = int(sources[edge])
            for state in range(task_states):
                if label_first[tail, state] == label_until[tail, state]:
                    continue
                after = state_after(
                    state,
                    int(letters[tail]),
                    int(letters[head]),
                    int(words[edge]),
                    letters_of_words,
                    transition,
                )
                for label in range(label_first[tail, state], label_until[tail, state]):
                    for i in range(parts):
                        candidates[count, i] = label_cost[label, i] + costs[edge, i]
                    if not _can_better(candidates[count], remaining[head, after], present):
                        continue
                    origin[count, 0] = label
                    origin[count, 1] = edge
                    origin[count, 2] = after
                    count += 1
        order = np.arange(count)
        for i in range(1, count):  # insertion sort keeps the order of equals
            moved = order[i]
            j = i - 1
            while j >= 0 and _before(candidates[moved], candidates[order[j]]):
                order[j + 1] = order[j]
                j -= 1
            order[j + 1] = moved
        known = np.full(until_edge - first_edge, -1, np.int64)
        while used + count > len(label_cost):
            longer_cost = np.empty((2 * len(label_cost), parts))
            longer_cost[:used] = label_cost[:used]
            label_cost = longer_cost
            longer_from = np.empty((2 * len(label_from), 2), np.int64)
            longer_from[:used] = label_from[:used]
            label_from = longer_from
        for state in range(task_states):
            label_first[head, state] = used
            for i in range(count):
                candidate = order[i]
                if origin[candidate, 2] != state:
                    continue
                cost = candidates[candidate]
                if _dominated(cost, label_cost, label_first[head, state], used):
                    continue
                edge = origin[candidate, 1]
                if edge >= 0:
                    if known[edge - first_edge] < 0:
                        pieces_count = connection(limits, states, int(sources[edge]), head, pieces)
                        counters[0] += 1
                        known[edge - first_edge] = hits(
                            tracks,
                            sizes,
                            firsts,
                            boxes,
                            bodies,
                            span,
                            robot,
                            heed,
                            pieces,
                            pieces_count,
                            1,
                        )
                    if known[edge - first_edge] > 0:
                        continue
                label_cost[used] = cost
                label_from[used, 0] = origin[candidate, 0]
                label_from[used, 1] = head
                used += 1
            label_until[head, state] = used
            if not (accepting[state] and ends[head]):
                continue
            clear = -1  # all labels of this pair rest at the same place and time
            for label in range(label_first[head, state], used):
                total = label_cost[label].sum()
                if total > least or (total == least and not _before(label_cost[label], best)):
                    continue
                if not _can_better(label_cost[label], nothing, present):
                    continue
                if clear < 0:
                    clear = 1
                    if stays and states[head, 2] < horizon:
                        rest[0, 0] = states[head, 2]
                        rest[0, 1] = horizon
                        rest[0, 2] = states[head, 0]
                        rest[0, 3] = states[head, 1]
                        counters[0] += 1
                        if hits(
                            tracks, sizes, firsts, boxes, bodies, span, robot, heed, rest, 1, 1
                        ):
                            clear = 0
                if clear == 0:
                    break
                least = total
                best[:] = label_cost[label]
                best_label = label
    counters[1] += used
    if best_label < 0:
        return np.empty(0, np.int64), np.inf
    length = 0
    label = best_label
    while label >= 0:
        length += 1
        label = label_from[label, 0]
    path = np.empty(length, np.int64)
    label = best_label
    for i in range(length - 1, -1, -1):
        path[i] = label_from[label, 1]
        label = label_from[label, 0]
    return path, best[0]
