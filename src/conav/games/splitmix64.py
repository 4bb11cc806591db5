"""The generator splitmix64 [Steele2014], by number of the draw.

A draw depends on the seed and its number alone, so it does not matter in which order draws are
made, and a kernel needs no generator to carry along.
"""

import numpy as np

from conav.compiled import kernel

# numba turns a sum of a signed and an unsigned 64-bit number into a float: all are unsigned here.
_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_11 = np.uint64(11)
_27 = np.uint64(27)
_30 = np.uint64(30)
_31 = np.uint64(31)
_33 = np.uint64(33)
_UNIT = 1.0 / 9007199254740992.0  # 2 ** -53


@kernel
def draw(seed: np.uint64, number: int) -> np.uint64:
    """The 64 random bits of this seed's draw number 0, 1, ..."""
    z = np.uint64(seed) + np.uint64(number + 1) * _GAMMA
    z = (z ^ (z >> _30)) * _MIX_1
    z = (z ^ (z >> _27)) * _MIX_2
    return z ^ (z >> _31)


@kernel
def unit(bits: np.uint64) -> float:
    """A number from 0 up to but not 1, of a draw's upper 53 bits."""
    return int(np.uint64(bits) >> _11) * _UNIT


@kernel
def below(bits: np.uint64, count: int) -> int:
    """A whole number from 0 to count - 1, of a draw's upper 31 bits; count up to 2**31.

    Uneven by less than count / 2**31.
    """
    return (int(np.uint64(bits) >> _33) * count) >> 31
