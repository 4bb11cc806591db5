"""Sums and products of floats without rounding: expansion arithmetic [Shewchuk1997].

An expansion is the first `count` entries of an array: floats of growing magnitude that do not
overlap, so that the last one has the sign of their sum. Here none of them is zero. Rules of the
file: no fused multiply-add and no reordering, which is what numba does without fastmath.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

SPLITTER = 134217729.0  # 2^27 + 1


@kernel
def two_sum(a: float, b: float) -> tuple[float, float]:
    """The rounded sum and what rounding lost; together exactly a + b (theorem 7, Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@kernel
def two_product(a: float, b: float) -> tuple[float, float]:
    """The rounded product and what rounding lost; together exactly a * b (theorem 18, Dekker)."""
    product = a * b
    wide = SPLITTER * a
    a_high = wide - (wide - a)
    a_low = a - a_high
    wide = SPLITTER * b
    b_high = wide - (wide - b)
    b_low = b - b_high
    lost = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, lost


@kernel
def grow(expansion: NDArray[np.float64], count: int, number: float) -> int:
    """The new count after `number` was added to the expansion in place (theorem 10, no zeros)."""
    carry = number
    kept = 0
    for i in range(count):
        carry, low = two_sum(carry, expansion[i])
        if low != 0.0:
            expansion[kept] = low
            kept += 1
    if carry != 0.0:
        expansion[kept] = carry
        kept += 1
    return kept


@kernel
def grow_by_product(expansion: NDArray[np.float64], count: int, a: float, b: float) -> int:
    """The new count after a * b was added to the expansion in place."""
    high, part = two_product(a, b)
    for _ in range(2):
        count = grow(expansion, count, part)
        part = high
    return count


@kernel
def grow_by_products(
    expansion: NDArray[np.float64],
    count: int,
    first: NDArray[np.float64],
    first_count: int,
    second: NDArray[np.float64],
    second_count: int,
    sign: float,
) -> int:
    """The new count after sign * first * second, two expansions, was added in place."""
    for i in range(first_count):
        for j in range(second_count):
            count = grow_by_product(expansion, count, sign * first[i], second[j])
    return count


@kernel
def sign_of(expansion: NDArray[np.float64], count: int) -> int:
    """1, 0 or -1."""
    if count == 0:
        return 0
    return 1 if expansion[count - 1] > 0.0 else -1
