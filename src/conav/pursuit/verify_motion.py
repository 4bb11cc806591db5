"""Whether pursuers did what pursuers can: the verifier's checks of starts, motion and knowledge."""

from math import hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from conav.pursuit.types import Schedule
from conav.pursuit.verify_lattice import Lattice, Point
from conav.pursuit.verify_problem import Check, Problem

SLACK = 1e-9  # of lengths and speeds, relative and [m]
SAMPLES = 16  # in a range: how finely drives beyond it are compared with what was seen

Place = NDArray[np.float64]  # (2,) [m]


def check_starts(problem: Problem, schedule: Schedule, check: Check) -> None:
    """Everybody enters once, at its start, is gone when it is lost, and no more are sent than may.

    Who is lost before it is sent sees for a moment without duration.
    """
    n = len(problem.pursuers)
    check.look(
        problem.most is None or n <= problem.most, f"{n} were sent, {problem.most} are allowed"
    )
    check.look(n >= problem.begin_with, f"{n} were sent, {problem.begin_with} were there")
    names = [one.name for one in problem.pursuers]
    check.look(len(set(names)) == n, "two pursuers have the same name")
    for i, one in enumerate(problem.pursuers):
        legs = np.flatnonzero(schedule.active[:, i])
        if len(legs) == 0:
            check.look(False, f"{one.name} is never there")
            continue
        first, last = int(legs[0]), int(legs[-1])
        check.look(len(legs) == last - first + 1, f"{one.name} comes back after it was lost")
        x, y = schedule.positions[first, i].tolist()
        away = hypot(x - one.start[0], y - one.start[1])
        for i_lost, at_s in problem.deaths:
            begin, end = schedule.times[last : last + 2].tolist()
            there = i_lost == i and end > begin and end > at_s + SLACK * (1 + at_s)
            check.look(not there, f"{one.name} is there after it was lost at {at_s:g} s")
        check.look(away <= SLACK * (1 + hypot(x, y)), f"{one.name} enters {away:.3g} m off")


def check_walls(problem: Problem, schedule: Schedule, lattice: Lattice, check: Check) -> None:
    """Everybody stays on the floor, as far as the lattice tells."""
    for m, i in np.argwhere(schedule.active).tolist():
        check.looked += 1
        ends = [lattice.snap(schedule.positions[m + end, i]) for end in range(2)]
        name = problem.pursuers[i].name
        if ends[0] is None or ends[1] is None:
            x, y = schedule.positions[m + (ends[0] is not None), i].tolist()
            check.fault(f"in leg {m} {name} is outside the floor at ({x:g}, {y:g})")
        elif not lattice.joined(ends[0], ends[1]):
            check.fault(f"in leg {m} {name} crosses a wall")


def check_speed(problem: Problem, schedule: Schedule, speed: Check, reach: Check) -> None:
    """Nobody is faster than it can be, nor drives farther than it can."""
    driven = np.zeros(len(problem.pursuers))
    for m, i in np.argwhere(schedule.active).tolist():
        one = problem.pursuers[i]
        length = float(np.hypot(*(schedule.positions[m + 1, i] - schedule.positions[m, i])))
        lasts = float(schedule.times[m + 1] - schedule.times[m])
        driven[i] += length
        speed.look(
            length <= one.speed_mps * lasts * (1 + SLACK) + SLACK,
            f"in leg {m} {one.name} drives {length:.6g} m in {lasts:.6g} s",
        )
    for one, length in zip(problem.pursuers, driven.tolist(), strict=True):
        if one.reach_m is not None:
            reach.look(
                length <= one.reach_m * (1 + SLACK) + SLACK,
                f"{one.name} drives {length:.6g} m of {one.reach_m:.6g} m",
            )


def check_knowledge(problem: Problem, schedule: Schedule, lattice: Lattice, check: Check) -> None:
    """On an unknown floor nobody drives where none of the team has seen the floor before.

    The rule and its fairness: docs/pursuit-verifier.md, section 7.
    """
    if problem.known:
        return
    seen: list[tuple[Place, float]] = []  # where somebody looked round, and how far it saw
    for m in range(len(schedule.active)):
        here = np.flatnonzero(schedule.active[m]).tolist()
        for i in here:
            range_m = problem.pursuers[i].range_m
            if range_m is not None:
                seen.append((schedule.positions[m, i], range_m))
        for i in here:
            _check_drive(problem, schedule, lattice, check, seen, m, i)
        for i in here:
            range_m = problem.pursuers[i].range_m
            if range_m is None:
                continue
            a, b = schedule.positions[m, i], schedule.positions[m + 1, i]
            parts = int(float(np.hypot(*(b - a))) / range_m * SAMPLES) + 1
            seen += [(a + (b - a) * k / parts, range_m) for k in range(1, parts + 1)]


def _check_drive(
    problem: Problem,
    schedule: Schedule,
    lattice: Lattice,
    check: Check,
    seen: list[tuple[Place, float]],
    m: int,
    i: int,
) -> None:
    """The part of a leg beyond the range of who drives it was seen before."""
    one = problem.pursuers[i]
    check.looked += 1
    a, b = schedule.positions[m, i], schedule.positions[m + 1, i]
    length = float(np.hypot(*(b - a)))
    # The floor along a straight drive is seen from where it begins, up to the range.
    if one.range_m is None or length <= one.range_m * (1 + SLACK):
        return
    parts = int(length / one.range_m * SAMPLES) + 1
    known: dict[bytes, Point | None] = {}
    for k in range(parts + 1):
        x = a + (b - a) * k / parts
        if not any(
            float(np.hypot(*(x - place))) <= range_m * (1 + SLACK)
            and _joined(lattice, known, place, x)
            for place, range_m in reversed(seen)
        ):
            check.fault(
                f"in leg {m} {one.name} drives to ({x[0]:g}, {x[1]:g}), which nobody had seen"
            )
            return


def _joined(lattice: Lattice, known: dict[bytes, Point | None], place: Place, x: Place) -> bool:
    ends: list[Point] = []
    for at in (place, x):
        key = at.tobytes()
        if key not in known:
            known[key] = lattice.snap(at)
        point = known[key]
        if point is None:
            return False
        ends.append(point)
    return lattice.joined(ends[0], ends[1])


def check_result(
    result: dict[str, Any], problem: Problem, schedule: Schedule, check: Check
) -> None:
    """The numbers of the result follow from the legs."""
    expected = {
        "pursuers": len(problem.pursuers),
        "legs": len(schedule.active),
        "time_s": float(schedule.times[-1] - schedule.times[0]),
        "distance_m": schedule.distance_m,
    }
    for name, value in expected.items():
        said = result.get(name)
        near = isinstance(said, int | float) and abs(said - value) <= SLACK * (1 + abs(value))
        check.look(near, f"{name} is {said!r}, not {value:.9g}")
    lower = result.get("lower_bound")
    check.look(
        isinstance(lower, int) and lower >= 0, f"lower_bound is {lower!r}, which is no number"
    )
    minimal = result.get("minimal_proved")
    if isinstance(lower, int) and result.get("status") == "done":
        check.look(
            lower <= len(problem.pursuers),
            f"fewer than {lower} cannot do it, it says, and {len(problem.pursuers)} did",
        )
    check.look(
        minimal is False or (minimal is True and lower == len(problem.pursuers)),
        f"minimal_proved is {minimal!r} with a bound of {lower!r}",
    )
