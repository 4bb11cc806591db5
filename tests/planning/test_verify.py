"""The verifier accepts a good plan and rejects whatever else is put into its file."""

import ast
import copy
import json
from contextlib import suppress
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import conav.planning.verify
from conav.cli.verify import verify
from conav.errors import InputError
from conav.planning.trajectory import positions, straight
from conav.planning.types import DOUBLE_INTEGRATOR, DUBINS_CAR, PlanningRobot, Trajectory
from conav.planning.verify import CHECKS, verify_plan
from conav.planning.verify_claims import costs_of
from conav.runs.types import PlanRun

from .hand_plan import hand_problem, hand_result, hand_trajectories, write_plan


def with_pieces(run: PlanRun, robot: int, pieces: np.ndarray) -> PlanRun:
    return replace(
        run,
        trajectories=[
            one._replace(pieces=pieces) if one.robot == robot else one for one in run.trajectories
        ],
    )


def changed(run: PlanRun, robot: int, piece: int, column: int, value: float) -> PlanRun:
    pieces = np.array(run.pieces(robot))
    pieces[piece, column] += value
    return with_pieces(run, robot, pieces)


def with_problem(run: PlanRun, **changes: Any) -> PlanRun:
    return replace(run, header={**run.header, "problem": {**run.header["problem"], **changes}})


def with_robot(run: PlanRun, robot: int, **changes: Any) -> PlanRun:
    robots = [dict(one) for one in run.header["problem"]["robots"]]
    robots[robot].update(changes)
    return with_problem(run, robots=robots)


def with_result(run: PlanRun, **changes: Any) -> PlanRun:
    assert run.result is not None
    return replace(run, result={**run.result, **changes})


def broken(run: PlanRun) -> tuple[str, ...]:
    report = verify_plan(run)
    assert (report.verdict == "violated") == bool(report.broken())
    return report.broken()


def told(run: PlanRun, check: str) -> str:
    """What the report says of a check that is broken."""
    (found,) = (one for one in verify_plan(run).checks if one.name == check)
    assert found.broken
    return "\n".join(map(str, found.violations))


def test_the_hand_plan_is_good(hand_run: PlanRun) -> None:
    report = verify_plan(hand_run)
    assert report.verdict == "verified", report.lines()
    assert tuple(check.name for check in report.checks) == CHECKS
    assert (report.planned, report.of) == (2, 2)
    # Least distances by 100,001 samples of time.
    times = np.linspace(0, 30, 100_001)
    places = [positions(one, times) for one in hand_trajectories()]
    sampled = np.hypot(*(places[0] - places[1]).T).min() - 0.3 - 0.4 - 0.1
    assert report.robots.low <= report.robots.high
    assert report.robots.high == pytest.approx(sampled, abs=1e-4)
    assert report.robots.robots == ("ann", "bob")
    # Bob passes the pillar's corner (4, 4).
    assert report.walls.high == pytest.approx(sampled_from_corner(places[1]) - 0.4, abs=1e-4)


def sampled_from_corner(places: np.ndarray) -> float:
    corners = np.hypot(*(places - np.array([4, 4])).T).min()
    other = np.hypot(*(places - np.array([6, 4])).T).min()
    return float(min(corners, other))


def test_the_report(hand_run: PlanRun) -> None:
    report = verify_plan(hand_run)
    assert report.lines()[-1].startswith("verified: ")
    summary = report.summary()
    assert summary["verdict"] == "verified"
    assert summary["clearance"]["robots"]["robots"] == ["ann", "bob"]
    bad = verify_plan(with_robot(hand_run, 1, start=[8.0, 3.0]))
    assert "  bob: begins 1 m from its start at 0 s at (9, 3)" in bad.lines()
    assert bad.summary()["checks"]["starts"]["violations"][0]["place"] == (9.0, 3.0)


def test_a_start(hand_run: PlanRun) -> None:
    run = with_robot(hand_run, 0, start=[1.0, 3.1])
    assert broken(run) == ("starts",)
    assert told(run, "starts").startswith("ann: begins 0.1 m")


@pytest.mark.parametrize("value", [1e-5, -0.3])
def test_a_jump(hand_run: PlanRun, value: float) -> None:
    run = changed(hand_run, 0, 1, 3, value)
    assert "continuity" in broken(run)
    assert "ann: jumps" in told(run, "continuity")
    assert "at 5 s" in told(run, "continuity")


