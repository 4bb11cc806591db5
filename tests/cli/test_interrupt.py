"""Ctrl-C in the middle of a run: it ends at once, says so, and leaves a file that is right."""

import json
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from time import monotonic, sleep

import pytest

import conav
from conav.cli.interrupts import EndAfterStep, Interrupted
from conav.exploration.verify import verify_exploration


@pytest.fixture(autouse=True)
def _heard_interrupts() -> Iterator[None]:
    """Interrupts as in a terminal: started in the background of a script, tests find them ignored,
    and so would the processes they start.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


LONG = [
    "explore",
    "field",
    "--robots",
    "2",
    "--range",
    "1.5",
    "--resolution",
    "0.25",
    "--seed",
    "2",
]


def started(folder: Path, *more: str) -> subprocess.Popen[str]:
    """The command, running for long enough that its file has steps."""
    process = subprocess.Popen(
        [sys.executable, "-m", "conav", *LONG, "--out", "run.mcap", *more],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = monotonic() + 120
    path = folder / "run.mcap"
    while not path.exists() or path.stat().st_size < 40_000:
        assert process.poll() is None, process.communicate()
        assert monotonic() < deadline
        sleep(0.02)
    return process


@pytest.mark.parametrize("more", [[], ["--json"]], ids=["summary", "json"])
def test_an_interrupted_run(tmp_path: Path, more: list[str]) -> None:
    process = started(tmp_path, *more)
    process.send_signal(signal.SIGINT)
    start = monotonic()
    out, err = process.communicate(timeout=20)
    assert monotonic() - start < 5
    assert process.returncode == 1, err
    assert "Traceback" not in err
    run = conav.read_run(tmp_path / "run.mcap")
    assert run.intact
    assert run.result is not None
    assert run.result["interrupted"] is True
    if more:
        summary = json.loads(out)
        assert summary["interrupted"] is True
        assert summary["status"] == "out_of_budget"
        assert summary["digest"] == run.digest
    else:
        assert "  interrupted: " in out
    report = verify_exploration(run)
    assert report.accepted, report.lines()
    assert len(run.steps) > 10


def test_the_run_ends_between_two_steps() -> None:
    before = signal.getsignal(signal.SIGINT)
    with EndAfterStep() as interrupts:
        interrupts.step()
        signal.raise_signal(signal.SIGINT)  # only noted: a step is under way
        with pytest.raises(KeyboardInterrupt):
            interrupts.step()
    assert signal.getsignal(signal.SIGINT) is before


def test_before_the_first_step_and_the_second_time_it_ends_at_once() -> None:
    with EndAfterStep(), pytest.raises(Interrupted):
        signal.raise_signal(signal.SIGINT)
    with EndAfterStep() as interrupts:
        interrupts.step()
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(Interrupted):
            signal.raise_signal(signal.SIGINT)


def test_an_interrupt_before_there_is_anything_to_show(capsys, monkeypatch) -> None:
    from conav.cli import run
    from conav.simulation import explore

    def interrupted(*args: object, **kwargs: object) -> None:
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(explore, "explore", interrupted)
    assert run(["explore", "office", "--quiet"]) == 130
    assert capsys.readouterr() == ("", "conav: interrupted\n")


def test_other_threads_and_ignored_interrupts_are_left_alone() -> None:
    failures: list[BaseException] = []

    def inside() -> None:
        try:
            with EndAfterStep() as interrupts:
                interrupts.step()
        except BaseException as error:
            failures.append(error)

    thread = threading.Thread(target=inside)
    thread.start()
    thread.join()
    assert failures == []
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with EndAfterStep() as interrupts:
            interrupts.step()
            signal.raise_signal(signal.SIGINT)
            interrupts.step()
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
