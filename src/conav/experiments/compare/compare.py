"""`conav compare`: every combination is played, kept as it finishes, and told of in a folder."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from conav.errors import InputError
from conav.experiments.compare.arguments import Map, Strategies, make_study
from conav.experiments.compare.cases import Case, Ground, Study, World, by_seed
from conav.experiments.compare.figures import Figure, draw
from conav.experiments.compare.files import COVERAGE, PARQUET, RESULTS, TIMING, write_files
from conav.experiments.compare.journal import JOURNAL, Journal
from conav.experiments.compare.optimum import against_best
from conav.experiments.compare.outcome import CaseBounds, Failure, Outcome
from conav.experiments.compare.page import PAGE, page
from conav.experiments.compare.run_case import Runner
from conav.experiments.compare.summary import table_summary, total_summary
from conav.experiments.compare.tables import Result, Table, Total, tables, totals
from conav.experiments.compare.workers import Workers
from conav.pictures.output import whole_file
from conav.simulation.finish_bounds import NO_BOUNDS

MAX_JOBS = 1024

Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Comparison:
    """What was compared and what came of it."""

    study: Study
    folder: Path
    results: Mapping[Case, Result]
    """Of each case that was played, in the order of the cases."""
    tables: tuple[Table, ...]
    totals: tuple[Total, ...]
    played: int  # runs of this call; the others were there
    interrupted: bool
    warnings: tuple[str, ...]

    @property
    def failures(self) -> dict[Case, Failure]:
        """The runs that could not be played to their end."""
        return {
            case: result for case, result in self.results.items() if isinstance(result, Failure)
        }

    def summary(self) -> dict[str, Any]:
        """The object that `conav compare --json` prints."""
        return {
            "job": "compare",
            "folder": str(self.folder),
            "runs": len(self.study.cases()),
            "done": sum(isinstance(result, Outcome) for result in self.results.values()),
            "failed": [
                {**case._asdict(), "message": failure.message}
                for case, failure in self.failures.items()
            ],
            "played": self.played,
            "interrupted": self.interrupted,
            "groups": [table_summary(table) for table in self.tables],
            "over_all": [total_summary(total) for total in self.totals],
            "warnings": list(self.warnings),
        }


def compare(
    maps: Sequence[Map],
    strategies: Strategies,
    folder: str | os.PathLike[str],
    *,
    robots: Sequence[int] = (3,),
    ranges_m: Sequence[float] = (7.0,),
    radios: Sequence[str | float] | None = None,
    runs: int = 10,
    seed: int = 0,
    settings: Mapping[str, Mapping[str, object]] | None = None,
    bounds: str = "quick",
    jobs: int | None = None,
    plots: bool = True,
    progress: Progress = lambda done, total: None,
    **world: Any,
) -> Comparison:
    """The comparison of strategies over all combinations of what is given.

    `maps` are built-in names, files or grids. `strategies` are names, NAME=STRATEGY for a second
    one of a kind, or by name: strategies of the catalogue or objects of your own. `radios` are
    "perfect", "off", "path-loss" or ranges [m]; None is perfect, or what a strategy is made for.
    Run k has the seed `seed` + k, so all strategies start it from the same places. `settings` are
    by the strategy's name here. `bounds` is how hard to look for bounds on the best possible time,
    which depends on no strategy: "quick", "full" or "none". `world` are the fields of `World`, as
    for `conav.explore`; `max_time_s` is the time limit [s] that runs without an end are counted at.

    The folder gets the page, the tables of numbers and, with `plots` and matplotlib, the plots.
    Each run is kept in it as it ends; what is there already is not played again. `jobs` is the
    number of processes, by default one per processor; with 1 nothing but this one is used.
    `progress` is told how many runs and bounds there are of how many. An interrupt from the
    keyboard ends the comparison with what was played. Raises `InputError` for bad input, before
    anything is played.
    """
    jobs = jobs if jobs is not None else os.cpu_count() or 1
    if not 1 <= jobs <= MAX_JOBS:
        raise InputError(f"jobs {jobs}", "is out of range", f"give 1 to {MAX_JOBS}")
    options: dict[str, Any] = {**world, "faults": tuple(world.get("faults", ()))}
    study = make_study(
        maps,
        strategies,
        robots=robots,
        ranges_m=ranges_m,
        radios=radios,
        runs=runs,
        seed=seed,
        settings=settings or {},
        bounds=bounds,
        world=World(**options),
    )
    target = Path(folder)
    warnings: list[str] = []
    failed: list[str] = []  # to find bounds
    played, interrupted = 0, False
    with _opened(target) as journal:
        keys = {case: study.key(case) for case in study.cases()}
        if journal.unreadable:
            warnings.append(
                f"{journal.path}: line {journal.unreadable[0]} cannot be read; what it held is "
                "played again where it is asked for"
            )
        first: dict[str, Case] = {}  # a strategy under two names is played once
        for case, key in keys.items():
            first.setdefault(key, case)
        missing = [
            case for key, case in first.items() if not isinstance(journal.results.get(key), Outcome)
        ]
        grounds = (
            {} if study.effort == NO_BOUNDS else {g: study.bounds_key(g) for g in study.grounds()}
        )
        unbounded = [ground for ground, key in grounds.items() if key not in journal.bounds]
        total = len(first) + len(grounds)
        done = total - len(missing) - len(unbounded)
        progress(done, total)
        try:
            jobs_wanted = min(jobs, max(len(missing), len(unbounded), 1))
            with Workers(partial(Runner, study), jobs_wanted) as workers:
                _check(study, workers, missing)
                for case, result in workers.each("run", by_seed(missing)):
                    journal.add(keys[case], result)
                    played += 1
                    progress(done + played, total)
                for number, (ground, limits) in enumerate(workers.each("bounds", unbounded), 1):
                    if isinstance(limits, CaseBounds):
                        journal.add_bounds(grounds[ground], limits)
                    else:
                        failed.append(f"no bounds for {_text(ground)}: {limits.message}")
                    progress(done + played + number, total)
        except KeyboardInterrupt:
            interrupted = True
        found = {case: journal.results[key] for case, key in keys.items() if key in journal.results}
        held = {g: journal.bounds[key] for g, key in grounds.items() if key in journal.bounds}
    best = against_best(study, found, held)
    made = tables(study, found, best)
    over_all = totals(study, found, best, made)
    odd = _odd(found) + failed
    warnings += odd + write_files(target, study, found, best)
    figures = _drawn(target, study, made, warnings) if plots and not interrupted else []
    with whole_file(target / PAGE) as stream:
        stream.write(page(study, target, found, made, over_all, figures, odd).encode())
    return Comparison(
        study, target, found, tuple(made), tuple(over_all), played, interrupted, tuple(warnings)
    )


def _opened(folder: Path) -> Journal[Outcome]:
    """The journal in the folder, which is made. What others wrote there is not written over."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            folder, f"cannot be made ({error.strerror})", "choose another --out"
        ) from None
    if not (folder / JOURNAL).exists():
        for name in (PAGE, RESULTS, COVERAGE, TIMING, PARQUET):
            if (folder / name).exists():
                raise InputError(
                    folder, f"holds a {name} that is of no comparison", "choose another --out"
                )
    return Journal(folder / JOURNAL, Outcome.read)


