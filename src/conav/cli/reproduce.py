"""`conav reproduce`."""

import json as json_module
import os
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from conav.cli.numbers import Whole
from conav.errors import InputError

PAPERS = ("potential-games",)


def reproduce(
    paper: str,
    /,
    *,
    out: Path | None = None,
    layouts: Whole = 20,
    games: Whole = 200,
    runs: Whole = 5,
    steps: Whole = 8000,
    jobs: Whole | None = None,
    only: Annotated[list[str] | None, Parameter(negative="")] = None,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Play a paper's experiments again and say which of its claims hold.

    Parameters
    ----------
    paper
        potential-games (Philip, Givigi, Schwartz 2014).
    out
        Folder for the page, the numbers and the plots. Default: reproduction-PAPER.
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
    if paper not in PAPERS:
        raise InputError(
            f"paper {paper!r}", "has no reproduction here", "use: " + ", ".join(PAPERS)
        )
    from conav.experiments.potential_games.reproduce import reproduce as run

    shown = sys.stderr.isatty() and not quiet

    def progress(text: str) -> None:
        if shown:
            print(f"conav: {text}", file=sys.stderr)

    made = run(
        out if out is not None else Path(f"reproduction-{paper}"),
        layouts=layouts,
        games=games,
        runs=runs,
        steps=steps,
        jobs=jobs if jobs is not None else os.cpu_count() or 1,
        only=only or (),
        progress=progress,
    )
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
