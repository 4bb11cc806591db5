"""Text of floor plan files, and JSON in it."""

import json
from pathlib import Path
from typing import Any

from conav.errors import InputError
from conav.maps.image import file_bytes

MAX_BYTES = 200_000_000


def file_text(path: Path, what: str) -> str:
    """The text of a file. Raises `InputError` for one that is not text; `what` says what it is."""
    data = file_bytes(path, limit=MAX_BYTES)
    if data.startswith(b"version https://git-lfs"):
        raise InputError(path, f"is a Git LFS pointer, not {what}", "run git lfs pull")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(path, f"is not text, so it is not {what}", "check the file") from error


def file_json(path: Path, what: str) -> dict[str, Any]:
    """The JSON object in a file. Raises `InputError` where there is none."""
    text = file_text(path, what)
    try:
        value = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        where = f" in line {error.lineno}" if isinstance(error, json.JSONDecodeError) else ""
        raise InputError(path, f"is not JSON{where}", "check that the file is whole") from error
    if not isinstance(value, dict):
        raise InputError(path, f"holds no JSON object, so it is not {what}", "check the file")
    return value
