"""Robots on a circle that all go straight across."""

from dataclasses import dataclass
from math import pi
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from conav.geometry.turned import cosine_and_sine
from conav.maps.polygon_map import PolygonMap
from conav.planning.scenes.catalogue import MAX_ROBOTS
from conav.planning.types import PlanningProblem, PlanningRobot, Region

CLEARANCE_M = 0.2  # [m] between neighbours on the circle, each anywhere in its goal


@dataclass(frozen=True)
class AntipodalCircle:
    """Robots on a circle, each to the place opposite, so that all ways meet in the middle.

    Nothing in it is random. With an odd number of robots goals lie between starts.
    """

    robots: Annotated[int, Field(ge=2, le=MAX_ROBOTS)] = 8
    circle_m: Annotated[float, Field(gt=0)] = 8.0  # radius; grows where robots need more
    radius_m: Annotated[float, Field(gt=0)] = 0.5
    speed_mps: Annotated[float, Field(gt=0)] = 1.0
    goal_radius_m: Annotated[float, Field(gt=0)] = 0.3
    horizon_s: Annotated[float, Field(gt=0)] = 60.0
    after_arrival: Literal["stay", "vanish"] = "stay"

    def problem(self, rng: np.random.Generator) -> PlanningProblem:
        chord = 2 * (self.radius_m + self.goal_radius_m) + CLEARANCE_M
        _, half = cosine_and_sine(pi / self.robots)
        circle = max(self.circle_m, chord / (2 * half))
        edge = circle + 2 * (self.radius_m + self.goal_radius_m) + CLEARANCE_M
        robots: list[PlanningRobot] = []
        for index in range(self.robots):
            cosine, sine = cosine_and_sine(2 * pi * index / self.robots)
            x, y = circle * cosine, circle * sine
            goal = Region("goal", disc=(-x, -y, self.goal_radius_m))
            robots.append(
                PlanningRobot(
                    name=f"robot_{index}",
                    start=(x, y),
                    task="F goal",
                    regions={"goal": goal},
                    radius_m=self.radius_m,
                    speed_mps=self.speed_mps,
                    after_arrival=self.after_arrival,
                )
            )
        return PlanningProblem(
            floor=PolygonMap(
                [(-edge, -edge), (edge, -edge), (edge, edge), (-edge, edge)],
                name="antipodal-circle",
            ),
            robots=tuple(robots),
            # Those on a circle that had to grow have farther to go.
            horizon_s=self.horizon_s * (circle / self.circle_m),
            name="antipodal-circle",
        )
