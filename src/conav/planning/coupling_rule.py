"""Couplings as a rule of the search through the product of graphs, for robots that drive straight.

What is remembered of a coupling is as little as decides what may still come:

- `near`: nothing; each pair of steps is within the distance at every time both last, or barred.
- `meet`: whether they have met.
- `not-before`: nothing while neither is known to have been where it is about; when one is, and the
  other has not come so far in time, when that was; and that it is settled.

A pair of steps is judged in closed form. Borders belong to regions, `SAME` beyond them included.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.planning.joint_rule import Present
from conav.planning.labels import SAME, build_regions, in_polygon
from conav.planning.types import Coupling, PlanningProblem, Region

SETTLED = ("settled",)

Span = tuple[float, float]


def refuse_couplings(problem: PlanningProblem) -> None:
    """Raises `InputError` for a problem with couplings: the solver knows none."""
    if problem.couplings:
        raise InputError(
            problem.name, "couples robots, which this solver does not know",
            "use the solver coupled (--solver coupled)",
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class CouplingRule:
    """The rule of some couplings; robots by their numbers in the search."""

    couplings: tuple[Coupling, ...]
    pairs: tuple[tuple[int, int], ...]  # of each coupling
    _known: dict[Hashable, bool] = field(default_factory=dict[Hashable, bool])
    _firsts: dict[Hashable, float | None] = field(default_factory=dict[Hashable, float | None])

    def begin(self) -> Hashable:
        # Steps are called by ranks, which are others when a graph has grown.
        self._known.clear()
        self._firsts.clear()
        return ((),) * len(self.couplings)

    def after(
        self, memory: Hashable, robot: int, new: Present, others: Sequence[Present]
    ) -> Hashable | None:
        assert isinstance(memory, tuple)
        found = list(memory)
        for k, (coupling, pair) in enumerate(zip(self.couplings, self.pairs, strict=True)):
            if robot not in pair or found[k] == SETTLED:
                continue
            theirs = others[pair[1] if robot == pair[0] else pair[0]]
            if coupling.kind == "not-before":
                after = self._ordered(found[k], k, robot == pair[0], new, theirs)
                if after is None:
                    return None
                found[k] = after
                continue
            if not len(theirs.pieces):
                continue
            key = k, robot, new.step, theirs.step
            if key not in self._known:
                judge = _always_near if coupling.kind == "near" else _meet
                self._known[key] = all(
                    judge(mine, other, coupling) for mine in new.pieces for other in theirs.pieces
                )  # a step of a robot that drives straight is one piece
            if coupling.kind == "near" and not self._known[key]:
                return None
            if coupling.kind == "meet" and self._known[key]:
                found[k] = SETTLED
        return tuple(found)

    def holds(self, memory: Hashable) -> bool:
        assert isinstance(memory, tuple)
        return all(
            one == SETTLED if coupling.kind == "meet" else one[:1] != ("first",)
            for coupling, one in zip(self.couplings, memory, strict=True)
        )

    def _ordered(
        self, memory: tuple[str, float] | tuple[()], k: int, first: bool, new: Present,
        theirs: Present,
    ) -> tuple[str, float] | tuple[()] | tuple[str] | None:  # fmt: skip
        """What is remembered of a `not-before` when its first or its second robot goes on.

        ("first", t): the first is in the region at t, to which the second has not come in time yet;
        ("second", t): the second was where it has to be at t, and the first has not come so far.
        """
        if memory and memory[0] == ("first" if first else "second"):
            return memory
        when = self._first(k, first, new)
        if not memory:
            if when is None:
                return ()
            if theirs.until >= when:  # whatever the other did until then is known
                return None if first else SETTLED
            return ("first" if first else "second", when)
        if first:
            if when is None:
                return SETTLED if new.until >= memory[1] else memory
            return SETTLED if when >= memory[1] else None
        if when is None:
            return None if new.until >= memory[1] else memory
        return SETTLED if when <= memory[1] else None

    def _first(self, k: int, first: bool, new: Present) -> float | None:
        """When a robot is first where a `not-before` is about it, in a step; None: never."""
        key = k, first, new.step
        if key not in self._firsts:
            coupling = self.couplings[k]
            region = coupling.region if first else coupling.other_region or coupling.region
            assert region is not None
            spans = [span for piece in new.pieces for span in spans_in(piece, region)]
            self._firsts[key] = spans[0][0] if spans else None
        return self._firsts[key]


def coupling_rule(problem: PlanningProblem) -> CouplingRule:
    """The rule of a problem's couplings, robots numbered as there.

    Raises `InputError` for a name that no robot has.
    """
    numbers = {robot.name: number for number, robot in enumerate(problem.robots)}
    for coupling in problem.couplings:
        for name in coupling.robots:
            if name not in numbers:
                raise InputError(
                    "couplings", f"there is no robot {name}", f"the robots: {', '.join(numbers)}"
                )
    pairs = tuple((numbers[one.robots[0]], numbers[one.robots[1]]) for one in problem.couplings)
    return CouplingRule(problem.couplings, pairs)


def spans_in(piece: NDArray[np.float64], region: Region) -> list[Span]:
    """When a straight piece is in a region, in order [s]."""
    begin, end = float(piece[0]), float(piece[1])
    if region.disc is not None:
        x, y, radius = region.disc
        found = _within(piece[2] - x, piece[3] - y, piece[4], piece[5], radius + SAME, end - begin)
        return [] if found is None else [(begin + found[0], begin + found[1])]
    times = sorted({begin, end, *_crossings(piece, region)})
    spans: list[Span] = []
    arrays = build_regions([region])
    for t0, t1 in [*pairwise(times)] or [(begin, end)]:
        middle = 0.5 * (t0 + t1) - begin
        x, y = piece[2] + middle * piece[4], piece[3] + middle * piece[5]
        if not in_polygon(arrays.rings, arrays.sides, 0, x, y):
            continue
        if spans and spans[-1][1] == t0:
            spans[-1] = (spans[-1][0], t1)
        else:
            spans.append((t0, t1))
    return spans


def _crossings(piece: NDArray[np.float64], region: Region) -> list[float]:
    """Times at which a piece meets a polygon's sides."""
    corners = region.polygon
    assert corners is not None
    ahead = np.roll(corners, -1, axis=0)
    begin, end, x, y, vx, vy = piece[:6].tolist()
    found: list[float] = []
    for (x0, y0), (x1, y1) in zip(corners.tolist(), ahead.tolist(), strict=True):
        across = vx * (y1 - y0) - vy * (x1 - x0)
        if across == 0.0:
            continue  # along it: met at the sides beside it
        s = ((x0 - x) * (y1 - y0) - (y0 - y) * (x1 - x0)) / across
        if 0.0 < s < end - begin:
            found.append(begin + s)
    return found


