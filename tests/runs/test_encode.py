"""Messages encoded by hand are the bytes rosbags makes."""

from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.runs.encode import encode_pose, encode_step, encode_transforms
from conav.runs.schemas import POSE, STEP, TF, typestore
from conav.runs.types import OCCUPIED_BIT, StepRecord


@settings(max_examples=100, deadline=None)
@given(
    n=st.integers(1, 9),
    scans=st.integers(0, 5),
    told=st.integers(0, 2),
    said=st.integers(0, 2),
    seed=st.integers(0, 2**32 - 1),
)
def test_steps(n: int, scans: int, told: int, said: int, seed: int) -> None:
    rng = np.random.default_rng(seed)

    def some(count: int, kind: Any) -> Any:
        return rng.integers(0, 100, count).astype(kind)

    record = StepRecord(
        step=int(rng.integers(2**32)),
        cells=some(n, np.uint32),
        headings=some(n, np.uint8),
        looked=some(n, np.uint8),
        scan_ends=some(n, np.uint32),
        scans=some(scans, np.uint32) | OCCUPIED_BIT,
        told=some(4 * told, np.uint32),
        said=some(3 * said, np.uint32),
        wishes=some(n, np.int8) - 1,
        goals=some(n, np.int32) - 1,
        finished=some(n, np.uint8),
        quiet=some(n, np.uint8),
        condition=some(n, np.uint8),
        messages=int(rng.integers(2**32)),
        bytes=int(rng.integers(2**63)),
    )
    store = typestore()
    assert encode_step(record) == bytes(store.serialize_cdr(store.types[STEP](*record), STEP))


def header(frame: str) -> Any:
    types = typestore().types
    stamp = types["builtin_interfaces/msg/Time"](sec=1, nanosec=5)
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def test_poses() -> None:
    store = typestore()
    types = store.types
    point = types["geometry_msgs/msg/Point"](x=1.0, y=2.0, z=3.0)
    turn = types["geometry_msgs/msg/Quaternion"](x=4.0, y=5.0, z=6.0, w=7.0)
    for frame in ("", "map", "frame", "odometry"):
        pose = types[POSE](
            header=header(frame),
            pose=types["geometry_msgs/msg/Pose"](position=point, orientation=turn),
        )
        ours = encode_pose(1_000_000_005, frame, (1, 2, 3, 4, 5, 6, 7))
        assert ours == bytes(store.serialize_cdr(pose, POSE))


def test_transforms() -> None:
    store = typestore()
    types = store.types
    children = ["a", "ab", "robot_0/base_link", "robot_12/base_link"]
    numbers = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
    transforms = [
        types["geometry_msgs/msg/TransformStamped"](
            header=header("map"),
            child_frame_id=child,
            transform=types["geometry_msgs/msg/Transform"](
                translation=types["geometry_msgs/msg/Vector3"](x=1.0, y=2.0, z=3.0),
                rotation=types["geometry_msgs/msg/Quaternion"](x=4.0, y=5.0, z=6.0, w=7.0),
            ),
        )
        for child in children
    ]
    ours = encode_transforms(1_000_000_005, "map", children, [numbers] * len(children))
    assert ours == bytes(store.serialize_cdr(types[TF](transforms=transforms), TF))
