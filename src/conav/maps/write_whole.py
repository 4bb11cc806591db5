"""Writing map files whole or not at all."""

import os
import secrets
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from conav.errors import InputError


def write_whole(contents: Mapping[Path, bytes]) -> None:
    """Writes each file beside its target and renames them once all are complete.

    Raises `InputError` where that is not possible; older files then stay as they were.
    """
    token = secrets.token_hex(4)
    waiting = {path.with_name(f".{token}{path.suffix}.tmp"): path for path in contents}
    target = next(iter(contents))
    try:
        for temporary, target in waiting.items():
            with temporary.open("xb") as file:
                file.write(contents[target])
                file.flush()
                os.fsync(file.fileno())
        for temporary, target in waiting.items():
            os.replace(temporary, target)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            target, f"cannot be written ({reason})", "check that its folder exists and is writable"
        ) from error
    finally:
        for temporary in waiting:
            with suppress(OSError):
                temporary.unlink()
