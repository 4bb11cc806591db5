"""Adding a vertex and all its edges to the graph of a robot whose ways are curves.

As `conav.planning.insert`, but an edge is the connection of its ends by the robot's motion, and
walls, discs and regions are met by its pieces.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.curves import pieces_free, pieces_meet_regions, pieces_word
from conav.planning.graph_arrays import (
    ADDED,
    EDGE_TESTS,
    EDGES,
    ETA,
    FORWARD,
    FULL,
    GAMMA,
    HEAD,
    LETTER,
    REFUSED,
    ROOT,
    TAIL,
    VERTICES,
    WORD,
    WORDS,
    letter_of,
)
from conav.planning.insert import FULL_WORDS, UNKNOWN, put_vertex, put_word
from conav.planning.labels import UNCLEAR, on_border, point_label
from conav.planning.near import near_vertices
from conav.planning.radius import connection_radius
from conav.planning.steering import SPEED, connection, connection_length


@kernel
def insert_curved(
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
    near: NDArray[np.int32],
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
    for i in range(len(state)):
        states[new, i] = state[i]
    edge = counts[EDGES]
    place = counts[WORDS]
    has_way_in = False
    forward = rule[FORWARD] != 0.0
    speed = limits[SPEED]
    radius = connection_radius(new + 1, rule[GAMMA], rule[ETA], int(rule[ROOT]))
    found = near_vertices(states, links, heads, box, speed, radius, forward, x, y, t, near)
    for i in range(found):
        other = int(near[i])
        into = states[other, 2] < t
        tail = other if into else new
        head = new if into else other
        count = connection(limits, states, tail, head, pieces)
        if count == 0 or not pieces_free(grid, starts, items, shapes, pieces, count):
            continue
        first = int(masks[links[other, LETTER]]) if into else label
        last = label if into else int(masks[links[other, LETTER]])
        changes = 0
        if first != last or pieces_meet_regions(discs, rings, pieces, count):
            changes = pieces_word(discs, rings, sides, pieces, count, first, last, places, word)
        if changes == UNCLEAR or (changes > 1 and not forward):
            continue
        at = put_word(masks, words, place, word, changes)
        if at == UNKNOWN:
            continue
        if edge == len(edges) or at == FULL_WORDS:
            return FULL
        edges[edge, TAIL] = tail
        edges[edge, HEAD] = head
        edges[edge, WORD] = at
        lengths[edge] = connection_length(limits, states, tail, head, pieces, count)
        edge += 1
        if at >= 0:
            place += changes + 1
        has_way_in |= into
    counts[EDGE_TESTS] += found
    if not has_way_in:
        return REFUSED
    counts[EDGES] = edge
    counts[WORDS] = place
    put_vertex(states, links, heads, counts, box, speed, state, letter)
    return ADDED
