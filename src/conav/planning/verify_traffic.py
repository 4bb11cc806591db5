"""Whether a straight piece comes too near to anybody else of a plan."""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.verify_clearance import extended
from conav.planning.verify_curves import least_apart
from conav.planning.verify_scene import Scene


def others(
    scene: Scene, number: int, margin: float
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Everybody else's pieces, where each one's begin, and how far to stay away."""
    me = scene.bodies[number]
    ways = [
        (
            extended(track, body.stays, scene.horizon),
            me.radius + body.radius + scene.margin + margin,
        )
        for other, body, track in scene.ways()
        if other != number
    ]
    tracks = np.concatenate([np.empty((0, 9)), *(track for track, _ in ways)])
    firsts = np.cumsum([0, *(len(track) for track, _ in ways)]).astype(np.int64)
    return tracks, firsts, np.array([distance for _, distance in ways], dtype=np.float64)


@kernel
def _meets(
    piece: NDArray[np.float64],
    tracks: NDArray[np.float64],
    firsts: NDArray[np.int64],
    needed: NDArray[np.float64],
) -> bool:
    """Whether a piece comes too near to somebody."""
    for other in range(len(needed)):
        low = firsts[other]
        high = firsts[other + 1]
        while low < high:  # the first piece that ends no earlier than this one begins
            middle = (low + high) // 2
            if tracks[middle, 1] < piece[0]:
                low = middle + 1
            else:
                high = middle
        for k in range(low, firsts[other + 1]):
            if tracks[k, 0] > piece[1]:
                break
            begin = max(piece[0], tracks[k, 0])
            end = min(piece[1], tracks[k, 1])
            _, near, _ = least_apart(piece, tracks[k], begin, end, needed[other])
            if near < needed[other]:
                return True
    return False


@kernel
def clear_edges(
    vertices: NDArray[np.float64],
    tails: NDArray[np.int64],
    heads: NDArray[np.int64],
    tracks: NDArray[np.float64],
    firsts: NDArray[np.int64],
    needed: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Whether nobody is in the way of each edge."""
    clear = np.empty(len(tails), np.bool_)
    piece = np.zeros(9)
    for i in range(len(tails)):
        u = tails[i]
        w = heads[i]
        piece[0] = vertices[u, 2]
        piece[1] = vertices[w, 2]
        piece[2] = vertices[u, 0]
        piece[3] = vertices[u, 1]
        piece[4] = (vertices[w, 0] - vertices[u, 0]) / (piece[1] - piece[0])
        piece[5] = (vertices[w, 1] - vertices[u, 1]) / (piece[1] - piece[0])
        clear[i] = not _meets(piece, tracks, firsts, needed)
    return clear


@kernel
def clear_rests(
    vertices: NDArray[np.float64],
    horizon: float,
    tracks: NDArray[np.float64],
    firsts: NDArray[np.int64],
    needed: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Whether nobody comes too near to who stays at each vertex."""
    clear = np.empty(len(vertices), np.bool_)
    piece = np.zeros(9)
    for i in range(len(vertices)):
        piece[0] = vertices[i, 2]
        piece[1] = max(horizon, vertices[i, 2])
        piece[2] = vertices[i, 0]
        piece[3] = vertices[i, 1]
        clear[i] = not _meets(piece, tracks, firsts, needed)
    return clear
