"""The robots' random generators inside kernels, number for number those of `generator_for`.

numpy's `SeedSequence` turns a seed and a name into 256 bits and PCG64 (O'Neill 2014; the XSL-RR
variant with 128 bits of state) makes numbers from them. numpy promises both streams for good. They
are written again here because a thousand games of three robots need three thousand generators, and
making those one by one through numpy takes longer than the games.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

_LOW = np.uint64(0xFFFFFFFF)
_32 = np.uint64(32)
_16 = np.uint64(16)
_1 = np.uint64(1)
_63 = np.uint64(63)
_MULT_HIGH = np.uint64(2549297995355413924)
_MULT_LOW = np.uint64(4865540595714422341)
_MULT_LOW_HIGH = np.uint64(4865540595714422341 >> 32)
_MULT_LOW_LOW = np.uint64(4865540595714422341 & 0xFFFFFFFF)
_INIT_A = np.uint64(0x43B0D7E5)
_MULT_A = np.uint64(0x931E8875)
_INIT_B = np.uint64(0x8B51F9DD)
_MULT_B = np.uint64(0x58F38DED)
_MIX_L = np.uint64(0xCA01F9DD)
_MIX_R = np.uint64(0x4973F715)

_DOUBLE = 2.0**-53


def name_words(names: list[str]) -> NDArray[np.uint64]:
    """The names as `seed_generators` reads them: a row each, length first."""
    encoded = [name.encode() for name in names]
    words = np.zeros((len(names), 1 + max(map(len, encoded), default=0)), dtype=np.uint64)
    for row, text in zip(words, encoded, strict=True):
        row[0] = len(text)
        row[1 : 1 + len(text)] = list(text)
    return words


@kernel
def seed_generator(
    seed: np.uint64, name: NDArray[np.uint64], states: NDArray[np.uint64], i: int
) -> None:
    """Fill row i of `states` (n, 4): state high and low, increment high and low of a new PCG64.

    `name` is a row of `name_words`.
    """
    length = int(name[0])
    entropy = np.zeros(max(length + 2, 4), dtype=np.uint64)
    entropy[0] = seed & _LOW
    count = 1
    if seed >> _32 != np.uint64(0):
        entropy[1] = seed >> _32
        count = 2
    for k in range(length):
        entropy[count] = name[1 + k]
        count += 1
    pool = np.zeros(4, dtype=np.uint64)
    constant = _INIT_A
    for k in range(4):
        value = entropy[k] if k < count else np.uint64(0)
        value ^= constant
        constant = (constant * _MULT_A) & _LOW
        value = (value * constant) & _LOW
        pool[k] = value ^ (value >> _16)
    for source in range(max(count, 4)):
        for target in range(4):
            if source == target:
                continue
            value = (pool[source] if source < 4 else entropy[source]) ^ constant
            constant = (constant * _MULT_A) & _LOW
            value = (value * constant) & _LOW
            value ^= value >> _16
            value = (_MIX_L * pool[target] - _MIX_R * value) & _LOW
            pool[target] = value ^ (value >> _16)
    words = np.zeros(4, dtype=np.uint64)
    constant = _INIT_B
    for k in range(8):
        value = pool[k % 4] ^ constant
        constant = (constant * _MULT_B) & _LOW
        value = (value * constant) & _LOW
        value ^= value >> _16
        words[k // 2] |= value << (_32 if k % 2 == 1 else np.uint64(0))
    states[i, 2] = (words[2] << _1) | (words[3] >> _63)
    states[i, 3] = (words[3] << _1) | _1
    # From 0: a step, plus the seed, a step.
    low = states[i, 3] + words[1]
    carry = _1 if low < words[1] else np.uint64(0)
    states[i, 0] = states[i, 2] + words[0] + carry
    states[i, 1] = low
    next_word(states, i)


@kernel
def next_word(states: NDArray[np.uint64], i: int) -> np.uint64:
    """The next 64 random bits of generator i of `states` (n, 4)."""
    low = states[i, 1]
    # The product of two 64 bit numbers in four of 32.
    a = low >> _32
    b = low & _LOW
    bb = b * _MULT_LOW_LOW
    ab = a * _MULT_LOW_LOW + (bb >> _32)
    ba = b * _MULT_LOW_HIGH + (ab & _LOW)
    high = a * _MULT_LOW_HIGH + (ab >> _32) + (ba >> _32)
    high += states[i, 0] * _MULT_LOW + low * _MULT_HIGH
    new = low * _MULT_LOW + states[i, 3]
    if new < states[i, 3]:
        high += _1
    high += states[i, 2]
    states[i, 0] = high
    states[i, 1] = new
    mixed = high ^ new
    turn = high >> np.uint64(58)
    return (mixed >> turn) | (mixed << ((np.uint64(64) - turn) & _63))


@kernel
def next_double(states: NDArray[np.uint64], i: int) -> float:
    """The next number in [0, 1): `Generator.random()`."""
    return float(next_word(states, i) >> np.uint64(11)) * _DOUBLE


@kernel
def next_quarter(states: NDArray[np.uint64], i: int) -> int:
    """The first `Generator.integers(4)` of a new generator."""
    return int((next_word(states, i) & _LOW) >> np.uint64(30))
