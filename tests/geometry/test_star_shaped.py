"""Centres of star-shaped polygons: by hand, and against all corners' sight."""

import numpy as np
import shapely
from hypothesis import given
from hypothesis import strategies as st

from conav.geometry.star_shaped import star_centre


def test_by_hand() -> None:
    assert star_centre([(0, 0), (2, 0), (2, 2), (0, 2)]) == (1.0, 1.0)
    cross = [(1, 0), (2, 0), (2, 1), (3, 1), (3, 2), (2, 2), (2, 3), (1, 3), (1, 2), (0, 2)]
    assert star_centre([*cross, (0, 1), (1, 1)]) == (1.5, 1.5)
    u_shape = [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
    assert star_centre(u_shape) is None
    assert star_centre([(0, 0), (0, 2), (2, 2), (2, 0)]) is None  # clockwise: no inside


@given(seed=st.integers(0, 10**6), n=st.integers(3, 12))
def test_polygons_around_a_point_have_one_that_sees_everything(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * (np.arange(n) + 0.6 * rng.random(n)) / n
    ring = np.stack((np.cos(angles), np.sin(angles)), 1) * rng.uniform(0.5, 3.0, (n, 1))
    polygon = shapely.Polygon(ring)
    centre = star_centre(ring)
    if n >= 6:  # no gap between two corners reaches half a turn
        assert centre is not None
    if centre is not None:
        wide = polygon.buffer(1e-9)
        assert all(wide.covers(shapely.LineString((centre, corner))) for corner in ring.tolist())
