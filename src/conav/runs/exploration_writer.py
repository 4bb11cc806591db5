"""Writing the run of an exploration."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.runs.encode import encode_step
from conav.runs.schemas import GRID, STEP, STEP_TOPIC, WORLD, WORLD_TOPIC
from conav.runs.types import StepRecord
from conav.runs.writer import RunWriter


class ExplorationWriter(RunWriter):
    """Writes one exploration: header, world, steps, result; errors as in `RunWriter`."""

    def world(
        self, cells: NDArray[np.uint8], resolution: float, origin: tuple[float, float, float]
    ) -> None:
        """Write the true map."""
        message = self.types[WORLD](
            rows=cells.shape[0],
            cols=cells.shape[1],
            resolution=resolution,
            origin=np.array(origin, dtype=np.float64),
            cells=cells.reshape(-1),
        )
        self.write(WORLD_TOPIC, WORLD, 0, message)

    def step(self, time_ns: int, record: StepRecord) -> None:
        """Write one step."""
        self.put(STEP_TOPIC, STEP, time_ns, encode_step(record))

    def map(
        self,
        topic: str,
        time_ns: int,
        cells: NDArray[np.uint8],
        resolution: float,
        origin: tuple[float, float, float],
    ) -> None:
        """Write a grid (0 free, 1 occupied, 2 unknown) as `nav_msgs/OccupancyGrid`."""
        types: Any = self.types
        data = np.array([0, 100, -1], dtype=np.int8)[cells.reshape(-1)]
        stamp = self.stamp(time_ns)
        message = types[GRID](
            header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="map"),
            info=types["nav_msgs/msg/MapMetaData"](
                map_load_time=stamp,
                resolution=resolution,
                width=cells.shape[1],
                height=cells.shape[0],
                origin=self.pose(*origin),
            ),
            data=data,
        )
        self.write(topic, GRID, time_ns, message)
