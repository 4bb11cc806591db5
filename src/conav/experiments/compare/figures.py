"""The plots of a comparison: coverage over time, and the measures over what was varied."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.experiments.compare.cases import Group, Study
from conav.experiments.compare.outcome import Outcome
from conav.experiments.compare.tables import Line, Table
from conav.experiments.compare.wording import group_text, short_text
from conav.intervals import Estimate
from conav.pictures.plots import Series, save_curves, save_points

MAX_CURVES = 12
"""Groups whose coverage is drawn: nobody looks at more, and the tables have them all."""
MAX_PANELS = 6

_NUMERIC = ("robots", "range_m")  # what can stand along an axis of numbers
_POINTS = 241  # along the time axis
_INTERVAL = "Median of the runs with its 95 % interval."


class Figure(NamedTuple):
    """A picture of the folder and what it shows."""

    file: str
    text: str


class _Panel(NamedTuple):
    """The groups that stand along one axis."""

    title: str
    axis: str  # the field of `Group` along it
    tables: list[Table]


def draw(folder: Path, study: Study, made: Sequence[Table]) -> list[Figure]:
    """Draw everything. Raises `InputError` without matplotlib."""
    figures = [_coverage(folder, study, table, k) for k, table in enumerate(made[:MAX_CURVES])]
    panels = list(_panels(study, made))[:MAX_PANELS]
    for k, panel in enumerate(panels):
        end = f"-{k + 1}" if len(panels) > 1 else ""
        figures += _measures(folder, study, panel, end)
    return figures


def coverage_at(
    runs: Sequence[Outcome], times: NDArray[np.float64]
) -> NDArray[np.float64]:  # (n_runs, n_times) whole percent
    """The share of what can be seen that each run has seen at each time [%]."""
    found = np.empty((len(runs), len(times)))
    for k, run in enumerate(runs):
        reached = np.array([time for time in run.percent_s if time is not None], dtype=np.float64)
        found[k] = np.searchsorted(reached, times, side="right")
    return found


def _coverage(folder: Path, study: Study, table: Table, number: int) -> Figure:
    runs = [run for outcomes in table.outcomes.values() for run in outcomes]
    last = max((time or 0.0 for run in runs for time in run.percent_s), default=0.0)
    times = np.linspace(0.0, max(last, runs[0].step_s), _POINTS)
    series: list[Series] = []
    for team in study.teams:
        if team.name in table.outcomes:
            covered = coverage_at(table.outcomes[team.name], times)
            low, middle, high = np.percentile(covered, [25, 50, 75], axis=0)
            series.append(Series(team.name, times, middle, low, high))
    title = group_text(study, table.group)
    figure = Figure(f"coverage-{number + 1}.png", f"Coverage over time, {title}")
    save_curves(
        folder / figure.file,
        series,
        xlabel="simulated time [s]",
        ylabel="coverage [%]",
        title=title,
        note="Median of the runs at each time; the band holds the middle half of them.",
        y_range=(0.0, 100.0),
    )
    return figure


def _panels(study: Study, made: Sequence[Table]) -> Iterator[_Panel]:
    """The tables, those together that differ in one thing: numbers where there are several."""
    axis = "map"
    if len(study.robots) > 1:
        axis = "robots"
    elif len(study.ranges_m) > 1:
        axis = "range_m"
    elif len(study.maps) == 1 and len(study.radios) > 1:
        axis = "radio"
    found: dict[tuple[Any, ...], list[Table]] = {}
    for table in made:
        rest = table.group._replace(**{axis: ""})
        found.setdefault(rest, []).append(table)
    for rest, those in found.items():
        yield _Panel(short_text(study, Group(*rest), without=axis), axis, those)


def _measures(folder: Path, study: Study, panel: _Panel, end: str) -> list[Figure]:
    limit = f"Runs that did not get there count as {study.world.max_time_s:,g} s."
    figures: list[Figure] = []
    for share, what in ((90, "time to 90 % coverage"), (100, "time to full coverage")):
        figure = Figure(f"t{share}{end}.png", _titled(what, panel.title))
        series = _series(study, panel, partial(_median_time, share))
        _points(folder / figure.file, panel, series, f"{what} [s]", f"{_INTERVAL} {limit}")
        figures.append(figure)
    for name, what, unit in (
        ("overlap", "overlap: what each robot saw, added up, over what the team saw, minus 1", ""),
        ("balance", "balance: spread of the robots' shares of the new area, 0 is even", ""),
        ("traffic", "messages sent by the team", " [kB]"),
    ):
        figure = Figure(f"{name}{end}.png", _titled(what.partition(":")[0], panel.title))
        series = _series(study, panel, partial(_measure, name))
        _points(folder / figure.file, panel, series, what + unit, _INTERVAL)
        figures.append(figure)
    return figures


def _median_time(share: int, line: Line) -> Estimate:
    return line.times[share].median


def _measure(name: str, line: Line) -> Estimate:
    return line.measures[name]


def _titled(what: str, panel: str) -> str:
    text = what[0].upper() + what[1:]
    return f"{text}, {panel}" if panel else text


def _points(path: Path, panel: _Panel, series: list[Series], ylabel: str, note: str) -> None:
    axes = {"map": "map", "robots": "robots", "range_m": "sensor range [m]", "radio": "radio"}
    save_points(
        path,
        series,
        xlabel=axes[panel.axis],
        ylabel=ylabel,
        title=panel.title,
        note=note,
        y_range=(0.0, None),
        connect=panel.axis in _NUMERIC,
    )


def _series(study: Study, panel: _Panel, value: Callable[[Line], Estimate]) -> list[Series]:
    """The points of each strategy; those without an interval are dots."""
    found: list[Series] = []
    for team in study.teams:
        points: list[tuple[Any, Estimate]] = [
            (getattr(table.group, panel.axis), value(line))
            for table in panel.tables
            for line in table.lines
            if line.strategy == team.name
        ]
        if not points:
            continue
        if panel.axis in _NUMERIC:
            points.sort(key=lambda point: point[0])
        found.append(
            Series(
                team.name,
                [x for x, _ in points],
                [y.value for _, y in points],
                [y.low if isfinite(y.low) else y.value for _, y in points],
                [y.high if isfinite(y.high) else y.value for _, y in points],
            )
        )
    return found
