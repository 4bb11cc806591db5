"""Robots that must change sides through a passage for one."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from conav.errors import InputError
from conav.maps.polygon_map import PolygonMap
from conav.planning.types import PlanningProblem, PlanningRobot, Region

CLEARANCE_M = 0.2
BAY_ROBOTS = 2
SPEED_MPS = 1.0


@dataclass(frozen=True)
class NarrowPassage:
    """Two groups change sides through a passage in which nobody can pass another.

    Without a bay the passage joins two rooms, half of the robots start in each and go to the other
    room: one side has to wait. With a bay there are no rooms: two robots start at the ends of a
    closed passage, and one must step aside into the bay. With the bay in the middle (`bay_at` 0.5)
    the other must wait for it first, which robots that plan one after the other do not think of.
    Nothing in it is random.
    """

    robots: Annotated[int, Field(ge=2, le=24)] = 2
    bay: bool = False
    bay_at: Annotated[float, Field(gt=0, lt=1)] = 0.3  # from the left end, share of the length
    length_m: Annotated[float, Field(gt=0)] = 8.0  # of the passage
    width: Annotated[float, Field(gt=1, lt=2)] = 1.5  # of the passage, in diameters of a robot
    radius_m: Annotated[float, Field(gt=0)] = 0.4
    horizon_s: Annotated[float, Field(gt=0)] = 60.0

    def problem(self, rng: np.random.Generator) -> PlanningProblem:
        if self.bay and self.robots != BAY_ROBOTS:
            raise InputError(
                "narrow-passage", f"with a bay it has {BAY_ROBOTS} robots, not {self.robots}",
                "leave out robots, or set bay=no",
            )  # fmt: skip
        outline, left = self._with_bay() if self.bay else self._with_rooms()
        starts = [(x * side, y) for x, y in left for side in (1.0, -1.0)][: self.robots]
        # Numbers are given in turn, so the place opposite is that of the neighbour.
        goals = [(-x, y) for x, y in starts]
        goal_radius = self.radius_m / 2
        robots = [
            PlanningRobot(
                name=f"robot_{index}",
                start=start,
                task="F goal",
                regions={"goal": Region("goal", disc=(*goal, goal_radius))},
                radius_m=self.radius_m,
                speed_mps=SPEED_MPS,
            )
            for index, (start, goal) in enumerate(zip(starts, goals, strict=True))
        ]
        return PlanningProblem(
            floor=PolygonMap(outline, name="narrow-passage"),
            robots=tuple(robots),
            horizon_s=self.horizon_s,
            name="narrow-passage",
        )

    def _with_rooms(self) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
        """The outline, about the origin, and the places in the left room."""
        half = self.width * self.radius_m
        step = 3 * self.radius_m + CLEARANCE_M  # diameter, and the width of a goal
        each = -(-self.robots // 2)
        columns = max(2, -(-each // 2))
        room_x, room_y = (columns + 1) * step, max(3.0 * step, 6.0 * self.radius_m)
        x0, x1, y1 = self.length_m / 2, self.length_m / 2 + room_x, room_y / 2
        # Two rows along the walls leave the way to the passage free.
        places = [
            (-(x1 - step * (0.75 + column)), row * (y1 - 0.75 * step))
            for column in range(columns)
            for row in (1.0, -1.0)
        ]
        right = [(x0, -half), (x0, -y1), (x1, -y1), (x1, y1), (x0, y1), (x0, half)]
        return [*right, *((-x, -y) for x, y in right)], places

    def _with_bay(self) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
        half = self.width * self.radius_m
        side = self.radius_m + 1.5 * CLEARANCE_M  # half as wide as the bay
        top = half + 2 * self.radius_m + CLEARANCE_M
        x1 = self.length_m / 2
        x = self.length_m * self.bay_at - x1
        # Room for the bay, and a start beside it on either hand.
        if x1 - abs(x) < side + 3 * self.radius_m:
            raise InputError(
                "narrow-passage", "the passage is too short for its bay", "ask for a longer one"
            )
        outline = [
            (-x1, -half), (x1, -half), (x1, half), (x + side, half),
            (x + side, top), (x - side, top), (x - side, half), (-x1, half),
        ]  # fmt: skip
        return outline, [(-x1 + 2 * self.radius_m, 0.0)]
