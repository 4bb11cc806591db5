"""One look of one robot at the true map."""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.sight import (
    cells_in_sight,
    lateral_limits,
    new_gap_space,
    sight_buffer_size,
)
from conav.maps.occupancy_grid import UNKNOWN


class Looker:
    """Working space for looks with one sensor range; nothing here outlives a look."""

    def __init__(self, range_fine: float, fine_cells: int, occlusion: bool) -> None:
        self.occlusion = occlusion
        self.limits = lateral_limits(range_fine)
        self.lows = new_gap_space(self.limits)
        self.highs = new_gap_space(self.limits)
        self.out = np.empty(sight_buffer_size(self.limits), dtype=np.int32)
        self.fresh = np.empty(min(sight_buffer_size(self.limits), fine_cells), dtype=np.int32)


@kernel
def look(
    walls: NDArray[np.uint8],
    belief: NDArray[np.uint8],
    row: int,
    col: int,
    occlusion: bool,
    limits: NDArray[np.int32],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    out: NDArray[np.int32],
    fresh: NDArray[np.int32],
    observable: NDArray[np.uint8],
    sensed_by: NDArray[np.uint8],
    robot: int,
    sensed: NDArray[np.int64],
    discovered: NDArray[np.int64],
    covered: NDArray[np.int64],
) -> int:
    """The number of fine cells written to `fresh`: those seen and still unknown to `belief`.

    Counts, of the observable cells: in `sensed[robot]` those this robot saw for the first time, in
    `discovered[robot]` those its belief did not hold, in `covered[0]` those no robot had seen.
    `sensed_by` (words, fine cells) has a bit per robot.
    """
    count = cells_in_sight(walls, row, col, occlusion, limits, lows, highs, out)
    known = belief.reshape(-1)
    wanted = observable.reshape(-1)
    word = robot // 8
    bit = np.uint8(1 << (robot % 8))
    found = 0
    for i in range(count):
        cell = out[i]
        seen = sensed_by[word, cell]
        if seen & bit:
            continue  # seen before, so known
        sensed_by[word, cell] = seen | bit
        if wanted[cell] == 1:
            first = seen == 0
            for w in range(sensed_by.shape[0]):
                if w != word and sensed_by[w, cell] != 0:
                    first = False
            if first:
                covered[0] += 1
            sensed[robot] += 1
        if known[cell] == UNKNOWN:
            fresh[found] = cell
            found += 1
            if wanted[cell] == 1:
                discovered[robot] += 1
    return found
