"""What was played, a line each in a file that only grows: whoever is killed loses no run."""

import json
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any, Generic, TypeVar, cast

from conav.errors import InputError
from conav.experiments.compare.outcome import CaseBounds, Failure

R = TypeVar("R")

JOURNAL = "journal.jsonl"


class Journal(Generic[R]):
    """Results of cases, and bounds, by key. Use as a context manager; nobody else may have it open.

    Results are dataclasses, which `read` makes of their fields; it raises `TypeError` or
    `ValueError` for what is none. A line is the key and the outcome, the failure or the bounds, as
    JSON. Each is handed to the system whole, as soon as its run has ended. Of a key with several
    lines the last counts.

    Raises `InputError` where the file cannot be written or another command is writing it.
    """

    def __init__(self, path: Path, read: Callable[[dict[str, Any]], R]) -> None:
        self.path = path
        self._result = read
        self.results: dict[str, R | Failure] = {}
        self.bounds: dict[str, CaseBounds] = {}
        self.unreadable: list[int] = []
        """Lines that are no result, but for a last one that was cut short."""
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
        except OSError as error:
            raise self._cannot(error) from None
        try:
            self._lock()
            self._read(path.read_bytes())
        except BaseException:
            os.close(self._file)
            raise

    def __enter__(self) -> "Journal[R]":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        os.close(self._file)

    def add(self, key: str, result: R | Failure) -> None:
        """Keep a result."""
        kind = "failure" if isinstance(result, Failure) else "outcome"
        content = asdict(cast("Any", result))
        self._write(json.dumps({"case": json.loads(key), kind: content}) + "\n")
        self.results[key] = result

    def add_bounds(self, key: str, bounds: CaseBounds) -> None:
        """Keep bounds."""
        self._write(json.dumps({"case": json.loads(key), "bounds": asdict(bounds)}) + "\n")
        self.bounds[key] = bounds

    def _write(self, text: str) -> None:
        data = text.encode()
        try:
            while data:
                data = data[os.write(self._file, data) :]
        except OSError as error:
            raise self._cannot(error) from None

    def _read(self, content: bytes) -> None:
        whole, _, rest = content.rpartition(b"\n")
        for number, line in enumerate(whole.split(b"\n"), 1):
            if line and not self._understood(line):
                self.unreadable.append(number)
        if rest and self._understood(rest):
            self._write("\n")
        elif rest:
            os.ftruncate(self._file, len(content) - len(rest))

    def _understood(self, line: bytes) -> bool:
        """Whether the line holds a result, which is then kept."""
        try:
            entry: dict[str, Any] = json.loads(line)
            key = json.dumps(entry["case"], sort_keys=True)
            if "outcome" in entry:
                self.results[key] = self._result(entry["outcome"])
            elif "bounds" in entry:
                self.bounds[key] = CaseBounds.read(entry["bounds"])
            else:
                self.results[key] = Failure(**entry["failure"])
        except (ValueError, TypeError, KeyError, AttributeError):
            return False
        return True

    def _lock(self) -> None:
        with suppress(ImportError):  # where there is none, nobody is kept out
            import fcntl

            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise InputError(
                    self.path.parent,
                    "is being written by another conav",
                    "wait for it, or choose another --out",
                ) from None
            except OSError:
                pass  # a file system without locks

    def _cannot(self, error: OSError) -> InputError:
        return InputError(
            self.path, f"cannot be written ({error.strerror or error})", "choose another --out"
        )
