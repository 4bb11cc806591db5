"""The figures of the two-stage paper: the flowchart is the program's table, and files repeat."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from conav.exploration.two_stage_flow import ADDED, FLOW, STAGE, Phase
from conav.pictures import two_stage_figures as module
from conav.pictures.two_stage_figures import (
    save_flowchart,
    save_sections,
    save_trajectories,
    transitions,
)

SQUARE = np.array([[10.0, 10.0], [10.0, 30.0], [20.0, 30.0], [20.0, 10.0], [10.0, 10.0]])


def test_every_transition_of_the_program_is_in_the_flowchart() -> None:
    drawn = Counter(
        (phase, event, then) for (phase, then), events in transitions().items() for event in events
    )
    assert drawn == Counter((phase, event, then) for (phase, event), then in FLOW.items())
    assert set(STAGE) == set(Phase) == set(module._PLACES)
    assert {event for _, event in FLOW} >= ADDED


def test_a_robot_changes_stage_once() -> None:
    """No transition leads back from stage 2."""
    assert all(STAGE[phase] <= STAGE[then] for (phase, _), then in FLOW.items())


def test_the_words_of_the_flowchart(tmp_path: Path) -> None:
    import re

    save_flowchart(tmp_path / "flow.svg")
    # matplotlib keeps each text as a comment beside its outlines.
    words = set(re.findall(r"<!-- (.*?) -->", (tmp_path / "flow.svg").read_text()))
    for phase in Phase:
        assert phase in words
    for _, event in FLOW:
        assert event in words or f"({event})" in words


def test_corners_of_a_path() -> None:
    path = np.array([[0, 0], [1, 0], [2, 0], [2, 0], [2, 1], [2, 0], [3, 1]], dtype=float)
    assert module._corners(path) == [(0, 0), (2, 0), (2, 1), (2, 0), (3, 1)]


@pytest.mark.parametrize("axis", [0, 1])
def test_pictures_are_drawn_and_repeat(axis: int, tmp_path: Path) -> None:
    for name in ("a", "b"):
        save_flowchart(tmp_path / f"2{name}.png")
        save_trajectories(tmp_path / f"4{name}.png", {"one": [SQUARE], "two": [SQUARE]}, 50.0, "n")
        save_sections(
            tmp_path / f"1{name}.png", [SQUARE], axis, [(0.0, 5.0), (25.0, 50.0)], 4.0, 50.0, "n"
        )
    for number in (1, 2, 4):
        first, second = (tmp_path / f"{number}{name}.png" for name in ("a", "b"))
        assert first.read_bytes() == second.read_bytes()
        with Image.open(first) as picture:
            picture.load()
            assert picture.width == 1280
            assert picture.convert("HSV").getchannel("S").getextrema()[1] > 150
