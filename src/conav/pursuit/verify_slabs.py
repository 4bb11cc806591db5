"""Hidden regions of one motion a second time: slow, exact, and straight from the definitions.

Python's own integers and fractions, nothing else; it shares no code with the fast decision. The
plane is cut into upright slabs at every point where two segments meet, each slab by the segments
into cells, and each cell is asked at one point of it who sees it. This is what checks certificates.
"""

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from math import lcm
from typing import NamedTuple

Point = tuple[int, int]
Place = tuple[Fraction, Fraction]
Segment = tuple[Place, Place]


class View(NamedTuple):
    """One pursuer during one motion."""

    before: Point
    after: Point
    reach_before: Sequence[Point]  # convex, counter-clockwise: what is in range; empty: everything
    reach_after: Sequence[Point]
    limited: bool  # its range
    old: bool
    new: bool
    throughout: bool


class Cells(NamedTuple):
    """What a motion does to evaders."""

    links: list[list[bool]]  # [old shadow][new shadow]
    old_at: list[int]  # the old shadow each of the points asked for lies in, -1 in none
    new_at: list[int]  # the new shadow each of the other points lies in
    n_old: int
    n_new: int


def cross(
    a: Sequence[Fraction | int], b: Sequence[Fraction | int], c: Sequence[Fraction | int]
) -> Fraction | int:
    """Positive where c is left of the line from a to b."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def walls_of(rings: Iterable[Sequence[Point]]) -> list[tuple[Point, Point]]:
    """The walls of rings of corners."""
    return [(ring[i], ring[(i + 1) % len(ring)]) for ring in rings for i in range(len(ring))]


def chords(rings: Sequence[Sequence[Point]], p: Point) -> list[Segment]:
    """Segments on which every border of p's view within the floor lies.

    From each corner that no wall hides from p, straight away from p, to the next wall.
    """
    walls = walls_of(rings)
    result: list[Segment] = []
    size = 1 + 2 * max(abs(number) for ring in rings for corner in ring for number in corner)
    for v in (corner for ring in rings for corner in ring):
        if v == p or any(_crosses(p, v, c, d) for c, d in walls):
            continue
        end = Fraction(size)  # in lengths of p to v, one unit at least: beyond the floor
        for c, d in walls:
            if cross(p, v, c) * cross(p, v, d) < 0:
                # At p + t (v - p) the ray meets the wall's line.
                t = Fraction(cross(c, d, p), cross(c, d, p) - cross(c, d, v))
                if 1 < t < end:
                    end = t
        far = (p[0] + end * (v[0] - p[0]), p[1] + end * (v[1] - p[1]))
        result.append(((Fraction(v[0]), Fraction(v[1])), far))
    return result


def _crosses(a: Point, b: Point, c: Point, d: Point) -> bool:
    return cross(a, b, c) * cross(a, b, d) < 0 and cross(c, d, a) * cross(c, d, b) < 0


def cells(
    rings: Sequence[Sequence[Point]],
    views: Sequence[View],
    instant: bool,
    old_points: Sequence[Place],
    new_points: Sequence[Place],
) -> Cells:
    """The shadows before and after a motion and who may get from which to which unseen."""
    walls = walls_of(rings)
    whole: list[Segment] = [(_place(a), _place(b)) for a, b in walls]
    borders: list[Segment] = []
    for view in views:
        ends = [(view.before, view.reach_before)]
        if view.after != view.before:
            ends.append((view.after, view.reach_after))
        for p, reach in ends:
            borders += chords(rings, p)
            borders += [(_place(a), _place(b)) for a, b in walls_of([reach])]
    grid = _Slabs(whole, borders)
    hidden: tuple[list[bool], list[bool], list[bool]] = ([], [], [])
    for low, high, x, next_x in grid.cells:
        q = _generic(low, high, x, next_x, rings, views)
        old = new = throughout = False
        for view in views:
            first = _in_reach(q, view.reach_before) and _sees(q, view.before, walls)
            if view.after == view.before:
                last = always = first
            else:
                last = _in_reach(q, view.reach_after) and _sees(q, view.after, walls)
                always = first and last and not _encloses(q, view, rings)
            old |= view.old and first
            new |= view.new and last
            throughout |= view.throughout and always
        for flags, seen in zip(hidden, (old, new, throughout), strict=True):
            flags.append(not seen)
    corners = [corner for ring in rings for corner in ring]
    free = [view for view in views if not view.limited]

    def shown(p: Point, q: Place) -> bool:
        in_line = any(cross(p, v, q) == 0 for v in corners if v != p)
        return in_line and in_floor(walls, p, q)

    def closed_old(q: Place) -> bool:
        return any(view.old and shown(view.before, q) for view in free)

    def closed_new(q: Place) -> bool:
        return any(view.new and shown(view.after, q) for view in free)

    def closed(q: Place) -> bool:
        return any(
            view.throughout
            and cross(view.before, view.after, q) == 0
            and shown(view.before, q)
            and shown(view.after, q)
            for view in free
        )

    shadow_old, n_old = grid.components(hidden[0], closed_old)
    shadow_new, n_new = grid.components(hidden[1], closed_new)
    between, n_between = grid.components(hidden[2], closed)
    met: list[tuple[set[int], set[int]]] = [(set(), set()) for _ in range(n_between)]
    links = [[False] * n_new for _ in range(n_old)]
    for k, component in enumerate(between):
        if component < 0:
            continue
        if instant:
            links[shadow_old[k]][shadow_new[k]] = True
        if shadow_old[k] >= 0:
            met[component][0].add(shadow_old[k])
        if shadow_new[k] >= 0:
            met[component][1].add(shadow_new[k])
    if not instant:
        for olds, news in met:
            for i in olds:
                for j in news:
                    links[i][j] = True
    return Cells(
        links,
        [grid.at(point, shadow_old) for point in old_points],
        [grid.at(point, shadow_new) for point in new_points],
        n_old,
        n_new,
    )


def _place(p: Point) -> Place:
    return Fraction(p[0]), Fraction(p[1])


def in_floor(walls: list[tuple[Point, Point]], a: Point, b: Point | Place) -> bool:
    """Whether the segment from a to b lies in the closed floor."""
    cuts = {Fraction(0), Fraction(1)}
    length = (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2
    for c, d in walls:
        of_a, of_b = cross(c, d, a), cross(c, d, b)
        if of_a != of_b:
            cuts.add(Fraction(of_a) / (of_a - of_b))
        for corner in (c, d):
            if length and cross(a, b, corner) == 0:
                along = (corner[0] - a[0]) * (b[0] - a[0]) + (corner[1] - a[1]) * (b[1] - a[1])
                cuts.add(Fraction(along) / length)
    stops = sorted(cut for cut in cuts if 0 <= cut <= 1)
    middles = [*stops, *((one + two) / 2 for one, two in pairwise(stops))]
    return all(
        _on_floor(walls, (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))) for t in middles
    )


def _on_floor(walls: list[tuple[Point, Point]], q: Place) -> bool:
    inside = False
    for c, d in walls:
        where = cross(c, d, q)
        between = (q[0] - c[0]) * (q[0] - d[0]) + (q[1] - c[1]) * (q[1] - d[1]) <= 0
        if where == 0 and between:
            return True
        if (c[1] <= q[1] < d[1] and where > 0) or (d[1] <= q[1] < c[1] and where < 0):
            inside = not inside
    return inside


class _Witness(NamedTuple):
    """The point (x / w, y / w), w positive: integers are ten times as quick as fractions."""

    x: int
    y: int
    w: int


def _turn(a: Point, b: Point, q: _Witness) -> int:
    """Positive where q is left of the line from a to b; the same for b, q, a and q, a, b."""
    return (b[0] - a[0]) * (q.y - a[1] * q.w) - (b[1] - a[1]) * (q.x - a[0] * q.w)


def _sees(q: _Witness, p: Point, walls: list[tuple[Point, Point]]) -> bool:
    """Whether p sees q, a point within the floor on no line through p and a corner."""
    for c, d in walls:
        of_p = cross(c, d, p)
        if of_p == 0:
            continue  # the segment could touch this wall at p only
        if of_p * _turn(c, d, q) < 0 and _turn(p, c, q) * _turn(p, d, q) < 0:
            return False
    return True


def _encloses(q: _Witness, view: View, rings: Sequence[Sequence[Point]]) -> bool:
    """Whether a hole lies in the triangle of q and the motion; one corner of it tells, but none on
    the motion's line, which a hole may touch from behind.
    """
    a, b = view.before, view.after
    around = _turn(a, b, q)
    for hole in rings[1:]:
        v = next(corner for corner in hole if cross(a, b, corner) != 0)
        signs = (_turn(a, v, q) * around, cross(a, b, v) * around, _turn(v, b, q) * around)
        if all(sign > 0 for sign in signs):
            return True
    return False


def _in_reach(q: _Witness, reach: Sequence[Point]) -> bool:
    return all(_turn(a, b, q) > 0 for a, b in walls_of([reach])) if reach else True


def _generic(
    low: Segment,
    high: Segment,
    begin: Fraction,
    end: Fraction,
    rings: Sequence[Sequence[Point]],
    views: Sequence[View],
) -> _Witness:
    """A point within a cell on no line through a corner and a position, nor along a motion."""
    corners = [corner for ring in rings for corner in ring]
    for k in range(2, 10_000):
        x = begin + (end - begin) / k
        share = Fraction(1, 2) + Fraction(1, 2 * k + 1)
        y = _height(low, x) * share + _height(high, x) * (1 - share)
        w = lcm(x.denominator, y.denominator)
        q = _Witness(int(x * w), int(y * w), w)
        if all(
            _turn(p, v, q) != 0
            for view in views
            for p in {view.before, view.after}
            for v in (*corners, view.after)
            if v != p
        ):
            return q
    raise AssertionError("all points of a cell lie on finitely many lines")


def _height(segment: Segment, x: Fraction) -> Fraction:
    (ax, ay), (bx, by) = segment
    return ay + (by - ay) * (x - ax) / (bx - ax)


def meeting(one: Segment, other: Segment) -> list[Fraction]:
    """The x at which two segments meet; none where they lie on one line or do not meet."""
    (a, b), (c, d) = one, other
    of_c, of_d = cross(a, b, c), cross(a, b, d)
    if of_c == of_d or of_c * of_d > 0 or cross(c, d, a) * cross(c, d, b) > 0:
        return []
    t = Fraction(of_c) / (of_c - of_d)
    return [c[0] + t * (d[0] - c[0])]


class _Slabs:
    """Cells between segments within the floor, and who is whose neighbour."""

    def __init__(self, walls: list[Segment], borders: list[Segment]) -> None:
        segments = sorted({(min(s), max(s)) for s in walls + borders})
        solid = {(min(s), max(s)) for s in walls}
        cuts = {place[0] for segment in segments for place in segment}
        for i, one in enumerate(segments):
            for other in segments[i + 1 :]:
                if other[0][0] > one[1][0]:
                    break  # sorted by where they begin
                cuts.update(meeting(one, other))
        self._cuts = sorted(cuts)
        upright: dict[Fraction, list[tuple[Segment, bool]]] = {}
        for s in segments:
            if s[0][0] == s[1][0]:
                upright.setdefault(s[0][0], []).append((s, s in solid))
        lying = [s for s in segments if s[0][0] != s[1][0]]
        self.cells: list[tuple[Segment, Segment, Fraction, Fraction]] = []
        self._edges: list[tuple[int, int, Place]] = []  # neighbours, a point on what parts them
        before: list[int] = []
        for x, next_x in pairwise(self._cuts):
            middle = (x + next_x) / 2
            across = sorted(
                (_height(s, middle), s not in solid, s)
                for s in lying
                if s[0][0] <= x and s[1][0] >= next_x
            )
            here: list[int] = []
            inside = False
            k = 0
            last: tuple[Segment, bool] | None = None
            while k < len(across):
                y, passable, segment = across[k]
                while k < len(across) and across[k][0] == y:
                    k += 1
                if last is not None and inside:
                    self.cells.append((last[0], segment, x, next_x))
                    here.append(len(self.cells) - 1)
                    if last[1] and here[:-1]:
                        self._edges.append((here[-2], here[-1], (middle, _height(last[0], middle))))
                if not passable:
                    inside = not inside
                last = segment, passable
            self._join(before, here, x, upright.get(x, []))
            before = here

    def _join(
        self, before: list[int], here: list[int], x: Fraction, upright: list[tuple[Segment, bool]]
    ) -> None:
        """Note which cells on both sides of an upright line meet, and where no wall parts them."""
        ends = {place[1] for segment, _ in upright for place in segment}
        for i in before:
            for j in here:
                low = max(_height(self.cells[i][0], x), _height(self.cells[j][0], x))
                high = min(_height(self.cells[i][1], x), _height(self.cells[j][1], x))
                if low >= high:
                    continue
                stops = sorted({low, high, *(end for end in ends if low < end < high)})
                for one, two in pairwise(stops):
                    y = (one + two) / 2
                    if not any(wall and s[0][1] < y < s[1][1] for s, wall in upright):
                        self._edges.append((i, j, (x, y)))

    def components(
        self, held: list[bool], closed: Callable[[Place], bool]
    ) -> tuple[list[int], int]:
        """The component of each cell that is held, -1 for the others, and how many there are.

        Nobody gets from cell to cell where the points between them are closed.
        """
        near: list[list[int]] = [[] for _ in held]
        for i, j, between in self._edges:
            if held[i] and held[j] and not closed(between):
                near[i].append(j)
                near[j].append(i)
        number = [-1] * len(held)
        count = 0
        for k in range(len(held)):
            if not held[k] or number[k] >= 0:
                continue
            number[k] = count
            stack = [k]
            while stack:
                for other in near[stack.pop()]:
                    if number[other] < 0:
                        number[other] = count
                        stack.append(other)
            count += 1
        return number, count

    def at(self, q: Place, number: list[int]) -> int:
        """The number of the cell that holds a point, borders included; -1 where none is held."""
        for k, (low, high, x, next_x) in enumerate(self.cells):
            if number[k] < 0 or not x <= q[0] <= next_x:
                continue
            if _height(low, q[0]) <= q[1] <= _height(high, q[0]):
                return number[k]
        return -1
