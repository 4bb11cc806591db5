"""The wrapper of the compiled kernels: lazy, cached by content, and working where nothing is."""

import importlib
import json
import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from conav.compiled import Kernel, kernel, source_hash
from conav.geometry.clearance import point_segment_square

HEAD = "from conav.compiled import kernel\n"
BASE = {
    "conav_test_low": HEAD
    + "import numpy as np\nSCALE = 3\nOTHER = 5\nTABLE = ((1, 2), (3, 4))\n"
    + "@kernel\ndef inner(x):\n    return x * SCALE + TABLE[0][1]\n",
    "conav_test_high": HEAD
    + "from conav_test_low import inner\n"
    + "@kernel\ndef middle(x):\n    return inner(x) + 1\n\n"
    + "@kernel\ndef outer(x):\n    return middle(x) + 1\n\n"
    + "@kernel\ndef alone(x):\n    return x\n",
}


@pytest.fixture
def fresh_modules() -> Iterator[None]:
    yield
    for name in BASE:
        sys.modules.pop(name, None)


def write(folder: Path, edits: dict[str, tuple[str, str]] | None = None) -> Path:
    """The two modules in a folder, with a piece of text replaced in some."""
    folder.mkdir(exist_ok=True)
    for name, source in BASE.items():
        old, new = (edits or {}).get(name, ("", ""))
        assert old in source
        (folder / f"{name}.py").write_text(source.replace(old, new) if old else source)
    return folder


def load(folder: Path) -> ModuleType:
    for name in BASE:
        sys.modules.pop(name, None)
    sys.path.insert(0, str(folder))
    try:
        importlib.invalidate_caches()
        return importlib.import_module("conav_test_high")
    finally:
        sys.path.remove(str(folder))


def hashes(folder: Path) -> dict[str, str]:
    module = load(folder)
    return {name: source_hash(getattr(module, name)) for name in ("inner", "outer", "alone")}


@pytest.mark.usefixtures("fresh_modules")
@pytest.mark.parametrize(
    ("name", "old", "new", "changed"),
    [
        ("conav_test_high", "middle(x) + 1", "middle(x) + 2", {"outer"}),
        ("conav_test_high", "inner(x) + 1", "inner(x) + 2", {"outer"}),  # a callee
        ("conav_test_low", "return x * SCALE", "return x + SCALE", {"inner", "outer"}),
        ("conav_test_low", "SCALE = 3", "SCALE = 4", {"inner", "outer"}),  # in another file
        ("conav_test_low", "((1, 2), (3, 4))", "((1, 7), (3, 4))", {"inner", "outer"}),
        ("conav_test_low", "OTHER = 5", "OTHER = 6", set()),  # nobody reads it
        ("conav_test_high", "return x\n", "return x + 0\n", {"alone"}),
        ("conav_test_high", "def alone", "\n\ndef alone", {"alone"}),
        ("conav_test_high", "", "", set()),
    ],
)
def test_the_hash_follows_what_a_kernel_is_made_of(
    name: str, old: str, new: str, changed: set[str], tmp_path: Path
) -> None:
    before = hashes(write(tmp_path / "a"))
    after = hashes(write(tmp_path / "b", {name: (old, new)}))
    assert {kernel_name for kernel_name in before if before[kernel_name] != after[kernel_name]} == (
        changed
    )


@pytest.mark.usefixtures("fresh_modules")
@pytest.mark.parametrize(
    ("constant", "changed", "read"),
    [
        # Printed in full such an array would fill pages, so printing leaves its middle out.
        ("np.zeros(5000)", "np.concatenate([np.zeros(2500), np.ones(1), np.zeros(2499)])", "[0]"),
        ("np.arange(3)", "np.arange(3.0)", "[0]"),
        ("1.0", "1", ""),
    ],
    ids=["long array", "type of an array", "type of a number"],
)
def test_the_hash_sees_all_of_a_constant(
    constant: str, changed: str, read: str, tmp_path: Path
) -> None:
    def hash_with(value: str, folder: str) -> str:
        text = "((1, 2), (3, 4))"
        made = write(tmp_path / folder, {"conav_test_low": (text, value)})
        path = made / "conav_test_low.py"
        path.write_text(path.read_text().replace("TABLE[0][1]", f"TABLE{read}"))
        return hashes(made)["inner"]

    assert hash_with(constant, "a") == hash_with(constant, "b")
    assert hash_with(constant, "a") != hash_with(changed, "c")


