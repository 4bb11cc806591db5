"""`conav reproduce inash`: the paper's two experiments, a page of findings, numbers, plots."""

import os
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from conav.experiments.compare.journal import JOURNAL, Journal
from conav.experiments.compare.outcome import Failure
from conav.experiments.inash.claims import SECTIONS
from conav.experiments.inash.figures import draw
from conav.experiments.inash.lab import Progress, play_all
from conav.experiments.inash.page import NUMBERS, PLANS, TITLE, page
from conav.experiments.inash.play import Played
from conav.experiments.inash.results import Results, Row
from conav.experiments.inash.world import Effort, all_cases
from conav.experiments.potential_games.report import Verdict
from conav.experiments.study_folder import PAGE, drawn, in_range, made_folder, write_csv
from conav.pictures.output import whole_file


@dataclass(frozen=True)
class Reproduction:
    """What was made: the folder, the verdicts, and whether all plans were made."""

    folder: Path
    verdicts: tuple[Verdict, ...]
    cases: int
    done: int
    failed: int  # plans that could not be made
    broken: int  # plans in which the verifier found a breach
    interrupted: bool
    warnings: tuple[str, ...]

    def summary(self) -> dict[str, Any]:
        """The object that `conav reproduce --json` prints."""
        return {
            "job": "reproduce",
            "paper": "inash",
            "folder": str(self.folder),
            "cases": self.cases,
            "done": self.done,
            "failed": self.failed,
            "broken": self.broken,
            "interrupted": self.interrupted,
            "verdicts": [verdict._asdict() for verdict in self.verdicts],
            "warnings": list(self.warnings),
        }


def reproduce(
    folder: str | os.PathLike[str],
    *,
    trials: int = 20,
    seed: int = 0,
    samples: int | None = None,
    batch: int = Effort().batch,
    jobs: int = 1,
    plots: bool = True,
    progress: Progress = lambda done, total: None,
) -> Reproduction:
    """The reproduction of [Zhu2014], written to a folder: a page, two CSV files and plots.

    `trials` of both experiments with the seeds from `seed` on, on `jobs` processes; `samples` of
    each robot instead of the calibrated ones. Each plan is kept in the folder as it is made; what
    is there already is not made again, so an interrupted or killed reproduction goes on where it
    was.
    Without matplotlib there are no plots, and a warning. Raises `InputError` for numbers out of
    range and a folder that cannot be written.
    """
    in_range("trials", trials, 1, 10_000)
    in_range("seed", seed, 0, 2**62)
    in_range("jobs", jobs, 1, 1024)
    in_range("batch", batch, 1, 1_000_000)
    if samples is not None:
        in_range("samples", samples, 1, 1_000_000)
    effort = Effort(samples, batch)
    target = made_folder(Path(folder), TITLE)
    cases = all_cases(trials, seed)
    warnings: list[str] = []
    with Journal(target / JOURNAL, Played.read) as journal:
        found, finished = play_all(cases, effort, journal, jobs, progress)
    results = Results(found, tuple(range(seed, seed + trials)))
    sections = [make(results) for make in SECTIONS]
    if plots and finished:
        drawn(lambda: draw(target, results, sections), warnings)
    write_csv(target / NUMBERS, Row._fields, (row for section in sections for row in section.rows))
    names = [item.name for item in fields(Played)]
    plans = [(case, plan) for case, plan in found.items() if isinstance(plan, Played)]
    write_csv(
        target / PLANS,
        ("experiment", "method", "robots", "trial", *names),
        ((*case, *(_cell(getattr(plan, name)) for name in names)) for case, plan in plans),
    )
    with whole_file(target / PAGE) as stream:
        stream.write(page(target, sections, results, effort, wanted=len(cases)).encode())
    return Reproduction(
        target,
        tuple(verdict for section in sections for verdict in section.verdicts),
        len(cases),
        len(found),
        sum(isinstance(one, Failure) for one in found.values()),
        sum(bool(plan.broken) for _, plan in plans),
        not finished,
        tuple(warnings),
    )


def _cell(value: object) -> object:
    """Several numbers in one cell, those that are missing left out between semicolons."""
    if not isinstance(value, tuple):
        return value
    return ";".join(
        "" if one is None else f"{one:.6g}" if isinstance(one, float) else str(one) for one in value
    )
