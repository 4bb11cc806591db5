"""Against the library of mathematics."""

import math

from hypothesis import given
from hypothesis import strategies as st

from conav.geometry.elementary import arc_tangent, log_above_one, sin_cos

finite = st.floats(-1e6, 1e6)


@given(st.one_of(finite, st.floats(-10, 10), st.integers(-99, 99).map(lambda k: k * math.pi / 4)))
def test_sine_and_cosine(x: float) -> None:
    sine, cosine = sin_cos(x)
    assert abs(sine - math.sin(x)) < 4e-16
    assert abs(cosine - math.cos(x)) < 4e-16


@given(finite, finite)
def test_arc_tangent(y: float, x: float) -> None:
    expected = math.atan2(y + 0.0, x + 0.0)
    if y == 0.0 and x == 0.0:
        expected = 0.0
    if y == 0.0 and x < 0.0:
        expected = math.pi
    assert abs(arc_tangent(y, x) - expected) < 1e-15


def test_arc_tangent_of_the_axes() -> None:
    assert arc_tangent(0.0, 1.0) == 0.0
    assert arc_tangent(1.0, 0.0) == math.pi / 2
    assert arc_tangent(0.0, -1.0) == math.pi
    assert arc_tangent(-1.0, 0.0) == -math.pi / 2


@given(st.one_of(st.floats(0, 1e9), st.floats(0, 1e-6), st.floats(0, 2)))
def test_logarithm(z: float) -> None:
    assert math.isclose(log_above_one(z), math.log1p(z), rel_tol=1e-15, abs_tol=1e-300)