@pytest.mark.usefixtures("fresh_modules")
@pytest.mark.parametrize(
    "body",
    [
        "    def nested(y):\n        return y * SCALE\n    return nested(x)\n",
        "    y = 0\n    for z in [SCALE for _ in range(2)]:\n        y += z\n    return y\n",
        "    return x * conav_test_settings.FACTOR\n",
    ],
    ids=["nested function", "comprehension", "module"],
)
def test_the_hash_sees_constants_read_in_other_ways(body: str, tmp_path: Path) -> None:
    def hash_with(scale: int, folder: str) -> str:
        made = write(tmp_path / folder, {"conav_test_low": ("SCALE = 3", f"SCALE = {scale}")})
        (made / "conav_test_settings.py").write_text(f"FACTOR = {scale}\n")
        path = made / "conav_test_low.py"
        source = "import conav_test_settings\n" + path.read_text()
        path.write_text(source.replace("    return x * SCALE + TABLE[0][1]\n", body))
        sys.modules.pop("conav_test_settings", None)
        return hashes(made)["inner"]

    assert hash_with(3, "a") == hash_with(3, "b")
    assert hash_with(3, "a") != hash_with(4, "c")


def python(script: str, *paths: Path, **environment: str) -> str:
    """What a new process prints."""
    inherited = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
    search = [*(str(path) for path in paths), inherited.get("PYTHONPATH", "")]
    inherited["PYTHONPATH"] = os.pathsep.join(part for part in search if part)
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=inherited | environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


RUN = """
import json
from conav_test_high import outer
from conav_test_low import inner
result = outer(10)
print(json.dumps({
    "result": result,
    "outer": [len(outer.compile().stats.cache_hits), len(outer.compile().stats.cache_misses)],
    "inner": [len(inner.compile().stats.cache_hits), len(inner.compile().stats.cache_misses)],
}))
"""


def compiled_files(cache: Path) -> set[Path]:
    return {path for path in cache.rglob("*") if path.suffix in (".nbi", ".nbc")}


