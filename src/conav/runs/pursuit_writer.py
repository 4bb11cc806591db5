"""Writing the run of a pursuit."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from conav.runs.scenery_writer import SceneryWriter
from conav.runs.schemas import BELIEF, BELIEF_TOPIC, LEG, LEG_TOPIC


class PursuitWriter(SceneryWriter):
    """Writes one pursuit: header, legs and beliefs after them, result; errors as in `RunWriter`."""

    def __init__(self, path: str) -> None:
        super().__init__(path)
        self._legs = 0

    def leg(
        self, begin_s: float, end_s: float, before: ArrayLike, after: ArrayLike, active: ArrayLike
    ) -> None:
        """Write an interval of the schedule: places (n, 2) [m] at both ends, and who sees (n,)."""
        self._legs += 1
        message = self.types[LEG](
            begin_s=begin_s,
            end_s=end_s,
            before=_flat(before),
            after=_flat(after),
            active=np.asarray(active, dtype=np.uint8),
        )
        self.write(LEG_TOPIC, LEG, round(end_s * 1e9), message)

    def belief(
        self, time_s: float, regions: Sequence[tuple[bool, Sequence[NDArray[np.float64]]]]
    ) -> None:
        """Write all hidden regions after the last leg: whether clear, and rings (n, 2) [m]."""
        rings = [_flat(ring) for _, of_region in regions for ring in of_region]
        message = self.types[BELIEF](
            legs=self._legs,
            clear=np.array([clear for clear, _ in regions], dtype=np.uint8),
            region_ends=np.cumsum([len(one) for _, one in regions]).astype(np.uint32),
            ring_ends=np.cumsum([len(ring) for ring in rings]).astype(np.uint32),
            outlines=np.concatenate([np.empty(0), *rings]),
        )
        self.write(BELIEF_TOPIC, BELIEF, round(time_s * 1e9), message)


def _flat(places: ArrayLike) -> NDArray[np.float64]:
    return np.ascontiguousarray(places, dtype=np.float64).reshape(-1)
