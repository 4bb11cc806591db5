"""The radius within which a new vertex is connected, the same on every machine.

r(k) = min(gamma (log k / k)^(1/m), eta): m is d [Karaman2011] or d + 1 [Solovey2020], and d is the
number of a state's coordinates, 3 for places and times, 4 with a heading, 5 with a velocity.
Logarithm and roots are made of + - * / and sqrt, since those of mathematical libraries differ in
their last bit from machine to machine.
"""

import math

from conav.compiled import kernel

_LOG_2 = 0.6931471805599453


@kernel
def natural_log(x: float) -> float:
    """The natural logarithm of x > 0, to some 1e-15 of its size or of 1."""
    halvings = 0
    while x > 1.5:
        x *= 0.5
        halvings += 1
    while x < 0.75:
        x *= 2.0
        halvings -= 1
    # log x = 2 artanh((x - 1) / (x + 1)), whose argument is at most 1/5 in size.
    z = (x - 1.0) / (x + 1.0)
    square = z * z
    total = 0.0
    for n in range(12, -1, -1):
        total = total * square + 1.0 / (2 * n + 1)
    return 2.0 * z * total + halvings * _LOG_2


@kernel
def cube_root(x: float) -> float:
    """The cube root of x >= 0, to the last few bits, by Newton's method."""
    if x == 0.0:
        return 0.0
    scale = 1.0
    while x > 8.0:
        x *= 0.125
        scale *= 2.0
    while x < 1.0:
        x *= 8.0
        scale *= 0.5
    root = 1.0 + (x - 1.0) / 7.0
    for _ in range(6):
        root = (2.0 * root + x / (root * root)) / 3.0
    return scale * root


@kernel
def fifth_root(x: float) -> float:
    """The fifth root of 0 <= x <= 1, to the last few bits, by Newton's method from above."""
    if x == 0.0:
        return 0.0
    root = 1.0
    for _ in range(200):  # a fifth is taken away at least while it is far above
        fourth = root * root * root * root
        after = (4.0 * root + x / fourth) / 5.0
        if after >= root:
            break
        root = after
    return root


@kernel
def connection_radius(count: int, gamma: float, eta: float, exponent: int) -> float:
    """The radius [m] for the vertex that makes them `count`, by exponent 3, 4, 5 or 6."""
    if count < 2:
        return eta
    share = natural_log(float(count)) / count
    if exponent == 3:
        root = cube_root(share)
    elif exponent == 4:
        root = math.sqrt(math.sqrt(share))
    elif exponent == 5:
        root = fifth_root(share)
    else:
        root = math.sqrt(cube_root(share))
    return min(gamma * root, eta)


def default_gamma(area_m2: float, extent_m: float) -> float:
    """The least gamma of RRG in the plane and time [Karaman2011], times what the cone takes away.

    gamma = 2 (1 + 1/3)^(1/3) (mu / zeta)^(1/3) with mu the measure of places and times, v t in
    metres, and zeta the unit ball's. Of a ball only the cones of what can be reached count, a share
    of (1 - 1/sqrt 2) / 2 on each side: gamma is larger by the cube root of its inverse, 1.9.
    """
    ball = 4.18879020478639
    cone = 0.14644660940672624
    return 2.0 * cube_root(4.0 / 3.0 * area_m2 * extent_m / ball / cone)