def _check(study: Study, workers: Workers, missing: Sequence[Case]) -> None:
    """Raises `InputError` for what would keep one of these from being played.

    The largest team has to fit on every map of every seed, and every strategy to make a first step
    on every map: a comparison is refused at once, not after half of it.
    """
    fits: dict[tuple[str, int], Case] = {}
    begins: dict[tuple[str, str], Case] = {}
    for case in sorted(missing, key=lambda case: -case.robots):
        fits.setdefault((case.map, case.seed), case)
        begins.setdefault((case.map, case.strategy), case)
    for method, cases in (("fits", fits), ("begins", begins)):
        wrong = {
            case: error
            for case, error in workers.each(method, list(cases.values()))
            if isinstance(error, InputError)
        }
        for case in missing:
            if case in wrong:
                raise wrong[case]


def _text(ground: Ground) -> str:
    return f"{ground.map}, {ground.robots} robots, range {ground.range_m:g} m, seed {ground.seed}"


def _odd(found: Mapping[Case, Result]) -> list[str]:
    """What was odd about the maps, once each."""
    texts: dict[tuple[str, str], str] = {}
    for case, result in found.items():
        if isinstance(result, Outcome):
            for warning in result.warnings:
                # The same with other numbers, as of another layout, is nothing new.
                texts.setdefault((case.map, warning[:40]), f"map {case.map}: {warning}")
    return list(texts.values())


def _drawn(folder: Path, study: Study, made: Sequence[Table], warnings: list[str]) -> list[Figure]:
    try:
        return draw(folder, study, made)
    except InputError as error:
        if "matplotlib" not in error.problem:
            raise
        warnings.append(f"no plots: {error.problem.partition(' needs ')[2]}; {error.remedy}")
        return []
