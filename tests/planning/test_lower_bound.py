"""Least lengths by hand."""

import math

import numpy as np
import pytest

from conav.planning.letters import task_of
from conav.planning.lower_bound import shortest_length, sum_bound
from conav.planning.types import PlanningProblem, PlanningRobot, Region


@pytest.mark.parametrize(
    ("task", "length"),
    [
        ("F a", 4.0),
        ("F b", math.sqrt(125) - 1),
        ("F a & F b", 4.0 + 8.0),  # to a, then from a to b
        ("(!b U a) & F b", 12.0),
        ("F a | F b", 4.0),
        ("F s", 2.0),
        ("true", 0.0),
        ("F a & F s", 2.0 + 0.0 + 4.0),
    ],
)
def test_least_length(scenes, task: str, length: float) -> None:
    regions = {
        **scenes.disc("a", 5, 0, 1.0),
        **scenes.disc("b", 5, 10, 1.0),
        "s": Region("s", polygon=np.array([(-4.0, -1), (-2, -1), (-2, 1), (-4, 1)])),
    }
    robot = PlanningRobot("r", (0.0, 0.0), task, regions)
    if task == "F a & F s":
        length = 2.0 + 6.0  # s first: 2 to it, and 6 from it to a
    assert math.isclose(shortest_length(robot, task_of(robot), 0), length)


def test_sum_in_seconds(scenes) -> None:
    problem = scenes.antipodal(2, costs=("duration",))
    assert sum_bound(problem, [10.0, 5.0]) == 15.0
    assert sum_bound(PlanningProblem(scenes.square, problem.robots, 60.0), [1.0, 2.0]) == 3.0
