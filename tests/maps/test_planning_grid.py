"""Planning cells over a map, by hand; and the part of a map robots start in."""

from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.maps.ascii_art import parse_ascii
from conav.maps.occupancy_grid import FREE, OCCUPIED, OccupancyGrid
from conav.maps.planning_grid import (
    PlanningGrid,
    default_cell,
    default_start_area,
    planning_grid,
)
from conav.simulation.pibt import moves_conflict


@pytest.mark.parametrize(
    ("resolution", "radius", "cells"),
    [
        (0.05, 0.1, 6),  # 2.83 * 0.1 = 0.283 m
        (0.1, 0.1, 3),
        (1.0, 0.1, 1),
        (0.05, 0.0, 1),  # never less than the map's own cell
        (0.1, 0.3, 9),  # 0.849 m
        (0.05, 0.2, 12),  # 0.566 m
        (0.05, 0.15 / (2 * 2**0.5), 3),  # exactly 0.15 m
        (0.25, 0.35, 4),
    ],
)
def test_default_cell_by_hand(resolution: float, radius: float, cells: int) -> None:
    assert default_cell(resolution, radius) == pytest.approx(cells * resolution)


@settings(max_examples=100, deadline=None)
@given(st.floats(0.01, 2.0), st.floats(0.0, 3.0))
def test_in_the_default_cell_robots_follow_each_other_round_a_corner(
    resolution: float, radius: float
) -> None:
    cell = default_cell(resolution, radius)

    def corner_is_tight(cell: float) -> bool:
        gap = 2 * radius / cell
        # One leaves (0, 1) to the north while the other comes from (0, 0) to the east.
        return moves_conflict(0, 1, 1, 0, 0, 0, gap * gap)

    assert not corner_is_tight(cell)
    if cell > 1.5 * resolution:
        assert corner_is_tight(cell - resolution)  # and no smaller multiple would do


def grid(rows: int, cols: int, resolution: float = 1.0) -> OccupancyGrid:
    return OccupancyGrid(np.zeros((rows, cols), np.uint8), resolution)


@pytest.mark.parametrize(
    ("side", "cell", "fine", "planning"),
    [
        (3, 1.0, [0, 1, 2], [0, 1, 2]),
        # Centres 1.5, 4.5, 7.5; one at 10.5 would be off the map, so row 9 belongs to the last.
        (10, 3.0, [1, 4, 7], [0, 0, 0, 1, 1, 1, 2, 2, 2, 2]),
        # Centres 1.5, 4.5, 7.5, 10.5: the last cell hangs over the border.
        (11, 3.0, [1, 4, 7, 10], [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3]),
        # Centres on borders between fine cells belong to the upper one.
        (6, 2.0, [1, 3, 5], [0, 0, 1, 1, 2, 2]),
        # A centre exactly on the map's border does not count: 1 and not 3.
        (3, 2.0, [1], [0, 0, 0]),
        # Centres 0.85, 2.55, 4.25, 5.95.
        (7, 1.7, [0, 2, 4, 5], [0, 0, 1, 2, 2, 3, 3]),
        # Centres 0.25, 0.75, 1.25, 1.75; the middle of a fine cell lies on a border.
        (2, 0.5, [0, 0, 1, 1], [1, 3]),
        (4, 1 / 3, [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3], [1, 4, 7, 10]),
    ],
)
def test_where_planning_cells_lie(
    side: int, cell: float, fine: list[int], planning: list[int]
) -> None:
    for rows, cols in ((side, 5), (5, side)):
        lattice = planning_grid(grid(rows, cols), cell_m=cell).lattice
        along_rows = rows == side
        assert (lattice.fine_row if along_rows else lattice.fine_col).tolist() == fine
        assert (lattice.row_of if along_rows else lattice.col_of).tolist() == planning
        assert (lattice.rows if along_rows else lattice.cols) == len(fine)


