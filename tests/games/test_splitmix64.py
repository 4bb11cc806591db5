"""splitmix64 against its published numbers and against plain integers."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.games.splitmix64 import below, draw, unit

MASK = 2**64 - 1


def plain(seed: int, number: int) -> int:
    z = (seed + (number + 1) * 0x9E3779B97F4A7C15) & MASK
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & MASK
    z = (z ^ z >> 27) * 0x94D049BB133111EB & MASK
    return z ^ z >> 31


def test_published_numbers() -> None:
    assert [int(draw(np.uint64(1234567), number)) for number in range(5)] == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]


@settings(deadline=None)  # the first call compiles
@given(st.integers(0, MASK), st.integers(0, 2**40))
def test_against_plain_integers(seed: int, number: int) -> None:
    bits = plain(seed, number)
    assert int(draw(np.uint64(seed), number)) == bits
    assert unit(np.uint64(bits)) == (bits >> 11) / 2**53
    for count in (1, 2, 3, 4, 20, 2**31):
        assert below(np.uint64(bits), count) == (bits >> 33) * count >> 31


def test_ends() -> None:
    assert unit(np.uint64(0)) == 0.0
    assert 0.999999 < unit(np.uint64(MASK)) < 1.0
    assert below(np.uint64(MASK), 2**31) == 2**31 - 1
    assert below(np.uint64(0), 5) == 0


def test_even_enough() -> None:
    counts = np.bincount(
        [below(np.uint64(draw(np.uint64(5), k)), 4) for k in range(4000)], minlength=4
    )
    assert counts.sum() == 4000
    assert abs(counts - 1000).max() < 120  # some 4 standard deviations
