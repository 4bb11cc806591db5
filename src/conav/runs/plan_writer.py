"""Writing the run of a planner, and of robots that drive its plan."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.runs.scenery_writer import SceneryWriter
from conav.runs.schemas import (
    DRIVEN_TOPIC,
    GRAPH,
    GRAPH_TOPIC,
    IMPROVEMENT_TOPIC,
    PATH,
    TRAJECTORY,
    TRAJECTORY_TOPIC,
)


class PlanWriter(SceneryWriter):
    """Writes one planner's run: header, what it found as it comes, graphs, result.

    Errors as in `RunWriter`. All events have time 0; the topics for ROS 2 have the plan's times.
    """

    def improvement(self, entry: dict[str, Any]) -> None:
        """Write an entry of the history; its trajectories follow."""
        self.string(IMPROVEMENT_TOPIC, 0, entry)

    def trajectory(self, robot: int, pieces: NDArray[np.float64] | None) -> None:
        """Write the trajectory that a robot has from now on, (n, 9), or that it has none."""
        flat = np.empty(0) if pieces is None else np.ascontiguousarray(pieces).reshape(-1)
        self.write(TRAJECTORY_TOPIC, TRAJECTORY, 0, self.types[TRAJECTORY](robot, flat))

    def driven(self, robot: int, pieces: NDArray[np.float64]) -> None:
        """Write what a robot drove when it followed its trajectory, (n, 9)."""
        flat = np.ascontiguousarray(pieces).reshape(-1)
        self.write(DRIVEN_TOPIC, TRAJECTORY, 0, self.types[TRAJECTORY](robot, flat))

    def graph(self, robot: int, vertices: NDArray[np.float64]) -> None:
        """Write a robot's vertices, (n, columns), in the order they were put in."""
        flat = np.ascontiguousarray(vertices).reshape(-1)
        columns = vertices.shape[1]
        self.write(GRAPH_TOPIC, GRAPH, 0, self.types[GRAPH](robot, columns, flat))

    def way(self, topic: str, poses: Sequence[tuple[float, float, float, float]]) -> None:
        """Write a path, each pose time [s], x [m], y [m], yaw [rad], as `nav_msgs/Path`."""
        stamped = [
            self.types["geometry_msgs/msg/PoseStamped"](
                header=self._header(round(t * 1e9)), pose=self.pose(x, y, yaw)
            )
            for t, x, y, yaw in poses
        ]
        self.write(topic, PATH, 0, self.types[PATH](header=self._header(0), poses=stamped))

    def _header(self, time_ns: int) -> Any:
        return self.types["std_msgs/msg/Header"](stamp=self.stamp(time_ns), frame_id="map")
