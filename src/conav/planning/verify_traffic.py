"""Whether a straight piece comes too near to anybody else of a plan.

Most of the others are far away at any time. Each of their pieces lies in a ball around its middle,
so a piece is looked at closely only where the balls leave a doubt; the answer does not depend on
them.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.verify_clearance import extended
from conav.planning.verify_curves import least_apart, place_at
from conav.planning.verify_scene import Scene

CLEAR, PERHAPS, MEETS = 2, 1, 0
"""Nobody is in the way; that depends on the margin; somebody is."""

_SLACK = 1e-6  # [m] by which balls are larger than they need to be


class Crowd(NamedTuple):
    """Everybody else of a plan, as long as they are there."""

    tracks: NDArray[np.float64]  # (pieces, 9), one robot's after the other's
    firsts: NDArray[np.int64]  # (others + 1,) where each one's pieces begin
    needed: NDArray[np.float64]  # (others,) how far to stay away [m]
    balls: NDArray[np.float64]  # (pieces, 3) x, y, radius [m]
    hulls: NDArray[np.float64]  # (others, 3) balls around all of one's pieces


def crowd_around(scene: Scene, number: int) -> Crowd:
    """Everybody but one robot."""
    me = scene.bodies[number]
    ways = [
        (extended(track, body.stays, scene.horizon), me.radius + body.radius + scene.margin)
        for other, body, track in scene.ways()
        if other != number
    ]
    tracks = np.concatenate([np.empty((0, 9)), *(track for track, _ in ways)])
    firsts = np.cumsum([0, *(len(track) for track, _ in ways)]).astype(np.int64)
    needed = np.array([distance for _, distance in ways], dtype=np.float64)
    return Crowd(tracks, firsts, needed, *_balls(tracks, firsts))


def way_of_edges(
    vertices: NDArray[np.float64],
    tails: NDArray[np.int64],
    heads: NDArray[np.int64],
    crowd: Crowd,
    margin: float,
) -> NDArray[np.int8]:
    """For each edge `CLEAR`, `PERHAPS` (within the margin [m]) or `MEETS`.

    It is fastest where edges with the same tail follow each other.
    """
    return _way_of_edges(vertices, tails, heads, *crowd, margin)


def way_of_rests(
    vertices: NDArray[np.float64], horizon: float, crowd: Crowd, margin: float
) -> NDArray[np.int8]:
    """As `way_of_edges`, for who stays at each vertex until the horizon."""
    return _way_of_rests(vertices, horizon, *crowd, margin)


@kernel
def _balls(
    tracks: NDArray[np.float64], firsts: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A ball around each piece, and one around each robot's pieces."""
    balls = np.empty((len(tracks), 3))
    hulls = np.empty((len(firsts) - 1, 3))
    for k in range(len(tracks)):
        half = (tracks[k, 1] - tracks[k, 0]) / 2.0
        x, y = place_at(tracks[k], tracks[k, 0] + half)
        speed = np.hypot(tracks[k, 4], tracks[k, 5])
        speed += 2.0 * half * np.hypot(tracks[k, 6], tracks[k, 7])
        balls[k, 0] = x
        balls[k, 1] = y
        balls[k, 2] = speed * half + _SLACK
    for other in range(len(hulls)):
        mine = balls[firsts[other] : firsts[other + 1]]
        x = (mine[:, 0].min() + mine[:, 0].max()) / 2.0
        y = (mine[:, 1].min() + mine[:, 1].max()) / 2.0
        hulls[other, 0] = x
        hulls[other, 1] = y
        hulls[other, 2] = (np.hypot(mine[:, 0] - x, mine[:, 1] - y) + mine[:, 2]).max()
    return balls, hulls


