"""Writing a picture's file whole or not at all."""

import os
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from conav.errors import InputError

MIN_PIXELS = 160
"""Below this a footer leaves no room for the map."""


def checked_path(path: str | os.PathLike[str], suffix: str, kind: str) -> Path:
    """The path as given, once it is known that such a file can be made there.

    Raises `InputError` for another suffix, a folder that does not exist and a path that is one.
    """
    target = Path(path)
    if target.suffix.lower() != suffix:
        raise InputError(
            target,
            f"{target.suffix or 'no suffix'} is not a format for {kind}",
            f"end the name in {suffix}",
        )
    if target.is_dir():
        raise InputError(target, "is a folder", "name a file")
    if not target.parent.is_dir():
        raise InputError(target, f"there is no folder {target.parent}", "make it first")
    return target


def checked_pixels(max_pixels: int) -> int:
    """The size limit. Raises `InputError` when no picture could be read at that size."""
    if max_pixels < MIN_PIXELS:
        raise InputError(
            f"max_pixels {max_pixels}", "leaves no room for a picture", f"give {MIN_PIXELS} or more"
        )
    return max_pixels


@contextmanager
def whole_file(target: Path) -> Generator[BinaryIO, None, None]:
    """A stream to a temporary file that takes the target's place when nothing went wrong.

    Raises `InputError` when that is not possible; what was at the target then stays.
    """
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        try:
            with part.open("wb") as stream:
                yield stream
            os.replace(part, target)
        finally:
            with suppress(OSError):
                part.unlink()
    except OSError as error:
        raise InputError(
            target, f"cannot be written ({error.strerror or error})", "choose another place"
        ) from None
