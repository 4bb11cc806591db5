"""Outcomes of the reproduction by study, estimates, and pieces of the page."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, nan
from typing import Any, NamedTuple

from conav.experiments.compare.outcome import Failure
from conav.experiments.potential_games.report import HELD, NOT_HELD, OPEN, Verdict
from conav.experiments.pursuit.play import Played
from conav.experiments.pursuit.world import Case, is_random
from conav.intervals import Estimate, mean_interval, ratio_interval


class Row(NamedTuple):
    """A number of the CSV."""

    study: str
    what: str
    measure: str
    unit: str
    value: float
    low: float  # of the 95 % interval, empty in the file where there is none
    high: float
    n: int  # random floors


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

    def add(self, study: str, what: str, measure: str, unit: str, found: Estimate) -> Estimate:
        """Adds a number of the CSV, and hands it back."""
        self.rows.append(Row(study, what, measure, unit, *found))
        return found

    def judge(self, source: str, claim: str, verdict: str, numbers: str) -> None:
        """Adds a verdict."""
        self.verdicts.append(Verdict(source, claim, verdict, numbers))


@dataclass(frozen=True)
class Results:
    """What was played; cases that failed or are missing are left out."""

    found: Mapping[Case, Played | Failure]

    def rows(self, study: str, setting: str | None = None) -> list[dict[str, Any]]:
        """All rows of a study, or those of one setting, in the order of the cases."""
        return [
            row
            for case, one in self.found.items()
            if case.study == study and setting in (None, case.setting) and isinstance(one, Played)
            for row in one.rows
        ]


def randoms(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows of random floors."""
    return [row for row in rows if is_random(row["floor"])]


def was_split(row: dict[str, Any]) -> bool:
    """Whether guards were posted on a floor, and left parts with places to go to."""
    return row["guards"] > 0 and row["parts_total"] > 0


def mean_of(values: Sequence[float]) -> Estimate:
    """The mean with its interval; unbounded without enough values."""
    return mean_interval(values) if values else Estimate(nan, -inf, inf, 0)


def ratio_of(above: Sequence[float], below: Sequence[float]) -> Estimate:
    """The geometric mean of ratios with its interval; unbounded without enough values."""
    if not above:
        return Estimate(nan, 0.0, inf, 0)
    return ratio_interval(above, below)


def always(so: Sequence[bool]) -> str:
    """The verdict on "this is always so": one exception is enough, and nothing says nothing."""
    if not so:
        return OPEN
    return HELD if all(so) else NOT_HELD
