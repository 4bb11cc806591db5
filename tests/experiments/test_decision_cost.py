"""The study of section 3.1: the three ways agree, and counters are what they must be."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.experiments.decision_cost import (
    Knowledge,
    by_kept_numbers,
    by_packed_rows,
    by_squares,
    cost_by_map_size,
    cost_by_range,
    decision_cost,
    knowledge,
)
from conav.experiments.decision_kernels import lower, packed_gains, packed_rows
from conav.experiments.detection_cost import AREAS, detection, detection_by_area, explored_area
from conav.experiments.timing import fit_power
from conav.exploration.turn_sequences import BLOCKED
from conav.geometry.directions import DCOL, DROW
from conav.geometry.sight import lateral_limits
from conav.maps.occupancy_grid import FREE, OCCUPIED, UNKNOWN


def known(side: int, s_range: int, decisions: int, seed: int, roam: int | None = None) -> Knowledge:
    return knowledge(side, roam or side, s_range, decisions, np.random.default_rng(seed))


def plain_gains(
    cells: np.ndarray, row: int, col: int, heading: int, bits: int, s_range: float
) -> list[int]:
    """The sum of h in (17) for each sequence, point by point over the whole map."""
    rows, cols = cells.shape
    gains: list[int] = []
    for turn in range(4):
        k = (heading + turn) % 4
        if not bits >> k & 1:
            gains.append(BLOCKED)
            continue
        places = [(row + DROW[k], col + DCOL[k])]
        r, c = row + 2 * DROW[k], col + 2 * DCOL[k]
        if turn == 0 and 0 <= r < rows and 0 <= c < cols and cells[r, c] != OCCUPIED:
            places.append((r, c))
        gains.append(
            sum(
                cells[p] == UNKNOWN
                and any((p[0] - r) ** 2 + (p[1] - c) ** 2 <= s_range**2 for r, c in places)
                for p in product(range(rows), range(cols))
            )
        )
    return gains


# --- decisions --------------------------------------------------------------------------------


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1.0, 1.5, 2.0, 3.0, 5.0, 7.3, 40.0]))
def test_packed_rows_count_what_17_counts(seed: int, s_range: float) -> None:
    """At borders and obstacles too, and on maps of several words a row."""
    rng = np.random.default_rng(seed)
    rows, cols = int(rng.integers(1, 12)), int(rng.integers(1, rng.choice([12, 200])))
    cells = rng.choice([FREE, OCCUPIED, UNKNOWN], (rows, cols), p=[0.4, 0.1, 0.5]).astype(np.uint8)
    row, col, heading = (int(rng.integers(n)) for n in (rows, cols, 4))
    bits = 0
    for k in range(4):
        r, c = row + DROW[k], col + DCOL[k]
        if 0 <= r < rows and 0 <= c < cols and rng.random() < 0.8:
            cells[r, c] = FREE
            bits |= 1 << k
    gains = np.empty(4, np.int64)
    limits = lateral_limits(min(s_range, rows + cols))
    words = packed_gains(
        packed_rows(cells == UNKNOWN), cells, row, col, heading, bits, limits, gains
    )
    assert gains.tolist() == plain_gains(cells, row, col, heading, bits, s_range)
    assert (words > 0) == (bits > 0)


@pytest.mark.parametrize("s_range", [1, 2, 5, 9])
def test_the_three_ways_agree(s_range: int) -> None:
    for seed in range(3):
        at = known(90, s_range, 150, seed)
        squares = by_squares(at).gains
        assert np.array_equal(by_packed_rows(at).gains, squares)
        assert np.array_equal(by_kept_numbers(at).gains, squares)
        assert squares.max() > squares.min() >= 0
        for place, gains in zip(at.places[:5].tolist(), squares.tolist(), strict=False):
            assert gains == plain_gains(at.cells, *place, 0b1111, s_range)


def test_half_of_a_map_is_known() -> None:
    assert 0.4 < np.mean(known(200, 2, 100, 1).cells == UNKNOWN) < 0.6


@pytest.mark.parametrize("s_range", [1, 2, 4])
def test_lowering_keeps_the_numbers_right(s_range: int) -> None:
    at = known(40, s_range, 10, 3)
    pad, width, disc, _ = at.shape
    unknown = np.flatnonzero(at.unknown)[::7]
    left = at.left.copy()
    lower(left, unknown.astype(np.uint64), disc)
    now = at.unknown.reshape(-1, width).copy()
    now.flat[unknown] = 0
    places = left.reshape(-1, width)
    for r, c in product(range(pad, pad + 40, 3), range(pad, pad + 40)):
        around = sum(
            int(now[r + dr, c + dc])
            for dr, dc in product(range(-s_range, s_range + 1), repeat=2)
            if dr * dr + dc * dc <= s_range * s_range
        )
        assert places[r, c] == around


def test_counters_of_a_decision_by_hand() -> None:
    row = decision_cost(60, 1, 50, 0.0)
    # Five squares of 8 points; a baseline of 3 or 4 rows and three discs of 3, a word each unless
    # it lies across two; five numbers and a crescent of 3; the disc of 5 points.
    assert row.points == row.expected_points == 40
    assert 12 <= row.words <= 13
    assert (row.kept, row.lowered) == (8, 5)


def test_points_are_those_of_the_paper() -> None:
    rows = cost_by_range((1, 2, 3, 8, 20), side=70, decisions=40, budget_s=0.0)
    for row in rows:
        s = row.s_range
        assert row.points == 20 * (s * s + s)
        assert row.kept == 5 + 2 * s + 1
        assert row.lowered == sum(
            a * a + b * b <= s * s for a, b in product(range(-s, s + 1), repeat=2)
        )
        # 4 discs of 2 s + 1 rows, one more where the second disc lies above or below the first.
        assert 4 * (2 * s + 1) <= row.words <= 2 * (4 * (2 * s + 1) + 1)


def test_every_decision_away_from_borders_checks_as_many_points() -> None:
    for seed in range(3):
        at = known(60, 4, 100, seed)
        assert set(by_squares(at).looked.tolist()) == {20 * (4 * 4 + 4)}


def test_points_do_not_depend_on_the_map() -> None:
    told: list[str] = []
    rows = cost_by_map_size(
        (40, 100, 300), (2, 5), decisions=30, budget_s=0.0, progress=told.append
    )
    assert [(row.s_range, row.side) for row in rows] == [
        (s, side) for s in (2, 5) for side in (40, 100, 300)
    ]
    for work, expected in (("points", (120, 600)), ("kept", (10, 16))):
        assert [getattr(row, work) for row in rows] == [n for n in expected for _ in range(3)]
    assert len({row.words for row in rows}) == 2
    assert told[0] == "decisions with sRange 2 on 40 x 40 points"
    assert len(told) == 6


def test_decisions_are_the_same_on_maps_of_all_sizes() -> None:
    small, large = (known(side, 5, 80, 2, 40) for side in (40, 250))
    assert np.array_equal(large.places, small.places + np.array([64, 64, 0]))
    for way in (by_squares, by_packed_rows, by_kept_numbers):
        assert np.array_equal(way(small).gains, way(large).gains)
        assert np.array_equal(way(small).looked, way(large).looked)


def test_a_map_without_room_is_refused() -> None:
    with pytest.raises(ValueError, match="no room"):
        known(24, 5, 10, 1)
    assert len(known(25, 5, 10, 1).places) == 10


def test_break_even() -> None:
    row = decision_cost(60, 1, 50, 0.0)._replace(kept_us=1.0, lowered_us=0.5)
    assert row.break_even(11.0) == 20.0


# --- frontier detection -----------------------------------------------------------------------


@pytest.mark.parametrize("name", AREAS)
@pytest.mark.parametrize("side", [32, 64, 101])
def test_areas_are_explored_within_their_border(name: str, side: int) -> None:
    area = explored_area(name, side)
    assert area.cells.shape == area.moves.shape == (side, side)
    assert area.cells.flat[area.start] == FREE
    inner = np.zeros((side, side), np.bool_)
    inner[1:-1, 1:-1] = True
    assert not (area.cells[~inner] == FREE).any()
    row = detection(name, side, budget_s=0.0)
    assert row.explored == (area.cells == FREE).sum()
    assert row.searched == row.explored
    assert row.touched == row.sweeps * row.explored
    assert row.back_touched == row.back_sweeps * row.explored
    beside = np.zeros((side, side), np.bool_)
    unknown = np.pad(area.cells == UNKNOWN, 1)
    for r, c in ((0, 1), (2, 1), (1, 0), (1, 2)):
        beside |= unknown[r : r + side, c : c + side]
    assert row.frontier == (beside & (area.cells == FREE)).sum()


def test_an_open_square_by_hand() -> None:
    row = detection("open", 13, budget_s=0.0)
    # 11 x 11 cells around the robot: 5 rows against the raster, and a sweep to no avail.
    assert (row.explored, row.sweeps, row.frontier) == (121, 6, 40)
    assert row.back_sweeps == 3


def test_a_winding_corridor_by_hand() -> None:
    row = detection("winding", 10, budget_s=0.0)
    # Four rows of 8 cells and three cells between. Two rows lead to the left, a cell a sweep but
    # for their first, to which the cell below takes the sweep; one more sweep finds nothing.
    assert row.explored == 4 * 8 + 3
    assert row.sweeps == 1 + 2 * 7 + 1


def test_exponents() -> None:
    """With the side on open maps, up to a square on winding ones: sweeps grow with the detours."""
    fits = {
        name: [
            fit_power([r.explored for r in rows], [getattr(r, work) for r in rows]).exponent
            for work in ("touched", "back_touched")
        ]
        for name in ("open", "blocks", "winding")
        for rows in [detection_by_area(name, (24, 48, 96), budget_s=0.0)]
    }
    assert fits["open"][0] == pytest.approx(1.5, abs=0.05)
    assert fits["blocks"][0] == pytest.approx(1.5, abs=0.1)
    assert fits["winding"][0] == pytest.approx(2.0, abs=0.05)
    assert fits["open"][1] == pytest.approx(1.0, abs=0.01)
    assert fits["winding"][1] == pytest.approx(1.5, abs=0.05)


def test_detection_ends_when_it_takes_long() -> None:
    told: list[str] = []
    rows = detection_by_area("maze", (32, 64), budget_s=0.0, limit_s=0.0, progress=told.append)
    assert [row.side for row in rows] == [32]
    assert told == [
        "frontier detection in maze, 32 x 32 cells",
        "maze ends here: a detection took over 0 s",
    ]


def test_an_unknown_area_is_refused() -> None:
    with pytest.raises(ValueError, match="'garden'"):
        explored_area("garden", 32)


def test_a_power_law_is_found() -> None:
    fit = fit_power([1, 2, 4, 100], [3 * x**1.7 for x in (1, 2, 4, 100)])
    assert fit == pytest.approx((1.7, 3.0))
