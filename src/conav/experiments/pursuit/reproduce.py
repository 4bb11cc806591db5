"""`conav reproduce pursuit`: the paper's figures and claims, a page of findings, numbers, plots."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from conav.experiments.compare.journal import JOURNAL, Journal
from conav.experiments.compare.outcome import Failure
from conav.experiments.potential_games.report import Verdict
from conav.experiments.pursuit.claims import SECTIONS
from conav.experiments.pursuit.figures import draw
from conav.experiments.pursuit.lab import Progress, play_all
from conav.experiments.pursuit.page import NUMBERS, RUNS, TITLE, page
from conav.experiments.pursuit.play import Played
from conav.experiments.pursuit.results import Results, Row
from conav.experiments.pursuit.world import SIZES, all_cases
from conav.experiments.study_folder import PAGE, drawn, in_range, made_folder, write_csv
from conav.pictures.output import whole_file


@dataclass(frozen=True)
class Reproduction:
    """What was made: the folder, the verdicts, and whether all cases were played."""

    folder: Path
    verdicts: tuple[Verdict, ...]
    cases: int
    done: int
    failed: int  # cases that could not be played
    interrupted: bool
    warnings: tuple[str, ...]

    def summary(self) -> dict[str, Any]:
        """The object that `conav reproduce --json` prints."""
        return {
            "job": "reproduce",
            "paper": "pursuit",
            "folder": str(self.folder),
            "cases": self.cases,
            "done": self.done,
            "failed": self.failed,
            "interrupted": self.interrupted,
            "verdicts": [verdict._asdict() for verdict in self.verdicts],
            "warnings": list(self.warnings),
        }


def reproduce(
    folder: str | os.PathLike[str],
    *,
    runs: int = 20,
    seed: int = 0,
    sizes: int = SIZES,
    jobs: int = 1,
    plots: bool = True,
    progress: Progress = lambda done, total: None,
) -> Reproduction:
    """The reproduction of [Pellier2005], written to a folder: a page, two CSV files and pictures.

    `runs` random floors with the seeds from `seed` on, and `sizes` floors of each made family, on
    `jobs` processes. Each case is kept in the folder as it ends; what is there already is not
    played again, so an interrupted or killed reproduction goes on where it was.
    Without matplotlib there are no plots, and a warning. Raises `InputError` for numbers out of
    range and a folder that cannot be written.
    """
    in_range("runs", runs, 1, 10_000)
    in_range("seed", seed, 0, 2**62)
    in_range("sizes", sizes, 1, SIZES)
    in_range("jobs", jobs, 1, 1024)
    target = made_folder(Path(folder), TITLE)
    cases = all_cases(runs, seed, sizes)
    warnings: list[str] = []
    with Journal(target / JOURNAL, Played.read) as journal:
        found, finished = play_all(cases, journal, jobs, progress)
    results = Results(found)
    sections = [make(results) for make in SECTIONS]
    if plots and finished:
        drawn(lambda: draw(target, results), warnings)
    write_csv(target / NUMBERS, Row._fields, (row for section in sections for row in section.rows))
    write_csv(
        target / RUNS,
        ("study", "floor", "setting", "run", "measure", "value"),
        (
            (*case, number, name, "" if value is None else value)
            for case, one in found.items()
            if isinstance(one, Played)
            for number, row in enumerate(one.rows)
            for name, value in row.items()
            if name != "floor"
        ),
    )
    text = page(target, sections, results, runs=runs, seed=seed, sizes=sizes, wanted=len(cases))
    with whole_file(target / PAGE) as stream:
        stream.write(text.encode())
    return Reproduction(
        target,
        tuple(verdict for section in sections for verdict in section.verdicts),
        len(cases),
        len(found),
        sum(isinstance(one, Failure) for one in found.values()),
        not finished,
        tuple(warnings),
    )
