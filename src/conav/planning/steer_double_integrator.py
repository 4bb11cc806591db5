"""How a double integrator gets from one state to a later one.

A state is a row x, y [m], t [s], vx, vy [m/s]; limits are the top speed [m/s] and the bound on the
norm of the acceleration [m/s^2]. A way has three phases at most, each of constant acceleration:
from the first velocity to one in between, on at that, from there to the last velocity. With phases
of a, b and c seconds, a + b + c being the time between the states, the velocity in between is

    w = (dp - a v0 / 2 - c v1 / 2) / (T - a / 2 - c / 2),

whatever a and c are, and the end is met exactly. The shorter a and c, the nearer the way is to the
straight one at constant speed.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel

PIECES = 3
"""Of a connection, at most."""
STATE = 5
"""Numbers of a state."""
SPEED, ACCELERATION = range(2)
"""Places in the limits."""

_SPARE = 1.0 + 1e-9  # by which limits may be passed, which is rounding
_SHORTEST = 1e-3  # [s] of an end phase; times are too coarse for much shorter ones
_ROUNDS = 20
_NEWTON_ROUNDS = 60
_HALVINGS = 60


@kernel
def connect_double_integrator(
    limits: NDArray[np.float64],
    states: NDArray[np.float64],
    tail: int,
    head: int,
    pieces: NDArray[np.float64],
) -> int:
    """The number of pieces from one of the states to a later one; 0: none was found.

    They are written into `pieces`, shape (`PIECES`, PIECE). First the shortest end phases that the
    bound on the acceleration allows, by repeated substitution; then two phases with the least
    acceleration; then those made shorter until the speed is low enough. Not complete: where the
    bounds leave hardly any room a way can be missed.
    """
    t = states[tail, 2]
    duration = states[head, 2] - t
    dx = states[head, 0] - states[tail, 0]
    dy = states[head, 1] - states[tail, 1]
    ux = states[tail, 3]
    uy = states[tail, 4]
    vx = states[head, 3]
    vy = states[head, 4]
    speed = limits[SPEED] * _SPARE
    bound = limits[ACCELERATION] * _SPARE
    if duration <= 0.0 or least_duration(limits, states, tail, head) > duration:
        return 0
    first, last = _short_phases(dx, dy, ux, uy, vx, vy, duration, limits[ACCELERATION])
    if not _keeps(dx, dy, ux, uy, vx, vy, duration, first, last, speed, bound):
        # One acceleration all along is met by halves; for it any time is one of an even switch.
        first = 0.5 * duration
        last = duration - first
        if not _keeps(dx, dy, ux, uy, vx, vy, duration, first, last, speed, bound):
            first = _even_switch(dx, dy, ux, uy, vx, vy, duration)
            last = duration - first
        if not _keeps(dx, dy, ux, uy, vx, vy, duration, first, last, speed, bound):
            share = _slow_share(dx, dy, ux, uy, vx, vy, duration, first, last, speed)
            first *= share
            last *= share
            if not _keeps(dx, dy, ux, uy, vx, vy, duration, first, last, speed, bound):
                return 0
    wx, wy = _between(dx, dy, ux, uy, vx, vy, duration, first, last)
    x = states[tail, 0]
    y = states[tail, 1]
    count = 0
    if first > 0.0:
        _put(pieces, count, t, t + first, x, y, ux, uy, wx, wy)
        x += 0.5 * first * (ux + wx)
        y += 0.5 * first * (uy + wy)
        count += 1
    steady = states[head, 2] - last
    if steady > t + first + 1e-12 * duration or (first == 0.0 and last == 0.0):
        _put(pieces, count, t + first, steady, x, y, wx, wy, wx, wy)
        count += 1
    if last > 0.0:
        # Backwards from the end, so that this is met to the last digit.
        x = states[head, 0] - 0.5 * last * (wx + vx)
        y = states[head, 1] - 0.5 * last * (wy + vy)
        begin = pieces[count - 1, 1] if count > 0 else t
        _put(pieces, count, begin, states[head, 2], x, y, wx, wy, vx, vy)
        count += 1
    return count


@kernel
def least_duration(
    limits: NDArray[np.float64], states: NDArray[np.float64], tail: int, head: int
) -> float:
    """Seconds that no way between two states is shorter than.

    The velocity has to change, the distance to be driven, and along the line between the places
    and across it a body on a line with the same bounds has to come from one state to the other.
    """
    dx = states[head, 0] - states[tail, 0]
    dy = states[head, 1] - states[tail, 1]
    away = sqrt(dx * dx + dy * dy)
    ux = states[tail, 3]
    uy = states[tail, 4]
    vx = states[head, 3]
    vy = states[head, 4]
    speed = limits[SPEED] * _SPARE
    bound = limits[ACCELERATION] * _SPARE
    turn = sqrt((vx - ux) * (vx - ux) + (vy - uy) * (vy - uy))
    least = max(away / speed, turn / bound)
    cx = 1.0
    cy = 0.0
    if away > 0.0:
        cx = dx / away
        cy = dy / away
    along = _least_on_line(away, ux * cx + uy * cy, vx * cx + vy * cy, speed, bound)
    across = _least_on_line(0.0, uy * cx - ux * cy, vy * cx - vx * cy, speed, bound)
    return max(least, max(along, across)) / _SPARE


@kernel
def _least_on_line(d: float, u: float, v: float, speed: float, bound: float) -> float:
    """The least time to go d with first and last velocity u and v on a line.

    Which way full acceleration goes first says the distance that comes of merely changing the
    velocity. Just there the time can jump, and the shorter one counts.
    """
    change = 0.5 * (u + v) * abs(v - u) / bound
    least = np.inf
    if d >= change - 1e-9:
        least = _least_forwards(d, u, v, speed, bound)
    if d <= change + 1e-9:
        least = min(least, _least_forwards(-d, -u, -v, speed, bound))
    return least


@kernel
def _least_forwards(d: float, u: float, v: float, speed: float, bound: float) -> float:
    """Full acceleration forwards, full speed if it is reached, full acceleration backwards."""
    square = max(bound * d + 0.5 * (u * u + v * v), 0.0)
    if square <= speed * speed:
        return (2.0 * sqrt(square) - u - v) / bound
    return (2.0 * speed - u - v) / bound + (square - speed * speed) / (bound * speed)


@kernel
def _between(
    dx: float,
    dy: float,
    ux: float,
    uy: float,
    vx: float,
    vy: float,
    duration: float,
    first: float,
    last: float,
) -> tuple[float, float]:
    """The velocity in between."""
    whole = duration - 0.5 * (first + last)
    return (
        (dx - 0.5 * (first * ux + last * vx)) / whole,
        (dy - 0.5 * (first * uy + last * vy)) / whole,
    )


@kernel
def _keeps(
    dx: float,
    dy: float,
    ux: float,
    uy: float,
    vx: float,
    vy: float,
    duration: float,
    first: float,
    last: float,
    speed: float,
    bound: float,
) -> bool:
    """Whether phases keep the limits."""
    if not (first >= 0.0 and last >= 0.0 and first + last <= duration):
        return False
    floor = 0.1 * min(_SHORTEST, 0.25 * duration)
    if 0.0 < first < floor or 0.0 < last < floor:
        return False
    wx, wy = _between(dx, dy, ux, uy, vx, vy, duration, first, last)
    if wx * wx + wy * wy > speed * speed:
        return False
    gain_x = wx - ux
    gain_y = wy - uy
    if gain_x * gain_x + gain_y * gain_y > first * first * bound * bound:
        return False
    gain_x = vx - wx
    gain_y = vy - wy
    return gain_x * gain_x + gain_y * gain_y <= last * last * bound * bound


@kernel
def _short_phases(
    dx: float,
    dy: float,
    ux: float,
    uy: float,
    vx: float,
    vy: float,
    duration: float,
    bound: float,
) -> tuple[float, float]:
    """The end phases that full acceleration needs; -1, -1 where none are found.

    By repeated substitution; where that is slow, which is where hardly any time is to spare and two
    solutions are about to meet, by Newton's method on from there.
    """
    first = 0.0
    last = 0.0
    floor = min(_SHORTEST, 0.25 * duration)
    for turn in range(_ROUNDS + _NEWTON_ROUNDS):
        wx, wy = _between(dx, dy, ux, uy, vx, vy, duration, first, last)
        gain = sqrt((wx - ux) * (wx - ux) + (wy - uy) * (wy - uy))
        loss = sqrt((vx - wx) * (vx - wx) + (vy - wy) * (vy - wy))
        new_first = gain / bound
        new_last = loss / bound
        if new_first > 0.0:
            new_first = max(new_first, floor)
        if new_last > 0.0:
            new_last = max(new_last, floor)
        moved = abs(new_first - first) + abs(new_last - last)
        if moved <= 1e-15 * duration:
            break
        if turn >= _ROUNDS:
            # The derivatives of w are (w - u) / whole and (w - v) / whole, whole = 2T - a - c; a
            # phase at its shortest does not change.
            whole = 2.0 * duration - first - last
            mixed = (wx - ux) * (wx - vx) + (wy - uy) * (wy - vy)
            a, b, c, d = -1.0, 0.0, 0.0, -1.0
            if new_first > floor:
                a += new_first / whole
                b = mixed / (whole * bound * gain)
            if new_last > floor:
                c = mixed / (whole * bound * loss)
                d += new_last / whole
            determinant = a * d - b * c
            if determinant != 0.0:
                miss_first = new_first - first
                miss_last = new_last - last
                new_first = first - (d * miss_first - b * miss_last) / determinant
                new_last = last - (a * miss_last - c * miss_first) / determinant
        if not (new_first >= 0.0 and new_last >= 0.0 and new_first + new_last <= duration):
            return -1.0, -1.0
        first = new_first
        last = new_last
    return first, last


@kernel
def _even_switch(
    dx: float, dy: float, ux: float, uy: float, vx: float, vy: float, duration: float
) -> float:
    """How long the first of two phases lasts for both to need the same acceleration.

    The first needs without end when it is short, the second when that is, so there is such a time.
    """
    low = 0.0
    high = duration
    for _ in range(_HALVINGS):
        first = 0.5 * (low + high)
        last = duration - first
        wx, wy = _between(dx, dy, ux, uy, vx, vy, duration, first, last)
        before = ((wx - ux) * (wx - ux) + (wy - uy) * (wy - uy)) * last * last
        after = ((vx - wx) * (vx - wx) + (vy - wy) * (vy - wy)) * first * first
        if before > after:
            low = first
        else:
            high = first
    return 0.5 * (low + high)


@kernel
def _slow_share(
    dx: float,
    dy: float,
    ux: float,
    uy: float,
    vx: float,
    vy: float,
    duration: float,
    first: float,
    last: float,
    speed: float,
) -> float:
    """The greatest share of both phases with which the velocity in between is not too high."""
    low = 0.0
    high = 1.0
    for _ in range(_HALVINGS):
        share = 0.5 * (low + high)
        wx, wy = _between(dx, dy, ux, uy, vx, vy, duration, share * first, share * last)
        if wx * wx + wy * wy <= speed * speed:
            low = share
        else:
            high = share
    return low


@kernel
def _put(
    pieces: NDArray[np.float64],
    row: int,
    begin: float,
    end: float,
    x: float,
    y: float,
    ux: float,
    uy: float,
    vx: float,
    vy: float,
) -> None:
    """Writes the piece that begins at (x, y) and changes its velocity from u to v."""
    pieces[row, 0] = begin
    pieces[row, 1] = end
    pieces[row, 2] = x
    pieces[row, 3] = y
    pieces[row, 4] = ux
    pieces[row, 5] = uy
    pieces[row, 6] = (vx - ux) / (end - begin)
    pieces[row, 7] = (vy - uy) / (end - begin)
    pieces[row, 8] = 0.0
