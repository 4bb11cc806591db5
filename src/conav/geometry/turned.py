"""Sine and cosine by arithmetic alone, so that turned maps are equal on every machine."""

import math


def cosine_and_sine(angle: float) -> tuple[float, float]:
    """The cosine and sine of an angle [rad], within 2e-16 of the true ones for angles of a map.

    libm's differ in the last digit between machines; whole quarter turns are exact here.

    >>> cosine_and_sine(math.pi / 2)
    (0.0, 1.0)
    """
    quarter = round(angle / (math.pi / 2))
    rest = angle - quarter * (math.pi / 2)
    if abs(rest) <= 4e-16 * max(abs(angle), 1.0):
        rest = 0.0
    cosine = _series(rest, 0)
    sine = _series(rest, 1)
    for _ in range(quarter % 4):
        cosine, sine = 0.0 - sine, cosine
    return cosine, sine


def _series(x: float, first: int) -> float:
    """The sum of (-1)^k x^(2k + first) / (2k + first)! by Horner's rule; |x| is under one."""
    value = 1.0
    for power in range(first + 20, first, -2):
        value = 1.0 - value * (x * x) / (power * (power - 1))
    return value * x if first else value
