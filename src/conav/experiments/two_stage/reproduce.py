"""`conav reproduce two-stage`: the paper's simulation, a page of what was found, numbers, plots."""

import os
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

from conav.errors import InputError
from conav.experiments.compare.journal import JOURNAL, Journal
from conav.experiments.potential_games.report import Verdict
from conav.experiments.study_folder import PAGE, drawn, in_range, made_folder, write_csv
from conav.experiments.two_stage.claims import SECTIONS, unfinished
from conav.experiments.two_stage.figures import draw_curves, draw_runs
from conav.experiments.two_stage.lab import Lab, Progress
from conav.experiments.two_stage.page import NUMBERS, RUNS, TITLE, page
from conav.experiments.two_stage.play import Played
from conav.experiments.two_stage.results import Results, Row
from conav.experiments.two_stage.world import World, all_cases, problem_of
from conav.pictures.output import whole_file
from conav.robots.motion import MOTIONS

SIZES = tuple(range(1, 11))
MOST_ROBOTS = 64
LEAST_SIDE_M = 20.0


@dataclass(frozen=True)
class Reproduction:
    """What was made: the folder, the verdicts, and whether all runs were played."""

    folder: Path
    verdicts: tuple[Verdict, ...]
    cases: int
    done: int
    unfinished: int  # runs that did not see all
    failed: int  # runs that could not be played
    interrupted: bool
    warnings: tuple[str, ...]

    def summary(self) -> dict[str, Any]:
        """The object that `conav reproduce --json` prints."""
        return {
            "job": "reproduce",
            "paper": "two-stage",
            "folder": str(self.folder),
            "cases": self.cases,
            "done": self.done,
            "unfinished": self.unfinished,
            "failed": self.failed,
            "interrupted": self.interrupted,
            "verdicts": [verdict._asdict() for verdict in self.verdicts],
            "warnings": list(self.warnings),
        }


def reproduce(
    folder: str | os.PathLike[str],
    *,
    robots: Sequence[int] = SIZES,
    runs: int = 30,
    seed: int = 0,
    motion: str = "8-connected",
    side_m: float = 100.0,
    jobs: int = 1,
    plots: bool = True,
    progress: Progress = lambda done, total: None,
) -> Reproduction:
    """The reproduction of [Dai2018], written to a folder: a page, two CSV files and plots.

    `runs` for each size of `robots`, run k from the starts of seed `seed` + k, on `jobs` processes.
    Each run is kept in the folder as it ends; what is there already is not played again, so an
    interrupted or killed reproduction goes on where it was. Without matplotlib there are no plots,
    and a warning. Raises `InputError` for numbers out of range, team sizes that do not fit and a
    folder that cannot be written.
    """
    in_range("runs", runs, 1, 10_000)
    in_range("jobs", jobs, 1, 1024)
    in_range("seed", seed, 0, 2**62)
    in_range("side", side_m, LEAST_SIDE_M, 1000.0)
    sizes = tuple(sorted(set(robots)))
    if not sizes:
        raise InputError("robots", "names no team size", "give one at least, for example 1,2,4")
    for count in sizes:
        in_range("robots", count, 1, MOST_ROBOTS)
    if motion not in MOTIONS:
        raise InputError(f"motion {motion!r}", "is not known", "use one of: " + ", ".join(MOTIONS))
    world = World(side_m, motion)
    for number in range(seed, seed + runs):
        problem_of(sizes[-1], number, world)
    target = made_folder(Path(folder), TITLE)
    cases = all_cases(sizes, runs, seed)
    warnings: list[str] = []
    with Journal(target / JOURNAL, Played.read) as journal:
        lab = Lab(world, journal, jobs, progress)
        finished = lab.play(cases)
        results = Results(lab.results(cases), sizes, tuple(range(seed, seed + runs)))
        if plots and finished:
            drawn(lambda: draw_curves(target, results), warnings)
            drawn(lambda: draw_runs(target, lab, seed), warnings)
    sections = [make(results) for make in SECTIONS]
    write_csv(target / NUMBERS, Row._fields, (row for section in sections for row in section.rows))
    write_csv(
        target / RUNS,
        (*cases[0]._fields, *(item.name for item in fields(Played))),
        (
            (*case, *astuple(run))
            for case in cases
            if case == case.played and isinstance(run := results.found.get(case), Played)
        ),
    )
    with whole_file(target / PAGE) as stream:
        stream.write(page(target, sections, results, world, wanted=len(cases)).encode())
    late, failed = unfinished(results)
    return Reproduction(
        target,
        tuple(verdict for section in sections for verdict in section.verdicts),
        len(cases),
        len(results.found),
        late,
        failed,
        not finished,
        tuple(warnings),
    )
