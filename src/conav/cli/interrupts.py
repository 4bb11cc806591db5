"""Ctrl-C during a run: end it between two steps, so that its file and its numbers agree."""

import signal
import threading
from types import FrameType, TracebackType
from typing import Any


class Interrupted(BaseException):
    """Ctrl-C at a moment when there is no result to show yet, or for the second time."""


class EndAfterStep:
    """A context manager in which Ctrl-C lets the step under way end before the run does.

    An interrupt in the middle of a step would leave positions and counters that no recorded step
    explains. Before the first step, and when the user insists, it ends everything at once.
    """

    def __init__(self) -> None:
        self._stepping = False
        self._asked = False
        self._before: Any = signal.getsignal(signal.SIGINT)
        # Handlers belong to the main thread, and a run in the background of a script is not to be
        # woken from ignoring Ctrl-C.
        in_main = threading.current_thread() is threading.main_thread()
        self._ours = in_main and callable(self._before)

    def __enter__(self) -> "EndAfterStep":
        if self._ours:
            signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._ours:
            signal.signal(signal.SIGINT, self._before)

    def step(self) -> None:
        """To be called between two steps; raises `KeyboardInterrupt` when one was asked for."""
        if self.asked():
            raise KeyboardInterrupt

    def asked(self) -> bool:
        """To be called between two steps: whether an end was asked for."""
        self._stepping = True
        return self._asked

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self._asked or not self._stepping:
            raise Interrupted
        self._asked = True
