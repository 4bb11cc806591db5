"""The verifier accepts what the simulator does and rejects whatever else is put into a run."""

import copy
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import conav
from conav.errors import InputError
from conav.exploration.nearest import Nearest
from conav.exploration.verify import CHECKS, verify_exploration
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.runs.exploration_writer import ExplorationWriter
from conav.runs.reader import read_run
from conav.runs.types import OCCUPIED_BIT, ExplorationRun, StepRecord

ROOMS = (
    "#######################",
    "#......##......#......#",
    "#.......#......#......#",
    "#..............#......#",
    "#.......#.............#",
    "#.......#......#......#",
    "####.#######.######.###",
    "#..........#..........#",
    "#..........#..........#",
    "#.....................#",
    "#..##......#..........#",
    "#..##......#.....##...#",
    "#..........#.....##...#",
    "#..........#..........#",
    "#######################",
)


def explored(path: Path, map: Any, **problem: Any) -> ExplorationRun:
    conav.explore(map, out=path, **{"strategy": "nearest", **problem})
    return read_run(path)


def rooms(resolution: float = 0.2) -> OccupancyGrid:
    """Four rooms with doors, 4.6 x 3 m at the usual resolution, one corner not surveyed."""
    grid = parse_ascii("\n".join(ROOMS))
    cells = grid.cells.copy()
    cells[-3:, -4:] = 2
    return OccupancyGrid(cells, resolution, name="rooms")


# --- good runs --------------------------------------------------------------------------------


@pytest.mark.parametrize("motion", ["4-connected", "8-connected", "forward-turn"])
@pytest.mark.parametrize("sensor", ["range", "disc"])
@pytest.mark.parametrize("radio", ["perfect", 1.2, 0.0])
def test_good_runs_are_accepted(motion: str, sensor: str, radio: Any, tmp_path: Path) -> None:
    run = explored(
        tmp_path / "run.mcap",
        rooms(),
        robots=4,
        seed=3,
        motion=motion,
        sensor=sensor,
        radio=radio,
        range_m=1.3,
        radius_m=0.06,
        cell_m=0.2,
    )
    report = verify_exploration(run)
    assert report.accepted, report.lines()
    assert report.intact
    assert report.finished
    assert tuple(check.name for check in report.checks) == CHECKS
    assert all(check.looked > 0 for check in report.checks)


@pytest.mark.parametrize(
    "problem",
    [
        {"map": "maze", "robots": 3, "seed": 1, "cell_m": 0.17, "radius_m": 0.2},
        {"map": "maze", "robots": 2, "seed": 2, "cell_m": 0.1, "radius_m": 0.31},
        {"map": "office", "robots": 3, "seed": 3, "cell_m": 0.25, "radio": 5.0},
        {"map": "cave", "robots": 5, "seed": 4, "motion": "forward-turn", "radio": 3.0},
        {"map": "three-obstacles", "robots": 3, "seed": 5, "sensor": "disc", "range_m": 2.0},
        {"map": "field", "robots": 2, "seed": 6, "range_m": 12.0, "max_time_s": 60.0},
        {"map": "maze", "robots": 1, "seed": 7, "max_time_s": 0.0},
    ],
    ids=lambda problem: f"{problem['map']}-{problem['seed']}",
)
def test_good_runs_on_built_in_maps_are_accepted(problem: dict[str, Any], tmp_path: Path) -> None:
    report = verify_exploration(explored(tmp_path / "run.mcap", **problem))
    assert report.accepted, report.lines()


problems = st.fixed_dictionaries(
    {
        "cells": st.tuples(st.integers(4, 14), st.integers(4, 14), st.integers(0, 10**6)),
        "share": st.sampled_from([0.0, 0.1, 0.25]),
        "robots": st.integers(1, 4),
        "seed": st.integers(0, 1000),
        "range_m": st.sampled_from([1.0, 1.5, 2.5, 50.0]),
        "radius_m": st.sampled_from([0.0, 0.05, 0.1, 0.13, 0.2]),
        "cell_m": st.sampled_from([None, 0.2, 0.34, 0.4, 0.27]),
        "speed_mps": st.sampled_from([0.5, 1.0, 0.3]),
        "motion": st.sampled_from(["4-connected", "8-connected", "forward-turn"]),
        "sensor": st.sampled_from(["range", "disc"]),
        "radio": st.sampled_from(["perfect", 0.0, 0.5, 1.1]),
    }
)


@settings(max_examples=80, deadline=None)
@given(problem=problems)
def test_whatever_the_simulator_does_is_accepted(problem: dict[str, Any], tmp_path_factory) -> None:
    rows, cols, seed = problem.pop("cells")
    rng = np.random.default_rng(seed)
    cells = (rng.random((rows, cols)) < problem.pop("share")).astype(np.uint8)
    cells[rng.random((rows, cols)) < 0.04] = 2
    path = tmp_path_factory.mktemp("any") / "run.mcap"
    try:
        run = explored(path, OccupancyGrid(cells, 0.2), max_time_s=120.0, **problem)
    except InputError:
        return  # no room for such a team on such a map
    report = verify_exploration(run)
    assert report.accepted, report.lines()


