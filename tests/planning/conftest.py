"""Scenes several tests plan in: the fixture `scenes` has a function for each."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from conav.maps.polygon_map import PolygonMap
from conav.planning.types import PlanningProblem, PlanningRobot, Region

SQUARE = PolygonMap([(0, 0), (20, 0), (20, 20), (0, 20)])


def disc(name: str, x: float, y: float, radius: float = 0.5) -> dict[str, Region]:
    return {name: Region(name, disc=(x, y, radius))}


def antipodal(
    count: int, radius: float = 0.5, after: str = "stay", costs: tuple[str, ...] = ("length",)
) -> PlanningProblem:
    """Robots on a circle that want to the other side."""
    robots = []
    for i in range(count):
        dx, dy = 8 * math.cos(2 * math.pi * i / count), 8 * math.sin(2 * math.pi * i / count)
        goal = disc("goal", 10 - dx, 10 - dy)
        robots.append(
            PlanningRobot(f"r{i}", (10 + dx, 10 + dy), "F goal", goal, radius, after_arrival=after)
        )
    return PlanningProblem(SQUARE, tuple(robots), 60.0, costs=costs)


def bay() -> PlanningProblem:
    """Two robots swap in a corridor: one must wait in the bay."""
    floor = PolygonMap([(0, 0), (10, 0), (10, 1), (5.5, 1), (5.5, 2), (4.5, 2), (4.5, 1), (0, 1)])
    robots = (
        PlanningRobot("a", (1.0, 0.5), "F goal", disc("goal", 9.0, 0.5, 0.3), 0.3),
        PlanningRobot("b", (9.0, 0.5), "F goal", disc("goal", 1.0, 0.5, 0.3), 0.3),
    )
    return PlanningProblem(floor, robots, 60.0)


def discs(count: int, seed: int) -> np.ndarray:
    """Discs in the square, away from its border and each other."""
    random = np.random.default_rng(seed)
    found: list[tuple[float, float, float]] = []
    while len(found) < count:
        x, y = random.uniform(3, 17, 2)
        r = random.uniform(0.4, 1.0)
        if all(math.hypot(x - u, y - v) > r + s + 1.2 for u, v, s in found):
            found.append((x, y, r))
    return np.array(found)


def errand() -> PlanningProblem:
    """One robot with two places to be at and one to stay out of, among discs."""
    regions = {
        **disc("dock", 17, 3, 0.6),
        "shelf": Region("shelf", polygon=np.array([(2, 15), (4, 15), (4, 18), (2, 18)])),
        **disc("pit", 10, 10, 1.5),
    }
    robot = PlanningRobot("a", (2.0, 2.0), "F dock & F shelf & G !pit", regions, 0.4)
    return PlanningProblem(SQUARE, (robot,), 90.0, discs(8, 3))


@pytest.fixture(scope="session")
def scenes() -> SimpleNamespace:
    return SimpleNamespace(
        antipodal=antipodal, bay=bay, errand=errand, discs=discs, disc=disc, square=SQUARE
    )
