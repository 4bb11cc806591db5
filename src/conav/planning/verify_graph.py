"""The edges of a robot's graph from its vertices alone, by the rule in docs/verify.md.

Every pair of vertices is looked at. What rounding could decide either way is told apart: an edge is
sure, or it is perhaps one.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.compiled import kernel
from conav.planning.verify_curves import point_to_segment, segment_to_segment

SURE, PERHAPS = 2, 1

_SAME = 1e-9  # [m] borders met within that count as met together
_CLOSE = 1e-8  # [m] up to which the rule may see it otherwise
_EVENTS = 256


class Rule(NamedTuple):
    """What decides about edges beside the scene."""

    eta: float  # [m]
    gamma: float  # [m]
    root: int  # 3 or 4
    forward: bool  # edges in both directions of insertion


class Edges(NamedTuple):
    """Edges in the order of falling times of their tails."""

    tails: NDArray[np.int64]
    heads: NDArray[np.int64]
    sure: NDArray[np.bool_]
    first: NDArray[np.int64]  # (edges + 1,) where each one's new labels begin in `labels`
    labels: NDArray[np.int64]  # masks of regions


def default_gamma(area_m2: float, speed: float, horizon: float) -> float:
    """The factor of the radius where the settings have none.

    2 (1 + 1/3)^(1/3) (mu / zeta)^(1/3), mu being area times speed times horizon and zeta the ball's
    volume, of which the two cones of what can be reached are the share (1 - sqrt 1/2) / 2 each.
    """
    ball = 4.0 / 3.0 * np.pi * (1.0 - np.sqrt(0.5)) / 2.0
    return float(2.0 * np.cbrt(4.0 / 3.0 * area_m2 * speed * horizon / ball))


def radii(count: int, rule: Rule) -> NDArray[np.float64]:
    """The radius for each vertex by its number, (count,) [m]."""
    k = np.arange(1, count + 1, dtype=np.float64)
    found = np.minimum(rule.gamma * (np.log(k) / k) ** (1.0 / rule.root), rule.eta)
    found[:1] = rule.eta
    return found


def edges_of(
    vertices: NDArray[np.float64],
    rule: Rule,
    speed: float,
    shapes: NDArray[np.float64],
    discs: NDArray[np.float64],
    rings: NDArray[np.int64],
    sides: NDArray[np.float64],
) -> Edges:
    """All edges between vertices, (n, 3) x, y, t.

    `shapes`, (m, 5): segments x0, y0, x1, y1 and how far the centre stays away. Regions are
    `discs`, (k, 3), then polygons: of each the first and last side in `sides`, (., 4).
    """
    order = np.argsort(-vertices[:, 2], kind="stable")
    reach = radii(len(vertices), rule)
    room = 64 * len(vertices) + 1024
    while True:
        pairs = np.empty((room, 3), np.int64)
        first = np.empty(room + 1, np.int64)
        labels = np.empty(4 * room, np.int64)
        count = _edges(
            vertices, order, reach, speed, rule.forward, shapes, discs, rings, sides,
            pairs, first, labels,
        )  # fmt: skip
        if count >= 0:
            return Edges(
                pairs[:count, 0], pairs[:count, 1], pairs[:count, 2] == SURE,
                first[: count + 1], labels[: first[count]],
            )  # fmt: skip
        room *= 4


@kernel
def _edges(
    vertices: NDArray[np.float64],
    order: NDArray[np.int64],
    reach: NDArray[np.float64],
    speed: float,
    forward: bool,
    shapes: NDArray[np.float64],
    discs: NDArray[np.float64],
    rings: NDArray[np.int64],
    sides: NDArray[np.float64],
    pairs: NDArray[np.int64],
    first: NDArray[np.int64],
    labels: NDArray[np.int64],
) -> int:
    """How many edges there are; -1: the arrays are too short."""
    times = np.empty(_EVENTS)
    letters = np.empty(_EVENTS, np.int64)
    count = 0
    used = 0
    first[0] = 0
    near = np.empty(len(shapes), np.int64)  # shapes that an edge from this tail may meet
    spares = np.empty(len(shapes))  # how much farther the tail is from each than it must be
    farthest = reach.max() * (1.0 + 1e-9)
    for i in range(len(order)):
        u = order[i]
        beside = -1  # how many shapes are near; -1: not yet looked for
        for j in range(i - 1, -1, -1):
            w = order[j]
            dt = vertices[w, 2] - vertices[u, 2]
            cone = speed * dt
            if cone > farthest:  # and so are all that are later
                break
            if dt <= 0.0 or (not forward and u > w):
                continue
            radius = reach[max(u, w)]
            if cone > radius * (1.0 + 1e-12):
                continue
            dx = vertices[w, 0] - vertices[u, 0]
            dy = vertices[w, 1] - vertices[u, 1]
            plane = np.hypot(dx, dy)
            away = np.hypot(plane, cone)
            if plane > cone * (1.0 + 1e-12) or away > radius * (1.0 + 1e-12):
                continue
            sure = plane <= cone * (1.0 - 1e-12) and away <= radius * (1.0 - 1e-12)
            ax, ay = vertices[u, 0], vertices[u, 1]
            bx, by = vertices[w, 0], vertices[w, 1]
            spare = np.inf
            if beside < 0:
                beside = _shapes_near(ax, ay, farthest, shapes, near, spares)
            for c in range(beside):
                if spares[c] > plane + 2e-9:
                    continue
                k = near[c]
                gap = segment_to_segment(
                    ax, ay, bx, by, shapes[k, 0], shapes[k, 1], shapes[k, 2], shapes[k, 3]
                )
                spare = min(spare, gap - shapes[k, 4])
                if spare < -1e-9:
                    break
            if spare < -1e-9:
                continue
            sure = sure and spare > 1e-9
            changes, clear = line_word(ax, ay, bx, by, discs, rings, sides, times, letters)
            if changes < 0 or (changes > 1 and not forward):
                continue
            if count + 1 >= len(pairs) or used + changes > len(labels):
                return -1
            for k in range(changes):
                labels[used + k] = letters[k]
            used += changes
            pairs[count, 0] = u
            pairs[count, 1] = w
            pairs[count, 2] = SURE if sure and clear else PERHAPS
            count += 1
            first[count] = used
    return count


@kernel
def _shapes_near(
    x: float,
    y: float,
    reach: float,
    shapes: NDArray[np.float64],
    near: NDArray[np.int64],
    spares: NDArray[np.float64],
) -> int:
    """How many shapes somebody may touch who goes so far from a place; written into `near`."""
    count = 0
    for k in range(len(shapes)):
        far = reach + shapes[k, 4] + 2e-9
        if (
            x - max(shapes[k, 0], shapes[k, 2]) > far
            or min(shapes[k, 0], shapes[k, 2]) - x > far
            or y - max(shapes[k, 1], shapes[k, 3]) > far
            or min(shapes[k, 1], shapes[k, 3]) - y > far
        ):
            continue
        away = point_to_segment(x, y, shapes[k, 0], shapes[k, 1], shapes[k, 2], shapes[k, 3])
        if away <= far:
            near[count] = k
            spares[count] = away - shapes[k, 4]
            count += 1
    return count


@kernel
def label_at(
    x: float,
    y: float,
    discs: NDArray[np.float64],
    rings: NDArray[np.int64],
    sides: NDArray[np.float64],
) -> int:
    """The mask of the regions a place is in: discs, then polygons."""
    mask = 0
    for i in range(len(discs)):
        if np.hypot(x - discs[i, 0], y - discs[i, 1]) <= discs[i, 2]:
            mask |= 1 << i
    for i in range(len(rings)):
        odd = False
        for k in range(rings[i, 0], rings[i, 1]):
            x0, y0, x1, y1 = sides[k, 0], sides[k, 1], sides[k, 2], sides[k, 3]
            if (y0 > y) != (y1 > y) and x0 + (y - y0) / (y1 - y0) * (x1 - x0) > x:
                odd = not odd
        if odd:
            mask |= 1 << (len(discs) + i)
    return mask


@kernel
def line_word(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    discs: NDArray[np.float64],
    rings: NDArray[np.int64],
    sides: NDArray[np.float64],
    times: NDArray[np.float64],
    letters: NDArray[np.int64],
) -> tuple[int, bool]:
    """How many new labels a straight way meets, and whether rounding has no say in them.

    They are written into `letters`. Borders that are met together are entered first and left then.
    """
    dx = bx - ax
    dy = by - ay
    length = np.hypot(dx, dy)
    if length == 0.0:
        return 0, True
    clear = True
    count = 0
    for i in range(len(discs)):
        x = discs[i, 0] - ax
        y = discs[i, 1] - ay
        along = (x * dx + y * dy) / length
        off = abs(x * dy - y * dx) / length
        r = discs[i, 2]
        if abs(off - r) <= _CLOSE and -_CLOSE < along < length + _CLOSE:
            clear = False
        if off < r:
            half = np.sqrt(r * r - off * off)
            for end in range(2):
                s = along - half if end == 0 else along + half
                if abs(s) <= _CLOSE or abs(s - length) <= _CLOSE:
                    clear = False
                if 0.0 < s < length:
                    if count == _EVENTS:
                        return -1, False
                    times[count] = s
                    count += 1
    for k in range(len(sides)):
        x0, y0, x1, y1 = sides[k, 0], sides[k, 1], sides[k, 2], sides[k, 3]
        if (
            min(ax, bx) > max(x0, x1) + _CLOSE
            or max(ax, bx) < min(x0, x1) - _CLOSE
            or min(ay, by) > max(y0, y1) + _CLOSE
            or max(ay, by) < min(y0, y1) - _CLOSE
        ):
            continue
        if point_to_segment(x0, y0, ax, ay, bx, by) <= _CLOSE:
            clear = False
        if point_to_segment(ax, ay, x0, y0, x1, y1) <= _CLOSE:
            clear = False
        if point_to_segment(bx, by, x0, y0, x1, y1) <= _CLOSE:
            clear = False
        ex = x1 - x0
        ey = y1 - y0
        across = dx * ey - dy * ex
        if across == 0.0:
            continue
        s = ((x0 - ax) * ey - (y0 - ay) * ex) / across
        u = ((x0 - ax) * dy - (y0 - ay) * dx) / across
        if 0.0 < s < 1.0 and 0.0 <= u <= 1.0:
            if count == _EVENTS:
                return -1, False
            times[count] = s * length
            count += 1
    for i in range(1, count):  # insertion sort
        s = times[i]
        k = i - 1
        while k >= 0 and times[k] > s:
            times[k + 1] = times[k]
            k -= 1
        times[k + 1] = s
    mask = label_at(ax, ay, discs, rings, sides)
    found = 0
    i = 0
    while i < count:
        last = i
        while last + 1 < count and times[last + 1] - times[last] <= _SAME:
            last += 1
        after = times[last + 1] if last + 1 < count else length
        if last + 1 < count and after - times[last] <= _CLOSE:
            clear = False
        if times[last] > times[i] + 0.1 * _SAME:
            clear = False
        s = 0.5 * (times[last] + after) / length
        now = label_at(ax + s * dx, ay + s * dy, discs, rings, sides)
        if found + 2 > _EVENTS:
            return -1, False
        if (mask | now) != mask and (mask | now) != now:
            letters[found] = mask | now
            found += 1
        if now != mask:
            letters[found] = now
            found += 1
        mask = now
        i = last + 1
    return found, clear
