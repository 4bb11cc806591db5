"""Names of robots in the topics of ROS 2."""

import re
from collections.abc import Sequence


def topic_names(names: Sequence[str]) -> list[str]:
    """Names as ROS 2 allows them in topics, all different.

    >>> topic_names(["robot_0", "my robot", "my-robot", "7"])
    ['robot_0', 'my_robot', 'my_robot_2', 'robot_7']
    """
    found: list[str] = []
    for number, name in enumerate(names):
        plain = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9_]", "_", name)).strip("_")
        plain = plain if plain[:1].isalpha() else f"robot_{plain or number}"
        while plain in found:
            plain += f"_{number}"
        found.append(plain)
    return found
