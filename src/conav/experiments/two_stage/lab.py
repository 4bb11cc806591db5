"""Plays the cases that are missing, on several processes, and keeps what was played."""

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from conav.experiments.compare.journal import Journal
from conav.experiments.compare.outcome import Failure
from conav.experiments.compare.workers import Workers
from conav.experiments.two_stage.paths import Path as Track
from conav.experiments.two_stage.play import Played, play, watch
from conav.experiments.two_stage.world import Case, World, case_key

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Trace:
    """What figures need of a run."""

    case: Case
    side_m: float  # of the picture: the square with its wall
    paths: tuple[Track, ...]
    board: tuple[int, int, tuple[tuple[int, int], ...]] | None
    """When all are in stage 2: the step, the axis, and the sections nobody has scanned."""
    time_s: float


@dataclass(frozen=True)
class Runner:
    """Plays cases in one process."""

    world: World

    def run(self, case: Case) -> Played | Failure:
        """What is kept of a case, or why it could not be played."""
        try:
            return play(case, self.world)
        except Exception as error:
            at = traceback.extract_tb(error.__traceback__)[-1]
            return Failure(
                f"{type(error).__name__}: {error} ({Path(at.filename).name}, {at.lineno})"
            )

    def trace(self, case: Case) -> Trace:
        """The paths of a case."""
        problem, result, track, _ = watch(case, self.world)
        lattice = problem.plan.lattice
        return Trace(
            case,
            lattice.cols * lattice.cell_m,
            tuple(track.paths(problem)),
            track.board,
            result.metrics.time_s,
        )


@dataclass
class Lab:
    """The runs of a reproduction by case; those that are there already are not played again."""

    world: World
    journal: Journal[Played]
    jobs: int
    progress: Progress

    def results(self, cases: Sequence[Case]) -> dict[Case, Played | Failure]:
        """What is known of these cases."""
        keys = {case: case_key(case.played, self.world) for case in cases}
        kept = self.journal.results
        return {case: kept[key] for case, key in keys.items() if key in kept}

    def play(self, cases: Sequence[Case]) -> bool:
        """Whether all could be played, before an interrupt from the keyboard."""
        keys = {case.played: case_key(case.played, self.world) for case in cases}
        kept = self.journal.results
        missing = [case for case, key in keys.items() if not isinstance(kept.get(key), Played)]
        self.progress(len(keys) - len(missing), len(keys))
        try:
            with self._workers(len(missing)) as workers:
                for number, (case, result) in enumerate(workers.each("run", missing), 1):
                    self.journal.add(keys[case], result)
                    self.progress(len(keys) - len(missing) + number, len(keys))
        except KeyboardInterrupt:
            return False
        return True

    def traces(self, cases: Sequence[Case]) -> Mapping[Case, Trace]:
        """The paths of some cases, which are played for it."""
        with self._workers(len(cases)) as workers:
            return dict(workers.each("trace", cases))

    def _workers(self, count: int) -> Workers:
        return Workers(partial(Runner, self.world), max(min(self.jobs, count), 1))
