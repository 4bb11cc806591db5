"""Uncoordinated robots with a shared map: Algorithm 2 with an exploration rate of 1."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conav
from conav.errors import InputError
from conav.exploration.uncoordinated import Uncoordinated
from conav.runs.types import ExplorationRun
from conav.testing import check_strategy

PAPER: dict[str, Any] = {
    "motion": "forward-turn",
    "sensor": "disc",
    "range_m": 2.0,
    "cell_m": 1.0,
    "speed_mps": 1.0,
    "traffic": "none",
}


def explored(path: Path, map: Any, **problem: Any) -> ExplorationRun:
    conav.explore(map, out=path, **problem)
    return conav.read_run(path)


@pytest.mark.parametrize("tie", ["random", "baseline"])
@pytest.mark.parametrize(
    "problem",
    [
        {"map": "three-obstacles", **PAPER, "max_time_s": 300.0},
        {"map": "maze", "motion": "forward-turn", "radio": 4.0, "max_time_s": 60.0},
    ],
    ids=["three-obstacles", "maze"],
)
def test_it_is_potential_with_epsilon_1(tie: str, problem: dict[str, Any], tmp_path: Path) -> None:
    """Run for run: the events of every step are the same."""
    settings: dict[str, object] = {"tie": tie}
    one = explored(
        tmp_path / "a.mcap", strategy="uncoordinated", settings=settings, seed=4, **problem
    )
    other = explored(
        tmp_path / "b.mcap",
        strategy="potential",
        settings=settings | {"epsilon": 1.0},
        seed=4,
        **problem,
    )
    assert len(one.steps) == len(other.steps) > 100
    for step, same in zip(one.steps, other.steps, strict=True):
        for a, b in zip(step, same, strict=True):
            assert np.array_equal(a, b)
    assert one.result == other.result
    lazy = explored(tmp_path / "c.mcap", strategy="potential", settings=settings, seed=4, **problem)
    assert lazy.result != one.result


@pytest.mark.parametrize("seed", [1, 2])
def test_finishes_and_is_accepted(seed: int, tmp_path: Path) -> None:
    grid = conav.builtin_map("three-obstacles", width_m=16, height_m=16, seed=seed)
    out = tmp_path / "run.mcap"
    done = conav.explore(grid, strategy="uncoordinated", seed=seed, out=out, **PAPER)
    assert done.status == "done"
    assert done.metrics.coverage == 1.0
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()


def test_a_real_kind_of_map_is_accepted(tmp_path: Path) -> None:
    run = explored(
        tmp_path / "run.mcap",
        "office",
        strategy="uncoordinated",
        robots=3,
        seed=3,
        motion="forward-turn",
        cell_m=0.37,
        max_time_s=200.0,
    )
    report = conav.verify_exploration(run)
    assert report.accepted, report.lines()


def test_it_is_a_strategy_like_any_other() -> None:
    check_strategy(Uncoordinated(), motion="forward-turn")


def test_settings_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match=r"docs/strategies/uncoordinated\.md"):
        conav.explore("maze", strategy="uncoordinated", settings={"tie": "forward"})
    for epsilon in ("2", "often"):
        with pytest.raises(InputError, match="has no such setting"):
            conav.explore("maze", strategy="uncoordinated", settings={"epsilon": epsilon})
