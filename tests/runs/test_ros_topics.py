"""The ROS topics, read by rosbags from the definitions inside the file, without conav's reader."""

from math import atan2, cos, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

import conav
from conav.maps.occupancy_grid import OccupancyGrid

ORIGIN = (-3.0, 2.0, 0.3)


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    path = tmp_path_factory.mktemp("bag") / "run.mcap"
    cells = conav.builtin_map("maze", width_m=8.0, height_m=6.0, seed=1).cells
    done = conav.explore(OccupancyGrid(cells, 0.1, ORIGIN, "maze"), robots=2, seed=3, out=path)
    return path, done


def read(path: Path) -> dict[str, list[tuple[int, Any]]]:
    with AnyReader([path]) as reader:
        topics: dict[str, list[tuple[int, Any]]] = {}
        for connection, time_ns, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            topics.setdefault(connection.topic, []).append((time_ns, message))
    return topics


def test_topics_and_times(bag: tuple[Path, Any]) -> None:
    topics = read(bag[0])
    assert {"/map", "/ground_truth", "/tf", "/robot_0/pose", "/robot_1/pose"} <= set(topics)
    for messages in topics.values():
        times = [time for time, _ in messages]
        assert times == sorted(times)


def test_the_last_map_is_what_the_team_knows(bag: tuple[Path, Any]) -> None:
    path, done = bag
    _, grid = read(path)["/map"][-1]
    assert grid.header.frame_id == "map"
    assert (grid.info.height, grid.info.width) == done.result.team_map.shape
    assert abs(grid.info.resolution - 0.1) < 1e-6
    assert (grid.info.origin.position.x, grid.info.origin.position.y) == ORIGIN[:2]
    assert (
        abs(2 * atan2(grid.info.origin.orientation.z, grid.info.origin.orientation.w) - 0.3) < 1e-9
    )
    assert set(np.unique(grid.data)) <= {-1, 0, 100}
    ours = np.array([0, 100, -1])[done.result.team_map].ravel()
    assert np.array_equal(grid.data, ours)


def test_poses_and_transforms_follow_the_events(bag: tuple[Path, Any]) -> None:
    path, done = bag
    topics = read(path)
    lattice = done.problem.plan.lattice
    steps = dict(topics["/conav/step"])
    x0, y0, yaw = ORIGIN
    checked = 0
    for robot in range(2):
        for time, pose in topics[f"/robot_{robot}/pose"]:
            if time not in steps:
                continue
            u, v = lattice.position(int(steps[time].cells[robot]))
            assert abs(pose.pose.position.x - (x0 + cos(yaw) * u - sin(yaw) * v)) < 1e-9
            assert abs(pose.pose.position.y - (y0 + sin(yaw) * u + cos(yaw) * v)) < 1e-9
            assert pose.header.frame_id == "map"
            checked += 1
    assert checked > 10
    for time, message in topics["/tf"]:
        assert [t.child_frame_id for t in message.transforms] == [
            "robot_0/base_link",
            "robot_1/base_link",
        ]
        stamp = message.transforms[0].header.stamp
        assert stamp.sec * 1_000_000_000 + stamp.nanosec == time
