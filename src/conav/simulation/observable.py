"""What a team can observe at best: the measure that coverage is a share of."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.directions import DCOL, DROW
from conav.geometry.sight import segment_is_clear
from conav.maps.occupancy_grid import FREE
from conav.maps.planning_grid import PlanningGrid
from conav.robots.sensor import Sensor


def observable_cells(
    plan: PlanningGrid, starts: Sequence[int], sensor: Sensor
) -> NDArray[np.uint8]:
    """1 for each free fine cell the team can observe, shape (fine rows, fine cols).

    A free cell counts when the sensor sees it from the nearest place a robot can reach: nearest by
    steps through free cells with occlusion, in a straight line without. Cells that are seen only
    from farther away do not count, so a team may see a little more than all.
    """
    labels = {int(plan.labels.reshape(-1)[cell]) for cell in starts}
    reachable = np.isin(plan.labels, sorted(labels))
    places = np.zeros(plan.walls.shape, dtype=np.uint8)
    rows, cols = np.nonzero(reachable)
    places[plan.lattice.fine_row[rows], plan.lattice.fine_col[cols]] = 1
    square = (sensor.range_m / plan.grid.resolution) ** 2
    if sensor.occlusion:
        return _seen_from_nearest(plan.walls, places, square)
    if not places.any():
        return np.zeros_like(places)
    from scipy import ndimage  # slow to import, and most runs have a sensor with occlusion

    nearest = ndimage.distance_transform_edt(
        places == 0, return_distances=False, return_indices=True
    )
    rows, cols = np.indices(places.shape, dtype=np.int64)
    near = (rows - nearest[0]) ** 2 + (cols - nearest[1]) ** 2 <= square
    return (near & (plan.walls == FREE)).astype(np.uint8)


@kernel
def _seen_from_nearest(
    walls: NDArray[np.uint8], places: NDArray[np.uint8], square: float
) -> NDArray[np.uint8]:
    rows, cols = walls.shape
    size = rows * cols
    nearest = np.full(size, -1, dtype=np.int32)
    queue = np.empty(size, dtype=np.int32)
    tail = 0
    for cell in range(size):
        if places[cell // cols, cell % cols] == 1:
            nearest[cell] = cell
            queue[tail] = cell
            tail += 1
    head = 0
    while head < tail:
        cell = queue[head]
        head += 1
        r = cell // cols
        c = cell % cols
        for k in range(8):
            r2 = r + DROW[k]
            c2 = c + DCOL[k]
            if 0 <= r2 < rows and 0 <= c2 < cols and walls[r2, c2] == FREE:
                # A diagonal step between two walls is no way through.
                if k >= 4 and walls[r, c2] != FREE and walls[r2, c] != FREE:
                    continue
                other = r2 * cols + c2
                if nearest[other] < 0:
                    nearest[other] = nearest[cell]
                    queue[tail] = other
                    tail += 1
    result = np.zeros((rows, cols), dtype=np.uint8)
    for i in range(tail):
        cell = queue[i]
        r = cell // cols
        c = cell % cols
        r2 = nearest[cell] // cols
        c2 = nearest[cell] % cols
        if (r - r2) ** 2 + (c - c2) ** 2 <= square and segment_is_clear(walls, r2, c2, r, c):
            result[r, c] = 1
    return result
