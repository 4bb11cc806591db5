"""`conav reproduce potential-games`: every study, a page of what was found, the numbers, plots."""

import csv
import os
from collections.abc import Callable, Collection
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from conav.errors import InputError
from conav.experiments.potential_games.lab import Lab
from conav.experiments.potential_games.report import (
    CurveRow,
    Row,
    Section,
    Verdict,
)
from conav.experiments.potential_games.studies import STUDIES
from conav.experiments.potential_games.world import ROBOTS, SEEDS, SIDE, STEPS
from conav.pictures.output import whole_file
from conav.pictures.potential_figures import FIGURES

PAGE = "README.md"
NUMBERS = "numbers.csv"
CURVES = "curves.csv"


@dataclass(frozen=True)
class Reproduction:
    """What was made: the folder, the verdicts, and whether all studies were finished."""

    folder: Path
    verdicts: tuple[Verdict, ...]
    studies: tuple[str, ...]
    interrupted: bool
    warnings: tuple[str, ...]

    def summary(self) -> dict[str, Any]:
        """The object that `conav reproduce --json` prints."""
        return {
            "job": "reproduce",
            "paper": "potential-games",
            "folder": str(self.folder),
            "studies": list(self.studies),
            "interrupted": self.interrupted,
            "verdicts": [verdict._asdict() for verdict in self.verdicts],
            "warnings": list(self.warnings),
        }


def reproduce(
    folder: str | os.PathLike[str],
    *,
    layouts: int = 20,
    games: int = 200,
    runs: int = 5,
    steps: int = STEPS,
    jobs: int = 1,
    only: Collection[str] = (),
    progress: Callable[[str], None] = lambda text: None,
) -> Reproduction:
    """The reproduction of [Philip2014], written to a folder: a page, two CSV files and plots.

    `layouts` of the map, `games` per layout in bulk and `runs` by the ordinary simulator, of
    `steps` at most; `only` some of `STUDIES`. The folder is brought up to date after every study,
    so an interrupt from the keyboard keeps what was done. Without matplotlib there are no plots,
    and a warning. Raises `InputError` for unknown studies, numbers out of range and a folder that
    cannot be written.
    """
    for name, value, least, most in (
        ("layouts", layouts, 1, 10_000),
        ("games", games, 1, SEEDS),
        ("runs", runs, 1, SEEDS),
        ("steps", steps, 2000, 1_000_000),
        ("jobs", jobs, 1, 1024),
    ):
        if not least <= value <= most:
            raise InputError(f"{name} {value}", "is out of range", f"give {least} to {most}")
    for name in only:
        if name not in STUDIES:
            raise InputError(
                f"study {name!r}", "is not known", "use some of: " + ", ".join(STUDIES)
            )
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            target, f"cannot be made ({error.strerror})", "give another --out"
        ) from None
    warnings: list[str] = []
    done: list[Section] = []
    interrupted = False
    with Lab(layouts, games, runs, steps, jobs, progress) as lab:
        try:
            if not only:
                for number, draw in FIGURES.items():
                    _draw(draw, target / f"figure-{number}.png", warnings)
            for name, study in STUDIES.items():
                if only and name not in only:
                    continue
                section = study(lab)
                for file, _, draw in section.pictures:
                    _draw(draw, target / file, warnings)
                done.append(section)
                _write(target, done, lab, complete=len(done) == len(STUDIES))
        except KeyboardInterrupt:
            interrupted = True
    verdicts = tuple(verdict for section in done for verdict in section.verdicts)
    return Reproduction(
        target, verdicts, tuple(section.name for section in done), interrupted, tuple(warnings)
    )


def _draw(draw: Callable[[Path], None], path: Path, warnings: list[str]) -> None:
    """Draw a picture, or remember once why not."""
    try:
        draw(path)
    except InputError as error:
        if "matplotlib" not in error.problem:
            raise
        text = f"no plots: {error.problem.partition(' needs ')[2]}; {error.remedy}"
        if text not in warnings:
            warnings.append(text)


