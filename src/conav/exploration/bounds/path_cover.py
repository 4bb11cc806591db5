"""The shortest way to share out places among robots: exact, for a dozen places."""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel


@kernel
def least_longest_path(
    first: NDArray[np.float64],
    between: NDArray[np.float64],
    kind: NDArray[np.int64],
    weights: NDArray[np.int64],
    spare: int,
) -> float:
    """The least length of the longest path, over all ways to share out places and order them.

    `first` (n, k) is robot i's way to place w, `between` (kinds, k, k) the way from place to place
    for each kind of robot, `kind` (n,) each robot's. Places may be left out as long as their
    `weights` (k,) add up to `spare` at most.

    Held and Karp (1962) for the paths of each kind through every set of places, then the best
    shares, robot by robot. Ways need not keep the triangle inequality: a set of places is given no
    less than any part of it, which holds for real paths, that pass the places of the part as well.
    """
    n, k = first.shape
    full = (1 << k) - 1
    ahead = np.empty((full + 1, k))  # least way through a set of places, from one of them
    best = np.empty(full + 1)  # the current robot's least path through a set
    team = np.empty(full + 1)  # the least longest path of the robots so far
    spread = np.empty(full + 1)
    weight = np.zeros(full + 1, dtype=np.int64)
    for chosen in range(1, full + 1):
        w = 0
        while chosen & (1 << w) == 0:
            w += 1
        weight[chosen] = weight[chosen & (chosen - 1)] + weights[w]
    built = -1
    for robot in range(n):
        if kind[robot] != built:
            built = kind[robot]
            for chosen in range(1, full + 1):
                for w in range(k):
                    if chosen & (1 << w) == 0:
                        continue
                    rest = chosen & ~(1 << w)
                    least = np.inf if rest else 0.0
                    for v in range(k):
                        if rest & (1 << v):
                            least = min(least, between[built, w, v] + ahead[rest, v])
                    ahead[chosen, w] = least
        best[0] = 0.0
        for chosen in range(1, full + 1):
            least = np.inf
            for w in range(k):
                if chosen & (1 << w):
                    least = min(least, first[robot, w] + ahead[chosen, w])
            for w in range(k):
                if chosen & (1 << w):
                    least = max(least, best[chosen & ~(1 << w)])
            best[chosen] = least
        if robot == 0:
            team[:] = best
            continue
        for chosen in range(full + 1):
            if robot == n - 1 and weight[full & ~chosen] > spare:
                continue  # nobody asks for it
            least = np.inf
            part = chosen
            while True:
                longest = max(best[part], team[chosen & ~part])
                least = min(least, longest)
                if part == 0:
                    break
                part = (part - 1) & chosen
            spread[chosen] = least
        team[:] = spread
    result = np.inf
    for chosen in range(full + 1):
        if weight[full & ~chosen] <= spare:
            result = min(result, team[chosen])
    return result
