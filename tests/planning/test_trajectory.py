"""Trajectories against integration by small steps and hand-computed cases."""

from math import hypot, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conav.planning.piece import bend, piece_length, state_on_piece
from conav.planning.trajectory import (
    cost,
    cut,
    end_position,
    gaps,
    headings,
    length,
    polyline,
    positions,
    straight,
    velocities,
)
from conav.planning.types import Trajectory

numbers = st.floats(-3, 3).map(lambda x: x if abs(x) > 1e-3 else 0.0)


@st.composite
def any_piece(draw: st.DrawFn) -> np.ndarray:
    start = draw(st.floats(0, 5))
    curved = draw(st.booleans())
    return np.array([
        start, start + draw(st.floats(0.01, 6)),
        draw(numbers), draw(numbers), draw(numbers), draw(numbers),
        0.0 if curved else draw(numbers), 0.0 if curved else draw(numbers),
        draw(numbers) if curved else 0.0,
    ])  # fmt: skip


def integrated(piece: np.ndarray, steps: int = 4000) -> tuple[np.ndarray, np.ndarray, float]:
    """End position, end velocity and length, by the midpoint rule on the equations of motion."""
    h = (piece[1] - piece[0]) / steps
    turn = np.array([[0.0, -piece[8]], [piece[8], 0.0]])
    place, velocity, metres = piece[2:4].copy(), piece[4:6].copy(), 0.0
    for _ in range(steps):
        middle = velocity + 0.5 * h * (piece[6:8] + turn @ velocity)
        place = place + h * middle
        metres += h * float(np.hypot(*middle))
        velocity = velocity + h * (piece[6:8] + turn @ middle)
    return place, velocity, metres


@pytest.mark.parametrize(
    "piece",
    [
        [0, 3, 1, 2, 0.5, -0.2, 0, 0, 0],
        [1, 4, 1, 2, 0.5, -0.2, -0.3, 0.4, 0],
        [1, 4, 1, 2, -1.5, 0, 1, 0, 0],  # stops and comes back
        [1, 4, 1, 2, 0.5, -0.2, 0, 0, 1.3],
        [0, 2, 0, 0, 1, 0, 0, 0, -0.7],
    ],
)
def test_motion_is_the_integral_of_its_equations(piece: list[float]) -> None:
    row = np.array(piece, dtype=np.float64)
    place, velocity, metres = integrated(row)
    assert np.allclose(state_on_piece(row, row[1]), [*place, *velocity], atol=1e-5)
    assert np.allclose(positions(Trajectory(row), row[1]), place, atol=1e-5)
    assert piece_length(row) == pytest.approx(metres, abs=1e-5)


@given(any_piece(), st.floats(0, 0.999))
def test_kernel_and_arrays_agree(piece: np.ndarray, share: float) -> None:
    t = piece[0] + share * (piece[1] - piece[0])
    one = Trajectory(piece)
    expected = [*positions(one, t)[0], *velocities(one, t)[0]]
    assert np.allclose(state_on_piece(piece, t), expected, atol=1e-12)


@given(any_piece())
def test_length_is_that_of_many_chords(piece: np.ndarray) -> None:
    times = np.linspace(piece[0], piece[1], 20_001)
    chords = np.hypot(*np.diff(positions(Trajectory(piece), times), axis=0).T).sum()
    assert piece_length(piece) == pytest.approx(chords, rel=1e-6, abs=1e-9)


def test_length_by_hand() -> None:
    # Thrown up and caught: v^2 / a = 4 in all, twice 2.
    assert piece_length(np.array([0, 4, 0, 0, 0, 2, 0, -1, 0.0])) == pytest.approx(4.0)
    # y = x^2 / 2 from 0 to 1: (sqrt 2 + asinh 1) / 2.
    arc = piece_length(np.array([0, 1, 0, 0, 1, 0, 0, 1, 0.0]))
    assert arc == pytest.approx((sqrt(2) + np.arcsinh(1)) / 2, rel=1e-15)
    # A quarter of a circle of radius 2.
    assert piece_length(np.array([0, pi, 0, 0, 1, 0, 0, 0, 0.5])) == pytest.approx(pi)


