"""Runs, and pieces of sections made of them: rows, tables, verdicts over team sizes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from conav.experiments.compare.outcome import Failure
from conav.experiments.potential_games.report import (
    HELD,
    NOT_HELD,
    OPEN,
    Verdict,
    below,
    estimate,
    every,
)
from conav.experiments.two_stage.play import Played
from conav.experiments.two_stage.world import METHODS, Case
from conav.intervals import Estimate, mean_interval, ratio_interval

Value = Callable[[Played], float]

RIVALS = ("DTA", "RAA")


class Row(NamedTuple):
    """A number of the CSV."""

    measure: str
    unit: str
    method: str  # or two, for a ratio of paired runs
    robots: int
    wait_s: float
    value: float
    low: float  # of the 95 % interval, empty in the file where there is none
    high: float
    n: int  # runs


@dataclass
class Section:
    """One measure on the page."""

    title: str
    text: str
    header: tuple[str, ...] = ()
    table: list[tuple[str, ...]] = field(default_factory=list[tuple[str, ...]])
    rows: list[Row] = field(default_factory=list[Row])
    verdicts: list[Verdict] = field(default_factory=list[Verdict])
    pictures: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])
    """File name, and what it shows."""


@dataclass(frozen=True)
class Results:
    """The runs of a reproduction."""

    found: Mapping[Case, Played | Failure]
    robots: tuple[int, ...]
    seeds: tuple[int, ...]

    def runs(self, method: str, robots: int, wait_s: float) -> dict[int, Played]:
        """The runs of a method by seed."""
        at = {seed: self.found.get(Case(method, robots, wait_s, seed)) for seed in self.seeds}
        return {seed: run for seed, run in at.items() if isinstance(run, Played)}

    def mean(self, method: str, robots: int, wait_s: float, value: Value) -> Estimate | None:
        """The mean of a value over runs, None without any."""
        values = [value(run) for run in self.runs(method, robots, wait_s).values()]
        return mean_interval(values) if values else None

    def ratio(
        self, one: str, other: str, robots: int, wait_s: float, value: Value
    ) -> Estimate | None:
        """The geometric mean of the first method's value over the second's in paired runs."""
        a, b = self.runs(one, robots, wait_s), self.runs(other, robots, wait_s)
        pairs = [(value(a[seed]), value(b[seed])) for seed in a if seed in b]
        if not pairs or min(min(pair) for pair in pairs) <= 0:
            return None
        return ratio_interval([x for x, _ in pairs], [y for _, y in pairs])

    def difference(
        self, one: str, other: str, robots: int, wait_s: float, value: Value
    ) -> Estimate | None:
        """The mean of the first method's value less the second's in paired runs."""
        a, b = self.runs(one, robots, wait_s), self.runs(other, robots, wait_s)
        pairs = [value(a[seed]) - value(b[seed]) for seed in a if seed in b]
        return mean_interval(pairs) if pairs else None


def row(
    section: Section,
    results: Results,
    measure: str,
    unit: str,
    method: str,
    robots: int,
    wait_s: float,
    value: Value,
) -> Estimate | None:
    """A mean, which is added to the rows."""
    found = results.mean(method, robots, wait_s, value)
    if found is not None:
        section.rows.append(Row(measure, unit, method, robots, wait_s, *found))
    return found


def ratio_row(
    section: Section,
    results: Results,
    measure: str,
    rival: str,
    robots: int,
    wait_s: float,
    value: Value,
) -> Estimate | None:
    """The ratio of TSCA's value to a rival's, which is added to the rows."""
    found = results.ratio("TSCA", rival, robots, wait_s, value)
    if found is not None:
        section.rows.append(Row(measure, "ratio", f"TSCA/{rival}", robots, wait_s, *found))
    return found


def compare_methods(
    section: Section,
    results: Results,
    measure: str,
    name: str,
    value: Value,
    *,
    most: bool = False,
) -> None:
    """A line of the table for each team size: the methods' means, and their ranking."""
    for robots in results.robots:
        found = {
            method: row(section, results, measure, "", method, robots, 5.0, value)
            for method in METHODS
        }
        for rival in RIVALS:
            ratio_row(section, results, measure, rival, robots, 5.0, value)
        known = {method: mean.value for method, mean in found.items() if mean is not None}
        section.table.append(
            (
                str(robots),
                name,
                *("-" if mean is None else estimate(mean) for mean in found.values()),
                ranking(known, most=most),
            )
        )


def ranking(values: Mapping[str, float], *, most: bool = False) -> str:
    """The methods in the order of their values, the least first or the most; equal ones joined.

    >>> ranking({"TSCA": 2.0, "DTA": 1.0, "RAA": 2.0})
    'DTA < TSCA = RAA'
    """
    order = sorted(values, key=lambda method: -values[method] if most else values[method])
    text = ""
    for before, method in zip([None, *order], order, strict=False):
        if before is not None:
            same = values[before] == values[method]
            text += " = " if same else " > " if most else " < "
        text += method
    return text


def judge_sizes(
    section: Section,
    results: Results,
    source: str,
    claim: str,
    value: Value,
    *,
    rivals: Sequence[str] = RIVALS,
    sizes: Sequence[int] | None = None,
) -> None:
    """A verdict per rival on "TSCA has less", at every team size; paired differences decide."""
    for rival in rivals:
        found: list[tuple[int, Estimate, str]] = []
        for robots in sizes if sizes is not None else results.robots:
            less = results.difference("TSCA", rival, robots, 5.0, value)
            if less is not None:
                found.append((robots, less, below(less, 0.0)))
        if found:
            section.verdicts.append(
                over_sizes(source, f"{claim}, against {rival}", found, f"TSCA less {rival}")
            )


def over_sizes(
    source: str, claim: str, found: Sequence[tuple[int, Estimate, str]], what: str
) -> Verdict:
    """The verdict at all team sizes, with where it held and the first and last numbers."""
    verdicts = [verdict for _, _, verdict in found]
    parts = [
        f"{verdict} with {numbers_text([robots for robots, _, other in found if other == verdict])}"
        for verdict in (HELD, NOT_HELD, OPEN)
        if verdict in verdicts
    ]
    ends = [found[0]] if len(found) == 1 else [found[0], found[-1]]
    numbers = ", ".join(f"{estimate(mean)} with {robots}" for robots, mean, _ in ends)
    return Verdict(source, claim, every(verdicts), f"{'; '.join(parts)} robots. {what}: {numbers}")


def numbers_text(values: Sequence[int]) -> str:
    """Ascending numbers as text, runs of them joined.

    >>> numbers_text([1, 2, 3, 5, 8, 9])
    '1 to 3, 5, 8, 9'
    """
    parts: list[str] = []
    begin = 0
    for i in range(1, len(values) + 1):
        if i == len(values) or values[i] != values[i - 1] + 1:
            run = values[begin:i]
            parts += [f"{run[0]} to {run[-1]}"] if len(run) > 2 else [str(value) for value in run]
            begin = i
    return ", ".join(parts)
