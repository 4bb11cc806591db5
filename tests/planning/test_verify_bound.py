"""Least lengths by hand, and against those of solvers."""

from dataclasses import replace
from math import inf, sqrt

import numpy as np
import pytest

from conav.planning.verify import verify_plan
from conav.planning.verify_bound import distance, least_length
from conav.planning.verify_scene import Area, Body
from conav.runs.types import PlanRun

A = Area((5.0, 0.0, 1.0), None)
B = Area((0.0, 7.0, 1.0), None)
INNER = Area((5.0, 0.0, 0.25), None)
BOX = Area(None, np.array([(-4, -1), (-2, -1), (-2, 1), (-4, 1.0)]))
AREAS = {"a": A, "b": B, "inner": INNER, "box": BOX}
A_TO_B = sqrt(25 + 49) - 2


def robot(task: str, start: tuple[float, ...] = (0.0, 0.0)) -> Body:
    return Body("r", "single-integrator", start, task, AREAS, 0.2, 1.0, 1.0, 1.0, True)


@pytest.mark.parametrize(
    ("task", "expected"),
    [
        ("F a", 4.0),
        ("true", 0.0),
        ("F box", 2.0),
        ("F a & F b", 4.0 + A_TO_B),  # 6 + the same the other way round
        ("sequence(b, a)", 6.0 + A_TO_B),
        ("F a | F b", 4.0),
        ("F (a & inner)", 4.0),  # to a, and from there no distance is known
        ("F inner", 4.75),  # from within a, which it lies in
        ("!a U b & F a", 6.0 + A_TO_B),
        ("F (a & b)", inf),
        ("false", inf),
        ("G !a & F b", 6.0),
        ("F a & F G !a & F box", 2.0 + 6.0),
    ],
)
def test_by_hand(task: str, expected: float) -> None:
    assert least_length(robot(task)) == pytest.approx(expected)


def test_from_within() -> None:
    assert least_length(robot("F a", (5.0, 0.5))) == 0.0
    # It may leave a and come back for nothing, so only from a's border on is sure.
    assert least_length(robot("F b & F a", (5.0, 0.0))) == pytest.approx(A_TO_B)


def test_distances() -> None:
    other = Area(None, np.array([(0, 3), (1, 3), (1, 4), (0, 4.0)]))
    assert distance(A, B) == pytest.approx(A_TO_B)
    assert distance(A, BOX) == distance(BOX, A) == 6.0
    assert distance(BOX, other) == pytest.approx(sqrt(8))
    assert distance(A, INNER) == 0.0


def test_a_bound_that_cannot_be_derived_is_said_not_to_be_checked(hand_run: PlanRun) -> None:
    assert hand_run.result is not None
    # Ann 7.5 m to the edge of east; bob 0.4 m less its region: lawn and then west.
    low = replace(hand_run, result={**hand_run.result, "lower_bound": 7.0})
    assert verify_plan(low).verdict == "verified"
    high = replace(hand_run, result={**hand_run.result, "lower_bound": 16.9})
    report = verify_plan(high)
    assert report.verdict == "partly checked"
    assert any("lower bound 16.9" in line for line in report.lines())
