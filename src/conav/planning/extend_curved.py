"""Growing the graph of a robot whose ways are curves.

Samples come from where those of straight ways come from (`conav.planning.extend`), and each has a
velocity or a heading besides: any, or around the present path its own and some more. Double
integrators are drawn at rest in three of ten samples and in most of those in a region, where paths
end. A sample is taken as it is if some vertex has a way to it. Otherwise, as Algorithm 2 of
[Zhu2014] has it, the way from the nearest vertex to it, in the time between or as soon as can be,
is followed for a radius at most. In mode "paper" that is all there is, and samples are uniform.
"""

import math

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.games.splitmix64 import below, draw, unit
from conav.geometry.elementary import PI
from conav.planning.curves import pieces_free
from conav.planning.extend import MAX_CHAIN, take_back
from conav.planning.graph_arrays import (
    EDGES,
    ETA,
    FORWARD,
    FULL,
    GAMMA,
    REFUSED,
    REJECTED,
    ROOT,
    SAMPLES,
    VERTICES,
    WORDS,
)
from conav.planning.insert_curved import insert_curved
from conav.planning.motion_states import (
    aim,
    come_to_rest,
    draw_rest,
    slow_down,
    soonest,
    stand,
    state_on_way,
)
from conav.planning.near import nearest
from conav.planning.radius import connection_radius
from conav.planning.sampler import (
    DRAWS,
    FROM_X,
    FROM_Y,
    GOALS,
    HORIZON,
    LOCAL,
    TO_X,
    TO_Y,
    WAITS,
    WAYS,
)
from conav.planning.steering import ACCELERATED, AT_MOST, MOTION, SPEED, connection
from conav.planning.targets import TRIES, nearest_in, place_in

_LONGEST = 1.4143  # root of 2: metres in space and time of a metre at full speed

WAIT, WAY, PLACE = range(3)
"""Kinds of samples: a vertex at rest, a way to a region, a state."""


