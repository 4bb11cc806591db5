"""Reading a run file, whole or cut short."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from conav.errors import InputError
from conav.runs.digest import Digest
from conav.runs.job_events import JOBS, JobEvents
from conav.runs.mcap_records import MAGIC, Damage, Metadata, RawMessage, records
from conav.runs.mcap_sink import McapSink, open_for_writing
from conav.runs.schemas import (
    EVENT_TOPICS,
    FORMAT,
    HEADER_TOPIC,
    RESULT_TOPIC,
    TIMING,
    decode_object,
)
from conav.runs.types import ExplorationRun, PlanRun, PursuitRun, Run

_REMEDY = "give a file written by conav with --out"


def read_run(path: str | os.PathLike[str]) -> Run:
    """The run in a file, of the subclass of `Run` that the job in its header has.

    A file cut short is read up to its last whole chunk; `intact` tells. Raises `InputError` when
    the file does not exist, is no run file, or ends before its header.
    """
    path = Path(path)
    parts = _Parts()
    intact = True
    try:
        for item in _items(path):
            if isinstance(item, Metadata):
                if item.name == TIMING:
                    parts.timing = item.content
            elif item.topic in EVENT_TOPICS:
                parts.take(item)
    except Damage:
        intact = False
    header = parts.header
    if header is not None and header.get("format") != FORMAT:
        raise InputError(
            path,
            f"is of format {header.get('format')!r}; this conav reads {FORMAT}",
            "use the conav that wrote it",
        )
    if header is not None and header.get("job") not in JOBS:
        raise InputError(
            path, f"is a run of job {header.get('job')!r}", "use the conav that wrote it"
        )
    if header is None or parts.events is None or not parts.events.begun:
        problem = "holds no conav run" if intact else "was cut short before the run began"
        raise InputError(path, problem, _REMEDY)
    return parts.events.run(
        path=path,
        header=header,
        result=parts.result,
        timing=parts.timing,
        digest=parts.digest.hex(),
        intact=intact,
    )


def read_exploration(path: str | os.PathLike[str]) -> ExplorationRun:
    """The exploration in a file; as `read_run`, and `InputError` when it is of another job."""
    run = read_run(path)
    if not isinstance(run, ExplorationRun):
        raise _other_job(run, "give a file written by conav explore --out")
    return run


def read_plan(path: str | os.PathLike[str]) -> PlanRun:
    """The planner's run in a file; as `read_run`, and `InputError` when it is of another job."""
    run = read_run(path)
    if not isinstance(run, PlanRun):
        raise _other_job(run, "give a file written by conav plan --out")
    return run


def read_pursuit(path: str | os.PathLike[str]) -> PursuitRun:
    """The pursuit in a file; as `read_run`, and `InputError` when it is of another job."""
    run = read_run(path)
    if not isinstance(run, PursuitRun):
        raise _other_job(run, "give a file written by conav pursue --out")
    return run


def _other_job(run: Run, remedy: str) -> InputError:
    return InputError(run.path, f"is a run of job {run.header.get('job')!r}", remedy)


def repair_run(path: str | os.PathLike[str], out: str | os.PathLike[str]) -> int:
    """The number of messages copied from a damaged run file into a whole one with a new index.

    Raises `InputError` as `read_run` does, when `out` cannot be written and when it is the damaged
    file itself.
    """
    source, target = Path(path), Path(out)
    read_run(source)  # says what is wrong when there is nothing to repair
    if target.exists() and target.samefile(source):
        raise InputError(target, "is the damaged file itself", "name another --out")
    count = 0
    channels: dict[str, int] = {}
    sink = McapSink(open_for_writing(target))
    try:
        for item in _items(source):
            if isinstance(item, Metadata):
                sink.metadata(item.name, item.content)
                continue
            if item.topic not in channels:
                channels[item.topic] = sink.channel(
                    item.topic, item.schema, item.schema_text, item.metadata
                )
            sink.message(channels[item.topic], item.time_ns, item.sequence, item.data)
            count += 1
    except Damage:
        pass
    finally:
        sink.close()
    return count


class _Parts:
    """What was read so far of a run: its header, then its job's events, then its result."""

    def __init__(self) -> None:
        self.header: dict[str, Any] | None = None
        self.events: JobEvents | None = None
        self.result: dict[str, Any] | None = None
        self.timing: dict[str, str] = {}
        self.digest = Digest()

    def take(self, item: RawMessage) -> None:
        """Take in the next event. Raises `Damage` when it cannot be read or comes out of turn."""
        try:
            self._take(item)
        except Damage:
            raise
        except Exception as error:
            # The decoder checks what it is given with assertions and errors of several packages.
            raise Damage from error
        self.digest.add(item.topic, item.time_ns, item.data)

    def _take(self, item: RawMessage) -> None:
        if item.topic == HEADER_TOPIC and self.header is None:
            self.header = decode_object(item.data)
            kind = JOBS.get(str(self.header.get("job")))
            self.events = None if kind is None else kind()
        elif self.events is None or self.result is not None:
            raise Damage
        elif item.topic != RESULT_TOPIC:
            self.events.take(item.topic, item.data)
        elif self.events.begun:
            self.result = decode_object(item.data)
        else:
            raise Damage


def _items(path: Path) -> Iterator[RawMessage | Metadata]:
    """All messages and metadata of a file; `Damage` where it breaks off."""
    try:
        with path.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise InputError(path, "is no run file", _REMEDY)
            yield from records(stream)
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", _REMEDY) from None
