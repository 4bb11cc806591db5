"""Which regions a robot is in, and when that changes: its word.

Between the times at which a piece meets a border, in closed form, it is either in a region or not,
which its middle tells. All is read three times, with regions as they are, and all a little larger
and a little smaller: a word that depends on less than the tolerance may be read either way.
"""

from itertools import pairwise, product
from math import hypot, inf, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from conav.planning.verify_curves import place_at
from conav.planning.verify_scene import TOLERANCE, Area

Word = tuple[frozenset[str], ...]
Stays = list[tuple[float, float]]

_INSTANT = 1e-9  # [s] shorter changes are rounding
_ALL = 4  # regions of which every combination of readings is tried


def words(track: NDArray[np.float64], areas: dict[str, Area]) -> list[Word]:
    """The words of a trajectory, as it is first, then those that differ by less than the tolerance.

    Robots have one word, except where they all but touch a border.
    """
    offsets = (0.0, TOLERANCE, -TOLERANCE)
    stays = {
        (name, offset): stays_in(track, area, offset)
        for name, area in areas.items()
        for offset in offsets
    }
    begin, end = float(track[0, 0]), float(track[-1, 1])

    def word(reading: dict[str, float]) -> Word:
        return _word({name: stays[name, offset] for name, offset in reading.items()}, begin, end)

    found = [word(dict.fromkeys(areas, offset)) for offset in offsets]
    if found[0] == found[1] == found[2]:
        return found[:1]
    unsure = [
        name
        for name in areas
        if len({_changes(stays[name, offset], begin, end) for offset in offsets}) > 1
    ]
    if len(unsure) <= _ALL:
        found += [
            word({**dict.fromkeys(areas, rest), **dict(zip(unsure, choice, strict=True))})
            for choice in product(offsets, repeat=len(unsure))
            for rest in offsets
        ]
    return list(dict.fromkeys(found))


def stays_in(track: NDArray[np.float64], area: Area, offset: float) -> Stays:
    """When a trajectory is in a region made larger by so much on all sides, in order [s]."""
    found: Stays = []
    for piece in track:
        begin, end = float(piece[0]), float(piece[1])
        times = [begin, *sorted(t for t in _meetings(piece, area, offset) if begin < t < end), end]
        for t0, t1 in pairwise(times):
            if t1 - t0 <= _INSTANT and end - begin > _INSTANT:
                continue
            x, y = place_at(piece, (t0 + t1) / 2.0)
            if depth(area, x, y) + offset < -1e-12:
                continue
            if found and t0 - found[-1][1] <= _INSTANT:
                found[-1] = (found[-1][0], t1)
            else:
                found.append((t0, t1))
    return found


def depth(area: Area, x: float, y: float) -> float:
    """How far a place is inside a region, negative outside [m]."""
    if area.disc is not None:
        return area.disc[2] - hypot(x - area.disc[0], y - area.disc[1])
    corners = area.corners
    assert corners is not None
    x0, y0 = corners.T
    x1, y1 = np.roll(corners, -1, axis=0).T
    dx, dy = x1 - x0, y1 - y0
    square = dx * dx + dy * dy
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.where(square > 0, ((x - x0) * dx + (y - y0) * dy) / square, 0.0).clip(0.0, 1.0)
        crossed = ((y0 > y) != (y1 > y)) & (x0 + (y - y0) / dy * dx > x)
    away = float(np.hypot(x - x0 - s * dx, y - y0 - s * dy).min())
    return away if crossed.sum() % 2 else -away


def _word(stays: dict[str, Stays], begin: float, end: float) -> Word:
    """The sets of regions, one after the other."""
    times = sorted({begin, end, *(t for spans in stays.values() for span in spans for t in span)})
    spans = [(t0, t1) for t0, t1 in pairwise(times) if t1 - t0 > _INSTANT]
    word: list[frozenset[str]] = []
    for t0, t1 in spans or [(begin, end)]:
        t = (t0 + t1) / 2.0
        letter = frozenset(
            name for name, inside in stays.items() if any(a <= t <= b for a, b in inside)
        )
        if not word or word[-1] != letter:
            word.append(letter)
    return tuple(word)


def _changes(stays: Stays, begin: float, end: float) -> tuple[int, bool, bool]:
    starts_in = bool(stays) and stays[0][0] <= begin + _INSTANT
    return len(stays), starts_in, bool(stays) and stays[-1][1] >= end - _INSTANT


