"""Sine and cosine by arithmetic, against high precision."""

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.geometry.turned import cosine_and_sine


def exact_series(x: Fraction, first: int) -> float:
    term, total = (x if first else Fraction(1)), Fraction(0)
    for power in range(first, first + 60, 2):
        total += term
        term = -term * x * x / ((power + 1) * (power + 2))
    return float(total)


@settings(deadline=None)  # long fractions
@given(st.floats(-3.2, 3.2))
def test_close_to_the_true_values(angle: float):
    cosine, sine = cosine_and_sine(angle)
    assert cosine == pytest.approx(exact_series(Fraction(angle), 0), abs=6e-16)
    assert sine == pytest.approx(exact_series(Fraction(angle), 1), abs=6e-16)


@pytest.mark.parametrize("quarter", range(-5, 6))
def test_quarter_turns_are_exact(quarter: int):
    expected = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarter % 4]
    assert cosine_and_sine(quarter * math.pi / 2) == expected
