"""How a Dubins car gets from one state to a later one.

A state is a row x, y [m], t [s], heading [rad]; limits are the top speed [m/s] and the radius of
the tightest turn [m]. The way is the shortest of the six words of [Dubins1957], found as in
[Shkel2001]; it is driven at the constant speed that takes just the time between the states, so any
duration from the shortest on is met.
"""

from math import floor, sqrt

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.geometry.elementary import PI, TWO_PI, arc_tangent, sin_cos
from conav.planning.piece import state_on_piece

PIECES = 3
"""Of a connection, at most."""
STATE = 4
"""Numbers of a state."""
SPEED, RADIUS = range(2)
"""Places in the limits."""

LSL, RSR, LSR, RSL, RLR, LRL = range(6)
WORDS = ("LSL", "RSR", "LSR", "RSL", "RLR", "LRL")

# The turn of each phase of each word: 1 left, -1 right, 0 straight.
_TURNS = np.array(
    [[1, 0, 1], [-1, 0, -1], [1, 0, -1], [-1, 0, 1], [-1, 1, -1], [1, -1, 1]], dtype=np.float64
)
_ROUNDING = 1e-12  # circles that touch may seem to overlap or to be apart by that much
_LESS_THAN_A_TURN = TWO_PI - 1e-12  # an angle beyond is rounding below none


@kernel
def connect_dubins(
    limits: NDArray[np.float64],
    states: NDArray[np.float64],
    tail: int,
    head: int,
    pieces: NDArray[np.float64],
) -> int:
    """The number of pieces from one of the states to a later one; 0: there is no way in time.

    They are written into `pieces`, shape (`PIECES`, PIECE). Complete: without an obstacle no way of
    a car is shorter.
    """
    begin = states[tail, 2]
    end = states[head, 2]
    if end <= begin:
        return 0
    radius = limits[RADIUS]
    word, first, second, third = shortest_word(
        states[tail, 0],
        states[tail, 1],
        states[tail, 3],
        states[head, 0],
        states[head, 1],
        states[head, 3],
        radius,
    )
    whole = first + second + third
    if whole > limits[SPEED] * (end - begin):
        return 0
    speed = whole / (end - begin)
    sine, cosine = sin_cos(states[tail, 3])
    x = states[tail, 0]
    y = states[tail, 1]
    vx = speed * cosine
    vy = speed * sine
    t = begin
    driven = 0.0
    count = 0
    for phase in range(3):
        metres = first if phase == 0 else (second if phase == 1 else third)
        if metres == 0.0:
            continue
        driven += metres
        until = begin + driven / speed
        if driven == whole:
            until = end
        pieces[count, 0] = t
        pieces[count, 1] = until
        pieces[count, 2] = x
        pieces[count, 3] = y
        pieces[count, 4] = vx
        pieces[count, 5] = vy
        pieces[count, 6] = 0.0
        pieces[count, 7] = 0.0
        pieces[count, 8] = _TURNS[word, phase] * speed / radius
        x, y, vx, vy = state_on_piece(pieces[count], until)
        t = until
        count += 1
    if count == 0:  # it stands where it is
        pieces[0, 0] = begin
        pieces[0, 1] = end
        pieces[0, 2] = x
        pieces[0, 3] = y
        for column in range(4, 9):
            pieces[0, column] = 0.0
        return 1
    pieces[count - 1, 1] = end
    return count


@kernel
def least_duration(
    limits: NDArray[np.float64], states: NDArray[np.float64], tail: int, head: int
) -> float:
    """Seconds that the way between two states takes at full speed; none is shorter."""
    _, first, second, third = shortest_word(
        states[tail, 0],
        states[tail, 1],
        states[tail, 3],
        states[head, 0],
        states[head, 1],
        states[head, 3],
        limits[RADIUS],
    )
    return (first + second + third) / limits[SPEED]


@kernel
def shortest_word(
    ax: float, ay: float, a_heading: float, bx: float, by: float, b_heading: float, radius: float
) -> tuple[int, float, float, float]:
    """The word of the shortest way, and the metres of its three phases.

    Of equals the first in the order of `WORDS`.
    """
    best = 0
    best_first = np.inf
    best_second = np.inf
    best_third = np.inf
    for word in range(6):
        first, second, third = word_lengths(word, ax, ay, a_heading, bx, by, b_heading, radius)
        if first + second + third < best_first + best_second + best_third:
            best = word
            best_first = first
            best_second = second
            best_third = third
    return best, best_first, best_second, best_third


@kernel
def word_lengths(
    word: int,
    ax: float,
    ay: float,
    a_heading: float,
    bx: float,
    by: float,
    b_heading: float,
    radius: float,
) -> tuple[float, float, float]:
    """The metres of the three phases of one word, infinite where it does not lead there.

    In units of the radius, in the frame in which the end lies on the x axis [Shkel2001].
    """
    dx = (bx - ax) / radius
    dy = (by - ay) / radius
    d = sqrt(dx * dx + dy * dy)
    line = arc_tangent(dy, dx)
    alpha = a_heading - line
    beta = b_heading - line
    sa, ca = sin_cos(alpha)
    sb, cb = sin_cos(beta)
    _, cab = sin_cos(alpha - beta)
    first = 0.0
    second = 0.0
    third = 0.0
    if word in (LSL, RSR):
        side = 1.0 if word == LSL else -1.0
        x = d + side * (sa - sb)
        y = side * (cb - ca)
        second = sqrt(x * x + y * y)
        ahead = arc_tangent(y, x) if second > 1e-12 else alpha
        first = _turn(side * (ahead - alpha))
        third = _turn(side * (beta - ahead))
    elif word in (LSR, RSL):
        side = 1.0 if word == LSR else -1.0
        square = d * d - 2.0 + 2.0 * cab + 2.0 * side * d * (sa + sb)
        if square < -_ROUNDING:
            return np.inf, np.inf, np.inf
        second = sqrt(max(square, 0.0))
        x = d + side * (sa + sb)
        y = -side * (ca + cb)
        ahead = arc_tangent(y, x) + side * arc_tangent(2.0, second)
        first = _turn(side * (ahead - alpha))
        third = _turn(side * (ahead - beta))
    else:
        side = 1.0 if word == LRL else -1.0
        x = d + side * (sa - sb)
        y = side * (cb - ca)
        # The circles at the ends are 4 sin(half of the angle between) apart.
        half = 0.25 * sqrt(x * x + y * y)
        if half > 1.0 + _ROUNDING:
            return np.inf, np.inf, np.inf
        half = min(half, 1.0)
        corner = arc_tangent(half, sqrt((1.0 - half) * (1.0 + half)))  # arc sine
        second = TWO_PI - 2.0 * corner
        ahead = arc_tangent(y, x)
        first = _turn(side * (ahead - alpha) + PI - corner)
        third = _turn(side * (beta - alpha) - first + second)
    return first * radius, second * radius, third * radius


@kernel
def _turn(angle: float) -> float:
    """The angle between none and a whole turn."""
    rest = angle - TWO_PI * floor(angle / TWO_PI)
    return 0.0 if rest > _LESS_THAN_A_TURN or rest < 1e-15 else rest
