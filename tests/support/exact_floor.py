"""Slow and obvious geometry of floors in rational numbers; shares no code with the library."""

from fractions import Fraction
from functools import cmp_to_key
from itertools import pairwise
from typing import NamedTuple

Point = tuple[Fraction, Fraction]


def exact(point) -> Point:
    return Fraction(float(point[0])), Fraction(float(point[1]))


def minus(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1]


def cross(a: Point, b: Point) -> Fraction:
    return a[0] * b[1] - a[1] * b[0]


def sign(value: Fraction) -> int:
    return (value > 0) - (value < 0)


def turn(a: Point, b: Point, c: Point) -> int:
    return sign(cross(minus(b, a), minus(c, a)))


def between(a: Point, b: Point, p: Point) -> bool:
    """Whether p lies on the closed segment."""
    if turn(a, b, p):
        return False
    return min(a[0], b[0]) <= p[0] <= max(a[0], b[0]) and min(a[1], b[1]) <= p[1] <= max(a[1], b[1])


class Piece(NamedTuple):
    """A visible piece of a wall: which one, from what part of it to what part."""

    wall: int
    start: Fraction
    end: Fraction


class ExactFloor:
    def __init__(self, rings) -> None:
        self.vertices = [exact(point) for ring in rings for point in ring]
        self.walls: list[tuple[int, int]] = []
        for ring in rings:
            base = len(self.walls)
            self.walls += [(base + i, base + (i + 1) % len(ring)) for i in range(len(ring))]

    def ends(self, wall: int) -> tuple[Point, Point]:
        a, b = self.walls[wall]
        return self.vertices[a], self.vertices[b]

    def area(self) -> Fraction:
        return sum((cross(*self.ends(w)) for w in range(len(self.walls))), Fraction(0)) / 2

    def contains(self, p: Point) -> bool:
        """Whether the closed floor holds the point."""
        inside = False
        for w in range(len(self.walls)):
            a, b = self.ends(w)
            if between(a, b, p):
                return True
            if (a[1] > p[1]) != (b[1] > p[1]):
                x = a[0] + (p[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
                inside ^= x > p[0]
        return inside

    def meetings(self, a: Point, b: Point) -> list[Fraction]:
        """Parts of the way from a to b at which the line meets walls or their ends, 0 to 1."""
        found = {Fraction(0), Fraction(1)}
        d = minus(b, a)
        for w in range(len(self.walls)):
            p, q = self.ends(w)
            e = minus(q, p)
            if cross(d, e) != 0:
                t = cross(minus(p, a), e) / cross(d, e)
                u = cross(minus(p, a), d) / cross(d, e)
                if 0 <= u <= 1:
                    found.add(t)
            elif cross(d, minus(p, a)) == 0:
                found |= {self.part(a, d, p), self.part(a, d, q)}
        return sorted(t for t in found if 0 <= t <= 1)

    @staticmethod
    def part(a: Point, d: Point, p: Point) -> Fraction:
        return (p[0] - a[0]) / d[0] if d[0] != 0 else (p[1] - a[1]) / d[1]

    def sees(self, a: Point, b: Point) -> bool:
        """Whether the closed segment stays on the closed floor: its pieces' middles are on it."""
        if not (self.contains(a) and self.contains(b)):
            return False
        if a == b:
            return True
        d = minus(b, a)
        return all(
            self.contains((a[0] + (s + t) / 2 * d[0], a[1] + (s + t) / 2 * d[1]))
            for s, t in pairwise(self.meetings(a, b))
        )

    def visible_pieces(self, q: Point) -> list[Piece]:
        """The walls seen from q with some width, counter-clockwise around it, cyclic.

        Between the directions of two neighbouring vertices one wall is seen, or none.
        """
        if not self.contains(q):
            return []
        axes = [(Fraction(x), Fraction(y)) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1))]
        rays = [minus(v, q) for v in self.vertices if v != q] + axes

        def half(d: Point) -> int:
            return 0 if d[1] > 0 or (d[1] == 0 and d[0] > 0) else 1

        def compare(a: Point, b: Point) -> int:
            return half(a) - half(b) or -sign(cross(a, b))

        rays.sort(key=cmp_to_key(compare))
        directions = [d for i, d in enumerate(rays) if i == 0 or compare(rays[i - 1], d)]
        pieces: list[Piece] = []
        for one, two in zip(directions, directions[1:] + directions[:1], strict=True):
            wall = self._wall_seen(q, (one[0] + two[0], one[1] + two[1]))
            if wall >= 0:
                start, end = self._hit(q, one, wall), self._hit(q, two, wall)
                if pieces and pieces[-1].wall == wall and pieces[-1].end == start:
                    pieces[-1] = Piece(wall, pieces[-1].start, end)
                else:
                    pieces.append(Piece(wall, start, end))
        first, last = pieces[0], pieces[-1]
        if len(pieces) > 1 and last.wall == first.wall and last.end == first.start:
            pieces = [Piece(first.wall, last.start, first.end), *pieces[1:-1]]
        return pieces

    def _hit(self, q: Point, d: Point, wall: int) -> Fraction:
        a, b = self.ends(wall)
        e = minus(b, a)
        return cross(minus(q, a), d) / cross(e, d)

    def _wall_seen(self, q: Point, d: Point) -> int:
        """The first wall on a ray that meets no vertex, if seen from its floor side; else -1."""
        nearest, found = None, -1
        for w in range(len(self.walls)):
            a, b = self.ends(w)
            e = minus(b, a)
            if cross(d, e) == 0:
                continue
            t = cross(minus(a, q), e) / cross(d, e)
            u = cross(minus(a, q), d) / cross(d, e)
            if t > 0 and 0 < u < 1 and (nearest is None or t < nearest):
                nearest, found = t, w
        return found if found >= 0 and turn(*self.ends(found), q) > 0 else -1

    def point_on(self, wall: int, part: Fraction) -> Point:
        a, b = self.ends(wall)
        return a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])

    def visible_area(self, q: Point) -> Fraction:
        total = Fraction(0)
        for wall, start, end in self.visible_pieces(q):
            total += cross(minus(self.point_on(wall, start), q), minus(self.point_on(wall, end), q))
        return total / 2