def test_a_run_cut_short_is_accepted_as_far_as_it_goes(perfect: ExplorationRun) -> None:
    cut = replace(perfect, steps=perfect.steps[:7], result=None, intact=False)
    report = verify_exploration(cut)
    assert report.accepted
    assert not report.finished
    assert not report.intact
    assert any("cut short" in line for line in report.lines())
    nothing = verify_exploration(replace(cut, steps=[]))
    assert nothing.accepted


def test_an_interrupted_run_is_accepted(perfect: ExplorationRun, tmp_path: Path) -> None:
    def stop(state: Any) -> None:
        if state.step == 9:
            raise KeyboardInterrupt

    path = tmp_path / "run.mcap"
    done = conav.explore(rooms(), out=path, progress=stop, **PERFECT)
    assert done.result.interrupted
    report = verify_exploration(read_run(path))
    assert report.accepted, report.lines()
    assert report.finished


def test_the_report_for_people_and_for_programs(perfect: ExplorationRun) -> None:
    good = verify_exploration(perfect)
    assert good.lines()[-1].startswith(f"accepted: {perfect.path} (digest {perfect.digest[:16]}")
    bad = verify_exploration(with_result(perfect, "overlap", 0.5))
    assert bad.lines()[-1].startswith("REJECTED")
    assert any(line == "metrics: BROKEN 1 times (13 looked at)" for line in bad.lines())
    summary = bad.summary()
    assert summary["accepted"] is False
    assert summary["digest"] == perfect.digest
    assert "overlap" in summary["checks"]["metrics"]["faults"][0]
    assert summary["checks"]["walls"] == {
        "looked": good.summary()["checks"]["walls"]["looked"],
        "broken": 0,
        "faults": [],
    }


def test_only_a_few_faults_are_told_in_full(perfect: ExplorationRun) -> None:
    steps = [step._replace(messages=0) for step in perfect.steps]
    report = verify_exploration(replace(perfect, steps=steps))
    (check,) = (check for check in report.checks if check.name == "messages")
    assert check.broken == len(steps)
    assert len(check.faults) == 3


# --- tampering --------------------------------------------------------------------------------

PERFECT: dict[str, Any] = {
    "robots": 3,
    "seed": 2,
    "range_m": 1.3,
    "radius_m": 0.06,
    "cell_m": 0.2,
}


@pytest.fixture(scope="module")
def perfect(tmp_path_factory: pytest.TempPathFactory) -> ExplorationRun:
    return explored(tmp_path_factory.mktemp("good") / "perfect.mcap", rooms(), **PERFECT)


@pytest.fixture(scope="module")
def limited(tmp_path_factory: pytest.TempPathFactory) -> ExplorationRun:
    path = tmp_path_factory.mktemp("good") / "limited.mcap"
    # Two robots in one corner, two in the other.
    starts = [(0.5, 0.5), (0.9, 0.5), (3.9, 2.1), (3.3, 2.1)]
    return explored(path, rooms(), radio=1.0, starts=starts, **{**PERFECT, "robots": 4})


@pytest.fixture(scope="module")
def turning(tmp_path_factory: pytest.TempPathFactory) -> ExplorationRun:
    path = tmp_path_factory.mktemp("good") / "turning.mcap"
    return explored(path, rooms(), motion="forward-turn", **PERFECT)


def with_steps(run: ExplorationRun, changes: dict[int, StepRecord]) -> ExplorationRun:
    return replace(run, steps=[changes.get(number, step) for number, step in enumerate(run.steps)])


def with_field(
    run: ExplorationRun, number: int, name: str, place: int | None, value: Any
) -> ExplorationRun:
    step = run.steps[number]
    if place is not None:
        array = getattr(step, name).copy()
        array[place] = value
        value = array
    return with_steps(run, {number: step._replace(**{name: value})})


def with_result(run: ExplorationRun, key: str, value: Any) -> ExplorationRun:
    result = copy.deepcopy(run.result)
    assert result is not None
    target = result["metrics"] if key in result["metrics"] else result
    assert key in target
    target[key] = value
    return replace(run, result=result)


def with_robots(run: ExplorationRun, *keys: str, value: Any) -> ExplorationRun:
    header = copy.deepcopy(run.header)
    for robot in header["robots"]:
        part = robot
        for key in keys[:-1]:
            part = part[key]
        part[keys[-1]] = value
    return replace(run, header=header)


def broken(run: ExplorationRun) -> tuple[str, ...]:
    return verify_exploration(run).broken()


