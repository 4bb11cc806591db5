"""How runs compare with the best possible time to see all, which is known from both sides."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from conav.experiments.compare.cases import Case, Ground, Study
from conav.experiments.compare.outcome import CaseBounds, Failure, Outcome
from conav.exploration.bounds.bounds import ratio_interval
from conav.simulation.known_map_run import KNOWN_MAP


class AgainstBest(NamedTuple):
    """A run against the best possible one: bounds on that one's time [s] and on the ratio."""

    lower_s: float
    lower_by: str  # swath, eccentricity or witness
    upper_s: float | None  # of the fastest run known, None where none saw all
    upper_by: str | None  # the strategy that made it, or "known-map"
    low: float
    high: float  # inf for a run that did not see all


def against_best(
    study: Study,
    results: Mapping[Case, Outcome | Failure],
    bounds: Mapping[Ground, CaseBounds],
) -> dict[Case, AgainstBest]:
    """Each run whose ground has bounds, against the best possible one.

    A run that saw all is a plan: the fastest one of any strategy and radio is an upper bound, like
    the run of a team that knows the map. So no ratio is below 1.
    """
    fastest: dict[Ground, tuple[float, str]] = {
        ground: (found.known_map_s, KNOWN_MAP)
        for ground, found in bounds.items()
        if found.known_map_s is not None
    }
    for case in study.cases():
        run = results.get(case)
        time = run.percent_s[-1] if isinstance(run, Outcome) else None
        if time is not None and time < fastest.get(case.ground, (np.inf, ""))[0]:
            fastest[case.ground] = (time, case.strategy)
    found: dict[Case, AgainstBest] = {}
    for case, run in results.items():
        if isinstance(run, Outcome) and case.ground in bounds:
            limits = bounds[case.ground]
            upper_s, by = fastest.get(case.ground, (None, None))
            time = run.percent_s[-1]
            spent = study.world.max_time_s if time is None else time
            low, high = ratio_interval(spent, limits.lower_s, upper_s)
            found[case] = AgainstBest(
                limits.lower_s,
                limits.lower_by,
                upper_s,
                by,
                low,
                high if time is not None else np.inf,
            )
    return found


def median_ratio(found: Sequence[AgainstBest]) -> tuple[float, float] | None:
    """Between what the median of the ratios lies: the medians of their lower and upper ends."""
    if not found:
        return None
    return float(np.median([one.low for one in found])), float(
        np.median([one.high for one in found])
    )