@settings(max_examples=100, deadline=None)
@given(
    st.integers(1, 40), st.integers(1, 40), st.sampled_from([0.05, 0.1, 1.0]), st.floats(0.1, 7.0)
)
def test_every_centre_lies_on_the_map_and_none_is_left_out(
    rows: int, cols: int, resolution: float, ratio: float
) -> None:
    if ratio > 2 * min(rows, cols) - 1e-6:
        return
    lattice = planning_grid(grid(rows, cols, resolution), cell_m=ratio * resolution).lattice
    for count, fine, side in (
        (lattice.rows, lattice.fine_row, rows),
        (lattice.cols, lattice.fine_col, cols),
    ):
        assert (count - 0.5) * ratio < side + 1e-6
        assert (count + 0.5) * ratio > side - 1e-6
        assert fine.min() >= 0
        assert fine.max() < side
        assert all(a <= b for a, b in pairwise(fine.tolist()))
        for number, place in enumerate(fine.tolist()):
            assert place - 1e-6 <= (number + 0.5) * ratio <= place + 1 + 1e-6
    for of, count, side in (
        (lattice.row_of, lattice.rows, rows),
        (lattice.col_of, lattice.cols, cols),
    ):
        assert len(of) == side
        assert of.max() == count - 1 or ratio < 1
        for place, number in enumerate(of.tolist()):
            inside = number * ratio - 1e-6 <= place + 0.5 <= (number + 1) * ratio + 1e-6
            assert inside or (number == count - 1 and place + 0.5 > number * ratio)


def test_positions_and_cells_are_inverse() -> None:
    lattice = planning_grid(grid(10, 7, 0.1), cell_m=0.25).lattice
    assert (lattice.rows, lattice.cols) == (4, 3)
    for cell in range(12):
        assert lattice.cell_at(*lattice.position(cell)) == cell
    assert lattice.position(5) == pytest.approx((0.625, 0.375))
    for outside in ((-0.01, 0.1), (0.1, -0.01), (5.0, 0.1), (0.1, 5.0), (float("nan"), 0.1)):
        assert lattice.cell_at(*outside) == -1


def test_unknown_cells_are_walls() -> None:
    plan = planning_grid(parse_ascii("...\n.?.\n..."))
    same = planning_grid(parse_ascii("...\n.#.\n..."))
    assert plan.walls[1, 1] == OCCUPIED
    assert plan.standable.tolist() == [[1, 1, 1], [1, 0, 1], [1, 1, 1]]
    assert np.array_equal(plan.moves, same.moves)


def test_four_connected_teams_have_straight_moves_only() -> None:
    plan = planning_grid(grid(4, 4), diagonal=False)
    assert not (plan.moves & 0b1111_0000).any()
    assert (planning_grid(grid(4, 4)).moves & 0b1111_0000).any()


