"""Where samples of a robot's graph come from."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

DRAWS = 64  # of a sample

# Places of the numbers a sampler has.
FROM_X, FROM_Y, TO_X, TO_Y, HORIZON, GOALS, WAYS, WAITS, LOCAL = range(9)


class Sampler(NamedTuple):
    """Where samples come from; shares are of all samples, and the rest is uniform."""

    seed: np.uint64
    bounds: tuple[float, float, float, float]  # [m]
    horizon_s: float
    goal_share: float = 0.1  # in a region of the task
    straight_share: float = 0.02  # straight ways from a vertex to a region
    wait_share: float = 0.05  # a vertex, later
    local_share: float = 0.3  # around the present path, if there is one

    @property
    def numbers(self) -> NDArray[np.float64]:
        return np.array(
            [
                *self.bounds,
                self.horizon_s,
                self.goal_share,
                self.straight_share,
                self.wait_share,
                self.local_share,
            ]
        )
