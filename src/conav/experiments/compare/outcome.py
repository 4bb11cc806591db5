"""What is kept of a run, or of one that failed."""

from dataclasses import dataclass, fields
from typing import Any, cast

import numpy as np

from conav.exploration.types import ExplorationProblem
from conav.simulation.run_exploration import ExplorationResult


@dataclass(frozen=True)
class Outcome:
    """What is kept of a run; times are simulated seconds."""

    status: str
    steps: int
    step_s: float
    time_s: float
    coverage: float
    percent_s: tuple[float | None, ...]  # (100,) when 1, 2 ... 100 percent were covered, or None
    path_m: tuple[float, ...]  # per robot
    overlap: float
    balance_seen: float
    balance_path: float
    messages: int
    bytes: int
    observable_m2: float
    warnings: tuple[str, ...]
    compute_s: float  # wall time, as are the next
    decision_ms_mean: float
    decision_ms_p99: float
    decision_ms_max: float

    @staticmethod
    def read(content: dict[str, Any]) -> "Outcome":
        """The outcome that was kept. Raises `TypeError` for what is none."""
        if set(content) != {item.name for item in fields(Outcome)}:
            raise TypeError("no outcome of a run")
        values: dict[str, Any] = {
            key: tuple(cast("list[Any]", value)) if isinstance(value, list) else value
            for key, value in content.items()
        }
        return Outcome(**values)


@dataclass(frozen=True)
class CaseBounds:
    """What is kept of bounds on the best possible time to see all; simulated seconds."""

    lower_s: float
    lower_by: str  # swath, eccentricity or witness
    known_map_s: float | None  # of a team that knows the map

    @staticmethod
    def read(content: dict[str, Any]) -> "CaseBounds":
        """The bounds that were kept. Raises `TypeError` for what is none."""
        return CaseBounds(**content)


@dataclass(frozen=True)
class Failure:
    """A run that could not be played to its end, and why."""

    message: str


def outcome_of(
    problem: ExplorationProblem, warnings: tuple[str, ...], result: ExplorationResult
) -> Outcome:
    """What is kept of a run that was played."""
    metrics = result.metrics
    covered = np.array(result.covered, dtype=np.int64)
    steps = np.searchsorted(covered * 100, np.arange(1, 101) * result.observable, side="left")
    return Outcome(
        status=str(result.status),
        steps=metrics.steps,
        step_s=problem.step_s,
        time_s=metrics.time_s,
        coverage=metrics.coverage,
        percent_s=tuple(
            round(int(step) * problem.step_s, 9) if step < len(covered) else None for step in steps
        ),
        path_m=metrics.path_m,
        overlap=metrics.overlap,
        balance_seen=metrics.balance["seen"],
        balance_path=metrics.balance["path"],
        messages=metrics.messages,
        bytes=metrics.bytes,
        observable_m2=round(result.observable * problem.plan.grid.resolution**2, 9),
        warnings=warnings,
        compute_s=result.compute_s,
        decision_ms_mean=result.decision_ms["mean"],
        decision_ms_p99=result.decision_ms["p99"],
        decision_ms_max=result.decision_ms["max"],
    )
