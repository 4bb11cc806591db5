"""Robots among random discs, after the first experiment of [Zhu2014]."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from conav.maps.polygon_map import PolygonMap
from conav.planning.scenes.catalogue import MAX_ROBOTS
from conav.planning.scenes.placing import Point, apart, distance, placed, square
from conav.planning.types import PlanningProblem, PlanningRobot, Region

CLEARANCE_M = 0.2  # [m] beyond what must be kept, so that starts and gaps are no tight fit
FAR = 0.4  # of the side: how far a goal is from its start at least


@dataclass(frozen=True)
class RandomDiscs:
    """Robots cross a square with random discs in it, each to a goal of its own.

    [Zhu2014] has eight robots of one radius among random obstacles; sizes, speeds and numbers are
    not given there, and are ours. Between two obstacles, and between one and the wall, a robot can
    pass, so each robot alone reaches its goal; starts are free and apart, and so are goals, with
    every robot anywhere in its own.
    """

    robots: Annotated[int, Field(ge=1, le=MAX_ROBOTS)] = 8
    obstacles: Annotated[int, Field(ge=0, le=1000)] = 10
    side_m: Annotated[float, Field(gt=0)] = 20.0
    smallest_m: Annotated[float, Field(gt=0)] = 0.4  # radius of an obstacle
    largest_m: Annotated[float, Field(gt=0)] = 1.0
    radius_m: Annotated[float, Field(gt=0)] = 0.5
    speed_mps: Annotated[float, Field(gt=0)] = 1.0
    goal_radius_m: Annotated[float, Field(gt=0)] = 0.5
    horizon_s: Annotated[float, Field(gt=0)] = 60.0
    after_arrival: Literal["stay", "vanish"] = "vanish"

    def __post_init__(self) -> None:
        if self.smallest_m > self.largest_m:
            raise ValueError("smallest_m is greater than largest_m")

    def problem(self, rng: np.random.Generator) -> PlanningProblem:
        discs = self._discs(rng)
        starts: list[Point] = []
        goals: list[Point] = []
        for index in range(self.robots):
            starts.append(self._place(rng, index, discs, starts, 0.0, None))
            goals.append(self._place(rng, index, discs, goals, self.goal_radius_m, starts[-1]))
        robots = [
            PlanningRobot(
                name=f"robot_{index}",
                start=start,
                task="F goal",
                regions={"goal": Region("goal", disc=(*goal, self.goal_radius_m))},
                radius_m=self.radius_m,
                speed_mps=self.speed_mps,
                after_arrival=self.after_arrival,
            )
            for index, (start, goal) in enumerate(zip(starts, goals, strict=True))
        ]
        return PlanningProblem(
            floor=PolygonMap(square(self.side_m), name="random-discs"),
            robots=tuple(robots),
            horizon_s=self.horizon_s,
            discs=np.array(discs, dtype=np.float64).reshape(-1, 3),
            name="random-discs",
        )

    def _discs(self, rng: np.random.Generator) -> list[tuple[float, float, float]]:
        passage = 2 * self.radius_m + CLEARANCE_M
        discs: list[tuple[float, float, float]] = []
        for index in range(self.obstacles):
            radius = self.smallest_m + float(rng.random()) * (self.largest_m - self.smallest_m)
            away = radius + passage

            def allowed(point: Point, away: float = away) -> bool:
                return all(distance(point, (x, y)) >= away + r for x, y, r in discs)

            point = placed(
                rng, (away, away), (self.side_m - away, self.side_m - away), allowed,
                f"random-discs: obstacle {index}", "ask for fewer or smaller ones",
            )  # fmt: skip
            discs.append((*point, radius))
        return discs

    def _place(
        self,
        rng: np.random.Generator,
        index: int,
        discs: list[tuple[float, float, float]],
        others: list[Point],
        around: float,
        start: Point | None,
    ) -> Point:
        """A place from which the robot, up to `around` from it, is clear of walls and others."""
        away = self.radius_m + around + CLEARANCE_M

        def allowed(point: Point) -> bool:
            far = start is None or distance(point, start) >= FAR * self.side_m
            free = all(distance(point, (x, y)) >= away + r for x, y, r in discs)
            return far and free and apart(point, others, 2 * away)

        return placed(
            rng, (away, away), (self.side_m - away, self.side_m - away), allowed,
            f"random-discs: robot_{index}", "ask for fewer or smaller robots, or a larger side",
        )  # fmt: skip
