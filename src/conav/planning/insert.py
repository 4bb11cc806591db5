"""Adding a vertex and all its edges to the graph of a robot that drives straight."""

import math

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.graph_arrays import (
    ADDED,
    BEFORE,
    EDGE_TESTS,
    EDGES,
    ETA,
    FORWARD,
    FULL,
    GAMMA,
    HEAD,
    LETTER,
    ONE_CHANGE,
    REFUSED,
    ROOT,
    TAIL,
    VERTICES,
    WORD,
    WORDS,
    cell_of,
    letter_of,
)
from conav.planning.labels import UNCLEAR, meets_regions, on_border, point_label, segment_word
from conav.planning.near import near_vertices
from conav.planning.obstacles import segment_free
from conav.planning.radius import connection_radius
from conav.planning.steering import SPEED

UNKNOWN, FULL_WORDS = -2, -3
"""Instead of a place for a word: it has a label that was said not to occur; there is no room."""


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
    near: NDArray[np.int32],
) -> int:
    """Adds a vertex and its edges, if the rule gives it a way in: `ADDED`, `REFUSED` or `FULL`."""
    radius = connection_radius(counts[VERTICES] + 1, rule[GAMMA], rule[ETA], int(rule[ROOT]))
    forward = rule[FORWARD] != 0.0
    found = near_vertices(
        states,
        links,
        heads,
        box,
        limits[SPEED],
        radius,
        forward,
        state[0],
        state[1],
        state[2],
        near,
    )
    return insert_among(
        grid, starts, items, shapes, discs, rings, sides, masks, limits, rule, states, links,
        heads, edges, lengths, words, counts, box, state, places, word, pieces, near, found,
    )  # fmt: skip


@kernel
def insert_among(
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
    found: int,
) -> int:
    """As `insert`, the first `found` of `near` being all vertices within the radius."""
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
    edge = counts[EDGES]
    place = counts[WORDS]
    has_way_in = False
    forward = rule[FORWARD] != 0.0
    speed = limits[SPEED]
    for i in range(found):
        other = int(near[i])
        ox = states[other, 0]
        oy = states[other, 1]
        into = states[other, 2] < t
        ax, ay, bx, by = (ox, oy, x, y) if into else (x, y, ox, oy)
        if not segment_free(grid, starts, items, shapes, ax, ay, bx, by):
            continue
        first = int(masks[links[other, LETTER]]) if into else label
        last = label if into else int(masks[links[other, LETTER]])
        changes = 0
        if first != last or meets_regions(discs, rings, ax, ay, bx, by):
            changes = segment_word(discs, rings, sides, ax, ay, bx, by, first, last, places, word)
        if changes == UNCLEAR or (changes > 1 and not forward):
            continue
        at = put_word(masks, words, place, word, changes)
        if at == UNKNOWN:
            continue
        if edge == len(edges) or at == FULL_WORDS:
            return FULL
        edges[edge, TAIL] = other if into else new
        edges[edge, HEAD] = new if into else other
        edges[edge, WORD] = at
        lengths[edge] = math.sqrt((ox - x) * (ox - x) + (oy - y) * (oy - y))
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


@kernel
def put_word(
    masks: NDArray[np.int64],
    words: NDArray[np.int32],
    place: int,
    word: NDArray[np.int64],
    changes: int,
) -> int:
    """Where in `words` the letters of so many changes now are, or why they are not.

    They are written from `place` on where there are several.
    """
    if changes <= 1:
        return ONE_CHANGE
    if place + changes + 1 > len(words):
        return FULL_WORDS
    for i in range(changes):
        step = letter_of(masks, word[i])
        if step < 0:
            return UNKNOWN
        words[place + 1 + i] = step
    words[place] = changes
    return place


@kernel
def put_vertex(
    states: NDArray[np.float64],
    links: NDArray[np.int32],
    heads: NDArray[np.int32],
    counts: NDArray[np.int64],
    box: NDArray[np.float64],
    speed: float,
    state: NDArray[np.float64],
    letter: int,
) -> None:
    """Adds the state as the newest vertex."""
    new = counts[VERTICES]
    for i in range(len(state)):
        states[new, i] = state[i]
    cell = cell_of(box, speed, state[0], state[1], state[2])
    links[new, LETTER] = letter
    links[new, BEFORE] = heads[cell]
    heads[cell] = new
    counts[VERTICES] = new + 1
