"""The page of a comparison and the command that makes it again."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path

from conav import __version__
from conav.experiments.compare.cases import OWN_RADIO, Case, Study, Team, World
from conav.experiments.compare.figures import MAX_CURVES, MAX_PANELS, Figure
from conav.experiments.compare.files import COVERAGE, PARQUET, RESULTS, TIMING
from conav.experiments.compare.journal import JOURNAL
from conav.experiments.compare.outcome import Failure
from conav.experiments.compare.statistics import ENOUGH
from conav.experiments.compare.tables import Result, Table, Total
from conav.experiments.compare.wording import (
    ABOUT,
    AT_LEAST,
    AT_MOST,
    group_rows,
    group_text,
    markdown,
    measure_rows,
    total_rows,
)
from conav.exploration.catalogue import STRATEGIES, make_strategy, settings_of
from conav.simulation.finish_bounds import DEFAULT_EFFORT, NO_BOUNDS

PAGE = "README.md"

_OPTIONS = {
    "motion": "--motion",
    "sensor": "--sensor",
    "cell_m": "--cell",
    "radius_m": "--radius",
    "speed_mps": "--speed",
    "resolution": "--resolution",
    "traffic": "--traffic",
    "loss": "--loss",
    "delay_s": "--delay",
    "energy_j": "--energy",
    "outside": "--outside",
    "outside_folder": "--outside-folder",
    "max_time_s": "--max-time",
}


def command(study: Study, folder: Path) -> str | None:
    """The command that makes the comparison, or None where only Python can say what it is of."""
    if not all(isinstance(place.source, str) for place in study.maps):
        return None
    if not all(team.strategy in STRATEGIES for team in study.teams):
        return None
    words = ["conav", "compare", *(str(place.source) for place in study.maps)]
    words += ["--strategies", ",".join(_named(team) for team in study.teams)]
    words += ["--robots", ",".join(map(str, study.robots))]
    words += ["--range", ",".join(f"{range_m!r}".removesuffix(".0") for range_m in study.ranges_m)]
    if study.radios not in ((OWN_RADIO,), ("perfect",)):
        words += ["--radio", ",".join(study.radios)]
    words += ["--runs", str(len(study.seeds))]
    if study.seeds[0]:
        words += ["--seed", str(study.seeds[0])]
    for item in fields(World):
        value = getattr(study.world, item.name)
        if item.name == "faults":
            words += [word for fault in value for word in ("--fault", str(fault))]
        elif value != item.default:
            words.append(_OPTIONS[item.name])
            words += [] if value is True else [_text(value)]
    for team in study.teams:
        for name, value in _changed(team).items():
            words += ["--set", f"{team.name}.{name}={_text(value)}"]
    if study.effort != DEFAULT_EFFORT:
        words += ["--bounds", study.effort]
    words += ["--out", str(folder)]
    return shlex.join(words)


def page(
    study: Study,
    folder: Path,
    results: Mapping[Case, Result],
    made: Sequence[Table],
    found: Sequence[Total],
    figures: Sequence[Figure],
    warnings: Sequence[str],
) -> str:
    """The page in Markdown."""
    names = [team.name for team in study.teams]
    lines = [
        f"# Comparison of {_and(names)}",
        "",
        *_made_by(study, folder),
        *_played(study, results),
    ]
    if found and len(names) > 1:
        lines += [
            "## Over all",
            "",
            f"Times relative to {names[0]}: geometric means over the runs, paired by map, team and "
            "start.",
            "",
            markdown(total_rows(study, found)),
            "",
        ]
    for k, table in enumerate(made):
        lines += [
            f"## {_capital(group_text(study, table.group))}",
            "",
            markdown(group_rows(study, table)),
            "",
            markdown(measure_rows(study, table)),
            "",
        ]
        if k < MAX_CURVES:
            lines += _shown([one for one in figures if one.file == f"coverage-{k + 1}.png"])
    others = [one for one in figures if not one.file.startswith("coverage-")]
    if others:
        lines += ["## Side by side", "", *_shown(others)]
    if figures and len(made) > MAX_CURVES:
        lines += [
            f"Coverage is drawn for the first {MAX_CURVES} of {len(made)} groups, and no more than "
            f"{MAX_PANELS} plots of each measure.",
            "",
        ]
    lines += _failures(results)
    if warnings:
        lines += ["## What was odd", "", *(f"- {warning}" for warning in warnings), ""]
    return "\n".join(lines + _reading(study))


def _made_by(study: Study, folder: Path) -> list[str]:
    text = command(study, folder)
    made = f"Made by conav {__version__}"
    lines = [f"{made} from Python." if text is None else f"{made}:"]
    if text is not None:
        lines += ["", "```", text, "```"]
    lines += ["", "| strategy | settings |", "|---|---|"]
    for team in study.teams:
        settings = ", ".join(f"{name} {_text(value)}" for name, value in team.settings.items())
        name = team.name if team.strategy == team.name else f"{team.name} ({team.strategy})"
        lines.append(f"| {name} | {settings or 'none'} |")
    return [*lines, ""]


def _played(study: Study, results: Mapping[Case, Result]) -> list[str]:
    asked = len(study.cases())
    first, last = min(study.seeds), max(study.seeds)
    text = f"{asked:,} runs, " + (f"seeds {first} to {last}" if last > first else f"seed {first}")
    if len(results) < asked:
        text = f"**Interrupted: {len(results):,} of {text} were played**"
    drawn = [place.name for place in study.maps if place.seeded]
    if drawn:
        text += f"; of {_and(drawn)} every seed is another layout"
    return [f"{text}. All strategies start a run from the same places.", ""]


def _failures(results: Mapping[Case, Result]) -> list[str]:
    rows = [
        f"- {case.strategy} on {case.map}, {case.robots} robots, range {case.range_m:g} m, "
        f"seed {case.seed}: {result.message}"
        for case, result in results.items()
        if isinstance(result, Failure)
    ]
    return ["## Failed", "", "These runs are in no number above.", "", *rows, ""] if rows else []


def _reading(study: Study) -> list[str]:
    limit = f"{study.world.max_time_s:,g} s"
    return [
        "## How to read it",
        "",
        "- T90, T99 and T100 are the simulated seconds until the team had seen that percentage of "
        "what it could see; the tables have medians over the runs.",
        f"- A run that did not get there counts as {limit}, the time limit, and *all seen* says "
        f"how many saw everything. {AT_LEAST} and {AT_MOST} mark what is at least or at most that; "
        f"{ABOUT} marks a ratio of two strategies neither of which always got there.",
        "- In brackets stands a 95 % interval: of a median by the ranks of the runs, of a ratio "
        "by bootstrap over the pairs of runs. It speaks of runs like these, on these maps. With "
        f"fewer than {ENOUGH} runs there is none.",
        *_reading_best(study),
        "- Ranks are by T100, then by how many got there, then by T99 and T90.",
        "- The other measures are medians of whole runs, so a team that goes on to the time limit "
        "drives and sends more. overlap: what each robot saw, added up, over what the team saw, "
        "minus 1. balance: standard deviation of the robots' shares of the newly seen area.",
        f"- [{RESULTS}]({RESULTS}) has a row per run, `{PARQUET}` the same where it could be "
        f"written, [{COVERAGE}]({COVERAGE}) the time to each percent, [{TIMING}]({TIMING}) wall "
        f"times. `{JOURNAL}` is what the command goes on from when it is given again.",
        "- `conav explore MAP --seed SEED` with the same options plays a run again.",
        "",
    ]


def _reading_best(study: Study) -> list[str]:
    if study.effort == NO_BOUNDS:
        return []
    return [
        "- *T100 over best possible* is the interval in which the median ratio of T100 to the "
        "fastest time possible, for a team that knows the map, lies. The upper end comes from a "
        "certified lower bound, which no team can beat on that map from these starts; the lower "
        "end from the fastest run known: of any strategy here, or of a team that was given the "
        f"map. {AT_LEAST} stands where runs that did not see all leave the upper end open.",
    ]


def _shown(figures: Sequence[Figure]) -> list[str]:
    return [line for one in figures for line in (f"![{one.text}]({one.file})", "")]


def _and(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _named(team: Team) -> str:
    return team.name if team.name == team.strategy else f"{team.name}={team.strategy}"


def _changed(team: Team) -> dict[str, object]:
    """The settings that are not the strategy's own."""
    usual = settings_of(make_strategy(team.strategy))
    return {name: value for name, value in team.settings.items() if value != usual[name]}


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)