@pytest.mark.parametrize("a", [1e-3, 1e-6, 1e-9, 1e-12, 1e-15])
def test_length_is_exact_where_the_acceleration_is_small(a: float) -> None:
    # To second order the speed is hypot(v + (a.v/|v|) s), here across the velocity: no first order.
    piece = np.array([0, 2, 0, 0, 0.6, 0.8, -0.8 * a, 0.6 * a, 0.0])
    assert piece_length(piece) == pytest.approx(2.0 + a * a * 8 / 6, rel=1e-12)
    piece[6:8] = 0.6 * a, 0.8 * a
    assert piece_length(piece) == pytest.approx(2.0 + 2.0 * a, rel=1e-15)


@given(any_piece(), st.floats(0, 1))
def test_bend_bounds_how_far_it_leaves_the_tangent(piece: np.ndarray, share: float) -> None:
    s = share * (piece[1] - piece[0])
    x, y, _, _ = state_on_piece(piece, piece[0] + s)
    off = hypot(x - piece[2] - s * piece[4], y - piece[3] - s * piece[5])
    assert off <= bend(piece) * s * s / 2 + 1e-12


HAND = Trajectory(
    np.array([
        [0, 2, 0, 0, 1, 0, 0, 0, 0],
        [2, 2 + pi, 2, 0, 1, 0, 0, 0, 0.5],  # a quarter to the left, radius 2
        [2 + pi, 4 + pi, 4, 2, 0, 1, 0, -0.5, 0],  # brakes to a stop
    ])
)  # fmt: skip


def test_hand_trajectory() -> None:
    assert HAND.arrival_s == 4 + pi
    assert end_position(HAND) == pytest.approx((4, 3))
    assert length(HAND) == pytest.approx(2 + pi + 1)
    assert cost(HAND, ("duration", "length")) == pytest.approx([4 + pi, 3 + pi])
    assert gaps(HAND) == pytest.approx(np.zeros((2, 2)), abs=1e-15)
    before, after = positions(HAND, [-1, 99])
    assert before == pytest.approx([0, 0])
    assert after == pytest.approx([4, 3])
    assert velocities(HAND, [-1, 1, 2 + pi, 99]) == pytest.approx(
        np.array([[0, 0], [1, 0], [0, 1], [0, 0]])
    )
    assert headings(HAND, [1, 2 + pi / 2, 3 + pi, 99]) == pytest.approx([0, pi / 4, pi / 2, pi / 2])


def test_who_stands_faces_where_it_drove() -> None:
    stopping = straight([(0, 0), (0, 0), (0, 2), (0, 2)], [0, 1, 2, 3])
    assert headings(stopping, [0.5, 1.5, 2.5], first=1.0) == pytest.approx([1.0, pi / 2, pi / 2])


def test_gaps_are_found() -> None:
    torn = np.array(HAND.pieces)
    torn[1, 2] += 0.3
    torn[2, 0] += 0.25
    found = gaps(Trajectory(torn))
    assert found[0] == pytest.approx([0.3, 0.0])
    assert found[1, 1] == pytest.approx(0.25)


@given(st.floats(0, 6), st.floats(0.01, 6))
def test_a_part_is_where_the_whole_is(start: float, duration: float) -> None:
    part = cut(HAND, start, start + duration)
    times = np.linspace(0, duration, 50)
    assert np.allclose(positions(part, times), positions(HAND, start + times), atol=1e-9)
    assert part.pieces[0, 0] == 0.0
    assert part.arrival_s == pytest.approx(duration)
    assert np.allclose(gaps(part), 0.0, atol=1e-9)


def test_no_part_of_no_time() -> None:
    with pytest.raises(ValueError, match="no time"):
        cut(HAND, 2.0, 2.0)


@given(any_piece(), st.floats(0.001, 0.1))
def test_a_drawn_line_is_near(piece: np.ndarray, tolerance: float) -> None:
    points = polyline(Trajectory(piece), tolerance)
    times = np.linspace(piece[0], piece[1], 301)
    drawn = np.stack([np.interp(times, points[:, 2], points[:, k]) for k in (0, 1)], axis=-1)
    off = np.hypot(*(drawn - positions(Trajectory(piece), times)).T)
    assert off.max() <= tolerance + 1e-9


def test_length_of_a_turn_back_with_hardly_any_velocity_across() -> None:
    for across in (1e-290, 1e-160, 1e-12):
        piece = np.array([0.0, 2.0, 0.0, 0.0, across, -1.0, 0.0, 1.0, 0.0])
        assert length(Trajectory(piece)) == pytest.approx(1.0)