def _write(folder: Path, sections: list[Section], lab: Lab, *, complete: bool) -> None:
    _write_csv(folder / NUMBERS, Row._fields, [row for one in sections for row in one.rows])
    _write_csv(folder / CURVES, CurveRow._fields, [row for one in sections for row in one.curves])
    with whole_file(folder / PAGE) as stream:
        stream.write(page(folder, sections, lab, complete=complete).encode())


def _write_csv(path: Path, header: tuple[str, ...], rows: list[Any]) -> None:
    with whole_file(path) as stream:
        lines = _Lines()
        table = csv.writer(lines, lineterminator="\n")
        table.writerow(header)
        for row in rows:
            table.writerow(
                [
                    (f"{value:.6g}" if isfinite(value) else "")
                    if isinstance(value, float)
                    else value
                    for value in row
                ]
            )
        stream.write("".join(lines.text).encode())


class _Lines:
    """What `csv.writer` writes to."""

    def __init__(self) -> None:
        self.text: list[str] = []

    def write(self, text: str) -> None:
        self.text.append(text)


def page(folder: Path, sections: list[Section], lab: Lab, *, complete: bool) -> str:
    """The page in Markdown; pictures are shown where their files lie in the folder."""
    options = f"--layouts {lab.layouts} --games {lab.games} --runs {lab.runs} --steps {lab.steps}"
    lines = [
        "# Potential games for exploration: what holds",
        "",
        "G. Philip, S. N. Givigi, H. M. Schwartz: Cooperative navigation of unknown environments "
        "using potential games. Int. J. Mechatronics and Automation 4(3), 2014.",
        "",
        f"Made by `conav reproduce potential-games {options}`; the numbers are in "
        f"[{NUMBERS}]({NUMBERS}), the curves in [{CURVES}]({CURVES}).",
        "",
    ]
    if not complete:
        missing = [name for name in STUDIES if name not in {section.name for section in sections}]
        lines += [f"Not all studies are in it; missing: {', '.join(missing)}.", ""]
    verdicts = [verdict for section in sections for verdict in section.verdicts]
    if verdicts:
        lines += [
            "A claim *held* or *did not hold* when the whole 95 % interval says so, and is *not "
            "decided* otherwise. Every claim is judged by itself: of twenty that are false at the "
            "very limit, one may pass as held.",
            "",
            "| where | claim | here | in numbers |",
            "|---|---|---|---|",
        ]
        lines += [
            f"| {one.source} | {one.claim} | **{one.verdict}** | {one.numbers} |"
            for one in verdicts
        ]
        lines.append("")
    lines += [
        "## The world",
        "",
        f"The paper tells of {ROBOTS} robots, three obstacles, four headings and a sensor without "
        "occlusion, and refers to an earlier one for the rest. It gives neither the size of the "
        f"grid nor where obstacles and robots are. Here: {SIDE} x {SIDE} points, {lab.layouts} "
        "layouts of three rectangles at random, robots side by side in a corner with random "
        f"headings, {lab.games} games per layout played in bulk, {lab.runs} by the ordinary "
        "simulator. Robots pass through each other, as in the paper. A game ends after "
        f"{lab.steps} steps; what was not finished then counts as {lab.steps} steps, is marked *at "
        "least*, and the number of finished games is given beside it. T90 is the first step at "
        "which 90 % of the free points were seen. Values are means over layouts with Student's "
        "95 % interval over layouts; ratios are geometric means of ratios paired by layout. So "
        "they speak of such worlds, not of the paper's one.",
        "",
    ]
    drawn = [number for number in FIGURES if (folder / f"figure-{number}.png").is_file()]
    if drawn:
        lines += [
            "The paper's figures of the game itself, drawn from the code that plays it:",
            "",
            " ".join(f"[Figure {number}](figure-{number}.png)" for number in drawn),
            "",
        ]
    for section in sections:
        lines += [f"## {section.title}", "", section.text, ""]
        for file, what, _ in section.pictures:
            if (folder / file).is_file():
                lines += [f"![{what}]({file})", ""]
        if section.table:
            lines += [
                "| " + " | ".join(section.header) + " |",
                "|" + "---|" * len(section.header),
                *("| " + " | ".join(row) + " |" for row in section.table),
                "",
            ]
    return "\n".join(lines)
