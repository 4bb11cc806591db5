"""Writing the run of a planner."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.runs.schemas import (
    GRAPH,
    GRAPH_TOPIC,
    IMPROVEMENT_TOPIC,
    MARKERS,
    PATH,
    TRAJECTORY,
    TRAJECTORY_TOPIC,
)
from conav.runs.writer import RunWriter

_LINE_STRIP, _CYLINDER = 4, 3  # kinds of visualization_msgs/Marker
_WALL_M = 0.05  # [m] how thick a line is drawn

Colour = tuple[float, float, float, float]


class PlanWriter(RunWriter):
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

    def scenery(
        self,
        topic: str,
        lines: Sequence[tuple[str, NDArray[np.float64], Colour]],
        discs: Sequence[tuple[str, str, tuple[float, float, float], Colour]],
    ) -> None:
        """Write closed lines and discs as `visualization_msgs/MarkerArray`.

        A line is a namespace, its points (n, 2) [m] and a colour; a disc a namespace, the frame it
        moves with, x, y, radius [m] in it and a colour. Colours are red, green, blue, opacity.
        """
        point = self.types["geometry_msgs/msg/Point"]
        markers = [
            self._marker(
                number, name, "map", _LINE_STRIP, self.pose(0.0, 0.0, 0.0), (_WALL_M, 0.0, 0.0),
                colour, [point(float(x), float(y), 0.0) for x, y in [*points, points[0]]],
            )
            for number, (name, points, colour) in enumerate(lines)
        ]  # fmt: skip
        markers += [
            self._marker(
                len(lines) + number, name, frame, _CYLINDER, self.pose(x, y, 0.0),
                (2.0 * radius, 2.0 * radius, _WALL_M), colour, [],
            )
            for number, (name, frame, (x, y, radius), colour) in enumerate(discs)
        ]  # fmt: skip
        self.write(topic, MARKERS, 0, self.types[MARKERS](markers=markers))

    def _header(self, time_ns: int) -> Any:
        return self.types["std_msgs/msg/Header"](stamp=self.stamp(time_ns), frame_id="map")

    def _marker(
        self,
        number: int,
        namespace: str,
        frame: str,
        kind: int,
        pose: Any,
        scale: tuple[float, float, float],
        colour: Colour,
        points: list[Any],
    ) -> Any:
        types = self.types
        empty = np.empty(0, dtype=np.uint8)
        stamp = self.stamp(0)
        return types["visualization_msgs/msg/Marker"](
            header=types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame),
            ns=namespace,
            id=number,
            type=kind,
            action=0,
            pose=pose,
            scale=types["geometry_msgs/msg/Vector3"](*scale),
            color=types["std_msgs/msg/ColorRGBA"](*colour),
            lifetime=types["builtin_interfaces/msg/Duration"](sec=0, nanosec=0),
            frame_locked=frame != "map",
            points=points,
            colors=[],
            texture_resource="",
            texture=types["sensor_msgs/msg/CompressedImage"](
                header=types["std_msgs/msg/Header"](stamp=stamp, frame_id=""), format="", data=empty
            ),
            uv_coordinates=[],
            text="",
            mesh_resource="",
            mesh_file=types["visualization_msgs/msg/MeshFile"](filename="", data=empty),
            mesh_use_embedded_materials=False,
        )
