"""Bounds on the finishing time of an exploration, from the problem alone."""

from dataclasses import dataclass
from fractions import Fraction
from math import ceil, inf, isinf

import numpy as np
from numpy.typing import NDArray

from conav.exploration.bounds.eccentricity import eccentricity_steps
from conav.exploration.bounds.swath import swath_of, swath_steps
from conav.exploration.bounds.views import Places, survey
from conav.exploration.bounds.witness import witness_bound
from conav.exploration.types import ExplorationProblem


@dataclass(frozen=True)
class FinishBounds:
    """When a team can have seen a share of what it can observe; times are simulated seconds.

    No team with these robots and starts does before `lower_s`, whatever its strategy, its radio,
    the traffic rule and what it knows of the map. A run, with the problem's traffic rule, did at
    `upper_s`. The optimum lies between them. A lower bound of inf says that the share can never be
    seen.
    """

    share: float
    observable: int  # cells
    needed: int  # of these
    lower_s: float
    by: str  # which of the three it is: "swath", "eccentricity" or "witness"
    swath_s: float
    eccentricity_s: float
    witness_s: float
    witnesses: tuple[int, ...]  # fine cells, flat
    caught: int  # cells that the swath bound takes for seen at the start
    places: int  # planning cells the team can reach
    tried: int  # sets of witnesses looked at
    upper_s: float | None = None  # None where no run is known that does

    def ratios(self, time_s: float) -> tuple[float, float]:
        """A time over the upper and over the lower bound: its ratio to the optimum lies between.

        The first is 0 without an upper bound. Where a bound is 0 the ratio is 1 for time 0 and inf
        for any other.
        """
        low = 0.0 if self.upper_s is None else _ratio(time_s, self.upper_s)
        return low, _ratio(time_s, self.lower_s)


def _ratio(time_s: float, bound_s: float) -> float:
    if bound_s == 0.0:
        return 1.0 if time_s == 0.0 else inf
    return time_s / bound_s


def cells_needed(share: float, observable: int) -> int:
    """How many of the observable cells a share is, rounded up: 0.7 of 10 is 7.

    Decimal shares are taken as written; 0.7 as a float is a little less and 0.7 * 10 a little more.
    Raises `ValueError` for a share that is not from 0 to 1.
    """
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"share {share} is not from 0 to 1")
    return ceil(Fraction(str(float(share))) * observable)


def lower_bounds(
    problem: ExplorationProblem,
    observable: NDArray[np.uint8],
    share: float = 1.0,
    *,
    witnesses: int = 15,
) -> FinishBounds:
    """Certified lower bounds on when a team can have seen a share of the observable cells.

    `observable` (fine rows, fine cols) is 1 for the cells that count, as a run counts them:
    `conav.simulation.observable`. `witnesses` is how many the witness bound takes at most; each
    more doubles its work, and 0 leaves it out. A map of 250 x 250 cells takes a second or two.

    Raises `ValueError` for a share that is not from 0 to 1.
    """
    count = int(np.count_nonzero(observable))
    needed = cells_needed(share, count)
    places = Places.of(problem)
    seen = survey(problem, places)
    swath = swath_of(problem, places, observable)
    found = witness_bound(problem, places, seen, observable, needed, most=witnesses)
    steps = {
        "swath": swath_steps(swath, needed),
        "eccentricity": eccentricity_steps(seen, observable, needed),
        "witness": found.steps,
    }
    times = {name: time_of(problem, value) for name, value in steps.items()}
    by = max(times, key=lambda name: times[name])
    return FinishBounds(
        share=share,
        observable=count,
        needed=needed,
        lower_s=times[by],
        by=by,
        swath_s=times["swath"],
        eccentricity_s=times["eccentricity"],
        witness_s=times["witness"],
        witnesses=found.cells,
        caught=swath.caught,
        places=len(places.cells),
        tried=found.tried,
    )


def time_of(problem: ExplorationProblem, steps: float) -> float:
    """The time of a step [s] as a run reports it."""
    return steps if isinf(steps) else round(steps * problem.step_s, 9)
