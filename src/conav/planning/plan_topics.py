"""A scene and the motion in it on topics for viewers of ROS 2."""

from collections.abc import Sequence
from math import atan2, cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from conav.planning.trajectory import headings, polyline, positions
from conav.planning.types import DUBINS_CAR, PlanningProblem, Region, Trajectory
from conav.runs.plan_writer import PlanWriter
from conav.runs.scenery_writer import Colour
from conav.runs.topic_names import topic_names

POSE_EVERY_S = 0.2  # [s] of the plan, between two poses on the ROS topics
_CIRCLE = 48  # corners of a disc that is drawn as a line

_WALL: Colour = (0.2, 0.2, 0.2, 1.0)
_OBSTACLE: Colour = (0.4, 0.4, 0.4, 1.0)
_REGION: Colour = (0.1, 0.6, 0.3, 0.8)
_ROBOT: Colour = (0.1, 0.4, 0.8, 0.9)


def write_scenery(writer: PlanWriter, problem: PlanningProblem) -> None:
    """Write walls, obstacles, regions, and a disc for each robot that moves with it."""
    names = topic_names([robot.name for robot in problem.robots])
    lines = [("walls", ring, _WALL) for ring in problem.floor.rings]
    for robot in problem.robots:
        lines += [
            (f"{robot.name}/{key}", _outline(region), _REGION)
            for key, region in robot.regions.items()
        ]
    round_ones = [("obstacles", "map", disc, _OBSTACLE) for disc in _discs(problem.discs)]
    round_ones += [
        ("robots", f"{name}/base_link", (0.0, 0.0, robot.radius_m), _ROBOT)
        for name, robot in zip(names, problem.robots, strict=True)
    ]
    writer.scenery("/scene", lines, round_ones)


def write_motion(
    writer: PlanWriter, problem: PlanningProblem, trajectories: Sequence[Trajectory | None]
) -> None:
    """Write paths at once, then poses in the order of their times, until the last arrival."""
    end_s = max((one.arrival_s for one in trajectories if one is not None), default=0.0)
    names = topic_names([robot.name for robot in problem.robots])
    moving = [
        (name, robot, one, robot.start[2] if robot.motion == DUBINS_CAR else 0.0)
        for name, robot, one in zip(names, problem.robots, trajectories, strict=True)
        if one is not None
    ]
    for name, _, one, first in moving:
        points = polyline(one)
        facing = headings(one, points[:, 2], first).tolist()
        poses = [(t, x, y, yaw) for (x, y, t), yaw in zip(points.tolist(), facing, strict=True)]
        writer.way(f"/{name}/path", poses)
    times = np.append(np.arange(0.0, end_s, POSE_EVERY_S), end_s)
    places = [positions(one, times).tolist() for _, _, one, _ in moving]
    yaws = [headings(one, times, first).tolist() for _, _, one, first in moving]
    for k, t in enumerate(times.tolist()):
        here = [
            i
            for i, (_, robot, one, _) in enumerate(moving)
            if robot.after_arrival == "stay" or t <= one.arrival_s
        ]
        writer.poses(
            round(t * 1e9),
            [moving[i][0] for i in here],
            [(*places[i][k], _wrapped(yaws[i][k])) for i in here],
        )


def _wrapped(angle: float) -> float:
    return atan2(sin(angle), cos(angle))


def _outline(region: Region) -> NDArray[np.float64]:
    if region.polygon is not None:
        return region.polygon
    assert region.disc is not None
    x, y, radius = region.disc
    angles = 2.0 * pi * np.arange(_CIRCLE) / _CIRCLE
    return np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])


def _discs(discs: NDArray[np.float64]) -> list[tuple[float, float, float]]:
    return [(x, y, radius) for x, y, radius in discs.tolist()]