@kernel
def extend_curved(
    grid: NDArray[np.float64],
    starts: NDArray[np.int32],
    items: NDArray[np.int32],
    shapes: NDArray[np.float64],
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    masks: NDArray[np.int64],
    limits: NDArray[np.float64],
    rule: NDArray[np.float64],
    states: NDArray[np.float64],
    links: NDArray[np.int32],
    heads: NDArray[np.int32],
    edges: NDArray[np.int32],
    lengths: NDArray[np.float64],
    words: NDArray[np.int32],
    counts: NDArray[np.int64],
    box: NDArray[np.float64],
    state: NDArray[np.float64],
    places: NDArray[np.float64],
    word: NDArray[np.int64],
    pieces: NDArray[np.float64],
    near_ones: NDArray[np.int32],
    seed: np.uint64,
    numbers: NDArray[np.float64],
    path: NDArray[np.float64],
    samples: int,
) -> int:
    """How many of the samples were used up before the arrays were full."""
    speed = limits[SPEED]
    horizon = numbers[HORIZON]
    forward = rule[FORWARD] != 0.0
    pair = np.empty((2, states.shape[1]))
    way = np.empty_like(pieces)
    for done in range(samples):
        vertices = counts[VERTICES]
        edge = counts[EDGES]
        place = counts[WORDS]
        sample = counts[SAMPLES]
        first = sample * DRAWS
        radius = connection_radius(vertices + 1, rule[GAMMA], rule[ETA], int(rule[ROOT]))
        choice = unit(draw(seed, first)) if forward else 1.0
        kind = PLACE
        if choice < numbers[WAITS]:
            kind = WAIT
        elif choice < numbers[WAITS] + numbers[WAYS]:
            kind = WAY
        near = -1
        count = 0
        steps = 1
        outcome = REFUSED
        if kind == PLACE:
            _draw_state(
                discs,
                rings,
                sides,
                limits,
                states,
                seed,
                first,
                numbers,
                path,
                radius,
                forward,
                state,
            )
            if 0.0 < state[2] <= horizon:
                if forward:
                    outcome = insert_curved(
                        grid, starts, items, shapes, discs, rings, sides, masks, limits, rule,
                        states, links, heads, edges, lengths, words, counts, box, state, places,
                        word, pieces, near_ones,
                    )  # fmt: skip
                if outcome == REFUSED:
                    near = nearest(
                        states, links, heads, box, vertices, speed, state[0], state[1], state[2]
                    )
            if near >= 0:
                for i in range(len(state)):
                    pair[0, i] = states[near, i]
                    pair[1, i] = state[i]
                count = connection(limits, pair, 0, 1, way)
                if count == 0:
                    count = soonest(limits, pair, way)
        elif kind == WAIT:
            near = below(draw(seed, first + 1), vertices)
            come_to_rest(limits, states, near, state)
            state[2] += unit(draw(seed, first + 2)) * radius / speed
            for i in range(len(state)):
                pair[0, i] = states[near, i]
                pair[1, i] = state[i]
            if state[2] > pair[0, 2]:
                count = connection(limits, pair, 0, 1, way)
        else:
            near = below(draw(seed, first + 1), vertices)
            count = _to_region(
                discs, rings, sides, limits, states, seed, first, horizon, near, pair, way
            )
            smallest = connection_radius(
                vertices + MAX_CHAIN, rule[GAMMA], rule[ETA], int(rule[ROOT])
            )
            steps = int(_LONGEST * speed * (pair[1, 2] - pair[0, 2]) / smallest) + 1
            if steps > MAX_CHAIN:
                count = 0
        if count > 0 and kind == PLACE:
            longest = radius if forward else rule[ETA]
            whole = _LONGEST * speed * (pair[1, 2] - pair[0, 2])
            if whole > longest:
                pair[1, 2] = pair[0, 2] + longest / whole * (pair[1, 2] - pair[0, 2])
            # In mode "forward" the insertion looks at it, and other ways in will do.
            if not forward and not pieces_free(grid, starts, items, shapes, way, count):
                count = 0
        if count > 0 and kind == WAY and not pieces_free(grid, starts, items, shapes, way, count):
            count = 0
        if count > 0 and pair[1, 2] <= horizon:
            begin = pair[0, 2]
            duration = pair[1, 2] - begin
            for step in range(1, steps + 1):
                if kind == PLACE or step < steps:
                    state_on_way(
                        limits, pair[0], way, count, begin + step / steps * duration, state
                    )
                else:
                    for i in range(len(state)):
                        state[i] = pair[1, i]
                outcome = insert_curved(
                    grid, starts, items, shapes, discs, rings, sides, masks, limits, rule, states,
                    links, heads, edges, lengths, words, counts, box, state, places, word, pieces,
                    near_ones,
                )  # fmt: skip
                if outcome <= 0:
                    break
        if outcome == FULL:
            take_back(states, links, heads, counts, box, speed, vertices)
            counts[EDGES] = edge
            counts[WORDS] = place
            return done
        if outcome == REFUSED:
            counts[REJECTED] += 1
        counts[SAMPLES] = sample + 1
    return samples


