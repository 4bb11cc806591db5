"""Driving a piece of a lane: to its nearer end, along its middle line, round what is in the way.

A robot drives through what it does not know yet as if it were clear, and makes another way when it
sees that it is not.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.belief import OPEN, Belief
from conav.exploration.rectangle_drive import coordinates, direction, half_footprint
from conav.exploration.types import TeamView
from conav.geometry.directions import DCOL, DROW
from conav.geometry.grid_search import path_to, search, search_space
from conav.maps.occupancy_grid import OCCUPIED, UNKNOWN
from conav.maps.planning_grid import Lattice

_NO_PATH = np.empty(0, dtype=np.int8)
PATIENCE = 64
"""Decisions a robot waits in one place for others to make way before it gives a piece up."""


@dataclass(frozen=True)
class Sweep:
    """An order to sweep a piece of a lane: to `begin`, then along the lane to `end`."""

    axis: int
    across: int  # planning cells
    begin: int
    end: int
    low: int  # along: what is unknown in the lane from here
    high: int  # to here is to be seen

    @property
    def size_bytes(self) -> int:
        """Five planning coordinates of 4 bytes and the axis."""
        return 21


@dataclass
class SweepDrive:
    """A sweep under way."""

    sweep: Sweep
    sweeping: bool = False  # it has got to where it begins
    path: NDArray[np.int8] = field(default_factory=lambda: _NO_PATH)  # the last move first
    left: int = 0
    here: int = -1  # planning cell where the path goes on
    cell: int = -1  # where the last decision was made
    waited: int = 0  # decisions made there since

    def goes_on_as(self, order: Sweep) -> bool:
        """Whether the robot is doing what it is ordered to: the lane, up to the same end."""
        own = self.sweep
        return self.sweeping and (own.axis, own.across, own.end) == (
            order.axis,
            order.across,
            order.end,
        )


def next_move(drive: SweepDrive, view: TeamView) -> int:
    """The next direction, or -1 when the sweep is over; to be called once a step."""
    if view.cell == drive.cell:
        drive.waited += 1
        if drive.waited > PATIENCE:
            return -1
    else:
        drive.cell = view.cell
        drive.waited = 0
    sweep = drive.sweep
    cols = view.lattice.cols
    along, across = coordinates(sweep.axis, view.cell, cols)
    if not drive.sweeping and along == sweep.begin and across == sweep.across:
        drive.sweeping = True
        drive.left = 0
    if drive.sweeping and along == sweep.end and across == sweep.across:
        return -1
    if drive.left and view.cell != drive.here:
        k = int(drive.path[drive.left - 1])
        if view.cell == drive.here + DROW[k] * cols + DCOL[k]:
            drive.here = view.cell
            drive.left -= 1
        else:
            drive.left = 0  # pushed off the path
    ways = int(view.belief.moves.item(view.cell))
    if drive.left == 0 and drive.sweeping and across == sweep.across:
        ahead = direction(sweep.axis, 1 if sweep.end > along else -1, 0)
        if ways >> ahead & 1:
            return ahead
    if drive.left:
        k = int(drive.path[drive.left - 1])
        blocked = _blocked_at(
            view.belief.cells,
            view.belief.marks,
            view.lattice.fine_row,
            view.lattice.fine_col,
            drive.here,
            drive.path,
            drive.left,
        )
        if ways >> k & 1 and not blocked:
            return k
    if not _find_way(drive, view):
        return -1
    k = int(drive.path[drive.left - 1])
    return k if ways >> k & 1 else -1


def swept(drive: SweepDrive, view: TeamView) -> Sweep:
    """What a robot says it has done with: all it was to see, or what it came by."""
    sweep = drive.sweep
    along, _ = coordinates(sweep.axis, view.cell, view.lattice.cols)
    if not drive.sweeping or along == sweep.end:
        return sweep
    half = half_footprint(view.body.sensor.range_m, view.lattice)
    if sweep.end > sweep.begin:
        return replace(sweep, high=min(sweep.high, along + half))
    return replace(sweep, low=max(sweep.low, along - half))


def place_of(drive: SweepDrive, view: TeamView) -> int:
    """The planning cell a robot is heading for: where it knows no farther, if not the end."""
    sweep = drive.sweep
    cols = view.lattice.cols
    if drive.left:
        ways = drive.path[drive.left - 1 :: -1].tolist()
    else:
        along, _ = coordinates(sweep.axis, view.cell, cols)
        ways = [direction(sweep.axis, 1 if sweep.end > along else -1, 0)] * abs(sweep.end - along)
    cell = view.cell
    for k in ways:
        following = cell + DROW[k] * cols + DCOL[k]
        if not view.belief.marks.item(following) & OPEN:
            break
        cell = following
    return cell


def _find_way(drive: SweepDrive, view: TeamView) -> bool:
    """Whether there may be a way to where the sweep begins or goes on."""
    sweep = drive.sweep
    lattice = view.lattice
    along, _ = coordinates(sweep.axis, view.cell, lattice.cols)
    goals = np.zeros(view.belief.moves.shape, dtype=np.uint8)
    line = (goals if sweep.axis == 0 else goals.T)[:, sweep.across]
    heading = 1 if sweep.end >= sweep.begin else -1
    moves, possible = presumed_moves(
        view.belief, lattice, view.body.radius_m, view.body.motion.diagonal
    )
    free = (possible if sweep.axis == 0 else possible.T)[:, sweep.across]
    first = -1
    if drive.sweeping:
        # On from here, beyond what is in the way.
        low, high = (along + 1, sweep.end) if heading > 0 else (sweep.end, along - 1)
        line[low : high + 1] = free[low : high + 1]
    else:
        first = _first_of(free, sweep)
        if first < 0:
            return False
        line[first] = 1
    space = search_space(goals.size)
    goal = search(moves, view.cell, goals, 1, space)
    if goal < 0 and not drive.sweeping:
        # It may be clear there, but shut off, as inside a block. The search went everywhere.
        reached = (space.stamp[:-1] == space.stamp[-1]).reshape(goals.shape)
        first = _first_of((reached if sweep.axis == 0 else reached.T)[:, sweep.across], sweep)
        if first >= 0:
            row, col = (first, sweep.across) if sweep.axis == 0 else (sweep.across, first)
            goal = row * lattice.cols + col
    if goal < 0:
        return False
    if not drive.sweeping and first != sweep.begin:
        drive.sweep = replace(sweep, begin=first)
    drive.here = view.cell
    drive.path, drive.left = path_to(space, lattice.cols, goal)
    if drive.left == 0 and not drive.sweeping:
        drive.sweeping = True
        return _find_way(drive, view)
    return drive.left > 0


def _first_of(places: NDArray[Any], sweep: Sweep) -> int:
    """The first place (along) from where a sweep begins to its end that is one of these, or -1."""
    step = 1 if sweep.end >= sweep.begin else -1
    for along in range(sweep.begin, sweep.end + step, step):
        if places[along]:
            return along
    return -1


def presumed_moves(
    belief: Belief, lattice: Lattice, radius_m: float, diagonal: bool
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Moves that are known or may be possible, and planning cells where a robot may stand.

    Both (rows, cols). A planning cell is possible when it is known to be standable, or when
    something within the radius of its centre is unknown and nothing there is known to be a wall.
    """
    possible = np.empty(belief.moves.shape, dtype=np.uint8)
    moves = np.empty(belief.moves.shape, dtype=np.uint8)
    _presume(
        belief.cells,
        belief.marks,
        belief.moves,
        lattice.fine_row,
        lattice.fine_col,
        radius_m / lattice.resolution,
        diagonal,
        possible,
        moves,
    )
    return moves, possible


