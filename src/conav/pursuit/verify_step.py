"""One motion of all pursuers, for the verifier: its arrangement and its hidden regions."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from conav.pursuit.verify_arrangement import Arrangement, Ints, arrange
from conav.pursuit.verify_lattice import Lattice, Point
from conav.pursuit.verify_range import inscribed_polygon
from conav.pursuit.verify_regions import Regions, classify
from conav.pursuit.verify_sight import first_seen, put_axis, put_line, windows

BOX_SLACK = 16.0  # [lattice units] far more than the rounding of a crossing's coordinates


class Mover(NamedTuple):
    """One pursuer during one motion, in lattice coordinates."""

    before: Point
    after: Point
    range: int | None  # [lattice units] rounded down; None: no limit
    old: bool = True  # whether it counts for the view before the motion
    new: bool = True  # and for the view after it


@dataclass(frozen=True, eq=False)
class Step:
    """A motion with its faces."""

    movers: tuple[Mover, ...]
    instant: bool  # views change at this moment and nobody moves
    lines: Ints  # (3 segments, 3)
    faces: Arrangement
    regions: Regions


class _View(NamedTuple):
    """What one position adds to an arrangement."""

    lines: Ints  # (3 k, 3) of windows, then of the edges of the range
    sides: Ints  # (k,) where each hides: 1 on its left, -1 on its right
    anchor: Ints  # (3, 3) a segment that begins at the position


@dataclass(eq=False)
class Stepper:
    """Makes `Step`s on one floor and remembers views."""

    lattice: Lattice
    _views: dict[tuple[Point, int | None], _View] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        points = self.lattice.points
        ends = [(i, j) for i, j in enumerate(self.lattice.links[:, 1].tolist())]
        ends += list(self.lattice.bridges)
        self._fixed = np.concatenate(
            [_segment(points[i].tolist(), points[j].tolist()) for i, j in ends]
        )

    def step(self, movers: Sequence[Mover], *, instant: bool = False) -> Step:
        """The motion of these pursuers, who all move on straight lines in the floor.

        Of two positions within one motion only the segment between them is searched; those who
        drive more than half their range are taken to see nothing throughout.
        """
        n_walls = len(self.lattice.points)
        rows = [self._fixed]
        count = len(self._fixed) // 3
        owners = [np.full(count, -1, dtype=np.int64)]
        pockets = [np.zeros(count, dtype=np.int64)]
        shown = [np.zeros(count, dtype=np.bool_)]
        places: list[tuple[Point, int | None]] = []
        table = np.empty((len(movers), 6), dtype=np.int64)
        for i, mover in enumerate(movers):
            moves = mover.before != mover.after
            for end, point in enumerate((mover.before, mover.after)[: 1 + moves]):
                table[i, end] = len(places)
                view = self._view(point, mover.range)
                rows.append(view.lines)
                owners.append(np.full(len(view.sides), len(places), dtype=np.int64))
                pockets.append(view.sides)
                shown.append(np.full(len(view.sides), mover.range is None))
                places.append((point, mover.range))
                count += len(view.sides)
            if not moves:
                table[i, 1] = table[i, 0]
            table[i, 2:] = -1, mover.old, mover.new, self.sees_throughout(mover)
        anchors = np.arange(count, count + len(places), dtype=np.int64)
        extra = [self._view(*place).anchor for place in places]
        for i, mover in enumerate(movers):
            if mover.before != mover.after:
                table[i, 2] = count + len(extra)
                extra.append(_segment(mover.before, mover.after))
        rows += extra
        owners.append(np.full(len(extra), -1, dtype=np.int64))
        pockets.append(np.zeros(len(extra), dtype=np.int64))
        shown.append(np.zeros(len(extra), dtype=np.bool_))
        lines = np.concatenate(rows)
        faces = Arrangement(*arrange(lines, n_walls, self.lattice.links[:, 1], BOX_SLACK))
        regions = Regions(
            *classify(
                faces.first,
                faces.segment,
                faces.face,
                faces.same,
                faces.faces,
                n_walls,
                np.concatenate(owners),
                np.concatenate(pockets),
                np.concatenate(shown),
                anchors,
                table,
                instant,
            )
        )
        return Step(tuple(movers), instant, lines, faces, regions)

    @staticmethod
    def sees_throughout(mover: Mover) -> bool:
        """Whether what the mover sees all along is looked for: not of long drives in short sight.

        Up to half its range, the whole path is within range of both of its ends.
        """
        (ax, ay), (bx, by) = mover.before, mover.after
        square = 4 * ((ax - bx) ** 2 + (ay - by) ** 2)
        return mover.range is None or square <= mover.range**2

    def _view(self, point: Point, range_units: int | None) -> _View:
        key = (point, range_units)
        if key not in self._views:
            self._views[key] = self._new_view(point, range_units)
        return self._views[key]

    def _new_view(self, point: Point, range_units: int | None) -> _View:
        points, links = self.lattice.points, self.lattice.links
        lines, found = windows(points, links, *point)
        sides = found[:, 1]
        if range_units is not None:
            corners = inscribed_polygon(point, range_units, points)
            edges = [_segment(a, b) for a, b in pairwise([*corners, *corners[:1]])]
            lines = np.concatenate((lines, *edges))
            sides = np.concatenate((sides, np.full(len(edges), -1, dtype=np.int64)))
        seen = first_seen(points, links, *point)
        return _View(lines, sides, _segment(point, points[seen].tolist()))


def halved(movers: Sequence[Mover]) -> tuple[tuple[Mover, ...], tuple[Mover, ...]] | None:
    """The two halves of a motion, or None where the lattice does not hold their middle."""
    middles: list[Point] = []
    for mover in movers:
        x, y = (a + b for a, b in zip(mover.before, mover.after, strict=True))
        if x % 2 or y % 2:
            return None
        middles.append((x // 2, y // 2))
    return (
        tuple(m._replace(after=at) for m, at in zip(movers, middles, strict=True)),
        tuple(m._replace(before=at) for m, at in zip(movers, middles, strict=True)),
    )


def _segment(a: Sequence[int], b: Sequence[int]) -> Ints:
    """The three lines of the segment from a to b."""
    lines = np.empty((3, 3), dtype=np.int64)
    put_line(lines, 0, a[0], a[1], b[0], b[1])
    put_axis(lines, 1, a[0], a[1], 0)
    put_axis(lines, 2, b[0], b[1], 0)
    return lines
