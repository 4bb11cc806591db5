"""Traffic at a crossing of two streets, after the second experiment of [Zhu2014]."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.planning.scenes.placing import Point
from conav.planning.types import PlanningProblem, PlanningRobot, Region

CLEARANCE_M = 0.2
FIRST_M = 3.0  # [m] from the crossing to the first robot that waits
ROWS = 3

STRAIGHT, LEFT, RIGHT = 2, 3, 1
"""Quarter turns, counter-clockwise, from the arm a robot comes from to the one it leaves by."""

# Arms south, east, north, west; per arm the ways of the robots in it, the first one in front. All
# twelve leave three by each arm, and the first four already cross, turn left and turn right.
WAYS = (
    (STRAIGHT, LEFT, RIGHT),
    (LEFT, STRAIGHT, RIGHT),
    (STRAIGHT, RIGHT, LEFT),
    (RIGHT, STRAIGHT, LEFT),
)


@dataclass(frozen=True)
class Intersection:
    """Two streets cross between blocks of houses; robots go straight on, left or right.

    [Zhu2014] has six robots; sizes and ways are not given there, and are ours. Every arm has a lane
    in and a lane out, by right-hand traffic, which starts and goals keep to and nobody has to.
    Robots queue in the lanes in; those that leave by the same arm have goals one behind another.
    Nothing in it is random.
    """

    robots: Annotated[int, Field(ge=1, le=4 * ROWS)] = 6
    lane_m: Annotated[float, Field(gt=0)] = 3.0  # width of a lane
    arm_m: Annotated[float, Field(gt=0)] = 9.0  # length of an arm
    radius_m: Annotated[float, Field(gt=0)] = 0.5
    speed_mps: Annotated[float, Field(gt=0)] = 1.0
    goal_radius_m: Annotated[float, Field(gt=0)] = 0.5
    horizon_s: Annotated[float, Field(gt=0)] = 60.0
    after_arrival: Literal["stay", "vanish"] = "vanish"

    def problem(self, rng: np.random.Generator) -> PlanningProblem:
        room = self.radius_m + self.goal_radius_m + CLEARANCE_M / 2
        end = self.lane_m + self.arm_m
        rows = -(-self.robots // 4)
        if 2 * room > self.lane_m or FIRST_M + room * (2 * rows - 1) > self.arm_m:
            raise InputError(
                "intersection", "robots and goals do not fit into the lanes",
                "ask for smaller robots, or greater lane_m or arm_m",
            )  # fmt: skip
        leaving = [0, 0, 0, 0]
        robots: list[PlanningRobot] = []
        for index in range(self.robots):
            row, arm = divmod(index, 4)
            out = (arm + WAYS[arm][row]) % 4
            start = _turned((self.lane_m / 2, -(self.lane_m + FIRST_M + 2 * room * row)), arm)
            goal = _turned((-self.lane_m / 2, -(end - room - 2 * room * leaving[out])), out)
            leaving[out] += 1
            robots.append(
                PlanningRobot(
                    name=f"robot_{index}",
                    start=start,
                    task="F goal",
                    regions={"goal": Region("goal", disc=(*goal, self.goal_radius_m))},
                    radius_m=self.radius_m,
                    speed_mps=self.speed_mps,
                    after_arrival=self.after_arrival,
                )
            )
        half = self.lane_m
        arm_corners = [(-half, -half), (-half, -end), (half, -end)]
        return PlanningProblem(
            floor=PolygonMap(
                [_turned(corner, arm) for arm in range(4) for corner in arm_corners],
                name="intersection",
            ),
            robots=tuple(robots),
            horizon_s=self.horizon_s,
            name="intersection",
        )


def _turned(point: Point, quarters: int) -> Point:
    """A place of the southern arm in another one, exactly."""
    x, y = point
    for _ in range(quarters):
        x, y = 0.0 - y, x
    return x, y
