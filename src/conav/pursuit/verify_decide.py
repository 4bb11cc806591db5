"""Whether an evader of unbounded speed can stay unseen: the three-valued decision.

Shadows are refined only where it matters: a link between two shadows that might let an evader
through is either confirmed by a point that nobody sees all along, or its motion is halved.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from conav.pursuit.verify_lattice import Lattice, Point
from conav.pursuit.verify_polygons import face_points
from conav.pursuit.verify_sight import never_sees, on_floor
from conav.pursuit.verify_step import Stepper
from conav.pursuit.verify_timeline import Piece

Flags = NDArray[np.bool_]

MAX_PIECES = 50_000


class Verdict(StrEnum):
    """What a schedule does to evaders of unbounded speed."""

    CAPTURED = "captured"
    """Whatever they do, somebody sees them; there is a certificate."""
    ESCAPES = "escapes"
    """One is never seen; there is a path."""
    UNKNOWN = "unknown"
    """Neither was shown."""


@dataclass(frozen=True, eq=False)
class Decision:
    """The verdict with the motions it rests on."""

    verdict: Verdict
    pieces: tuple[Piece, ...]
    labels: tuple[Flags, ...]  # contaminated shadows before each piece and after the last
    route: tuple[int, ...]  # of an escape: the shadow before each piece and after the last
    reason: str  # of UNKNOWN


def decide(pieces: list[Piece], stepper: Stepper, max_pieces: int = MAX_PIECES) -> Decision:
    """The verdict on the motions of a schedule."""
    while True:
        labels = _forward(pieces, stepper)
        if not labels[-1].any():
            return Decision(Verdict.CAPTURED, tuple(pieces), labels, (), "")
        search = _Search(pieces, stepper, labels)
        if search.route:
            return Decision(Verdict.ESCAPES, tuple(pieces), labels, search.route, "")
        if not search.to_halve:
            reason = (
                "where it matters the lattice ends: motions cannot be halved any further, and "
                "no point was found that stays hidden"
            )
            return Decision(Verdict.UNKNOWN, tuple(pieces), labels, (), reason)
        finer: list[Piece] = []
        for k, piece in enumerate(pieces):
            finer += search.to_halve.get(k, (piece,))
        pieces = finer
        if len(pieces) > max_pieces:
            reason = f"more than {max_pieces} motions would have to be looked at"
            return Decision(Verdict.UNKNOWN, tuple(pieces), labels, (), reason)


def _forward(pieces: list[Piece], stepper: Stepper) -> tuple[Flags, ...]:
    """Which shadows may hold an evader, before each piece and after the last."""
    labels = [np.ones(1, dtype=np.bool_)]  # with no view yet the floor is one shadow
    for piece in pieces:
        links = piece.step(stepper).regions.links
        assert links.shape[0] == len(labels[-1])
        labels.append(links[labels[-1]].any(axis=0))
    return tuple(labels)


class _Search:
    """A forward search over confirmed links, and the motions to halve where it does not get on."""

    def __init__(self, pieces: list[Piece], stepper: Stepper, labels: tuple[Flags, ...]) -> None:
        self.route: tuple[int, ...] = ()
        self.to_halve: dict[int, tuple[Piece, Piece]] = {}
        matters = self._backward(pieces, stepper, labels)
        sure = np.ones(1, dtype=np.bool_)  # reached over confirmed links
        perhaps = np.ones(1, dtype=np.bool_)  # also over links that can be settled no further
        came: list[NDArray[np.int64]] = []
        for k, piece in enumerate(pieces):
            links = piece.step(stepper).regions.links
            next_sure = np.zeros(links.shape[1], dtype=np.bool_)
            next_perhaps = np.zeros(links.shape[1], dtype=np.bool_)
            source = np.full(links.shape[1], -1, dtype=np.int64)
            halves: tuple[Piece, Piece] | None = None
            for i in np.flatnonzero(perhaps & matters[k]).tolist():
                for j in np.flatnonzero(links[i] & matters[k + 1]).tolist():
                    if next_sure[j] or (next_perhaps[j] and not sure[i]):
                        continue
                    if witness(piece, i, j, stepper) is not None:
                        next_perhaps[j] = True
                        if sure[i]:
                            next_sure[j] = True
                            source[j] = i
                        continue
                    halves = halves or piece.halves()
                    if halves is None:
                        next_perhaps[j] = True
                    else:
                        self.to_halve[k] = halves
            came.append(source)
            sure, perhaps = next_sure, next_perhaps
        if sure.any():
            at = int(np.flatnonzero(sure)[0])
            route = [at]
            for source in reversed(came):
                at = int(source[at])
                route.append(at)
            self.route = tuple(reversed(route))

    @staticmethod
    def _backward(
        pieces: list[Piece], stepper: Stepper, labels: tuple[Flags, ...]
    ) -> tuple[Flags, ...]:
        """Which contaminated shadows lead to one at the end."""
        matters = [labels[-1]]
        for piece, label in zip(reversed(pieces), reversed(labels[:-1]), strict=True):
            links = piece.step(stepper).regions.links
            matters.append(label & links[:, matters[-1]].any(axis=1))
        return tuple(reversed(matters))


def witness(piece: Piece, old: int, new: int, stepper: Stepper) -> Point | None:
    """A point of both shadows that no pursuer sees during the piece; None where none was found."""
    key = (old, new)
    if key not in piece.witnesses:
        step = piece.step(stepper)
        regions = step.regions
        at = (regions.old == old) & (regions.new == new)
        if piece.instant:
            at &= regions.unseen >= 0
        piece.witnesses[key] = next(
            (
                point
                for point in face_points(step, np.flatnonzero(at))
                if _stays_hidden(piece, point, stepper)
            ),
            None,
        )
    return piece.witnesses[key]


def _stays_hidden(piece: Piece, point: Point, stepper: Stepper) -> bool:
    lattice: Lattice = stepper.lattice
    if not on_floor(lattice.points, lattice.links, *point):
        return False
    view = stepper.windows(point)
    for mover in piece.movers:
        if mover.range is not None and _apart(mover.before, mover.after, point, mover.range):
            continue
        if not never_sees(
            lattice.points, lattice.links, *point, view, *mover.before, *mover.after
        ):
            return False
    return True


def _apart(a: Point, b: Point, x: Point, range_units: int) -> bool:
    """Whether x is out of range all along the segment a-b, exactly."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    px, py = x[0] - a[0], x[1] - a[1]
    length = dx * dx + dy * dy
    along = min(max(px * dx + py * dy, 0), length)
    # The nearest point is a + d along / length; all distances times length, squared.
    if length == 0:
        return px * px + py * py > range_units**2
    ex, ey = px * length - dx * along, py * length - dy * along
    return ex * ex + ey * ey > (range_units * length) ** 2