def test_the_arrays_are_locked() -> None:
    plan = planning_grid(grid(4, 4))
    lattice = plan.lattice
    for array in (
        plan.walls,
        plan.moves,
        plan.standable,
        plan.labels,
        lattice.fine_row,
        lattice.fine_col,
        lattice.row_of,
        lattice.col_of,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


@pytest.mark.parametrize("cell", [0.0, -1.0, float("nan"), float("inf")])
def test_a_cell_must_be_a_length(cell: float) -> None:
    with pytest.raises(InputError, match="--cell"):
        planning_grid(grid(4, 4), cell_m=cell)


@pytest.mark.parametrize("radius", [-0.1, float("nan"), float("inf")])
def test_a_radius_must_be_a_length(radius: float) -> None:
    with pytest.raises(InputError, match="--radius"):
        planning_grid(grid(4, 4), cell_m=1.0, radius_m=radius)


def test_a_cell_larger_than_the_map_is_refused() -> None:
    # Up to twice the map's side the first centre lies on the map.
    assert planning_grid(grid(4, 4), cell_m=7.9).lattice.rows == 1
    with pytest.raises(InputError, match="larger than the map") as caught:
        planning_grid(grid(4, 4), cell_m=8.0)
    assert "--cell" in caught.value.remedy
    with pytest.raises(InputError, match="larger than the map"):
        planning_grid(grid(40, 4), cell_m=9.0)  # one direction is enough


def test_absurdly_many_cells_are_refused() -> None:
    with pytest.raises(InputError, match="planning cells"):
        planning_grid(grid(4, 4), cell_m=1e-6)


ISLAND = """
.......
.#####.
.#...#.
.#...#.
.#####.
.......
"""


def area_cells(plan: PlanningGrid, *, outside: bool = False) -> tuple[set[int], tuple[str, ...]]:
    area = default_start_area(plan, outside=outside)
    cells = area.cells.tolist()
    assert cells == sorted(set(cells))
    assert set(cells) == set(np.flatnonzero(plan.labels == area.label).tolist())
    return set(cells), area.warnings


def test_robots_start_inside_where_the_outside_is_drawn_free() -> None:
    plan = planning_grid(parse_ascii(ISLAND))
    cells, warnings = area_cells(plan)
    assert cells == {row * 7 + col for row in (2, 3) for col in (2, 3, 4)}
    assert len(warnings) == 1
    assert "--outside" in warnings[0]
    # 22 cells outside, 6 inside.
    assert "79 %" in warnings[0]
    assert "21 %" in warnings[0]


def test_outside_keeps_the_largest_part() -> None:
    plan = planning_grid(parse_ascii(ISLAND))
    cells, warnings = area_cells(plan, outside=True)
    assert len(cells) == 22
    assert 0 in cells
    assert warnings == ()


def test_a_tiny_part_inside_is_no_building() -> None:
    # 1 of 25 cells inside: a pillar's hollow.
    picture = "......\n.###..\n.#.#..\n.###..\n......"
    cells, warnings = area_cells(planning_grid(parse_ascii(picture)))
    assert len(cells) == 21
    assert warnings == ()
    # Two of 20 is exactly a tenth, which is enough.
    exactly = "......\n.####.\n.#..#.\n.####.\n......"
    assert parse_ascii(exactly).area_m2(FREE) == 20
    cells, warnings = area_cells(planning_grid(parse_ascii(exactly)))
    assert len(cells) == 2
    assert len(warnings) == 1


def test_an_ordinary_map_starts_in_its_largest_part() -> None:
    picture = "########\n#..#...#\n#..#...#\n########"
    cells, warnings = area_cells(planning_grid(parse_ascii(picture)))
    assert cells == {row * 8 + col for row in (1, 2) for col in (4, 5, 6)}
    assert warnings == ()


def test_a_map_open_to_its_border_without_an_inside() -> None:
    cells, warnings = area_cells(planning_grid(grid(3, 3)))
    assert len(cells) == 9
    assert warnings == ()


def test_a_disc_that_cannot_come_near_the_border_still_counts_as_outside() -> None:
    # Three fine cells a letter; a disc of radius 1.4 keeps its centre off the border itself.
    big = "\n".join(
        "".join(letter * 3 for letter in row) for row in ISLAND.split() for _ in range(3)
    )
    plan = planning_grid(parse_ascii(big), cell_m=1.0, radius_m=1.4)
    cells, warnings = area_cells(plan)
    assert warnings
    rows, cols = np.divmod(np.array(sorted(cells)), plan.lattice.cols)
    assert rows.min() >= 6
    assert rows.max() < 12
    assert cols.min() >= 6
    assert cols.max() < 15


def test_no_free_cell_at_all() -> None:
    with pytest.raises(InputError, match="no free cell"):
        default_start_area(planning_grid(parse_ascii("##\n#?")))


def test_no_room_for_the_robot() -> None:
    with pytest.raises(InputError, match=r"radius 0\.8 m fits"):
        default_start_area(planning_grid(parse_ascii("#.#\n#.#"), cell_m=1.0, radius_m=0.8))


@settings(max_examples=50, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([(0.05, 0.1), (0.05, 0.0), (0.1, 0.3), (1.0, 0.1)]),
)
def test_parts_are_joined_by_moves(seed: int, lengths: tuple[float, float]) -> None:
    rng = np.random.default_rng(seed)
    cells = (rng.random((30, 25)) < 0.08).astype(np.uint8)
    plan = planning_grid(OccupancyGrid(cells, lengths[0]), radius_m=lengths[1])
    assert np.array_equal(plan.labels >= 0, plan.standable == 1)
    for row, col, (k, dr, dc) in product(
        range(plan.lattice.rows), range(plan.lattice.cols), ((0, 0, 1), (1, 1, 0), (4, 1, 1))
    ):
        if plan.moves[row, col] >> k & 1:
            assert plan.labels[row, col] == plan.labels[row + dr, col + dc]
