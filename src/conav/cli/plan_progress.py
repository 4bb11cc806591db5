"""How far a planner is, on a terminal."""

import sys
from math import isfinite
from time import monotonic
from types import TracebackType
from typing import Any

from conav.cli.progress import EVERY_S, PATIENCE_S


class PlanProgress:
    """A line on standard error, only on a terminal and only when the planning takes a while.

    It says how many vertices were tried, how many robots have a path, and what all paths cost.
    """

    def __init__(self, problem: Any, *, shown: bool) -> None:
        self._shown = shown and sys.stderr.isatty()
        self._robots = len(problem.robots)
        self._unit = "m" if problem.costs[0] == "length" else "s"
        self._status: Any = None
        self._next = monotonic() + PATIENCE_S

    def __enter__(self) -> "PlanProgress":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._status is not None:
            self._status.stop()

    def step(self, state: Any) -> None:
        """Show how far it is."""
        if not self._shown:
            return
        now = monotonic()
        if now < self._next:
            return
        self._next = now + EVERY_S
        if self._status is None:
            from rich.console import Console

            self._status = Console(stderr=True).status("")
            self._status.start()
        self._status.update(self.words(state))

    def words(self, state: Any) -> str:
        """What the line says."""
        costs = [cost for cost in state.costs[:, 0].tolist() if isfinite(cost)]
        text = (
            f"{state.stage}: {state.samples * self._robots:,} samples, "
            f"{len(costs)} of {self._robots} robots have a path"
        )
        return f"{text}, {sum(costs):.5g} {self._unit} in all" if costs else text
