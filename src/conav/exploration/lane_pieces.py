"""Unknown area in the open, cut into pieces of lanes that robots sweep.

A lane is a strip as wide as a robot sees from its middle line. A piece is a part of a lane, from
where to where a robot has to drive on the middle line to see all that is unknown beside it.
Everything unknown is taken for clear, as far as it can be reached through cells that are not known
to be walls.

Coordinates are planning cells *along* the lanes and *across* them. With axis 0 lanes run north and
south, so across is the column and along the row; with axis 1 it is the other way round.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from conav.compiled import kernel
from conav.exploration.rectangle_drive import extent, half_footprint
from conav.geometry.directions import DCOL, DROW
from conav.geometry.sight import lateral_limits
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN
from conav.maps.planning_grid import Lattice


@dataclass(frozen=True)
class Piece:
    """A part of a lane that holds unknown cells; lengths in planning cells."""

    lane: int
    low: int  # along, where the unknown cells begin
    high: int  # and end
    begin: int  # along: a drive on the middle line from here
    end: int  # to here, or back, sees them; begin <= end


@dataclass(frozen=True, eq=False)
class Lanes:
    """Lanes over a whole map, side by side and about equally wide."""

    axis: int
    middle: NDArray[np.int64]  # (n_lanes,) across, the line a robot drives on
    edges: NDArray[np.int64]  # (n_lanes + 1,) map cells across, where one ends and the next begins
    fine_middle: NDArray[np.int64]  # (n_lanes,) the map cell of the middle line
    limits: NDArray[np.int32]  # (reach + 1,) map cells seen ahead by distance to the side

    @property
    def width(self) -> int:
        """The width of the widest lane [map cells]."""
        return int(np.diff(self.edges).max())

    def beside(self, across: int) -> list[int]:
        """The lane a planning cell is in and those next to it."""
        lane = int(np.argmin(np.abs(self.middle - across)))
        return [k for k in (lane - 1, lane, lane + 1) if 0 <= k < len(self.middle)]


def lay_lanes(axis: int, range_m: float, lattice: Lattice) -> Lanes:
    """As few lanes as cover the map, each some whole strips of planning cells.

    Everything in a lane is seen from its middle line in the open, unless single strips are too wide
    for that.
    """
    along, across = extent(axis, lattice)
    limits = lateral_limits(range_m / lattice.resolution)
    strip_of = lattice.col_of if axis == 0 else lattice.row_of
    fine_of = lattice.fine_col if axis == 0 else lattice.fine_row
    fine_along = lattice.fine_row if axis == 0 else lattice.fine_col
    end = (lattice.fine_rows if axis == 0 else lattice.fine_cols) - 1
    # A robot looks from centres of planning cells only: how far the row farthest from one is.
    off = max(int(fine_along[0]), end - int(fine_along[-1]))
    if along > 1:
        off = max(off, int(np.diff(fine_along).max()) // 2)
    count = -(-across // (2 * half_footprint(range_m, lattice) + 1))
    while True:
        strips = np.array([k * across // count for k in range(count + 1)])
        middle = (strips[:-1] + strips[1:] - 1) // 2
        edges = np.searchsorted(strip_of, strips).astype(np.int64)
        fine_middle = fine_of[middle].astype(np.int64)
        side = int(np.maximum(fine_middle - edges[:-1], edges[1:] - 1 - fine_middle).max())
        if count == across or (side < len(limits) and limits[side] >= off):
            break
        count += 1
    return Lanes(axis, middle.astype(np.int64), edges, fine_middle, limits)


def wanted_cells(
    cells: NDArray[np.uint8], known_free: Sequence[int], given_up: NDArray[np.uint8]
) -> NDArray[np.uint8]:
    """1 for the unknown cells that may be reached from these map cells and are not given up.

    `cells` and `given_up` (fine rows, fine cols); `known_free` are flat indices of free cells.
    """
    regions = np.asarray(cast("tuple[Any, int]", label(cells != OCCUPIED))[0])
    here = np.unique(regions.reshape(-1)[np.asarray(known_free)])
    reachable = np.isin(regions, here[here > 0])
    return (reachable & (cells == UNKNOWN) & (given_up == 0)).astype(np.uint8)


def find_pieces(
    lanes: Lanes,
    wanted: NDArray[np.uint8],
    lattice: Lattice,
    cuts: Sequence[Sequence[int]],
    most: int,
) -> list[Piece]:
    """The pieces of all lanes, in the order of lanes and along them.

    `wanted` (fine rows, fine cols) is 1 for the cells to be seen. A run of them along a lane is one
    piece, gaps up to the width of a lane included; it is cut at the `cuts` of its lane (along) and
    into equal parts no longer than about `most`. Less than one row of cells is not worth a sweep:
    it is taken out of `wanted`.
    """
    oriented = wanted if lanes.axis == 0 else wanted.T
    along_of = lattice.row_of if lanes.axis == 0 else lattice.col_of
    fine_along = lattice.fine_row if lanes.axis == 0 else lattice.fine_col
    width = lanes.width
    side, count = _profile(np.ascontiguousarray(oriented), lanes.edges, lanes.fine_middle)
    longest = max(int(most * lattice.ratio), width)
    pieces: list[Piece] = []
    for lane in range(len(lanes.middle)):
        rows = np.flatnonzero(side[lane] >= 0)
        if len(rows) == 0:
            continue
        marks = sorted({int(np.searchsorted(along_of, along)) for along in cuts[lane]})
        for run in np.split(rows, np.flatnonzero(np.diff(rows) > width) + 1):
            if int(count[lane, run].sum()) < width:
                strip = slice(int(lanes.edges[lane]), int(lanes.edges[lane + 1]))
                oriented[run[0] : run[-1] + 1, strip] = 0
                continue
            for part in _cut(run, marks, longest, width // 2, along_of):
                # A cell to the side is seen from so far before and behind it.
                ahead = np.maximum(
                    lanes.limits[np.minimum(side[lane, part], len(lanes.limits) - 1)], 0
                )
                begin, end = _drive(
                    int((part + ahead).min()), int((part - ahead).max()), along_of, fine_along
                )
                low, high = int(along_of[part[0]]), int(along_of[part[-1]])
                pieces.append(Piece(lane, low, high, begin, end))
    return pieces


def _drive(
    begin: int, end: int, along_of: NDArray[np.int32], fine_along: NDArray[np.int32]
) -> tuple[int, int]:
    """From where to where to drive (along) to look from map cells up to `begin` and from `end` on.

    A robot looks from centres of planning cells. Where there is one from `end` to `begin`, one look
    is enough.
    """
    first = int(np.searchsorted(fine_along, begin, side="right")) - 1
    last = int(np.searchsorted(fine_along, end))
    if first >= last:
        middle = min(max(int(along_of[(begin + end) // 2]), last), first)
        return middle, middle
    return max(first, 0), min(last, len(fine_along) - 1)


def _cut(
    run: NDArray[np.int64],
    marks: Sequence[int],
    most: int,
    least: int,
    along_of: NDArray[np.int32],
) -> list[NDArray[np.int64]]:
    """A run of rows cut at marks, and in about equal parts; marks nearer than `least` are left out.

    Parts meet between planning cells, so that what is swept of one can be told in planning cells.
    """
    edges = [int(run[0])]
    for mark in marks:
        if mark - edges[-1] >= least and int(run[-1]) - mark >= least:
            edges.append(mark)
    edges.append(int(run[-1]) + 1)
    parts: list[NDArray[np.int64]] = []
    for a, b in pairwise(edges):
        count = max(-(-(b - a) // most), 1)
        inner = [along_of[a + (b - a) * i // count] for i in range(1, count)]
        for low, high in pairwise([a, *np.searchsorted(along_of, inner).tolist(), b]):
            part = run[np.searchsorted(run, low) : np.searchsorted(run, high)]
            if len(part):
                parts.append(part)
    return parts


@kernel
def looks_like_wall(cells: NDArray[np.uint8], row: int, col: int, around: int, least: int) -> bool:
    """Whether all unknown cells beside free ones near a map cell go on a long wall.

    Near is up to `around` cells in rows and columns. Such a cell has a free one on one side, and
    along that side `least` cells of wall next to it. The end of a wall seen from a lane looks so.
    """
    rows, cols = cells.shape
    for r in range(max(row - around, 0), min(row + around, rows - 1) + 1):
        for c in range(max(col - around, 0), min(col + around, cols - 1) + 1):
            if cells[r, c] != UNKNOWN:
                continue
            beside_free = False
            goes_on = False
            for k in range(4):
                r2 = r + DROW[k]
                c2 = c + DCOL[k]
                if not (0 <= r2 < rows and 0 <= c2 < cols) or cells[r2, c2] != FREE:
                    continue
                beside_free = True
                for side in (1, 3):
                    down = DROW[(k + side) % 4]
                    right = DCOL[(k + side) % 4]
                    length = 0
                    r3 = r + down
                    c3 = c + right
                    while (
                        length < least
                        and 0 <= r3 < rows
                        and 0 <= c3 < cols
                        and cells[r3, c3] == OCCUPIED
                    ):
                        length += 1
                        r3 += down
                        c3 += right
                    if length >= least:
                        goes_on = True
            if beside_free and not goes_on:
                return False
    return True


@kernel
def _profile(
    wanted: NDArray[np.uint8], edges: NDArray[np.int64], middle: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Per lane and map cell along it: how far to the side a wanted cell lies, -1 where none does,
    and how many there are."""
    along = wanted.shape[0]
    lanes = middle.shape[0]
    farthest = np.full((lanes, along), -1, dtype=np.int64)
    count = np.zeros((lanes, along), dtype=np.int64)
    for a in range(along):
        for lane in range(lanes):
            for c in range(edges[lane], edges[lane + 1]):
                if wanted[a, c] == 1:
                    count[lane, a] += 1
                    farthest[lane, a] = max(farthest[lane, a], abs(c - middle[lane]))
    return farthest, count
