"""The run file as others read it: with rosbags and with mcap, knowing nothing of conav."""

import json
import subprocess
import sys
from math import atan2, cos, isclose, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosHistory, QosReliability
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

OCCUPIED_BIT = 1 << 31


class Bag:
    """Everything in a run file, decoded by the definitions inside it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.topics: dict[str, list[tuple[int, Any]]] = {}
        self.types: dict[str, str] = {}
        self.qos: dict[str, Any] = {}
        with AnyReader([path]) as reader:
            for connection in reader.connections:
                self.types[connection.topic] = connection.msgtype
                self.qos[connection.topic] = connection.ext.offered_qos_profiles
                assert connection.ext.serialization_format == "cdr"
            for connection, time_ns, data in reader.messages():
                message = reader.deserialize(data, connection.msgtype)
                self.topics.setdefault(connection.topic, []).append((time_ns, message))

    def all(self, topic: str) -> list[Any]:
        return [message for _, message in self.topics[topic]]

    def text(self, topic: str) -> dict[str, Any]:
        (message,) = self.all(topic)
        return json.loads(message.data)


@pytest.fixture(scope="module")
def bag(turned_run: Path) -> Bag:
    return Bag(turned_run)


def yaw_of(turn: Any) -> float:
    assert turn.x == turn.y == 0.0
    assert isclose(turn.z**2 + turn.w**2, 1.0)
    return 2 * atan2(turn.z, turn.w)


def test_topics_and_types(bag: Bag) -> None:
    assert bag.types == {
        "/conav/header": "std_msgs/msg/String",
        "/conav/world": "conav_msgs/msg/World",
        "/conav/step": "conav_msgs/msg/Step",
        "/conav/result": "std_msgs/msg/String",
        "/map": "nav_msgs/msg/OccupancyGrid",
        "/ground_truth": "nav_msgs/msg/OccupancyGrid",
        "/tf": "tf2_msgs/msg/TFMessage",
        **{f"/robot_{number}/pose": "geometry_msgs/msg/PoseStamped" for number in range(3)},
    }


def test_the_last_map_is_what_the_events_say(bag: Bag) -> None:
    world = bag.all("/conav/world")[0]
    expected = np.full(world.rows * world.cols, -1)
    for step in bag.all("/conav/step"):
        expected[step.scans & ~np.uint32(OCCUPIED_BIT)] = np.where(
            step.scans & OCCUPIED_BIT, 100, 0
        )
    last = bag.all("/map")[-1]
    assert np.array_equal(last.data, expected)
    assert {-1, 0, 100} == set(last.data.tolist())
    first = bag.all("/map")[0]
    assert (first.data == -1).sum() > (last.data == -1).sum()


def test_grids_say_where_they_lie(bag: Bag) -> None:
    world = bag.all("/conav/world")[0]
    for time_ns, grid in bag.topics["/map"] + bag.topics["/ground_truth"]:
        assert grid.header.frame_id == "map"
        assert grid.header.stamp.sec * 10**9 + grid.header.stamp.nanosec == time_ns
        assert (grid.info.width, grid.info.height) == (world.cols, world.rows)
        assert isclose(grid.info.resolution, 0.2, rel_tol=1e-6)  # a float of 32 bits
        place = grid.info.origin.position
        assert (place.x, place.y, place.z) == (2.5, -1.25, 0.0)
        assert isclose(yaw_of(grid.info.origin.orientation), 0.3)
    (truth,) = bag.all("/ground_truth")
    assert np.array_equal(truth.data, np.array([0, 100, -1])[world.cells])


def test_poses_are_where_the_events_put_the_robots(bag: Bag) -> None:
    header = bag.text("/conav/header")
    world = bag.all("/conav/world")[0]
    cell = header["cell_m"]
    cols = int(np.ceil(world.cols * world.resolution / cell - 0.5 - 1e-9))
    x0, y0, yaw = world.origin
    steps = dict(bag.topics["/conav/step"])
    for robot in range(3):
        for time_ns, pose in bag.topics[f"/robot_{robot}/pose"]:
            assert pose.header.frame_id == "map"
            assert pose.header.stamp.sec * 10**9 + pose.header.stamp.nanosec == time_ns
            step = steps[time_ns]
            row, col = divmod(int(step.cells[robot]), cols)
            x, y = (col + 0.5) * cell, (row + 0.5) * cell
            place = pose.pose.position
            assert isclose(place.x, x0 + cos(yaw) * x - sin(yaw) * y, abs_tol=1e-9)
            assert isclose(place.y, y0 + sin(yaw) * x + cos(yaw) * y, abs_tol=1e-9)
            assert place.z == 0.0
            turn = yaw_of(pose.pose.orientation) - (yaw + step.headings[robot] * pi / 2)
            assert isclose(cos(turn), 1.0)
    headings = {int(step.headings[0]) for step in steps.values()}
    assert len(headings) > 2


def test_transforms_say_what_poses_say(bag: Bag) -> None:
    for time_ns, message in bag.topics["/tf"]:
        assert [part.child_frame_id for part in message.transforms] == [
            f"robot_{number}/base_link" for number in range(3)
        ]
        for number, part in enumerate(message.transforms):
            pose = dict(bag.topics[f"/robot_{number}/pose"])[time_ns].pose
            assert part.header.frame_id == "map"
            assert part.header.stamp.sec * 10**9 + part.header.stamp.nanosec == time_ns
            moved, place = part.transform.translation, pose.position
            assert (moved.x, moved.y, moved.z) == (place.x, place.y, place.z)
            assert part.transform.rotation == pose.orientation


def test_time_goes_on_in_steps(bag: Bag) -> None:
    header = bag.text("/conav/header")
    result = bag.text("/conav/result")
    for topic, messages in bag.topics.items():
        times = [time_ns for time_ns, _ in messages]
        assert times == sorted(times), topic
    times = [time_ns for time_ns, _ in bag.topics["/conav/step"]]
    assert times == [round(header["step_s"] * 1e9) * number for number in range(len(times))]
    assert result["metrics"]["steps"] == len(times) - 1
    assert times[-1] == bag.topics["/tf"][-1][0] == bag.topics["/map"][-1][0]


def test_the_file_keeps_the_conventions_of_ros_2(turned_run: Path, bag: Bag) -> None:
    with turned_run.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary is not None
        metadata = {item.name: item.metadata for item in reader.iter_metadata()}
        counts: dict[str, int] = {}
        for _, channel, message in reader.iter_messages():
            assert message.sequence == counts.get(channel.topic, 0)
            assert message.log_time == message.publish_time
            counts[channel.topic] = message.sequence + 1
    assert counts == {topic: len(messages) for topic, messages in bag.topics.items()}
    # Players newer than Humble read settings as numbers only in files that say they are not newer.
    assert set(metadata["rosbag2"]) == {"ROS_DISTRO"}
    store = get_typestore(Stores.ROS2_JAZZY)
    for schema in summary.schemas.values():
        assert schema.encoding == "ros2msg"
        store.register(get_types_from_msg(schema.data.decode(), schema.name))
    for channel in summary.channels.values():
        assert channel.message_encoding == "cdr"
        schema = summary.schemas[channel.schema_id]
        assert channel.metadata["topic_type_hash"] == store.hash_rihs01(schema.name)
        assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
    for topic in ("/map", "/ground_truth"):
        (qos,) = bag.qos[topic]
        assert qos.durability == QosDurability.TRANSIENT_LOCAL
        assert qos.reliability == QosReliability.RELIABLE
        assert (qos.history, qos.depth) == (QosHistory.KEEP_LAST, 1)


def test_the_quality_of_service_is_yaml_with_numbers(turned_run: Path) -> None:
    import yaml

    with turned_run.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    (text,) = {
        channel.metadata["offered_qos_profiles"]
        for channel in summary.channels.values()
        if "offered_qos_profiles" in channel.metadata
    }
    (profile,) = yaml.safe_load(text)
    assert set(profile) == {
        "history",
        "depth",
        "reliability",
        "durability",
        "deadline",
        "lifespan",
        "liveliness",
        "liveliness_lease_duration",
        "avoid_ros_namespace_conventions",
    }
    for name in ("history", "depth", "reliability", "durability", "liveliness"):
        assert isinstance(profile[name], int)
    for name in ("deadline", "lifespan", "liveliness_lease_duration"):
        assert profile[name] == {"sec": 0, "nsec": 0}


def test_standard_messages_are_those_of_ros(turned_run: Path) -> None:
    """The definitions in the file make the types ROS 2 ships, by their hashes."""
    ours = {"conav_msgs/msg/Step", "conav_msgs/msg/World"}
    shipped = get_typestore(Stores.ROS2_JAZZY)
    with turned_run.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    seen = set()
    for channel in summary.channels.values():
        name = summary.schemas[channel.schema_id].name
        if name not in ours:
            assert channel.metadata["topic_type_hash"] == shipped.hash_rihs01(name)
            seen.add(name)
    assert len(seen) == 4


def test_reading_it_does_not_need_conav(turned_run: Path) -> None:
    script = (
        "import sys\n"
        "sys.modules['conav'] = None\n"
        "from pathlib import Path\n"
        "from rosbags.highlevel import AnyReader\n"
        "with AnyReader([Path(sys.argv[1])]) as bag:\n"
        "    for connection, _, data in bag.messages():\n"
        "        bag.deserialize(data, connection.msgtype)\n"
        "    print(bag.message_count)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(turned_run)], capture_output=True, text=True, timeout=60
    )
    assert int(done.stdout) > 10, done.stderr
