"""The records of an `.mcap` file one by one, with every length checked against what is there.

A damaged file may claim any length. Nothing is read or allocated on such a claim before it was
compared with what the file holds, so a damaged file costs neither time nor memory and ends in
`Damage` and nothing else. The layout is that of https://mcap.dev/spec.
"""

import struct
import zlib
from collections.abc import Iterator
from os import SEEK_CUR, SEEK_END
from typing import BinaryIO, NamedTuple

MAGIC = b"\x89MCAP0\r\n"
MAX_BYTES = 1 << 30  # of one record and of one unpacked chunk

_FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 0x02, 0x03, 0x04, 0x05, 0x06
_METADATA, _DATA_END = 0x0C, 0x0F
_HEAD = struct.Struct("<BQ")  # a record's kind and length
_FOOTER_BYTES = _HEAD.size + 20  # two places and a checksum


class Damage(Exception):
    """The rest of the file cannot be read."""


class Metadata(NamedTuple):
    """A metadata record: texts by name."""

    name: str
    content: dict[str, str]


class RawMessage(NamedTuple):
    """One message as it lies in the file."""

    topic: str
    schema: str
    schema_text: bytes
    metadata: dict[str, str]  # of its channel
    time_ns: int
    sequence: int
    data: bytes


class _Schema(NamedTuple):
    name: str
    text: bytes


class _Channel(NamedTuple):
    schema: int
    topic: str
    metadata: dict[str, str]


def records(stream: BinaryIO) -> Iterator[RawMessage | Metadata]:
    """All messages and metadata in the order of the file.

    Raises `Damage` at the first byte that is missing or, as far as checksums tell, wrong; what came
    before it was whole.
    """
    size = stream.seek(0, SEEK_END)
    stream.seek(0)
    tables = _Tables()
    magic = _take(stream, len(MAGIC), size)
    if magic != MAGIC:
        raise Damage
    checksum = zlib.crc32(magic)
    while True:
        head = _take(stream, _HEAD.size, size)
        kind, length = _HEAD.unpack(head)
        body = _take(stream, length, size)
        if kind == _DATA_END:
            _check_end(body, checksum, stream.read())
            return
        try:
            yield from tables.content(kind, body)
        except (struct.error, UnicodeDecodeError, KeyError) as error:
            raise Damage from error
        checksum = zlib.crc32(body, zlib.crc32(head, checksum))


def _take(stream: BinaryIO, count: int, size: int) -> bytes:
    if count > min(size - stream.seek(0, SEEK_CUR), MAX_BYTES):
        raise Damage
    taken = stream.read(count)
    if len(taken) != count:
        raise Damage  # the file became shorter meanwhile
    return taken


def _check_end(body: bytes, checksum: int, rest: bytes) -> None:
    """Raise `Damage` unless the index after the messages is whole; a checksum of 0 is none."""
    if len(body) != 4 or len(rest) < _FOOTER_BYTES + len(MAGIC) or not rest.endswith(MAGIC):
        raise Damage
    (said,) = struct.unpack("<I", body)
    footer = rest[-_FOOTER_BYTES - len(MAGIC) : -len(MAGIC)]
    (summary_said,) = struct.unpack("<I", footer[-4:])
    if (
        said not in (0, checksum)
        or _HEAD.unpack(footer[: _HEAD.size]) != (_FOOTER, 20)
        or summary_said not in (0, zlib.crc32(rest[: -len(MAGIC) - 4]))
    ):
        raise Damage


class _Tables:
    """Schemas and channels met so far, and the records they explain."""

    def __init__(self) -> None:
        self.schemas: dict[int, _Schema] = {0: _Schema("", b"")}
        self.channels: dict[int, _Channel] = {}

    def content(self, kind: int, body: bytes) -> Iterator[RawMessage | Metadata]:
        """What a record says; nothing for kinds that matter only to indexed reading."""
        if kind == _CHUNK:
            inside = _unpack(body)
            at = 0
            while at < len(inside):
                kind, length = _HEAD.unpack_from(inside, at)
                at += _HEAD.size
                if kind == _CHUNK or length > len(inside) - at:
                    raise Damage
                yield from self.content(kind, inside[at : at + length])
                at += length
        elif kind == _MESSAGE:
            number, sequence, time_ns, _ = struct.unpack_from("<HIQQ", body)
            channel = self.channels[number]
            schema = self.schemas[channel.schema]
            yield RawMessage(
                channel.topic,
                schema.name,
                schema.text,
                channel.metadata,
                time_ns,
                sequence,
                body[22:],
            )
        elif kind == _SCHEMA:
            (number,) = struct.unpack_from("<H", body)
            name, at = _text(body, 2)
            _, at = _text(body, at)  # the encoding
            self.schemas[number] = _Schema(name, _sized(body, at))
        elif kind == _CHANNEL:
            number, schema = struct.unpack_from("<HH", body)
            topic, at = _text(body, 4)
            _, at = _text(body, at)  # the encoding of its messages
            self.channels[number] = _Channel(schema, topic, _texts(_sized(body, at)))
        elif kind == _METADATA:
            name, at = _text(body, 0)
            yield Metadata(name, _texts(_sized(body, at)))


def _sized(body: bytes, at: int) -> bytes:
    """The bytes at a place where their number stands before them."""
    (count,) = struct.unpack_from("<I", body, at)
    if count > len(body) - at - 4:
        raise Damage
    return body[at + 4 : at + 4 + count]


def _text(body: bytes, at: int) -> tuple[str, int]:
    """The text at a place, and the place after it."""
    raw = _sized(body, at)
    return raw.decode(), at + 4 + len(raw)


def _texts(body: bytes) -> dict[str, str]:
    result: dict[str, str] = {}
    at = 0
    while at < len(body):
        key, at = _text(body, at)
        result[key], at = _text(body, at)
    return result


def _unpack(body: bytes) -> bytes:
    """The records inside a chunk."""
    _, _, size, checksum = struct.unpack_from("<QQQI", body)
    method, at = _text(body, 28)
    (length,) = struct.unpack_from("<Q", body, at)
    packed = body[at + 8 :]
    if length != len(packed) or size > MAX_BYTES:
        raise Damage
    inside = _decompress(method, packed, size)
    if len(inside) != size or (checksum and zlib.crc32(inside) != checksum):
        raise Damage
    return inside


def _decompress(method: str, packed: bytes, size: int) -> bytes:
    """The packed bytes unpacked; never more than `size` of them."""
    if method == "":
        return packed
    try:
        if method == "zstd":
            import zstandard

            # Where the packed bytes say how much they hold, that much is allocated at once.
            if zstandard.frame_content_size(packed) not in (-1, size):
                raise Damage
            return zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
        if method == "lz4":
            from lz4.frame import LZ4FrameDecompressor

            return LZ4FrameDecompressor().decompress(packed, max_length=size)
    except Damage:
        raise
    except Exception as error:
        # Both packages raise errors of their own, on any of which there is one thing to do.
        raise Damage from error
    raise Damage