def cols_of(run: ExplorationRun) -> int:
    return round(run.cells.shape[1] * run.resolution / run.header["cell_m"])


def driving(run: ExplorationRun, *, straight: bool = False) -> Iterator[tuple[int, int, int, int]]:
    """Step, robot, and the cells it drives from and to, of every move."""
    cols = cols_of(run)
    for number in range(len(run.steps) - 1):
        for robot in range(len(run.steps[0].cells)):
            a, b = (int(run.steps[number + k].cells[robot]) for k in (0, 1))
            if a != b and not (straight and abs(a - b) not in (1, cols)):
                yield number, robot, a, b


def scanning(run: ExplorationRun, least: int = 1) -> Iterator[tuple[int, int]]:
    """Step and robot of every scan with at least so many cells."""
    for number, step in enumerate(run.steps):
        for robot in range(len(step.cells)):
            if len(step.scan(robot)[0]) >= least:
                yield number, robot


def with_scan(
    run: ExplorationRun, number: int, robot: int, change: Callable[[np.ndarray], np.ndarray]
) -> ExplorationRun:
    """One robot's scan in one step replaced; the others stay."""
    step = run.steps[number]
    ends = [0, *map(int, step.scan_ends)]
    parts = [step.scans[a:b] for a, b in pairwise(ends)]
    parts[robot] = change(parts[robot]).astype(np.uint32)
    scans = np.concatenate(parts)
    bounds = np.cumsum([len(part) for part in parts]).astype(np.uint32)
    return with_steps(run, {number: step._replace(scans=scans, scan_ends=bounds)})


def test_the_runs_to_tamper_with_are_good(
    perfect: ExplorationRun, limited: ExplorationRun, turning: ExplorationRun
) -> None:
    for run in (perfect, limited, turning):
        assert broken(run) == ()
        assert len(run.steps) > 10
    assert any(len(step.told) for step in limited.steps)


def test_teleport(perfect: ExplorationRun) -> None:
    number, robot, a, b = next(driving(perfect))
    far = b + 5 if b % cols_of(perfect) < 12 else b - 5
    found = broken(with_field(perfect, number + 1, "cells", robot, far))
    assert {"walls", "speed"} <= set(found)
    assert a != far


def test_through_a_wall(tmp_path: Path) -> None:
    # The robot steps through a wall one cell thick in two steps.
    grid = parse_ascii("#######\n#..#..#\n#.....#\n#######")
    run = explored(tmp_path / "run.mcap", grid, robots=1, starts=[(2.5, 2.5)], radius_m=0.2)
    cols = cols_of(run)
    at = int(run.steps[0].cells[0])
    step = run.steps[0]
    inside = step._replace(step=1, cells=np.array([at + 1], np.uint32))
    beyond = step._replace(step=2, cells=np.array([at + 2], np.uint32))
    found = broken(replace(run, steps=[step, inside, beyond], result=None))
    assert "walls" in found
    # And past the corner of the wall: legal alone is neither of the two moves it is made of.
    around = step._replace(step=1, cells=np.array([at - cols + 1], np.uint32))
    assert "walls" in broken(replace(run, steps=[step, around], result=None))


def test_robots_larger_than_said(perfect: ExplorationRun) -> None:
    """A wider team would have touched walls and each other."""
    wide = with_robots(perfect, "radius_m", value=0.19)
    wide.header["radius_m"] = 0.19
    assert "walls" in broken(wide)
    lying = with_robots(perfect, "radius_m", value=0.05)
    assert broken(lying) == ("form",)


def test_a_radius_that_only_grazes(tmp_path: Path) -> None:
    # A corridor one cell wide: half a cell of radius fits exactly, a hair more does not.
    grid = parse_ascii("#######\n#.....#\n#######")
    run = explored(
        tmp_path / "run.mcap", grid, robots=1, radius_m=0.5, cell_m=1.0, range_m=2.0, seed=1
    )
    assert broken(run) == ()
    wider = with_robots(run, "radius_m", value=0.5001)
    wider.header["radius_m"] = 0.5001
    assert "walls" in broken(wider)


def open_field(tmp_path: Path, starts: list[tuple[float, float]], **problem: Any) -> ExplorationRun:
    grid = parse_ascii("\n".join(["." * 12] * 8))
    return explored(
        tmp_path / "run.mcap", grid, robots=len(starts), starts=starts, range_m=3.0, **problem
    )


def moved(run: ExplorationRun, *places: tuple[int, ...]) -> ExplorationRun:
    """A run of these cells: the first step of another with robots put elsewhere after it."""
    step = run.steps[0]
    steps = [
        step._replace(step=number, cells=np.array(cells, np.uint32))
        for number, cells in enumerate((tuple(map(int, step.cells)), *places))
    ]
    return replace(run, steps=steps, result=None)


