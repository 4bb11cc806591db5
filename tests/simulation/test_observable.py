"""What a team can observe at best, by hand and against the verifier's own version."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import conav
from conav.exploration.verify import verify_exploration
from conav.maps.ascii_art import parse_ascii, to_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import planning_grid
from conav.robots.sensor import Sensor
from conav.simulation.observable import observable_cells


def observable(
    picture: str, start: tuple[int, int], reach: float, *, occlusion: bool = True, **body: float
) -> str:
    """The map with `.` on observable cells and `#` on all others."""
    plan = planning_grid(parse_ascii(picture), **({"cell_m": 1.0, "radius_m": 0.1} | body))
    cell = start[0] * plan.lattice.cols + start[1]
    seen = observable_cells(plan, [cell], Sensor("any", occlusion, reach))
    return to_ascii(OccupancyGrid(1 - seen, 1.0))


def test_a_room_is_observable_whole() -> None:
    room = "#####\n#...#\n#.#.#\n#...#\n#####"
    for reach in (0.0, 1.0, 10.0):  # robots can stand everywhere, so the range does not matter
        assert observable(room, (1, 1), reach) == room


def test_rooms_nobody_can_reach_are_left_out() -> None:
    picture = "#########\n#...#...#\n#...#...#\n#########"
    left = "#########\n#...#####\n#...#####\n#########"
    assert observable(picture, (1, 1), 10.0) == left


def test_through_walls_only_without_occlusion() -> None:
    picture = "#########\n#...#...#\n#...#...#\n#########"
    two = "#########\n#...#.###\n#...#.###\n#########"
    assert observable(picture, (1, 1), 2.0, occlusion=False) == two
    assert observable(picture, (1, 1), 4.0, occlusion=False) == picture


@pytest.mark.parametrize(("reach", "count"), [(0.9, 0), (1.0, 1), (2.5, 2), (3.0, 3), (9.0, 4)])
def test_a_slit_too_narrow_for_the_robot(reach: float, count: int) -> None:
    """A disc of radius 0.6 comes up to the slit's mouth and looks in as far as it reaches."""
    slit = "#######\n###.###\n###.###\n###.###\n###.###\n#.....#\n#.....#\n#.....#\n#######"
    for occlusion in (True, False):
        rows = observable(slit, (2, 3), reach, occlusion=occlusion, radius_m=0.6).split("\n")
        assert [row[3] for row in rows[1:5]] == ["#"] * (4 - count) + ["."] * count
    rows = observable(slit, (2, 3), 9.0, radius_m=0.6).split("\n")
    assert rows == slit.split("\n")


def test_cells_beside_the_walls_need_a_range() -> None:
    room = "#####\n#...#\n#...#\n#...#\n#####"
    middle = "#####\n#####\n##.##\n#####\n#####"
    cross = "#####\n##.##\n#...#\n##.##\n#####"
    for occlusion in (True, False):
        assert observable(room, (2, 2), 0.5, occlusion=occlusion, radius_m=0.6) == middle
        assert observable(room, (2, 2), 1.0, occlusion=occlusion, radius_m=0.6) == cross
        assert observable(room, (2, 2), 1.5, occlusion=occlusion, radius_m=0.6) == room


def test_a_cell_out_of_sight_of_its_nearest_place_does_not_count() -> None:
    """Round two corners of a passage that is too narrow to enter."""
    picture = "########\n##...###\n##.#.###\n##.#####\n#....###\n#....###\n#....###\n########"
    got = observable(picture, (2, 3), 9.0, radius_m=0.6)
    rows = got.split("\n")
    assert rows[3] == "##.#####"
    assert rows[2] == "##.#####"  # the near leg is seen, the far one is not
    assert rows[1][2] == "."
    assert rows[1][4] == "#"


def test_one_reachable_place_among_several_in_a_fine_cell_is_enough() -> None:
    """Four planning cells in each fine one; beside a wall only some can be stood on."""
    room = "####\n#..#\n#..#\n####"
    plan = planning_grid(parse_ascii(room), cell_m=0.5, radius_m=0.4)
    starts = [int(np.flatnonzero(plan.standable)[0])]
    assert plan.standable.sum() == 4
    seen = observable_cells(plan, starts, Sensor("any", True, 0.0))
    assert np.array_equal(seen, plan.walls == 0)
    seen = observable_cells(plan, starts, Sensor("any", False, 0.0))
    assert np.array_equal(seen, plan.walls == 0)


def test_starts_in_two_parts_count_both() -> None:
    plan = planning_grid(parse_ascii("..#..#.."), cell_m=1.0, radius_m=0.1)
    sensor = Sensor("any", True, 5.0)
    assert observable_cells(plan, [0, 7], sensor).tolist() == [[1, 1, 0, 0, 0, 0, 1, 1]]
    assert observable_cells(plan, [3], sensor).tolist() == [[0, 0, 0, 1, 1, 0, 0, 0]]


def test_walls_and_unknown_cells_never_count() -> None:
    for occlusion in (True, False):
        assert observable("..?#.", (0, 0), 9.0, occlusion=occlusion)[2:4] == "##"


@settings(max_examples=25, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([(1.0, 0.1), (1.0, 0.6), (2.0, 0.7), (1.7, 0.6), (0.5, 0.4), (3.0, 1.0)]),
    st.sampled_from(["range", "disc"]),
    st.sampled_from([1.0, 2.5, 6.0]),
)
def test_the_verifier_counts_the_same_cells(
    tmp_path_factory: pytest.TempPathFactory,
    seed: int,
    body: tuple[float, float],
    sensor: str,
    reach: float,
) -> None:
    """Through the file of a run of no length."""
    rng = np.random.default_rng(seed)
    walls = (rng.random((int(rng.integers(3, 14)), int(rng.integers(3, 14)))) < 0.2).astype(
        np.uint8
    )
    path: Path = tmp_path_factory.mktemp("runs") / "run.mcap"
    try:
        conav.explore(
            OccupancyGrid(walls, 1.0),
            robots=1,
            cell_m=body[0],
            radius_m=body[1],
            sensor=sensor,
            range_m=reach,
            seed=seed % 100,
            max_time_s=0.0,
            out=path,
        )
    except conav.InputError:
        return  # no room for the robot
    report = verify_exploration(conav.read_run(path))
    assert report.accepted, "\n".join(report.lines())
