"""Our own logarithm and roots against the library's."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from conav.planning.radius import connection_radius, cube_root, natural_log


@given(st.floats(1e-6, 1e12))
@settings(deadline=None)
def test_logarithm(x: float) -> None:
    assert abs(natural_log(x) - math.log(x)) <= 4e-15 * max(1.0, abs(math.log(x)))


@given(st.floats(1e-9, 1e9))
@settings(deadline=None)
def test_cube_root(x: float) -> None:
    assert abs(cube_root(x) - math.cbrt(x)) <= 1e-15 * math.cbrt(x) * 4


def test_radius_falls_from_eta_by_its_exponent() -> None:
    assert connection_radius(1, 5.0, 3.0, 3) == 3.0
    assert connection_radius(2, 50.0, 3.0, 3) == 3.0
    for k in (100, 5000, 10**6):
        share = math.log(k) / k
        assert math.isclose(connection_radius(k, 5.0, 9.0, 3), 5 * share ** (1 / 3))
        assert math.isclose(connection_radius(k, 5.0, 9.0, 4), 5 * share**0.25)
