"""Double integrators meet their ends, keep their limits, and find what a search finds."""

from itertools import pairwise, product
from math import hypot

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.planning.piece import state_on_piece
from conav.planning.steer_double_integrator import (
    PIECES,
    connect_double_integrator,
    least_duration,
)
from conav.planning.trajectory import gaps
from conav.planning.types import PIECE, Trajectory

SPEED, BOUND = 1.5, 0.8
LIMITS = np.array([SPEED, BOUND])

places = st.floats(-5, 5)
speeds = st.floats(-1, 1)
states = st.tuples(places, places, speeds, speeds)


def steer(a: tuple[float, ...], b: tuple[float, ...], duration: float) -> np.ndarray:
    rows = np.array([[a[0], a[1], 2.0, *a[2:]], [b[0], b[1], 2.0 + duration, *b[2:]]])
    pieces = np.full((PIECES, PIECE), np.nan)
    return pieces[: connect_double_integrator(LIMITS, rows, 0, 1, pieces)]


def check(a: tuple[float, ...], b: tuple[float, ...], duration: float, pieces: np.ndarray) -> None:
    assert pieces[0, 0] == 2.0
    assert pieces[-1, 1] == 2.0 + duration
    assert tuple(pieces[0, 2:6]) == pytest.approx(a, abs=1e-9)
    assert state_on_piece(pieces[-1], pieces[-1, 1]) == pytest.approx(b, abs=1e-9)
    assert np.abs(gaps(Trajectory(pieces))).max(initial=0.0) < 1e-9
    for before, after in pairwise(pieces):
        assert state_on_piece(before, before[1])[2:] == pytest.approx(after[4:6], abs=1e-9)
    for piece in pieces:
        assert hypot(piece[6], piece[7]) <= BOUND * (1 + 1e-8)
        for t in piece[:2]:
            assert hypot(*state_on_piece(piece, t)[2:]) <= SPEED * (1 + 1e-8)


def searched(a: tuple[float, ...], b: tuple[float, ...], duration: float, slack: float) -> bool:
    """Whether some phases of a grid keep limits that are smaller by a share."""
    shares = np.linspace(0, 1, 81)[1:]
    dp, u, v = np.subtract(b[:2], a[:2]), np.array(a[2:]), np.array(b[2:])
    first, last = (duration * grid for grid in np.meshgrid(shares, shares))
    fits = first + last <= duration
    first, last = first[fits][:, np.newaxis], last[fits][:, np.newaxis]
    w = (dp - first * u / 2 - last * v / 2) / (duration - first / 2 - last / 2)
    keeps = (
        (np.hypot(*w.T) <= SPEED * slack)
        & (np.hypot(*(w - u).T) <= BOUND * slack * first[:, 0])
        & (np.hypot(*(v - w).T) <= BOUND * slack * last[:, 0])
    )
    return bool(keeps.any())


@settings(max_examples=400, deadline=None)
@given(states, states, st.floats(0.05, 20))
def test_ends_are_met_and_limits_kept(
    a: tuple[float, ...], b: tuple[float, ...], duration: float
) -> None:
    pieces = steer(a, b, duration)
    if len(pieces):
        check(a, b, duration, pieces)
        rows = np.array([[a[0], a[1], 0.0, *a[2:]], [b[0], b[1], 0.0, *b[2:]]])
        assert least_duration(LIMITS, rows, 0, 1) <= duration
    else:
        assert not searched(a, b, duration, 0.97)


def test_by_hand() -> None:
    # From rest to rest over 2 m in 4 s: 1.25 s to some speed, coast, brake.
    pieces = steer((0, 0, 0, 0), (2, 0, 0, 0), 4.0)
    check((0, 0, 0, 0), (2, 0, 0, 0), 4.0, pieces)
    assert len(pieces) == 3
    # w = a s and 2 = w (4 - s): 0.8 s^2 - 3.2 s + 2 = 0.
    s = (3.2 - (3.2**2 - 6.4) ** 0.5) / 1.6
    assert pieces[0, 1] - 2.0 == pytest.approx(s)
    # As fast as can be: bang-bang in 2 sqrt(d / a).
    fastest = 2 * (2 / BOUND) ** 0.5
    assert len(steer((0, 0, 0, 0), (2, 0, 0, 0), fastest * 1.0001)) > 0
    assert len(steer((0, 0, 0, 0), (2, 0, 0, 0), fastest * 0.9999)) == 0
    # Standing, and going on as it was.
    assert len(steer((1, 1, 0, 0), (1, 1, 0, 0), 3.0)) == 1
    assert steer((0, 0, 1, 0), (3, 0, 1, 0), 3.0)[0, 4:8] == pytest.approx([1, 0, 0, 0])


@pytest.mark.parametrize(
    ("d", "u", "v", "expected"),
    [
        (2.0, 0.0, 0.0, 2 * (2 / BOUND) ** 0.5),
        (10.0, 0.0, 0.0, 2 * SPEED / BOUND + (10 - SPEED**2 / BOUND) / SPEED),
        (0.0, 1.0, 1.0, 0.0),
        # 1 m back with velocity 1 at both ends: from 1 to w < 0 and back, w^2 = 1 + a.
        (-1.0, 1.0, 1.0, 2 * (1 + (1 + BOUND) ** 0.5) / BOUND),
        (0.0, 0.0, 0.0, 0.0),
    ],
)
def test_least_durations_by_hand(d: float, u: float, v: float, expected: float) -> None:
    rows = np.array([[0, 0, 0, u, 0], [d, 0, 0, v, 0.0]])
    assert least_duration(LIMITS, rows, 0, 1) == pytest.approx(expected, rel=1e-6, abs=1e-8)


def test_a_body_that_is_too_fast_comes_back() -> None:
    # Over 0 m from velocity 1 to 0: brake 1 / a, come back 1 / (2 a) with bang-bang.
    rows = np.array([[0, 0, 0, 1.0, 0], [0, 0, 0, 0, 0.0]])
    back = 0.5 / BOUND
    expected = 1 / BOUND + 2 * (back / BOUND) ** 0.5
    assert least_duration(LIMITS, rows, 0, 1) == pytest.approx(expected, rel=1e-6)


def test_least_durations_are_below_every_way_on_a_line() -> None:
    """On a line two phases with full acceleration are the fastest; all signs and switches."""
    for u, v, sign in product(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), (1, -1)):
        for first in np.linspace(0, 3, 13):
            top = u + sign * BOUND * first
            last = (top - v) / (sign * BOUND)
            if last < 0 or abs(top) > SPEED:
                continue
            d = (u + top) / 2 * first + (top + v) / 2 * last
            rows = np.array([[0, 0, 0, u, 0], [d, 0, 0, v, 0.0]])
            assert least_duration(LIMITS, rows, 0, 1) <= first + last + 1e-9
