"""The few cells of interest against numpy's look at all."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.geometry.sparse_cells import cells_that_differ, cells_with_bits

seeds = st.integers(0, 2**32 - 1)


def bytes_of(rng: np.random.Generator) -> np.ndarray:
    """An array of any length around that of some spans, with few or many cells above 0."""
    size = int(rng.integers(0, 260))
    share = rng.choice([0.0, 0.01, 0.1, 0.9])
    return (rng.integers(0, 256, size) * (rng.random(size) < share)).astype(np.uint8)


@settings(deadline=None)
@given(seeds)
def test_cells_that_differ(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one = bytes_of(rng)
    other = one ^ np.uint8(rng.integers(0, 256)) * (rng.random(len(one)) < rng.choice([0.02, 0.5]))
    out = np.full(len(one), -1, np.int64)
    count = cells_that_differ(one, other.astype(np.uint8), out)
    assert np.array_equal(out[:count], np.flatnonzero(one != other))
    assert (out[count:] == -1).all()


@settings(deadline=None)
@given(seeds, st.integers(1, 255))
def test_cells_with_bits(seed: int, mask: int) -> None:
    flat = bytes_of(np.random.default_rng(seed))
    flat.flags.writeable = False  # as minds get them
    out = np.full(len(flat), -1, np.int64)
    count = cells_with_bits(flat, mask, out)
    assert np.array_equal(out[:count], np.flatnonzero(flat & np.uint8(mask)))
    assert (out[count:] == -1).all()
