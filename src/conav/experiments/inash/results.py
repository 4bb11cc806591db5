"""Plans of a reproduction as arrays over trials and robots, estimates, and pieces of the page."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isnan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.experiments.compare.outcome import Failure
from conav.experiments.inash.play import Played
from conav.experiments.inash.world import EXPERIMENTS, METHODS, Case
from conav.experiments.potential_games.report import HELD, NOT_HELD, OPEN, Verdict
from conav.intervals import Estimate, bootstrap_interval, mean_interval, wilson

Statistic = Callable[[NDArray[np.float64]], float]


class Row(NamedTuple):
    """A number of the CSV."""

    experiment: str
    method: str  # or two, for a difference of paired trials
    measure: str
    unit: str
    robot: str  # its number from 1; empty for the team
    value: float
    low: float  # of the 95 % interval, empty in the file where there is none
    high: float
    n: int  # trials


@dataclass
class Section:
    """One question on the page."""

    title: str
    text: str
    tables: list[tuple[tuple[str, ...], list[tuple[str, ...]]]] = field(
        default_factory=list[tuple[tuple[str, ...], list[tuple[str, ...]]]]
    )
    rows: list[Row] = field(default_factory=list[Row])
    verdicts: list[Verdict] = field(default_factory=list[Verdict])
    pictures: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])
    """File name, and what it shows."""

    def add(
        self,
        experiment: str,
        method: str,
        measure: str,
        unit: str,
        found: Estimate,
        robot: str = "",
    ) -> Estimate:
        """Adds a number of the CSV, and hands it back."""
        self.rows.append(Row(experiment, method, measure, unit, robot, *found))
        return found


@dataclass(frozen=True)
class Results:
    """What was planned; trials in which a method's plan is missing or failed are left out."""

    found: Mapping[Case, Played | Failure]
    trials: tuple[int, ...]

    def plans(self, experiment: str, method: str, robots: int | None = None) -> list[Played]:
        """A method's plans, in the order of the trials that all methods have played."""
        count = EXPERIMENTS[experiment].robots if robots is None else robots
        plans = (
            self.found.get(Case(experiment, method, count, trial))
            for trial in self.paired(experiment)
        )
        return [one for one in plans if isinstance(one, Played)]

    def paired(self, experiment: str) -> list[int]:
        """The trials that all methods have played."""
        count = EXPERIMENTS[experiment].robots
        return [
            trial
            for trial in self.trials
            if all(
                isinstance(self.found.get(Case(experiment, method, count, trial)), Played)
                for method in METHODS
            )
        ]

    def reached(self, experiment: str, method: str) -> NDArray[np.float64]:
        """1 where a robot has a path to its goal, else 0; (trials, robots)."""
        return np.array([one.reached for one in self.plans(experiment, method)], dtype=np.float64)

    def ratios(self, experiment: str, method: str) -> NDArray[np.float64]:
        """Lengths over solo lengths, nan without a path; (trials, robots)."""
        return np.array([one.ratios for one in self.plans(experiment, method)], dtype=np.float64)

    def lengths(self, experiment: str, method: str) -> NDArray[np.float64]:
        """Lengths [m], nan without a path; (trials, robots)."""
        return np.array([one.length_m for one in self.plans(experiment, method)], dtype=np.float64)


def each_trial(statistic: Statistic, *tables: NDArray[np.float64]) -> Estimate:
    """The mean over trials of a statistic of one table's rows, or of its paired difference of two.

    For tables without gaps, whose statistic is linear in the robots.
    """
    signs = (1.0, -1.0)
    return mean_interval(
        [
            sum(sign * statistic(row[None]) for sign, row in zip(signs, rows, strict=False))
            for rows in zip(*tables, strict=True)
        ]
    )


LEAST_TRIALS = 8
"""A bootstrap of fewer says too little: intervals come out far too narrow."""


def over_trials(statistic: Statistic, *tables: NDArray[np.float64]) -> Estimate:
    """A statistic of one table, (trials, robots), or its difference of two paired ones.

    The interval is a bootstrap over trials, whose robots stay together; the same draws each time.
    It is unbounded with fewer than `LEAST_TRIALS`.
    """
    first = tables[0]

    def value(at: NDArray[np.int64]) -> float:
        less = statistic(tables[1][at]) if len(tables) > 1 else 0.0
        return statistic(first[at]) - less

    if len(first) < LEAST_TRIALS:
        return Estimate(value(np.arange(len(first))), -inf, inf, len(first))
    return bootstrap_interval(value, len(first), np.random.Generator(np.random.PCG64(0)))


def slope(values: NDArray[np.float64]) -> float:
    """The least-squares slope over robots of each one's mean over trials; nan when one has none.

    >>> slope(np.array([[1.0, 2.0, 3.0], [1.0, np.nan, 5.0]]))
    1.5
    """
    means = means_of(values)
    place = np.arange(len(means)) - (len(means) - 1) / 2.0
    return float((place * means).sum() / (place * place).sum())


def spread(values: NDArray[np.float64]) -> float:
    """The largest of the robots' means over trials less the smallest.

    >>> spread(np.array([[1.0, 2.0], [1.0, 4.0]]))
    2.0
    """
    means = means_of(values)
    return float(means.max() - means.min())


def exponent(values: NDArray[np.float64], sizes: Sequence[int]) -> float:
    """The slope of the logarithm of each column's mean over that of its size; nan where one is 0.

    >>> round(exponent(np.array([[1.0, 3.0], [3.0, 5.0]]), [2, 4]), 12)
    1.0
    """
    means = values.mean(axis=0)
    if means.min() <= 0:
        return float("nan")
    return float(np.polyfit(np.log(sizes), np.log(means), 1)[0])


def means_of(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Each robot's mean over the trials in which it has a value, (robots,); nan without any."""
    there = ~np.isnan(values)
    count = there.sum(axis=0)
    total = np.where(there, values, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def mean_of(values: NDArray[np.float64]) -> float:
    """The mean of all values there are; nan without any."""
    there = values[~np.isnan(values)]
    return float(there.mean()) if len(there) else float("nan")


def paired_difference(a: NDArray[np.float64], b: NDArray[np.float64]) -> Estimate | None:
    """The mean over trials of each trial's mean of a - b, over robots that have both."""
    trials = [mean_of(row) for row in a - b]
    known = [value for value in trials if not isnan(value)]
    return mean_interval(known) if known else None


def share_of(good: Sequence[bool]) -> Estimate:
    """The share of what is good, with the interval of [Wilson1927]."""
    found = wilson(sum(good), len(good))
    return Estimate(found.share, found.low, found.high, found.trials)


def more(found: Estimate, limit: float) -> str:
    """The verdict on "this is more than the limit"; an interval that ends at it says no."""
    if isnan(found.value):
        return OPEN
    if found.low > limit:
        return HELD
    return NOT_HELD if found.high <= limit else OPEN


def less(found: Estimate, limit: float) -> str:
    """The verdict on "this is less than the limit"."""
    return more(Estimate(-found.value, -found.high, -found.low, found.n), -limit)
