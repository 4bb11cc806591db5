"""The witness bound: somebody must come to see each of some cells that are far from one another.

Take groups of cells, the witnesses, with V(w) the places from which any cell of group w is seen. A
team that may miss m cells can leave out groups of m cells at most, all together, and visits V(w) of
every other. Whoever visits several takes at least the least travel from its start to the first V(w)
and from each V(w) to the next, 0 where they overlap. So the least longest path over all ways to
leave out, share out and order the witnesses is a lower bound, whichever witnesses are taken;
looking for good ones only tightens it. To see all, m is 0 and a witness is a single cell.
"""

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.bounds.path_cover import least_longest_path
from conav.exploration.bounds.travel import turn_cost, whole_steps
from conav.exploration.bounds.views import Places, Survey, group_views, sensors_of, travel_of
from conav.exploration.types import ExplorationProblem

POOL = 256  # groups to choose witnesses from
TRAVEL = 2e7  # planning cells reached in finding the ways between these, a second or two
FEWEST = 16  # groups however large the map
TURNING = 6  # how much longer these take for robots that turn
SWAPPED = 8  # witnesses up to which exchanges are tried
TRIED = 40  # groups tried for each of these, the farthest from the others first
TRIED_LATER = 12  # and for each witness after them
WORK = 1e7  # divisions of the witnesses between two robots, times robots, that take a second or so


@dataclass(frozen=True, eq=False)
class Pool:
    """Groups of cells to choose witnesses from, and how far apart they are."""

    seeds: NDArray[np.int64]  # (groups,) a fine cell of each
    sizes: NDArray[np.int64]  # (groups,) cells
    first: NDArray[np.float64]  # (n_robots, groups) [steps] from each start
    between: NDArray[np.float64]  # (kinds, groups, groups) [steps] from one to another
    kind: NDArray[np.int64]  # (n_robots,) which of `between` is each robot's


@dataclass(frozen=True)
class Witnesses:
    """The bound, and what gave it."""

    steps: float  # whole; inf when nobody can see enough
    cells: tuple[int, ...]  # a fine cell of each witness
    tried: int  # sets of witnesses looked at


