"""Social entropy: how a team is spread out, in one number (Balch 2000).

Simple social entropy is Shannon's over the shares of a team's clusters. Hierarchic social entropy
adds it up over all levels h of a clustering: at level h robots belong together when no two of them
differ by more than h. Difference is distance here, as in [Dai2018], so the unit is metres times
bits, and two robots at distance d have S = d: the larger, the more dispersed.

Logarithms differ in the last digit between machines. They are only taken of quotients of small
integers and are rounded to 12 decimals, so that every machine compares the same numbers.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import log2, sqrt
from typing import Literal

from conav.exploration.types import TeamView
from conav.geometry.directions import DCOL, DROW

Measure = Literal["hierarchic", "simple"]
Sense = Literal["minimise", "maximise"]
Point = tuple[float, float]  # x, y

_DECIMALS = 12
_MOST = 10  # robots: clusters are cliques, whose number may grow exponentially


@lru_cache(maxsize=4096)
def _information(part: int, whole: int) -> float:
    """The term -p log2 p of a share p = part / whole [bits], rounded."""
    return round(-(part / whole) * log2(part / whole), _DECIMALS) if part < whole else 0.0


def shannon(sizes: Sequence[int]) -> float:
    """The entropy of a team divided into clusters of these sizes [bits].

    The share of a cluster is its size over the sum of all sizes, also where clusters overlap.

    >>> round(shannon([1, 3]), 3)
    0.811
    """
    whole = sum(sizes)
    return sum(_information(size, whole) for size in sorted(sizes) if size > 0)


def clusters(distances: Sequence[Sequence[float]], level: float) -> list[frozenset[int]]:
    """The maximal sets of robots no two of which are farther apart than `level`, ordered.

    They may overlap (C_u of Balch). They are the maximal cliques of the graph of pairs within the
    level, found with Bron and Kerbosch's algorithm with a pivot.
    """
    n = len(distances)
    near = [frozenset(j for j in range(n) if j != i and distances[i][j] <= level) for i in range(n)]
    found: list[frozenset[int]] = []

    def extend(chosen: frozenset[int], left: frozenset[int], done: frozenset[int]) -> None:
        if not left and not done:
            found.append(chosen)
            return
        pivot = max(sorted(left | done), key=lambda i: len(near[i] & left))
        for i in sorted(left - near[pivot]):
            extend(chosen | {i}, left & near[i], done & near[i])
            left -= {i}
            done |= {i}

    if n:
        extend(frozenset(), frozenset(range(n)), frozenset())
    return sorted(found, key=sorted)


def entropy_at(distances: Sequence[Sequence[float]], level: float) -> float:
    """The entropy of the clusters at one level, H(R, h) [bits]."""
    return shannon([len(cluster) for cluster in clusters(distances, level)])


def hierarchic_entropy(distances: Sequence[Sequence[float]]) -> float:
    """Hierarchic social entropy, the integral of H(R, h) over h from 0 to infinity [m bits].

    Exact: clusters change only where h passes a distance between two robots.
    """
    n = len(distances)
    levels = sorted({float(distances[i][j]) for i in range(n) for j in range(i)})
    total = 0.0
    below = 0.0
    for level in levels:
        # From `below` up to but not `level` the clusters are those at `below`.
        if level > below:
            total += entropy_at(distances, below) * (level - below)
            below = level
    return total


def team_entropy(points: Sequence[Point], measure: Measure, level: float) -> float:
    """The social entropy of robots at these points; `level` is for the simple measure."""
    distances = [[sqrt((x - a) ** 2 + (y - b) ** 2) for a, b in points] for x, y in points]
    if measure == "hierarchic":
        return round(hierarchic_entropy(distances), 9)
    return round(entropy_at(distances, level), 9)


def nearest_points(points: Sequence[Point], who: int, most: int) -> list[Point]:
    """The point `who` first, then those of the `most` - 1 robots nearest to it."""
    x, y = points[who]
    others = [i for i in range(len(points)) if i != who]
    others.sort(key=lambda i: ((points[i][0] - x) ** 2 + (points[i][1] - y) ** 2, i))
    return [points[who], *(points[i] for i in sorted(others[: most - 1]))]


def best_directions(
    shifts: Sequence[Point], entropy: Callable[[Point], float], sense: Sense
) -> list[int]:
    """The numbers of the shifts of one robot after which the team's entropy is best, all ties."""
    values = [entropy(shift) for shift in shifts]
    if not values:
        return []
    best = min(values) if sense == "minimise" else max(values)
    return [i for i, value in enumerate(values) if value == best]


def entropy_directions(
    view: TeamView,
    directions: Sequence[int],
    *,
    sense: Sense,
    measure: Measure,
    level: float,
    probe: float,
) -> list[int]:
    """The directions after a move in which the team's entropy is best, all ties.

    The robot is imagined `probe` metres that way, the others where they were last heard. Directions
    it cannot start in are left out unless it can start in none. Of large teams the ten nearest
    count.
    """
    possible = [k for k in directions if view.belief.moves.item(view.cell) >> k & 1]
    possible = possible or list(directions)
    known = [robot for robot, cell in enumerate(view.heard_cell.tolist()) if cell >= 0]
    points = [view.lattice.position(int(view.heard_cell[robot])) for robot in known]
    (x, y), *others = nearest_points(points, known.index(view.robot), _MOST)

    def entropy(shift: Point) -> float:
        moved = (x + probe * shift[0], y + probe * shift[1])
        return team_entropy([moved, *others], measure, level)

    shifts = [(float(DCOL[k]), float(DROW[k])) for k in possible]
    return [possible[i] for i in best_directions(shifts, entropy, sense)]