def test_swapping_cells(tmp_path: Path) -> None:
    run = open_field(tmp_path, [(4.5, 4.5), (5.5, 4.5)])
    a, b = map(int, run.steps[0].cells)
    assert "collisions" in broken(moved(run, (b, a)))
    assert "collisions" not in broken(moved(run, (a - 1, b - 1)))


def test_crossing_diagonally(tmp_path: Path) -> None:
    run = open_field(tmp_path, [(4.5, 4.5), (5.5, 4.5)])
    a, b = map(int, run.steps[0].cells)
    assert "collisions" in broken(moved(run, (b + 12, a + 12)))


def test_sharing_a_cell(tmp_path: Path) -> None:
    run = open_field(tmp_path, [(4.5, 4.5), (6.5, 4.5)])
    a, b = map(int, run.steps[0].cells)
    assert "collisions" in broken(moved(run, (a + 1, b - 1)))


def test_touching_at_the_last_step(tmp_path: Path) -> None:
    run = open_field(tmp_path, [(4.5, 4.5), (5.5, 4.5)])
    fat = with_robots(run, "radius_m", value=0.6)
    fat.header["radius_m"] = 0.6
    assert "collisions" in broken(replace(fat, steps=run.steps[:1], result=None))


def test_too_fast(tmp_path: Path) -> None:
    """Diagonals in a row, a straight cell a step with half the speed, and nothing saved in rest."""
    run = open_field(tmp_path, [(1.5, 1.5)], speed_mps=1.0)
    at = int(run.steps[0].cells[0])
    assert "speed" in broken(moved(run, (at + 13,)))
    assert "speed" not in broken(moved(run, (at + 1,), (at + 2,)))
    idle = moved(run, (at,), (at,), (at,), (at + 13,))
    resting = [step._replace(wishes=np.array([-1], np.int8)) for step in idle.steps]
    assert "speed" in broken(replace(idle, steps=resting))
    waiting = [step._replace(wishes=np.array([4], np.int8)) for step in idle.steps]
    early = replace(idle, steps=[waiting[0], waiting[1], waiting[4]._replace(step=2)])
    assert "speed" not in broken(early)


def test_slow_robots_take_their_time(tmp_path: Path) -> None:
    run = open_field(tmp_path, [(1.5, 1.5), (8.5, 6.5)], speed_mps=1.0)
    header = copy.deepcopy(run.header)
    header["robots"][0]["speed_mps"] = 0.5
    a, b = map(int, run.steps[0].cells)
    slow = replace(moved(run, (a + 1, b), (a + 2, b)), header=header)
    assert "speed" in broken(slow)


def test_a_wrong_value_in_a_scan(perfect: ExplorationRun) -> None:
    number, robot = next(scanning(perfect))

    def lie(cells: np.ndarray) -> np.ndarray:
        return np.concatenate([[cells[0] ^ OCCUPIED_BIT], cells[1:]])

    assert "sight and knowledge" in broken(with_scan(perfect, number, robot, lie))


def test_a_cell_claimed_that_is_not_seen(perfect: ExplorationRun) -> None:
    number, robot = list(scanning(perfect))[3]
    row, col = divmod(int(perfect.steps[number].cells[robot]), cols_of(perfect))
    far = np.argwhere(perfect.cells == 0)
    far = far[np.hypot(far[:, 0] - row, far[:, 1] - col) > 7][-1]
    claim = np.uint32(far[0] * perfect.cells.shape[1] + far[1])
    found = broken(with_scan(perfect, number, robot, lambda cells: np.append(cells, claim)))
    assert "sight and knowledge" in found


def test_a_wall_claimed_behind_another(tmp_path: Path) -> None:
    grid = parse_ascii("##########\n#....##..#\n##########")
    run = explored(tmp_path / "run.mcap", grid, robots=1, starts=[(2.5, 1.5)], cell_m=1.0)
    behind = np.uint32(1 * 10 + 6) | OCCUPIED_BIT
    tampered = with_scan(run, 0, 0, lambda cells: np.append(cells, behind))
    assert "sight and knowledge" in broken(tampered)


@pytest.mark.parametrize("wall", [False, True])
def test_a_cell_in_view_left_out(perfect: ExplorationRun, wall: bool) -> None:
    """Every robot's, also what another one tells in the same step, and walls as well."""
    for number, robot in list(scanning(perfect, least=12))[:6]:

        def hide(cells: np.ndarray) -> np.ndarray:
            place = int(np.flatnonzero(((cells & OCCUPIED_BIT) != 0) == wall)[0])
            return np.delete(cells, place)

        assert "sight and knowledge" in broken(with_scan(perfect, number, robot, hide))


