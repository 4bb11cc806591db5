"""Writing what does not move, for viewers of ROS 2."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.runs.schemas import MARKERS
from conav.runs.writer import RunWriter

_LINE_STRIP, _CYLINDER = 4, 3  # kinds of visualization_msgs/Marker
_WALL_M = 0.05  # [m] how thick a line is drawn

Colour = tuple[float, float, float, float]


class SceneryWriter(RunWriter):
    """A writer of runs whose floor is drawn with lines and discs."""

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
