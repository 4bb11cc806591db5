"""Routes over pieces of lanes for a team, the longest as short as possible.

Robots start where they are, drive each piece from one end to the other, and do not come back: a
min-max rural postman problem with open routes. Routes are improved by ruin and recreate
[Schrimpf2000] with strings of neighbours taken out of several routes [Christiaens2020], each put
back where the longest route grows least, and a threshold that falls to 0 (record-to-record travel,
[Dueck1993]).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.games.splitmix64 import below, draw

THRESHOLD = 0.02  # how much worse than the last a plan may be at the beginning
TOTAL = 0.3  # weight of the mean route against the longest
LATER = 0.02  # when a piece is put in: weight of the whole route it goes to
MOST_STRINGS = 3
LONGEST_STRING = 8


@dataclass(eq=False)
class Routes:
    """A route per robot over numbered pieces."""

    pieces: NDArray[np.int64]  # (n_robots, n_pieces) in the order they are driven
    turned: NDArray[np.int64]  # (n_robots, n_pieces) 1: from its second end to its first
    count: NDArray[np.int64]  # (n_robots,) pieces in each route
    length: NDArray[np.float64]  # (n_robots,) [planning cells]

    def cost(self) -> float:
        """What is minimised: the longest route, and some of the mean."""
        return float(self.length.max() + TOTAL * self.length.mean())

    def copy(self) -> "Routes":
        """Independent routes with the same content."""
        return Routes(self.pieces.copy(), self.turned.copy(), self.count.copy(), self.length.copy())


def no_routes(n_robots: int, n_pieces: int) -> Routes:
    """Routes with nothing in them."""
    shape = (n_robots, n_pieces)
    return Routes(
        np.zeros(shape, dtype=np.int64),
        np.zeros(shape, dtype=np.int64),
        np.zeros(n_robots, dtype=np.int64),
        np.zeros(n_robots),
    )


def improve(
    routes: Routes,
    ends: NDArray[np.float64],
    starts: NDArray[np.float64],
    diagonal: float,
    rounds: int,
    rng: np.random.Generator,
) -> Routes:
    """Routes over all pieces, no worse than these with the missing pieces put in where they fit.

    `ends` (n_pieces, 2, 2) are the two ends of each piece, `starts` (n_robots, 2) where the robots
    are [planning cells]; `diagonal` is what a diagonal move costs. Of `routes` the lengths need not
    be right. `rounds` is how often routes are ruined and recreated.
    """
    best = routes.copy()
    now = routes.copy()
    trial = routes.copy()
    _improve(
        (best.pieces, best.turned, best.count, best.length),
        (now.pieces, now.turned, now.count, now.length),
        (trial.pieces, trial.turned, trial.count, trial.length),
        ends,
        starts,
        diagonal,
        rounds,
        np.uint64(rng.integers(2**63)),
    )
    return best


@kernel
def travel(ax: float, ay: float, bx: float, by: float, diagonal: float) -> float:
    """The length of a way between two cells in the open."""
    dx = abs(ax - bx)
    dy = abs(ay - by)
    return max(dx, dy) + (diagonal - 1.0) * min(dx, dy)


@kernel
def route_length(
    pieces: NDArray[np.int64],
    turned: NDArray[np.int64],
    count: int,
    ends: NDArray[np.float64],
    start: NDArray[np.float64],
    diagonal: float,
) -> float:
    """The length of one route [planning cells]."""
    x = start[0]
    y = start[1]
    length = 0.0
    for k in range(count):
        i = pieces[k]
        o = turned[k]
        length += travel(x, y, ends[i, o, 0], ends[i, o, 1], diagonal)
        x = ends[i, 1 - o, 0]
        y = ends[i, 1 - o, 1]
        length += travel(ends[i, o, 0], ends[i, o, 1], x, y, diagonal)
    return length


_Arrays = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]


@kernel
def _improve(
    best: _Arrays,
    now: _Arrays,
    trial: _Arrays,
    ends: NDArray[np.float64],
    starts: NDArray[np.float64],
    diagonal: float,
    rounds: int,
    seed: np.uint64,
) -> None:
    n_pieces = ends.shape[0]
    _complete(best, ends, starts, diagonal)
    if n_pieces == 0:
        return
    _copy(best, now)
    middle = (ends[:, 0] + ends[:, 1]) / 2.0
    removed = np.empty(n_pieces, dtype=np.int64)
    touched = np.empty(starts.shape[0], dtype=np.bool_)
    least = _cost(best)
    last = least
    drawn = 0
    for turn in range(rounds):
        _copy(now, trial)
        bits = draw(seed, drawn)
        centre = below(bits, n_pieces)
        longest = np.argmax(trial[3])
        if turn % 2 == 0 and trial[2][longest] > 0:
            centre = trial[0][longest, below(bits, trial[2][longest])]
        strings = 1 + below(draw(seed, drawn + 1), MOST_STRINGS)
        drawn += 2
        touched[:] = False
        n_removed = 0
        for _ in range(strings):
            robot, place = _nearest_piece(trial, touched, middle, centre)
            if robot < 0:
                break
            touched[robot] = True
            taken = 1 + below(draw(seed, drawn), min(LONGEST_STRING, trial[2][robot]))
            first = place - below(draw(seed, drawn + 1), taken)
            drawn += 2
            first = min(max(first, 0), trial[2][robot] - taken)
            for k in range(first, first + taken):
                removed[n_removed] = trial[0][robot, k]
                n_removed += 1
            _take_out(trial, robot, first, taken, ends, starts, diagonal)
        order = below(draw(seed, drawn), 3)
        drawn += 1
        if order == 0:
            for a in range(n_removed - 1, 0, -1):
                b = below(draw(seed, drawn), a + 1)
                drawn += 1
                removed[a], removed[b] = removed[b], removed[a]
        elif order == 1:
            removed[:n_removed] = removed[:n_removed][::-1].copy()
        for q in range(n_removed):
            _insert(removed[q], trial, ends, starts, diagonal)
        cost = _cost(trial)
        if cost < last * (1.0 + THRESHOLD * (1.0 - turn / rounds)):
            last = cost
            _copy(trial, now)
            if cost < least - 1e-9:
                least = cost
                _copy(trial, best)


@kernel
def _cost(routes: _Arrays) -> float:
    length = routes[3]
    return length.max() + TOTAL * length.sum() / length.shape[0]


@kernel
def _copy(source: _Arrays, to: _Arrays) -> None:
    for r in range(source[2].shape[0]):
        to[2][r] = source[2][r]
        to[3][r] = source[3][r]
        for k in range(source[2][r]):
            to[0][r, k] = source[0][r, k]
            to[1][r, k] = source[1][r, k]


@kernel
def _complete(
    routes: _Arrays, ends: NDArray[np.float64], starts: NDArray[np.float64], diagonal: float
) -> None:
    """Work out the lengths and put in the pieces that are missing, in their order."""
    pieces, turned, count, length = routes
    missing = np.ones(ends.shape[0], dtype=np.bool_)
    for r in range(count.shape[0]):
        length[r] = route_length(pieces[r], turned[r], count[r], ends, starts[r], diagonal)
        for k in range(count[r]):
            missing[pieces[r, k]] = False
    for i in range(ends.shape[0]):
        if missing[i]:
            _insert(i, routes, ends, starts, diagonal)


@kernel
def _nearest_piece(
    routes: _Arrays, touched: NDArray[np.bool_], middle: NDArray[np.float64], centre: int
) -> tuple[int, int]:
    """The robot not touched whose route passes nearest to a piece, and the place in it, or -1."""
    pieces, _, count, _ = routes
    nearest = np.inf
    robot = -1
    place = 0
    for r in range(count.shape[0]):
        if touched[r]:
            continue
        for k in range(count[r]):
            i = pieces[r, k]
            off = abs(middle[i, 0] - middle[centre, 0]) + abs(middle[i, 1] - middle[centre, 1])
            if off < nearest:
                nearest = off
                robot = r
                place = k
    return robot, place


@kernel
def _take_out(
    routes: _Arrays,
    robot: int,
    first: int,
    taken: int,
    ends: NDArray[np.float64],
    starts: NDArray[np.float64],
    diagonal: float,
) -> None:
    """Take a string of pieces out of a route."""
    pieces, turned, count, length = routes
    for k in range(first + taken, count[robot]):
        pieces[robot, k - taken] = pieces[robot, k]
        turned[robot, k - taken] = turned[robot, k]
    count[robot] -= taken
    length[robot] = route_length(
        pieces[robot], turned[robot], count[robot], ends, starts[robot], diagonal
    )


@kernel
def _insert(
    i: int,
    routes: _Arrays,
    ends: NDArray[np.float64],
    starts: NDArray[np.float64],
    diagonal: float,
) -> None:
    """Put a piece in where the longest route, and then its own, grows least."""
    pieces, turned, count, length = routes
    longest = length.max()
    own = travel(ends[i, 0, 0], ends[i, 0, 1], ends[i, 1, 0], ends[i, 1, 1], diagonal)
    least = np.inf
    robot = 0
    place = 0
    way = 0
    more = 0.0
    for r in range(count.shape[0]):
        x = starts[r, 0]
        y = starts[r, 1]
        for k in range(count[r] + 1):
            last = k == count[r]
            nx = 0.0
            ny = 0.0
            skipped = 0.0
            if not last:
                j = pieces[r, k]
                nx = ends[j, turned[r, k], 0]
                ny = ends[j, turned[r, k], 1]
                skipped = travel(x, y, nx, ny, diagonal)
            for o in range(2):
                added = travel(x, y, ends[i, o, 0], ends[i, o, 1], diagonal) + own - skipped
                if not last:
                    added += travel(ends[i, 1 - o, 0], ends[i, 1 - o, 1], nx, ny, diagonal)
                after = length[r] + added
                cost = TOTAL * added + max(0.0, after - longest) + LATER * after
                if cost < least:
                    least = cost
                    robot = r
                    place = k
                    way = o
                    more = added
            if not last:
                j = pieces[r, k]
                x = ends[j, 1 - turned[r, k], 0]
                y = ends[j, 1 - turned[r, k], 1]
    for k in range(count[robot], place, -1):
        pieces[robot, k] = pieces[robot, k - 1]
        turned[robot, k] = turned[robot, k - 1]
    pieces[robot, place] = i
    turned[robot, place] = way
    count[robot] += 1
    length[robot] += more