def witness_bound(
    problem: ExplorationProblem,
    places: Places,
    seen: Survey,
    observable: NDArray[np.uint8],
    needed: int,
    *,
    most: int = 15,
) -> Witnesses:
    """The step before which fewer than `needed` observable cells can have been seen.

    At most `most` witnesses are taken, and fewer by large teams; on large maps they are chosen
    from fewer groups, so that the work does not grow with the map for ever.
    """
    best = Witnesses(0.0, (), 0)
    if needed <= 0 or most <= 0:
        return best
    while most > 1 and len(problem.robots) * 3.0**most > WORK and len(problem.robots) > 2:
        most -= 1
    spare = int(observable.sum()) - needed
    pool = int(min(max(TRAVEL / (len(places.cells) * _searches(problem)), FEWEST), POOL))
    # With m cells to spare every group larger than m must be visited; of those larger than half
    # of m all but one, but they are seen from fewer places and are more.
    for group, seeds in (
        [single_cells(seen, observable, pool)]
        if spare == 0
        else [grown_groups(seen, observable, size, pool) for size in (spare + 1, spare // 2 + 1)]
    ):
        if len(seeds) > 0:
            found = _choose(pool_of(problem, places, group, seeds), spare, most)
            if found.steps > best.steps:
                best = found
    return best


def _searches(problem: ExplorationProblem) -> int:
    """How many searches over all places each group takes, in those of robots that need not turn."""
    kinds = {
        (robot.sensor, robot.motion, float(rate))
        for robot, rate in zip(problem.robots, problem.rates, strict=True)
    }
    return sum(TURNING if motion.turn_costs_step else 1 for _, motion, _ in kinds)


def single_cells(
    seen: Survey, observable: NDArray[np.uint8], most: int = POOL
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Groups of one cell each, `most` at most, all over the map, and these cells; hard ones to see.

    The cell seen last comes first, so that the bound is never below the eccentricity.
    """
    rows, cols = observable.shape
    cells = np.flatnonzero((observable.reshape(-1) == 1) & seen.known)
    last = cells[np.argmax(seen.first[cells])]
    hardest = cells[np.lexsort((-seen.first[cells], seen.views[cells]))]
    apart = int(0.9 * (np.count_nonzero(observable) / most) ** 0.5)
    taken = np.zeros((rows, cols), dtype=np.bool_)
    seeds: list[int] = []
    for cell in [int(last), *hardest.tolist()]:
        row, col = divmod(cell, cols)
        if taken[row, col]:
            continue
        seeds.append(cell)
        if len(seeds) == most:
            break
        taken[max(row - apart, 0) : row + apart + 1, max(col - apart, 0) : col + apart + 1] = True
    group = np.full(observable.size, -1, dtype=np.int32)
    group[seeds] = np.arange(len(seeds))
    return group, np.array(seeds, dtype=np.int64)


def grown_groups(
    seen: Survey, observable: NDArray[np.uint8], size: int, most: int = POOL
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """At most `most` connected groups of `size` cells each, and the cell each was grown from.

    No cell is in two. They are grown from the cells that are seen last and towards them, so that a
    group is what lies at the end of a way: the deep part of a room.
    """
    cells = np.flatnonzero(observable.reshape(-1))
    order = cells[np.argsort(-seen.first[cells], kind="stable")]
    return _grow(observable, order, seen.first, size, most)


@kernel
def _grow(
    observable: NDArray[np.uint8],
    order: NDArray[np.int64],
    first: NDArray[np.float64],
    size: int,
    most: int,
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    rows, cols = observable.shape
    group = np.full(rows * cols, -1, dtype=np.int32)
    queued = np.full(rows * cols, -1, dtype=np.int32)  # the last attempt that reached a cell
    too_small = np.zeros(rows * cols, dtype=np.uint8)  # what is left around it does not suffice
    seeds = np.empty(most, dtype=np.int64)
    members = np.empty(rows * cols, dtype=np.int64)
    count = 0
    for attempt in range(order.shape[0]):
        seed = order[attempt]
        if group[seed] >= 0 or too_small[seed] == 1:
            continue
        heap = [(-first[seed], seed)]
        queued[seed] = attempt
        held = 0
        while len(heap) > 0 and held < size:
            cell = heapq.heappop(heap)[1]
            members[held] = cell
            held += 1
            row = cell // cols
            col = cell % cols
            for r, c in ((row, col + 1), (row + 1, col), (row, col - 1), (row - 1, col)):
                if 0 <= r < rows and 0 <= c < cols and observable[r, c] == 1:
                    other = r * cols + c
                    if group[other] < 0 and queued[other] != attempt:
                        queued[other] = attempt
                        heapq.heappush(heap, (-first[other], other))
        for i in range(held):
            if held == size:
                group[members[i]] = count
            else:
                too_small[members[i]] = 1
        if held == size:
            seeds[count] = seed
            count += 1
            if count == most:
                break
    return group, seeds[:count].copy()


def pool_of(
    problem: ExplorationProblem,
    places: Places,
    group: NDArray[np.int32],
    seeds: NDArray[np.int64],
) -> Pool:
    """The groups, and the least travel from the starts to where each is seen and between these."""
    n = len(problem.robots)
    count = len(seeds)
    first = np.full((n, count), np.inf)
    between: list[NDArray[np.float64]] = []
    kinds: dict[tuple[object, float, float], int] = {}
    kind = np.zeros(n, dtype=np.int64)
    for sensor, robots in sensors_of(problem).items():
        sees = group_views(problem.plan, sensor, places, group, count)
        number, place = np.nonzero(sees)
        at = places.cells[place]
        # Where the places of each group that is seen at all begin in `at`.
        held, begin = np.unique(number, return_index=True)
        for robot in robots:
            start = np.array([problem.starts[robot]], dtype=np.int64)
            if len(held) > 0:
                travel = travel_of(problem, robot, start)[at]
                first[robot, held] = np.minimum.reduceat(travel, begin)
            rate = float(problem.rates[robot])
            key = (sensor, rate, turn_cost(problem.robots[robot].motion, rate))
            if key not in kinds:
                kinds[key] = len(between)
                table = np.full((count, count), np.inf)
                for index in held.tolist():
                    travel = travel_of(problem, robot, at[number == index])[at]
                    table[index, held] = np.minimum.reduceat(travel, begin)
                between.append(table)
            kind[robot] = kinds[key]
    return Pool(
        seeds=seeds,
        sizes=np.bincount(group[group >= 0], minlength=count).astype(np.int64),
        first=first,
        between=np.array(between),
        kind=kind,
    )


def _choose(pool: Pool, spare: int, most: int) -> Witnesses:
    """The best bound found: witnesses are added one by one, the first ones exchanged in between."""
    count = len(pool.seeds)
    tried = 0
    nearest = pool.first.min(axis=0)
    apart = pool.between.min(axis=0)

    def bound(chosen: list[int]) -> float:
        return least_longest_path(
            np.ascontiguousarray(pool.first[:, chosen]),
            np.ascontiguousarray(pool.between[:, chosen][:, :, chosen]),
            pool.kind,
            pool.sizes[chosen],
            spare,
        )

    def add(chosen: list[int], tries: int) -> tuple[float, list[int]]:
        """The best bound with one more witness, of those farthest from the others."""
        nonlocal tried
        distance = nearest.copy()
        for index in chosen:
            distance = np.minimum(distance, apart[index])
        distance[chosen] = 0.0
        order = np.argsort(-distance, kind="stable")[:tries]
        best = (-1.0, chosen)
        for index in order[distance[order] > 0.0].tolist():
            tried += 1
            value = bound([*chosen, index])
            if value > best[0]:
                best = (value, [*chosen, index])
        return best

    value, chosen = 0.0, list[int]()
    while len(chosen) < min(most, count):
        later = len(chosen) >= SWAPPED
        more, longer = add(chosen, TRIED_LATER if later else TRIED)
        if len(longer) == len(chosen):
            break
        value, chosen = more, longer
        improved = len(chosen) == min(SWAPPED, most, count)
        while improved:
            improved = False
            for index in list(chosen):
                more, other = add([item for item in chosen if item != index], TRIED)
                if more > value + 1e-9:
                    value, chosen, improved = more, other, True
    return Witnesses(whole_steps(value), tuple(pool.seeds[chosen].tolist()), tried)
