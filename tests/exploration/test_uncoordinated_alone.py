"""Uncoordinated robots that tell each other nothing."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conav
from conav.errors import InputError
from conav.exploration.uncoordinated_alone import UncoordinatedAlone
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import UNKNOWN
from conav.simulation.explore import explore
from conav.simulation.world_state import WorldState

PAPER: dict[str, Any] = {
    "motion": "forward-turn",
    "sensor": "disc",
    "range_m": 2.0,
    "cell_m": 1.0,
    "speed_mps": 1.0,
    "traffic": "none",
}
SQUARE = "\n".join(["." * 12] * 12)


def test_nobody_says_or_hears_anything(tmp_path: Path) -> None:
    out = tmp_path / "run.mcap"
    # Two of them begin on the same cell.
    starts = [(1.5, 1.5), (1.5, 1.5), (8.5, 8.5)]
    done = conav.explore(
        parse_ascii(SQUARE), strategy="uncoordinated-alone", starts=starts, out=out, **PAPER
    )
    assert done.status == "done"
    assert (done.metrics.messages, done.metrics.bytes) == (0, 0)
    run = conav.read_run(out)
    assert all(robot["radio"]["range_m"] == 0.0 for robot in run.header["robots"])
    assert all(len(step.told) == len(step.said) == 0 for step in run.steps)
    report = conav.verify_exploration(run)
    assert report.accepted, report.lines()


def test_each_knows_what_it_has_seen_itself() -> None:
    own = np.zeros((3, 12, 12), bool)
    y, x = np.indices((12, 12))
    steps = 0

    def watch(state: WorldState) -> None:
        nonlocal steps
        steps += 1
        for robot, cell in enumerate(state.cells.tolist()):
            own[robot] |= (y - cell // 12) ** 2 + (x - cell % 12) ** 2 <= 4
            assert np.array_equal(state.beliefs[robot].cells != UNKNOWN, own[robot])
            others = np.delete(state.heard_step[robot], robot)
            assert (others == -1).all()

    done = explore(
        parse_ascii(SQUARE), strategy=UncoordinatedAlone(), progress=watch, seed=2, **PAPER
    )
    assert steps == done.metrics.steps + 1
    # The team is done when its robots together have seen all, which none of them can tell.
    assert done.status == "done"
    assert own.any(axis=0).all()
    assert not own.all()


def test_finishes_and_is_accepted(tmp_path: Path) -> None:
    grid = conav.builtin_map("three-obstacles", width_m=16, height_m=16, seed=1)
    out = tmp_path / "run.mcap"
    done = conav.explore(grid, strategy="uncoordinated-alone", seed=1, out=out, **PAPER)
    assert done.status == "done"
    assert done.metrics.coverage == 1.0
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()


def test_one_robot_alone_is_uncoordinated() -> None:
    grid = conav.builtin_map("three-obstacles", width_m=12, height_m=12, seed=1)
    one, other = (
        conav.explore(grid, strategy=name, robots=1, seed=3, **PAPER)
        for name in ("uncoordinated-alone", "uncoordinated")
    )
    assert one.metrics == other.metrics
    assert one.result.covered == other.result.covered


def test_a_real_kind_of_map_is_accepted(tmp_path: Path) -> None:
    out = tmp_path / "run.mcap"
    conav.explore(
        "office",
        strategy="uncoordinated-alone",
        robots=3,
        seed=3,
        motion="forward-turn",
        cell_m=0.37,
        max_time_s=200.0,
        out=out,
    )
    report = conav.verify_exploration(conav.read_run(out))
    assert report.accepted, report.lines()


@pytest.mark.parametrize("radio", ["perfect", 3.0, "5"])
def test_another_radio_is_refused(radio: Any) -> None:
    with pytest.raises(InputError, match="made for radio off") as caught:
        conav.explore("maze", strategy="uncoordinated-alone", radio=radio)
    assert "\n" not in str(caught.value)


def test_the_radio_may_be_named_off() -> None:
    done = conav.explore("maze", strategy="uncoordinated-alone", radio="off", max_time_s=5.0)
    assert done.metrics.messages == 0


def test_settings_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match=r"docs/strategies/uncoordinated-alone\.md"):
        conav.explore("maze", strategy="uncoordinated-alone", settings={"tie": "forward"})
    for name, value in (("epsilon", "2"), ("epsilon", "often"), ("radio", "perfect")):
        with pytest.raises(InputError, match="has no such setting"):
            conav.explore("maze", strategy="uncoordinated-alone", settings={name: value})
