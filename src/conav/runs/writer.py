"""Writing a run file as it happens: what all jobs have in common.

Every finished chunk goes to the operating system at once, and a chunk is finished at least once a
second, so a killed process loses the last second and nothing else.
"""

import json
import os
from collections.abc import Sequence
from math import cos, sin
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any, Self

from conav.runs.digest import Digest
from conav.runs.encode import encode_pose, encode_transforms
from conav.runs.mcap_sink import McapSink, open_for_writing
from conav.runs.schemas import (
    EVENT_TOPICS,
    GRID,
    HEADER_TOPIC,
    MARKERS,
    PATH,
    POSE,
    RESULT_TOPIC,
    STRING,
    TF,
    TIMING,
    typestore,
)

FLUSH_S = 1.0  # [s] wall time a chunk may stay open

# ROS 2 players older than Jazzy read quality-of-service settings as numbers and newer ones as
# words, but these too read numbers in files with a metadata record of this name that does not give
# the version of its settings.
_BAG = ("rosbag2", {"ROS_DISTRO": "jazzy"})
_KEPT = (GRID, PATH, MARKERS)  # what does not move is there for whoever comes later
_LATCHED = (
    "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n"
    "  deadline:\n    sec: 0\n    nsec: 0\n"
    "  lifespan:\n    sec: 0\n    nsec: 0\n"
    "  liveliness: 1\n  liveliness_lease_duration:\n    sec: 0\n    nsec: 0\n"
    "  avoid_ros_namespace_conventions: false\n"
)


class RunWriter:
    """Writes one run to one `.mcap` file; a context manager. Each job has its own beneath it.

    Raises `InputError` when the file cannot be written, or when something that is not a run file
    lies at its path.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self._sink = McapSink(open_for_writing(self.path))
        self._sink.metadata(*_BAG)
        self._channels: dict[str, int] = {}
        self._sequence: dict[str, int] = {}
        self._store = typestore()
        self._digest = Digest()
        self._flushed = monotonic()
        self._serialize = self._store.serialize_cdr

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def types(self) -> Any:
        """The classes of messages by name."""
        return self._store.types

    @property
    def digest(self) -> str:
        """The digest of the events written so far."""
        return self._digest.hex()

    def header(self, header: dict[str, Any]) -> None:
        """Write what made the run; the first event of the file."""
        self.string(HEADER_TOPIC, 0, header)

    def result(self, time_ns: int, result: dict[str, Any]) -> None:
        """Write how the run ended; the last event of the file."""
        self.string(RESULT_TOPIC, time_ns, result)

    def timing(self, timing: dict[str, str]) -> None:
        """Write wall times and versions, which are no part of the run's digest."""
        self._sink.metadata(TIMING, timing)

    def poses(
        self, time_ns: int, names: Sequence[str], poses: Sequence[tuple[float, float, float]]
    ) -> None:
        """Write the robots' poses x [m], y [m], yaw [rad] in the map frame, as ROS poses and tf."""
        numbers = [(x, y, 0.0, 0.0, 0.0, sin(yaw / 2), cos(yaw / 2)) for x, y, yaw in poses]
        for name, pose in zip(names, numbers, strict=True):
            self.put(f"/{name}/pose", POSE, time_ns, encode_pose(time_ns, "map", pose))
        children = [f"{name}/base_link" for name in names]
        self.put("/tf", TF, time_ns, encode_transforms(time_ns, "map", children, numbers))

    def flush(self) -> None:
        """Finish the open chunk, so that everything so far survives the end of the process."""
        self._sink.flush()

    def close(self) -> None:
        """Finish the file; calling it again does nothing."""
        self._sink.close()

    def string(self, topic: str, time_ns: int, content: dict[str, Any]) -> None:
        """Write JSON as `std_msgs/String`."""
        text = json.dumps(content, sort_keys=True, allow_nan=False)
        self.write(topic, STRING, time_ns, self.types[STRING](data=text))

    def write(self, topic: str, kind: str, time_ns: int, message: Any) -> None:
        """Write a message of one of `types`."""
        self.put(topic, kind, time_ns, bytes(self._serialize(message, kind)))

    def put(self, topic: str, kind: str, time_ns: int, payload: bytes) -> None:
        """Write a message of that type, encoded already."""
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channel(topic, kind)
        if topic in EVENT_TOPICS:
            self._digest.add(topic, time_ns, payload)
        sequence = self._sequence[topic]
        self._sequence[topic] = sequence + 1
        self._sink.message(channel, time_ns, sequence, payload)
        now = monotonic()
        if now - self._flushed > FLUSH_S:
            self.flush()
            self._flushed = now

    def _channel(self, topic: str, kind: str) -> int:
        text, _ = self._store.generate_msgdef(kind, ros_version=2)
        metadata = {"topic_type_hash": self._store.hash_rihs01(kind)}
        if kind in _KEPT:
            metadata["offered_qos_profiles"] = _LATCHED
        self._channels[topic] = self._sink.channel(topic, kind, text.encode(), metadata)
        self._sequence[topic] = 0
        return self._channels[topic]

    def stamp(self, time_ns: int) -> Any:
        """A time as `builtin_interfaces/Time`."""
        return self.types["builtin_interfaces/msg/Time"](
            sec=time_ns // 1_000_000_000, nanosec=time_ns % 1_000_000_000
        )

    def pose(self, x: float, y: float, yaw: float) -> Any:
        """A place on the floor [m] and a direction [rad] as `geometry_msgs/Pose`."""
        types = self.types
        return types["geometry_msgs/msg/Pose"](
            position=types["geometry_msgs/msg/Point"](x=x, y=y, z=0.0),
            orientation=types["geometry_msgs/msg/Quaternion"](
                x=0.0, y=0.0, z=sin(yaw / 2), w=cos(yaw / 2)
            ),
        )
