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
from conav.exploration.belief import STOOD, Belief
from conav.geometry.directions import DCOL, DROW
from conav.geometry.sight import cells_in_sight
from conav.geometry.sight_space import sight_space
from conav.geometry.sparse_cells import cells_with_bits
from conav.maps.occupancy_grid import UNKNOWN
from conav.maps.planning_grid import Lattice
from conav.robots.sensor import Sensor


@dataclass(frozen=True, eq=False)
class Viewpoints:
    """Places not scanned from that may see an unknown cell beside a frontier.

    It is the same for all robots that share a belief, and kept with it.
    """

    places: NDArray[np.int64]  # (n,) flat planning cells, each once
    hidden: NDArray[np.int64]  # (n,) the lowest unknown fine cell that each may see
    scans: int  # the belief had heard when it was made
    opened: tuple[int, int]  # places and ways known then
    hopeless: NDArray[np.uint8]  # (fine rows, fine cols) 1 for what no place known then may see


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
    belief: Belief, lattice: Lattice, sensor: Sensor, distance: NDArray[np.float64]
) -> tuple[int, int]:
    """The nearest planning cell that might see an unknown cell beside a frontier, and the lowest
    such unknown cell (flat fine index); -1, -1 when there is none.

    `distance` (planning cells,) are path lengths from the robot, inf where it cannot go. Ties go to
    the lower place. Where the robot is it has looked already.
    """
    views = viewpoints(belief, lattice, sensor)
    lengths = distance[views.places]
    nearest = float(lengths.min(initial=np.inf))
    if nearest == np.inf:
        return -1, -1
    best = np.flatnonzero(lengths == nearest)
    first = best[np.argmin(views.places[best])]
    return int(views.places[first]), int(views.hidden[first])


def viewpoints(belief: Belief, lattice: Lattice, sensor: Sensor) -> Viewpoints:
    """The viewpoints of a belief, those without any known move left out."""
    key = f"viewpoints {sensor.range_m!r} {sensor.occlusion}"
    before: Viewpoints | None = belief.derived.get(key)
    if before is not None and before.scans == belief.scans:
        return before
    opened = (belief.opened, belief.ways)
    # What nothing could see before is looked at again only when a new place or way opens.
    hopeless = np.zeros(belief.cells.shape, dtype=np.uint8)
    if before is not None and before.opened == opened:
        hopeless = before.hopeless
    space = sight_space(sensor.range_m, lattice.resolution, sensor.occlusion, belief.cells.shape)
    hidden = unknown_beside_frontier(belief)
    places = np.empty(belief.marks.size, dtype=np.int64)
    sees = np.empty(belief.marks.size, dtype=np.int64)
    count = _find_viewpoints(
        belief.cells,
        hidden,
        hopeless,
        belief.marks,
        belief.moves,
        lattice.row_of,
        lattice.col_of,
        lattice.fine_row,
        lattice.fine_col,
        0 if lattice.ratio >= 1 else int(0.5 / lattice.ratio) + 1,
        space.limits,
        space.occlusion,
        space.lows,
        space.highs,
        space.out,
        places,
        sees,
    )
    found = Viewpoints(places[:count].copy(), sees[:count].copy(), belief.scans, opened, hopeless)
    belief.derived[key] = found
    return found


def unknown_beside_frontier(belief: Belief) -> NDArray[np.int64]:
    """Flat indices of the unknown cells with a frontier cell as straight neighbour, ascending."""
    at = np.empty(belief.frontier.size, dtype=np.int64)
    at = at[: cells_with_bits(belief.frontier.reshape(-1), 1, at)]
    hidden = np.empty(4 * len(at), dtype=np.int64)
    hidden = hidden[: _unknown_beside(belief.cells, belief.frontier, at, hidden)]
    return np.sort(hidden)


@kernel
def _unknown_beside(
    cells: NDArray[np.uint8],
    frontier: NDArray[np.uint8],
    at: NDArray[np.int64],
    hidden: NDArray[np.int64],
) -> int:
    """The number of unknown cells with one of the frontier cells `at` beside, written to `hidden`.

    Each comes once, with the first of these that is beside it.
    """
    rows, cols = cells.shape
    count = 0
    for i in range(at.shape[0]):
        row = at[i] // cols
        col = at[i] - row * cols
        for k in range(4):
            r = row + DROW[k]
            c = col + DCOL[k]
            if r < 0 or r >= rows or c < 0 or c >= cols or cells[r, c] != UNKNOWN:
                continue
            first = True
            for j in range(4):
                r2 = r + DROW[j]
                c2 = c + DCOL[j]
                if (
                    0 <= r2 < rows
                    and 0 <= c2 < cols
                    and frontier[r2, c2] != 0
                    and r2 * cols + c2 < at[i]
                ):
                    first = False
            if first:
                hidden[count] = r * cols + c
                count += 1
    return count


@kernel
def _find_viewpoints(
    cells: NDArray[np.uint8],
    hidden: NDArray[np.int64],
    hopeless: NDArray[np.uint8],
    marks: NDArray[np.uint8],
    moves: NDArray[np.uint8],
    row_of: NDArray[np.int32],
    col_of: NDArray[np.int32],
    fine_row: NDArray[np.int32],
    fine_col: NDArray[np.int32],
    spread: int,
    limits: NDArray[np.int32],
    occlusion: bool,
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    places: NDArray[np.int64],
    sees: NDArray[np.int64],
) -> int:
    """The number of viewpoints written to `places`, and to `sees` the first cell each may see."""
    fine_cols = cells.shape[1]
    rows, cols = marks.shape
    taken = np.zeros(marks.shape, dtype=np.uint8)
    total = 0
    for i in range(hidden.shape[0]):
        r = hidden[i] // fine_cols
        c = hidden[i] % fine_cols
        if hopeless[r, c] == 1:
            continue
        count = cells_in_sight(cells, r, c, occlusion, limits, lows, highs, out)
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
                    if (
                        fine_row[pr] != r2
                        or fine_col[pc] != c2
                        or moves[pr, pc] == 0
                        or marks[pr, pc] & STOOD
                    ):
                        continue
                    found = True
                    if taken[pr, pc] == 0:
                        taken[pr, pc] = 1
                        places[total] = pr * cols + pc
                        sees[total] = hidden[i]
                        total += 1
        if not found:
            hopeless[r, c] = 1
    return total
