"""A robot's graph: states in space and time, and the ways between them.

The vertices, in the order they came, say everything: vertex 0 is the start at time 0, and the
edges follow by a rule. With k the greater of the two vertices' numbers, plus 1, there is an edge
from u to w exactly when

1. t_u < t_w (in mode "paper" also u < w: from older to newer vertices alone, as in Algorithm 2
   Extend of [Zhu2014]),
2. |dx|^2 + |dy|^2 <= (v dt)^2: the robot can be in time,
3. |dx|^2 + |dy|^2 + (v dt)^2 <= r(k)^2 with the radius of `conav.planning.radius`,
4. the straight way is free of walls and discs (`conav.planning.obstacles`),
5. it has a word (`conav.planning.labels`): no region's border is met so closely that rounding
   decides; in mode "paper" the label changes once at most ("trace inclusive").

Old graphs are part of newer ones and time makes every one acyclic, in both modes, which is what
the convergence of iNash needs. Mode "forward" has about twice the edges for the same vertices.
How vertices are found is no part of the rule (`conav.planning.extend`).
"""

import math
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.labels import (
    MAX_EVENTS,
    UNCLEAR,
    Regions,
    meets_regions,
    on_border,
    point_label,
    segment_word,
)
from conav.planning.obstacles import Obstacles, segment_free
from conav.planning.radius import connection_radius
from conav.planning.steering import MAX_PIECES, SPEED, STATE, connection, connection_length
from conav.planning.types import PIECE

Mode = Literal["forward", "paper"]
Exponent = Literal["d", "d+1"]

# Places of `Graph.counts`.
VERTICES, EDGES, WORDS, SAMPLES, REJECTED, EDGE_TESTS, COUNTS = range(7)

# Places of a rule, and of a graph's box.
ETA, GAMMA, ROOT, FORWARD = range(4)
LEFT, LOW, CELL, COLUMNS, ROWS, LAYERS = range(6)

# Columns of `Graph.links` and `Graph.edges`.
LETTER, BEFORE = range(2)
TAIL, HEAD, WORD = range(3)

ADDED, REFUSED, FULL = 1, 0, -1
"""What came of a vertex: it is in, it has no way in, or the arrays are too short."""

ONE_CHANGE = -1
"""Instead of a place in `words`: the edge changes the label to that of its end, or not at all."""

MAX_CELLS = 1 << 20
_CELLS = 2  # of a graph in the greatest radius

# Boxes around what may be connected are larger by that, far above rounding.
_MORE = 1.0 + 1e-9
_MARGIN = 1e-9  # [m]


Memory = tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]

SurroundingArrays = tuple[
    NDArray[np.float64],
    NDArray[np.int32],
    NDArray[np.int32],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.int64],
    NDArray[np.float64],
    NDArray[np.float64],
]


class Surroundings(NamedTuple):
    """What a robot's graph is made in, in the order in which kernels take it."""

    obstacles: Obstacles
    regions: Regions
    masks: NDArray[np.int64]  # (letters,) the label of each letter
    limits: NDArray[np.float64]  # of the motion
    rule: NDArray[np.float64]

    @property
    def arrays(self) -> "SurroundingArrays":
        grid, starts, items, shapes = self.obstacles
        discs, rings, sides = self.regions
        return (
            grid, starts, items, shapes, discs, rings, sides, self.masks, self.limits, self.rule
        )  # fmt: skip


class Graph(NamedTuple):
    """Arrays for kernels, in their order; what is in use of them is in `counts`."""

    states: NDArray[np.float64]  # (vertices, STATE) x, y [m], t [s], ...
    links: NDArray[np.int32]  # (vertices, 2) letter; the vertex before in the same cell, -1
    heads: NDArray[np.int32]  # (cells,) the newest vertex in each cell of x, y, v t, -1
    edges: NDArray[np.int32]  # (edges, 3) from, to, where in `words` its letters are
    lengths: NDArray[np.float64]  # (edges,) [m]
    words: NDArray[np.int32]  # a count and so many letters, for each edge with several changes
    counts: NDArray[np.int64]
    box: NDArray[np.float64]  # left, low, cell [m], columns, rows, layers


def make_rule(eta_m: float, gamma_m: float, exponent: Exponent, mode: Mode) -> NDArray[np.float64]:
    """What decides about edges, beside the scene, as an array."""
    return np.array([eta_m, gamma_m, 3 if exponent == "d" else 4, mode == "forward"], np.float64)