@kernel
def _first_from(tracks: NDArray[np.float64], low: int, high: int, time: float) -> int:
    """The first of some pieces that ends no earlier than a time."""
    while low < high:
        middle = (low + high) // 2
        if tracks[middle, 1] < time:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def _between(
    piece: NDArray[np.float64], other: NDArray[np.float64], needed: float, margin: float
) -> int:
    """Whether two pieces that are there at a common time come too near."""
    begin = max(piece[0], other[0])
    end = min(piece[1], other[1])
    low, high, _ = least_apart(piece, other, begin, end, needed + margin)
    if high < needed - margin:
        return MEETS
    return CLEAR if low >= needed + margin else PERHAPS


@kernel
def _way_of_edges(
    vertices: NDArray[np.float64],
    tails: NDArray[np.int64],
    heads: NDArray[np.int64],
    tracks: NDArray[np.float64],
    firsts: NDArray[np.int64],
    needed: NDArray[np.float64],
    balls: NDArray[np.float64],
    hulls: NDArray[np.float64],
    margin: float,
) -> NDArray[np.int8]:
    ways = np.empty(len(tails), np.int8)
    near = np.empty(len(tracks), np.int64)  # pieces that an edge from this tail may meet
    away = np.empty(len(tracks))  # how far to stay away from each
    piece = np.zeros(9)
    first = 0
    while first < len(tails):
        u = tails[first]
        x = vertices[u, 0]
        y = vertices[u, 1]
        begin = vertices[u, 2]
        latest = begin
        reach = 0.0
        last = first
        while last < len(tails) and tails[last] == u:
            w = heads[last]
            latest = max(latest, vertices[w, 2])
            reach = max(reach, np.hypot(vertices[w, 0] - x, vertices[w, 1] - y))
            last += 1
        count = 0
        for other in range(len(needed)):
            far = reach + needed[other] + margin
            if np.hypot(hulls[other, 0] - x, hulls[other, 1] - y) > far + hulls[other, 2]:
                continue
            for k in range(
                _first_from(tracks, firsts[other], firsts[other + 1], begin), firsts[other + 1]
            ):
                if tracks[k, 0] > latest:
                    break
                if np.hypot(balls[k, 0] - x, balls[k, 1] - y) <= far + balls[k, 2]:
                    near[count] = k
                    away[count] = needed[other]
                    count += 1
        piece[0] = begin
        piece[2] = x
        piece[3] = y
        for i in range(first, last):
            w = heads[i]
            piece[1] = vertices[w, 2]
            piece[4] = (vertices[w, 0] - x) / (piece[1] - begin)
            piece[5] = (vertices[w, 1] - y) / (piece[1] - begin)
            way = CLEAR
            for c in range(count):
                k = near[c]
                if tracks[k, 0] <= piece[1] and tracks[k, 1] >= begin:
                    way = min(way, _between(piece, tracks[k], away[c], margin))
                    if way == MEETS:
                        break
            ways[i] = way
        first = last
    return ways


@kernel
def _way_of_rests(
    vertices: NDArray[np.float64],
    horizon: float,
    tracks: NDArray[np.float64],
    firsts: NDArray[np.int64],
    needed: NDArray[np.float64],
    balls: NDArray[np.float64],
    hulls: NDArray[np.float64],
    margin: float,
) -> NDArray[np.int8]:
    ways = np.empty(len(vertices), np.int8)
    piece = np.zeros(9)
    for i in range(len(vertices)):
        x = vertices[i, 0]
        y = vertices[i, 1]
        piece[0] = vertices[i, 2]
        piece[1] = max(horizon, vertices[i, 2])
        piece[2] = x
        piece[3] = y
        way = CLEAR
        for other in range(len(needed)):
            far = needed[other] + margin
            if np.hypot(hulls[other, 0] - x, hulls[other, 1] - y) > far + hulls[other, 2]:
                continue
            for k in range(
                _first_from(tracks, firsts[other], firsts[other + 1], piece[0]), firsts[other + 1]
            ):
                if tracks[k, 0] > piece[1]:
                    break
                if np.hypot(balls[k, 0] - x, balls[k, 1] - y) <= far + balls[k, 2]:
                    way = min(way, _between(piece, tracks[k], needed[other], margin))
                    if way == MEETS:
                        break
            if way == MEETS:
                break
        ways[i] = way
    return ways
