"""Starting is quick because nothing heavy is imported before it is needed."""

import subprocess
import sys

HEAVY = ["numpy", "numba", "scipy", "mcap", "rosbags", "pydantic", "PIL", "yaml"]

IN_THIS_PROCESS = """
import sys
{action}
print(*sorted(name for name in {heavy} if name in sys.modules))
"""


def loaded_by(action: str) -> list[str]:
    """Which heavy packages are loaded after an action."""
    done = subprocess.run(
        [sys.executable, "-c", IN_THIS_PROCESS.format(action=action, heavy=HEAVY)],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()[-1].split()


def test_import_conav_loads_nothing_heavy() -> None:
    assert loaded_by("import conav; dir(conav); conav.__version__") == []
    assert loaded_by("from conav import InputError, Status") == []


def test_help_loads_nothing_heavy() -> None:
    for arguments in (["--help"], ["--version"], ["explore", "--help"], ["--bogus"], []):
        action = f"from conav.cli import run; run({arguments})"
        assert loaded_by(action) == [], arguments


def test_help_of_the_module_imports_no_numpy() -> None:
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "conav", "--help"],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0
    imported = {line.rsplit("|", 1)[-1].strip() for line in done.stderr.splitlines()}
    assert "conav.cli" in imported
    assert imported.isdisjoint({"numpy", "numba", "scipy", "mcap", "rosbags"})


def test_numba_is_loaded_by_the_first_kernel_only() -> None:
    assert "numba" not in loaded_by("import conav; conav.builtin_map('three-obstacles')")
    assert "numba" in loaded_by("import conav; conav.explore('three-obstacles', max_time_s=1)")