def test_seen_twice(perfect: ExplorationRun) -> None:
    number, robot = list(scanning(perfect))[-1]
    old = perfect.steps[0].scan(0)[0][0]
    repeat = with_scan(perfect, number, robot, lambda cells: np.append(cells, old))
    assert "sight and knowledge" in broken(repeat)
    double = with_scan(perfect, number, robot, lambda cells: np.append(cells, cells[:1]))
    assert "sight and knowledge" in broken(double)


def test_looking_without_having_moved_and_not_looking(perfect: ExplorationRun) -> None:
    number, robot = next(
        (number, robot)
        for number, step in enumerate(perfect.steps)
        for robot in range(3)
        if not step.looked[robot]
    )
    assert "sight and knowledge" in broken(with_field(perfect, number, "looked", robot, 1))
    number, robot = next(scanning(perfect))
    assert "sight and knowledge" in broken(with_field(perfect, number, "looked", robot, 0))


def test_driving_into_the_unknown(tmp_path: Path) -> None:
    # Two robots without a radio: one walks into the part that only the other has seen.
    grid = parse_ascii("#" * 14 + "\n#" + "." * 12 + "#\n" + "#" * 14)
    run = explored(
        tmp_path / "run.mcap",
        grid,
        robots=2,
        starts=[(1.5, 1.5), (12.5, 1.5)],
        range_m=2.0,
        radio=0.0,
        cell_m=1.0,
        speed_mps=1.0,
    )
    a, b = map(int, run.steps[0].cells)
    blind = moved(run, (a + 1, b), (a + 2, b), (a + 3, b))
    looked = [
        step._replace(
            looked=np.array([0, 0], np.uint8) if number else step.looked,
            scan_ends=np.array([0, 0], np.uint32) if number else step.scan_ends,
            scans=step.scans[:0] if number else step.scans,
        )
        for number, step in enumerate(blind.steps)
    ]
    report = verify_exploration(replace(blind, steps=looked))
    faults = [text for check in report.checks for text in check.faults]
    assert any("robot 0 at step 2 drives into the unknown" in text for text in faults)


def test_a_goal_nobody_knows(perfect: ExplorationRun, limited: ExplorationRun) -> None:
    step = 3
    free = np.flatnonzero(perfect.cells.reshape(-1) == 0)
    seen = np.concatenate([item.scans & ~OCCUPIED_BIT for item in perfect.steps[: step + 1]])
    goal = int(np.setdiff1d(free, seen)[-1])
    assert "sight and knowledge" in broken(with_field(perfect, step, "goals", 0, goal))
    # With a limited radio what a robot far away sees is not known.
    first = limited.steps[0]
    cells, occupied = first.scan(2)
    far = int(next(cell for cell in cells[~occupied] if cell not in first.scan(1)[0]))
    assert "sight and knowledge" not in broken(with_field(limited, 0, "goals", 3, far))
    assert "sight and knowledge" in broken(with_field(limited, 0, "goals", 0, far))


def told(run: ExplorationRun) -> Iterator[tuple[int, np.ndarray]]:
    for number, step in enumerate(run.steps):
        if len(step.told):
            yield number, step.told.reshape(-1, 4)


def with_told(run: ExplorationRun, number: int, rows: np.ndarray) -> ExplorationRun:
    flat = np.asarray(rows, dtype=np.uint32).reshape(-1)
    return with_steps(run, {number: run.steps[number]._replace(told=flat)})


def test_told_over_too_great_a_distance(limited: ExplorationRun) -> None:
    rows = limited.steps[1].told.reshape(-1, 4)
    for receiver, sender in ((0, 2), (0, 3), (3, 1)):
        far = np.array([[receiver, sender, sender, 1]])
        assert "radio" in broken(with_told(limited, 1, np.concatenate([rows, far])))


def test_a_smaller_radio_than_was_used(limited: ExplorationRun) -> None:
    assert "radio" in broken(with_robots(limited, "radio", "range_m", value=0.3))
    assert "radio" in broken(with_robots(limited, "radio", "range_m", value=3.0))


def test_told_what_the_sender_does_not_hold(limited: ExplorationRun) -> None:
    number, rows = next(told(limited))
    for column, value in ((3, 99), (2, 3), (1, 3), (0, 3)):
        lie = rows.copy()
        lie[0, column] = value if lie[0, column] != value else value - 1
        assert "radio" in broken(with_told(limited, number, lie)), column


def test_nobody_is_told_what_could_be_heard(limited: ExplorationRun) -> None:
    number, rows = list(told(limited))[1]
    assert "radio" in broken(with_told(limited, number, rows[:-1]))
    assert "radio" in broken(with_told(limited, number, np.concatenate([rows, rows[-1:]])))
    if len(rows) > 1:
        assert "radio" in broken(with_told(limited, number, rows[::-1]))


def test_transfers_where_all_hear_all(perfect: ExplorationRun) -> None:
    assert "radio" in broken(with_told(perfect, 2, np.array([[0, 1, 1, 1]])))


