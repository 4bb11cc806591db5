"""Growing a graph: where samples come from, and Extend.

In mode "paper" a sample is a place and a time that the start can reach, and Extend is Algorithm 2
of [Zhu2014]: the nearest vertex from which the sample can be reached, in the metric
sqrt(|dx|^2 + (v dt)^2), is moved from by at most eta towards the sample, and the new vertex is kept
if that way is free. In mode "forward" samples are also drawn towards the regions of the task and
around the robot's present path, straight ways at full speed to the regions are tried, and waits
are added, which no random time makes: a robot that waits is at the same place later.

Every sample takes its own random draws by number, so what a seed gives depends neither on the
sizes of arrays nor on how many samples one call makes.
"""

import math

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.games.splitmix64 import below, draw, unit
from conav.planning.graph_arrays import (
    BEFORE,
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
    cell_of,
)
from conav.planning.insert import insert_among
from conav.planning.near import near_vertices, nearest
from conav.planning.obstacles import segment_free
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
from conav.planning.steering import AT_MOST, SPEED
from conav.planning.targets import TRIES, nearest_in, place_in

MAX_CHAIN = 256
"""Vertices of a straight way."""


@kernel
def extend(
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
    targets = len(discs) + len(rings)
    horizon = numbers[HORIZON]
    forward = rule[FORWARD] != 0.0
    for done in range(samples):
        vertices = counts[VERTICES]
        edge = counts[EDGES]
        place = counts[WORDS]
        sample = counts[SAMPLES]
        first = sample * DRAWS
        kind = unit(draw(seed, first))
        some = unit(draw(seed, first + 1))
        radius = connection_radius(vertices + 1, rule[GAMMA], rule[ETA], int(rule[ROOT]))
        # What is added is a line in space and time from a vertex, in a number of steps.
        near = -1
        x = 0.0
        y = 0.0
        t = 0.0
        steps = 1
        found = -1  # vertices that are known to be near
        nears = True
        if not forward:
            x = numbers[FROM_X] + some * (numbers[TO_X] - numbers[FROM_X])
            y = numbers[FROM_Y] + unit(draw(seed, first + 2)) * (numbers[TO_Y] - numbers[FROM_Y])
            early = AT_MOST * _distance(states[0, 0], states[0, 1], x, y) / speed
            t = early + unit(draw(seed, first + 3)) * (horizon - early)
            radius = rule[ETA]
        elif kind < numbers[WAITS]:
            near = below(draw(seed, first + 2), vertices)
            x = states[near, 0]
            y = states[near, 1]
            t = states[near, 2] + some * radius / speed
            nears = False
        elif kind < numbers[WAITS] + numbers[WAYS]:
            nears = False
            near = below(draw(seed, first + 2), vertices)
            t = np.inf
            if targets > 0:
                target = below(draw(seed, first + 3), targets)
                x, y, hit = nearest_in(
                    discs, rings, sides, target, states[near, 0], states[near, 1]
                )
                if hit and segment_free(
                    grid, starts, items, shapes, states[near, 0], states[near, 1], x, y
                ):
                    away = _distance(states[near, 0], states[near, 1], x, y)
                    duration = away / speed * AT_MOST
                    spare = horizon - states[near, 2] - duration
                    if some > 0.5 and spare > 0.0:  # the others drive at full speed
                        late = 2.0 * some - 1.0
                        duration += late * late * spare
                    t = states[near, 2] + duration
                    whole = math.sqrt(away * away + speed * speed * duration * duration)
                    # The radius gets smaller on the way.
                    steps = (
                        int(
                            whole
                            / connection_radius(
                                vertices + MAX_CHAIN, rule[GAMMA], rule[ETA], int(rule[ROOT])
                            )
                            * AT_MOST
                        )
                        + 1
                    )
                    if steps > MAX_CHAIN:
                        t = np.inf
        elif kind < numbers[WAITS] + numbers[WAYS] + numbers[LOCAL] and len(path) > 1:
            # Around a place of the path, mostly close by, and in its time as well.
            leg = below(draw(seed, first + 2), len(path) - 1)
            share = unit(draw(seed, first + 3))
            spread = radius * some * some
            x = path[leg, 0] + share * (path[leg + 1, 0] - path[leg, 0])
            y = path[leg, 1] + share * (path[leg + 1, 1] - path[leg, 1])
            t = path[leg, 2] + share * (path[leg + 1, 2] - path[leg, 2])
            x += spread * (2.0 * unit(draw(seed, first + 4)) - 1.0)
            y += spread * (2.0 * unit(draw(seed, first + 5)) - 1.0)
            t += spread / speed * (2.0 * unit(draw(seed, first + 6)) - 1.0)
        else:
            hit = False
            beyond = numbers[WAITS] + numbers[WAYS] + numbers[LOCAL]
            if beyond <= kind < beyond + numbers[GOALS] and targets > 0:
                target = below(draw(seed, first + 2), targets)
                for trial in range(TRIES):
                    u = unit(draw(seed, first + 8 + 2 * trial))
                    v = unit(draw(seed, first + 9 + 2 * trial))
                    x, y, hit = place_in(discs, rings, sides, target, u, v)
                    if hit:
                        break
            if not hit:
                x = numbers[FROM_X] + unit(draw(seed, first + 4)) * (
                    numbers[TO_X] - numbers[FROM_X]
                )
                y = numbers[FROM_Y] + unit(draw(seed, first + 5)) * (
                    numbers[TO_Y] - numbers[FROM_Y]
                )
            early = AT_MOST * _distance(states[0, 0], states[0, 1], x, y) / speed
            # Early times are the likelier: late ones are reached from them in any case.
            t = early + some * some * (horizon - early)
        outcome = REFUSED
        if 0.0 < t <= horizon:
            if nears:
                # A sample that some vertex reaches within the radius is taken as it is, whichever
                # is the nearest; in mode "paper" the way from that one must be free.
                if forward:
                    found = near_vertices(
                        states, links, heads, box, speed, radius, True, x, y, t, near_ones
                    )
                    for i in range(found):
                        if states[near_ones[i], 2] < t:
                            near = int(near_ones[i])
                            break
                    if near < 0:
                        found = -1
                if near < 0:
                    near = nearest(states, links, heads, box, vertices, speed, x, y, t)
                    if near >= 0:
                        away = _distance(states[near, 0], states[near, 1], x, y)
                        reach = speed * (t - states[near, 2])
                        whole = math.sqrt(away * away + reach * reach)
                        if whole > radius:
                            # A little less: rounding must not put the vertex outside the radius.
                            share = radius / (whole * AT_MOST)
                            x = states[near, 0] + share * (x - states[near, 0])
                            y = states[near, 1] + share * (y - states[near, 1])
                            t = states[near, 2] + share * (t - states[near, 2])
                        if not forward and not segment_free(
                            grid, starts, items, shapes, states[near, 0], states[near, 1], x, y
                        ):
                            near = -1
            if near >= 0:
                x0 = states[near, 0]
                y0 = states[near, 1]
                t0 = states[near, 2]
                for step in range(1, steps + 1):
                    share = step / steps
                    state[0] = x if step == steps else x0 + share * (x - x0)
                    state[1] = y if step == steps else y0 + share * (y - y0)
                    state[2] = t if step == steps else t0 + share * (t - t0)
                    if found < 0:
                        radius = connection_radius(
                            counts[VERTICES] + 1, rule[GAMMA], rule[ETA], int(rule[ROOT])
                        )
                        found = near_vertices(
                            states, links, heads, box, speed, radius, forward, state[0], state[1],
                            state[2], near_ones,
                        )  # fmt: skip
                    outcome = insert_among(
                        grid,
                        starts,
                        items,
                        shapes,
                        discs,
                        rings,
                        sides,
                        masks,
                        limits,
                        rule,
                        states,
                        links,
                        heads,
                        edges,
                        lengths,
                        words,
                        counts,
                        box,
                        state,
                        places,
                        word,
                        pieces,
                        near_ones,
                        found,
                    )
                    found = -1
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
def take_back(
    states: NDArray[np.float64],
    links: NDArray[np.int32],
    heads: NDArray[np.int32],
    counts: NDArray[np.int64],
    box: NDArray[np.float64],
    speed: float,
    vertices: int,
) -> None:
    """Forgets the vertices that came after there were so many."""
    for vertex in range(counts[VERTICES] - 1, vertices - 1, -1):
        cell = cell_of(box, speed, states[vertex, 0], states[vertex, 1], states[vertex, 2])
        heads[cell] = links[vertex, BEFORE]
    counts[VERTICES] = vertices


@kernel
def _distance(ax: float, ay: float, bx: float, by: float) -> float:
    dx = bx - ax
    dy = by - ay
    return math.sqrt(dx * dx + dy * dy)
