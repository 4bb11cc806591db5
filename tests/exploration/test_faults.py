"""Every strategy of the catalogue in teams that break, run empty, grow, and hear badly."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conav.exploration.catalogue import STRATEGIES, make_strategy
from conav.exploration.types import ExplorationProblem
from conav.exploration.verify import verify_exploration
from conav.maps.ascii_art import parse_ascii
from conav.runs.exploration_writer import ExplorationWriter
from conav.runs.reader import read_run
from conav.runs.types import ExplorationRun
from conav.simulation.explore import exploration_problem
from conav.simulation.run_exploration import ExplorationResult, run_exploration
from conav.status import Status

ROOMS = parse_ascii(
    """
########################
#......#.......#.......#
#......#.......#.......#
#..............#.......#
#......#...............#
#......#.......#.......#
####.#####.######.######
#..........#...........#
#......................#
#..##......#.....##....#
#..##......#.....##....#
#..........#...........#
########################
""".strip(),
    resolution=0.5,
    name="rooms",
)
OPEN = parse_ascii(
    """
##################
#................#
#................#
#.......##.......#
#.......##.......#
#................#
#................#
#................#
##################
""".strip(),
    resolution=0.5,
    name="open",
)
MEMORYLESS = {
    "potential-1",
    "potential",
    "potential-improved",
    "better-response",
    "marginal-contribution",
    "uncoordinated",
    "uncoordinated-alone",
}
"""Strategies that turn at obstacles and may need very long in rooms."""


def made_for(strategy: str, **options: Any) -> ExplorationProblem:
    """Four robots on a map on which the strategy finishes."""
    radio = getattr(make_strategy(strategy), "radio", None)
    if radio is not None:
        options["radio"] = radio
    problem, _ = exploration_problem(
        OPEN if strategy in MEMORYLESS else ROOMS,
        **{"robots": 4, "seed": 3, "range_m": 2.0, "max_time_s": 2000.0} | options,
    )
    return problem


def played(
    strategy: str, problem: ExplorationProblem, folder: Path
) -> tuple[ExplorationResult, ExplorationRun]:
    """The run, which saw everything and is accepted."""
    path = folder / "run.mcap"
    with ExplorationWriter(path) as writer:
        result = run_exploration(problem, make_strategy(strategy), name=strategy, writer=writer)
    run = read_run(path)
    report = verify_exploration(run)
    assert report.accepted, report.lines()
    assert result.status is Status.DONE
    assert result.metrics.coverage == 1.0
    return result, run


def cells(run: ExplorationRun) -> np.ndarray:
    return np.stack([step.cells for step in run.steps])


def events(result: ExplorationResult) -> list[tuple[str, str]]:
    return [(event.robot, event.event) for event in result.events]


each = pytest.mark.parametrize("strategy", STRATEGIES)


@each
def test_all_but_one_die(strategy: str, tmp_path: Path) -> None:
    faults = ("robot_0:dies:2", "robot_1:dies:4.5", "robot_3:dies:6")
    result, run = played(strategy, made_for(strategy, faults=faults), tmp_path)
    assert events(result) == [("robot_0", "died"), ("robot_1", "died"), ("robot_3", "died")]
    times = [event.time_s for event in result.events]
    assert times == [2.0, 5.0, 6.0]  # steps last 1 s
    where = cells(run)
    for robot, step in ((0, 2), (1, 5), (3, 6)):
        assert (where[step:, robot] == where[step, robot]).all()
    assert (where[7:, 2] != where[6, 2]).any()


@each
@pytest.mark.parametrize("robot", [0, 1])
def test_one_stalls_for_ever(strategy: str, robot: int, tmp_path: Path) -> None:
    problem = made_for(strategy, faults=(f"robot_{robot}:stalls:3",))
    result, run = played(strategy, problem, tmp_path)
    assert events(result) == [(f"robot_{robot}", "stalled")]
    assert (cells(run)[3:, robot] == cells(run)[3, robot]).all()


@each
def test_one_joins_late(strategy: str, tmp_path: Path) -> None:
    problem = made_for(strategy, faults=("robot_3:joins:5",))
    result, run = played(strategy, problem, tmp_path)
    assert events(result) == [("robot_3", "joined")]
    joined = int(result.events[0].time_s)
    assert joined >= 5
    assert not any(step.looked[3] for step in run.steps[:joined])
    assert run.steps[joined].looked[3]
    assert result.metrics.path_m[3] > 0.0
    # What it sees is of use: it sees cells nobody knew.
    assert any(len(step.scan(3)[0]) for step in run.steps[joined:])


@each
def test_radios_that_are_weak_slow_and_lose_messages(strategy: str, tmp_path: Path) -> None:
    problem = made_for(strategy, radio="path-loss", loss=0.2, delay_s=2.0)
    _, run = played(strategy, problem, tmp_path)
    if getattr(make_strategy(strategy), "radio", None) is None:
        assert any(len(step.told) for step in run.steps)


@each
def test_a_short_radio(strategy: str, tmp_path: Path) -> None:
    """Groups part, meet again, and tell each other what they saw."""
    problem = made_for(strategy, radio=2.0)
    _, run = played(strategy, problem, tmp_path)
    if getattr(make_strategy(strategy), "radio", None) is None:
        # Somebody is told scans of somebody else's than the one who tells: beliefs merge.
        told = np.concatenate([step.told.reshape(-1, 4) for step in run.steps])
        assert (told[:, 1] != told[:, 2]).any()


@each
def test_all_but_one_run_empty(strategy: str, tmp_path: Path) -> None:
    problem = made_for(strategy)
    robots = tuple(
        replace(robot, energy_j=None if number == 2 else 60.0 + 30.0 * number)
        for number, robot in enumerate(problem.robots)
    )
    result, _ = played(strategy, replace(problem, robots=robots), tmp_path)
    died = {event.robot: event.time_s for event in result.events}
    for number, robot in enumerate(robots):
        if robot.energy_j is None:
            assert robot.name not in died
            continue
        path_m = result.metrics.path_m[number]
        if robot.name in died:
            spent = robot.spent_j(path_m, died[robot.name])
            # A step is 1 s and at most 0.5 m: the last one may go beyond.
            assert robot.energy_j <= spent < robot.energy_j + 10.0 + 0.5 * 2**0.5 * 20.0
        else:
            assert robot.spent_j(path_m, result.metrics.time_s) < robot.energy_j
    assert died