@pytest.mark.parametrize("name", ["messages", "bytes"])
@pytest.mark.parametrize("change", [-1, 1])
def test_traffic_counts(
    perfect: ExplorationRun, limited: ExplorationRun, name: str, change: int
) -> None:
    for run in (perfect, limited):
        value = getattr(run.steps[4], name) + change
        tampered = with_field(run, 4, name, None, value)
        # The total in the result is changed along with it, so that only the count itself is off.
        assert run.result is not None
        tampered = with_result(tampered, name, run.result["metrics"][name] + change)
        assert broken(tampered) == ("messages",)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("steps", 3),
        ("time_s", 1.5),
        ("coverage", 0.5),
        ("coverage", 1.0 + 1e-6),
        ("t90_s", 0.1),
        ("t95_s", None),
        ("t99_s", 1e-3),
        ("t100_s", 2.0),
        ("path_m", [1.0, 1.0, 1.0]),
        ("path_m", []),
        ("overlap", 0.0),
        ("balance", {"seen": 0.0, "path": 0.0}),
        ("balance", {}),
        ("messages", 7),
        ("bytes", True),
        ("coverage", "1.0"),
        ("coverage", float("nan")),
        ("observable", 100),
        ("observable", None),
    ],
)
def test_results_that_do_not_follow(perfect: ExplorationRun, key: str, value: Any) -> None:
    assert broken(with_result(perfect, key, value)) == ("metrics",)


def test_every_measure_is_checked(perfect: ExplorationRun) -> None:
    assert perfect.result is not None
    for key, value in perfect.result["metrics"].items():
        if isinstance(value, float):
            changed: Any = value * 1.000001 + 1e-6
        elif isinstance(value, int):
            changed = value + 1
        elif isinstance(value, list):
            changed = [value[0] + 1e-6, *value[1:]]
        else:
            changed = {name: part + 1e-6 for name, part in value.items()}
        assert broken(with_result(perfect, key, changed)) == ("metrics",), key
    result = copy.deepcopy(perfect.result)
    del result["metrics"]["t95_s"]
    assert broken(replace(perfect, result=result)) == ("metrics",)
    result = copy.deepcopy(perfect.result)
    result["metrics"]["score"] = 10
    assert broken(replace(perfect, result=result)) == ("metrics",)
    assert "metrics" in broken(replace(perfect, result={}))


@pytest.mark.parametrize("status", ["stuck", "out_of_budget", "infeasible", "finished", None])
def test_another_status_than_done(perfect: ExplorationRun, status: Any) -> None:
    assert broken(with_result(perfect, "status", status)) == ("ending",)


def test_done_though_something_is_unseen(perfect: ExplorationRun, tmp_path: Path) -> None:
    assert "ending" in broken(replace(perfect, steps=perfect.steps[:-4]))
    late = explored(tmp_path / "run.mcap", rooms(), max_time_s=4.0, **PERFECT)
    assert broken(late) == ()
    for status in ("done", "stuck"):
        assert broken(with_result(late, "status", status)) == ("ending",)
    assert broken(with_result(late, "interrupted", "perhaps")) == ("ending",)
    longer = copy.deepcopy(late.header)
    longer["max_time_s"] = 8.0
    assert broken(replace(late, header=longer)) == ("ending",)
    shorter = {**longer, "max_time_s": 2.0}
    assert broken(replace(late, header=shorter)) == ("ending",)


def test_going_on_after_all_is_seen(perfect: ExplorationRun) -> None:
    last = perfect.steps[-1]
    nothing = np.zeros(3, np.uint8)
    more = last._replace(
        step=last.step + 1,
        looked=nothing,
        scan_ends=np.zeros(3, np.uint32),
        scans=last.scans[:0],
        wishes=np.full(3, -1, np.int8),
        bytes=perfect.steps[-1].bytes,
    )
    assert "ending" in broken(replace(perfect, steps=[*perfect.steps, more]))


def test_turning_takes_a_step(turning: ExplorationRun) -> None:
    number, robot = next(
        (number, robot)
        for number, robot, _, _ in driving(turning)
        if number
        and turning.steps[number].headings[robot] == turning.steps[number + 1].headings[robot]
    )
    other = (int(turning.steps[number].headings[robot]) + 1) % 4
    assert "headings" in broken(with_field(turning, number, "headings", robot, other))
    assert "headings" in broken(with_field(turning, number + 1, "headings", robot, other))
    # A robot that drives sideways all along.
    steps = [step._replace(headings=(step.headings + 1) % 4) for step in turning.steps]
    assert "headings" in broken(replace(turning, steps=steps))


def test_facing_another_way_than_driven(perfect: ExplorationRun) -> None:
    number, robot, _, _ = next(driving(perfect, straight=True))
    wrong = (int(perfect.steps[number + 1].headings[robot]) + 2) % 4
    assert "headings" in broken(with_field(perfect, number + 1, "headings", robot, wrong))


