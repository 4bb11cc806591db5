"""Faults as text and as data."""

from math import inf
from typing import Any

import pytest

from conav.errors import InputError
from conav.robots.fault import Fault, check_faults, parse_fault
from conav.robots.robot import Robot

NAMES = ("robot_0", "robot_1", "robot_2")


def test_texts() -> None:
    assert parse_fault("robot_1:dies:100", NAMES) == Fault(1, "dies", 100.0)
    assert parse_fault("robot_2:stalls:50:200", NAMES) == Fault(2, "stalls", 50.0, 200.0)
    assert parse_fault("robot_0:stalls:50", NAMES) == Fault(0, "stalls", 50.0)
    assert parse_fault("robot_2:joins:0.5", NAMES) == Fault(2, "joins", 0.5)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("robot_1", "is not ROBOT:KIND:SECONDS"),
        ("robot_1:dies", "is not ROBOT:KIND:SECONDS"),
        ("robot_1:sleeps:3", "is not ROBOT:KIND:SECONDS"),
        ("robot_1:stalls:3:4:5", "is not ROBOT:KIND:SECONDS"),
        ("robot_3:dies:3", "who is not in the team"),
        ("robot_1:dies:soon", "no numbers"),
        ("robot_1:dies:-3", "cannot be"),
        ("robot_1:dies:nan", "cannot be"),
        ("robot_1:dies:3:4", "cannot be"),
        ("robot_1:stalls:4:4", "cannot be"),
    ],
)
def test_texts_that_cannot_be(text: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        parse_fault(text, NAMES)


def test_faults_of_a_team() -> None:
    check_faults((Fault(0, "dies", 1.0), Fault(1, "dies", 1.0), Fault(0, "joins", 0.5)), 2)
    with pytest.raises(ValueError, match="there are 2 robots"):
        check_faults((Fault(2, "dies", 1.0),), 2)
    with pytest.raises(ValueError, match="dies twice"):
        check_faults((Fault(1, "dies", 1.0), Fault(1, "dies", 2.0)), 2)


def test_energy_by_hand() -> None:
    robot = Robot("robot_0", energy_j=100.0, drive_j_per_m=3.0, on_w=2.0)
    assert robot.spent_j(driven_m=5.0, on_s=7.0) == 29.0


@pytest.mark.parametrize(
    "wrong", [{"energy_j": 0.0}, {"energy_j": inf}, {"on_w": -1.0}, {"drive_j_per_m": inf}]
)
def test_batteries_that_cannot_be(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="robot_0"):
        Robot("robot_0", **wrong)
