"""Rectangles: the generalised back and forth of [Dai2018], driven over known moves.

A rectangle has two lanes, one sensor footprint apart, and two short edges. A robot on its first
lane goes along it to the border, across to the second, along that to the border at the other end,
back across, and along the first to where it began: then the trajectory is closed. As it is a loop
it can be begun anywhere on it. Where there is room for one lane only both lanes are the same.

Coordinates are planning cells *along* the lanes and *across* them. With axis 0 lanes run north and
south, so across is the column and along the row; with axis 1 it is the other way round.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conav.exploration.belief import OPEN
from conav.exploration.types import TeamView
from conav.geometry.directions import DCOL, DROW
from conav.geometry.grid_search import path_to, search, search_space
from conav.maps.occupancy_grid import FREE, UNKNOWN
from conav.maps.planning_grid import Lattice

CHOOSE = -2
"""At the border; the second lane is to be chosen."""
CLOSED = -3
"""The rectangle is closed."""

PATIENCE = 64
"""Decisions a robot waits in one place for others to make way before it takes them for a border."""

WALL_ENDS = 4
"""Unknown cells beyond the last free ones ahead that are taken for a wall: a lane at a wall sees
all of it but its ends, one cell on either side."""

_NO_PATH = np.empty(0, dtype=np.int8)


@dataclass
class Path:
    """A path of known moves under way."""

    moves: NDArray[np.int8] = field(default_factory=lambda: _NO_PATH)  # the last one first
    left: int = 0
    here: int = -1  # planning cell from which they start

    def next(self, view: TeamView) -> int:
        """The direction of the next move, or -1 at the end and when pushed off."""
        if self.left and view.cell != self.here:
            k = int(self.moves[self.left - 1])
            if view.cell == self.here + DROW[k] * view.lattice.cols + DCOL[k]:
                self.here = view.cell
                self.left -= 1
            else:
                self.left = 0
        if self.left == 0:
            return -1
        return int(self.moves[self.left - 1])


@dataclass
class Rectangle:
    """A rectangle under way."""

    axis: int
    heading: int  # +1 or -1: the way it takes the first lane at first, the auxiliary direction
    first: int  # the first lane's coordinate across
    second: int | None  # the second lane's, None until chosen
    start: int  # coordinate along where it began
    leg: int = 0  # 0 to 4: lane, edge, lane, edge, rest of the first lane; 5 closed
    path: Path = field(default_factory=Path)  # round an obstacle
    cell: int = -1  # where the last decision was made
    waited: int = 0  # decisions made there since


def coordinates(axis: int, cell: int, cols: int) -> tuple[int, int]:
    """The coordinates of a planning cell: (along, across)."""
    row, col = divmod(cell, cols)
    return (row, col) if axis == 0 else (col, row)


def direction(axis: int, along: int, across: int) -> int:
    """The direction 0 to 3 of a unit step along or across the lanes."""
    dcol, drow = (across, along) if axis == 0 else (along, across)
    return 0 if dcol > 0 else 2 if dcol < 0 else 1 if drow > 0 else 3


def extent(axis: int, lattice: Lattice) -> tuple[int, int]:
    """The planning cells along the lanes and across them."""
    return (lattice.rows, lattice.cols) if axis == 0 else (lattice.cols, lattice.rows)


def half_footprint(range_m: float, lattice: Lattice) -> int:
    """The planning cells on either side of a lane that are seen whole from it.

    Lanes 2 h + 1 cells apart leave nothing between them: the grid's form of the distance 2 r.
    """
    across = 2 * int(range_m / lattice.resolution) + 1
    return max(int((across / lattice.ratio - 1) / 2), 0)


def lanes(lower: int, upper: int, advance: int, half: int) -> tuple[int, int]:
    """The two lanes of a section's next rectangle, entered from below if `advance` is +1.

    They reach no farther than the section needs; with room for one lane both are the same.
    """
    if advance < 0:
        first, second = lanes(-upper, -lower, 1, half)
        return -first, -second
    if upper - lower <= 2 * half:
        return upper - half, upper - half
    return lower + half, min(lower + 3 * half + 1, upper - half)


def next_move(rectangle: Rectangle, view: TeamView) -> int:
    """The next direction, or `CHOOSE` or `CLOSED`; to be called once a step."""
    if view.cell == rectangle.cell:
        rectangle.waited += 1
    else:
        rectangle.cell = view.cell
        rectangle.waited = 0
    if rectangle.waited > PATIENCE:
        rectangle.waited = 0
        rectangle.path.left = 0
        _end_leg(rectangle, view)
    around = rectangle.path.next(view)
    if around >= 0:
        return around
    while rectangle.leg < 5:
        if rectangle.leg == 1 and rectangle.second is None:
            return CHOOSE
        wanted = _leg_direction(rectangle, view)
        if wanted >= 0:
            if _possible(view, wanted):
                return wanted
            if _go_round(rectangle, view):
                return rectangle.path.next(view)
        _end_leg(rectangle, view)
    return CLOSED


def _possible(view: TeamView, k: int) -> bool:
    return bool(view.belief.moves.item(view.cell) >> k & 1)


def _end_leg(rectangle: Rectangle, view: TeamView) -> None:
    if rectangle.leg == 1:
        # What kept it from the second lane makes the place it is at the second lane.
        _, rectangle.second = coordinates(rectangle.axis, view.cell, view.lattice.cols)
    rectangle.leg += 1


def _leg_direction(rectangle: Rectangle, view: TeamView) -> int:
    """The direction the leg goes on in, -1 at its end."""
    along, across = coordinates(rectangle.axis, view.cell, view.lattice.cols)
    if rectangle.leg in (1, 3):
        assert rectangle.second is not None
        to = rectangle.second if rectangle.leg == 1 else rectangle.first
        if across == to:
            return -1
        return direction(rectangle.axis, 0, 1 if to > across else -1)
    heading = -rectangle.heading if rectangle.leg == 2 else rectangle.heading
    if rectangle.leg == 4 and heading * (along - rectangle.start) >= 0:
        return -1
    # Pushed off its lane it goes back to it, where it can.
    lane = rectangle.second if rectangle.leg == 2 else rectangle.first
    if lane is not None and across != lane:
        back = direction(rectangle.axis, 0, 1 if lane > across else -1)
        if _possible(view, back):
            return back
    return direction(rectangle.axis, heading, 0)


def _go_round(rectangle: Rectangle, view: TeamView) -> bool:
    """Whether there is a known way round what blocks the leg, to where the leg goes on.

    The way may be longer than the straight one by a footprint: more is a border.
    """
    axis = rectangle.axis
    lattice = view.lattice
    along, across = coordinates(axis, view.cell, lattice.cols)
    size_along, size_across = extent(axis, lattice)
    half = half_footprint(view.body.sensor.range_m, lattice)
    marks = view.belief.marks if axis == 0 else view.belief.marks.T
    wanted = np.zeros(view.belief.marks.shape, dtype=np.uint8)
    target = wanted if axis == 0 else wanted.T
    if rectangle.leg in (1, 3):
        assert rectangle.second is not None
        to = rectangle.second if rectangle.leg == 1 else rectangle.first
        low, high = (across + 1, to) if to > across else (to, across - 1)
        target[along, low : high + 1] = marks[along, low : high + 1] & OPEN
    else:
        lane = rectangle.second if rectangle.leg == 2 else rectangle.first
        heading = -rectangle.heading if rectangle.leg == 2 else rectangle.heading
        if lane is None or not 0 <= lane < size_across:
            return False
        end = size_along - 1 if heading > 0 else 0
        if rectangle.leg == 4:
            end = rectangle.start
        low, high = (along + 1, end) if heading > 0 else (end, along - 1)
        low = max(low, along - 2 * half - 1)
        high = min(high, along + 2 * half + 1)
        target[low : high + 1, lane] = marks[low : high + 1, lane] & OPEN
    if not wanted.any():
        return False
    space = search_space(wanted.size)
    goal = search(view.belief.moves, view.cell, wanted, OPEN, space)
    if goal < 0:
        return False
    to_along, to_across = coordinates(axis, goal, lattice.cols)
    straight = abs(to_along - along) + abs(to_across - across)
    if space.distance.item(goal) > straight + 2 * half + 1:
        return False
    moves, left = path_to(space, lattice.cols, goal)
    rectangle.path = Path(moves, left, view.cell)
    return left > 0


def path_towards(axis: int, lane: int, view: TeamView) -> Path | None:
    """The way to the lane, or as far towards it as is known; None when the robot is nearest."""
    belief = view.belief
    cols = view.lattice.cols
    space = search_space(belief.moves.size)
    search(belief.moves, view.cell, np.zeros_like(belief.marks), 1, space)
    reached = np.flatnonzero(space.stamp[:-1] == space.stamp[-1])
    across = reached % cols if axis == 0 else reached // cols
    off = np.abs(across - lane)
    nearest = off.min()
    _, here = coordinates(axis, view.cell, cols)
    if abs(here - lane) == nearest:
        return None
    candidates = reached[off == nearest]
    goal = int(candidates[np.argmin(space.distance[candidates])])
    moves, left = path_to(space, cols, goal)
    return Path(moves, left, view.cell)


def unknown_within_known(axis: int, lower: int, upper: int, view: TeamView) -> int:
    """The unknown map cells in these strips, inside the bounding box of known free space along the
    lanes."""
    cells = view.belief.cells if axis == 0 else view.belief.cells.T
    free = np.flatnonzero((cells == FREE).any(axis=1))
    if len(free) == 0:
        return 0
    low, high = _fine(lower, upper, view.lattice.ratio, cells.shape[1])
    return int(np.count_nonzero(cells[free[0] : free[-1] + 1, low:high] == UNKNOWN))


def rest_is_worth(rectangle: Rectangle, view: TeamView) -> bool:
    """Whether the rest of the rectangle would show anything: unknown beside free on its way.

    Asked from the second lane on; before, a robot cannot know where the border is.
    """
    if rectangle.leg < 2 or rectangle.second is None:
        return True
    along, _ = coordinates(rectangle.axis, view.cell, view.lattice.cols)
    half = half_footprint(view.body.sensor.range_m, view.lattice)
    size, _ = extent(rectangle.axis, view.lattice)
    end = 0 if rectangle.heading > 0 else size - 1
    if rectangle.leg == 2 and _beside_free(
        rectangle, view, along, end, rectangle.second - half, rectangle.second + half
    ):
        return True
    begin = end if rectangle.leg < 4 else along
    return _beside_free(
        rectangle, view, begin, rectangle.start, rectangle.first - half, rectangle.first + half
    )


def _beside_free(
    rectangle: Rectangle, view: TeamView, a: int, b: int, left: int, right: int
) -> bool:
    """Whether anything is unknown beside free between two places along, ends of walls apart."""
    belief = view.belief
    cells, frontier = belief.cells, belief.frontier
    if rectangle.axis == 1:
        cells, frontier = cells.T, frontier.T
    ratio = view.lattice.ratio
    low, high = _fine(min(a, b), max(a, b), ratio, cells.shape[0])
    first, last = _fine(left, right, ratio, cells.shape[1])
    if high <= low or last <= first:
        return False
    unknown = cells[low:high, first:last] == UNKNOWN
    if not unknown.any():
        return False
    edge = frontier[low:high, first:last] != 0
    beside = np.zeros_like(unknown)
    beside[1:] |= edge[:-1]
    beside[:-1] |= edge[1:]
    beside[:, 1:] |= edge[:, :-1]
    beside[:, :-1] |= edge[:, 1:]
    beside &= unknown
    free = np.flatnonzero((cells[low:high, first:last] == FREE).any(axis=1))
    if len(free) == 0:
        return False
    inside = int(np.count_nonzero(beside[free[0] : free[-1] + 1]))
    return inside > 0 or int(np.count_nonzero(beside)) > WALL_ENDS


def _fine(lower: int, upper: int, ratio: float, size: int) -> tuple[int, int]:
    """The map cells [from, to) of planning cells lower to upper."""
    return min(max(int(lower * ratio), 0), size), min(max(int((upper + 1) * ratio), 0), size)
