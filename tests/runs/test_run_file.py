"""What is written is what is read, and nothing that matters is written over."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import conav
from conav.errors import InputError
from conav.runs.encode import encode_step
from conav.runs.exploration_writer import ExplorationWriter
from conav.runs.reader import read_run, repair_run
from conav.runs.schemas import FORMAT, STEP, typestore
from conav.runs.types import OCCUPIED_BIT, StepRecord

HEADER = {"format": FORMAT, "job": "explore", "note": "größer"}
WORLD = np.array([[0, 1, 2], [2, 0, 0]], dtype=np.uint8)


def numbers(kind: type, size: int | st.SearchStrategy[int]) -> st.SearchStrategy[np.ndarray]:
    return arrays(kind, size)


@st.composite
def step_records(draw: st.DrawFn) -> StepRecord:
    n = draw(st.integers(0, 9))
    any_length = st.integers(0, 9)
    return StepRecord(
        draw(st.integers(0, 2**32 - 1)),
        draw(numbers(np.uint32, n)),
        draw(numbers(np.uint8, n)),
        draw(numbers(np.uint8, n)),
        draw(numbers(np.uint32, n)),
        draw(numbers(np.uint32, any_length)),
        draw(numbers(np.uint32, any_length)),
        draw(numbers(np.uint32, any_length)),
        draw(numbers(np.int8, n)),
        draw(numbers(np.int32, n)),
        draw(numbers(np.uint8, n)),
        draw(numbers(np.uint8, n)),
        draw(numbers(np.uint8, n)),
        draw(st.integers(0, 2**32 - 1)),
        draw(st.integers(0, 2**64 - 1)),
    )


def same(a: StepRecord, b: StepRecord) -> bool:
    return all(
        np.array_equal(x, y) and np.asarray(x).dtype.kind == np.asarray(y).dtype.kind
        for x, y in zip(a, b, strict=True)
    )


def write(path: Path, steps: list[StepRecord], result: dict[str, object] | None) -> str:
    with ExplorationWriter(path) as writer:
        writer.header(HEADER)
        writer.world(WORLD, 0.25, (1.0, -2.0, 0.5))
        for number, step in enumerate(steps):
            writer.step(number * 500_000_000, step)
        if result is not None:
            writer.result(len(steps) * 500_000_000, result)
        writer.timing({"compute_s": "0.5"})
        return writer.digest


@settings(max_examples=60, deadline=None)
@given(steps=st.lists(step_records(), max_size=4))
def test_what_is_written_is_read(steps: list[StepRecord], tmp_path_factory) -> None:
    path = tmp_path_factory.mktemp("trip") / "run.mcap"
    digest = write(path, steps, {"status": "done"})
    run = read_run(path)
    assert run.header == HEADER
    assert np.array_equal(run.cells, WORLD)
    assert (run.resolution, run.origin) == (0.25, (1.0, -2.0, 0.5))
    assert len(run.steps) == len(steps)
    assert all(same(a, b) for a, b in zip(run.steps, steps, strict=True))
    assert run.result == {"status": "done"}
    assert run.timing["compute_s"] == "0.5"
    assert run.digest == digest
    assert run.intact
    assert run.path == path


@settings(max_examples=150, deadline=None)
@given(step_records())
def test_steps_are_encoded_as_the_ros_library_does(step: StepRecord) -> None:
    store = typestore()
    assert encode_step(step) == bytes(store.serialize_cdr(store.types[STEP](*step), STEP))


def test_scans_are_told_apart() -> None:
    step = StepRecord(
        0,
        *(np.zeros(3, kind) for kind in (np.uint32, np.uint8, np.uint8)),
        np.array([2, 2, 3], np.uint32),
        np.array([7, 8 | OCCUPIED_BIT, 9 | OCCUPIED_BIT], np.uint32),
        np.empty(0, np.uint32),
        np.empty(0, np.uint32),
        *(np.zeros(3, kind) for kind in (np.int8, np.int32, np.uint8, np.uint8, np.uint8)),
        0,
        0,
    )
    cells, occupied = step.scan(0)
    assert cells.tolist() == [7, 8]
    assert occupied.tolist() == [False, True]
    assert step.scan(1)[0].tolist() == []
    assert step.scan(2)[0].tolist() == [9]


def test_a_run_says_what_it_was_and_how_it_ended(small_run: Path) -> None:
    run = read_run(small_run)
    assert run.header["seed"] == 5
    assert run.header["robots"][1]["radio"]["range_m"] == 1.5
    assert run.result is not None
    assert run.result["status"] == "done"
    assert run.result["metrics"]["steps"] == len(run.steps) - 1
    assert {"python", "conav", "numpy", "compute_s"} <= set(run.timing)


def test_wall_times_and_versions_are_no_part_of_the_digest(tmp_path: Path, monkeypatch) -> None:
    from conav.simulation import run_exploration

    first = conav.explore("three-obstacles", robots=2, out=tmp_path / "a.mcap")
    monkeypatch.setattr(run_exploration, "versions", lambda: {"python": "another"})
    second = conav.explore("three-obstacles", robots=2, out=tmp_path / "b.mcap")
    a, b = read_run(tmp_path / "a.mcap"), read_run(tmp_path / "b.mcap")
    assert a.timing != b.timing
    assert first.result.digest == second.result.digest == a.digest == b.digest


def test_the_digest_tells_seeds_apart(tmp_path: Path) -> None:
    digests = {
        conav.explore("maze", robots=2, seed=seed, out=tmp_path / "run.mcap").result.digest
        for seed in range(3)
    }
    assert len(digests) == 3


def test_a_file_without_a_result_is_read(tmp_path: Path) -> None:
    write(tmp_path / "run.mcap", [], None)
    run = read_run(tmp_path / "run.mcap")
    assert run.result is None
    assert run.intact


def test_another_format_is_refused(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setitem(HEADER, "format", 99)
    write(tmp_path / "run.mcap", [], None)
    with pytest.raises(InputError, match="is of format 99; this conav reads 3; use the conav that"):
        read_run(tmp_path / "run.mcap")


def test_a_run_is_written_over_a_run_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.touch()  # an empty file holds nothing to lose
    write(path, [], None)
    write(path, [], {"status": "stuck"})
    assert read_run(path).result == {"status": "stuck"}
    path.write_text("precious")
    with pytest.raises(InputError, match="exists and is no run file; it is left alone"):
        ExplorationWriter(path)
    assert path.read_text() == "precious"


def test_places_that_cannot_be_written_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"is a folder; name a file, for example run\.mcap"):
        ExplorationWriter(tmp_path)
    with pytest.raises(InputError, match="lies in a folder that does not exist; make the folder"):
        ExplorationWriter(tmp_path / "no" / "run.mcap")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_named() -> None:
    with pytest.raises(InputError, match="/dev/full: cannot be written"):
        write(Path("/dev/full"), [], None)
    with pytest.raises(InputError, match="/dev/full: cannot be written"):
        conav.explore("three-obstacles", robots=1, out="/dev/full")


def test_repair_of_a_whole_file_keeps_everything(small_run: Path, tmp_path: Path) -> None:
    out = tmp_path / "copy.mcap"
    count = repair_run(small_run, out)
    before, after = read_run(small_run), read_run(out)
    assert count > len(before.steps)
    assert after.digest == before.digest
    assert after.timing == before.timing
    assert after.intact
    assert replace(after, path=before.path, steps=[]).result == before.result


def test_repair_destroys_nothing(small_run: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is the damaged file itself; name another --out"):
        repair_run(small_run, small_run)
    precious = tmp_path / "precious.txt"
    precious.write_text("precious")
    with pytest.raises(InputError, match="it is left alone"):
        repair_run(small_run, precious)
    assert precious.read_text() == "precious"
    with pytest.raises(InputError, match="does not exist"):
        repair_run(small_run, tmp_path / "no" / "run.mcap")
    with pytest.raises(InputError, match="is no run file"):
        repair_run(precious, tmp_path / "out.mcap")
    assert not (tmp_path / "out.mcap").exists()
