"""Sine, cosine, arc tangent and logarithm from + - * / and sqrt alone.

Libraries of mathematics differ from processor to processor in the last digits, and a plan that
turns on one of those would differ too. These do not; they are within a few units of the last place
(tests/geometry/test_elementary.py), which is all that geometry asks for.
"""

from math import floor, sqrt

from conav.compiled import kernel

PI = 3.141592653589793
TWO_PI = 2.0 * PI
_HALF_PI = PI / 2.0
_HALF_PI_HIGH = 1.5707963267341256  # half of pi in three parts: 33 bits, 33 bits, the rest
_HALF_PI_MIDDLE = 6.077100506303966e-11
_HALF_PI_LOW = 2.0222662487959506e-21
_LN_2 = 0.6931471805599453


@kernel
def sin_cos(x: float) -> tuple[float, float]:
    """The sine and cosine of an angle [rad] of up to a million radians.

    The nearest multiple of pi/2 is taken away in three parts [Cody1980]; what is left, at most
    pi/4, goes into Taylor's series.
    """
    turns = floor(x / _HALF_PI + 0.5)
    r = ((x - turns * _HALF_PI_HIGH) - turns * _HALF_PI_MIDDLE) - turns * _HALF_PI_LOW
    z = r * r
    term = r
    sine = 0.0
    for k in range(9, 0, -1):  # Horner's scheme from the highest power
        sine = (1.0 + sine) * (-z / (2.0 * k * (2.0 * k + 1.0)))
    sine = r + term * sine
    cosine = 0.0
    for k in range(9, 0, -1):
        cosine = (1.0 + cosine) * (-z / (2.0 * k * (2.0 * k - 1.0)))
    cosine = 1.0 + cosine
    quarter = int(turns - 4.0 * floor(turns / 4.0))
    if quarter == 0:
        return sine, cosine
    if quarter == 1:
        return cosine, -sine
    if quarter == 2:
        return -sine, -cosine
    return -cosine, sine


@kernel
def arc_tangent(y: float, x: float) -> float:
    """The angle of the direction (x, y) in (-pi, pi] [rad]; 0 where both are 0.

    The ratio of the smaller to the larger is halved as an angle twice, by atan(t) = 2 atan(t / (1 +
    sqrt(1 + t^2))), and goes into Taylor's series.
    """
    ax = abs(x)
    ay = abs(y)
    if ax == 0.0 and ay == 0.0:
        return 0.0
    t = ay / ax if ay <= ax else ax / ay
    t = t / (1.0 + sqrt(1.0 + t * t))
    t = t / (1.0 + sqrt(1.0 + t * t))
    z = t * t
    series = 0.0
    for k in range(13, 0, -1):
        series = z * ((-1.0 if k % 2 else 1.0) / (2.0 * k + 1.0) + series)
    angle = 4.0 * (t + t * series)
    if ay > ax:
        angle = _HALF_PI - angle
    if x < 0.0:
        angle = PI - angle
    return -angle if y < 0.0 else angle


@kernel
def log_above_one(z: float) -> float:
    """ln(1 + z) for z >= 0, as exact relative to its value for a small z as for a large one."""
    twos = 0.0
    while z > 0.5:
        z = (z - 1.0) / 2.0  # 1 + z halves
        twos += 1.0
    # ln(1 + z) = 2 artanh(z / (2 + z)); z is now in (-0.25, 0.5].
    t = z / (2.0 + z)
    square = t * t
    series = 0.0
    for k in range(12, 0, -1):
        series = square * (1.0 / (2.0 * k + 1.0) + series)
    return twos * _LN_2 + 2.0 * (t + t * series)
