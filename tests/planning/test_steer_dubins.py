"""Dubins cars: words by hand, ends met, and no random drive that gets there is shorter."""

from math import cos, hypot, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.planning.piece import state_on_piece
from conav.planning.steer_dubins import (
    LRL,
    LSL,
    LSR,
    PIECES,
    RSL,
    RSR,
    connect_dubins,
    least_duration,
    shortest_word,
    word_lengths,
)
from conav.planning.trajectory import gaps, length
from conav.planning.types import PIECE, Trajectory

RADIUS = 0.7
LIMITS = np.array([1.2, RADIUS])

places = st.floats(-5, 5)
angles = st.floats(-7, 7)
states = st.tuples(places, places, angles)


def steer(a: tuple[float, ...], b: tuple[float, ...], duration: float) -> np.ndarray:
    rows = np.array([[a[0], a[1], 1.0, a[2]], [b[0], b[1], 1.0 + duration, b[2]]])
    pieces = np.full((PIECES, PIECE), np.nan)
    return pieces[: connect_dubins(LIMITS, rows, 0, 1, pieces)]


@settings(max_examples=400, deadline=None)
@given(states, states, st.just(0.0) | st.floats(1e-3, 10))
def test_ends_are_met(a: tuple[float, ...], b: tuple[float, ...], longer: float) -> None:
    _, *metres = shortest_word(*a, *b, RADIUS)
    duration = sum(metres) / LIMITS[0] * (1 + 1e-9) + longer
    if duration < 1e-5:
        return
    pieces = steer(a, b, duration)
    assert len(pieces) > 0
    assert pieces[0, 0] == 1.0
    assert pieces[-1, 1] == 1.0 + duration
    assert (np.diff(pieces[:, :2], axis=1) > 0).all()
    assert tuple(pieces[0, 2:4]) == a[:2]
    x, y, vx, vy = state_on_piece(pieces[-1], pieces[-1, 1])
    assert (x, y) == pytest.approx(b[:2], abs=1e-9)
    assert np.abs(gaps(Trajectory(pieces))).max(initial=0.0) < 1e-9
    speeds = np.hypot(pieces[:, 4], pieces[:, 5])
    assert speeds == pytest.approx(np.full(len(pieces), sum(metres) / duration), abs=1e-9)
    assert speeds.max() <= LIMITS[0] * (1 + 1e-9)
    assert length(Trajectory(pieces)) == pytest.approx(sum(metres), abs=1e-9)
    if speeds[0] > 1e-6:
        assert (vx, vy) == pytest.approx((speeds[0] * cos(b[2]), speeds[0] * sin(b[2])), abs=1e-9)
        turning = pieces[pieces[:, 8] != 0]
        radii = np.hypot(turning[:, 4], turning[:, 5]) / np.abs(turning[:, 8])
        assert radii == pytest.approx(np.full(len(radii), RADIUS), rel=1e-9)


@settings(max_examples=100, deadline=None)
@given(states, states)
def test_not_in_less_time(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    rows = np.array([[a[0], a[1], 0.0, a[2]], [b[0], b[1], 0.0, b[2]]])
    least = least_duration(LIMITS, rows, 0, 1)
    if least > 1e-6:
        assert len(steer(a, b, 0.999 * least)) == 0


@pytest.mark.parametrize(
    ("word", "end", "expected"),
    [
        # Quarter, straight, quarter about circles at (0, 1) and (4, 1): radius 1.
        (LSL, (4.0, 2.0, pi), (0.0, 4.0, pi)),
        (LSL, (-4.0, 2.0, pi), (pi, 4.0, 0.0)),
        (RSR, (4.0, -2.0, pi), (0.0, 4.0, pi)),
        (LSR, (2.0, 6.0, 0.0), (pi / 2, 4.0, pi / 2)),
        (RSL, (2.0, -6.0, 0.0), (pi / 2, 4.0, pi / 2)),
        (LSL, (5.0, 0.0, 0.0), (0.0, 5.0, 0.0)),
    ],
)
def test_words_by_hand(
    word: int, end: tuple[float, ...], expected: tuple[float, float, float]
) -> None:
    assert word_lengths(word, 0.0, 0.0, 0.0, *end, 1.0) == pytest.approx(expected, abs=1e-12)


def test_turning_around_close_by_takes_three_turns() -> None:
    # From (0, 0) east to (0, 0) west: circles at (0, 1) and (0, -1), 2 apart, the middle one
    # sqrt 3 to a side: arcs of 60, 300 and 60 degrees.
    word, *metres = shortest_word(0.0, 0.0, 0.0, 0.0, 0.0, pi, 1.0)
    assert word in (LRL, LRL - 1)
    assert sum(metres) == pytest.approx(7 * pi / 3)
    assert metres[1] == pytest.approx(5 * pi / 3)


def test_the_straight_line_is_the_shortest_far_away() -> None:
    _, *metres = shortest_word(0.0, 0.0, 0.0, 30.0, 40.0, 0.0, 1.0)
    assert 50.0 < sum(metres) < 50.0 + 2 * pi
    _, *metres = shortest_word(1.0, 1.0, pi / 4, 4.0, 4.0, pi / 4, 1.0)
    assert sum(metres) == pytest.approx(3 * sqrt(2))


def test_no_random_drive_is_shorter() -> None:
    """Shooting: drives of five random arcs end somewhere; the shortest word there is no longer."""
    rng = np.random.default_rng(1)
    for _ in range(2000):
        x, y, heading = 0.0, 0.0, rng.uniform(-pi, pi)
        start = heading
        metres = 0.0
        for _ in range(5):
            turn = rng.choice([-1.0, 1.0, 0.0, rng.uniform(-1, 1)]) / RADIUS
            along = rng.uniform(0, 1.5)
            piece = np.array([0, along, x, y, cos(heading), sin(heading), 0, 0, turn])
            x, y, _, _ = state_on_piece(piece, along)
            heading += turn * along
            metres += along
        _, *shortest = shortest_word(0.0, 0.0, start, x, y, heading, RADIUS)
        assert hypot(x, y) - 1e-12 <= sum(shortest) <= metres + 1e-9


def test_a_car_that_has_time_and_nowhere_to_go_stands() -> None:
    pieces = steer((1, 2, 0.5), (1, 2, 0.5), 3.0)
    assert len(pieces) == 1
    assert (pieces[0, 4:] == 0).all()