@dataclass(eq=False)
class RobotGraph:
    """A growing graph of one robot. `arrays` is replaced when it gets too short."""

    surroundings: Surroundings
    arrays: Graph
    memory: "Memory" = field(default_factory=lambda: scratch())

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Shape (n, STATE), in order of insertion: a view."""
        return self.arrays.states[: self.size]

    @property
    def size(self) -> int:
        return int(self.arrays.counts[VERTICES])

    @property
    def edges(self) -> int:
        return int(self.arrays.counts[EDGES])

    def radius_at(self, count: int) -> float:
        """The connection radius [m] for the vertex that makes them `count`."""
        rule = self.surroundings.rule
        return connection_radius(count, float(rule[GAMMA]), float(rule[ETA]), int(rule[ROOT]))

    def enlarge(self) -> None:
        """Twice the room for whatever is more than half full, and for all where nothing is."""
        graph = self.arrays
        used = {
            "states": graph.counts[VERTICES],
            "links": graph.counts[VERTICES],
            "edges": graph.counts[EDGES],
            "lengths": graph.counts[EDGES],
            "words": graph.counts[WORDS],
        }
        full = [name for name in used if 2 * used[name] >= len(getattr(graph, name))]
        longer: dict[str, NDArray[np.generic]] = {}
        for name in full or used:
            old = getattr(graph, name)
            new = np.empty((2 * len(old), *old.shape[1:]), old.dtype)
            new[: len(old)] = old
            longer[name] = new
        self.arrays = graph._replace(**longer)

    def insert(self, states: NDArray[np.float64]) -> int:
        """How many of these states, (m, STATE), came in as vertices, each with all its edges."""
        added = 0
        done = 0
        while done < len(states):
            outcome = insert(*self.surroundings.arrays, *self.arrays, states[done], *self.memory)
            if outcome == FULL:
                self.enlarge()
            else:
                added += outcome
                done += 1
        return added


def scratch() -> "Memory":
    """Memory for kernels to work in: places, word, pieces."""
    return (
        np.empty(MAX_EVENTS),
        np.empty(3 * MAX_EVENTS, np.int64),
        np.empty((MAX_PIECES, PIECE)),
    )


def build_graph(
    surroundings: Surroundings,
    bounds: tuple[float, float, float, float],
    horizon_s: float,
    start: NDArray[np.float64],
) -> RobotGraph:
    """The graph of the start alone, shape (STATE,), its letter being one of the task's."""
    x0, y0, x1, y1 = bounds
    extent = surroundings.limits[SPEED] * horizon_s
    cell = float(surroundings.rule[ETA]) / _CELLS
    while ((x1 - x0) / cell + 1) * ((y1 - y0) / cell + 1) * (extent / cell + 1) > MAX_CELLS:
        cell *= 2
    columns, rows, layers = (int(size / cell) + 1 for size in (x1 - x0, y1 - y0, extent))
    room, edges = 256, 1024
    graph = Graph(
        np.empty((room, STATE)),
        np.empty((room, 2), np.int32),
        np.full(columns * rows * layers, -1, np.int32),
        np.empty((edges, 3), np.int32),
        np.empty(edges),
        np.empty(256, np.int32),
        np.zeros(COUNTS, np.int64),
        np.array([x0, y0, cell, columns, rows, layers]),
    )
    x, y, t = start[:3].tolist()
    graph.states[0] = start
    label = point_label(*surroundings.regions, x, y)
    graph.links[0] = letter_of(surroundings.masks, label), -1
    graph.heads[cell_of(graph.box, float(surroundings.limits[SPEED]), x, y, t)] = 0
    graph.counts[VERTICES] = 1
    return RobotGraph(surroundings, graph)


@kernel
def letter_of(masks: NDArray[np.int64], mask: int) -> int:
    """The letter of a label, -1 for one that was said not to occur."""
    for letter in range(len(masks)):
        if masks[letter] == mask:
            return letter
    return -1


@kernel
def cell_of(box: NDArray[np.float64], speed: float, x: float, y: float, t: float) -> int:
    """The cell of a place and time."""
    column = min(max(int((x - box[LEFT]) / box[CELL]), 0), int(box[COLUMNS]) - 1)
    row = min(max(int((y - box[LOW]) / box[CELL]), 0), int(box[ROWS]) - 1)
    layer = min(max(int(speed * t / box[CELL]), 0), int(box[LAYERS]) - 1)
    return (layer * int(box[ROWS]) + row) * int(box[COLUMNS]) + column


