"""How much a solver may do, and whom it tells how far it is."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.planning.types import Trajectory

_GROWING = 0.85
"""Of a budget of time, the share in which graphs grow: the rest is for the last answers."""


@dataclass(frozen=True, eq=False)
class Progress:
    """How far a solver is, after an iteration."""

    stage: str  # "sampling", "feasibility", "game" or "last answers"
    iteration: int
    samples: int  # drawn by each robot
    costs: NDArray[np.float64]  # (robots, components), infinite without a path: a copy
    history: Sequence[Mapping[str, object]] = ()  # improvements so far; grows on
    trajectories: Callable[[], tuple[Trajectory | None, ...]] = tuple
    """The plan as it is now."""


OnProgress = Callable[[Progress], bool | None]
"""Called after each iteration; False stops the solver, and what it found stands."""


@dataclass(eq=False)
class Budget:
    """Counts down. Samples and iterations give the same result everywhere, time does not."""

    samples: int | None  # for each robot
    iterations: int | None
    time_s: float | None
    on_progress: OnProgress | None = None
    drawn: int = 0
    iteration: int = 0
    stopped: bool = False
    started: float = field(default_factory=lambda: time.monotonic())

    def __post_init__(self) -> None:
        if self.samples is None and self.iterations is None and self.time_s is None:
            raise InputError("budget", "has no end", "give samples, iterations or time_s")

    @property
    def out_of_time(self) -> bool:
        """Whether everything must stop."""
        return self.stopped or (
            self.time_s is not None and time.monotonic() - self.started >= self.time_s
        )

    @property
    def left_s(self) -> float:
        """Seconds of wall time until everything must stop; infinite without a budget of time."""
        if self.time_s is None:
            return math.inf
        return self.time_s - (time.monotonic() - self.started)

    @property
    def growing(self) -> bool:
        """Whether another iteration may begin."""
        if self.out_of_time or (self.samples is not None and self.drawn >= self.samples):
            return False
        if self.iterations is not None and self.iteration >= self.iterations:
            return False
        return self.time_s is None or (time.monotonic() - self.started < _GROWING * self.time_s)

    def next_batch(self, batch: int) -> int:
        """The number of samples each robot draws in the iteration that begins now."""
        more = batch if self.samples is None else min(batch, self.samples - self.drawn)
        self.drawn += more
        self.iteration += 1
        return more

    def tell(
        self,
        stage: str,
        costs: NDArray[np.float64],
        history: Sequence[Mapping[str, object]],
        trajectories: Callable[[], tuple[Trajectory | None, ...]],
    ) -> None:
        """Tells how far it is, and hears whether to go on."""
        if self.on_progress is not None:
            progress = Progress(
                stage, self.iteration, self.drawn, costs.copy(), history, trajectories
            )
            if self.on_progress(progress) is False:
                self.stopped = True
