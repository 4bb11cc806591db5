"""The few cells of a large array of bytes that are of interest, found without a look at each.

Spans of 64 bytes are taken as eight words of 64 bits. Only where something shows in a span are its
words looked at, and only where something shows in a word its bytes.
"""

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

WORD = 8
SPAN = 8  # words


@kernel
def cells_that_differ(
    one: NDArray[np.uint8], other: NDArray[np.uint8], out: NDArray[np.int64]
) -> int:
    """The number of indices written to `out`, ascending, at which two flat arrays differ.

    The arrays are contiguous, and as long as each other and `out`.
    """
    size = one.shape[0]
    whole = size // (WORD * SPAN) * SPAN  # words in full spans
    words = one[: whole * WORD].view(np.uint64)
    others = other[: whole * WORD].view(np.uint64)
    count = 0
    for begin in range(0, whole, SPAN):
        differ = np.uint64(0)
        for word in range(begin, begin + SPAN):
            differ |= words[word] ^ others[word]
        if differ == 0:
            continue
        for word in range(begin, begin + SPAN):
            if words[word] != others[word]:
                for i in range(word * WORD, (word + 1) * WORD):
                    if one[i] != other[i]:
                        out[count] = i
                        count += 1
    for i in range(whole * WORD, size):
        if one[i] != other[i]:
            out[count] = i
            count += 1
    return count


@kernel
def cells_with_bits(flat: NDArray[np.uint8], mask: int, out: NDArray[np.int64]) -> int:
    """The number of indices written to `out`, ascending, at which a flat array has a bit of `mask`.

    The array is contiguous and as long as `out`; `mask` is from 1 to 255.
    """
    size = flat.shape[0]
    whole = size // (WORD * SPAN) * SPAN  # words in full spans
    words = flat[: whole * WORD].view(np.uint64)
    wide = np.uint64(mask) * np.uint64(0x0101010101010101)
    count = 0
    for begin in range(0, whole, SPAN):
        any_of = np.uint64(0)
        for word in range(begin, begin + SPAN):
            any_of |= words[word]
        if any_of & wide == 0:
            continue
        for word in range(begin, begin + SPAN):
            if words[word] & wide != 0:
                for i in range(word * WORD, (word + 1) * WORD):
                    if flat[i] & mask:
                        out[count] = i
                        count += 1
    for i in range(whole * WORD, size):
        if flat[i] & mask:
            out[count] = i
            count += 1
    return count
