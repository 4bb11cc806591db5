"""Straightening a path in space and time, everybody else's trajectory standing.

Random pairs of places on the path are joined by a straight way that takes the same time, and random
places by a straight way at full speed to a region, where the path may then end; where seconds count
the rest of the path is also driven at full speed. A change is kept if it makes the path shorter (or
earlier), meets nothing and nobody, and leaves the task done. The new places become vertices of the
graph, so the next response on the graph is at least as good as the path found here.
"""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.games.splitmix64 import below, draw, unit
from conav.planning.graph import RobotGraph
from conav.planning.graph_arrays import letter_of
from conav.planning.labels import MAX_EVENTS, UNCLEAR, on_border, point_label, segment_word
from conav.planning.obstacles import segment_free
from conav.planning.steering import AT_MOST, SPEED, STATE
from conav.planning.targets import nearest_in
from conav.planning.traffic import Traffic, hits
from conav.planning.types import PIECE
from conav.tasks.automaton import INITIAL, Automaton

MAX_ROWS = 512
"""Of a path while it is straightened."""

_LEAST = 1e-7  # [m or s] a change gains, so that it is more than rounding
_DRAWS = 8  # of a try


def shortcut(
    graph: RobotGraph,
    path: NDArray[np.float64],
    automaton: Automaton,
    traffic: Traffic,
    robot: int,
    heed: NDArray[np.bool_],
    seed: np.uint64,
    tries: int,
    hurry: bool,
) -> NDArray[np.float64]:
    """The straightened path, (m, STATE); with `hurry` seconds count too."""
    if len(path) > MAX_ROWS // 2:
        return path
    rows = np.empty((MAX_ROWS, STATE))
    rows[: len(path)] = path
    surroundings = graph.surroundings
    size = _straighten(
        *surroundings.obstacles,
        *surroundings.regions,
        surroundings.masks,
        surroundings.limits,
        automaton.transition,
        automaton.accepting,
        *traffic.arrays,
        robot,
        heed,
        traffic.stays[robot],
        traffic.horizon_s,
        rows,
        len(path),
        seed,
        tries,
        hurry,
    )
    return rows[:size].copy()


@kernel
def _straighten(
    grid: NDArray[np.float64],
    starts: NDArray[np.int32],
    items: NDArray[np.int32],
    shapes: NDArray[np.float64],
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    masks: NDArray[np.int64],
    limits: NDArray[np.float64],
    transition: NDArray[np.int32],
    accepting: NDArray[np.bool_],
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
    rows: NDArray[np.float64],
    size: int,
    seed: np.uint64,
    tries: int,
    hurry: bool,
) -> int:
    """The number of rows of the path after some tries."""
    speed = limits[SPEED]
    targets = len(discs) + len(rings)
    new = np.empty((MAX_ROWS, STATE))
    places = np.empty(MAX_EVENTS)
    word = np.empty(3 * MAX_EVENTS, np.int64)
    piece = np.zeros((1, PIECE))
    for trial in range(tries):
        if size < 2:
            return size
        first = trial * _DRAWS
        kind = unit(draw(seed, first))
        leg = below(draw(seed, first + 1), size - 1)
        share = unit(draw(seed, first + 2))
        if unit(draw(seed, first + 3)) < 0.5:
            share = 0.0  # at a corner
        ax = rows[leg, 0] + share * (rows[leg + 1, 0] - rows[leg, 0])
        ay = rows[leg, 1] + share * (rows[leg + 1, 1] - rows[leg, 1])
        at = rows[leg, 2] + share * (rows[leg + 1, 2] - rows[leg, 2])
        count = leg + 1
        for i in range(count):
            for j in range(STATE):
                new[i, j] = rows[i, j]
        if share > 0.0:
            new[count, 0] = ax
            new[count, 1] = ay
            new[count, 2] = at
            count += 1
        changed = count - 1  # rows from here on are new
        if kind < 0.75:
            to_leg = below(draw(seed, first + 4), size - 1)
            to_share = unit(draw(seed, first + 5))
            if unit(draw(seed, first + 6)) < 0.5:
                to_share = 1.0
            if to_leg <= leg:
                continue
            if to_share < 1.0:
                new[count, 0] = rows[to_leg, 0] + to_share * (rows[to_leg + 1, 0] - rows[to_leg, 0])
                new[count, 1] = rows[to_leg, 1] + to_share * (rows[to_leg + 1, 1] - rows[to_leg, 1])
                new[count, 2] = rows[to_leg, 2] + to_share * (rows[to_leg + 1, 2] - rows[to_leg, 2])
                count += 1
            joined = count - (1 if to_share < 1.0 else 0)  # the row after the straight way
            if count + size - to_leg - 1 > MAX_ROWS - 2:
                continue
            for i in range(to_leg + 1, size):
                for j in range(STATE):
                    new[count, j] = rows[i, j]
                count += 1
            until = joined
        elif kind < 0.875 or not hurry:
            if targets == 0:
                continue
            target = below(draw(seed, first + 4), targets)
            x, y, found = nearest_in(discs, rings, sides, target, ax, ay)
            if not found:
                continue
            new[count, 0] = x
            new[count, 1] = y
            away = math.sqrt((x - ax) * (x - ax) + (y - ay) * (y - ay))
            new[count, 2] = at + away / speed * AT_MOST
            if unit(draw(seed, first + 5)) < 0.5 and not hurry:
                new[count, 2] = max(new[count, 2], rows[size - 1, 2])
            until = count
            count += 1
        else:
            for i in range(leg + 1, size):
                dx = rows[i, 0] - new[count - 1, 0]
                dy = rows[i, 1] - new[count - 1, 1]
                new[count, 0] = rows[i, 0]
                new[count, 1] = rows[i, 1]
                away = math.sqrt(dx * dx + dy * dy)
                if away == 0.0:
                    continue
                new[count, 2] = new[count - 1, 2] + away / speed * AT_MOST
                count += 1
            until = count - 1
        gained = _length(rows, size) - _length(new, count)
        earlier = rows[size - 1, 2] - new[count - 1, 2]
        if not (
            (gained > _LEAST and (earlier >= 0.0 or not hurry))
            or (hurry and earlier > _LEAST and gained >= 0.0)
        ):
            continue
        if new[count - 1, 2] > horizon:
            continue
        fine = True
        for i in range(changed, until):
            dt = new[i + 1, 2] - new[i, 2]
            if dt <= 0.0 or not segment_free(
                grid, starts, items, shapes, new[i, 0], new[i, 1], new[i + 1, 0], new[i + 1, 1]
            ):
                fine = False
                break
            _write_piece(piece, new, i)
            if hits(tracks, sizes, firsts, boxes, bodies, span, robot, heed, piece, 1, 1):
                fine = False
                break
        if not fine:
            continue
        # The way's end is where it was unless it ends sooner or elsewhere.
        if stays and until == count - 1 and new[count - 1, 2] < horizon:
            piece[0, 0] = new[count - 1, 2]
            piece[0, 1] = horizon
            piece[0, 2] = new[count - 1, 0]
            piece[0, 3] = new[count - 1, 1]
            piece[0, 4] = 0.0
            piece[0, 5] = 0.0
            if hits(tracks, sizes, firsts, boxes, bodies, span, robot, heed, piece, 1, 1):
                continue
        if not _task_done(
            discs, rings, sides, masks, transition, accepting, new, count, places, word
        ):
            continue
        size = count
        for i in range(count):
            for j in range(STATE):
                rows[i, j] = new[i, j]
    return size


