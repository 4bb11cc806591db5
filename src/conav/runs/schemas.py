"""The message types of a run file, as ROS 2 knows them, and their CDR encoding."""

import json
from functools import cache
from typing import Any, cast

STEP = "conav_msgs/msg/Step"
WORLD = "conav_msgs/msg/World"
TRAJECTORY = "conav_msgs/msg/Trajectory"
GRAPH = "conav_msgs/msg/Graph"
LEG = "conav_msgs/msg/Leg"
BELIEF = "conav_msgs/msg/Belief"
STRING = "std_msgs/msg/String"
GRID = "nav_msgs/msg/OccupancyGrid"
POSE = "geometry_msgs/msg/PoseStamped"
TF = "tf2_msgs/msg/TFMessage"
PATH = "nav_msgs/msg/Path"
MARKERS = "visualization_msgs/msg/MarkerArray"

DEFINITIONS = {
    STEP: """uint32 step
uint32[] cells
uint8[] headings
uint8[] looked
uint32[] scan_ends
uint32[] scans
uint32[] told
uint32[] said
int8[] wishes
int32[] goals
uint8[] finished
uint8[] quiet
uint8[] condition
uint32 messages
uint64 bytes
""",
    WORLD: """uint32 rows
uint32 cols
float64 resolution
float64[3] origin
uint8[] cells
""",
    # Rows of t0, t1, x, y, vx, vy, ax, ay and turn rate; no rows: the robot has no trajectory.
    TRAJECTORY: """uint32 robot
float64[] pieces
""",
    # The vertices of a robot's graph in the order they were put in, so many numbers each.
    GRAPH: """uint32 robot
uint32 columns
float64[] vertices
""",
    # Where each pursuer is at both ends, x and y by turns, and whether it sees in between.
    LEG: """float64 begin_s
float64 end_s
float64[] before
float64[] after
uint8[] active
""",
    # Hidden regions after so many legs: whether each is clear, where its rings end, where each
    # ring's numbers end, and the rings, x and y by turns, a region's outer ring first.
    BELIEF: """uint32 legs
uint8[] clear
uint32[] region_ends
uint32[] ring_ends
float64[] outlines
""",
}

HEADER_TOPIC = "/conav/header"
WORLD_TOPIC = "/conav/world"
STEP_TOPIC = "/conav/step"
RESULT_TOPIC = "/conav/result"
IMPROVEMENT_TOPIC = "/conav/improvement"
TRAJECTORY_TOPIC = "/conav/trajectory"
DRIVEN_TOPIC = "/conav/driven"
GRAPH_TOPIC = "/conav/graph"
LEG_TOPIC = "/conav/leg"
BELIEF_TOPIC = "/conav/belief"
EVENT_TOPICS = (
    HEADER_TOPIC,
    WORLD_TOPIC,
    STEP_TOPIC,
    IMPROVEMENT_TOPIC,
    TRAJECTORY_TOPIC,
    DRIVEN_TOPIC,
    GRAPH_TOPIC,
    LEG_TOPIC,
    BELIEF_TOPIC,
    RESULT_TOPIC,
)
"""The topics the digest covers and the verifiers read; the others are for ROS 2 tools."""

TIMING = "conav_timing"
"""The metadata record with wall times and versions, which are no part of a run's digest."""
FORMAT = 3
"""The number of this format in a run's header."""


@cache
def typestore() -> Any:
    """The rosbags type store with conav's own messages registered."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store


def decode(data: bytes, kind: str) -> Any:
    """A message of that type from its CDR encoding."""
    return typestore().deserialize_cdr(data, kind)


def decode_object(data: bytes) -> dict[str, Any]:
    """The JSON object in a `std_msgs/String`. Raises `ValueError` where it is none."""
    content = json.loads(decode(data, STRING).data)
    if not isinstance(content, dict):
        raise ValueError("not an object")
    return cast("dict[str, Any]", content)
