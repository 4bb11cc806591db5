"""The nearest-frontier strategy end to end."""

import numpy as np
import pytest

import conav
from conav.exploration.belief import Belief, new_scratch
from conav.exploration.nearest import by_field, by_search
from conav.exploration.verify import verify_exploration
from conav.geometry.directions import DCOL, DROW
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import planning_grid


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


@pytest.mark.parametrize("share", [0.0, 0.02, 0.3])
def test_both_ways_to_find_the_nearest_agree(share: float) -> None:
    """The same goal, and paths of the same length; only which of equal paths may differ."""
    rng = np.random.default_rng(7)
    found = 0
    for _ in range(60):
        cells = (rng.random((14, 17)) < rng.choice([0.1, 0.35])).astype(np.uint8)
        plan = planning_grid(OccupancyGrid(cells, 1.0), radius_m=0.1, cell_m=1.0)
        places = np.flatnonzero(plan.standable)
        start = int(rng.choice(places))
        belief = Belief(plan)
        seen = np.flatnonzero(rng.random(cells.size) < 0.95).astype(np.int32)
        belief.hear(plan, start, seen, new_scratch(plan))
        goals = (rng.random(cells.shape) < share).astype(np.uint8) * 2
        one, two = (find(belief, start, goals, 2) for find in (by_search, by_field))
        assert one[0] == two[0]
        assert (one[1] >= 4).sum() == (two[1] >= 4).sum()
        assert one[2] == len(one[1]) == two[2] == len(two[1])
        for goal, path, _ in (one, two):
            if goal < 0:
                continue
            found += 1
            cell = start
            for k in path[::-1].tolist():
                assert belief.moves.flat[cell] >> k & 1
                cell += DROW[k] * 17 + DCOL[k]
            assert cell == goal
    assert (found > 60) == (share > 0)