def test_motion_the_robot_does_not_have(perfect: ExplorationRun) -> None:
    assert "walls" in broken(with_robots(perfect, "motion", "diagonal", value=False))
    assert "headings" in broken(with_robots(perfect, "motion", "turn_costs_step", value=True))


def test_a_sensor_the_robot_does_not_have(perfect: ExplorationRun) -> None:
    for value in (1.1, 1.5):
        assert "sight and knowledge" in broken(
            with_robots(perfect, "sensor", "range_m", value=value)
        )
    assert "sight and knowledge" in broken(with_robots(perfect, "sensor", "occlusion", value=False))


def test_another_map(perfect: ExplorationRun) -> None:
    free = np.argwhere(perfect.cells == 0)[40]
    cells = perfect.cells.copy()
    cells[tuple(free)] = 1
    assert "sight and knowledge" in broken(replace(perfect, cells=cells))
    assert broken(replace(perfect, resolution=perfect.resolution * 2)) != ()


def test_other_starts(perfect: ExplorationRun) -> None:
    header = copy.deepcopy(perfect.header)
    header["starts"][0] += 1
    assert "form" in broken(replace(perfect, header=header))


def test_a_clock_that_runs_slow(perfect: ExplorationRun) -> None:
    assert broken(replace(perfect, header={**perfect.header, "step_s": 0.1}))[0] == "form"


@pytest.mark.parametrize(
    ("name", "place", "value"),
    [
        ("step", None, 8),
        ("cells", 0, 10**6),
        ("headings", 1, 4),
        ("looked", 1, 2),
        ("finished", 1, 7),
        ("wishes", 0, 8),
        ("wishes", 0, -2),
        ("goals", 0, -2),
        ("goals", 0, 10**6),
        ("cells", None, np.zeros(2, np.uint32)),
        ("headings", None, np.zeros(4, np.uint8)),
        ("told", None, np.zeros(3, np.uint32)),
        ("said", None, np.zeros(4, np.uint32)),
        ("scan_ends", None, np.array([5, 3, 9], np.uint32)),
        ("scan_ends", 2, 10**6),
        ("scans", None, np.array([10**6], np.uint32)),
    ],
)
def test_steps_of_another_form(
    perfect: ExplorationRun, name: str, place: int | None, value: Any
) -> None:
    assert broken(with_field(perfect, 5, name, place, value)) == ("form",)


def test_steps_lost_or_doubled(perfect: ExplorationRun) -> None:
    steps = perfect.steps
    assert broken(replace(perfect, steps=[*steps[:5], *steps[6:]])) == ("form",)
    assert broken(replace(perfect, steps=[*steps[:5], steps[4], *steps[5:]])) == ("form",)
    assert broken(replace(perfect, steps=[])) == ("form",)


@pytest.mark.parametrize(
    "change",
    [
        {"job": "plan"},
        {"robots": []},
        {"robots": "three"},
        {"robots": [{}]},
        {"cell_m": 0},
        {"cell_m": float("nan")},
        {"cell_m": 1e-7},
        {"cell_m": 1e300},
        {"cell_m": True},
        {"step_s": 0.0},
        {"step_s": "1"},
        {"starts": [1, 2]},
        {"starts": [1, 2, 10**9]},
        {"starts": [1, 2, 0.5]},
        {"max_time_s": float("inf")},
        {"max_time_s": None},
    ],
)
def test_headers_that_cannot_be_used(perfect: ExplorationRun, change: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"has a header that cannot be used|is a run of job"):
        verify_exploration(replace(perfect, header={**perfect.header, **change}))


@pytest.mark.parametrize(
    ("keys", "value"),
    [
        (("radius_m",), -1),
        (("speed_mps",), 0),
        (("sensor",), None),
        (("sensor", "occlusion"), 1),
        (("sensor", "range_m"), float("inf")),
        (("motion", "diagonal"), "yes"),
        (("radio", "range_m"), "far"),
    ],
)
def test_robots_that_cannot_be(perfect: ExplorationRun, keys: tuple[str, ...], value: Any) -> None:
    with pytest.raises(InputError, match="has a header that cannot be used"):
        verify_exploration(with_robots(perfect, *keys, value=value))


def test_absurd_lengths_are_no_trouble(perfect: ExplorationRun) -> None:
    for keys in (("radius_m",), ("sensor", "range_m"), ("radio", "range_m")):
        assert broken(with_robots(perfect, *keys, value=1e308)) != ()


