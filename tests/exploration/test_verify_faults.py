"""The verifier accepts what broken teams and slow radios do, and rejects what they cannot do."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import conav
from conav.errors import InputError
from conav.exploration.verify import verify_exploration
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.runs.reader import read_run
from conav.runs.types import ExplorationRun, StepRecord

ROOMS = """
#######################
#......##......#......#
#.......#......#......#
#..............#......#
#.......#.............#
#.......#......#......#
####.#######.######.###
#..........#..........#
#.....................#
#..##......#.....##...#
#..........#.....##...#
#######################
""".strip()
STALLED, DEAD, ABSENT = 1, 2, 3


def explored(path: Path, map: Any, **problem: Any) -> ExplorationRun:
    conav.explore(map, out=path, **problem)
    return read_run(path)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> ExplorationRun:
    """Robot 0 dies, robot 1 stalls for a while, robot 2 joins late, robot 3 runs empty."""
    return explored(
        tmp_path_factory.mktemp("broken") / "run.mcap",
        parse_ascii(ROOMS, resolution=0.5),
        robots=5,
        seed=3,
        range_m=1.6,
        radio=3.0,
        energy_j=350.0,
        faults=["robot_0:dies:9", "robot_1:stalls:5:12", "robot_2:joins:7"],
    )


@pytest.fixture(scope="module")
def slow(tmp_path_factory: pytest.TempPathFactory) -> ExplorationRun:
    """Over radios that lose, delay, and are stopped by walls."""
    return explored(
        tmp_path_factory.mktemp("slow") / "run.mcap",
        parse_ascii(ROOMS, resolution=0.5),
        robots=4,
        seed=3,
        range_m=1.6,
        radio="path-loss",
        loss=0.2,
        delay_s=2.0,
    )


def broken(run: ExplorationRun) -> tuple[str, ...]:
    return verify_exploration(run).broken()


def with_field(
    run: ExplorationRun, number: int, name: str, place: int | None, value: Any
) -> ExplorationRun:
    step = run.steps[number]
    part = getattr(step, name)
    if isinstance(part, np.ndarray) and place is not None:
        part = part.copy()
        part[place] = value
    else:
        part = value
    return with_steps(run, {number: step._replace(**{name: part})})


def with_steps(run: ExplorationRun, changes: dict[int, StepRecord]) -> ExplorationRun:
    return replace(run, steps=[changes.get(k, step) for k, step in enumerate(run.steps)])


def with_robots(run: ExplorationRun, change: dict[str, Any]) -> ExplorationRun:
    robots = [{**robot, **change} for robot in run.header["robots"]]
    return replace(run, header={**run.header, "robots": robots})


def with_radios(run: ExplorationRun, change: dict[str, Any]) -> ExplorationRun:
    robots = [{**robot, "radio": {**robot["radio"], **change}} for robot in run.header["robots"]]
    return replace(run, header={**run.header, "robots": robots})


def where(run: ExplorationRun, robot: int, condition: int) -> list[int]:
    return [step.step for step in run.steps if step.condition[robot] == condition]


# --- robots ---------------------------------------------------------------------------------------


def test_the_runs_to_tamper_with_are_good(run: ExplorationRun, slow: ExplorationRun) -> None:
    for one in (run, slow):
        report = verify_exploration(one)
        assert report.accepted, report.lines()
    assert where(run, 0, DEAD)[0] == 9
    assert where(run, 1, STALLED) == list(range(5, 12))
    assert where(run, 2, ABSENT) == list(range(7))
    assert where(run, 3, DEAD)
    assert any(len(step.told) for step in slow.steps)


@pytest.mark.parametrize(("robot", "condition"), [(0, DEAD), (1, STALLED), (2, ABSENT)])
def test_who_cannot_drive_drives(run: ExplorationRun, robot: int, condition: int) -> None:
    last = where(run, robot, condition)[-1]
    number = last if condition != DEAD else last - 1
    cell = int(run.steps[number].cells[robot])
    for other in (cell + 1, cell - 1, cell + 23, cell - 23):
        assert "faults" in broken(with_field(run, number, "cells", robot, other))


def test_who_is_dead_turns(run: ExplorationRun) -> None:
    number = where(run, 0, DEAD)[3]
    heading = int(run.steps[number].headings[0])
    assert "faults" in broken(with_field(run, number, "headings", 0, (heading + 1) % 4))


@pytest.mark.parametrize(("robot", "condition"), [(0, DEAD), (2, ABSENT)])
@pytest.mark.parametrize(
    ("name", "value"),
    [("looked", 1), ("wishes", 0), ("goals", 30), ("finished", 1), ("quiet", 1)],
)
def test_who_is_not_on_senses_or_decides(
    run: ExplorationRun, robot: int, condition: int, name: str, value: int
) -> None:
    number = where(run, robot, condition)[2]
    assert "faults" in broken(with_field(run, number, name, robot, value))


def test_who_is_dead_speaks(run: ExplorationRun) -> None:
    number = where(run, 0, DEAD)[2]
    said = np.array([0, 1, 30], np.uint32)
    assert "faults" in broken(with_field(run, number, "said", None, said))


def test_who_is_dead_tells(run: ExplorationRun) -> None:
    dead = where(run, 0, DEAD)[0]
    step = next(s for s in run.steps[:dead] if 0 in s.told[1::4])
    row = step.told.reshape(-1, 4)[step.told[1::4] == 0][0]
    later = run.steps[dead + 1]
    told = np.concatenate([later.told, row]).astype(np.uint32)
    assert "radio" in broken(with_field(run, dead + 1, "told", None, told))


@pytest.mark.parametrize("robot", range(5))
def test_another_condition_than_there_is(run: ExplorationRun, robot: int) -> None:
    for number in (3, 10, 20):
        now = int(run.steps[number].condition[robot])
        for other in {0, STALLED, DEAD, ABSENT} - {now}:
            assert "faults" in broken(with_field(run, number, "condition", robot, other))


def test_more_energy_than_there_is(run: ExplorationRun) -> None:
    for change in ({"energy_j": 300.0}, {"on_w": 12.0}, {"drive_j_per_m": 25.0}):
        assert "faults" in broken(with_robots(run, change))
    assert "faults" in broken(with_robots(run, {"energy_j": None}))


def test_faults_that_were_not_asked_for(run: ExplorationRun) -> None:
    faults = run.header["faults"]
    for number, fault in enumerate(faults):
        rest = [*faults[:number], *faults[number + 1 :]]
        assert "faults" in broken(replace(run, header={**run.header, "faults": rest}))
        later = {**fault, "at_s": fault["at_s"] + 1.0}
        some = [*faults[:number], later, *faults[number + 1 :]]
        assert "faults" in broken(replace(run, header={**run.header, "faults": some}))


@pytest.mark.parametrize(
    "faults",
    [
        None,
        [{"robot": 9, "kind": "dies", "at_s": 1.0, "until_s": None}],
        [{"robot": 0, "kind": "sleeps", "at_s": 1.0, "until_s": None}],
        [{"robot": 0, "kind": "dies", "at_s": -1.0, "until_s": None}],
        [{"robot": 0, "kind": "dies"}],
    ],
)
def test_headers_that_cannot_be_used(run: ExplorationRun, faults: Any) -> None:
    with pytest.raises(InputError, match="has a header that cannot be used"):
        verify_exploration(replace(run, header={**run.header, "faults": faults}))


def test_what_only_the_dead_knew_does_not_count(tmp_path: Path) -> None:
    """Robots that never hear each other: coverage falls when one dies."""
    grid = parse_ascii("." * 30, resolution=0.5)
    run = explored(
        tmp_path / "run.mcap",
        grid,
        robots=2,
        starts=[(2.25, 0.25), (14.25, 0.25)],
        range_m=1.0,
        radio="off",
        faults=["robot_1:dies:1"],
    )
    assert broken(run) == ()
    result = run.result
    assert result is not None
    early = replace(run, steps=run.steps[:3], result={**result, "status": "out_of_budget"})
    assert "metrics" in broken(early)
    # Without the death the same steps have seen more: the coverage of the result is too low.
    immortal = replace(run, header={**run.header, "faults": []})
    assert {"faults", "ending"} <= set(broken(immortal))


# --- radios ---------------------------------------------------------------------------------------


def told_rows(run: ExplorationRun) -> list[tuple[int, np.ndarray]]:
    return [(step.step, row) for step in run.steps for row in step.told.reshape(-1, 4)]


def test_told_without_a_link(slow: ExplorationRun) -> None:
    """With a weaker signal, or thicker walls, some of what was told could not be."""
    model = slow.header["robots"][0]["radio"]["path_loss"]
    for change in ({"reference_db": 49.9, "reference_distance": 5.0}, {"wall_exponent": 8.0}):
        tampered = with_radios(slow, {"path_loss": {**model, **change}})
        assert {"radio", "messages"} & set(broken(tampered)), change
    assert "radio" in broken(with_radios(slow, {"range_m": 0.6}))


def test_told_too_early(slow: ExplorationRun) -> None:
    number, row = next((n, row) for n, row in told_rows(slow) if n > 3)
    before = slow.steps[number - 1]
    step = slow.steps[number]
    rest = np.array([r for r in step.told.reshape(-1, 4) if (r != row).any()], np.uint32)
    # Its sender's own scan, made two steps ago, a step sooner.
    changes = {
        number - 1: before._replace(told=np.concatenate([before.told, row]).astype(np.uint32)),
        number: step._replace(told=rest.reshape(-1)),
    }
    assert "radio" in broken(with_steps(slow, changes))
    assert "radio" in broken(with_radios(slow, {"delay_s": 3.0}))


def test_told_before_anything_could_arrive(slow: ExplorationRun) -> None:
    assert "radio" in broken(with_field(slow, 1, "told", None, np.array([0, 1, 1, 1], np.uint32)))


@pytest.mark.parametrize("place", range(4))
def test_told_what_was_not_held_or_by_nobody(slow: ExplorationRun, place: int) -> None:
    number, _ = told_rows(slow)[5]
    value = int(slow.steps[number].told[place])
    bad = 99 if place != 3 else value + 50
    assert "radio" in broken(with_field(slow, number, "told", place, bad))


def test_told_what_was_known(slow: ExplorationRun) -> None:
    number, row = told_rows(slow)[5]
    step = slow.steps[number]
    assert "radio" in broken(
        with_field(slow, number, "told", None, np.concatenate([step.told, row]).astype(np.uint32))
    )


def test_what_arrived_was_paid_for(slow: ExplorationRun) -> None:
    step = next(s for s in slow.steps if s.messages)
    assert "messages" in broken(with_field(slow, step.step, "messages", None, 1))
    assert "messages" in broken(with_field(slow, step.step, "messages", None, 1000))
    assert "messages" in broken(with_field(slow, step.step, "bytes", None, 100))


def test_a_slow_radio_is_no_perfect_one(slow: ExplorationRun, run: ExplorationRun) -> None:
    for one in (slow, run):
        assert "form" in broken(replace(one, header={**one.header, "all_to_all": True}))


@pytest.mark.parametrize(
    "change",
    [
        {"loss": 1.0},
        {"loss": "much"},
        {"delay_s": -1.0},
        {"path_loss": {"unit_m": 0.0}},
        {"path_loss": 3},
    ],
)
def test_radios_that_cannot_be(slow: ExplorationRun, change: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="has a header that cannot be used"):
        verify_exploration(with_radios(slow, change))


# --- whatever the simulator does ------------------------------------------------------------------


def some_faults(robots: int) -> st.SearchStrategy[list[str]]:
    times = st.integers(0, 60)
    one = st.one_of(
        st.builds("robot_{}:stalls:{}".format, st.integers(0, robots - 1), times),
        st.builds(
            lambda robot, at, more: f"robot_{robot}:stalls:{at}:{at + more}",
            st.integers(0, robots - 1),
            times,
            st.integers(1, 30),
        ),
    )
    by_robot = st.builds(
        lambda kinds, at: [
            f"robot_{robot}:{kind}:{time}"
            for robot, (kind, time) in enumerate(zip(kinds, at, strict=True))
            if kind
        ],
        st.lists(st.sampled_from(["", "", "dies", "joins"]), min_size=robots, max_size=robots),
        st.lists(times, min_size=robots, max_size=robots),
    )
    return st.builds(lambda a, b: [*a, *b], st.lists(one, max_size=2), by_robot)


@settings(max_examples=60, deadline=None)
@given(
    cells=st.tuples(st.integers(4, 12), st.integers(4, 12), st.integers(0, 10**6)),
    share=st.sampled_from([0.0, 0.1, 0.25]),
    faults=some_faults(4),
    problem=st.fixed_dictionaries(
        {
            "seed": st.integers(0, 1000),
            "range_m": st.sampled_from([1.0, 1.5]),
            "radius_m": st.sampled_from([0.0, 0.1]),
            "motion": st.sampled_from(["8-connected", "forward-turn"]),
            "radio": st.sampled_from(["perfect", 0.0, 0.8, "path-loss"]),
            "loss": st.sampled_from([0.0, 0.0, 0.3]),
            "delay_s": st.sampled_from([0.0, 0.0, 0.5, 2.0]),
            "energy_j": st.sampled_from([None, None, 150.0, 400.0]),
            "traffic": st.sampled_from(["pibt", "none"]),
            "strategy": st.sampled_from(["nearest", "hungarian", "repeated-auction", "two-stage"]),
        }
    ),
)
def test_whatever_the_simulator_does_is_accepted(
    cells: Any, share: float, faults: list[str], problem: dict[str, Any], tmp_path_factory: Any
) -> None:
    rows, cols, seed = cells
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid((rng.random((rows, cols)) < share).astype(np.uint8), 0.2)
    path = tmp_path_factory.mktemp("any") / "run.mcap"
    try:
        run = explored(path, grid, robots=4, max_time_s=60.0, faults=faults, **problem)
    except InputError:
        return  # no room for such a team on such a map
    report = verify_exploration(run)
    assert report.accepted, report.lines()