@kernel
def _draw_state(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    limits: NDArray[np.float64],
    states: NDArray[np.float64],
    seed: np.uint64,
    first: int,
    numbers: NDArray[np.float64],
    path: NDArray[np.float64],
    radius: float,
    forward: bool,
    state: NDArray[np.float64],
) -> None:
    """Fills in a state: around the path, in a region, or anywhere."""
    speed = limits[SPEED]
    targets = len(discs) + len(rings)
    # The draw that chose the kind, on what is left of it.
    kind = unit(draw(seed, first)) - numbers[WAITS] - numbers[WAYS]
    some = unit(draw(seed, first + 1))
    if forward and kind < numbers[LOCAL] and len(path) > 1:
        leg = below(draw(seed, first + 2), len(path) - 1)
        share = unit(draw(seed, first + 3))
        spread = radius * some * some
        dx = path[leg + 1, 0] - path[leg, 0]
        dy = path[leg + 1, 1] - path[leg, 1]
        dt = path[leg + 1, 2] - path[leg, 2]
        for i in range(len(state)):
            state[i] = path[leg, i]
        if dx * dx + dy * dy > 0.0 and dt > 0.0:
            aim(limits, state, dx, dy, dt)
        turned = spread / radius * (2.0 * unit(draw(seed, first + 7)) - 1.0)
        if limits[MOTION] == ACCELERATED:
            state[3] += speed * turned
            state[4] += speed * spread / radius * (2.0 * unit(draw(seed, first + 8)) - 1.0)
            slow_down(limits, state)
        else:
            state[3] += PI * turned
        state[0] += share * dx + spread * (2.0 * unit(draw(seed, first + 4)) - 1.0)
        state[1] += share * dy + spread * (2.0 * unit(draw(seed, first + 5)) - 1.0)
        state[2] += share * dt + spread / speed * (2.0 * unit(draw(seed, first + 6)) - 1.0)
        return
    draw_rest(
        limits,
        state,
        unit(draw(seed, first + 6)),
        unit(draw(seed, first + 7)),
        unit(draw(seed, first + 8)),
    )
    found = False
    if forward and numbers[LOCAL] <= kind < numbers[LOCAL] + numbers[GOALS] and targets > 0:
        target = below(draw(seed, first + 2), targets)
        for trial in range(TRIES):
            u = unit(draw(seed, first + 10 + 2 * trial))
            v = unit(draw(seed, first + 11 + 2 * trial))
            state[0], state[1], found = place_in(discs, rings, sides, target, u, v)
            if found:
                break
        if found and unit(draw(seed, first + 3)) < 0.7:
            stand(limits, state)
    if not found:
        u = unit(draw(seed, first + 4))
        v = unit(draw(seed, first + 5))
        state[0] = numbers[FROM_X] + u * (numbers[TO_X] - numbers[FROM_X])
        state[1] = numbers[FROM_Y] + v * (numbers[TO_Y] - numbers[FROM_Y])
    dx = state[0] - states[0, 0]
    dy = state[1] - states[0, 1]
    early = AT_MOST * math.sqrt(dx * dx + dy * dy) / speed
    # Early times are the likelier: late ones are reached from them in any case.
    late = some * some if forward else some
    state[2] = early + late * (numbers[HORIZON] - early)


@kernel
def _to_region(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    limits: NDArray[np.float64],
    states: NDArray[np.float64],
    seed: np.uint64,
    first: int,
    horizon: float,
    near: int,
    pair: NDArray[np.float64],
    way: NDArray[np.float64],
) -> int:
    """The number of pieces of a way from a vertex to a region, whose ends are put into `pair`."""
    targets = len(discs) + len(rings)
    for i in range(pair.shape[1]):
        pair[0, i] = states[near, i]
        pair[1, i] = states[near, i]
    if targets == 0:
        return 0
    target = below(draw(seed, first + 2), targets)
    x = pair[0, 0]
    y = pair[0, 1]
    to_x, to_y, found = nearest_in(discs, rings, sides, target, x, y)
    if not found:
        return 0
    pair[1, 0] = to_x
    pair[1, 1] = to_y
    aim(limits, pair[1], to_x - x, to_y - y, 1.0)
    stand(limits, pair[1])
    count = soonest(limits, pair, way)
    spare = horizon - pair[1, 2]
    late = 2.0 * unit(draw(seed, first + 3)) - 1.0
    if count > 0 and late > 0.0 and spare > 0.0:  # the others drive as fast as can be
        pair[1, 2] += late * late * spare
        count = connection(limits, pair, 0, 1, way)
    return count
