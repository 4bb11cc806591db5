"""Working space for looks with one sensor on maps of one shape."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.geometry.sight import lateral_limits, new_gap_space, sight_buffer_size


class SightSpace(NamedTuple):
    """A sensor's range on a map, and working space for looks; shared, nothing in it lasts."""

    limits: NDArray[np.int32]
    occlusion: bool
    lows: NDArray[np.float64]
    highs: NDArray[np.float64]
    out: NDArray[np.int32]
    stamps: NDArray[np.int32]  # a number per fine cell, the last used one at the end


@lru_cache(maxsize=8)
def sight_space(
    range_m: float, resolution: float, occlusion: bool, shape: tuple[int, int]
) -> SightSpace:
    """Working space for a sensor on maps of one shape."""
    limits = lateral_limits(min(range_m / resolution, sum(shape)))
    cells = shape[0] * shape[1]
    return SightSpace(
        limits,
        occlusion,
        new_gap_space(limits),
        new_gap_space(limits),
        np.empty(sight_buffer_size(limits), dtype=np.int32),
        np.zeros(cells + 1, dtype=np.int32),
    )
