"""The verifier accepts what the simulator makes and rejects what was tampered with, by name."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conav
from conav.exploration.verify import verify_exploration
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.runs.types import OCCUPIED_BIT, Run, StepRecord

PICTURE = """
####################
#........#.........#
#........#.........#
#..................#
#........#....##...#
#........#....##...#
#........#.........#
####################
"""


def small_run(folder: Path, **options: Any) -> Run:
    grid = parse_ascii(PICTURE.strip(), name="small")
    path = folder / "run.mcap"
    given: dict[str, Any] = {"robots": 3, "seed": 2, "range_m": 4.0, "speed_mps": 1.0}
    conav.explore(grid, out=path, **{**given, **options})
    return conav.read_run(path)


@pytest.fixture(scope="module")
def perfect(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return small_run(tmp_path_factory.mktemp("perfect"))


@pytest.fixture(scope="module")
def limited(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return small_run(tmp_path_factory.mktemp("limited"), radio=3.0)


@pytest.mark.parametrize("motion", ["4-connected", "8-connected", "forward-turn"])
@pytest.mark.parametrize("sensor", ["range", "disc"])
@pytest.mark.parametrize("radio", ["perfect", 3.0, 0.0])
def test_accepts_honest_runs(motion: str, sensor: str, radio: str | float, tmp_path: Path) -> None:
    run = small_run(tmp_path, motion=motion, sensor=sensor, radio=radio)
    report = verify_exploration(run)
    assert report.accepted, report.lines()


@pytest.mark.parametrize(
    ("cell_m", "radius_m"), [(0.1, 0.03), (0.1, 0.25), (0.17, 0.1), (0.25, 0.1), (0.05, 0.12)]
)
def test_accepts_any_cell_and_radius(cell_m: float, radius_m: float, tmp_path: Path) -> None:
    grid = conav.builtin_map("office", width_m=8.0, height_m=6.0, seed=1)
    # Unknown cells in the truth are walls.
    cells = grid.cells.copy()
    cells[cells == 1] = np.where(np.arange(np.count_nonzero(cells == 1)) % 3, 1, 2)
    path = tmp_path / "run.mcap"
    conav.explore(
        OccupancyGrid(cells, grid.resolution, (1.0, -2.0, 0.5)),
        robots=2,
        seed=4,
        cell_m=cell_m,
        radius_m=radius_m,
        out=path,
    )
    report = verify_exploration(conav.read_run(path))
    assert report.accepted, report.lines()


def edited(run: Run, number: int, **changes: Any) -> Run:
    steps = list(run.steps)
    steps[number] = steps[number]._replace(**changes)
    return replace(run, steps=steps)


def with_array(run: Run, number: int, name: str, robot: int, value: int) -> Run:
    array = getattr(run.steps[number], name).copy()
    array[robot] = value
    return edited(run, number, **{name: array})


def with_result(run: Run, **changes: Any) -> Run:
    result = deepcopy(run.result)
    assert result is not None
    for key, value in changes.items():
        if key in result:
            result[key] = value
        else:
            assert key in result["metrics"], key
            result["metrics"][key] = value
    return replace(run, result=result)


def with_robots(run: Run, **changes: Any) -> Run:
    header = deepcopy(run.header)
    for robot in header["robots"]:
        robot.update(changes)
    return replace(run, header=header)


def with_scans(run: Run, number: int, robot: int, part: np.ndarray) -> Run:
    """The same step with one robot's scan replaced."""
    step: StepRecord = run.steps[number]
    parts = []
    start = 0
    for other, end in enumerate(step.scan_ends):
        parts.append(part if other == robot else step.scans[start:end])
        start = int(end)
    ends = np.cumsum([len(item) for item in parts]).astype(np.uint32)
    return edited(run, number, scans=np.concatenate(parts).astype(np.uint32), scan_ends=ends)


def first_scan(run: Run, least: int = 2) -> tuple[int, int, np.ndarray]:
    """A step, a robot and its scan after the first step, with at least so many cells."""
    for number, step in enumerate(run.steps[1:], 1):
        start = 0
        for robot, end in enumerate(step.scan_ends):
            if end - start >= least:
                return number, robot, step.scans[start:end].copy()
            start = int(end)
    raise AssertionError("no such scan")


def far_cell(run: Run) -> int:
    """A free cell the whole team has not seen at first: the far upper corner."""
    step = run.steps[0]
    return 6 * 20 + (18 if int(step.cells[0]) % 20 < 9 else 1)


def cut_scan(run: Run) -> Run:
    number, robot, part = first_scan(run)
    return with_scans(run, number, robot, part[:-1])


def flip_scan(run: Run) -> Run:
    number, robot, part = first_scan(run)
    part[0] ^= OCCUPIED_BIT
    return with_scans(run, number, robot, part)


def repeat_scan(run: Run) -> Run:
    number, robot, part = first_scan(run)
    return with_scans(run, number, robot, np.append(part, part[0]))


