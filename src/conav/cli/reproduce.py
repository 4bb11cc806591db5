"""`conav reproduce`."""

import json as json_module
import os
import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, Parameter

from conav.cli.numbers import Whole
from conav.errors import InputError

reproduce = App(
    name="reproduce",
    help="Play a paper's experiments again and say which of its claims hold.",
    help_format="plaintext",
)


@reproduce.command(name="potential-games")
def potential_games(
    *,
    out: Path = Path("reproduction-potential-games"),
    layouts: Whole = 20,
    games: Whole = 200,
    runs: Whole = 5,
    steps: Whole = 8000,
    jobs: Whole | None = None,
    only: Annotated[list[str] | None, Parameter(negative="")] = None,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Philip, Givigi, Schwartz 2014: cooperative navigation using potential games.

    Parameters
    ----------
    out
        Folder for the page, the numbers and the plots.
    layouts
        How many layouts of the map.
    games
        Games per layout that are played in bulk.
    runs
        Games per layout by the ordinary simulator.
    steps
        Steps after which a game ends.
    jobs
        Processes. Default: one per processor.
    only
        Play only this study; may be repeated.
    json
        Print one JSON object instead of the summary.
    quiet
        Print nothing but errors.
    """
    from conav.experiments.potential_games.reproduce import reproduce as run

    shown = sys.stderr.isatty() and not quiet

    def progress(text: str) -> None:
        if shown:
            print(f"conav: {text}", file=sys.stderr)

    made = run(
        out,
        layouts=layouts,
        games=games,
        runs=runs,
        steps=steps,
        jobs=jobs if jobs is not None else os.cpu_count() or 1,
        only=only or (),
        progress=progress,
    )
    return _told(made, json=json, quiet=quiet)


@reproduce.command(name="two-stage")
def two_stage(
    *,
    out: Path = Path("reproduction-two-stage"),
    robots: str = "1,2,3,4,5,6,7,8,9,10",
    runs: Whole = 30,
    seed: Whole = 0,
    motion: str = "8-connected",
    side: float = 100.0,
    jobs: Whole | None = None,
    plots: bool = True,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Dai, Jiang 2018: a two-stage coordinated strategy.

    Runs are kept as they end: the same command goes on where it was stopped, and with more runs or
    team sizes only those are played that are missing.

    Parameters
    ----------
    out
        Folder for the page, the numbers, the plots, and the runs that were played.
    robots
        Team sizes, for example 1,2,4.
    runs
        Runs of each team size with each method. Run k has the same starts for all methods.
    seed
        Seed of the first run; each further run has the next.
    motion
        4-connected, 8-connected or forward-turn.
    side
        Side of the square area [m].
    jobs
        Processes. Default: one per processor.
    plots
        Draw the plots.
    json
        Print one JSON object instead of the summary.
    quiet
        Print nothing but errors.
    """
    sizes: list[int] = []
    for part in robots.split(","):
        try:
            sizes.append(int(part))
        except ValueError:
            raise InputError(
                "--robots", f"{part.strip()!r} is not a whole number", "part several by commas"
            ) from None

    from conav.compiled import compiled_before
    from conav.experiments.two_stage.reproduce import reproduce as run

    if not quiet and not compiled_before():
        print(
            "conav: compiling the kernels; this happens once and takes about 15 s", file=sys.stderr
        )
    shown = sys.stderr.isatty() and not quiet

    def progress(done: int, total: int) -> None:
        if shown:
            print(f"\rconav: {done} of {total} runs ", end="", file=sys.stderr, flush=True)

    made = run(
        out,
        robots=sizes,
        runs=runs,
        seed=seed,
        motion=motion,
        side_m=side,
        jobs=jobs if jobs is not None else os.cpu_count() or 1,
        plots=plots,
        progress=progress,
    )
    if shown:
        print(file=sys.stderr)
    code = _told(made, json=json, quiet=quiet)
    return 1 if made.failed else code


@reproduce.command(name="inash")
def inash(
    *,
    out: Path = Path("reproduction-inash"),
    trials: Whole = 20,
    seed: Whole = 0,
    samples: Whole | None = None,
    batch: Whole = 20,
    jobs: Whole | None = None,
    plots: bool = True,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Zhu, Otte, Chaudhari, Frazzoli 2014: iNash-trajectory.

    Plans are kept as they are made: the same command goes on where it was stopped, and with more
    trials only those are played that are missing.

    Parameters
    ----------
    out
        Folder for the page, the numbers, the plots, and the plans that were made.
    trials
        Trials of each experiment.
    seed
        Seed of the first trial; each further trial has the next.
    samples
        Samples of each robot. Default: as calibrated for each experiment.
    batch
        Samples of each robot in an iteration of iNash and the any-time method; the paper's is 1.
    jobs
        Processes. Default: one per processor.
    plots
        Draw the plots.
    json
        Print one JSON object instead of the summary.
    quiet
        Print nothing but errors.
    """
    from conav.compiled import compiled_before
    from conav.experiments.inash.reproduce import reproduce as run

    if not quiet and not compiled_before():
        print(
            "conav: compiling the kernels; this happens once and takes about 15 s", file=sys.stderr
        )
    shown = sys.stderr.isatty() and not quiet

    def progress(done: int, total: int) -> None:
        if shown:
            print(f"\rconav: {done} of {total} plans ", end="", file=sys.stderr, flush=True)

    made = run(
        out,
        trials=trials,
        seed=seed,
        samples=samples,
        batch=batch,
        jobs=jobs if jobs is not None else os.cpu_count() or 1,
        plots=plots,
        progress=progress,
    )
    if shown:
        print(file=sys.stderr)
    code = _told(made, json=json, quiet=quiet)
    return 1 if made.failed or made.broken else code


@reproduce.command(name="pursuit")
def pursuit(
    *,
    out: Path = Path("reproduction-pursuit"),
    runs: Whole = 20,
    seed: Whole = 0,
    sizes: Whole = 3,
    jobs: Whole | None = None,
    plots: bool = True,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Pellier, Fiorino 2005: coordinated exploration and pursuit-evasion.

    Cases are kept as they end: the same command goes on where it was stopped, and with more runs or
    sizes only those are played that are missing.

    Parameters
    ----------
    out
        Folder for the page, the numbers, the pictures, and the cases that were played.
    runs
        Random floors of each study.
    seed
        Seed of the first random floor; each further one has the next.
    sizes
        How many floors of each made family, the small ones first: 1 to 3.
    jobs
        Processes. Default: one per processor.
    plots
        Draw the pictures.
    json
        Print one JSON object instead of the summary.
    quiet
        Print nothing but errors.
    """
    from conav.compiled import compiled_before
    from conav.experiments.pursuit.reproduce import reproduce as run

    if not quiet and not compiled_before():
        print(
            "conav: compiling the kernels; this happens once and takes up to a minute",
            file=sys.stderr,
        )
    shown = sys.stderr.isatty() and not quiet

    def progress(done: int, total: int) -> None:
        if shown:
            print(f"\rconav: {done} of {total} cases ", end="", file=sys.stderr, flush=True)

    made = run(
        out,
        runs=runs,
        seed=seed,
        sizes=sizes,
        jobs=jobs if jobs is not None else os.cpu_count() or 1,
        plots=plots,
        progress=progress,
    )
    if shown:
        print(file=sys.stderr)
    code = _told(made, json=json, quiet=quiet)
    return 1 if made.failed else code


def _told(made: Any, *, json: bool, quiet: bool) -> int:
    """The exit code, after what was made was told of."""
    for warning in made.warnings if not quiet else ():
        print(f"conav: warning: {warning}", file=sys.stderr)
    if json:
        print(json_module.dumps(made.summary()))
    elif not quiet:
        for verdict in made.verdicts:
            print(f"{verdict.verdict}: {verdict.claim} ({verdict.source})")
            print(f"  {verdict.numbers}")
        end = "interrupted; what was done is in" if made.interrupted else "page, numbers, plots:"
        print(f"{end} {made.folder}")
    return 1 if made.interrupted else 0
