"""What a study finds: rows for the CSV, a table and plots for the page, and verdicts on claims."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.intervals import Estimate

HELD = "held"
NOT_HELD = "did not hold"
OPEN = "not decided"


class Row(NamedTuple):
    """A number of the CSV."""

    study: str
    team: str
    s_range: int
    measure: str
    unit: str
    value: float
    low: float  # of the 95 % interval, empty in the file where there is none
    high: float
    n: int  # layouts


class CurveRow(NamedTuple):
    """A point of a curve for the CSV of curves."""

    study: str
    team: str
    s_range: int
    measure: str
    step: int
    value: float
    low: float
    high: float


class Verdict(NamedTuple):
    """A claim of the paper and what was found here."""

    source: str
    claim: str
    verdict: str
    numbers: str


@dataclass
class Section:
    """One study on the page."""

    name: str
    title: str
    text: str
    header: tuple[str, ...] = ()
    table: list[tuple[str, ...]] = field(default_factory=list[tuple[str, ...]])
    rows: list[Row] = field(default_factory=list[Row])
    curves: list[CurveRow] = field(default_factory=list[CurveRow])
    verdicts: list[Verdict] = field(default_factory=list[Verdict])
    pictures: list[tuple[str, str, Callable[[Path], None]]] = field(
        default_factory=list[tuple[str, str, Callable[[Path], None]]]
    )
    """File name, what it shows, and who draws it."""

    def add(self, team: str, s_range: int, measure: str, unit: str, found: Estimate) -> None:
        """Add an estimate to the rows."""
        self.rows.append(Row(self.name, team, s_range, measure, unit, *found))

    def add_curve(
        self,
        team: str,
        s_range: int,
        measure: str,
        curve: Sequence[NDArray[np.float64]],
        every: int = 10,
    ) -> None:
        """Add every so many points of a curve (mean, low, high) to the rows of curves."""
        mean, low, high = curve
        self.curves.extend(
            CurveRow(
                self.name,
                team,
                s_range,
                measure,
                step,
                *map(float, (mean[step], low[step], high[step])),
            )
            for step in range(0, len(mean), every)
        )

    def judge(self, source: str, claim: str, verdict: str, numbers: str) -> None:
        """Add a verdict."""
        self.verdicts.append(Verdict(source, claim, verdict, numbers))


def below(found: Estimate, limit: float) -> str:
    """The verdict on "this is less than the limit"."""
    if found.high < limit:
        return HELD
    return NOT_HELD if found.low > limit else OPEN


def above(found: Estimate, limit: float) -> str:
    """The verdict on "this is more than the limit"."""
    if found.low > limit:
        return HELD
    return NOT_HELD if found.high < limit else OPEN


def every(verdicts: Sequence[str]) -> str:
    """The verdict on all of them together."""
    if NOT_HELD in verdicts:
        return NOT_HELD
    return OPEN if OPEN in verdicts else HELD


def number(value: float) -> str:
    """A number as people read it: three or four digits."""
    if not isfinite(value):
        return "-"
    size = abs(value)
    if size >= 1000:
        return f"{value:,.0f}"
    if size >= 100:
        return f"{value:.0f}"
    if size >= 10:
        return f"{value:.1f}"
    if size >= 1:
        return f"{value:.2f}"
    return f"{value:.3f}" if size >= 0.001 or size == 0 else f"{value:.2g}"


def estimate(found: Estimate) -> str:
    """An estimate as text: value [low, high]."""
    if not isfinite(found.low) or not isfinite(found.high):
        return number(found.value)
    return f"{number(found.value)} [{number(found.low)}, {number(found.high)}]"


def percent(found: Estimate) -> str:
    """A share as text: percent [low, high]."""
    if not isfinite(found.low) or not isfinite(found.high):
        return f"{100 * found.value:.1f} %"
    return f"{100 * found.value:.1f} % [{100 * found.low:.1f}, {100 * found.high:.1f}]"
