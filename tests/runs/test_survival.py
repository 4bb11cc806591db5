"""Killed, cut short or damaged: what was written is not lost, and nothing worse happens."""

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import conav
from conav.errors import InputError
from conav.runs.types import Run

SLOW_RUN = """
import sys, time
import conav
def wait(state):
    time.sleep(0.002)
conav.explore("office", robots=4, seed=6, out=sys.argv[1], progress=wait)
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    conav.explore("office", robots=4, seed=6, out=path)
    return path


def assert_prefix(part: Run, run: Run) -> None:
    assert len(part.steps) <= len(run.steps)
    for ours, theirs in zip(part.steps, run.steps, strict=False):
        for a, b in zip(ours, theirs, strict=True):
            assert np.array_equal(a, b)


def assert_opens_everywhere(path: Path, steps: int) -> None:
    """With the mcap package's indexed reader and with rosbags."""
    from mcap.reader import make_reader
    from rosbags.highlevel import AnyReader

    with path.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.chunk_indexes
        found = sum(1 for _ in reader.iter_messages(topics=["/conav/step"]))
    assert found == steps
    with AnyReader([path]) as bag:
        wanted = [item for item in bag.connections if item.topic == "/conav/step"]
        messages = [bag.deserialize(raw, c.msgtype) for c, _, raw in bag.messages(wanted)]
    assert [message.step for message in messages] == list(range(steps))


@pytest.mark.parametrize("turn", range(3))
def test_sigkill_at_a_random_moment(turn: int, whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    process = subprocess.Popen([sys.executable, "-c", SLOW_RUN, str(path)])
    try:
        deadline = time.monotonic() + 120
        while not (path.exists() and path.stat().st_size > 20_000):
            assert time.monotonic() < deadline
            assert process.poll() is None
            time.sleep(0.01)
        time.sleep(random.Random(turn).uniform(0.0, 1.2))
        assert process.poll() is None, "the run ended before it was killed"
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    run = conav.read_run(path)
    assert not run.intact
    assert run.result is None
    assert_prefix(run, conav.read_run(whole))
    report = conav.verify_exploration(run)
    assert report.accepted, report.lines()
    mended = tmp_path / "mended.mcap"
    conav.repair_run(path, mended)
    again = conav.read_run(mended)
    assert again.intact
    assert again.digest == run.digest
    assert_prefix(again, run)
    assert_opens_everywhere(mended, len(run.steps))


def test_a_whole_file_opens_everywhere(whole: Path) -> None:
    run = conav.read_run(whole)
    assert run.intact
    assert_opens_everywhere(whole, len(run.steps))


def test_cut_at_any_length(whole: Path, tmp_path: Path) -> None:
    data = whole.read_bytes()
    run = conav.read_run(whole)
    path = tmp_path / "cut.mcap"
    read = 0
    for length in [*range(0, 200, 7), *range(200, len(data), len(data) // 60)]:
        path.write_bytes(data[:length])
        try:
            part = conav.read_run(path)
        except InputError:
            continue
        assert not part.intact
        assert_prefix(part, run)
        read += 1
    assert read > 20


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.lists(st.tuples(st.floats(0, 1), st.integers(0, 255)), min_size=1, max_size=5))
def test_damage_anywhere(whole: Path, tmp_path: Path, damage: list[tuple[float, int]]) -> None:
    data = bytearray(whole.read_bytes())
    for place, value in damage:
        data[int(place * (len(data) - 1))] = value
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    try:
        run = conav.read_run(path)
    except InputError:
        return
    assert len(run.steps) <= len(conav.read_run(whole).steps)


@pytest.mark.parametrize("content", [b"", b"hello", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n" * 9])
def test_what_is_no_run(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "no.mcap"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"no\.mcap"):
        conav.read_run(path)


def test_an_interrupt_keeps_what_there_is(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"

    def stop(state: object) -> None:
        if state.step == 40:  # type: ignore[attr-defined]
            raise KeyboardInterrupt

    done = conav.explore("office", robots=2, seed=1, out=path, progress=stop)
    assert done.result.interrupted
    assert done.status == "out_of_budget"
    run = conav.read_run(path)
    assert run.intact
    assert len(run.steps) == 41
    report = conav.verify_exploration(run)
    assert report.accepted, report.lines()


def test_nothing_else_is_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "thesis.txt"
    path.write_text("four years of work")
    with pytest.raises(InputError, match=r"thesis\.txt"):
        conav.explore("office", robots=1, out=path)
    assert path.read_text() == "four years of work"
