"""A schedule as the verifier takes it: motions on the lattice, and moments when views change."""

from dataclasses import dataclass, field
from fractions import Fraction

from conav.pursuit.types import Schedule
from conav.pursuit.verify_lattice import PARTS, Lattice, Point
from conav.pursuit.verify_range import range_units
from conav.pursuit.verify_step import Mover, Step, Stepper, halved

Ranges = tuple[float | None, ...]  # [m] of each pursuer


class Unverifiable(Exception):
    """The schedule cannot be put on the lattice; says why."""


@dataclass(eq=False)
class Piece:
    """A part of a motion between two moments of the schedule, or such a moment itself."""

    leg: int  # the interval of the schedule; of a moment the one that begins then
    part: tuple[Fraction, Fraction]  # of the interval's duration; equal ends for a moment
    movers: tuple[Mover, ...]
    names: tuple[int, ...]  # the pursuers that the movers are
    instant: bool
    witnesses: dict[tuple[int, int], Point | None] = field(
        default_factory=dict[tuple[int, int], "Point | None"]
    )
    """For links tried: a point that nobody sees throughout and that lies in both shadows."""
    _step: Step | None = None

    def step(self, stepper: Stepper) -> Step:
        """The piece's arrangement and regions, computed once."""
        if self._step is None:
            self._step = stepper.step(self.movers, instant=self.instant)
        return self._step

    def halves(self) -> tuple["Piece", "Piece"] | None:
        """The two halves, or None where the lattice ends or nobody moves."""
        if self.instant or all(mover.before == mover.after for mover in self.movers):
            return None
        movers = halved(self.movers)
        if movers is None:
            return None
        begin, end = self.part
        middle = (begin + end) / 2
        return (
            Piece(self.leg, (begin, middle), movers[0], self.names, instant=False),
            Piece(self.leg, (middle, end), movers[1], self.names, instant=False),
        )


def timeline(schedule: Schedule, ranges: Ranges, lattice: Lattice) -> list[Piece]:
    """The pieces of a schedule in order, beginning with the moment at which it begins.

    Pursuers see from the moment their activity begins to the moment it ends, both included: whoever
    is active before or after a moment, or at it alone, sees at that moment. Raises `Unverifiable`.
    """
    places = _snapped(schedule, lattice)
    units = [
        None if range_m is None else range_units(range_m, lattice.grid_m / PARTS)
        for range_m in ranges
    ]
    n_legs, n_pursuers = schedule.active.shape
    active = [frozenset(i for i in range(n_pursuers) if row[i]) for row in schedule.active.tolist()]
    lasts = [bool(b > a) for a, b in zip(schedule.times[:-1], schedule.times[1:], strict=True)]
    pieces: list[Piece] = []
    before: frozenset[int] = frozenset()
    leg = 0
    while leg < n_legs or not pieces:
        # A moment: all intervals without duration, between two with one.
        begin, seeing = leg, set(before)
        while leg < n_legs and not lasts[leg]:
            for i in active[leg]:
                if places[leg][i] != places[leg + 1][i]:
                    raise Unverifiable(f"pursuer {i} moves in no time in interval {leg}")
            seeing |= active[leg]
            leg += 1
        after = active[leg] if leg < n_legs else frozenset(seeing)
        seeing |= after
        if not pieces or frozenset(seeing) != before or after != before:
            pieces.append(_moment(begin, before, frozenset(seeing), after, places[begin], units))
        if leg < n_legs:
            pieces.append(_motion(leg, after, places, units, lattice))
            before = after
            leg += 1
    return pieces


def _snapped(schedule: Schedule, lattice: Lattice) -> list[list[Point]]:
    """All positions on the lattice; those of pursuers that are not active may lie anywhere."""
    nowhere = (0, 0)
    result: list[list[Point]] = []
    known: dict[tuple[float, float], Point | None] = {}
    for m, row in enumerate(schedule.positions.tolist()):
        result.append([])
        for i, (x, y) in enumerate(row):
            if (x, y) not in known:
                known[x, y] = lattice.snap((x, y))
            place = known[x, y]
            near = schedule.active[max(m - 1, 0) : m + 1, i]
            if place is None and near.any():
                raise Unverifiable(f"pursuer {i} is outside the floor at ({x:g}, {y:g})")
            result[-1].append(nowhere if place is None else place)
    return result


def _moment(
    leg: int,
    before: frozenset[int],
    seeing: frozenset[int],
    after: frozenset[int],
    places: list[Point],
    units: list[int | None],
) -> Piece:
    names = tuple(sorted(seeing))
    movers = tuple(
        Mover(places[i], places[i], units[i], old=i in before, new=i in after) for i in names
    )
    zero = Fraction(0)
    return Piece(leg, (zero, zero), movers, names, instant=True)


def _motion(
    leg: int,
    active: frozenset[int],
    places: list[list[Point]],
    units: list[int | None],
    lattice: Lattice,
) -> Piece:
    names = tuple(sorted(active))
    movers = tuple(Mover(places[leg][i], places[leg + 1][i], units[i]) for i in names)
    for i, mover in zip(names, movers, strict=True):
        if not lattice.joined(mover.before, mover.after):
            raise Unverifiable(f"pursuer {i} leaves the floor in interval {leg}")
    return Piece(leg, (Fraction(0), Fraction(1)), movers, names, instant=False)
