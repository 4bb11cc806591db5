"""Sight against a slow twin that follows the definition, and against hand-drawn cases."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conav.exploration import verify_sight
from conav.geometry.sight import (
    disc_cells,
    lateral_limits,
    new_gap_space,
    segment_is_clear,
    sight_buffer_size,
    visible_cells,
)
from conav.maps.ascii_art import parse_ascii


def view(cells: np.ndarray, row: int, col: int, range_cells: float) -> set[int]:
    limits = lateral_limits(range_cells)
    out = np.zeros(sight_buffer_size(limits), np.int32)
    count = visible_cells(
        cells, row, col, limits, new_gap_space(limits), new_gap_space(limits), out
    )
    return set(out[:count].tolist())


def seen_by_definition(cells: np.ndarray, r: int, c: int, r2: int, c2: int) -> bool:
    """Corners of every wall against the line, one by one, in integers."""
    left = right = False
    dr, dc = r2 - r, c2 - c
    for wr in range(min(r, r2), max(r, r2) + 1):
        for wc in range(min(c, c2), max(c, c2) + 1):
            if cells[wr, wc] != 1:
                continue
            corners = [(2 * (wr - r) + a, 2 * (wc - c) + b) for a in (-1, 1) for b in (-1, 1)]
            sides = [dc * a - dr * b for a, b in corners]
            if min(sides) < 0 < max(sides):
                return False
            left |= max(sides) == 0
            right |= min(sides) == 0
    return not (left and right)


grids = st.tuples(st.integers(1, 12), st.integers(1, 12)).flatmap(
    lambda shape: st.tuples(
        arrays(np.uint8, shape, elements=st.sampled_from([0, 0, 0, 1])),
        st.integers(0, shape[0] - 1),
        st.integers(0, shape[1] - 1),
    )
)


@settings(max_examples=150, deadline=None)
@given(grids, st.sampled_from([1.0, 2.5, 4.0, 30.0]))
def test_sight_equals_its_definition(grid: tuple[np.ndarray, int, int], reach: float) -> None:
    cells, r, c = grid
    cells[r, c] = 0
    seen = view(cells, r, c, reach)
    for r2 in range(cells.shape[0]):
        for c2 in range(cells.shape[1]):
            if cells[r2, c2] == 1:
                continue
            near = (r - r2) ** 2 + (c - c2) ** 2 <= reach * reach
            clear = (r, c) == (r2, c2) or seen_by_definition(cells, r, c, r2, c2)
            assert (r2 * cells.shape[1] + c2 in seen) == (near and clear)


@settings(max_examples=150, deadline=None)
@given(grids)
def test_all_ways_to_sight_agree(grid: tuple[np.ndarray, int, int]) -> None:
    """Shadow casting, walking the segment, and the verifier's rows, shades and whole view."""
    cells, r, c = grid
    cells[r, c] = 0
    seen = view(cells, r, c, 30.0)
    nothing, marks = np.zeros_like(cells), np.zeros_like(cells)
    missed, fresh = verify_sight.look_around(
        cells, nothing, 1, nothing, marks, 4, nothing + 1, r, c, 900.0, True
    )
    assert set(np.flatnonzero(marks == 4).tolist()) == seen
    assert missed == fresh == len(seen)
    for r2 in range(cells.shape[0]):
        for c2 in range(cells.shape[1]):
            if (r, c) == (r2, c2):
                continue
            shown = r2 * cells.shape[1] + c2 in seen
            if cells[r2, c2] == 0:
                assert segment_is_clear(cells, r, c, r2, c2) == shown
                assert verify_sight.free_cell_seen(cells, r, c, r2, c2) == shown
            else:
                assert verify_sight.wall_seen(cells, r, c, r2, c2) == shown


@settings(max_examples=60, deadline=None)
@given(grids)
def test_sight_is_mutual(grid: tuple[np.ndarray, int, int]) -> None:
    cells, r, c = grid
    cells[r, c] = 0
    cols = cells.shape[1]
    for index in view(cells, r, c, 30.0):
        r2, c2 = divmod(index, cols)
        if cells[r2, c2] == 0:
            assert r * cols + c in view(cells, r2, c2, 30.0)


@pytest.mark.parametrize(
    ("picture", "expected"),
    [
        # A diagonal wall one cell thick does not leak.
        ("....#\n...#.\n..#..\n.#...\n#....", False),
        (".....\n.....\n..#..\n.....\n.....", False),
        # Grazing corners on one side is allowed, on both sides it is not.
        (".....\n....#\n...#.\n.....\n.....", True),
        (".....\n..#.#\n.....\n.....\n.....", False),
        (".....\n....#\n.#...\n.....\n.....", False),
    ],
)
def test_from_corner_to_corner(picture: str, expected: bool) -> None:
    cells = parse_ascii(picture).cells
    assert (24 in view(cells, 0, 0, 30.0)) == expected


def test_walls_hide_each_other() -> None:
    cells = parse_ascii("..##\n..##\n....").cells
    seen = view(cells, 0, 0, 10.0)
    assert {1 * 4 + 2, 2 * 4 + 2} <= seen  # the near faces
    assert 2 * 4 + 3 not in seen  # the block's far corner


def test_disc_has_the_cells_within_range() -> None:
    cells = np.ones((9, 9), np.uint8)
    limits = lateral_limits(2.0)
    out = np.zeros(sight_buffer_size(limits), np.int32)
    count = disc_cells(cells, 4, 4, limits, out)
    assert count == 13  # by hand: 1 + 3 + 5 + 3 + 1
    assert count == len(set(out[:count].tolist()))


@pytest.mark.parametrize("reach", [0.0, 1.0, 1.5, 2.0, 5.0, 7.3])
def test_lateral_limits_are_the_discs_rows(reach: float) -> None:
    limits = lateral_limits(reach)
    for d, c in enumerate(limits):
        assert d * d + c * c <= reach * reach
        assert d * d + (c + 1) ** 2 > reach * reach
