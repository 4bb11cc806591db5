"""Functions of one piece of a trajectory, as kernels. Columns: t0, t1, x, y, vx, vy, ax, ay, turn.

They decide plans, so they use + - * / and sqrt only.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.elementary import log_above_one, sin_cos


@kernel
def state_on_piece(piece: NDArray[np.float64], t: float) -> tuple[float, float, float, float]:
    """Position [m] and velocity [m/s] at a time, x, y, vx, vy, as if the piece had no ends."""
    s = t - piece[0]
    turn = piece[8]
    if turn == 0.0:
        return (
            piece[2] + s * (piece[4] + 0.5 * s * piece[6]),
            piece[3] + s * (piece[5] + 0.5 * s * piece[7]),
            piece[4] + s * piece[6],
            piece[5] + s * piece[7],
        )
    # The chord of an arc points half way between the directions at its ends.
    sine, cosine = sin_cos(0.5 * turn * s)
    chord = 2.0 * sine / turn
    full_sine = 2.0 * sine * cosine
    full_cosine = 1.0 - 2.0 * sine * sine
    return (
        piece[2] + chord * (cosine * piece[4] - sine * piece[5]),
        piece[3] + chord * (sine * piece[4] + cosine * piece[5]),
        full_cosine * piece[4] - full_sine * piece[5],
        full_sine * piece[4] + full_cosine * piece[5],
    )


@kernel
def bend(piece: NDArray[np.float64]) -> float:
    """The norm of the acceleration on a piece [m/s^2], the same all along; 0: it is straight."""
    if piece[8] != 0.0:
        return abs(piece[8]) * sqrt(piece[4] * piece[4] + piece[5] * piece[5])
    return sqrt(piece[6] * piece[6] + piece[7] * piece[7])


@kernel
def piece_length(piece: NDArray[np.float64]) -> float:
    """The metres driven on a piece."""
    duration = piece[1] - piece[0]
    ax = piece[6]
    ay = piece[7]
    a = sqrt(ax * ax + ay * ay)
    v = sqrt(piece[4] * piece[4] + piece[5] * piece[5])
    if piece[8] != 0.0 or a == 0.0:
        return v * duration
    # Along the acceleration the velocity is p + a s, across it always c.
    p = (piece[4] * ax + piece[5] * ay) / a
    c = abs(piece[4] * ay - piece[5] * ax) / a
    end = p + a * duration
    if p >= 0.0:
        return _length_gaining(p, c, a, duration)
    if end <= 0.0:
        return _length_gaining(-end, c, a, duration)  # the same, driven backwards
    return _length_gaining(0.0, c, a, -p / a) + _length_gaining(0.0, c, a, end / a)


@kernel
def _length_gaining(p: float, c: float, a: float, duration: float) -> float:
    """The integral of sqrt((p + a s)^2 + c^2) over s from 0 to the duration, for p >= 0, a > 0.

    The closed form with an inverse hyperbolic sine, arranged so that nothing cancels where the
    acceleration is small.
    """
    q = p + a * duration
    first = sqrt(p * p + c * c)
    last = sqrt(q * q + c * c)
    if last == 0.0:
        return 0.0
    share = (p + q) / (first + last)
    length = duration * (last + p * share)
    if c * c > 0.0:  # one that is lost when squared adds nothing, and would be divided by
        length += c * c * log_above_one(a * duration * (1.0 + share) / (p + first)) / a
    return 0.5 * length