@kernel
def _presume(
    cells: NDArray[np.uint8],
    marks: NDArray[np.uint8],
    known: NDArray[np.uint8],
    fine_row: NDArray[np.int32],
    fine_col: NDArray[np.int32],
    radius: float,
    diagonal: bool,
    possible: NDArray[np.uint8],
    moves: NDArray[np.uint8],
) -> None:
    rows, cols = marks.shape
    fine_rows, fine_cols = cells.shape
    reach = int(radius + 0.5)
    for r in range(rows):
        for c in range(cols):
            if marks[r, c] & OPEN:
                possible[r, c] = 1
                continue
            possible[r, c] = 0
            wall = False
            dark = False
            top = min(fine_row[r] + reach, fine_rows - 1)
            right = min(fine_col[c] + reach, fine_cols - 1)
            for y in range(max(fine_row[r] - reach, 0), top + 1):
                for x in range(max(fine_col[c] - reach, 0), right + 1):
                    if cells[y, x] == OCCUPIED:
                        wall = True
                    elif cells[y, x] == UNKNOWN:
                        dark = True
            if dark and not wall:
                possible[r, c] = 1
    for r in range(rows):
        for c in range(cols):
            bits = known[r, c]
            if possible[r, c]:
                for k in range(8 if diagonal else 4):
                    r2 = r + DROW[k]
                    c2 = c + DCOL[k]
                    if r2 < 0 or r2 >= rows or c2 < 0 or c2 >= cols or not possible[r2, c2]:
                        continue
                    if marks[r, c] & marks[r2, c2] & OPEN:
                        continue  # known to be possible or not
                    if k >= 4 and not (possible[r2, c] and possible[r, c2]):
                        continue
                    bits |= 1 << k
            moves[r, c] = bits


@kernel
def _blocked_at(
    cells: NDArray[np.uint8],
    marks: NDArray[np.uint8],
    fine_row: NDArray[np.int32],
    fine_col: NDArray[np.int32],
    here: int,
    path: NDArray[np.int8],
    left: int,
) -> bool:
    """Whether the centre of a cell on the path is known to be a wall."""
    cols = marks.shape[1]
    cell = here
    for i in range(left - 1, -1, -1):
        k = path[i]
        cell += DROW[k] * cols + DCOL[k]
        r = cell // cols
        c = cell % cols
        if marks[r, c] & OPEN == 0 and cells[fine_row[r], fine_col[c]] == OCCUPIED:
            return True
    return False
