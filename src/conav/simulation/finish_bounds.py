"""Bounds on the optimum from both sides: what no team can beat, and what one with a map did.

How much work goes into them is counted in rounds and cells touched, never in seconds, so that a
seed gives the same bounds on every machine.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from conav.errors import InputError
from conav.exploration.bounds.bounds import (
    FinishBounds,
    Ground,
    cells_needed,
    lower_bounds_on,
    time_of,
)
from conav.exploration.bounds.views import Places, look_cells
from conav.exploration.metrics import SHARES
from conav.exploration.types import ExplorationProblem
from conav.simulation.known_map_run import KNOWN_MAP, known_map_run
from conav.simulation.observable import observable_cells

NO_BOUNDS = "none"
DEFAULT_EFFORT = "quick"


@dataclass(frozen=True)
class Effort:
    """How much work goes into bounds."""

    witnesses: int = 15  # to see all, at most
    part_witnesses: int = 15  # for each smaller share
    rounds: int = 150  # in search of a better plan of a team that knows the map
    plan_each_share: bool = True  # else the plan to see all serves the smaller shares, too
    place_rounds: float = inf  # rounds times places, at most
    lower_cells: float = inf  # touched in looks for the lower bounds, at most: about 3 ns each
    plan_cells: float = inf  # in looks for a plan; there is none where it takes more


EFFORTS = {
    "quick": Effort(
        part_witnesses=0,
        rounds=30,
        plan_each_share=False,
        place_rounds=4e5,
        lower_cells=1e9,
        plan_cells=1e9,
    ),
    "full": Effort(),
}
"""Quick takes a second or two, whatever the map: within a few percent of full on small ones."""


def check_effort(effort: str) -> None:
    """Raises `InputError` for what is neither one of `EFFORTS` nor `NO_BOUNDS`."""
    if effort not in (*EFFORTS, NO_BOUNDS):
        known = ", ".join((*EFFORTS, NO_BOUNDS))
        raise InputError(f"bounds {effort!r}", "is not known", f"use one of: {known}")


def finish_bounds(
    problem: ExplorationProblem,
    shares: Sequence[int] = SHARES,
    *,
    effort: str | Effort = "full",
) -> dict[int, FinishBounds]:
    """Bounds, below and above, on when the best team has seen each share [%] of what it can.

    They depend on map, team, starts and traffic rule alone, not on strategy or radio; where robots
    may die they are for the best radio. Lower bounds take all robots to be in order. `upper_s` is
    None where no team that knows the map was tried, or it had not seen the share at the problem's
    time limit. Raises `ValueError` for a share that is not from 0 to 100.
    """
    how = EFFORTS[effort] if isinstance(effort, str) else effort
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    count = int(np.count_nonzero(observable))
    ground = Ground.of(problem, observable, most=how.lower_cells)
    found = {
        share: lower_bounds_on(
            ground,
            share / 100,
            witnesses=how.witnesses if share == 100 else how.part_witnesses,
        )
        for share in shares
    }
    rounds = _rounds(problem, how)
    if rounds < 0:
        return found
    for planned in shares if how.plan_each_share else (100,):
        run = known_map_run(problem, planned / 100, rounds=rounds)
        if run is None:
            continue
        if run.interrupted:
            raise KeyboardInterrupt
        # A plan for one share may also be the best for another.
        for share, bounds in found.items():
            needed = cells_needed(share / 100, count)
            step = next((k for k, seen in enumerate(run.covered) if seen >= needed), None)
            time_s = None if step is None else time_of(problem, step)
            found[share] = bounds.with_run(time_s, KNOWN_MAP)
    return found


def _rounds(problem: ExplorationProblem, how: Effort) -> int:
    """How many rounds a plan gets, -1 for no plan."""
    places = Places.of(problem)
    if look_cells(problem, places) * len(places.cells) > how.plan_cells:
        return -1
    return int(min(how.rounds, how.place_rounds / max(len(places.cells), 1)))
