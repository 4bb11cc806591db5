"""A progress bar for long explorations."""

import sys
from time import monotonic
from types import TracebackType
from typing import Any

PATIENCE_S = 0.7  # [s] a run may take before a bar appears
EVERY_S = 0.1  # [s] between two updates


class ExplorationProgress:
    """A bar on standard error, only on a terminal and only when the run takes a while."""

    def __init__(self, *, shown: bool) -> None:
        self._shown = shown and sys.stderr.isatty()
        self._bar: Any = None
        self._next = monotonic() + PATIENCE_S

    def __enter__(self) -> "ExplorationProgress":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def step(self, state: Any) -> None:
        """Show how far the run is."""
        if not self._shown or state.step % 16:
            return
        now = monotonic()
        if now < self._next:
            return
        self._next = now + EVERY_S
        if self._bar is None:
            self._bar, self._task = _new_bar()
            self._bar.start()
        self._bar.update(
            self._task,
            completed=int(state.covered[0]),
            total=max(state.n_observable, 1),
            clock=f"{state.time_s:.0f} s simulated",
        )


def _new_bar() -> tuple[Any, Any]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    bar = Progress(
        TextColumn("exploring"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[clock]}"),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    return bar, bar.add_task("exploring", total=1, clock="")
