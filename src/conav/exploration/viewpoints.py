"""Where to look from when no frontier can be stood on: the last pockets of a map.

A frontier often lies where the robot's disc does not fit: close to a wall, behind furniture, in a
gap. Then the unknown cells beside it are looked at from farther away. Sight is symmetric, so the
places that might see an unknown cell are the cells that it might see, with everything unknown taken
as clear. A place that was scanned from already cannot qualify: had the view from it been clear, the
cell would be known, and if not, the wall in between is.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.exploration.belief import Belief
from conav.geometry.grid_search import SearchSpace
from conav.geometry.sight import (
    disc_cells,
    lateral_limits,
    new_gap_space,
    sight_buffer_size,
    visible_cells,
)
from conav.maps.occupancy_grid import UNKNOWN
from conav.maps.planning_grid import Lattice
from conav.robots.sensor import Sensor


@dataclass
class HopelessCells:
    """Unknown cells no known place can see, remembered until a new place or way opens."""

    opened: tuple[int, int] = (-1, -1)  # places and ways known then
    flags: NDArray[np.uint8] | None = None  # (fine rows, fine cols)


def beside_frontier(belief: Belief) -> NDArray[np.uint8]:
    """Planning cells beside a cell with frontier and not scanned from yet, shape (rows, cols)."""
    rows, cols = belief.frontier_count.shape
    inside = np.zeros((rows + 2, cols + 2), dtype=np.bool_)
    inside[1:-1, 1:-1] = belief.frontier_count > 0
    near = np.zeros((rows, cols), dtype=np.bool_)
    for down in range(3):
        for right in range(3):
            near |= inside[down : down + rows, right : right + cols]
    cells = (near & (belief.stood == 0)).astype(np.uint8)
    cells.flags.writeable = False
    return cells


def nearest_viewpoint(
    belief: Belief,
    lattice: Lattice,
    sensor: Sensor,
    reached: SearchSpace,
    hopeless: HopelessCells,
) -> tuple[int, int]:
    """The nearest reached planning cell that might see an unknown cell beside a frontier, and that
    unknown cell (flat fine index); -1, -1 when there is none.

    `reached` holds the last search from the robot over everything it can reach.
    """
    if hopeless.flags is None or hopeless.opened != (belief.opened, belief.ways):
        hopeless.opened = (belief.opened, belief.ways)
        hopeless.flags = np.zeros(belief.cells.shape, dtype=np.uint8)
    reach = min(sensor.range_m / lattice.resolution, sum(belief.cells.shape))
    limits = lateral_limits(reach)
    hidden = unknown_beside_frontier(belief)
    return _nearest_viewpoint(
        belief.cells,
        hidden,
        hopeless.flags,
        sensor.occlusion,
        limits,
        belief.stood,
        lattice.row_of,
        lattice.col_of,
        lattice.fine_row,
        lattice.fine_col,
        0 if lattice.ratio >= 1 else int(0.5 / lattice.ratio) + 1,
        reached.stamp,
        reached.distance,
        new_gap_space(limits),
        new_gap_space(limits),
        np.empty(sight_buffer_size(limits), dtype=np.int32),
    )


def unknown_beside_frontier(belief: Belief) -> NDArray[np.int64]:
    """Flat indices of the unknown cells with a frontier cell as straight neighbour, ascending."""
    rows, cols = belief.cells.shape
    at = np.flatnonzero(belief.frontier)
    row, col = np.divmod(at, cols)
    around = np.concatenate(
        [at[row > 0] - cols, at[row < rows - 1] + cols, at[col > 0] - 1, at[col < cols - 1] + 1]
    )
    return np.unique(around[belief.cells.reshape(-1)[around] == UNKNOWN])


@kernel
def _nearest_viewpoint(
    cells: NDArray[np.uint8],
    hidden: NDArray[np.int64],
    hopeless: NDArray[np.uint8],
    occlusion: bool,
    limits: NDArray[np.int32],
    stood: NDArray[np.uint8],
    row_of: NDArray[np.int32],
    col_of: NDArray[np.int32],
    fine_row: NDArray[np.int32],
    fine_col: NDArray[np.int32],
    spread: int,
    stamp: NDArray[np.int32],
    distance: NDArray[np.float64],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
) -> tuple[int, int]:
    fine_cols = cells.shape[1]
    rows, cols = stood.shape
    now = stamp[rows * cols]
    best = -1
    target = -1
    shortest = np.inf
    for i in range(hidden.shape[0]):
        r = hidden[i] // fine_cols
        c = hidden[i] % fine_cols
        if hopeless[r, c] == 1:
            continue
        if occlusion:
            count = visible_cells(cells, r, c, limits, lows, highs, out)
        else:
            count = disc_cells(cells, r, c, limits, out)
        found = False
        for j in range(count):
            r2 = out[j] // fine_cols
            c2 = out[j] % fine_cols
            # The planning cells whose centre lies in this fine cell: one at most, unless planning
            # cells are smaller than fine ones.
            for pr in range(max(row_of[r2] - spread, 0), min(row_of[r2] + spread, rows - 1) + 1):
                for pc in range(
                    max(col_of[c2] - spread, 0), min(col_of[c2] + spread, cols - 1) + 1
                ):
                    if fine_row[pr] != r2 or fine_col[pc] != c2 or stood[pr, pc] == 1:
                        continue
                    cell = pr * cols + pc
                    if stamp[cell] == now:
                        found = True
                        if distance[cell] < shortest or (
                            distance[cell] == shortest and cell < best
                        ):
                            shortest = distance[cell]
                            best = cell
                            target = hidden[i]
        if not found:
            hopeless[r, c] = 1
    return best, target