def test_a_tampered_file(perfect: ExplorationRun, tmp_path: Path) -> None:
    """The same through a file: whole, with right checksums, and wrong."""
    good = tmp_path / "good.mcap"
    rewrite(perfect, good)
    assert read_run(good).digest == perfect.digest
    assert broken(read_run(good)) == ()
    bad = tmp_path / "bad.mcap"
    rewrite(with_result(perfect, "t90_s", 0.5), bad)
    tampered = read_run(bad)
    assert tampered.intact
    assert tampered.digest != perfect.digest
    assert broken(tampered) == ("metrics",)
    number, robot, _, b = next(driving(perfect))
    rewrite(with_field(perfect, number + 1, "cells", robot, b + 5), bad)
    assert "walls" in broken(read_run(bad))


def rewrite(run: ExplorationRun, path: Path) -> None:
    step_ns = round(run.header["step_s"] * 1e9)
    with ExplorationWriter(path) as writer:
        writer.header(run.header)
        writer.world(run.cells, run.resolution, run.origin)
        for step in run.steps:
            writer.step(step.step * step_ns, step)
        assert run.result is not None
        writer.result((len(run.steps) - 1) * step_ns, run.result)


@settings(max_examples=120, deadline=None)
@given(data=st.data())
def test_no_changed_number_goes_unnoticed(limited: ExplorationRun, data: st.DataObject) -> None:
    """One number of one step changed at random: some rule is broken.

    Left out are claims of a mind that need not be true: what it asks for and whether it is done.
    """
    number = data.draw(st.integers(0, len(limited.steps) - 1))
    step = limited.steps[number]
    names = ["step", "cells", "headings", "looked", "scan_ends", "messages", "bytes"]
    names += [name for name in ("scans", "told") if len(getattr(step, name))]
    name = data.draw(st.sampled_from(names))
    value = getattr(step, name)
    if isinstance(value, np.ndarray):
        place = data.draw(st.integers(0, len(value) - 1))
        top = int(np.iinfo(value.dtype).max)
        new = data.draw(st.one_of(st.integers(0, min(top, 400)), st.integers(0, top)))
        if int(value[place]) == new or (name == "headings" and number == 0):
            return
        tampered = with_field(limited, number, name, place, new)
    else:
        new = data.draw(st.integers(0, 10**6))
        if value == new:
            return
        tampered = with_field(limited, number, name, None, new)
    assert broken(tampered) != ()


# --- radios switched off ------------------------------------------------------------------------


class Shy(Nearest):
    """The nearest frontier, with the radio off one step of three."""

    may_be_quiet = True

    def step(self, memory: Any, view: Any, inbox: Any, rng: Any) -> Any:
        memory, action, said = super().step(memory, view, inbox, rng)
        return memory, action._replace(quiet=(view.step + view.robot) % 3 == 0), said


@pytest.fixture(scope="module")
def shy(tmp_path_factory: pytest.TempPathFactory) -> ExplorationRun:
    path = tmp_path_factory.mktemp("shy") / "run.mcap"
    return explored(path, rooms(), robots=3, seed=3, range_m=1.3, strategy=Shy())


def test_radios_that_are_off_part_of_the_time(shy: ExplorationRun) -> None:
    assert broken(shy) == ()
    assert shy.header["all_to_all"] is False
    assert any(len(step.told) for step in shy.steps)


def test_heard_with_the_radio_off(shy: ExplorationRun) -> None:
    number = next(step.step for step in shy.steps[1:] if len(step.told))
    receiver = int(shy.steps[number].told[0])
    assert "radio" in broken(with_field(shy, number - 1, "quiet", receiver, 1))


def test_not_heard_with_the_radio_on(shy: ExplorationRun) -> None:
    changes = {
        number: step._replace(quiet=np.zeros_like(step.quiet))
        for number, step in enumerate(shy.steps)
    }
    assert "radio" in broken(with_steps(shy, changes))


def test_speaking_with_the_radio_off(shy: ExplorationRun) -> None:
    number, sender = next(
        (step.step, int(robot)) for step in shy.steps for robot in np.flatnonzero(step.quiet)
    )
    said = np.array([sender, 1 - min(sender, 1), 30], np.uint32)
    tampered = with_field(shy, number + 1, "said", None, said)
    step = tampered.steps[number + 1]
    tampered = with_field(tampered, number + 1, "messages", None, step.messages + 1)
    tampered = with_field(tampered, number + 1, "bytes", None, step.bytes + 30)
    tampered = with_result(tampered, "messages", tampered.result["metrics"]["messages"] + 1)
    tampered = with_result(tampered, "bytes", tampered.result["metrics"]["bytes"] + 30)
    assert broken(tampered) == ("radio",)


def test_a_radio_off_where_all_tell_all(perfect: ExplorationRun) -> None:
    assert perfect.header["all_to_all"] is True
    assert broken(with_field(perfect, 3, "quiet", 0, 1)) == ("radio",)


def test_all_tell_all_only_over_radios_that_reach_all(limited: ExplorationRun) -> None:
    header = {**limited.header, "all_to_all": True}
    assert "form" in broken(replace(limited, header=header))