@kernel
def width(z: int, layers: int, cell: float, at: float, radius: float) -> float:
    """How far away, at most, a vertex of layer z can be that has an edge to one at v t = `at`.

    The robot is no faster than v, and the radius bounds both together. In the last layer are all
    later times.
    """
    low = z * cell - at
    high = low + cell if z < layers - 1 else max(low + cell, radius)
    nearest = max(low, -high, 0.0)
    farthest = max(high, -low)
    if nearest >= radius:
        return 0.0
    return min(farthest, math.sqrt(radius * radius - nearest * nearest)) * _MORE + _MARGIN


@kernel
def insert(
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
) -> int:
    """Adds a vertex and its edges, if the rule gives it a way in: `ADDED`, `REFUSED` or `FULL`."""
    new = counts[VERTICES]
    if new == len(states):
        return FULL
    x = state[0]
    y = state[1]
    t = state[2]
    if on_border(discs, rings, sides, x, y):
        return REFUSED
    label = point_label(discs, rings, sides, x, y)
    letter = letter_of(masks, label)
    if letter < 0:
        return REFUSED
    for i in range(states.shape[1]):
        states[new, i] = state[i]
    first_edge = counts[EDGES]
    first_word = counts[WORDS]
    edge = first_edge
    place = first_word
    tests = 0
    full = False
    has_way_in = False
    forward = rule[FORWARD] != 0.0
    speed = limits[SPEED]
    radius = connection_radius(new + 1, rule[GAMMA], rule[ETA], int(rule[ROOT]))
    square = radius * radius
    columns = int(box[COLUMNS])
    rows = int(box[ROWS])
    layers = int(box[LAYERS])
    cell = box[CELL]
    layer = min(max(int(speed * t / cell), 0), layers - 1)
    farthest = radius * _MORE
    last_layer = min(int((speed * t + farthest) / cell), layers - 1) if forward else layer
    for z in range(max(int((speed * t - farthest) / cell), 0), last_layer + 1):
        # No place of this layer that has an edge to the vertex is farther away than `wide`.
        wide = width(z, layers, cell, speed * t, farthest)
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
                    other = old
                    old = links[old, BEFORE]
                    dx = x - states[other, 0]
                    dy = y - states[other, 1]
                    reach = speed * (t - states[other, 2])
                    plane = dx * dx + dy * dy
                    cone = reach * reach
                    if plane > cone or plane + cone > square or reach == 0.0:
                        continue
                    tail = other
                    head = new
                    if reach < 0.0:
                        if not forward:
                            continue
                        tail = new
                        head = other
                    tests += 1
                    count = connection(limits, states, tail, head, pieces)
                    if count == 0:
                        continue
                    ax = states[tail, 0]
                    ay = states[tail, 1]
                    bx = states[head, 0]
                    by = states[head, 1]
                    if not segment_free(grid, starts, items, shapes, ax, ay, bx, by):
                        continue
                    first = label
                    last = label
                    if tail == new:
                        last = int(masks[links[other, LETTER]])
                    else:
                        first = int(masks[links[other, LETTER]])
                    changes = 0
                    if first != last or meets_regions(discs, rings, ax, ay, bx, by):
                        changes = segment_word(
                            discs, rings, sides, ax, ay, bx, by, first, last, places, word
                        )
                    if changes == UNCLEAR or (changes > 1 and not forward):
                        continue
                    if edge == len(edges):
                        full = True
                        break
                    edges[edge, WORD] = ONE_CHANGE
                    if changes > 1:
                        if place + changes + 1 > len(words):
                            full = True
                            break
                        known = True
                        for i in range(changes):
                            step = letter_of(masks, word[i])
                            known &= step >= 0
                            words[place + 1 + i] = step
                        if not known:
                            continue
                        words[place] = changes
                        edges[edge, WORD] = place
                        place += changes + 1
                    edges[edge, TAIL] = tail
                    edges[edge, HEAD] = head
                    lengths[edge] = connection_length(states, tail, head, pieces, count)
                    edge += 1
                    has_way_in |= head == new
                if full:
                    break
            if full:
                break
        if full:
            break
    if full:
        return FULL
    counts[EDGE_TESTS] += tests
    if not has_way_in:
        return REFUSED
    counts[EDGES] = edge
    counts[WORDS] = place
    place = cell_of(box, speed, x, y, t)
    links[new, LETTER] = letter
    links[new, BEFORE] = heads[place]
    heads[place] = new
    counts[VERTICES] = new + 1
    return ADDED
