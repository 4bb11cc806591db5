"""Bounds on the finishing time of an exploration, from the problem alone."""

from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, inf, isinf

import numpy as np
from numpy.typing import NDArray

from conav.exploration.bounds.eccentricity import eccentricity_steps
from conav.exploration.bounds.swath import Swath, swath_of, swath_steps
from conav.exploration.bounds.views import Places, Survey, look_cells, survey
from conav.exploration.bounds.witness import witness_bound
from conav.exploration.types import ExplorationProblem

SAMPLED = 0.3  # of a budget that does not suffice for all places


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
    upper_by: str | None = None  # which run that is

    def with_run(self, time_s: float | None, by: str) -> "FinishBounds":
        """These bounds and what a run adds to them: whoever did it shows that it can be done.

        `time_s` is when the run had seen the share, None if it never did.
        """
        if time_s is None or (self.upper_s is not None and self.upper_s <= time_s):
            return self
        return replace(self, upper_s=time_s, upper_by=by)

    def ratios(self, time_s: float) -> tuple[float, float]:
        """The least and the greatest that the ratio of a run's time to the optimum can be."""
        return ratio_interval(time_s, self.lower_s, self.upper_s)

    def ratios_beyond(self, time_s: float) -> tuple[float, float]:
        """The same for a run that had not seen the share by a time: the ratio is at least that."""
        return self.ratios(time_s)[0], inf


def ratio_interval(time_s: float, lower_s: float, upper_s: float | None) -> tuple[float, float]:
    """The least and the greatest that the ratio of a run's time to the optimum can be.

    These are the time over the upper and over the lower bound. No run is better than the best one,
    so the first is 1 at least, without an upper bound as well. Over a bound of 0 the ratio is 1 for
    time 0 and inf for any other.
    """
    least = 1.0 if upper_s is None else max(1.0, _ratio(time_s, upper_s))
    return least, _ratio(time_s, lower_s)


def _ratio(time_s: float, bound_s: float) -> float:
    if bound_s == 0.0:
        return 1.0 if time_s == 0.0 else inf
    return time_s / bound_s


@dataclass(frozen=True, eq=False)
class Ground:
    """What bounds for all shares have in common: what is seen from where, and how soon."""

    problem: ExplorationProblem
    observable: NDArray[np.uint8]  # (fine rows, fine cols)
    places: Places
    swath: Swath
    seen: Survey

    @staticmethod
    def of(
        problem: ExplorationProblem, observable: NDArray[np.uint8], *, most: float = inf
    ) -> "Ground":
        """The ground of a problem, by looking from every place.

        Where these looks would touch more than `most` cells together, `SAMPLED` of that go into
        looks from some observable cells, evenly chosen, and of the others nothing is known. Bounds
        are valid all the same; those for shares below 1 are weaker.
        """
        places = Places.of(problem)
        swath = swath_of(problem, places, observable)
        touched = look_cells(problem, places)
        cells = None
        if touched * len(places.cells) > most:
            candidates = np.flatnonzero(observable.reshape(-1))
            count = max(int(SAMPLED * most / touched), 1)
            cells = candidates[:: max(-(-len(candidates) // count), 1)]
        return Ground(problem, observable, places, swath, survey(problem, places, cells))


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
    more doubles its work, and 0 leaves it out. A map of 250 x 250 cells takes half a second.

    Raises `ValueError` for a share that is not from 0 to 1.
    """
    return lower_bounds_on(Ground.of(problem, observable), share, witnesses=witnesses)


def lower_bounds_on(ground: Ground, share: float = 1.0, *, witnesses: int = 15) -> FinishBounds:
    """The same for one share of several, whose common ground was surveyed once."""
    problem, observable, places = ground.problem, ground.observable, ground.places
    count = int(np.count_nonzero(observable))
    needed = cells_needed(share, count)
    found = witness_bound(problem, places, ground.seen, observable, needed, most=witnesses)
    steps = {
        "swath": swath_steps(ground.swath, needed),
        "eccentricity": eccentricity_steps(ground.seen, observable, needed),
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
        caught=ground.swath.caught,
        places=len(places.cells),
        tried=found.tried,
    )


def time_of(problem: ExplorationProblem, steps: float) -> float:
    """The time of a step [s] as a run reports it."""
    return steps if isinf(steps) else round(steps * problem.step_s, 9)