def claim_far(run: Run) -> Run:
    number, robot, part = first_scan(run, least=1)
    return with_scans(run, number, robot, np.append(part, np.uint32(far_cell(run))))


def swap_two(run: Run) -> Run:
    number = len(run.steps) // 2
    cells = run.steps[number].cells.copy()
    cells[0], cells[1] = cells[1], cells[0]
    return edited(run, number, cells=cells)


def same_place(run: Run) -> Run:
    number = len(run.steps) // 2
    cells = run.steps[number].cells.copy()
    cells[1] = cells[0]
    return edited(run, number, cells=cells)


TAMPERINGS: dict[str, tuple[str, Callable[[Run], Run]]] = {
    "teleport": ("walls", lambda run: with_array(run, 3, "cells", 0, far_cell(run))),
    "into a wall": ("walls", lambda run: with_array(run, len(run.steps) - 1, "cells", 0, 0)),
    "a wider body": ("walls", lambda run: with_robots(run, radius_m=0.7)),
    "two robots in one place": ("collisions", same_place),
    "two robots change places": ("collisions", swap_two),
    "slower than it drove": ("speed", lambda run: slower(run)),
    "walls taken for free": ("sight and knowledge", flip_scan),
    "a cell it cannot see": ("sight and knowledge", claim_far),
    "a cell it did not report": ("sight and knowledge", cut_scan),
    "a cell reported twice": ("sight and knowledge", repeat_scan),
    "a shorter sensor": (
        "sight and knowledge",
        lambda run: with_robots(run, sensor={"name": "range", "occlusion": True, "range_m": 3.0}),
    ),
    "a look that was none": (
        "sight and knowledge",
        lambda run: with_array(run, 5, "looked", 0, 1 - int(run.steps[5].looked[0])),
    ),
    "a goal nobody told of": (
        "sight and knowledge",
        lambda run: with_array(run, 0, "goals", 0, far_cell(run)),
    ),
    "fewer messages": ("messages", lambda run: edited(run, 4, messages=0)),
    "fewer bytes": ("messages", lambda run: edited(run, 4, bytes=run.steps[4].bytes - 1)),
    "coverage": ("metrics", lambda run: with_result(run, coverage=0.9)),
    "an earlier time": ("metrics", lambda run: with_result(run, t90_s=1.0)),
    "shorter paths": ("metrics", lambda run: with_result(run, path_m=[1.0, 1.0, 1.0])),
    "less overlap": ("metrics", lambda run: with_result(run, overlap=0.0)),
    "better balance": ("metrics", lambda run: with_result(run, balance={"seen": 0, "path": 0})),
    "fewer cells to see": ("metrics", lambda run: with_result(run, observable=50)),
    "another status": ("ending", lambda run: with_result(run, status="stuck")),
    "a missing step": ("form", lambda run: replace(run, steps=run.steps[:4] + run.steps[5:])),
    "other starts": (
        "form",
        lambda run: replace(run, header={**run.header, "starts": run.header["starts"][::-1]}),
    ),
}


def slower(run: Run) -> Run:
    header = deepcopy(run.header)
    header["robots"][0]["speed_mps"] = 0.5
    return replace(run, header=header)


@pytest.mark.parametrize("what", TAMPERINGS)
def test_rejects(what: str, perfect: Run) -> None:
    assert verify_exploration(perfect).accepted
    check, tamper = TAMPERINGS[what]
    report = verify_exploration(tamper(perfect))
    assert not report.accepted
    assert check in report.broken(), report.lines()


def told_somewhere(run: Run) -> tuple[int, np.ndarray]:
    for number, step in enumerate(run.steps):
        if len(step.told):
            return number, step.told.copy()
    raise AssertionError("nobody told anybody anything")


def test_rejects_transfers_that_cannot_have_been(limited: Run) -> None:
    assert verify_exploration(limited).accepted
    number, told = told_somewhere(limited)
    more = told.copy()
    more[3] += 1  # a scan the sender does not hold
    self_told = told.copy()
    self_told[1] = self_told[0]
    for wrong in (more, self_told, told[4:], np.concatenate([told, told])):
        report = verify_exploration(edited(limited, number, told=wrong))
        assert "radio" in report.broken(), report.lines()


def test_rejects_a_radio_that_did_not_reach(limited: Run) -> None:
    radio = {"name": "limited", "range_m": 0.5}
    assert not verify_exploration(with_robots(limited, radio=radio)).accepted


def test_rejects_hearing_without_a_radio(perfect: Run) -> None:
    """With the shared map taken away, robots know what nobody told them."""
    radio = {"name": "limited", "range_m": 0.0}
    report = verify_exploration(with_robots(perfect, radio=radio))
    assert "sight and knowledge" in report.broken(), report.lines()


def test_another_job_is_bad_input(perfect: Run) -> None:
    with pytest.raises(conav.InputError, match="explorations"):
        verify_exploration(replace(perfect, header={**perfect.header, "job": "plan"}))
