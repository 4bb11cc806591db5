"""Straightening a path of curved ways, everybody else's trajectory standing.

As `conav.planning.shortcut`: random pairs of states on the path are joined by the motion's own way
that takes the same time, and random states by one to a region, where the path may then end; where
seconds count they are also joined as soon as can be, and the rest of the path is driven earlier. A
way cut in two need not be driven as before, so all that is new on either side is looked at too.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.games.splitmix64 import below, draw, unit
from conav.planning.curves import pieces_free, pieces_meet_regions, pieces_word
from conav.planning.graph import RobotGraph
from conav.planning.graph_arrays import letter_of
from conav.planning.labels import MAX_EVENTS, UNCLEAR, on_border, point_label
from conav.planning.motion_states import aim, soonest, stand, state_on_way
from conav.planning.steering import MAX_PIECES, connection, connection_length
from conav.planning.targets import nearest_in
from conav.planning.traffic import Traffic, hits
from conav.planning.types import PIECE
from conav.tasks.automaton import INITIAL, Automaton

MAX_ROWS = 512
"""Of a path while it is straightened."""

_LEAST = 1e-7  # [m or s] a change gains, so that it is more than rounding
_DRAWS = 8  # of a try


def shortcut_curved(
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
    """The straightened path, rows of states; with `hurry` seconds count too."""
    if len(path) > MAX_ROWS // 2:
        return path
    rows = np.empty((MAX_ROWS, path.shape[1]))
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
    targets = len(discs) + len(rings)
    numbers = rows.shape[1]
    new = np.empty((MAX_ROWS, numbers))
    pair = np.empty((2, numbers))
    metres = np.empty(MAX_ROWS)  # of each way of the path, and of the new one
    new_metres = np.empty(MAX_ROWS)
    pieces = np.empty((MAX_PIECES, PIECE))
    rest = np.zeros((1, PIECE))
    places = np.empty(MAX_EVENTS)
    word = np.empty(3 * MAX_EVENTS, np.int64)
    for i in range(size - 1):
        count = connection(limits, rows, i, i + 1, pieces)
        metres[i] = connection_length(limits, rows, i, i + 1, pieces, count)
    for trial in range(tries):
        if size < 2:
            return size
        first = trial * _DRAWS
        kind = unit(draw(seed, first))
        leg = below(draw(seed, first + 1), size - 1)
        share = unit(draw(seed, first + 2))
        if unit(draw(seed, first + 3)) < 0.5:
            share = 0.0  # at a corner
        count = leg + 1
        new[:count] = rows[:count]
        if share > 0.0:
            _state_on_leg(limits, rows, leg, share, pieces, new[count])
            count += 1
        to_end = not (kind < 0.6 or (hurry and kind >= 0.8))
        if to_end:
            if targets == 0:
                continue
            target = below(draw(seed, first + 4), targets)
            x = new[count - 1, 0]
            y = new[count - 1, 1]
            to_x, to_y, found = nearest_in(discs, rings, sides, target, x, y)
            if not found:
                continue
            pair[0] = new[count - 1]
            pair[1] = new[count - 1]
            pair[1, 0] = to_x
            pair[1, 1] = to_y
            aim(limits, pair[1], to_x - x, to_y - y, 1.0)
            stand(limits, pair[1])
            if soonest(limits, pair, pieces) == 0:
                continue
            if unit(draw(seed, first + 5)) < 0.5 and not hurry:
                pair[1, 2] = max(pair[1, 2], rows[size - 1, 2])
            new[count] = pair[1]
            count += 1
            until = count - 1
        else:
            to_leg = below(draw(seed, first + 4), size - 1)
            to_share = unit(draw(seed, first + 5))
            if unit(draw(seed, first + 6)) < 0.5:
                to_share = 1.0
            if to_leg <= leg or count + size - to_leg > MAX_ROWS - 2:
                continue
            begin = count - 1
            if to_share < 1.0:
                _state_on_leg(limits, rows, to_leg, to_share, pieces, new[count])
                count += 1
            new[count : count + size - to_leg - 1] = rows[to_leg + 1 : size]
            until = begin + 2 if to_share < 1.0 else begin + 1  # where it is as it was
            count += size - to_leg - 1
            if hurry and kind >= 0.8:
                pair[0] = new[begin]
                pair[1] = new[begin + 1]
                if soonest(limits, pair, pieces) == 0:
                    continue
                earlier = new[begin + 1, 2] - pair[1, 2]
                if earlier <= 0.0:
                    continue
                for i in range(begin + 1, count):
                    new[i, 2] -= earlier
                until = count - 1
        if new[count - 1, 2] > horizon:
            continue
        # The same ways lie before `leg` and, counted from the end, after `until`.
        gained = 0.0
        for i in range(leg, size - 1 - (count - 1 - until)):
            gained += metres[i]
        fine = True
        for i in range(leg, until):
            pieces_count = connection(limits, new, i, i + 1, pieces)
            if pieces_count == 0:
                fine = False
                break
            new_metres[i] = connection_length(limits, new, i, i + 1, pieces, pieces_count)
            gained -= new_metres[i]
        earlier = rows[size - 1, 2] - new[count - 1, 2]
        if not fine or not (
            (gained > _LEAST and (earlier >= 0.0 or not hurry))
            or (hurry and earlier > _LEAST and gained >= -_LEAST)
        ):
            continue
        for i in range(leg, until):
            pieces_count = connection(limits, new, i, i + 1, pieces)
            if not pieces_free(grid, starts, items, shapes, pieces, pieces_count) or hits(
                tracks, sizes, firsts, boxes, bodies, span, robot, heed, pieces, pieces_count, 1
            ):
                fine = False
                break
        if not fine:
            continue
        # The way's end is where it was unless it ends sooner or elsewhere.
        if stays and until == count - 1 and new[count - 1, 2] < horizon:
            rest[0, 0] = new[count - 1, 2]
            rest[0, 1] = horizon
            rest[0, 2] = new[count - 1, 0]
            rest[0, 3] = new[count - 1, 1]
            if hits(tracks, sizes, firsts, boxes, bodies, span, robot, heed, rest, 1, 1):
                continue
        if not _task_done(
            discs, rings, sides, masks, limits, transition, accepting, new, count, pieces, places,
            word,
        ):  # fmt: skip
            continue
        for i in range(until, count - 1):
            new_metres[i] = metres[size - 1 - (count - 1 - i)]
        metres[leg : count - 1] = new_metres[leg : count - 1]
        size = count
        rows[:count] = new[:count]
    return size


@kernel
def _state_on_leg(
    limits: NDArray[np.float64],
    rows: NDArray[np.float64],
    leg: int,
    share: float,
    pieces: NDArray[np.float64],
    state: NDArray[np.float64],
) -> None:
    """Fills in the state after a share of the time of one way of a path."""
    count = connection(limits, rows, leg, leg + 1, pieces)
    t = rows[leg, 2] + share * (rows[leg + 1, 2] - rows[leg, 2])
    if count > 0:
        state_on_way(limits, rows[leg], pieces, count, t, state)
    else:  # not a way at all: one of its ends, which the next look refuses
        state[:] = rows[leg]


@kernel
def _task_done(
    discs: NDArray[np.float64],
    rings: NDArray[np.float64],
    sides: NDArray[np.float64],
    masks: NDArray[np.int64],
    limits: NDArray[np.float64],
    transition: NDArray[np.int32],
    accepting: NDArray[np.bool_],
    rows: NDArray[np.float64],
    size: int,
    pieces: NDArray[np.float64],
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
        count = connection(limits, rows, i - 1, i, pieces)
        if label == after and not pieces_meet_regions(discs, rings, pieces, count):
            continue
        changes = pieces_word(discs, rings, sides, pieces, count, label, after, places, word)
        if changes == UNCLEAR:
            return False
        for j in range(changes):
            letter = letter_of(masks, word[j])
            if letter < 0:
                return False
            state = transition[state, letter]
        label = after
    return bool(accepting[state])


@kernel
def _spread_out(
    limits: NDArray[np.float64],
    path: NDArray[np.float64],
    steps: NDArray[np.int64],
    rows: NDArray[np.float64],
) -> None:
    """Fills in the states after equal times, so many on each way of the path."""
    pieces = np.empty((MAX_PIECES, PIECE))
    rows[0] = path[0]
    at = 1
    for leg in range(len(steps)):
        for step in range(1, steps[leg]):
            _state_on_leg(limits, path, leg, step / steps[leg], pieces, rows[at])
            at += 1
        rows[at] = path[leg + 1]
        at += 1


def between_curved(graph: RobotGraph, path: NDArray[np.float64], room: int) -> NDArray[np.float64]:
    """The path's states and more on its ways, so close that each edge is within the radius.

    `room` vertices may come in before the last of these, which makes the radius smaller.
    """
    limits = graph.surroundings.limits
    durations = np.diff(path[:, 2])
    # No metre of the way takes more than root 2 in space and time.
    metres = 1.4143 * float(limits[0]) * durations
    steps = (metres / graph.radius_at(graph.size + room)).astype(np.int64) + 1
    rows = np.empty((int(steps.sum()) + 1, path.shape[1]))
    _spread_out(limits, path, steps, rows)
    return rows