@kernel
def _length(rows: NDArray[np.float64], size: int) -> float:
    total = 0.0
    for i in range(1, size):
        dx = rows[i, 0] - rows[i - 1, 0]
        dy = rows[i, 1] - rows[i - 1, 1]
        total += math.sqrt(dx * dx + dy * dy)
    return total


@kernel
def _write_piece(piece: NDArray[np.float64], rows: NDArray[np.float64], i: int) -> None:
    """The way from a row to the next, straight and at constant speed."""
    dt = rows[i + 1, 2] - rows[i, 2]
    piece[0, 0] = rows[i, 2]
    piece[0, 1] = rows[i + 1, 2]
    piece[0, 2] = rows[i, 0]
    piece[0, 3] = rows[i, 1]
    piece[0, 4] = (rows[i + 1, 0] - rows[i, 0]) / dt
    piece[0, 5] = (rows[i + 1, 1] - rows[i, 1]) / dt


@kernel
def _task_done(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    masks: NDArray[np.int64],
    transition: NDArray[np.int32],
    accepting: NDArray[np.bool_],
    rows: NDArray[np.float64],
    size: int,
    places: NDArray[np.float64],
    word: NDArray[np.int64],
) -> bool:
    """Whether the task is done at the end of a path."""
    label = point_label(discs, rings, sides, rows[0, 0], rows[0, 1])
    letter = letter_of(masks, label)
    if letter < 0:
        return False
    state = transition[INITIAL, letter]
    for i in range(1, size):
        if on_border(discs, rings, sides, rows[i, 0], rows[i, 1]):
            return False  # no vertex may be there
        after = point_label(discs, rings, sides, rows[i, 0], rows[i, 1])
        changes = segment_word(
            discs,
            rings,
            sides,
            rows[i - 1, 0],
            rows[i - 1, 1],
            rows[i, 0],
            rows[i, 1],
            label,
            after,
            places,
            word,
        )
        if changes == UNCLEAR:
            return False
        for j in range(changes):
            letter = letter_of(masks, word[j])
            if letter < 0:
                return False
            state = transition[state, letter]
        label = after
    return bool(accepting[state])


def between(graph: RobotGraph, path: NDArray[np.float64], room: int) -> NDArray[np.float64]:
    """The path's states and more between them, so close that each edge is within the radius.

    `room` vertices may come in before the last of these, which makes the radius smaller.
    """
    radius = graph.radius_at(graph.size + room)
    speed = float(graph.surroundings.limits[SPEED])
    rows: list[NDArray[np.float64]] = [path[:1]]
    for a, b in pairwise(path):
        dx, dy, dt = (b - a)[:3].tolist()
        whole = math.sqrt(dx * dx + dy * dy + speed * speed * dt * dt)
        steps = int(whole / radius * AT_MOST) + 1
        shares = np.arange(1, steps + 1)[:, None] / steps
        line = a + shares * (b - a)
        line[-1] = b
        rows.append(line)
    return np.concatenate(rows)
