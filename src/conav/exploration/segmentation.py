"""Exploration by rooms: Wurm, Stachniss and Burgard (IROS 2008).

The known free space is cut where it is narrow, and robots are assigned to the parts before they are
assigned to frontiers. The paper cuts a Voronoi graph at its critical points: nodes where the
clearance, the distance to the nearest obstacle, has a local minimum, next to a junction. Here no
graph is built. Cells are taken in the order of falling clearance, so that parts grow from its peaks
along the ridges the Voronoi graph consists of, and two parts meet exactly at the local minimum of
clearance on the ridge between them (the watershed of Vincent and Soille 1991). The parts stay apart
where that minimum is narrow beside both peaks, which takes the place of the paper's rule that a
critical point lies next to a junction.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from conav.compiled import kernel
from conav.exploration.belief import OPEN, Belief
from conav.exploration.frontier_targets import Targets
from conav.exploration.hungarian import assign_shortest
from conav.exploration.team_assignment import TeamMemory, team_step
from conav.exploration.types import Action, TeamView
from conav.geometry.directions import DCOL, DROW
from conav.maps.occupancy_grid import OCCUPIED
from conav.maps.planning_grid import Lattice
from conav.messages.message import Message

STRAIGHT_STEP = 5
"""Clearance is counted in fifths of a fine cell: chamfer distance 5-7-11 (Borgefors 1986)."""

_FAR = 65_535  # where no obstacle is known near enough


@dataclass(frozen=True)
class Segmentation:
    """Robots are spread over the rooms that have frontiers, then over the frontiers in each.

    The cost of a segment is the path to its nearest frontier, less a discount for a robot that is
    in it already, so that a room is finished before it is left. Robots are assigned to segments by
    the Hungarian method (scipy's); when they are more, each segment takes another robot only when
    all have as many. Inside a segment robots are assigned to pieces of frontier in the same way.
    """

    narrowing: float = 0.7
    """Cut a passage whose clearance is less than this share of that of both its sides, 0 to 1."""
    discount: float = 0.4
    """Share of a segment's cost that a robot inside it is spared, 0 to 1."""

    def __post_init__(self) -> None:
        for name, share in (("narrowing", self.narrowing), ("discount", self.discount)):
            if not 0.0 <= share <= 1.0:
                raise ValueError(f"{name} is {share:g}; give 0 to 1")

    def start(self, view: TeamView, rng: np.random.Generator) -> TeamMemory:
        return TeamMemory()

    def step(
        self,
        memory: TeamMemory,
        view: TeamView,
        inbox: Sequence[Message],
        rng: np.random.Generator,
    ) -> tuple[TeamMemory, Action, Sequence[Message]]:
        return team_step(memory, view, inbox, self._assign)

    def _assign(
        self, targets: Targets, view: TeamView, robots: Sequence[int], positions: NDArray[np.int32]
    ) -> NDArray[np.int64]:
        labels = segments(view.belief, view.lattice, self.narrowing).reshape(-1)
        return assign_by_segment(
            targets, view, labels[targets.cells], labels[positions], self.discount
        )


def assign_by_segment(
    targets: Targets,
    view: TeamView,
    of_target: NDArray[np.int32],
    of_robot: NDArray[np.int32],
    discount: float,
) -> NDArray[np.int64]:
    """A planning cell per robot, -1 for none, given the segments of targets and robots."""
    goals = np.full(len(targets.costs), -1, dtype=np.int64)
    reachable = np.isfinite(targets.costs).any(axis=0)
    names = np.unique(of_target[reachable])
    if len(names) == 0:
        return goals
    costs = np.full((len(goals), len(names)), np.inf)
    for column, name in enumerate(names.tolist()):
        costs[:, column] = targets.costs[:, of_target == name].min(axis=1)
    inside = of_robot[:, None] == names[None, :]
    chosen = spread(np.where(inside, (1.0 - discount) * costs, costs))
    for column, name in enumerate(names.tolist()):
        here = np.flatnonzero(chosen == column)
        if len(here) == 0:
            continue
        own = of_target == name
        # A piece that lies in two segments is a piece in each.
        unique, piece = np.unique(targets.piece[own], return_inverse=True)
        part = Targets(
            targets.cells[own], piece.astype(np.int64), len(unique), targets.costs[here][:, own]
        )
        goals[here] = assign_shortest(part, view, here.tolist(), of_robot[here])
    return goals


def spread(costs: NDArray[np.float64]) -> NDArray[np.int64]:
    """The column for each row, -1 for none: the cheapest way to use all columns equally often.

    `costs` (n_robots, n_segments) is inf where a robot cannot get to a segment. With more robots
    than segments every segment has as many columns as it takes; one more robot in a segment costs
    more than all paths together.
    """
    robots, columns = costs.shape
    chosen = np.full(robots, -1, dtype=np.int64)
    finite = costs[np.isfinite(costs)]
    if len(finite) == 0:
        return chosen
    copies = -(-robots // columns)
    more = 1.0 + float(finite.max()) * robots
    never = more * (copies + 1) * robots
    table = np.tile(costs, (1, copies)) + more * np.repeat(np.arange(copies), columns)
    for robot, column in zip(
        *linear_sum_assignment(np.where(np.isfinite(table), table, never)), strict=True
    ):
        if np.isfinite(table[robot, column]):
            chosen[robot] = column % columns
    return chosen


def segments(belief: Belief, lattice: Lattice, narrowing: float) -> NDArray[np.int32]:
    """The segment of every planning cell known to be standable, -1 elsewhere, shape (rows, cols).

    Segments are numbered from 0 in the order of falling clearance of their widest places.
    """
    clear = clearance(belief.cells)[np.ix_(lattice.fine_row, lattice.fine_col)]
    clear = np.minimum(clear, _FAR).astype(np.uint16)
    cells = np.flatnonzero(belief.marks & OPEN)
    # Sixteen bits are sorted by digits. Ties stay in the order of the cells.
    order = cells[np.argsort(_FAR - clear.reshape(-1)[cells], kind="stable")]
    labels = np.full(belief.moves.shape, -1, dtype=np.int32)
    _flood(belief.moves, clear, order, narrowing, labels)
    return labels


def clearance(cells: NDArray[np.uint8]) -> NDArray[np.int32]:
    """Distance from every fine cell to the nearest known obstacle [fine cells / 5], same shape.

    A chamfer distance in whole numbers, at most 2 % off the Euclidean one, in a tenth of its time.
    """
    rows, cols = cells.shape
    # A border two cells wide, so that every cell has all the neighbours a step can come from.
    distance = np.full((rows + 4, cols + 4), _FAR, dtype=np.int32)
    inner = distance[2:-2, 2:-2]
    inner[cells == OCCUPIED] = 0
    _chamfer(distance)
    return inner


@kernel
def _chamfer(distance: NDArray[np.int32]) -> None:
    rows, cols = distance.shape
    flat = distance.reshape(-1)
    # Once forwards with the steps from before, once backwards with those from behind.
    for sign in (1, -1):
        for i in range(2, rows - 2):
            r = i if sign == 1 else rows - 1 - i
            for j in range(2, cols - 2):
                c = j if sign == 1 else cols - 1 - j
                at = r * cols + c
                up = at - sign * cols
                upper = up - sign * cols
                best = min(flat[at - sign], flat[up]) + 5
                best = min(best, min(flat[up - 1], flat[up + 1]) + 7)
                best = min(best, min(flat[up - 2], flat[up + 2]) + 11)
                best = min(best, min(flat[upper - 1], flat[upper + 1]) + 11)
                flat[at] = min(flat[at], best)


@kernel
def _flood(
    moves: NDArray[np.uint8],
    clear: NDArray[np.uint16],
    order: NDArray[np.int64],
    narrowing: float,
    labels: NDArray[np.int32],
) -> None:
    """Number the segments of the cells in `order`, which is that of falling clearance."""
    cols = moves.shape[1]
    ways = moves.reshape(-1)
    height = clear.reshape(-1)
    label = labels.reshape(-1)
    size = order.shape[0]
    # A part that has been merged points to the one that took it; peaks come in falling order, so
    # the lower number is always the higher peak.
    leader = np.empty(size, dtype=np.int32)
    peak = np.empty(size, dtype=np.float64)
    count = 0
    for i in range(size):
        cell = order[i]
        here = float(height[cell])
        first = -1
        beside = -1
        widest = -1.0
        # Twice round: the highest part first, then those that give way to it.
        for turn in range(2):
            for k in range(8):
                if ways[cell] & (1 << k) == 0:
                    continue
                other = cell + DROW[k] * cols + DCOL[k]
                if label[other] < 0:
                    continue
                part = label[other]
                while leader[part] != part:
                    leader[part] = leader[leader[part]]
                    part = leader[part]
                if turn == 0:
                    if first < 0 or part < first:
                        first = part
                    if float(height[other]) > widest:
                        widest = float(height[other])
                        beside = part
                elif part != first and here >= narrowing * peak[part]:
                    leader[part] = first
                    beside = first  # the cell that joins two parts belongs to them
        if first < 0:
            leader[count] = count
            peak[count] = here
            beside = count
            count += 1
        label[cell] = beside
    number = np.full(count, -1, dtype=np.int32)
    used = 0
    for part in range(count):
        if leader[part] == part:
            number[part] = used
            used += 1
    for i in range(size):
        part = label[order[i]]
        while leader[part] != part:
            part = leader[part]
        label[order[i]] = number[part]
