"""The verifier's least distances against dense sampling and cases known by hand."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.planning.trajectory import positions
from conav.planning.types import Trajectory
from conav.planning.verify_claims import costs_of
from conav.planning.verify_curves import least_apart, least_from_segment, place_at, velocity_at

from .test_trajectory import any_piece

DENSE = 4001


def sampled(a: np.ndarray, b: np.ndarray, begin: float, end: float) -> float:
    times = np.linspace(begin, end, DENSE)
    places = []
    for piece in (a, b):
        longer = piece.copy()
        longer[1] = max(longer[1], end)
        places.append(positions(Trajectory(longer), times))
    return float(np.hypot(*(places[0] - places[1]).T).min())


@settings(max_examples=150, deadline=None)
@given(any_piece(), any_piece())
def test_two_pieces(a: np.ndarray, b: np.ndarray) -> None:
    begin, end = max(a[0], b[0]), min(a[1], b[1])
    if begin > end:
        return
    low, high, when = least_apart(a, b, begin, end, inf)
    assert high - 1.1e-7 <= low <= high
    assert begin <= when <= end
    assert np.hypot(*np.subtract(place_at(a, when), place_at(b, when))) == pytest.approx(high)
    fastest = sum(np.hypot(*velocity_at(p, t)) for p in (a, b) for t in (begin, end)) + 1e-9
    slack = fastest * (end - begin) / DENSE
    expected = sampled(a, b, begin, end)
    assert low <= expected + 1e-9
    assert low >= expected - slack - 1e-6


@settings(max_examples=150, deadline=None)
@given(any_piece(), st.tuples(*[st.floats(-4, 4)] * 4))
def test_a_piece_and_a_wall(piece: np.ndarray, wall: tuple[float, ...]) -> None:
    low, high, when = least_from_segment(piece, np.array(wall), inf)
    assert high - 1.1e-7 <= low <= high
    assert piece[0] <= when <= piece[1]
    times = np.linspace(piece[0], piece[1], DENSE)
    places = positions(Trajectory(piece), times)
    a, d = np.array(wall[:2]), np.array(wall[2:]) - np.array(wall[:2])
    s = np.clip((places - a) @ d / max(d @ d, 1e-300), 0, 1)
    expected = np.hypot(*(places - a - s[:, np.newaxis] * d).T).min()
    slack = 2 * np.hypot(*np.diff(places, axis=0).T).max()
    assert expected - slack - 1e-6 <= low <= expected + 1e-9


def test_what_is_far_is_not_looked_into() -> None:
    a = np.array([0, 10, 0, 0, 1, 0, 0, 0, 2.0])
    b = np.array([0, 10, 50, 0, 0, 0, 0, 0, 0.0])
    low, high, _ = least_apart(a, b, 0.0, 10.0, 5.0)
    assert 5.0 <= low <= high


def test_two_discs_that_just_touch() -> None:
    # Past each other on lines 1 m apart; they meet at t = 5.
    a = np.array([0, 10, 0, 0, 1, 0, 0, 0, 0.0])
    b = np.array([0, 10, 10, 1, -1, 0, 0, 0, 0.0])
    assert least_apart(a, b, 0.0, 10.0, inf) == (1.0, 1.0, 5.0)


def test_an_arc_that_grazes_a_wall() -> None:
    # A circle of radius 2 about (0, 2), the wall at y = -1: 1 m at the lowest point, at t = 2 pi.
    arc = np.array([0, 4 * pi, 0, 4, -1, 0, 0, 0, 0.5])
    low, high, when = least_from_segment(arc, np.array([-5, -1, 5, -1.0]), inf)
    assert low == pytest.approx(1.0, abs=1e-7)
    assert high == pytest.approx(1.0, abs=1e-7)
    assert when == pytest.approx(2 * pi, abs=1e-3)


def test_concentric_circles_keep_their_distance() -> None:
    a = np.array([0, 6, 1, 0, 0, 1, 0, 0, 1.0])
    b = np.array([0, 6, 3, 0, 0, 3, 0, 0, 1.0])
    low, high, _ = least_apart(a, b, 0.0, 6.0, inf)
    assert low == pytest.approx(2.0, abs=2e-7)
    assert high == pytest.approx(2.0, abs=1e-12)


def test_a_parabola_and_a_point() -> None:
    # y = x^2 / 2 and (0, 2): nearest where x^2 = 2, at sqrt 3.
    piece = np.array([0, 3, 0, 0, 1, 0, 0, 1, 0.0])
    point = np.array([0, 3, 0, 2, 0, 0, 0, 0, 0.0])
    low, high, when = least_apart(piece, point, 0.0, 3.0, inf)
    assert (low, high) == pytest.approx((sqrt(3), sqrt(3)), abs=2e-7)
    assert when == pytest.approx(sqrt(2), abs=1e-3)


@given(any_piece())
def test_lengths_are_those_of_chords(piece: np.ndarray) -> None:
    times = np.linspace(piece[0], piece[1], 20_001)
    chords = np.hypot(*np.diff(positions(Trajectory(piece), times), axis=0).T).sum()
    found = costs_of(piece[np.newaxis], ("length", "duration"))
    assert found == pytest.approx([chords, piece[1]], rel=1e-6, abs=1e-9)
