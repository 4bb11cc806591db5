"""Where a team starts: together by itself, or where it is told."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import OccupancyGrid
from conav.maps.planning_grid import PlanningGrid, default_start_area, planning_grid
from conav.robots.robot import Robot
from conav.simulation.explore import exploration_problem
from conav.simulation.pibt import MIN_GAP
from conav.simulation.starts import nearest_standable, start_together, starts_at


def team(n: int, radius: float = 0.1) -> tuple[Robot, ...]:
    return tuple(Robot(f"robot_{i}", radius_m=radius) for i in range(n))


def plan_of(
    picture: str,
    *,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    resolution: float = 1.0,
    cell: float | None = None,
    radius: float = 0.1,
) -> PlanningGrid:
    grid = parse_ascii(picture, resolution=resolution, origin=origin)
    return planning_grid(grid, cell_m=cell or resolution, radius_m=radius)


def together(plan: PlanningGrid, n: int, radius: float, seed: int) -> tuple[int, ...]:
    rng = np.random.default_rng(seed)
    return start_together(plan, default_start_area(plan), team(n, radius), rng)


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 12),
    st.sampled_from([(1.0, 0.1), (1.0, 0.45), (0.5, 0.3), (0.3, 0.4), (2.0, 0.7)]),
)
def test_a_team_starts_apart_in_one_part_and_as_near_as_it_fits(
    seed: int, n: int, body: tuple[float, float]
) -> None:
    rng = np.random.default_rng(seed)
    cell, radius = body
    walls = (rng.random((12, 12)) < 0.1).astype(np.uint8)
    plan = planning_grid(OccupancyGrid(walls, 1.0), cell_m=cell, radius_m=radius)
    try:
        starts = together(plan, n, radius, seed)
    except InputError:
        return
    labels = plan.labels.reshape(-1)[list(starts)]
    assert len(set(labels.tolist())) == 1
    assert (plan.standable.reshape(-1)[list(starts)] == 1).all()
    places = [plan.lattice.position(start) for start in starts]
    gap = max(2 * radius, MIN_GAP * cell)
    for i in range(n):
        for j in range(i):
            assert math.dist(places[i], places[j]) >= gap - 1e-6
    # By number of moves from the first: ever further, and no nearer place was passed over.
    far = moves_from(plan, starts[0])
    steps = [far[start] for start in starts]
    assert steps == sorted(steps)
    for place, distance in far.items():
        if distance < steps[-1] and place not in starts:
            assert any(
                math.dist(plan.lattice.position(place), other) < gap + 1e-6 for other in places
            )


def moves_from(plan: PlanningGrid, start: int) -> dict[int, int]:
    from conav.geometry.directions import DCOL, DROW

    far = {start: 0}
    ring = [start]
    while ring:
        following = []
        for cell in ring:
            for k in range(8):
                if plan.moves.reshape(-1)[cell] >> k & 1:
                    other = cell + DROW[k] * plan.lattice.cols + DCOL[k]
                    if other not in far:
                        far[other] = far[cell] + 1
                        following.append(other)
        ring = following
    return far


def test_the_first_robot_may_start_anywhere() -> None:
    plan = plan_of("....\n....")
    assert {together(plan, 1, 0.1, seed)[0] for seed in range(80)} == set(range(8))


def test_the_same_seed_gives_the_same_starts() -> None:
    grid = parse_ascii("........\n........\n........")
    starts = [exploration_problem(grid, robots=4, seed=seed)[0].starts for seed in (1, 1, 2, 3)]
    assert starts[0] == starts[1]
    assert len(set(starts)) == 3


def test_a_full_room_is_filled_to_the_last_cell() -> None:
    plan = plan_of("####\n#..#\n#..#\n####")
    assert set(together(plan, 4, 0.1, 3)) == {5, 6, 9, 10}
    with pytest.raises(InputError, match="room for 4 of 5 robots") as caught:
        together(plan, 5, 0.1, 3)
    assert "--robots" in caught.value.remedy


def test_wide_robots_need_more_room() -> None:
    # Discs of radius 0.45 on a lattice of 2 x 4 places half a metre apart: two at best.
    plan = plan_of("#####\n#...#\n#...#\n#####", cell=0.5, radius=0.45)
    assert plan.standable.sum() == 8
    starts = together(plan, 2, 0.45, 0)
    assert math.dist(*(plan.lattice.position(start) for start in starts)) >= 0.9
    with pytest.raises(InputError, match="room for 2 of 3 robots"):
        together(plan, 3, 0.45, 0)


def test_explicit_starts_by_hand() -> None:
    plan = plan_of("....\n....\n....")
    assert starts_at(plan, [(0.5, 0.5), (3.9, 2.1)], team(2)) == (0, 11)
    # Anywhere in a cell, its lower and left sides included.
    assert starts_at(plan, [(1.0, 1.0)], team(1)) == (5,)


def test_explicit_starts_are_in_the_map_frame() -> None:
    # The grid's corner at (10, 20), turned left by a quarter: columns run to the north.
    plan = plan_of("....\n....", origin=(10.0, 20.0, math.pi / 2))
    assert starts_at(plan, [(10 - 0.5, 20 + 2.5)], team(1)) == (2,)
    assert starts_at(plan, [(10 - 1.5, 20 + 0.5)], team(1)) == (4,)
    with pytest.raises(InputError, match="off the map"):
        starts_at(plan, [(10.5, 20.5)], team(1))
    shifted = plan_of("....\n....", origin=(-2.0, -1.0, 0.0))
    assert starts_at(shifted, [(-1.5, -0.5), (1.5, 0.5)], team(2)) == (0, 7)


@pytest.mark.parametrize("yaw", [0.0, 0.3, -2.0, math.pi])
def test_explicit_starts_go_through_any_turn(yaw: float) -> None:
    plan = plan_of("....\n....\n....", origin=(3.0, -4.0, yaw), resolution=0.5)
    for cell in range(12):
        u, v = plan.lattice.position(cell)
        x = 3.0 + math.cos(yaw) * u - math.sin(yaw) * v
        y = -4.0 + math.sin(yaw) * u + math.cos(yaw) * v
        assert starts_at(plan, [(x, y)], team(1)) == (cell,)


@pytest.mark.parametrize(
    "point",
    [(-0.1, 0.5), (0.5, -0.1), (4.1, 0.5), (0.5, 3.1), (math.nan, 0.5), (math.inf, 0.5)],
)
def test_a_start_off_the_map(point: tuple[float, float]) -> None:
    plan = plan_of("....\n....\n....")
    with pytest.raises(InputError, match="off the map") as caught:
        starts_at(plan, [point], team(1))
    assert "robot_0" in caught.value.place
    assert "4 x 3 m" in caught.value.problem


def test_the_map_ends_where_it_ends() -> None:
    """Also where planning cells hang over its border or stop short of it."""
    over = plan_of("." * 11 + "\n" + "." * 11 + "\n" + "." * 11, cell=3.0)
    assert over.lattice.cols == 4  # the last one from 9 to 12
    assert starts_at(over, [(10.9, 1.5)], team(1)) == (3,)
    with pytest.raises(InputError, match="off the map"):
        starts_at(over, [(11.5, 1.5)], team(1))
    short = plan_of("." * 10 + "\n" + "." * 10 + "\n" + "." * 10, cell=3.0)
    assert short.lattice.cols == 3  # up to 9
    assert starts_at(short, [(8.9, 1.5)], team(1)) == (2,)
    # On the map, but in no planning cell: put into the nearest, or refused for what it is.
    try:
        cell = starts_at(short, [(9.5, 1.5)], team(1))[0]
    except InputError as error:
        told = error.problem
    else:
        told = f"cell {cell}"
    assert told == "cell 2" or "off the map" not in told


def test_a_start_in_a_wall_names_the_nearest_place() -> None:
    plan = plan_of("....\n.##.\n.##.\n....", origin=(100.0, 0.0, 0.0))
    with pytest.raises(InputError, match="in a wall") as caught:
        starts_at(plan, [(101.4, 1.6)], team(1))
    # From cell (1, 1) the free cells (0, 1) and (1, 0) are one away; the lower comes first.
    assert "101.50,0.50" in caught.value.remedy
    assert starts_at(plan, [(101.5, 0.5)], team(1)) == (1,)


def test_the_named_place_is_in_the_map_frame() -> None:
    origin = (5.0, 6.0, 0.7)
    plan = plan_of("##\n#.", origin=origin)
    cos, sin = math.cos(0.7), math.sin(0.7)

    def at(u: float, v: float) -> tuple[float, float]:
        return 5.0 + cos * u - sin * v, 6.0 + sin * u + cos * v

    with pytest.raises(InputError) as caught:
        starts_at(plan, [at(0.5, 1.5)], team(1))
    x, y = at(1.5, 0.5)
    assert f"{x:.2f},{y:.2f}" in caught.value.remedy


def test_a_start_too_near_a_wall() -> None:
    plan = plan_of("...\n...\n...", radius=0.6)
    with pytest.raises(InputError, match=r"too near one for a robot of radius 0\.6 m") as caught:
        starts_at(plan, [(0.5, 0.5)], team(1, 0.6))
    assert "1.50,1.50" in caught.value.remedy


def test_starts_too_near_each_other() -> None:
    plan = plan_of("....\n....")
    with pytest.raises(InputError, match="too near another robot") as caught:
        starts_at(plan, [(0.5, 0.5), (0.7, 0.3)], team(2))
    assert "robot_1" in caught.value.place
    fine = plan_of("......\n......\n......", cell=0.5, radius=0.4)
    assert len(starts_at(fine, [(1.25, 1.25), (2.25, 1.25)], team(2, 0.4))) == 2
    with pytest.raises(InputError, match="too near another robot"):
        starts_at(fine, [(1.25, 1.25), (1.75, 1.25)], team(2, 0.4))


@pytest.mark.parametrize("count", [0, 1, 3])
def test_a_point_for_each_robot(count: int) -> None:
    plan = plan_of("....\n....")
    with pytest.raises(InputError, match=f"{count} points for 2 robots"):
        starts_at(plan, [(i + 0.5, 0.5) for i in range(count)], team(2))


def test_nearest_standable() -> None:
    plan = plan_of("#####\n#####\n#.###\n###.#")
    assert nearest_standable(plan, 0) == 1 * 5 + 1
    assert nearest_standable(plan, 4) == 3
    assert nearest_standable(plan, 3) == 3
    with pytest.raises(InputError, match="no place"):
        nearest_standable(plan_of("##\n##"), 0)


def test_robots_may_start_in_different_parts() -> None:
    plan = plan_of("..#..")
    assert starts_at(plan, [(0.5, 0.5), (4.5, 0.5)], team(2)) == (0, 4)
