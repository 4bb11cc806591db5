"""Plays the cases that are missing, on several processes, and keeps what was played."""

import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from conav.experiments.compare.journal import Journal
from conav.experiments.compare.outcome import Failure
from conav.experiments.compare.workers import Workers
from conav.experiments.pursuit.play import Played, play
from conav.experiments.pursuit.world import Case, case_key, code_of_cases

Progress = Callable[[int, int], None]


class Runner:
    """Plays cases in one process."""

    def run(self, case: Case) -> Played | Failure:
        """What is kept of a case, or why it could not be played."""
        try:
            return play(case)
        except Exception as error:
            at = traceback.extract_tb(error.__traceback__)[-1]
            return Failure(
                f"{type(error).__name__}: {error} ({Path(at.filename).name}, {at.lineno})"
            )


def play_all(
    cases: Sequence[Case], journal: Journal[Played], jobs: int, progress: Progress
) -> tuple[Mapping[Case, Played | Failure], bool]:
    """What is known of the cases, and whether all were played before an interrupt.

    Those that are in the journal already are not played again, but for those that failed.
    """
    code = code_of_cases()
    keys = {case: case_key(case, code) for case in cases}
    missing = [case for case in cases if not isinstance(journal.results.get(keys[case]), Played)]
    progress(len(cases) - len(missing), len(cases))
    finished = True
    try:
        with Workers(Runner, max(min(jobs, len(missing)), 1)) as workers:
            for number, (case, result) in enumerate(workers.each("run", missing), 1):
                journal.add(keys[case], result)
                progress(len(cases) - len(missing) + number, len(cases))
    except KeyboardInterrupt:
        finished = False
    kept = journal.results
    return {case: kept[keys[case]] for case in cases if keys[case] in kept}, finished
