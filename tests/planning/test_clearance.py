"""Clearances against the verifier's bounds, dense sampling and cases known by hand."""

from math import inf, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.planning.clearance import TOUCH, piece_clear_of_segment, pieces_apart
from conav.planning.trajectory import positions
from conav.planning.types import Trajectory
from conav.planning.verify_curves import least_apart, least_from_segment

from .test_trajectory import any_piece

distances = st.floats(0.01, 3)


def is_curved(*pieces: np.ndarray) -> bool:
    return any((piece[6:] != 0).any() for piece in pieces)


@settings(max_examples=200, deadline=None)
@given(any_piece(), any_piece(), distances)
def test_pieces_against_the_verifier(a: np.ndarray, b: np.ndarray, distance: float) -> None:
    begin, end = max(a[0], b[0]), min(a[1], b[1])
    found = pieces_apart(a[np.newaxis], 0, b[np.newaxis], 0, distance)
    if begin > end:
        assert found
        return
    low, high, _ = least_apart(a, b, begin, end, inf)
    if found:
        assert high >= distance - 1e-12
    else:
        assert low < distance + (TOUCH if is_curved(a, b) else 1e-12)


@settings(max_examples=200, deadline=None)
@given(any_piece(), st.tuples(*[st.floats(-4, 4)] * 4), distances)
def test_a_wall_against_the_verifier(
    piece: np.ndarray, wall: tuple[float, ...], distance: float
) -> None:
    low, high, _ = least_from_segment(piece, np.array(wall), inf)
    if piece_clear_of_segment(piece, *wall, distance):
        assert high >= distance - 1e-12
    else:
        assert low < distance + (TOUCH if is_curved(piece) else 1e-12)


@settings(max_examples=100, deadline=None)
@given(any_piece(), any_piece(), distances)
def test_no_sample_is_nearer_than_accepted(a: np.ndarray, b: np.ndarray, distance: float) -> None:
    times = np.linspace(max(a[0], b[0]), min(a[1], b[1]), 1000)
    if times[0] <= times[-1] and pieces_apart(a[np.newaxis], 0, b[np.newaxis], 0, distance):
        away = positions(Trajectory(a), times) - positions(Trajectory(b), times)
        assert np.hypot(*away.T).min() >= distance - 1e-9


def test_straight_ones_may_touch() -> None:
    a = np.array([[0, 10, 0, 0, 1, 0, 0, 0, 0.0]])
    b = np.array([[0, 10, 10, 1, -1, 0, 0, 0, 0.0]])
    assert pieces_apart(a, 0, b, 0, 1.0)
    assert not pieces_apart(a, 0, b, 0, 1.0 + 1e-12)
    assert piece_clear_of_segment(a[0], 0.0, 2.0, 10.0, 2.0, 2.0)
    assert not piece_clear_of_segment(a[0], 0.0, 2.0, 10.0, 2.0, 2.0 + 1e-12)
    assert not piece_clear_of_segment(a[0], 5.0, -1.0, 5.0, 1.0, 0.1)  # through the wall


@pytest.mark.parametrize(
    ("over", "clear"), [(1e-3, True), (2e-6, True), (0.0, False), (-1e-3, False)]
)
def test_arcs_that_graze(over: float, clear: bool) -> None:
    arc = np.array([0, 4 * pi, 0, 4, -1, 0, 0, 0, 0.5])  # about (0, 2), down to y = 0
    assert piece_clear_of_segment(arc, -5.0, -1.0, 5.0, -1.0, 1.0 - over) == clear
    ring = np.array([[0, 6, 1, 0, 0, 1, 0, 0, 1.0], [0, 6, 3, 0, 0, 3, 0, 0, 1.0]])
    assert pieces_apart(ring, 0, ring, 1, 2.0 - over) == clear


def test_parts_of_the_time_count_alone() -> None:
    a = np.array([[0, 1, 0, 0, 1, 0, 0, 0, 2.0]])
    b = np.array([[2, 3, 0, 0, 0, 0, 0, 0, 0.0]])
    assert pieces_apart(a, 0, b, 0, 5.0)