def test_a_gap_in_time(hand_run: PlanRun) -> None:
    run = changed(hand_run, 1, 2, 0, 0.1)
    assert "bob: is nowhere for 0.1 s" in told(run, "continuity")


def test_too_fast(hand_run: PlanRun) -> None:
    run = with_robot(hand_run, 1, speed_mps=0.7)
    assert broken(run) == ("speed",)
    assert told(run, "speed").startswith("bob: drives")


def test_late(hand_run: PlanRun) -> None:
    run = with_problem(hand_run, horizon_s=13.5)
    assert broken(run) == ("arrival",)


def test_a_wall(hand_run: PlanRun) -> None:
    floor = hand_run.header["problem"]["floor"]
    nearer = [[[4, 2], [4, 4.2], [6, 4.2], [6, 2]]]
    run = with_problem(hand_run, floor={**floor, "holes": nearer})
    assert broken(run) == ("walls",)
    assert told(run, "walls").startswith("bob: overlaps a wall by")


def test_an_obstacle(hand_run: PlanRun) -> None:
    run = with_problem(hand_run, discs=[[2.5, 2.0, 0.4]])
    assert broken(run) == ("walls",)
    assert told(run, "walls").startswith("ann: overlaps an obstacle by")


def test_outside(hand_run: PlanRun) -> None:
    floor = hand_run.header["problem"]["floor"]
    around_ann = [[[0.2, 2.2], [0.2, 3.8], [1.8, 3.8], [1.8, 2.2]]]
    run = with_problem(hand_run, floor={**floor, "holes": [*floor["holes"], *around_ann]})
    assert "ann: begins outside the floor" in told(run, "walls")


def test_the_margin(hand_run: PlanRun) -> None:
    clearance = verify_plan(hand_run).robots.high
    assert broken(with_problem(hand_run, margin_m=0.1 + clearance - 1e-5)) == ()
    run = with_problem(hand_run, margin_m=0.1 + clearance + 1e-5)
    assert broken(run) == ("collisions",)
    assert told(run, "collisions").startswith("ann and bob: too near by 1e-05 m")


def test_who_has_arrived_is_in_the_way_unless_it_vanishes(tmp_path: Path) -> None:
    problem = hand_problem(discs=np.empty((0, 3)))
    robots = tuple(replace(robot, task="true", regions={}) for robot in problem.robots)
    ann = straight([(1, 3), (3, 1.5)], [0, 4])
    bob = straight([(9, 3), (8, 1), (1, 1)], [0, 3, 12])
    for after, expected in (("stay", ("collisions",)), ("vanish", ())):
        both = (replace(robots[0], after_arrival=after), robots[1])
        scene = replace(problem, robots=both, costs=("length",))
        costs = np.array([[2.5], [5**0.5 + 7]])
        result = hand_result(scene, trajectories=(ann, bob), costs=costs)
        assert broken(write_plan(tmp_path / f"{after}.mcap", scene, result)) == expected


def test_a_task(hand_run: PlanRun) -> None:
    run = with_robot(hand_run, 1, task="F west & G !lawn")
    assert broken(run) == ("tasks",)
    assert "its word is {east} {} {lawn} {} {west}" not in told(run, "tasks")  # east is not named
    assert "its word is {} {lawn} {} {west}" in told(run, "tasks")
    assert "cannot be read" in told(with_robot(hand_run, 1, task="F (west"), "tasks")
    assert "no such region" in told(with_robot(hand_run, 1, task="F nowhere"), "tasks")


def test_a_region(hand_run: PlanRun) -> None:
    regions = hand_run.header["problem"]["robots"][0]["regions"]
    run = with_robot(hand_run, 0, regions={**regions, "east": {"disc": [9, 4, 0.5]}})
    assert broken(run) == ("tasks",)


@pytest.mark.parametrize("component", [0, 1])
def test_a_cost(hand_run: PlanRun, component: int) -> None:
    assert hand_run.result is not None
    costs = [list(row) for row in hand_run.result["costs"]]
    costs[1][component] -= 0.001
    run = with_result(hand_run, costs=costs)
    assert broken(run) == ("costs",)
    assert told(run, "costs").startswith(f"bob: {('length', 'duration')[component]} is said to be")


def test_a_piece_that_makes_the_way_longer(hand_run: PlanRun) -> None:
    assert "costs" in broken(changed(hand_run, 0, 1, 5, 0.01))


