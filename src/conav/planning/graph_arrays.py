"""The arrays of a robot's graph, in the order in which kernels take them, and their places."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.labels import MAX_EVENTS, Regions
from conav.planning.obstacles import Obstacles
from conav.planning.steering import MAX_PIECES
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

Memory = tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64], NDArray[np.int32]]
"""For kernels to work in: places, a word, pieces, and vertices nearby."""

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

    states: NDArray[np.float64]  # (vertices, numbers) x, y [m], t [s], ...
    links: NDArray[np.int32]  # (vertices, 2) letter; the vertex before in the same cell, -1
    heads: NDArray[np.int32]  # (cells,) the newest vertex in each cell of x, y, v t, -1
    edges: NDArray[np.int32]  # (edges, 3) from, to, where in `words` its letters are
    lengths: NDArray[np.float64]  # (edges,) [m]
    words: NDArray[np.int32]  # a count and so many letters, for each edge with several changes
    counts: NDArray[np.int64]
    box: NDArray[np.float64]  # left, low, cell [m], columns, rows, layers


def make_rule(
    eta_m: float, gamma_m: float, numbers: int, exponent: Exponent, mode: Mode
) -> NDArray[np.float64]:
    """What decides about edges of states of so many numbers, beside the scene, as an array."""
    root = numbers if exponent == "d" else numbers + 1
    return np.array([eta_m, gamma_m, root, mode == "forward"], np.float64)


def scratch(vertices: int) -> Memory:
    """Memory for kernels that work on a graph with room for so many vertices."""
    return (
        np.empty(MAX_EVENTS),
        np.empty(3 * MAX_EVENTS, np.int64),
        np.empty((MAX_PIECES, PIECE)),
        np.empty(vertices, np.int32),
    )


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
