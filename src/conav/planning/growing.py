"""Growing a graph by samples."""

import numpy as np
from numpy.typing import NDArray

from conav.planning.extend import extend
from conav.planning.extend_curved import extend_curved
from conav.planning.graph import RobotGraph
from conav.planning.sampler import Sampler


def grow(graph: RobotGraph, sampler: Sampler, path: NDArray[np.float64], samples: int) -> None:
    """Adds what the next samples give; `path`, rows of states, is the present one, maybe empty."""
    numbers = sampler.numbers
    state = np.empty(graph.vertices.shape[1])
    some = extend if graph.straight else extend_curved
    while True:
        samples -= some(
            *graph.surroundings.arrays,
            *graph.arrays,
            state,
            *graph.memory,
            sampler.seed,
            numbers,
            path,
            samples,
        )
        if samples == 0:
            return
        graph.enlarge()