def test_done_without_a_trajectory(hand_run: PlanRun) -> None:
    run = with_pieces(hand_run, 0, np.empty((0, 9)))
    assert broken(run) == ("costs", "status")
    assert "ann" in told(run, "status")


def test_done_with_something_to_gain(hand_run: PlanRun) -> None:
    assert "status" in broken(with_result(hand_run, epsilon=[0.0, 0.5]))


def test_a_lower_bound_above_the_plan(hand_run: PlanRun) -> None:
    assert broken(with_result(hand_run, lower_bound=1000.0)) == ("lower bound",)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_none(hand_run: PlanRun, value: float) -> None:
    pieces = np.array(hand_run.pieces(0))
    pieces[1, 4] = value
    assert broken(with_pieces(hand_run, 0, pieces)) == ("form",)


def test_a_file_without_its_end_is_partly_checked(hand_run: PlanRun) -> None:
    report = verify_plan(replace(hand_run, result=None, intact=False))
    assert report.verdict == "partly checked"
    assert report.accepted


@pytest.mark.parametrize(
    "changes",
    [
        {"robots": []},
        {"horizon_s": float("nan")},
        {"costs": ["beauty"]},
        {"floor": {"outer": [[0, 0]], "holes": []}},
        {"discs": [[0, 0, -1]]},
    ],
)
def test_headers_of_nonsense(hand_run: PlanRun, changes: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="header that cannot be used"):
        verify_plan(with_problem(hand_run, **changes))
    with pytest.raises(InputError, match="job"):
        verify_plan(replace(hand_run, header={**hand_run.header, "job": "explore"}))


def test_inash_gets_better_only(hand_run: PlanRun) -> None:
    longer = straight([(1, 3), (3, 1), (6, 1.5), (9, 3)], [0, 5, 8, 12]).pieces
    first = hand_run.trajectories[0]
    worse = [first, first._replace(pieces=longer, improvement=2), *hand_run.trajectories[1:]]
    run = replace(
        hand_run,
        header={**hand_run.header, "solver": "inash"},
        history=[{"stage": "game"}, {"stage": "game"}],
        trajectories=worse,
    )
    assert "ann: gets worse in the game" in told(run, "history")
    eased = replace(run, history=[{"stage": "game"}, {"stage": "feasibility"}])
    assert "history" not in broken(eased)


@settings(max_examples=60, deadline=None)
@given(
    robot=st.integers(0, 1),
    piece=st.integers(0, 2),
    column=st.integers(0, 8),
    value=st.floats(1e-3, 2.0),
    sign=st.sampled_from([1, -1]),
)
def test_no_number_of_a_trajectory_can_be_another(
    hand: PlanRun, robot: int, piece: int, column: int, value: float, sign: int
) -> None:
    assert broken(changed(hand, robot, piece, column, sign * value))


@pytest.fixture(scope="module")
def hand(tmp_path_factory: pytest.TempPathFactory) -> PlanRun:
    problem = hand_problem()
    return write_plan(tmp_path_factory.mktemp("hand") / "p.mcap", problem, hand_result(problem))


# --- other motions ----------------------------------------------------------------------------


def single(
    tmp_path: Path, robot: PlanningRobot, pieces: list[list[float]], length: float
) -> PlanRun:
    problem = hand_problem(robots=(robot,), costs=("length",))
    result = hand_result(
        problem, trajectories=(Trajectory(np.array(pieces)),), costs=np.array([[length]])
    )
    return write_plan(tmp_path / "run.mcap", problem, result)


CAR = PlanningRobot(
    "car", (0.6, 1, 0.0), "true", {}, motion=DUBINS_CAR, turning_radius_m=0.8, speed_mps=1.0
)
QUARTER = 0.5 * pi * 0.8  # [m]


def car_pieces() -> list[list[float]]:
    return [
        [0, 2, 0.6, 1, 1, 0, 0, 0, 0],
        [2, 3, 2.6, 1, 0, 0, 0, 0, 0],  # stands
        [3, 3 + 2 * QUARTER, 2.6, 1, 0.5, 0, 0, 0, 0.5 / 0.8],
        [3 + 2 * QUARTER, 4 + 2 * QUARTER, 3.4, 1.8, 0, 1, 0, 0, 0],
    ]


