"""The command in this process, where most of its tests run."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from conav.cli import run


class Outcome(NamedTuple):
    code: int
    out: str
    err: str


Command = Callable[..., Outcome]


@pytest.fixture
def conav(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch) -> Command:
    """`conav("maps", "office")` is what that command does in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def command(*arguments: object) -> Outcome:
        capsys.readouterr()
        code = run([str(argument) for argument in arguments])
        return Outcome(code, *capsys.readouterr())

    return command
