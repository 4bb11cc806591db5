"""The nearest-frontier strategy end to end."""

import numpy as np
import pytest

import conav
from conav.exploration.verify import verify_exploration
from conav.maps.ascii_art import parse_ascii


@pytest.mark.parametrize("name", ["office", "maze", "cave", "three-obstacles"])
def test_finishes_and_is_accepted(name: str, tmp_path) -> None:
    path = tmp_path / "run.mcap"
    done = conav.explore(name, robots=3, seed=2, out=path)
    assert done.status == "done"
    assert done.metrics.coverage == 1.0
    report = verify_exploration(conav.read_run(path))
    assert report.accepted, report.lines()


def test_one_robot_walks_a_corridor_by_hand() -> None:
    # Nine cells in a row, one robot at the left end, sensor range two cells: it stands still for
    # the looks that show cells 1 and 2, and has seen cell 8 when it stands on cell 6.
    grid = parse_ascii("#" * 11 + "\n#.........#\n" + "#" * 11)
    done = conav.explore(
        grid, robots=1, starts=[(1.5, 1.5)], range_m=2.0, speed_mps=1.0, motion="4-connected"
    )
    assert done.status == "done"
    assert done.metrics.steps == 6
    assert done.metrics.path_m == (6.0,)
    assert done.result.covered == (3, 4, 5, 6, 7, 8, 9)
    assert np.count_nonzero(done.result.team_map == 0) == 9
