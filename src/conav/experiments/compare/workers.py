"""Processes that play cases. One that dies costs the case it was at, not all the others."""

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import connection, get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pickle import PicklingError
from types import TracebackType
from typing import Any, TypeVar

from conav.errors import InputError
from conav.experiments.compare.outcome import Failure

Task = TypeVar("Task")

READY = "ready"


@dataclass(eq=False)
class _Worker:
    process: BaseProcess
    pipe: "Connection[Any, Any]"
    ready: bool = False


class Workers:
    """So many processes with a runner each, or, for one, this process. A context manager.

    `make` is called once in each process and gives the runner, whose methods take a case.

    The pool of the standard library gives up altogether when one of its processes dies, for want of
    memory for example.
    """

    def __init__(self, make: Callable[[], Any], jobs: int) -> None:
        self._make = make
        self._jobs = jobs
        self._here = make() if jobs == 1 else None
        self._workers: list[_Worker] = []

    def __enter__(self) -> "Workers":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for worker in self._workers:
            if kind is not None:
                worker.process.kill()  # whatever it is at is not wanted any more
            worker.pipe.close()  # which ends one that waits
        for worker in self._workers:
            worker.process.join()

    def each(self, method: str, cases: Sequence[Task]) -> Iterator[tuple[Task, Any]]:
        """Each case with what that method of a runner says of it, as they come.

        At an interrupt from the keyboard those that are there are still handed out.
        """
        if self._here is not None:
            for case in cases:
                yield case, getattr(self._here, method)(case)
            return
        waiting = deque(cases)
        while len(self._workers) < min(self._jobs, len(waiting)):
            self._workers.append(self._started())
        idle = list(self._workers)
        busy: dict[Any, tuple[_Worker, Task]] = {}
        interrupted = False
        while waiting or busy:
            while waiting and idle and not interrupted:
                worker, case = idle.pop(), waiting.popleft()
                busy[worker.pipe] = worker, case
                _send(worker, (method, case))
            try:
                ready = connection.wait(list(busy), 0 if interrupted else None)
            except KeyboardInterrupt:
                interrupted = True
                continue
            for pipe in ready:
                worker, case = busy[pipe]
                try:
                    answer = worker.pipe.recv()
                except (EOFError, OSError):
                    answer = Failure(self._death_of(worker))
                    self._workers.remove(worker)
                    worker = self._started()
                    self._workers.append(worker)
                if answer == READY:
                    worker.ready = True
                    continue
                del busy[pipe]
                idle.append(worker)
                yield case, answer
            if interrupted and not ready:
                break
        if interrupted:
            raise KeyboardInterrupt

    def _started(self) -> _Worker:
        context = get_context("spawn")  # nothing of this process is inherited but what is sent
        pipe, other = context.Pipe()
        process = context.Process(target=_work, args=(self._make, other), daemon=True)
        # Ctrl-C is for this process; a new one ignores what its parent ignores from the start.
        in_main = threading.current_thread() is threading.main_thread()
        before = signal.getsignal(signal.SIGINT)
        if in_main and before is not None:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            process.start()
        except (PicklingError, AttributeError, TypeError, ValueError) as error:
            raise InputError(
                "strategies",
                f"cannot be sent to another process ({error})",
                "define their classes in a module, or use one process (jobs=1)",
            ) from None
        finally:
            if in_main and before is not None:
                signal.signal(signal.SIGINT, before)
        other.close()
        return _Worker(process, pipe)

    def _death_of(self, worker: _Worker) -> str:
        """How a process ended. Raises `InputError` when it never began: no other would."""
        worker.process.join()
        worker.pipe.close()
        code = worker.process.exitcode or 0
        how = f"signal {-code}" if code < 0 else f"exit code {code}"
        if not worker.ready:
            raise InputError(
                "a process of the comparison",
                f"ended before it began ({how})",
                "use one process (jobs=1)",
            )
        return f"the process that played it ended ({how})"


def _send(worker: _Worker, task: tuple[str, Any]) -> None:
    with suppress(OSError):  # it died; reading from it will tell
        worker.pipe.send(task)


def _work(make: Callable[[], Any], pipe: "Connection[Any, Any]") -> None:
    """The life of a process: answer until there is nobody to answer to."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    runner = make()
    pipe.send(READY)
    while True:
        try:
            method, case = pipe.recv()
        except EOFError:
            return
        pipe.send(getattr(runner, method)(case))


def _end_with_parent() -> None:
    """A comparison that is killed leaves no process behind that works for nobody."""
    parent = parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)