def _meetings(piece: NDArray[np.float64], area: Area, offset: float) -> list[float]:
    """Times at which a piece may meet the border of a region made larger; too many do no harm."""
    if area.disc is not None:
        x, y, radius = area.disc
        return _meets_circle(piece, x, y, radius + offset)
    corners = area.corners
    assert corners is not None
    found: list[float] = []
    middle = place_at(piece, (piece[0] + piece[1]) / 2.0)
    reach = _reach(piece) + abs(offset)
    for (x0, y0), (x1, y1) in zip(
        corners.tolist(), np.roll(corners, -1, axis=0).tolist(), strict=True
    ):
        length = hypot(x1 - x0, y1 - y0)
        if length == 0.0:
            continue
        nx, ny = (y1 - y0) / length, -(x1 - x0) / length
        c = nx * x0 + ny * y0
        if abs(nx * middle[0] + ny * middle[1] - c) > reach:
            continue
        for side in {offset, -offset}:
            found += _meets_line(piece, nx, ny, c + side)
        if offset != 0.0:
            found += _meets_circle(piece, x0, y0, abs(offset))
    return found


def _reach(piece: NDArray[np.float64]) -> float:
    """How far a piece is from its middle at most, and a little [m]."""
    half = float(piece[1] - piece[0]) / 2.0
    speed = hypot(piece[4], piece[5]) + 2.0 * half * hypot(piece[6], piece[7])
    return speed * half + 10.0 * TOLERANCE


def _meets_line(piece: NDArray[np.float64], nx: float, ny: float, c: float) -> list[float]:
    """Times at which n.p = c."""
    t0, _, x, y, vx, vy, ax, ay, turn = piece.tolist()
    if turn == 0.0:
        return [
            t0 + s
            for s in _roots((nx * ax + ny * ay) / 2.0, nx * vx + ny * vy, nx * x + ny * y - c)
        ]
    # n.p(s) = n.centre + u sin(turn s) + w cos(turn s)
    u, w = (nx * vx + ny * vy) / turn, (nx * vy - ny * vx) / turn
    return _on_arc(piece, u, w, c - (nx * x + ny * y) + w)


def _meets_circle(piece: NDArray[np.float64], cx: float, cy: float, r: float) -> list[float]:
    """Times at which the distance from (cx, cy) is r."""
    if r <= 0.0:
        return []
    t0, _, x, y, vx, vy, ax, ay, turn = piece.tolist()
    x, y = x - cx, y - cy
    if turn == 0.0 and ax == ay == 0.0:
        return [
            t0 + s
            for s in _roots(vx * vx + vy * vy, 2.0 * (x * vx + y * vy), x * x + y * y - r * r)
        ]
    if turn == 0.0:
        powers = [
            (ax * ax + ay * ay) / 4.0,
            ax * vx + ay * vy,
            vx * vx + vy * vy + x * ax + y * ay,
            2.0 * (x * vx + y * vy),
            x * x + y * y - r * r,
        ]
        roots = np.roots(powers)
        # Where it touches, two roots leave the real line together by the root of the rounding.
        return [t0 + float(root.real) for root in roots if abs(root.imag) < 1e-5]
    ux, uy = x - vy / turn, y + vx / turn  # the arc's centre
    wx, wy = vy / turn, -vx / turn  # from there to where it begins
    c = (r * r - ux * ux - uy * uy - wx * wx - wy * wy) / 2.0
    return _on_arc(piece, uy * wx - ux * wy, ux * wx + uy * wy, c)


def _on_arc(piece: NDArray[np.float64], u: float, w: float, c: float) -> list[float]:
    """Times of an arc at which u sin(turn s) + w cos(turn s) = c."""
    size = hypot(u, w)
    turn, duration = float(piece[8]), float(piece[1] - piece[0])
    if size == 0.0 or abs(c) > size * (1.0 + 1e-12):
        return []
    middle = float(np.arctan2(u, w))
    half = float(np.arccos(min(max(c / size, -1.0), 1.0)))
    found: list[float] = []
    whole = abs(turn) * duration
    for angle in (middle - half, middle + half):
        ahead = (angle if turn > 0.0 else -angle) % (2.0 * pi)
        while ahead <= whole:
            found.append(float(piece[0]) + ahead / abs(turn))
            ahead += 2.0 * pi
    return found


def _roots(a: float, b: float, c: float) -> list[float]:
    """Real roots of a s^2 + b s + c; those that rounding has just taken away too."""
    if a == 0.0:
        return [] if b == 0.0 else [-c / b]
    inner = b * b - 4.0 * a * c
    if inner < -1e-12 * max(b * b, abs(4.0 * a * c)):
        return []
    q = -(b + (sqrt(max(inner, 0.0)) if b >= 0.0 else -sqrt(max(inner, 0.0)))) / 2.0
    return [q / a, c / q if q != 0.0 else inf] if q != 0.0 else [0.0]
