"""The eccentricity bound by hand."""

import numpy as np
import pytest

from conav.exploration.bounds.bounds import lower_bounds
from conav.exploration.bounds.eccentricity import eccentricity_steps
from conav.exploration.bounds.views import Places, survey
from conav.exploration.types import ExplorationProblem
from conav.maps.ascii_art import parse_ascii
from conav.maps.planning_grid import planning_grid
from conav.robots.motion import MOTIONS
from conav.robots.robot import Robot
from conav.robots.sensor import Sensor
from conav.simulation.observable import observable_cells

CORRIDOR = "#" * 13 + "\n#" + "." * 11 + "#\n" + "#" * 13


def corridor(cols: list[int], *, speeds: tuple[float, ...], reach: float) -> ExplorationProblem:
    plan = planning_grid(parse_ascii(CORRIDOR), cell_m=1.0, radius_m=0.1, diagonal=False)
    robots = tuple(
        Robot(f"r{i}", 0.1, speed, MOTIONS["4-connected"], Sensor("any", True, reach))
        for i, speed in enumerate(speeds)
    )
    starts = tuple(13 + col for col in cols)
    return ExplorationProblem(plan, robots, starts, 0, 1e3, "none")


@pytest.mark.parametrize(
    ("cols", "speeds", "expected"),
    [
        # Cells 1 to 11, seen from two cells away; at the start 1 to 3, then one more a step.
        ([1], (1.0,), {1.0: 8, 0.9: 7, 0.5: 3, 0.27: 0, 0.28: 1, 0.0: 0}),
        ([1, 11], (1.0, 1.0), {1.0: 3, 0.9: 2, 0.5: 0, 0.6: 1}),
        # Half as fast: the second robot needs two steps for each cell.
        ([1, 11], (1.0, 0.5), {1.0: 4, 0.9: 3}),
    ],
)
def test_along_a_corridor(
    cols: list[int], speeds: tuple[float, ...], expected: dict[float, float]
) -> None:
    problem = corridor(cols, speeds=speeds, reach=2.0)
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    for share, steps in expected.items():
        bounds = lower_bounds(problem, observable, share)
        assert bounds.eccentricity_s == steps * problem.step_s


def test_what_nobody_sees_is_never_seen() -> None:
    """Coverage counts what the first robot's sensor would see, in everybody's part of the map."""
    rooms = "\n".join(["#" * 13, *["#.....#.....#"] * 5, "#" * 13])
    plan = planning_grid(parse_ascii(rooms), cell_m=1.0, radius_m=0.6, diagonal=False)
    sighted, blind = (
        Robot(f"sees {reach} m", 0.6, 1.0, MOTIONS["4-connected"], Sensor("any", True, reach))
        for reach in (3.0, 0.0)
    )
    middle = 3 * 13
    problem = ExplorationProblem(plan, (sighted, blind), (middle + 3, middle + 9), 0, 1e3)
    observable = observable_cells(plan, problem.starts, sighted.sensor)
    assert observable.sum() == 50
    # Of its 25 cells the robot on the right sees the 9 it can stand on.
    bounds = lower_bounds(problem, observable, 34 / 50)
    assert 0.0 < bounds.lower_s < np.inf
    for share in (35 / 50, 1.0):
        bounds = lower_bounds(problem, observable, share)
        assert bounds.eccentricity_s == bounds.lower_s == np.inf
    seen = survey(problem, Places.of(problem))
    assert eccentricity_steps(seen, observable, 35) == np.inf
    both = ExplorationProblem(plan, (sighted, sighted), problem.starts, 0, 1e3)
    assert lower_bounds(both, observable).lower_s < np.inf
