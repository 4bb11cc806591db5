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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.games.splitmix64 import below, draw, unit
from conav.geometry.clearance import point_segment_square
from conav.planning.graph import (
    BEFORE,
    CELL,
    COLUMNS,
    EDGES,
    ETA,
    FORWARD,
    FULL,
    GAMMA,
    LAYERS,
    LEFT,
    LOW,
    REFUSED,
    REJECTED,
    ROOT,
    ROWS,
    SAMPLES,
    VERTICES,
    WORDS,
    RobotGraph,
    cell_of,
    insert,
    width,
)
from conav.planning.labels import in_polygon
from conav.planning.obstacles import segment_free
from conav.planning.radius import connection_radius
from conav.planning.steering import AT_MOST, SPEED, STATE

_DRAWS = 64  # of a sample
_TRIES = 8  # to hit a region from its bounding box
_DEPTH = 1e-6  # [m] straight ways end that far inside a region
_FEW = 400  # vertices that are looked through faster than cells
_RINGS = 5  # of cells around a sample that are looked through before all vertices are
MAX_CHAIN = 256
"""Vertices of a straight way."""

# Places of the numbers a sampler has.
FROM_X, FROM_Y, TO_X, TO_Y, HORIZON, GOALS, STRAIGHT, WAITS, LOCAL = range(9)


class Sampler(NamedTuple):
    """Where samples come from; shares are of all samples, and the rest is uniform."""

    seed: np.uint64
    bounds: tuple[float, float, float, float]  # [m]
    horizon_s: float
    goal_share: float = 0.1  # in a region of the task
    straight_share: float = 0.02  # straight ways from a vertex to a region
    wait_share: float = 0.05  # a vertex, later
    local_share: float = 0.3  # around the present path, if there is one

    @property
    def numbers(self) -> NDArray[np.float64]:
        return np.array(
            [
                *self.bounds,
                self.horizon_s,
                self.goal_share,
                self.straight_share,
                self.wait_share,
                self.local_share,
            ]
        )


