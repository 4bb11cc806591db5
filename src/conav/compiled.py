"""One lazy wrapper of `numba.njit` for every compiled kernel.

Rules of this file:
- Importing conav imports neither numba nor a kernel; the first call does.
- A kernel is a function of arrays and numbers. It may call other kernels and read module constants,
  but not call itself: numba loads a recursive function from its cache into a crash.
- Compiled code is cached in a folder named by a hash of the kernel's source, its callees' sources
  and the constants they read. numba alone would serve a stale caller when only the callee changed.
- Where nothing is writable the cache is off and everything still works.
"""

import contextlib
import hashlib
import inspect
import os
import sys
import tempfile
import threading
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeVar, cast

P = ParamSpec("P")
R = TypeVar("R")

_lock = threading.RLock()


class Kernel(Generic[P, R]):
    """A function that is compiled at its first call; `python` is the function as written."""

    def __init__(self, function: Callable[P, R]) -> None:
        self.python = function
        self.__doc__ = function.__doc__
        self.__name__ = function.__name__
        self.__module__ = function.__module__
        self.__qualname__ = function.__qualname__
        self._compiled: Callable[P, R] | None = None
        self._building = False

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        compiled = self._compiled
        if compiled is None:
            compiled = self.compile()
        return compiled(*args, **kwargs)

    def compile(self) -> Callable[P, R]:
        """The numba dispatcher behind this kernel; calling it directly saves the wrapper's cost."""
        with _lock:
            if self._compiled is None:
                if self._building:
                    raise TypeError(f"the kernel {self.__qualname__} calls itself through another")
                self._building = True
                try:
                    self._compiled = cast("Callable[P, R]", _build(self))
                finally:
                    self._building = False
            return self._compiled

    def __reduce__(self) -> str:
        return self.python.__qualname__


def kernel(function: Callable[P, R]) -> Kernel[P, R]:
    """The function as a lazily compiled kernel (decorator)."""
    return Kernel(function)


def _names(code: types.CodeType) -> set[str]:
    """Names the code reads, functions and comprehensions inside it included."""
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            names |= _names(constant)
    return names


def _referenced(function: Any) -> dict[str, Any]:
    """Globals the function's code reads, by name."""
    names = _names(function.__code__)
    return {name: value for name, value in function.__globals__.items() if name in names}


def _content(value: object) -> bytes:
    """What a global adds to the hash: for an array all of it, for a module of ours its source."""
    import numpy as np

    if isinstance(value, np.ndarray):
        array = cast("np.ndarray[Any, Any]", value)
        return f"{array.dtype}{array.shape}".encode() + array.tobytes()
    if isinstance(value, types.ModuleType):
        file = getattr(value, "__file__", None)
        if value.__name__.partition(".")[0] in ("numpy", "math") or file is None:
            return value.__name__.encode()
        return Path(file).read_bytes()
    return repr(value).encode()


def source_hash(target: Kernel[..., Any]) -> str:
    """A hash of the kernel's source, of every kernel it calls and of the constants they read."""
    digest = hashlib.sha256()
    seen: set[str] = set()

    def visit(function: Any) -> None:
        key = f"{function.__module__}.{function.__qualname__}"
        if key in seen:
            return
        seen.add(key)
        digest.update(key.encode())
        digest.update(inspect.getsource(function).encode())
        for name, value in sorted(_referenced(function).items()):
            if isinstance(value, Kernel):
                visit(cast("Kernel[..., Any]", value).python)
            else:
                digest.update(name.encode() + b"=" + _content(value))

    visit(target.python)
    return digest.hexdigest()[:20]


def _build(target: Kernel[..., Any]) -> Any:
    _prepare_environment()
    import numba  # pyright: ignore[reportMissingTypeStubs]
    from numba.core import config  # pyright: ignore[reportMissingTypeStubs]

    function = cast("types.FunctionType", target.python)
    namespace = dict(function.__globals__)
    for name, value in _referenced(function).items():
        if value is target:
            raise TypeError(f"the kernel {function.__qualname__} calls itself")
        if isinstance(value, Kernel):
            namespace[name] = cast("Kernel[..., Any]", value).compile()
    plain = types.FunctionType(
        function.__code__, namespace, function.__name__, function.__defaults__
    )
    plain.__qualname__ = function.__qualname__
    plain.__module__ = function.__module__
    folder = cache_folder()
    if folder is not None:
        cast("Any", config).CACHE_DIR = str(folder / source_hash(target))
    compiled = cast("Any", numba).njit(cache=folder is not None, error_model="numpy")(plain)
    return compiled


def _prepare_environment() -> None:
    # numba refuses to import where it finds no folder for its own cache; ours replaces it.
    if "numba" not in sys.modules and "NUMBA_CACHE_DIR" not in os.environ:
        folder = cache_folder()
        if folder is not None:
            os.environ["NUMBA_CACHE_DIR"] = str(folder)


_folder: Path | None = None
_folder_found = False


def cache_folder() -> Path | None:
    """Where compiled kernels are kept, or `None` where nothing is writable.

    The first writable of: the environment variable CONAV_CACHE_DIR, the user's cache folder, a
    folder of this user's in the system's temporary folder.
    """
    global _folder, _folder_found
    if not _folder_found:
        _folder = next((path for path in _candidates() if _writable(path)), None)
        _folder_found = True
    return _folder


def compiled_before() -> bool:
    """Whether kernels of some version of conav lie in the cache."""
    folder = cache_folder()
    return folder is not None and any(folder.iterdir())


def _candidates() -> list[Path]:
    folders: list[Path] = []
    if os.environ.get("CONAV_CACHE_DIR"):
        folders.append(Path(os.environ["CONAV_CACHE_DIR"]))
    if os.environ.get("XDG_CACHE_HOME"):
        folders.append(Path(os.environ["XDG_CACHE_HOME"]) / "conav")
    with contextlib.suppress(RuntimeError):  # raised where no home folder is known
        folders.append(Path.home() / ".cache" / "conav")
    user = os.getuid() if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    with contextlib.suppress(FileNotFoundError):  # raised where no temporary folder is usable
        folders.append(Path(tempfile.gettempdir()) / f"conav-cache-{user}")
    return [folder / "kernels" for folder in folders]


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        # Code is loaded from here: a folder that somebody else made, as anyone can in the
        # temporary folder, is not used.
        if hasattr(os, "getuid") and folder.stat().st_uid != os.getuid():
            return False
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
