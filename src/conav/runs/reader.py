"""Reading a run file, whole or cut short."""

import json
import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, cast

import numpy as np

from conav.errors import InputError
from conav.runs.digest import Digest
from conav.runs.schemas import (
    EVENT_TOPICS,
    HEADER_TOPIC,
    RESULT_TOPIC,
    STEP,
    STEP_TOPIC,
    STRING,
    WORLD,
    WORLD_TOPIC,
    typestore,
)
from conav.runs.types import Run, StepRecord

MAGIC = b"\x89MCAP0\r\n"


class RawMessage(NamedTuple):
    """One message as it lies in the file."""

    topic: str
    schema: str
    schema_text: bytes
    metadata: dict[str, str]
    time_ns: int
    sequence: int
    data: bytes


class _Damage(Exception):
    """The rest of the file cannot be read."""


def read_run(path: str | os.PathLike[str]) -> Run:
    """The run in a file. A file cut short is read up to its last whole chunk; `intact` tells.

    Raises `InputError` when the file does not exist, is no run file, or ends before its header.
    """
    path = Path(path)
    store = typestore()
    digest = Digest()
    header: dict[str, Any] | None = None
    result: dict[str, Any] | None = None
    world: Any = None
    steps: list[StepRecord] = []
    timing: dict[str, str] = {}
    intact = True
    try:
        for item in _messages(path):
            if isinstance(item, dict):
                timing = item
                continue
            if item.topic not in EVENT_TOPICS:
                continue
            digest.add(item.topic, item.time_ns, item.data)
            if item.topic == STEP_TOPIC:
                message = store.deserialize_cdr(item.data, STEP)
                steps.append(StepRecord(*(getattr(message, name) for name in StepRecord._fields)))
            elif item.topic == WORLD_TOPIC:
                world = store.deserialize_cdr(item.data, WORLD)
            else:
                text = store.deserialize_cdr(item.data, STRING).data
                content = cast("dict[str, Any]", json.loads(text))
                if item.topic == HEADER_TOPIC:
                    header = content
                elif item.topic == RESULT_TOPIC:
                    result = content
    except _Damage:
        intact = False
    except (AssertionError, ValueError, IndexError, struct.error, UnicodeDecodeError, KeyError):
        # A chunk that unpacked but whose messages do not decode.
        intact = False
    if header is None or world is None:
        raise InputError(
            path,
            "holds no conav run" if intact else "was cut short before the run began",
            "give a file written by conav explore --out",
        )
    if world.rows * world.cols != len(world.cells):
        raise InputError(path, "holds a map of the wrong size", "the file is damaged")
    return Run(
        path=path,
        header=header,
        cells=np.asarray(world.cells, dtype=np.uint8).reshape(world.rows, world.cols),
        resolution=float(world.resolution),
        origin=(float(world.origin[0]), float(world.origin[1]), float(world.origin[2])),
        steps=steps,
        result=result,
        timing=timing,
        digest=digest.hex(),
        intact=intact,
    )


def repair_run(path: str | os.PathLike[str], out: str | os.PathLike[str]) -> int:
    """The number of messages copied from a damaged run file into a whole one with a new index.

    Raises `InputError` as `read_run` does, and when `out` is the file itself.
    """
    from mcap.writer import CompressionType, Writer

    source, target = Path(path), Path(out)
    read_run(source)  # says what is wrong when there is nothing to repair
    if target.exists() and target.samefile(source):
        raise InputError(target, "is the damaged file itself", "name another --out")
    count = 0
    try:
        with target.open("wb") as stream:
            writer = Writer(stream, compression=CompressionType.ZSTD)
            writer.start(profile="ros2", library="conav")
            schemas: dict[str, int] = {}
            channels: dict[str, int] = {}
            try:
                for item in _messages(source):
                    if isinstance(item, dict):
                        writer.add_metadata("conav_timing", item)
                        continue
                    if item.schema not in schemas:
                        schemas[item.schema] = writer.register_schema(
                            name=item.schema, encoding="ros2msg", data=item.schema_text
                        )
                    if item.topic not in channels:
                        channels[item.topic] = writer.register_channel(
                            topic=item.topic,
                            message_encoding="cdr",
                            schema_id=schemas[item.schema],
                            metadata=item.metadata,
                        )
                    writer.add_message(
                        channel_id=channels[item.topic],
                        log_time=item.time_ns,
                        publish_time=item.time_ns,
                        data=item.data,
                        sequence=item.sequence,
                    )
                    count += 1
            except _Damage:
                pass
            writer.finish()
    except OSError as error:
        raise InputError(
            target, f"cannot be written ({error.strerror})", "choose another --out"
        ) from None
    return count


def _messages(path: Path) -> Iterator[RawMessage | dict[str, str]]:
    """All messages in the order of the file, and the timing record; `_Damage` where it breaks."""
    try:
        stream = path.open("rb")
    except OSError as error:
        raise InputError(
            path, f"cannot be read ({error.strerror})", "give a file written by conav"
        ) from None
    with stream:
        if stream.read(len(MAGIC)) != MAGIC:
            raise InputError(
                path, "is no run file", "give an .mcap file written by conav explore --out"
            )
        stream.seek(0)
        yield from _records(stream)


def _records(stream: BinaryIO) -> Iterator[RawMessage | dict[str, str]]:
    from mcap.exceptions import McapError
    from mcap.records import Channel, Message, Metadata, Schema
    from mcap.stream_reader import StreamReader

    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    try:
        for record in StreamReader(stream, validate_crcs=True).records:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Metadata) and record.name == "conav_timing":
                yield dict(record.metadata)
            elif isinstance(record, Message):
                channel = channels[record.channel_id]
                schema = schemas[channel.schema_id]
                yield RawMessage(
                    channel.topic,
                    schema.name,
                    schema.data,
                    dict(channel.metadata),
                    record.log_time,
                    record.sequence,
                    record.data,
                )
    except (
        McapError,
        ValueError,
        KeyError,
        IndexError,
        EOFError,
        struct.error,
        zlib.error,
    ) as error:
        raise _Damage from error
    except Exception as error:
        # The decompressors raise errors of their own, which cannot be named without importing them.
        if type(error).__module__.split(".")[0] in ("zstandard", "lz4", "_frame", "backports"):
            raise _Damage from error
        if isinstance(error, RuntimeError):
            raise _Damage from error
        raise
