"""A first path of each robot, from a search over cells as if nobody else were about.

Sampling finds doors and detours by luck; a search of the floor in cells finds them at once. The
least way over pairs of a cell's centre and a state of the task's automaton (Dijkstra's algorithm)
is straightened and put into the graph at full speed, and again some times later, so that the robot
may also wait anywhere on it. Graphs stay what their rule says: these are vertices like all others.
Where cells are too coarse for a passage there is no guide, and samples do what they can.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.graph import RobotGraph
from conav.planning.graph_arrays import LETTER, letter_of
from conav.planning.labels import MAX_EVENTS, UNCLEAR, on_border, point_label, segment_word
from conav.planning.obstacles import Obstacles, segment_free
from conav.planning.steering import AT_MOST, SPEED
from conav.tasks.automaton import INITIAL, Automaton

MAX_CELLS = 40_000

STEPS = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]], np.int64)


class Cells(NamedTuple):
    """Cells of the floor, for robots of one radius."""

    left: float  # [m] of the first centre
    low: float
    cell: float
    moves: NDArray[np.uint8]  # (rows, columns) bit i: the way to the neighbour in `STEPS` is free


def build_cells(
    obstacles: Obstacles, bounds: tuple[float, float, float, float], cell_m: float
) -> Cells:
    """The cells and free moves; as wide as asked, or wider where there were too many."""
    x0, y0, x1, y1 = bounds
    cell = cell_m
    while (x1 - x0) * (y1 - y0) / (cell * cell) > MAX_CELLS:
        cell *= 1.25
    columns, rows = int((x1 - x0) / cell) + 1, int((y1 - y0) / cell) + 1
    moves = np.zeros((rows, columns), np.uint8)
    _free_moves(*obstacles, x0, y0, cell, moves)
    return Cells(x0, y0, cell, moves)


def guide_path(
    graph: RobotGraph, cells: Cells, automaton: Automaton, horizon_s: float
) -> NDArray[np.float64] | None:
    """States, (m, STATE), of a way at full speed from the start that does the task; None if none.

    None too if the way takes longer than the horizon.
    """
    surroundings = graph.surroundings
    start = graph.vertices[0]
    letter = int(graph.arrays.links[0, LETTER])
    points = _search(
        *surroundings.obstacles,
        *surroundings.regions,
        surroundings.masks,
        automaton.transition,
        automaton.accepting,
        automaton.sink,
        int(automaton.transition[INITIAL, letter]),
        cells.left,
        cells.low,
        cells.cell,
        cells.moves,
        float(start[0]),
        float(start[1]),
    )
    if len(points) == 0:
        return None
    states = np.repeat(start[None, :], len(points), axis=0)
    states[:, :2] = points
    steps = np.sqrt(np.sum(np.diff(points, axis=0) ** 2, axis=1))
    states[1:, 2] = np.cumsum(steps / float(surroundings.limits[SPEED]) * AT_MOST)
    return states if states[-1, 2] <= horizon_s else None


@kernel
def _free_moves(
    grid: NDArray[np.float64],
    starts: NDArray[np.int32],
    items: NDArray[np.int32],
    shapes: NDArray[np.float64],
    left: float,
    low: float,
    cell: float,
    moves: NDArray[np.uint8],
) -> None:
    """Fills in the moves. That of centres off the floor leads nowhere on it."""
    rows, columns = moves.shape
    for row in range(rows):
        for column in range(columns):
            x = left + (column + 0.5) * cell
            y = low + (row + 0.5) * cell
            for step in range(4):
                v = row + STEPS[step, 1]
                u = column + STEPS[step, 0]
                if v < 0 or u < 0 or v >= rows or u >= columns:
                    continue
                to_x = left + (u + 0.5) * cell
                to_y = low + (v + 0.5) * cell
                if segment_free(grid, starts, items, shapes, x, y, to_x, to_y):
                    moves[row, column] |= 1 << step
                    moves[v, u] |= 1 << (step + 4)


@kernel
def _push(heap: NDArray[np.float64], size: int, key: float, node: int) -> int:
    """Adds to a heap of rows (key, node), least first; returns its new size."""
    at = size
    while at > 0:
        up = (at - 1) // 2
        if heap[up, 0] < key or (heap[up, 0] == key and heap[up, 1] <= node):
            break
        heap[at, 0] = heap[up, 0]
        heap[at, 1] = heap[up, 1]
        at = up
    heap[at, 0] = key
    heap[at, 1] = node
    return size + 1


@kernel
def _pop(heap: NDArray[np.float64], size: int) -> int:
    """Takes the first row away; returns the new size."""
    size -= 1
    key = heap[size, 0]
    node = heap[size, 1]
    at = 0
    while True:
        down = 2 * at + 1
        if down >= size:
            break
        other = down + 1
        if other < size and (
            heap[other, 0] < heap[down, 0]
            or (heap[other, 0] == heap[down, 0] and heap[other, 1] < heap[down, 1])
        ):
            down = other
        if key < heap[down, 0] or (key == heap[down, 0] and node <= heap[down, 1]):
            break
        heap[at, 0] = heap[down, 0]
        heap[at, 1] = heap[down, 1]
        at = down
    heap[at, 0] = key
    heap[at, 1] = node
    return size


@kernel
def _search(
    grid: NDArray[np.float64],
    starts: NDArray[np.int32],
    items: NDArray[np.int32],
    shapes: NDArray[np.float64],
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    masks: NDArray[np.int64],
    transition: NDArray[np.int32],
    accepting: NDArray[np.bool_],
    sink: NDArray[np.bool_],
    start_state: int,
    left: float,
    low: float,
    cell: float,
    moves: NDArray[np.uint8],
    x: float,
    y: float,
) -> NDArray[np.float64]:
    """The points of a shortest way over cells, (n, 2), from the start; none if there is none."""
    rows, columns = moves.shape
    states = len(accepting)
    places = np.empty(MAX_EVENTS)
    word = np.empty(3 * MAX_EVENTS, np.int64)
    if accepting[start_state]:
        only = np.empty((1, 2))
        only[0, 0] = x
        only[0, 1] = y
        return only
    labels = np.empty(rows * columns, np.int64)
    for at in range(rows * columns):
        centre_x = left + (at % columns + 0.5) * cell
        centre_y = low + (at // columns + 0.5) * cell
        if on_border(discs, rings, sides, centre_x, centre_y):
            labels[at] = UNCLEAR  # no vertex may be there
        else:
            labels[at] = point_label(discs, rings, sides, centre_x, centre_y)
    start_label = point_label(discs, rings, sides, x, y)
    cost = np.full(rows * columns * states, np.inf)
    before = np.full(rows * columns * states, -1, np.int64)
    heap = np.empty((1024, 2))
    size = 0
    # From the start to the centres around it.
    start_row = int((y - low) / cell)
    start_column = int((x - left) / cell)
    for v in range(max(start_row - 2, 0), min(start_row + 2, rows - 1) + 1):
        for u in range(max(start_column - 2, 0), min(start_column + 2, columns - 1) + 1):
            to_x = left + (u + 0.5) * cell
            to_y = low + (v + 0.5) * cell
            if not segment_free(grid, starts, items, shapes, x, y, to_x, to_y):
                continue
            to = v * columns + u
            if labels[to] == UNCLEAR:
                continue
            state = _state_after(
                discs, rings, sides, masks, transition, x, y, to_x, to_y, start_label,
                int(labels[to]), start_state, places, word,
            )  # fmt: skip
            if state < 0 or sink[state]:
                continue
            node = to * states + state
            cost[node] = math.sqrt((to_x - x) * (to_x - x) + (to_y - y) * (to_y - y))
            size = _push(heap, size, float(cost[node]), node)
    last = -1
    while size > 0:
        key = float(heap[0, 0])
        node = int(heap[0, 1])
        size = _pop(heap, size)
        if key > cost[node]:
            continue
        state = node % states
        at = node // states
        if accepting[state]:
            last = node
            break
        row = at // columns
        column = at % columns
        from_x = left + (column + 0.5) * cell
        from_y = low + (row + 0.5) * cell
        for step in range(8):
            if not (moves[row, column] >> step) & 1:
                continue
            v = row + STEPS[step, 1]
            u = column + STEPS[step, 0]
            to = v * columns + u
            length = cell * 1.4142135623730951 if step % 2 == 1 else cell
            useful = False
            for after in range(states):
                useful |= key + length < cost[to * states + after] and not sink[after]
            if not useful or labels[to] == UNCLEAR:
                continue
            after = _state_after(
                discs, rings, sides, masks, transition, from_x, from_y,
                left + (u + 0.5) * cell, low + (v + 0.5) * cell, int(labels[at]),
                int(labels[to]), state, places, word,
            )  # fmt: skip
            if after < 0 or sink[after]:
                continue
            next_node = to * states + after
            if key + length < cost[next_node]:
                cost[next_node] = key + length
                before[next_node] = node
                if size == len(heap):
                    longer = np.empty((2 * size, 2))
                    longer[:size] = heap
                    heap = longer
                size = _push(heap, size, key + length, next_node)
    if last < 0:
        return np.empty((0, 2))
    count = 1
    node = last
    while node >= 0:
        count += 1
        node = before[node]
    points = np.empty((count, 2))
    node = last
    for i in range(count - 1, 0, -1):
        at = node // states
        points[i, 0] = left + (at % columns + 0.5) * cell
        points[i, 1] = low + (at // columns + 0.5) * cell
        node = before[node]
    points[0, 0] = x
    points[0, 1] = y
    if count > 1 and points[1, 0] == x and points[1, 1] == y:
        return points[1:]
    return points


@kernel
def _state_after(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    masks: NDArray[np.int64],
    transition: NDArray[np.int32],
    ax: float,
    ay: float,
    bx: float,
    by: float,
    first: int,
    last: int,
    state: int,
    places: NDArray[np.float64],
    word: NDArray[np.int64],
) -> int:
    """The automaton's state after a straight way, -1 where it has no word."""
    changes = segment_word(discs, rings, sides, ax, ay, bx, by, first, last, places, word)
    if changes == UNCLEAR:
        return -1
    for i in range(changes):
        letter = letter_of(masks, word[i])
        if letter < 0:
            return -1
        state = transition[state, letter]
    return state


def delayed(
    states: NDArray[np.float64], step_s: float, times: int, horizon_s: float
) -> NDArray[np.float64]:
    """The same states later, by one step, by two and so on; those after the horizon left out."""
    delays = step_s * np.arange(1, times + 1)
    later = np.repeat(states[None, :, :], times, axis=0)
    later[:, :, 2] += delays[:, None]
    rows = later.reshape(-1, states.shape[1])
    return rows[rows[:, 2] <= horizon_s]
