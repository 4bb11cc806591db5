"""What is reported of an exploration."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

SHARES = (90, 95, 99, 100)  # [%]


@dataclass(frozen=True)
class ExplorationMetrics:
    """The measures of one run; times are simulated seconds, lengths metres.

    Coverage counts free fine cells that the team can observe (`conav.simulation.observable`).
    """

    steps: int
    time_s: float
    coverage: float  # share of the observable cells seen by somebody, 0 to 1
    t90_s: float | None  # when coverage first reached 90 percent, None if it never did
    t95_s: float | None
    t99_s: float | None
    t100_s: float | None
    path_m: tuple[float, ...]  # per robot
    overlap: float  # sum over robots of what each saw, over what the team saw, minus 1
    balance: dict[str, float]
    """Spread over the robots: standard deviation of each one's share of the newly seen area
    ("seen") and of the team's path ("path"); 0 is even."""
    messages: int
    bytes: int


def exploration_metrics(
    *,
    covered: Sequence[int],
    observable: int,
    step_s: float,
    travelled_m: NDArray[np.float64],
    sensed: NDArray[np.int64],
    discovered: NDArray[np.int64],
    messages: int,
    bytes_sent: int,
) -> ExplorationMetrics:
    """The metrics of a run from its counters.

    `covered[k]` is the number of observable cells the team has seen after the looks of step k,
    `sensed` what each robot saw itself, `discovered` what was new to each when it saw it.
    """
    final = covered[-1] if covered else 0
    return ExplorationMetrics(
        steps=max(len(covered) - 1, 0),
        time_s=_time(max(len(covered) - 1, 0), step_s),
        coverage=final / observable if observable else 1.0,
        **{f"t{share}_s": _time_to(covered, observable, share, step_s) for share in SHARES},
        path_m=tuple(round(float(length), 9) for length in travelled_m),
        overlap=float(sensed.sum()) / final - 1.0 if final else 0.0,
        balance={"seen": _spread(discovered), "path": _spread(travelled_m)},
        messages=messages,
        bytes=bytes_sent,
    )


def _time_to(covered: Sequence[int], observable: int, share: int, step_s: float) -> float | None:
    for step, count in enumerate(covered):
        if count * 100 >= share * observable:
            return _time(step, step_s)
    return None


def _time(step: int, step_s: float) -> float:
    """The time of a step [s], without the last digits' rounding error."""
    return round(step * step_s, 9)


def _spread(values: NDArray[np.int64] | NDArray[np.float64]) -> float:
    total = float(values.sum())
    if total == 0:
        return 0.0
    shares = [float(value) / total for value in values]
    mean = sum(shares) / len(shares)
    return sqrt(sum((share - mean) ** 2 for share in shares) / len(shares))
