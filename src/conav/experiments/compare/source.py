"""Which code a run follows from: results of other code must not pass for its own."""

import hashlib
import re
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path

_IMPORTS = re.compile(rb"^\s*(?:from|import)\s+(conav\.[\w.]+)", re.MULTILINE)


def source_hash(*modules: str) -> str:
    """A hash of the sources of these modules and of all they import from conav, and so on.

    A version number would do for a conav that was released, but not while somebody works on it.
    Modules without a file, as at a prompt, count by name only.
    """
    waiting, seen = list(modules), dict.fromkeys(modules)
    digest = hashlib.sha256()
    while waiting:
        source = _source(waiting.pop())
        for name in sorted({found.decode() for found in _IMPORTS.findall(source)}):
            if name not in seen:
                seen[name] = None
                waiting.append(name)
    for name in sorted(seen):
        digest.update(name.encode() + b"\0" + _source(name) + b"\0")
    return digest.hexdigest()[:16]


@cache
def _source(name: str) -> bytes:
    file = getattr(sys.modules.get(name), "__file__", None)
    if file is None:
        try:
            spec = find_spec(name)
        except (ImportError, ValueError):
            return b""
        file = spec.origin if spec is not None and spec.has_location else None
    try:
        return Path(file).read_bytes() if file else b""
    except OSError:
        return b""
