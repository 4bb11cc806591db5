"""Where an `.mcap` file is put together: channels, chunks, and bytes that are kept nowhere.

Every finished chunk goes to the operating system at once.
"""

from io import RawIOBase
from pathlib import Path
from typing import Any, BinaryIO, cast

from conav.errors import InputError
from conav.runs.mcap_records import MAGIC

CHUNK_BYTES = 128 * 1024


class Unbuffered:
    """A stream whose every write is handed to the operating system at once.

    The mcap package puts a buffer of its own before a raw file, which a killed process loses. When
    a write fails the file is closed and `InputError` names it; later writes do nothing, so that
    finishing the file after that does not fail a second time.
    """

    def __init__(self, file: RawIOBase, path: Path) -> None:
        self._file = file
        self._path = path
        self._at = 0
        self._failed = False

    def write(self, data: bytes | bytearray | memoryview) -> int:
        view = memoryview(data).cast("B")
        done = 0
        try:
            while done < len(view) and not self._failed:
                done += self._file.write(view[done:]) or 0
        except OSError as error:
            self._failed = True
            self._file.close()
            raise InputError(
                self._path, f"cannot be written ({error.strerror})", "choose another --out"
            ) from None
        self._at += done
        return done

    def tell(self) -> int:
        return self._at

    def flush(self) -> None:
        pass

    def close(self) -> None:
        self._file.close()


def open_for_writing(path: Path) -> Unbuffered:
    """The file as an empty stream that keeps nothing back.

    Raises `InputError` when it cannot be written, or when something that is not a run file lies at
    its path, which is left as it is.
    """
    try:
        if path.is_dir():
            raise InputError(path, "is a folder", "name a file, for example run.mcap")
        if path.exists() and path.stat().st_size > 0:
            with path.open("rb") as present:
                if present.read(len(MAGIC)) != MAGIC:
                    raise InputError(
                        path,
                        "exists and is no run file; it is left alone",
                        "choose another --out or remove it",
                    )
        return Unbuffered(path.open("wb", buffering=0), path)
    except FileNotFoundError:
        raise InputError(
            path, "lies in a folder that does not exist", "make the folder first"
        ) from None
    except OSError as error:
        raise InputError(
            path, f"cannot be written ({error.strerror})", "choose another --out"
        ) from None


class McapSink:
    """An `.mcap` file as ROS 2 knows them, with checksums over all its bytes."""

    def __init__(self, stream: Unbuffered) -> None:
        from mcap.writer import CompressionType, Writer

        self._stream = stream
        self._writer = Writer(
            cast("BinaryIO", stream),
            chunk_size=CHUNK_BYTES,
            compression=CompressionType.ZSTD,
            enable_data_crcs=True,
        )
        self._writer.start(profile="ros2", library="conav")
        self._schemas: dict[str, int] = {}
        self._closed = False

    def channel(self, topic: str, schema: str, text: bytes, metadata: dict[str, str]) -> int:
        """The number of a new channel with messages of that schema (its ROS 2 definition)."""
        if schema not in self._schemas:
            self._schemas[schema] = self._writer.register_schema(
                name=schema, encoding="ros2msg", data=text
            )
        return self._writer.register_channel(
            topic=topic,
            message_encoding="cdr",
            schema_id=self._schemas[schema],
            metadata=metadata,
        )

    def message(self, channel: int, time_ns: int, sequence: int, data: bytes | memoryview) -> None:
        """Write a message; it is in the file when its chunk is finished."""
        self._writer.add_message(
            channel_id=channel,
            log_time=time_ns,
            publish_time=time_ns,
            data=cast("bytes", data),
            sequence=sequence,
        )

    def metadata(self, name: str, content: dict[str, str]) -> None:
        """Write a metadata record."""
        self._writer.add_metadata(name, content)

    def flush(self) -> None:
        """Finish the open chunk, so that everything so far survives the end of the process."""
        # The package finishes a chunk only when it is full; this is its own routine for that.
        cast("Any", self._writer)._Writer__finalize_chunk()

    def close(self) -> None:
        """Finish the file with its index; calling it again does nothing."""
        if not self._closed:
            self._closed = True
            try:
                self._writer.finish()
            finally:
                self._stream.close()
