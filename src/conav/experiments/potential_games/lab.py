"""Plays the games studies ask for: once each, on several processes, with progress."""

import signal
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from types import TracebackType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from conav.experiments.potential_games.world import (
    STEPS,
    Played,
    Simulated,
    Team,
    play,
    simulate,
)
from conav.intervals import Estimate, mean_interval, ratio_interval

T = TypeVar("T")


@dataclass
class Lab:
    """How much is played, and what was played already. Use as a context manager."""

    layouts: int = 20
    games: int = 200  # in bulk, per layout
    runs: int = 5  # by the ordinary simulator, per layout
    steps: int = STEPS
    jobs: int = 1
    progress: Callable[[str], None] = lambda text: None
    _played: dict[object, list[Any]] = field(default_factory=dict[object, list[Any]])
    _pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> "Lab":
        if self.jobs > 1:
            # Nothing of this process is inherited but what is sent, and Ctrl-C is for this one.
            self._pool = ProcessPoolExecutor(
                self.jobs, mp_context=get_context("spawn"), initializer=_ignore_interrupts
            )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=kind is None, cancel_futures=True)

    def bulk(
        self,
        team: Team,
        *,
        games: int | None = None,
        steps: int | None = None,
        traced: bool = False,
    ) -> list[Played]:
        """The team's games in bulk, an entry per layout."""
        games = games or self.games
        steps = steps or self.steps
        tasks = [(team, layout, games, steps, traced) for layout in range(self.layouts)]
        return self._once((team, games, steps, traced), team.label, play, tasks)

    def simulated(self, team: Team, runs: int | None = None) -> list[list[Simulated]]:
        """The team's games by the ordinary simulator, per layout."""
        runs = runs or self.runs
        tasks = [
            (team, layout, game, self.steps)
            for layout in range(self.layouts)
            for game in range(runs)
        ]
        found = self._once((team, runs), team.label, simulate, tasks)
        return [found[k * runs : (k + 1) * runs] for k in range(self.layouts)]

    def _once(
        self, key: object, label: str, function: Callable[..., T], tasks: Sequence[tuple[Any, ...]]
    ) -> list[T]:
        if key not in self._played:
            self.progress(label)
            if self._pool is None:
                self._played[key] = [function(*task) for task in tasks]
            else:
                futures: list[Future[T]] = [self._pool.submit(function, *task) for task in tasks]
                self._played[key] = [future.result() for future in futures]
        return self._played[key]


def _ignore_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def capped(times: NDArray[np.float64], cap: int) -> NDArray[np.float64]:
    """Times with those of unfinished games replaced by the cap; a step at least."""
    return np.clip(times, 1.0, cap)


def mean_times(played: Sequence[Played], column: int, cap: int) -> list[float]:
    """Each layout's mean time to a share, unfinished games counted at the cap."""
    return [float(capped(one.times[:, column], cap).mean()) for one in played]


def time_estimate(played: Sequence[Played], column: int, cap: int) -> Estimate:
    """The mean time over layouts, with its interval."""
    return mean_interval(mean_times(played, column, cap))


def time_ratio(one: Sequence[Played], other: Sequence[Played], column: int, cap: int) -> Estimate:
    """The geometric mean over layouts of the first team's mean time over the second's."""
    return ratio_interval(mean_times(one, column, cap), mean_times(other, column, cap))


def finished(played: Sequence[Played], column: int) -> tuple[int, int]:
    """How many games reached the share, and of how many."""
    return (
        int(sum(np.isfinite(one.times[:, column]).sum() for one in played)),
        sum(len(one.times) for one in played),
    )


def finished_share(played: Sequence[Played], column: int) -> Estimate:
    """The mean over layouts of the share of games that reached a share, cut off at 0 and 1."""
    found = mean_interval([float(np.isfinite(one.times[:, column]).mean()) for one in played])
    return Estimate(found.value, max(found.low, 0.0), min(found.high, 1.0), found.n)


def curve(values: Sequence[NDArray[np.float64]]) -> tuple[NDArray[np.float64], ...]:
    """The mean of the layouts' curves and its 95 % interval at every step: mean, low, high."""
    table = np.array(values)
    middle = table.mean(axis=0)
    if len(table) < 2:
        return middle, middle, middle
    from scipy.stats import t

    half = t.ppf(0.975, len(table) - 1) * table.std(axis=0, ddof=1) / np.sqrt(len(table))
    return middle, middle - half, middle + half
