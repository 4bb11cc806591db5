"""Whether an evader of unbounded speed can stay unseen: the three-valued decision.

Shadows are refined only where it matters: a link between two shadows that might let an evader
through is either confirmed by a point that nobody sees all along, or its motion is halved.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.pursuit.verify_lattice import Lattice, Point
from conav.pursuit.verify_polygons import face_points
from conav.pursuit.verify_sight import never_sees, on_floor, windows
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
    labels: tuple[Flags, ...]  # shadows that may hold an evader, before each piece and at the end
    route: tuple[int, ...]  # of an escape: the shadow before each piece and at the end
    reason: str  # of UNKNOWN


class Settled(NamedTuple):
    """What became of questions about shadows."""

    pieces: list[Piece]
    labels: tuple[Flags, ...]  # shadows that may hold an evader, before each piece and at the end
    sure: tuple[Flags, ...]  # those that do, of the ones that matter
    came: tuple[NDArray[np.int64], ...]  # from which shadow one comes into each of those
    open: bool  # whether something is neither sure nor excluded
    exhausted: bool  # whether that is because there would be too many motions


Targets = Callable[[list[Piece]], dict[int, Flags]]
"""Which shadows are asked about: by the number of the piece they are there before."""


def decide(pieces: list[Piece], stepper: Stepper, max_pieces: int = MAX_PIECES) -> Decision:
    """The verdict on the motions of a schedule: whether a shadow at the end may hold an evader."""

    def at_the_end(pieces: list[Piece]) -> dict[int, Flags]:
        return {len(pieces): np.ones(pieces[-1].step(stepper).regions.n_new, dtype=np.bool_)}

    found = settle(pieces, stepper, at_the_end, max_pieces, first_only=True)
    if found.sure[-1].any():
        verdict, reason = Verdict.ESCAPES, ""
    elif not found.open:
        verdict, reason = Verdict.CAPTURED, ""
    else:
        verdict, reason = (
            Verdict.UNKNOWN,
            (
                f"more than {max_pieces} motions would have to be looked at"
                if found.exhausted
                else "motions cannot be halved any further on the lattice, and no point was found "
                "that stays hidden"
            ),
        )
    route = _route(found) if verdict is Verdict.ESCAPES else ()
    return Decision(verdict, tuple(found.pieces), found.labels, route, reason)


def settle(
    pieces: list[Piece],
    stepper: Stepper,
    targets: Targets,
    max_pieces: int = MAX_PIECES,
    *,
    first_only: bool = False,
) -> Settled:
    """For the shadows asked about, whether an evader may be in them, as far as it can be told.

    With `first_only` it ends when one is sure.
    """
    while True:
        labels = _forward(pieces, stepper)
        asked = targets(pieces)
        matters = _backward(pieces, stepper, labels, asked)
        sure, came, halves = _search(pieces, stepper, matters)
        is_open = any((flags & labels[k] & ~sure[k]).any() for k, flags in asked.items())
        found = any((flags & sure[k]).any() for k, flags in asked.items())
        done = not is_open or not halves or (first_only and found)
        if done or len(pieces) + len(halves) > max_pieces:
            return Settled(pieces, labels, sure, came, is_open, not done)
        pieces = [part for k, piece in enumerate(pieces) for part in halves.get(k, (piece,))]


def _forward(pieces: list[Piece], stepper: Stepper) -> tuple[Flags, ...]:
    """Which shadows may hold an evader, before each piece and after the last."""
    # With no view yet the floor is one shadow.
    labels: list[Flags] = [np.ones(1, dtype=np.bool_)]
    for piece in pieces:
        links = piece.step(stepper).regions.links
        assert links.shape[0] == len(labels[-1])
        labels.append(np.asarray(links[labels[-1]].any(axis=0)))
    return tuple(labels)


def _backward(
    pieces: list[Piece], stepper: Stepper, labels: tuple[Flags, ...], asked: dict[int, Flags]
) -> tuple[Flags, ...]:
    """Which shadows that may hold an evader are asked about or lead to one that is."""
    nothing = np.zeros(len(labels[-1]), dtype=np.bool_)
    matters = [labels[-1] & asked.get(len(pieces), nothing)]
    for k in range(len(pieces) - 1, -1, -1):
        links = pieces[k].step(stepper).regions.links
        wanted = links[:, matters[-1]].any(axis=1)
        if k in asked:
            wanted |= asked[k]
        matters.append(labels[k] & wanted)
    return tuple(reversed(matters))


def _search(
    pieces: list[Piece], stepper: Stepper, matters: tuple[Flags, ...]
) -> tuple[tuple[Flags, ...], tuple[NDArray[np.int64], ...], dict[int, tuple[Piece, Piece]]]:
    """Shadows reached over confirmed links alone, from where, and the motions to halve to get on.

    Beyond a link that can be settled no further it goes on, so that later motions are halved that
    may cut it off.
    """
    sure: list[Flags] = [matters[0].copy()]
    perhaps = sure[0]
    came: list[NDArray[np.int64]] = []
    to_halve: dict[int, tuple[Piece, Piece]] = {}
    for k, piece in enumerate(pieces):
        links = piece.step(stepper).regions.links
        next_sure = np.zeros(links.shape[1], dtype=np.bool_)
        next_perhaps = np.zeros(links.shape[1], dtype=np.bool_)
        source = np.full(links.shape[1], -1, dtype=np.int64)
        for i in np.flatnonzero(perhaps).tolist():
            for j in np.flatnonzero(links[i] & matters[k + 1]).tolist():
                if next_sure[j] or (next_perhaps[j] and not sure[k][i]):
                    continue
                if witness(piece, i, j, stepper) is not None:
                    next_perhaps[j] = True
                    if sure[k][i]:
                        next_sure[j] = True
                        source[j] = i
                    continue
                halves = to_halve.get(k) or piece.halves()
                if halves is None:
                    next_perhaps[j] = True
                else:
                    to_halve[k] = halves
        came.append(source)
        sure.append(next_sure)
        perhaps = next_perhaps
    return tuple(sure), tuple(came), to_halve


def _route(found: Settled) -> tuple[int, ...]:
    at = int(np.flatnonzero(found.sure[-1])[0])
    route = [at]
    for source in reversed(found.came):
        at = int(source[at])
        route.append(at)
    return tuple(reversed(route))


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
    view, _ = windows(lattice.points, lattice.links, *point)
    for mover in piece.movers:
        if mover.range is not None and _apart(mover.before, mover.after, point, mover.range):
            continue
        if not never_sees(lattice.points, lattice.links, view, *point, *mover.before, *mover.after):
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