def test_compiled_code_is_reused_and_never_stale(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    folder = write(tmp_path / "modules")

    def run() -> dict[str, object]:
        return json.loads(python(RUN, folder, CONAV_CACHE_DIR=str(cache)))

    first = run()
    assert first["result"] == 10 * 3 + 2 + 1 + 1
    assert first["outer"] == [0, 1]
    files = compiled_files(cache)
    assert files
    second = run()
    assert second["result"] == first["result"]
    assert second["outer"] == [1, 0]
    assert compiled_files(cache) == files
    # Only the innermost kernel's file changes; numba alone would serve the old outer one.
    write(folder, {"conav_test_low": ("SCALE = 3", "SCALE = 4")})
    third = run()
    assert third["result"] == 10 * 4 + 2 + 1 + 1
    assert third["outer"] == [0, 1]
    assert compiled_files(cache) > files
    # And back: what was compiled for the first version still lies there, at another time stamp.
    write(folder)
    assert run()["result"] == first["result"]


NOWHERE = """
import tempfile
{break_temporary}
from conav import compiled
from conav.geometry.clearance import point_segment_square
assert point_segment_square(0.0, 3.0, -1.0, 0.0, 1.0, 0.0) == 9.0
assert not point_segment_square.compile()._cache.cache_path if compiled.cache_folder() else True
print(compiled.cache_folder())
"""


@pytest.mark.parametrize(
    "break_temporary",
    [
        "tempfile.tempdir = {below!r}",
        # What Python does on a file system that is read-only throughout.
        "def gettempdir():\n    raise FileNotFoundError(2, 'No usable temporary directory')\n"
        "tempfile.gettempdir = gettempdir",
    ],
    ids=["a folder that cannot be made", "no temporary folder at all"],
)
def test_works_where_nothing_is_writable(break_temporary: str, tmp_path: Path) -> None:
    """Folders below a regular file cannot be made, not even by root."""
    blocker = tmp_path / "file"
    blocker.write_text("")
    below = str(blocker / "cache")
    script = NOWHERE.format(break_temporary=break_temporary.format(below=below))
    names = ("CONAV_CACHE_DIR", "XDG_CACHE_HOME", "HOME", "TMPDIR")
    assert python(script, **dict.fromkeys(names, below)) == "None"


def test_the_first_writable_folder_is_taken(tmp_path: Path) -> None:
    blocker = tmp_path / "file"
    blocker.write_text("")
    script = "from conav.compiled import cache_folder; print(cache_folder())"
    below, home = str(blocker / "cache"), tmp_path / "home"
    home.mkdir()
    taken = python(script, CONAV_CACHE_DIR=below, XDG_CACHE_HOME=below, HOME=str(home))
    assert taken == str(home / ".cache" / "conav" / "kernels")
    taken = python(script, CONAV_CACHE_DIR=below, XDG_CACHE_HOME=str(home), HOME=below)
    assert taken == str(home / "conav" / "kernels")


def test_importing_conav_imports_next_to_nothing(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    script = (
        "import sys, threading, conav\n"
        "heavy = ['numba', 'numpy', 'scipy', 'pydantic', 'PIL', 'mcap', 'rosbags', 'yaml']\n"
        "print([name for name in heavy if name in sys.modules], threading.active_count())\n"
    )
    assert python(script, CONAV_CACHE_DIR=str(cache)) == "[] 1"
    assert not cache.exists()


def test_importing_the_rooms_imports_no_numba(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    script = (
        "import sys\n"
        "import conav.simulation.explore, conav.exploration.verify, conav.exploration.nearest\n"
        "import conav.runs.reader, conav.maps.read_map\n"
        "print('numba' in sys.modules)\n"
    )
    assert python(script, CONAV_CACHE_DIR=str(cache)) == "False"
    assert not cache.exists()


@kernel
def endless(x: int) -> int:
    """Calls itself."""
    return endless(x) + 1


@kernel
def to_and(x: int) -> int:
    return fro(x) + 1


@kernel
def fro(x: int) -> int:
    return to_and(x) + 1


def test_a_kernel_that_calls_itself_is_refused() -> None:
    with pytest.raises(TypeError, match="endless calls itself"):
        endless(1)
    with pytest.raises(TypeError, match="calls itself"):
        endless.compile()


def test_kernels_that_call_each_other_in_a_circle_are_refused() -> None:
    with pytest.raises(TypeError, match="calls itself"):
        to_and(1)


@kernel
def doubled(x: float, y: float = 0.5) -> float:
    """Twice x, and y."""
    return 2 * x + y


def test_a_kernel_is_its_function() -> None:
    assert isinstance(doubled, Kernel)
    assert doubled(1.0, 2.0) == doubled.python(1.0, 2.0) == 4.0
    assert doubled.__name__ == "doubled"
    assert doubled.__doc__ == "Twice x, and y."


def test_a_kernel_keeps_its_defaults_and_keywords() -> None:
    assert doubled(1.0, y=2.0) == 4.0
    assert doubled(1.0) == doubled.python(1.0) == 2.5


def test_kernels_pickle_by_name() -> None:
    again = pickle.loads(pickle.dumps(point_segment_square))
    assert again is point_segment_square


def test_two_threads_may_call_a_kernel_first(tmp_path: Path) -> None:
    script = (
        "import threading\n"
        "from conav.geometry.clearance import point_segment_square as distance\n"
        "found = []\n"
        "def call():\n"
        "    found.append(distance(0.0, 3.0, -1.0, 0.0, 1.0, 0.0))\n"
        "threads = [threading.Thread(target=call) for _ in range(4)]\n"
        "[thread.start() for thread in threads]\n"
        "[thread.join() for thread in threads]\n"
        "print(found)\n"
    )
    assert python(script) == "[9.0, 9.0, 9.0, 9.0]"


def test_arguments_of_another_type_compile_anew() -> None:
    assert doubled(np.float32(1.5), np.float32(1.0)) == 4.0
    assert doubled(1, 1) == 3
