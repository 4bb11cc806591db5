"""The least sum of costs over the robots' graphs, by conflict-based search.

Where two robots collide the search branches at the time t at which the two pieces that collide are
nearest, their centres d apart, less than the D they must keep. With m the middle between them:

    the one robot is not within rho of m at time t,  or  the other is not.     d / 2 < rho < D / 2

1. No plan without collisions is lost: two robots within rho of m are less than D apart, so in each
   such plan one of the two is not, on its way or at rest at t.
2. Each branch bars what its robot does now, which is d / 2 from m.

Rests need no rule of their own, and a bar takes out every edge through the place and not just the
one in use. Where d and D differ by so little that rounding could decide, the branches bar the two
edges (or rests) that collide, one each: no plan without collisions has both.

Of all pairs that collide the search branches at one where the cheaper branch costs most.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.barred_path import END, Bar, Place, Way, barred_path
from conav.planning.steering import pieces_of
from conav.planning.team import Team
from conav.planning.types import PIECE

_NEAR = 1e-7  # [m] that d is less than D by, for a bar on a place
_SPARE = 1e-9  # [m] that rho is less than D / 2 by


class Driven(NamedTuple):
    """A path by ranks, with the pieces of its way and rest."""

    path: NDArray[np.int64]
    pieces: NDArray[np.float64]  # (n, PIECE)
    edges: NDArray[np.int64]  # (n,) of each piece its edge's place on the path, the last the rest


class Meeting(NamedTuple):
    """Two robots too near each other: by which edges of their paths, when, and where they are."""

    a: int
    b: int
    edge_a: int
    edge_b: int
    time: float
    at_a: tuple[float, float]
    at_b: tuple[float, float]


@dataclass(eq=False)
class GraphModel:
    """Some robots of a team for conflict-based search, by their numbers in `robots`."""

    team: Team
    robots: Sequence[int]
    _found: dict[tuple[int, tuple[Bar, ...]], tuple[float, Driven] | None] = field(
        default_factory=dict
    )

    @property
    def size(self) -> int:
        return len(self.robots)

    def cheapest(
        self, robot: int, bars: Sequence[Bar], others: Sequence[Driven]
    ) -> tuple[float, Driven] | None:
        """The cheapest path; the others decide nothing, as equal costs are rare."""
        key = robot, tuple(bars)
        if key not in self._found:
            team, number = self.team, self.robots[robot]
            roads = team.roads_of(number)[0]
            limits = team.graphs[number].surroundings.limits
            stays, horizon = team.traffic.stays[number], team.traffic.horizon_s
            team.count("barred_paths")
            found = barred_path(roads, limits, stays, horizon, key[1])
            if found is None:
                self._found[key] = None
            else:
                self._found[key] = found[1], self._driven(number, found[0])
        return self._found[key]

    def collisions(self, paths: Sequence[Driven]) -> int:
        return len(self.meetings(paths))

    def branches(
        self, paths: Sequence[Driven], bars: Sequence[Sequence[Bar]]
    ) -> Sequence[tuple[int, Bar]]:
        best: tuple[tuple[int, Bar], ...] = ()
        most = (-1.0, -1.0)
        for meeting in self.meetings(paths):
            pair = self._bars(meeting, paths)
            rises: list[float] = []
            for robot, bar in pair:
                now = self.cheapest(robot, bars[robot], ())
                then = self.cheapest(robot, (*bars[robot], bar), ())
                assert now is not None, "a node has paths for all"
                rises.append(math.inf if then is None else then[0] - now[0])
            rank = (min(rises), max(rises))
            if rank > most:
                best, most = pair, rank
        return best

    def meetings(self, paths: Sequence[Driven]) -> list[Meeting]:
        """Of each two robots that collide the first two pieces that do."""
        found: list[Meeting] = []
        bodies = self.team.traffic.bodies
        for a, b in combinations(range(self.size), 2):
            distance = float(bodies[self.robots[a]] + bodies[self.robots[b]])
            i, j, time, ax, ay, bx, by = _meeting(paths[a].pieces, paths[b].pieces, distance)
            if i >= 0:
                edges = int(paths[a].edges[i]), int(paths[b].edges[j])
                found.append(Meeting(a, b, *edges, time, (ax, ay), (bx, by)))
        return found

    def _bars(
        self, meeting: Meeting, paths: Sequence[Driven]
    ) -> tuple[tuple[int, Bar], tuple[int, Bar]]:
        bodies = self.team.traffic.bodies
        a, b = meeting.a, meeting.b
        needed = float(bodies[self.robots[a]] + bodies[self.robots[b]])
        dx, dy = meeting.at_a[0] - meeting.at_b[0], meeting.at_a[1] - meeting.at_b[1]
        if needed - math.sqrt(dx * dx + dy * dy) < _NEAR:
            return (a, _way(paths[a], meeting.edge_a)), (b, _way(paths[b], meeting.edge_b))
        x = 0.5 * (meeting.at_a[0] + meeting.at_b[0])
        y = 0.5 * (meeting.at_a[1] + meeting.at_b[1])
        bar = Place(meeting.time, x, y, 0.5 * needed - _SPARE)
        return (a, bar), (b, bar)

    def _driven(self, robot: int, path: NDArray[np.int64]) -> Driven:
        """The path with its pieces, and the rest until the horizon if the robot stays."""
        team = self.team
        states = team.roads_of(robot)[0].arranged.states[path]
        pieces = pieces_of(team.graphs[robot].surroundings.limits, states)
        ends = np.searchsorted(states[1:, 2], pieces[:, 1])  # which vertex a piece leads up to
        end, horizon = states[-1], team.traffic.horizon_s
        if team.traffic.stays[robot] and end[2] < horizon:
            rest = np.zeros((1, PIECE))
            rest[0, :4] = end[2], horizon, end[0], end[1]
            pieces = np.vstack([pieces, rest])
            ends = np.append(ends, len(path) - 1)
        return Driven(path, pieces, ends)


def _way(driven: Driven, edge: int) -> Way:
    """The bar on an edge of a path, the last of which is its rest."""
    path = driven.path
    if edge >= len(path) - 1:
        return Way(int(path[-1]), END)
    return Way(int(path[edge]), int(path[edge + 1]))


@kernel
def _meeting(
    mine: NDArray[np.float64], theirs: NDArray[np.float64], distance: float
) -> tuple[int, int, float, float, float, float, float]:
    """The first two pieces less than `distance` apart at some time, and when they are nearest.

    With both places then; -1 for none. The arithmetic is that of `traffic.pieces_apart`.
    """
    least = distance * distance
    for a in range(len(mine)):
        for b in range(len(theirs)):
            begin = max(mine[a, 0], theirs[b, 0])
            end = min(mine[a, 1], theirs[b, 1])
            if begin > end:
                continue
            from_a = begin - mine[a, 0]
            from_b = begin - theirs[b, 0]
            ax = mine[a, 2] + mine[a, 4] * from_a
            ay = mine[a, 3] + mine[a, 5] * from_a
            bx = theirs[b, 2] + theirs[b, 4] * from_b
            by = theirs[b, 3] + theirs[b, 5] * from_b
            vx = mine[a, 4] - theirs[b, 4]
            vy = mine[a, 5] - theirs[b, 5]
            x = ax - bx
            y = ay - by
            near = x * x + y * y < least
            approach = x * vx + y * vy
            after = 0.0
            if approach < 0.0:
                after = min(-approach / (vx * vx + vy * vy), end - begin)
                x += vx * after
                y += vy * after
            if near or x * x + y * y < least:
                return (
                    a,
                    b,
                    begin + after,
                    ax + mine[a, 4] * after,
                    ay + mine[a, 5] * after,
                    bx + theirs[b, 4] * after,
                    by + theirs[b, 5] * after,
                )
    return -1, -1, 0.0, 0.0, 0.0, 0.0, 0.0