def grow(graph: RobotGraph, sampler: Sampler, path: NDArray[np.float64], samples: int) -> None:
    """Adds what the next samples give; `path`, (m, STATE), is the present one, m may be 0."""
    numbers = sampler.numbers
    state = np.empty(STATE)
    while True:
        samples -= extend(
            *graph.surroundings.arrays,
            *graph.arrays,
            state,
            *graph.memory,
            sampler.seed,
            numbers,
            path,
            samples,
        )
        if samples == 0:
            return
        graph.enlarge()


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
    seed: np.uint64,
    numbers: NDArray[np.float64],
    path: NDArray[np.float64],
    samples: int,
) -> int:
    """How many of the samples were used up before the arrays were full."""
    speed = limits[SPEED]
    targets = len(discs) + len(rings)
    horizon = numbers[HORIZON]
    for done in range(samples):
        vertices = counts[VERTICES]
        edge = counts[EDGES]
        place = counts[WORDS]
        sample = counts[SAMPLES]
        first = sample * _DRAWS
        kind = unit(draw(seed, first))
        some = unit(draw(seed, first + 1))
        radius = connection_radius(vertices + 1, rule[GAMMA], rule[ETA], int(rule[ROOT]))
        # What is added is a line in space and time from a vertex, in a number of steps.
        near = -1
        x = 0.0
        y = 0.0
        t = 0.0
        steps = 1
        nears = True
        if rule[FORWARD] == 0.0:
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
        elif kind < numbers[WAITS] + numbers[STRAIGHT]:
            nears = False
            near = below(draw(seed, first + 2), vertices)
            t = np.inf
            if targets > 0:
                target = below(draw(seed, first + 3), targets)
                x, y, found = nearest_in(
                    discs, rings, sides, target, states[near, 0], states[near, 1]
                )
                if found and segment_free(
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
        elif kind < numbers[WAITS] + numbers[STRAIGHT] + numbers[LOCAL] and len(path) > 1:
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
            found = False
            beyond = numbers[WAITS] + numbers[STRAIGHT] + numbers[LOCAL]
            if beyond <= kind < beyond + numbers[GOALS] and targets > 0:
                target = below(draw(seed, first + 2), targets)
                for trial in range(_TRIES):
                    u = unit(draw(seed, first + 8 + 2 * trial))
                    v = unit(draw(seed, first + 9 + 2 * trial))
                    x, y, found = _in_region(discs, rings, sides, target, u, v)
                    if found:
                        break
            if not found:
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
                if rule[FORWARD] != 0.0:
                    near = _some_near(states, links, heads, box, speed, radius, x, y, t)
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
                    if rule[FORWARD] == 0.0 and not segment_free(
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
                    outcome = insert(
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
                    )
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


@kernel
def _some_near(
    states: NDArray[np.float64],
    links: NDArray[np.int32],
    heads: NDArray[np.int32],
    box: NDArray[np.float64],
    speed: float,
    radius: float,
    x: float,
    y: float,
    t: float,
) -> int:
    """Some vertex within the radius from which (x, y, t) can be reached in time, -1 for none."""
    columns = int(box[COLUMNS])
    rows = int(box[ROWS])
    layers = int(box[LAYERS])
    cell = box[CELL]
    layer = min(max(int(speed * t / cell), 0), layers - 1)
    for z in range(layer, max(int((speed * t - radius) / cell), 0) - 1, -1):
        wide = width(z, layers, cell, speed * t, radius)
        for v in range(
            max(int((y - wide - box[LOW]) / cell), 0),
            min(int((y + wide - box[LOW]) / cell), rows - 1) + 1,
        ):
            for u in range(
                max(int((x - wide - box[LEFT]) / cell), 0),
                min(int((x + wide - box[LEFT]) / cell), columns - 1) + 1,
            ):
                old = heads[(z * rows + v) * columns + u]
                while old >= 0:
                    dx = x - states[old, 0]
                    dy = y - states[old, 1]
                    reach = speed * (t - states[old, 2])
                    plane = dx * dx + dy * dy
                    cone = reach * reach
                    if plane <= cone and reach > 0.0 and plane + cone <= radius * radius:
                        return old
                    old = links[old, BEFORE]
    return -1


@kernel
def nearest(
    states: NDArray[np.float64],
    links: NDArray[np.int32],
    heads: NDArray[np.int32],
    box: NDArray[np.float64],
    vertices: int,
    speed: float,
    x: float,
    y: float,
    t: float,
) -> int:
    """The nearest vertex from which (x, y, t) can be reached in time, -1 for none.

    Of equals the first in order of insertion. Distances are compared in squares.
    """
    best = np.inf
    found = -1
    columns = int(box[COLUMNS])
    rows = int(box[ROWS])
    if vertices > _FEW:
        column = min(max(int((x - box[LEFT]) / box[CELL]), 0), columns - 1)
        row = min(max(int((y - box[LOW]) / box[CELL]), 0), rows - 1)
        layer = min(max(int(speed * t / box[CELL]), 0), int(box[LAYERS]) - 1)
        for ring in range(_RINGS):
            for z in range(max(layer - ring, 0), layer + 1):
                for v in range(max(row - ring, 0), min(row + ring, rows - 1) + 1):
                    inner = ring > 0 and layer - z < ring and abs(v - row) < ring
                    for u in range(column - ring, column + ring + 1, 2 * ring if inner else 1):
                        if u < 0 or u >= columns:
                            continue
                        old = heads[(z * rows + v) * columns + u]
                        while old >= 0:
                            dx = x - states[old, 0]
                            dy = y - states[old, 1]
                            reach = speed * (t - states[old, 2])
                            plane = dx * dx + dy * dy
                            cone = reach * reach
                            away = plane + cone
                            if (
                                plane <= cone
                                and reach > 0.0
                                and (away < best or (away == best and old < found))
                            ):
                                best = away
                                found = old
                            old = links[old, BEFORE]
            # Whatever lies outside the rings so far is at least that far away.
            outside = ring * box[CELL]
            if found >= 0 and best <= outside * outside:
                return found
    for old in range(vertices):
        dx = x - states[old, 0]
        dy = y - states[old, 1]
        reach = speed * (t - states[old, 2])
        plane = dx * dx + dy * dy
        cone = reach * reach
        away = plane + cone
        if plane <= cone and reach > 0.0 and (away < best or (away == best and old < found)):
            best = away
            found = old
    return found


@kernel
def _in_region(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    target: int,
    u: float,
    v: float,
) -> tuple[float, float, bool]:
    """A place of a region's bounding box, and whether it is in the region."""
    if target < len(discs):
        dx = 2.0 * u - 1.0
        dy = 2.0 * v - 1.0
        r = discs[target, 2]
        return discs[target, 0] + r * dx, discs[target, 1] + r * dy, dx * dx + dy * dy < 1.0
    ring = target - len(discs)
    x = rings[ring, 2] + u * (rings[ring, 4] - rings[ring, 2])
    y = rings[ring, 3] + v * (rings[ring, 5] - rings[ring, 3])
    return x, y, in_polygon(rings, sides, ring, x, y)


@kernel
def nearest_in(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    target: int,
    x: float,
    y: float,
) -> tuple[float, float, bool]:
    """A place just inside a region, nearest to one outside, and whether there is one."""
    if target < len(discs):
        r = discs[target, 2]
        dx = x - discs[target, 0]
        dy = y - discs[target, 1]
        away = math.sqrt(dx * dx + dy * dy)
        if away <= r:
            return x, y, False
        keep = (r - min(_DEPTH, 0.5 * r)) / away
        return discs[target, 0] + keep * dx, discs[target, 1] + keep * dy, True
    ring = target - len(discs)
    if in_polygon(rings, sides, ring, x, y):
        return x, y, False
    best = np.inf
    found_x = x
    found_y = y
    for side in range(int(rings[ring, 0]), int(rings[ring, 1])):
        x0, y0, x1, y1 = sides[side]
        away = point_segment_square(x, y, x0, y0, x1, y1)
        if away < best:
            best = away
            dx = x1 - x0
            dy = y1 - y0
            length = math.sqrt(dx * dx + dy * dy)
            margin = min(2.0 * _DEPTH / length, 0.5)
            along = ((x - x0) * dx + (y - y0) * dy) / (length * length)
            along = min(max(along, margin), 1.0 - margin)
            # Regions lie on the left of their sides.
            found_x = x0 + along * dx - _DEPTH * dy / length
            found_y = y0 + along * dy + _DEPTH * dx / length
    return found_x, found_y, in_polygon(rings, sides, ring, found_x, found_y)
