"""Routes that see a share of a map that is known: a plan nobody on the spot could make.

A plan is improved by ruin and recreate (Schrimpf et al. 2000): some viewpoints are taken out of the
routes, and then, as long as too little is seen, an unseen cell is drawn and of all places that see
it the one is put in where it lengthens the longest route least. What is seen on the way counts, and
viewpoints that became needless are dropped. Whole steps and meetings are not looked at here: what a
plan is worth is found by driving it.
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.bounds.travel import travel_from, turn_cost
from conav.exploration.bounds.views import Places, Sight, sensors_of
from conav.exploration.types import ExplorationProblem
from conav.geometry.directions import DCOL, DROW, SQRT2
from conav.geometry.sight import cells_in_sight

MOST_BYTES = 2**27  # of each: what places see, what is seen on the way, distances
THRESHOLD = 0.03  # how much worse than the best a plan may be to be changed next

Route = list[int]  # viewpoints, planning cells; the start comes first


@dataclass(frozen=True)
class KnownMapPlan:
    """Routes that together see at least what was asked for."""

    routes: tuple[tuple[int, ...], ...]  # per robot every planning cell, the start first
    steps: float  # of the longest route, meetings and rounding left out
    viewpoints: int
    seen: int  # observable cells


def known_map_plan(
    problem: ExplorationProblem,
    observable: NDArray[np.uint8],
    needed: int,
    rng: np.random.Generator,
    *,
    rounds: int = 150,
) -> KnownMapPlan | None:
    """Routes from which at least `needed` observable cells are seen, or None when none can be.

    `observable` (fine rows, fine cols) is 1 for the cells that count; `rounds` is how often routes
    are ruined and recreated. A plan that is little worse than the best so far is taken as the next
    one to change (record-to-record travel, Dueck 1993).
    """
    terrain = _Terrain(problem, observable)
    routes = [[start] for start in problem.starts]
    if not terrain.recreate(routes, needed, rng):
        return None
    terrain.drop(routes, needed)
    best = routes
    least = terrain.cost(routes)
    for _ in range(rounds):
        trial = [list(route) for route in routes]
        terrain.ruin(trial, rng)
        if not terrain.recreate(trial, needed, rng):
            continue
        terrain.drop(trial, needed)
        cost = terrain.cost(trial)
        if cost <= least * (1.0 + THRESHOLD):
            routes = trial
        if cost < least:
            best, least = trial, cost
    return KnownMapPlan(
        routes=tuple(tuple(terrain.walk(robot, route)) for robot, route in enumerate(best)),
        steps=max(terrain.steps(robot, route) for robot, route in enumerate(best)),
        viewpoints=sum(len(route) - 1 for route in best),
        seen=_count(terrain.seen(best)),
    )


@dataclass(eq=False)
class _Terrain:
    """What is seen from where and how far it is, worked out when first asked for."""

    problem: ExplorationProblem
    observable: NDArray[np.uint8]
    fields: dict[tuple[float, int], NDArray[np.float64]] = field(default_factory=dict)
    legs: dict[tuple[int, float, int, int], NDArray[np.uint64]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        problem = self.problem
        places = Places.of(problem)
        self.count = int(self.observable.sum())
        self.words = (self.count + 63) // 64
        sensors = sensors_of(problem)
        row_bytes = max(8 * self.words * len(sensors), 1)
        # On maps too large for the table only every so many places are looked from, and those
        # that are needed beside them.
        stride = -(-len(places.cells) * row_bytes // MOST_BYTES)
        looked = np.zeros(len(places.cells), dtype=np.bool_)
        looked[:: max(stride, 1)] = True
        for sensor in sensors if stride > 1 else ():
            sight = Sight(problem.plan, sensor)
            _add_looks(
                problem.plan.walls,
                self.observable,
                places.centres,
                sight.occlusion,
                sight.limits,
                sight.lows,
                sight.highs,
                sight.out,
                looked,
            )
        self.lookouts = places.cells[looked]
        self.number = np.full(problem.plan.moves.size, -1, dtype=np.int64)
        self.number[self.lookouts] = np.arange(len(self.lookouts))
        self.sensor = [0] * len(problem.robots)
        self.bits: list[NDArray[np.uint64]] = []
        for index, (sensor, robots) in enumerate(sensors.items()):
            for robot in robots:
                self.sensor[robot] = index
            self.bits.append(self._looks(Sight(problem.plan, sensor), places.centres[looked]))
        self.turn = [
            turn_cost(robot.motion, float(rate))
            for robot, rate in zip(problem.robots, problem.rates, strict=True)
        ]

    def _looks(self, sight: Sight, centres: NDArray[np.int64]) -> NDArray[np.uint64]:
        place_in = np.cumsum(self.observable.reshape(-1), dtype=np.int64) - 1
        bits = np.zeros((len(centres), self.words), dtype=np.uint64)
        _fill_looks(
            self.problem.plan.walls,
            self.observable,
            place_in,
            centres,
            sight.occlusion,
            sight.limits,
            sight.lows,
            sight.highs,
            sight.out,
            bits,
        )
        return bits

    def field(self, robot: int, cell: int) -> NDArray[np.float64]:
        """Cells of travel between a place and every planning cell."""
        key = (self.turn[robot], cell)
        found = self.fields.get(key)
        if found is None:
            if len(self.fields) * 8 * self.problem.plan.moves.size >= MOST_BYTES:
                self.fields.clear()
            source = np.array([cell], dtype=np.int64)
            found = travel_from(self.problem.plan.moves, source, self.turn[robot])
            self.fields[key] = found
        return found

    def leg(self, robot: int, a: int, b: int) -> NDArray[np.uint64]:
        """What is seen on the way from a to b, b included and a not."""
        key = (self.sensor[robot], self.turn[robot], a, b)
        found = self.legs.get(key)
        if found is None:
            if len(self.legs) * 8 * self.words >= MOST_BYTES:
                self.legs.clear()
            found = self.look(robot, self.path(robot, a, b))
            self.legs[key] = found
        return found

    def look(self, robot: int, cells: NDArray[np.int64]) -> NDArray[np.uint64]:
        """What is seen from any of some planning cells."""
        rows = self.number[cells]
        table = self.bits[self.sensor[robot]]
        return np.bitwise_or.reduce(table[rows[rows >= 0]], axis=0, initial=np.uint64(0))

    def path(self, robot: int, a: int, b: int) -> NDArray[np.int64]:
        """The planning cells of a shortest way from a to b, b included and a not."""
        return _descend(self.problem.plan.moves, self.field(robot, a), b)

    def walk(self, robot: int, route: Route) -> list[int]:
        """All planning cells of a route, the start first."""
        cells = [route[0]]
        for a, b in pairwise(route):
            cells.extend(self.path(robot, a, b).tolist())
        return cells

    def steps(self, robot: int, route: Route) -> float:
        length = sum(float(self.field(robot, a)[b]) for a, b in pairwise(route))
        return length / float(self.problem.rates[robot])

    def cost(self, routes: list[Route]) -> float:
        """What is minimised: the longest route [steps], and a little of all together."""
        steps = [self.steps(robot, route) for robot, route in enumerate(routes)]
        return max(steps) + 0.1 * sum(steps)

    def seen(self, routes: list[Route]) -> NDArray[np.uint64]:
        """What is seen along all routes, a bit for each observable cell."""
        result = np.zeros(self.words, dtype=np.uint64)
        for robot, route in enumerate(routes):
            result |= self.seen_by(robot, route)
        return result

    def seen_by(self, robot: int, route: Route) -> NDArray[np.uint64]:
        result = self.look(robot, np.array(route[:1]))
        for a, b in pairwise(route):
            result |= self.leg(robot, a, b)
        return result

    def recreate(self, routes: list[Route], needed: int, rng: np.random.Generator) -> bool:
        """Whether viewpoints could be put in until enough is seen; for cells in random order."""
        rank = rng.permutation(self.count)
        hopeless = np.zeros(self.count, dtype=np.bool_)
        while True:
            seen = self.seen(routes)
            if _count(seen) >= needed:
                return True
            hidden = np.flatnonzero(~_unpacked(seen, self.count) & ~hopeless)
            if len(hidden) == 0:
                return False
            cell = int(hidden[np.argmin(rank[hidden])])
            if not self._insert(routes, cell):
                hopeless[cell] = True

    def _insert(self, routes: list[Route], cell: int) -> bool:
        """Whether a viewpoint that sees the cell was put in, where it lengthens least."""
        steps = [self.steps(robot, route) for robot, route in enumerate(routes)]
        longest = max(steps)
        least = (np.inf, np.inf)
        where = (-1, -1, -1)
        for robot, route in enumerate(routes):
            column = self.bits[self.sensor[robot]][:, cell // 64] >> np.uint64(cell % 64)
            spots = self.lookouts[column & np.uint64(1) == 1]
            if len(spots) == 0:
                continue
            to = np.array([self.field(robot, stop)[spots] for stop in route])
            more = to.copy()  # after the last viewpoint, or between two
            for at, (a, b) in enumerate(pairwise(route)):
                more[at] += to[at + 1] - self.field(robot, a)[b]
            at, best = divmod(int(np.argmin(more)), len(spots))
            added = float(more[at, best]) / float(self.problem.rates[robot])
            cost = (max(longest, steps[robot] + added), added)
            if cost < least:
                least = cost
                where = (robot, at + 1, int(spots[best]))
        robot, at, spot = where
        if robot < 0:
            return False
        routes[robot].insert(at, spot)
        return True

    def drop(self, routes: list[Route], needed: int) -> None:
        """Take out viewpoints without which enough is seen all the same."""
        later = [np.zeros(self.words, dtype=np.uint64)]  # seen by the routes after each
        for robot in range(len(routes) - 1, 0, -1):
            later.append(later[-1] | self.seen_by(robot, routes[robot]))
        before = np.zeros(self.words, dtype=np.uint64)
        for robot, route in enumerate(routes):
            before |= self.look(robot, np.array(route[:1]))
            # Entry j: what is seen from viewpoint j onwards, the way to it left out.
            ahead = [later.pop()] * 2
            for a, b in zip(route[-2::-1], route[:0:-1], strict=True):
                ahead.append(ahead[-1] | self.leg(robot, a, b))
            ahead.reverse()
            kept = route[:1]
            for j in range(1, len(route)):
                rest = before | ahead[j + 1]
                if j + 1 < len(route):
                    rest |= self.leg(robot, kept[-1], route[j + 1])
                if _count(rest) < needed:
                    before |= self.leg(robot, kept[-1], route[j])
                    kept.append(route[j])
            route[:] = kept

    def ruin(self, routes: list[Route], rng: np.random.Generator) -> None:
        """Take out a stretch of one route, or viewpoints near one another of all."""
        held = [(robot, at) for robot, route in enumerate(routes) for at in range(1, len(route))]
        if not held:
            return
        most = max(2, len(held) // 3)
        count = int(rng.integers(1, most + 1))
        robot, at = held[int(rng.integers(len(held)))]
        if rng.integers(2) == 0:
            del routes[robot][at : at + count]
            return
        near = self.field(robot, routes[robot][at])
        held.sort(key=lambda spot: float(near[routes[spot[0]][spot[1]]]))
        for robot, at in sorted(held[:count], reverse=True):
            del routes[robot][at]


def _count(words: NDArray[np.uint64]) -> int:
    return int(np.bitwise_count(words).sum())


def _unpacked(words: NDArray[np.uint64], count: int) -> NDArray[np.bool_]:
    octets = words.astype("<u8").view(np.uint8)
    return np.unpackbits(octets, bitorder="little")[:count].astype(np.bool_)


@kernel
def _fill_looks(
    walls: NDArray[np.uint8],
    observable: NDArray[np.uint8],
    place_in: NDArray[np.int64],
    centres: NDArray[np.int64],
    occlusion: bool,
    limits: NDArray[np.int32],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    bits: NDArray[np.uint64],
) -> None:
    cols = walls.shape[1]
    wanted = observable.reshape(-1)
    for i in range(centres.shape[0]):
        row, col = divmod(centres[i], cols)
        count = cells_in_sight(walls, row, col, occlusion, limits, lows, highs, out)
        for j in range(count):
            if wanted[out[j]] == 1:
                bit = place_in[out[j]]
                bits[i, bit // 64] |= np.uint64(1) << np.uint64(bit % 64)


@kernel
def _add_looks(
    walls: NDArray[np.uint8],
    observable: NDArray[np.uint8],
    centres: NDArray[np.int64],
    occlusion: bool,
    limits: NDArray[np.int32],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    looked: NDArray[np.bool_],
) -> None:
    """Mark further places until every cell that some place sees is seen from a marked one."""
    cols = walls.shape[1]
    hidden = observable.reshape(-1).copy()
    for turn in range(2):
        for i in range(centres.shape[0]):
            if looked[i] != (turn == 0):
                continue  # first what the marked ones see, then what the others see beyond that
            row, col = divmod(centres[i], cols)
            count = cells_in_sight(walls, row, col, occlusion, limits, lows, highs, out)
            for j in range(count):
                if hidden[out[j]] == 1:
                    hidden[out[j]] = 0
                    looked[i] = True


@kernel
def _descend(
    moves: NDArray[np.uint8], distance: NDArray[np.float64], goal: int
) -> NDArray[np.int64]:
    """The cells from a distance field's source, left out, to a goal."""
    cols = moves.shape[1]
    flat = moves.reshape(-1)
    path = np.empty(flat.shape[0], dtype=np.int64)
    count = 0
    cell = goal
    last = -1
    while distance[cell] > 0.0:
        path[count] = cell
        count += 1
        least = np.inf
        best = -1
        for k in range(8):
            if flat[cell] & (1 << k):
                other = cell + DROW[k] * cols + DCOL[k]
                length = distance[other] + (1.0 if k < 4 else SQRT2)
                # Going straight on, ways being equal: for robots that turn it is shorter.
                if length < least - 1e-9 or (length < least + 1e-9 and k == last):
                    least = length
                    best = k
        last = best
        cell += DROW[best] * cols + DCOL[best]
    return path[:count][::-1].copy()
