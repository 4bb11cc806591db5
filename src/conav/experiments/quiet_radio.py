"""Time against bandwidth: potential games by robots that talk now and then.

Teams of `potential-quiet` with different rules for their radios play the same layouts of
`three-obstacles`, in the world of [Philip2014]; times are put beside those of `potential`, whose
radios are always on, pair by pair.
"""

import csv
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from conav.experiments.compare.compare import compare
from conav.experiments.compare.outcome import Outcome
from conav.experiments.compare.tables import time_to
from conav.intervals import Estimate, mean_interval, ratio_interval
from conav.pictures.output import whole_file
from conav.pictures.plots import Series, save_points
from conav.simulation.finish_bounds import NO_BOUNDS

SHARES = (90, 99, 100)
ROBOTS = 3
S_RANGE = 2.0  # [m] as many points
MAX_TIME_S = 8000.0
WORLD: dict[str, Any] = {
    "cell_m": 1.0,
    "speed_mps": 1.0,
    "motion": "forward-turn",
    "sensor": "disc",
    "traffic": "none",
}
ALWAYS_ON = "always on"


@dataclass(frozen=True)
class QuietTeam:
    """A rule for radios, and the line of the plot it belongs to."""

    label: str
    family: str
    settings: Mapping[str, object]


def _clock(every: int, news: int = 0) -> QuietTeam:
    label, family = f"k = {every}", "every k steps"
    if news:
        label, family = f"{label}, {news} new", f"{family}, {news} new cells"
    return QuietTeam(label, family, {"every": every, "news": news})


def _near(within_m: float) -> QuietTeam:
    return QuietTeam(f"r = {within_m:g}", "within r", {"every": 0, "within_m": within_m})


TEAMS: tuple[QuietTeam, ...] = (
    *(_clock(every) for every in (1, 2, 5, 10, 20, 50, 100, int(MAX_TIME_S))),
    *(_clock(every, 20) for every in (1, 2, 5, 10, 20, 50, 100)),
    *(_near(within_m) for within_m in (1.0, 2.0, 4.0, 6.0, 10.0)),
)
"""With the longest k robots talk in the first step only."""


@dataclass(frozen=True)
class Bandwidth:
    """What a team's radios cost and what that costs in time; times in simulated seconds."""

    label: str
    family: str
    finished: int  # runs that saw everything; the others count at the time limit
    bytes: Estimate  # per robot and step, until all is seen
    total: Estimate  # bytes of the whole run
    times: tuple[Estimate, ...]  # mean time to each of `SHARES`
    ratios: tuple[Estimate, ...]  # to the team that is always on, in the same layout


def quiet_radio(
    folder: str | os.PathLike[str],
    *,
    layouts: int = 40,
    teams: Sequence[QuietTeam] = TEAMS,
    jobs: int | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Bandwidth]:
    """The teams, the one that is always on first; runs are kept in `folder`, see `compare`.

    Raises `InputError` for bad input and `RuntimeError` where a run failed or was interrupted.
    """
    names = [f"team-{number}" for number in range(len(teams))]
    done = compare(
        ["three-obstacles"],
        ["potential", *(f"{name}=potential-quiet" for name in names)],
        folder,
        robots=(ROBOTS,),
        ranges_m=(S_RANGE,),
        runs=layouts,
        settings={name: team.settings for name, team in zip(names, teams, strict=True)},
        jobs=jobs,
        bounds=NO_BOUNDS,
        plots=False,
        progress=progress,
        max_time_s=MAX_TIME_S,
        **WORLD,
    )
    outcomes: dict[str, list[Outcome]] = {}
    for case in done.study.cases():
        outcome = done.results.get(case)
        if not isinstance(outcome, Outcome):
            raise RuntimeError(f"no run of {case.strategy} with seed {case.seed}: {outcome}")
        outcomes.setdefault(case.strategy, []).append(outcome)
    always = outcomes["potential"]
    found = [_bandwidth(QuietTeam(ALWAYS_ON, ALWAYS_ON, {}), always, always)]
    for name, team in zip(names, teams, strict=True):
        found.append(_bandwidth(team, outcomes[name], always))
    return found


def _bandwidth(team: QuietTeam, runs: Sequence[Outcome], always: Sequence[Outcome]) -> Bandwidth:
    times = [[time_to(run, share, MAX_TIME_S) for run in runs] for share in SHARES]
    beside = [[time_to(run, share, MAX_TIME_S) for run in always] for share in SHARES]
    return Bandwidth(
        team.label,
        team.family,
        sum(run.percent_s[-1] is not None for run in runs),
        mean_interval([run.bytes / (ROBOTS * max(run.steps, 1)) for run in runs]),
        mean_interval([float(run.bytes) for run in runs]),
        tuple(mean_interval(column) for column in times),
        tuple(ratio_interval(one, two) for one, two in zip(times, beside, strict=True)),
    )


def write_bandwidth(rows: Sequence[Bandwidth], path: str | os.PathLike[str]) -> None:
    """Write a CSV with a row per team; an estimate takes three columns, with its low and high."""
    lines = StringIO()
    table = csv.writer(lines, lineterminator="\n")
    names = ["bytes_per_robot_step", "bytes"]
    names += [f"t{share}_{what}" for what in ("s", "ratio") for share in SHARES]
    ends = ("", "_low", "_high")
    table.writerow(["team", "rule", "done", *(name + end for name in names for end in ends)])
    for row in rows:
        estimates = (row.bytes, row.total, *row.times, *row.ratios)
        numbers = [f"{value:.6g}" for at in estimates for value in at[:3]]
        table.writerow([row.label, row.family, row.finished, *numbers])
    with whole_file(Path(path)) as stream:
        stream.write(lines.getvalue().encode())


def draw_bandwidth(
    rows: Sequence[Bandwidth], path: str | os.PathLike[str], share: int, *, note: str = ""
) -> None:
    """Draw the time to one of `SHARES`, beside the team that is always on, against the bytes."""
    column = SHARES.index(share)
    families = list(dict.fromkeys(row.family for row in rows))
    series: list[Series] = []
    for family in families:
        of = sorted((row for row in rows if row.family == family), key=lambda row: row.bytes.value)
        series.append(
            Series(
                family,
                [row.bytes.value for row in of],
                [row.ratios[column].value for row in of],
                [row.ratios[column].low for row in of],
                [row.ratios[column].high for row in of],
            )
        )
    save_points(
        path,
        series,
        xlabel="bytes per robot and step",
        ylabel=f"time to {share} %, in times of the team that is always on",
        note=note,
        log_x=True,
        connect=True,
    )
