"""Clearance against a slow twin in whole numbers, and against hand-drawn cases."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage

from conav.geometry.clearance import (
    capsule_is_free,
    capsule_is_known,
    components,
    free_moves,
    point_segment_square,
)
from conav.geometry.directions import DCOL, DROW, OPPOSITE
from conav.maps.ascii_art import parse_ascii

UNIT = 40  # twins count in fortieths of a pixel, so everything is a whole number
UNKNOWN = 2


def touches(wall: tuple[int, int], a: tuple[int, int], b: tuple[int, int], radius: int) -> bool:
    """Whether a disc swept from a to b (x, y; straight or diagonal) touches a pixel (row, col)."""
    left, low = wall[1] * UNIT, wall[0] * UNIT
    corners = [(left + i, low + j) for i in (0, UNIT) for j in (0, UNIT)]
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = dx * dx + dy * dy
    for x, y in (a, b):  # ends against the square
        gx = max(left - x, 0, x - left - UNIT)
        gy = max(low - y, 0, y - low - UNIT)
        if gx * gx + gy * gy < radius * radius:
            return True
    sides = []
    for x, y in corners:  # corners against the segment
        along = (x - a[0]) * dx + (y - a[1]) * dy
        cross = (x - a[0]) * dy - (y - a[1]) * dx
        if 0 <= along <= length and cross * cross < radius * radius * length:
            return True
        sides.append(cross)
    # The segment through the square: no axis separates them.
    return (
        min(sides) <= 0 <= max(sides)
        and min(a[0], b[0]) <= left + UNIT
        and max(a[0], b[0]) >= left
        and min(a[1], b[1]) <= low + UNIT
        and max(a[1], b[1]) >= low
    )


def fits(cells: np.ndarray, a: tuple[int, int], b: tuple[int, int], radius: int) -> bool:
    rows, cols = cells.shape
    inside = all(
        radius <= x <= cols * UNIT - radius and radius <= y <= rows * UNIT - radius
        for x, y in (a, b)
    )
    return inside and not any(
        touches((r, c), a, b, radius) for r, c in product(range(rows), range(cols)) if cells[r, c]
    )


def centre(r: int, c: int, ratio: int) -> tuple[int, int]:
    """The centre x, y of a planning cell; `ratio` in units too."""
    assert ratio % 2 == 0
    return (2 * c + 1) * ratio // 2, (2 * r + 1) * ratio // 2


def moves_by_definition(
    cells: np.ndarray, rows: int, cols: int, ratio: int, radius: int
) -> np.ndarray:
    result = np.zeros((rows, cols, 2), np.uint8)
    for r, c in product(range(rows), range(cols)):
        here = centre(r, c, ratio)
        result[r, c, 0] = fits(cells, here, here, radius)
    for r, c, k in product(range(rows), range(cols), range(8)):
        r2, c2 = r + DROW[k], c + DCOL[k]
        if not (0 <= r2 < rows and 0 <= c2 < cols):
            continue
        stands = result[r, c, 0] and result[r2, c2, 0]
        corners = result[r2, c, 0] and result[r, c2, 0]
        swept = fits(cells, centre(r, c, ratio), centre(r2, c2, ratio), radius)
        if stands and corners and swept:
            result[r, c, 1] |= 1 << k
    return result


def counts(cells: np.ndarray, ratio: float) -> tuple[int, int]:
    """How many rows and columns of planning cells have their centre on the map."""
    rows, cols = (int(np.ceil(side / ratio - 0.5 - 1e-9)) for side in cells.shape)
    return rows, cols


grids = st.tuples(st.integers(1, 9), st.integers(1, 9)).flatmap(
    lambda shape: arrays(np.uint8, shape, elements=st.sampled_from([0, 0, 0, 0, 0, 1]))
)


# These ratios and radii are exact in binary, so discs that touch a wall exactly are decided too.
@settings(max_examples=60, deadline=None)
@given(
    grids,
    st.sampled_from([0.5, 1.0, 1.5, 2.0, 3.0]),
    st.sampled_from([0.125, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0]),
)
def test_moves_equal_their_definition(cells: np.ndarray, ratio: float, radius: float) -> None:
    rows, cols = counts(cells, ratio)
    if rows < 1 or cols < 1:
        return
    expected = moves_by_definition(cells, rows, cols, int(ratio * UNIT), int(radius * UNIT))
    assert np.array_equal(free_moves(cells, rows, cols, ratio, radius), expected)


@pytest.mark.parametrize(
    ("ratio", "radius"),
    [
        ((0.30000000000000004 / 0.05, 240), (0.1 / 0.05, 80)),  # the default on many real maps
        ((0.3 / 0.05, 240), (0.1 / 0.05, 80)),
        ((0.3 / 0.05, 240), (0.15 / 0.05, 120)),
        ((1.7, 68), (0.85, 34)),
    ],
)
def test_rounding_does_not_decide_where_a_disc_just_fits(
    ratio: tuple[float, int], radius: tuple[float, int]
) -> None:
    """A disc that exactly touches a wall fits, also where lengths are no round binary numbers.

    The default cell of 0.3 m on a map of 0.05 m has centres at whole pixels, so with a radius of
    0.1 m this is the usual case and not a rare one.
    """
    rng = np.random.default_rng(1)
    for _ in range(8):
        cells = (rng.random((19, 17)) < 0.1).astype(np.uint8)
        rows, cols = counts(cells, ratio[0])
        expected = moves_by_definition(cells, rows, cols, ratio[1], radius[1])
        assert np.array_equal(free_moves(cells, rows, cols, ratio[0], radius[0]), expected)


@settings(max_examples=40, deadline=None)
@given(grids, st.sampled_from([0.5, 1.0, 1.7, 3.0]), st.sampled_from([0.3, 0.6, 1.1]))
def test_every_move_can_be_taken_back(cells: np.ndarray, ratio: float, radius: float) -> None:
    rows, cols = counts(cells, ratio)
    if rows < 1 or cols < 1:
        return
    both = free_moves(cells, rows, cols, ratio, radius)
    for r, c, k in product(range(rows), range(cols), range(8)):
        if both[r, c, 1] >> k & 1:
            r2, c2 = r + DROW[k], c + DCOL[k]
            assert both[r, c, 0] == both[r2, c2, 0] == 1
            assert both[r2, c2, 1] >> OPPOSITE[k] & 1


def bits(*directions: int) -> int:
    return sum(1 << k for k in directions)


def test_moves_by_hand() -> None:
    # Row 0 is the bottom: a wall stands above the right cell.
    cells = parse_ascii(".#\n..").cells
    both = free_moves(cells, 2, 2, 1.0, 0.1)
    assert both[:, :, 0].tolist() == [[1, 1], [1, 0]]
    assert both[:, :, 1].tolist() == [[bits(0, 1), bits(2)], [bits(3), 0]]


@pytest.mark.parametrize("picture", [".#\n#.", ".#\n..", "..\n#."])
def test_no_corner_is_cut(picture: str) -> None:
    cells = parse_ascii(picture).cells
    both = free_moves(cells, 2, 2, 1.0, 1e-3)
    assert not (both[:, :, 1] & 0b1111_0000).any()


def test_a_thin_wall_between_two_centres_stops_the_move() -> None:
    # Cells three pixels wide; one column of wall pixels lies between the two centres.
    cells = parse_ascii("..#...\n..#...\n..#...").cells
    both = free_moves(cells, 1, 2, 3.0, 0.4)
    assert both[:, :, 0].tolist() == [[1, 1]]
    assert both[:, :, 1].tolist() == [[0, 0]]


def test_the_disc_stays_on_the_map() -> None:
    cells = np.zeros((3, 3), np.uint8)
    assert free_moves(cells, 3, 3, 1.0, 0.5)[:, :, 0].all()
    only_middle = free_moves(cells, 3, 3, 1.0, 0.51)[:, :, 0]
    assert only_middle.tolist() == [[0, 0, 0], [0, 1, 0], [0, 0, 0]]
    assert not free_moves(cells, 3, 3, 1.0, 1.51)[:, :, 0].any()


def test_unknown_pixels_stop_a_disc() -> None:
    cells = np.zeros((1, 3), np.uint8)
    cells[0, 2] = UNKNOWN
    assert capsule_is_free(cells, 0.5, 0.5, 1.5, 0.5, 0.5)
    assert not capsule_is_free(cells, 0.5, 0.5, 1.6, 0.5, 0.5)


@settings(max_examples=150, deadline=None)
@given(
    grids,
    st.integers(0, 60),
    st.integers(0, 60),
    st.sampled_from([(0, 0), (8, 0), (0, 8), (-8, 0), (8, 8), (8, -8), (-24, 24)]),
    st.sampled_from([1, 3, 5, 8, 12]),
)
def test_a_capsule_is_free_by_definition(
    cells: np.ndarray, x: int, y: int, step: tuple[int, int], radius: int
) -> None:
    """Anywhere on and off the map, in eighths of a pixel."""
    a, b = (x, y), (x + step[0], y + step[1])
    fifths = UNIT // 8
    expected = fits(
        cells, (a[0] * fifths, a[1] * fifths), (b[0] * fifths, b[1] * fifths), radius * fifths
    )
    got = capsule_is_free(cells, a[0] / 8, a[1] / 8, b[0] / 8, b[1] / 8, radius / 8)
    assert got == expected


@settings(max_examples=100, deadline=None)
@given(
    st.tuples(st.integers(1, 7), st.integers(1, 7)).flatmap(
        lambda shape: arrays(np.uint8, shape, elements=st.sampled_from([0, 1, UNKNOWN]))
    ),
    st.integers(0, 28),
    st.integers(0, 28),
    st.sampled_from([(0, 0), (4, 0), (0, -4), (4, 4), (-4, 4)]),
    st.sampled_from([0.25, 0.5, 1.0, 1.75]),
)
def test_a_capsule_is_known_by_definition(
    belief: np.ndarray, x: int, y: int, step: tuple[int, int], radius: float
) -> None:
    """All unknown centres against a thousand places along the way."""
    ax, ay, bx, by = x / 4, y / 4, (x + step[0]) / 4, (y + step[1]) / 4
    t = np.linspace(0.0, 1.0, 1025)
    known = True
    for r, c in np.argwhere(belief == UNKNOWN):
        gap = (ax + t * (bx - ax) - c - 0.5) ** 2 + (ay + t * (by - ay) - r - 0.5) ** 2
        known &= bool(gap.min() > radius * radius)
    assert capsule_is_known(belief, UNKNOWN, ax, ay, bx, by, radius) == known


def test_distance_to_a_segment_by_hand() -> None:
    assert point_segment_square(0.0, 3.0, -1.0, 0.0, 1.0, 0.0) == 9.0
    assert point_segment_square(4.0, 4.0, 0.0, 0.0, 1.0, 0.0) == 25.0
    assert point_segment_square(-3.0, 4.0, 0.0, 0.0, 0.0, 0.0) == 25.0
    assert point_segment_square(0.0, 2.0, 0.0, 0.0, 2.0, 2.0) == 2.0


@settings(max_examples=60, deadline=None)
@given(grids, st.sampled_from([1.0, 2.0]))
def test_parts_are_those_of_a_plain_labelling(cells: np.ndarray, ratio: float) -> None:
    rows, cols = counts(cells, ratio)
    if rows < 1 or cols < 1:
        return
    both = free_moves(cells, rows, cols, ratio, 0.1)
    standable = np.ascontiguousarray(both[:, :, 0])
    straight = np.ascontiguousarray(both[:, :, 1]) & 0b1111
    labels = components(straight, standable)
    assert np.array_equal(labels >= 0, standable == 1)
    if ratio == 1.0:
        expected, count = ndimage.label(standable)
        pairs = set(
            zip(labels[standable == 1].tolist(), expected[standable == 1].tolist(), strict=True)
        )
        assert len(pairs) == count == int(labels.max()) + 1
    seen = labels[labels >= 0]
    if len(seen):
        # Numbered from 0 by each part's first cell, row by row.
        firsts = [int(np.argmax(seen == label)) for label in range(int(seen.max()) + 1)]
        assert firsts == sorted(firsts)


def test_parts_meet_only_over_moves() -> None:
    cells = parse_ascii("..#\n..#\n#..").cells
    both = free_moves(cells, 3, 3, 1.0, 0.1)
    standable = np.ascontiguousarray(both[:, :, 0])
    labels = components(np.ascontiguousarray(both[:, :, 1]), standable)
    assert labels.tolist() == [[-1, 0, 0], [0, 0, -1], [0, 0, -1]]
    cells = parse_ascii(".#\n#.").cells  # touching at a corner is no way through
    both = free_moves(cells, 2, 2, 1.0, 0.1)
    labels = components(np.ascontiguousarray(both[:, :, 1]), np.ascontiguousarray(both[:, :, 0]))
    assert labels.tolist() == [[-1, 0], [1, -1]]
