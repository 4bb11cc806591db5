"""Teams: who may join one, and what one that found nothing leaves."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from conav.errors import InputError
from conav.geometry.sight_lines import sees
from conav.geometry.triangulation import Triangulation, triangulate
from conav.pursuit.types import Pursuer, PursuitProblem, PursuitResult, Schedule
from conav.status import Status

LARGEST = 60  # pursuers: a drive needs two views more, and there are bits for 62


def known_floor(
    problem: PursuitProblem, *, reach: bool = False, faults: bool = False
) -> Triangulation:
    """The triangulated floor of a problem that a method for known floors can take.

    Raises `InputError` for an unknown floor, a limited range, a start off the floor, and, unless
    the method can do with it, a limited reach or pursuers that are lost.
    """
    if problem.faults and not faults:
        raise InputError(
            "pursuit", "loses pursuers, which this method does not plan for", "use delegation"
        )
    if not problem.known:
        raise InputError("pursuit", "the floor is not known", "give a method for unknown floors")
    for one in problem.pursuers:
        if one.range_m is not None or (one.reach_m is not None and not reach):
            raise InputError(
                f"pursuer {one.name!r}",
                f"has a limited range{'' if reach else ' or reach'}, "
                "which this method does not plan for",
                "leave it out" if reach else "leave both out",
            )
    mesh = triangulate(problem.floor.vertices, problem.floor.ring_starts)
    for one in problem.pursuers:
        x, y = one.start
        if not sees(mesh, (x, y), (x, y)):
            raise InputError(
                f"pursuer {one.name!r}", f"starts at ({x:g}, {y:g}), off the floor", "move it"
            )
    return mesh


def team_of(problem: PursuitProblem, size: int) -> tuple[Pursuer, ...]:
    """The problem's pursuers, and more like the first."""
    team = list(problem.pursuers[:size])
    taken = {one.name for one in team}
    number = len(team)
    while len(team) < size:
        number += 1
        name = f"pursuer_{number}"
        if name not in taken:
            team.append(replace(problem.pursuers[0], name=name))
    return tuple(team)


def may_grow(problem: PursuitProblem, size: int) -> bool:
    """Whether a team of this size may have one pursuer more."""
    return size < LARGEST and (problem.most is None or size < problem.most)


def out_of_budget(
    pursuers: Sequence[Pursuer], reason: str, counters: dict[str, int]
) -> PursuitResult:
    """The result of a method that found nothing: everybody stands at its start."""
    starts = np.array([one.start for one in pursuers], dtype=np.float64)
    stand = Schedule(np.zeros(1), starts[None], np.empty((0, len(pursuers)), np.bool_))
    return PursuitResult(
        Status.OUT_OF_BUDGET,
        reason,
        stand,
        tuple(pursuers),
        lower_bound=1,
        minimal_proved=False,
        counters=counters,
    )