def _within(
    x: float, y: float, vx: float, vy: float, distance: float, duration: float
) -> Span | None:
    """When (x, y) + s (vx, vy) is within a distance of the origin, for s from 0 to the duration."""
    a, b, c = vx * vx + vy * vy, x * vx + y * vy, x * x + y * y - distance * distance
    if a == 0.0:
        return (0.0, duration) if c <= 0.0 else None
    inner = b * b - a * c
    if inner < 0.0:
        return None
    root = sqrt(inner)
    first, last = max((-b - root) / a, 0.0), min((-b + root) / a, duration)
    return (first, last) if first <= last else None


def _relative(
    mine: NDArray[np.float64], theirs: NDArray[np.float64]
) -> tuple[float, float, float, float, float, float] | None:
    """Begin, duration and relative motion of two pieces while both last; None: they never do."""
    begin, end = max(mine[0], theirs[0]), min(mine[1], theirs[1])
    if begin > end:
        return None
    a, b = begin - mine[0], begin - theirs[0]
    x = mine[2] + a * mine[4] - theirs[2] - b * theirs[4]
    y = mine[3] + a * mine[5] - theirs[3] - b * theirs[5]
    vx, vy = mine[4] - theirs[4], mine[5] - theirs[5]
    return float(begin), float(end - begin), float(x), float(y), float(vx), float(vy)


def _always_near(
    mine: NDArray[np.float64], theirs: NDArray[np.float64], coupling: Coupling
) -> bool:
    """Whether two pieces are within the distance at every time both last: at both ends of it."""
    found = _relative(mine, theirs)
    if found is None:
        return True
    _, duration, x, y, vx, vy = found
    assert coupling.within_m is not None
    most = (coupling.within_m + SAME) ** 2
    u, v = x + duration * vx, y + duration * vy
    return x * x + y * y <= most and u * u + v * v <= most


def _meet(mine: NDArray[np.float64], theirs: NDArray[np.float64], coupling: Coupling) -> bool:
    """Whether two pieces are within the distance at a time both are in the region."""
    found = _relative(mine, theirs)
    if found is None:
        return False
    begin, duration, x, y, vx, vy = found
    assert coupling.within_m is not None
    assert coupling.region is not None
    near = _within(x, y, vx, vy, coupling.within_m + SAME, duration)
    if near is None:
        return False
    low, high = begin + near[0], begin + near[1]
    return any(
        max(low, a0, b0) <= min(high, a1, b1)
        for a0, a1 in spans_in(mine, coupling.region)
        for b0, b1 in spans_in(theirs, coupling.region)
    )