def test_a_car(tmp_path: Path) -> None:
    run = single(tmp_path, CAR, car_pieces(), 3 + QUARTER)
    report = verify_plan(run)
    assert report.verdict == "verified", report.lines()
    assert broken(with_robot(run, 0, turning_radius_m=0.81)) == ("steering",)
    assert broken(with_robot(run, 0, start=[0.6, 1.0, 0.01])) == ("steering",)
    backwards = np.array(run.pieces(0))[:1]
    backwards[0, 4] = -0.1
    assert "backwards" in told(with_pieces(run, 0, backwards), "steering")
    turned = np.array(run.pieces(0))
    turned[2, 4:6] = 0.0, 0.5
    assert "does not face" in told(with_pieces(run, 0, turned), "steering")


def test_a_double_integrator(tmp_path: Path) -> None:
    robot = PlanningRobot(
        "mass", (1, 1, 0.0, 0.0), "true", {}, motion=DOUBLE_INTEGRATOR, acceleration_mps2=0.5
    )
    pieces = [
        [0, 2, 1, 1, 0, 0, 0.5, 0, 0],
        [2, 3, 2, 1, 1, 0, 0, 0, 0],
        [3, 5, 3, 1, 1, 0, -0.5, 0, 0],
    ]
    run = single(tmp_path, robot, [list(map(float, row)) for row in pieces], 3.0)
    report = verify_plan(run)
    assert report.verdict == "verified", report.lines()
    assert broken(with_robot(run, 0, acceleration_mps2=0.49)) == ("steering",)
    assert "starts" in broken(with_robot(run, 0, start=[1.0, 1.0, 0.1, 0.0]))
    assert broken(with_pieces(run, 0, np.array(run.pieces(0))[:2])) == ("arrival", "costs")
    assert broken(with_robot(with_result(run, costs=[[2.0]]), 0, after_arrival="vanish")) == (
        "costs",
    )
    jump = np.array(run.pieces(0))
    jump[1, 4] = 0.9
    assert "velocity jumps" in told(with_pieces(run, 0, jump), "continuity")


# --- independence, command ----------------------------------------------------------------------


def test_the_verifier_imports_nothing_of_solvers() -> None:
    """Not even modules of this room that the import contract has not heard of yet."""
    folder = Path(conav.planning.verify.__file__).parent
    allowed = ("conav.compiled", "conav.errors", "conav.runs.", "conav.planning.verify_")
    for path in sorted(folder.glob("verify*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("conav"):
                assert f"{node.module}".startswith(allowed), f"{path.name}: {node.module}"
            if isinstance(node, ast.Import):
                assert not any(name.name.startswith("conav") for name in node.names), path.name


def test_the_command(hand_run: PlanRun, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert verify(hand_run.path) == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("verified: ")
    assert verify(hand_run.path, json=True) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "verified"
    problem = hand_problem(horizon_s=13.0)
    bad = write_plan(tmp_path / "bad.mcap", problem, hand_result(problem))
    assert verify(bad.path) == 1
    assert "bob: arrives after the horizon of 13 s at 14 s" in capsys.readouterr().out


# --- nonsense -------------------------------------------------------------------------------------


def places_in(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every place in JSON."""
    inner = value.items() if isinstance(value, dict) else enumerate(value)
    found = [path] if path else []
    if isinstance(value, dict | list):
        for key, each in inner:
            deeper = (*path, key)
            found += places_in(each, deeper) if isinstance(each, dict | list) else [deeper]
    return found


JUNK = st.sampled_from(
    [None, True, -1, 0, 1e308, -1e308, "", "x", "stay", [], {}, [[]], [1, 2], {"a": 1}]
)


@settings(max_examples=300, deadline=None)
@given(which=st.integers(0, 10**6), junk=JUNK, part=st.sampled_from(["header", "result"]))
def test_nonsense_is_refused_or_reported(hand: PlanRun, which: int, junk: Any, part: str) -> None:
    """Whatever stands in the JSON of a file, there is a report or one line that refuses it."""
    content = copy.deepcopy(getattr(hand, part))
    places = places_in(content)
    *way, last = places[which % len(places)]
    inside = content
    for key in way:
        inside = inside[key]
    inside[last] = junk
    with suppress(InputError):
        verify_plan(replace(hand, **{part: content}))


def test_a_length_whose_cross_velocity_is_lost_when_squared() -> None:
    slow = 1.1125369292536007e-308
    piece = np.array([[4.0, 4.2, 3.75, 4.75, slow, 0.0, -5.0 * slow, -1.0, 0.0]])
    assert costs_of(piece, ("length",)) == pytest.approx([0.02])
