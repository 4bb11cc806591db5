"""Several pursuers moving at once: drives of a finished schedule that may overlap are made to.

The schedule becomes rounds, in each of which everybody drives once at most, and all begin and
arrive together. Leg by leg, each drive goes back a round at a time as long as its pursuer is not
driving in that round and nothing more is contaminated, by the rule for joint drives, once both ways
of doing it have come to the same places. So a guard that must stand until a drive has ended is not
driven away: its drive does not go back past that one. Of the rounds a drive can be in, it takes the
one with the least time in all, of equals the earliest.

This is a greedy pass. Ways stay what they are, and so does the distance; it never takes longer.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from conav.pursuit.joint_drives import JointDrives
from conav.pursuit.shadow_moves import Point, ShadowMoves
from conav.pursuit.types import Pursuer, Schedule

_LATER = 1e-9  # [s], relative: times that differ by less are equal

Round = dict[int, Point]
"""Where each pursuer that drives arrives."""


@dataclass(frozen=True)
class _Moment:
    places: tuple[Point, ...]
    dirty: int


def move_together(
    schedule: Schedule, pursuers: Sequence[Pursuer], shadows: ShadowMoves
) -> Schedule:
    """The schedule with drives overlapping where the floor is cleared all the same.

    The same schedule where that saves no time, or where the rule does not find it to clear the
    floor. Everybody must see all the time; raises `ValueError` otherwise.
    """
    if not schedule.active.all():
        raise ValueError("somebody does not see all the time")
    rows = [_row(row) for row in schedule.positions.tolist()]
    joint = JointDrives(shadows)
    begin = (1 << shadows.shadows(rows[0]).count) - 1
    rounds: list[Round] = []
    moments = [_Moment(rows[0], begin)]
    for before, after in pairwise(rows):
        drives = {i: end for i, end in enumerate(after) if end != before[i]}
        moment = _after(joint, moments[-1], drives)
        if moment is None:
            return schedule
        if drives:
            rounds.append(drives)
            moments.append(moment)
            for who in drives:
                rounds, moments = _earlier(joint, pursuers, rounds, moments, who)
    lasts = _lasts(pursuers, rounds, moments)
    saved = float(schedule.times[-1] - schedule.times[0]) - sum(lasts)
    # From less contamination halves are not always taken, so what was kept may not bound it.
    last: _Moment | None = moments[0]
    for drives in rounds:
        last = None if last is None else _after(joint, last, drives)
    if last is None or last.dirty or saved <= _LATER * (1.0 + sum(lasts)):
        return schedule
    times = float(schedule.times[0]) + np.concatenate([[0.0], np.cumsum(lasts)])
    positions = np.array([moment.places for moment in moments])
    return Schedule(times, positions, np.ones((len(rounds), len(pursuers)), np.bool_))


def _earlier(
    joint: JointDrives,
    pursuers: Sequence[Pursuer],
    rounds: list[Round],
    moments: list[_Moment],
    who: int,
) -> tuple[list[Round], list[_Moment]]:
    """The rounds with the last drive of a pursuer, which is in the last round, where it is best."""
    best, least = (rounds, moments), sum(_lasts(pursuers, rounds, moments))
    at = len(rounds) - 1
    while at > 0 and who not in rounds[at - 1]:
        found = _one_earlier(joint, rounds, moments, who, at)
        if found is None:
            break
        (rounds, moments), at = found, at - 1
        total = sum(_lasts(pursuers, rounds, moments))
        if total <= least * (1.0 + _LATER):
            best, least = found, min(total, least)
    return best


def _one_earlier(
    joint: JointDrives, rounds: list[Round], moments: list[_Moment], who: int, at: int
) -> tuple[list[Round], list[_Moment]] | None:
    """The rounds with a drive of round `at` in the one before; None where that contaminates more.

    Where no more is contaminated after it the rest is as it was: contamination that was taken into
    account already can only be too much.
    """
    first = {**rounds[at - 1], who: rounds[at][who]}
    second = {i: end for i, end in rounds[at].items() if i != who}
    middle = _after(joint, moments[at - 1], first)
    last = None if middle is None else _after(joint, middle, second)
    if middle is None or last is None or last.dirty & ~moments[at + 1].dirty:
        return None
    if not second:
        return [*rounds[: at - 1], first, *rounds[at + 1 :]], [*moments[:at], *moments[at + 1 :]]
    return (
        [*rounds[: at - 1], first, second, *rounds[at + 1 :]],
        [*moments[:at], middle, *moments[at + 1 :]],
    )


def _after(joint: JointDrives, moment: _Moment, drives: Round) -> _Moment | None:
    """What is contaminated after a round; None where it has too many viewpoints."""
    if not drives:
        return moment
    shadows = joint.shadows
    standing = shadows.team([at for i, at in enumerate(moment.places) if i not in drives])
    ways = tuple((shadows.number(moment.places[i]), shadows.number(drives[i])) for i in drives)
    if not joint.fits(standing, ways):
        return None
    places = tuple(drives.get(i, at) for i, at in enumerate(moment.places))
    return _Moment(places, joint.after(standing, ways, moment.dirty))


def _lasts(pursuers: Sequence[Pursuer], rounds: list[Round], moments: list[_Moment]) -> list[float]:
    """How long each round takes [s]: the slowest gives the pace."""
    return [
        max(_length(moment.places[i], end) / pursuers[i].speed_mps for i, end in drives.items())
        for drives, moment in zip(rounds, moments[:-1], strict=True)
    ]


def _row(places: list[list[float]]) -> tuple[Point, ...]:
    return tuple((x, y) for x, y in places)


def _length(a: Point, b: Point) -> float:
    return ((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5
