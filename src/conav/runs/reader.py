"""Reading a run file, whole or cut short."""

import json
import os
from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Any, cast

import numpy as np

from conav.errors import InputError
from conav.runs.digest import Digest
from conav.runs.mcap_records import MAGIC, Damage, Metadata, RawMessage, records
from conav.runs.mcap_sink import McapSink, open_for_writing
from conav.runs.schemas import (
    EVENT_TOPICS,
    FORMAT,
    HEADER_TOPIC,
    RESULT_TOPIC,
    STEP,
    STEP_TOPIC,
    STRING,
    TIMING,
    WORLD,
    WORLD_TOPIC,
    typestore,
)
from conav.runs.types import Run, StepRecord

_REMEDY = "give a file written by conav explore --out"


def read_run(path: str | os.PathLike[str]) -> Run:
    """The run in a file. A file cut short is read up to its last whole chunk; `intact` tells.

    Raises `InputError` when the file does not exist, is no run file, or ends before its header.
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
    world = parts.world
    if parts.header is None or world is None:
        problem = "holds no conav run" if intact else "was cut short before the run began"
        raise InputError(path, problem, _REMEDY)
    if parts.header.get("format") != FORMAT:
        raise InputError(
            path,
            f"is of format {parts.header.get('format')!r}; this conav reads {FORMAT}",
            "use the conav that wrote it",
        )
    numbers = (world.resolution, *world.origin)
    cells = np.asarray(world.cells, dtype=np.uint8)
    if (
        world.rows * world.cols != len(cells)
        or len(cells) == 0
        or int(cells.max()) > 2
        or not all(isfinite(number) for number in numbers)
        or world.resolution <= 0
    ):
        raise InputError(path, "holds a map that is none", "the file is damaged")
    return Run(
        path=path,
        header=parts.header,
        cells=cells.reshape(world.rows, world.cols),
        resolution=float(world.resolution),
        origin=(float(world.origin[0]), float(world.origin[1]), float(world.origin[2])),
        steps=parts.steps,
        result=parts.result,
        timing=parts.timing,
        digest=parts.digest.hex(),
        intact=intact,
    )


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
    """What was read so far of a run: its header, then its map, its steps and its result."""

    def __init__(self) -> None:
        self.header: dict[str, Any] | None = None
        self.world: Any = None
        self.steps: list[StepRecord] = []
        self.result: dict[str, Any] | None = None
        self.timing: dict[str, str] = {}
        self.digest = Digest()
        self._store = typestore()

    def take(self, item: RawMessage) -> None:
        """Take in the next event. Raises `Damage` when it cannot be read or comes out of turn."""
        turn = {
            HEADER_TOPIC: self.header is None,
            WORLD_TOPIC: self.header is not None and self.world is None,
            STEP_TOPIC: self.world is not None and self.result is None,
            RESULT_TOPIC: self.world is not None and self.result is None,
        }
        if not turn[item.topic]:
            raise Damage
        try:
            self._decode(item)
        except Exception as error:
            # The decoder checks what it is given with assertions and errors of several packages.
            raise Damage from error
        self.digest.add(item.topic, item.time_ns, item.data)

    def _decode(self, item: RawMessage) -> None:
        decode = self._store.deserialize_cdr
        if item.topic == STEP_TOPIC:
            message = decode(item.data, STEP)
            self.steps.append(StepRecord(*(getattr(message, name) for name in StepRecord._fields)))
        elif item.topic == WORLD_TOPIC:
            self.world = decode(item.data, WORLD)
        else:
            content = json.loads(decode(item.data, STRING).data)
            if not isinstance(content, dict):
                raise ValueError("not an object")
            if item.topic == HEADER_TOPIC:
                self.header = cast("dict[str, Any]", content)
            else:
                self.result = cast("dict[str, Any]", content)


def _items(path: Path) -> Iterator[RawMessage | Metadata]:
    """All messages and metadata of a file; `Damage` where it breaks off."""
    try:
        with path.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise InputError(path, "is no run file", _REMEDY)
            yield from records(stream)
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", _REMEDY) from None
