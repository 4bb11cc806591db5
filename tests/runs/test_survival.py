"""Files of killed processes, cut short, with flipped bits or with lies in them.

Reading gives a run or an `InputError`, never anything else, and neither waits nor eats memory.
"""

import os
import random
import signal
import struct
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

import conav
from conav.errors import InputError
from conav.exploration.verify import verify_exploration
from conav.runs.mcap_records import Metadata, RawMessage, records
from conav.runs.mcap_sink import McapSink, open_for_writing
from conav.runs.reader import read_run, repair_run
from conav.runs.schemas import (
    EVENT_TOPICS,
    HEADER_TOPIC,
    RESULT_TOPIC,
    STEP_TOPIC,
    WORLD_TOPIC,
)
from conav.runs.types import ExplorationRun, StepRecord

MAP = {"name": "office", "width_m": 80, "height_m": 50, "resolution": 0.2}
PROBLEM = {"robots": 8, "seed": 6}

SLOWLY = f"""
import sys, time
import conav, conav.runs.writer
conav.runs.writer.FLUSH_S = 0.05  # more chunks in less time than usual
def pause(state):
    if state.step == 0:
        print("begun", flush=True)
    time.sleep(0.002)
conav.explore(conav.builtin_map(**{MAP}), **{PROBLEM}, out=sys.argv[1], progress=pause)
"""


def same(a: StepRecord, b: StepRecord) -> bool:
    return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


def is_beginning(part: ExplorationRun, whole: ExplorationRun) -> bool:
    return (
        part.header == whole.header
        and np.array_equal(part.cells, whole.cells)
        and len(part.steps) <= len(whole.steps)
        and all(map(same, part.steps, whole.steps))
    )


def read_or_refuse(path: Path) -> ExplorationRun | None:
    """What reading a damaged file comes to; `None` when it is refused in one line."""
    start = monotonic()
    run = None
    try:
        run = read_run(path)
    except InputError as refusal:
        text = str(refusal)
    else:
        text = f"{path}: is read"
    assert text.startswith(str(path))
    assert "\n" not in text
    assert monotonic() - start < 10
    return run


@pytest.fixture(scope="module")
def killed_runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Files of processes that were killed at random moments."""
    folder = tmp_path_factory.mktemp("killed")
    rng = random.Random(os.getpid())
    paths = [folder / f"{number}.mcap" for number in range(4)]
    processes = [
        subprocess.Popen([sys.executable, "-c", SLOWLY, str(path)], stdout=subprocess.PIPE)
        for path in paths
    ]
    for number, process in enumerate(processes):
        assert process.stdout is not None
        assert process.stdout.readline() == b"begun\n"
        sleep(rng.uniform(0.02, 0.2) if number == 0 else rng.uniform(0.1, 1.0))
        process.send_signal(signal.SIGKILL)
        assert process.wait(timeout=20) == -signal.SIGKILL
        process.stdout.close()
    return paths


def test_killed_processes_leave_the_beginning_of_their_run(
    killed_runs: list[Path], tmp_path: Path
) -> None:
    whole_path = tmp_path / "whole.mcap"
    done = conav.explore(conav.builtin_map(**MAP), **PROBLEM, out=whole_path)
    whole = read_run(whole_path)
    assert done.status == "done"
    longest = None
    for path in killed_runs:
        part = read_run(path)
        assert not part.intact
        assert part.result is None
        assert is_beginning(part, whole)
        out = tmp_path / path.name
        repair_run(path, out)
        again = read_run(out)
        assert again.intact
        assert again.digest == part.digest
        assert is_beginning(again, part)
        assert len(again.steps) == len(part.steps)
        if longest is None or len(part.steps) > len(longest.steps):
            longest = part
    assert longest is not None
    assert 10 < len(longest.steps) < len(whole.steps)
    report = verify_exploration(longest)
    assert report.accepted, report.lines()
    assert not report.intact
    assert not report.finished
    assert any("cut short" in line for line in report.lines())


def test_repaired_files_open_everywhere(killed_runs: list[Path], tmp_path: Path) -> None:
    out = tmp_path / "repaired.mcap"
    count = repair_run(killed_runs[-1], out)
    run = read_run(out)
    report = verify_exploration(run)
    assert report.accepted, report.lines()
    assert not report.finished
    with out.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == count
        assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 0
        topics = {channel.topic: number for number, channel in summary.channels.items()}
        steps = summary.statistics.channel_message_counts[topics["/conav/step"]]
        assert steps == len(run.steps)
        assert sum(1 for _ in reader.iter_messages()) == count
        numbers = [item.sequence for _, _, item in reader.iter_messages("/conav/step")]
        assert numbers == list(range(steps))
    with AnyReader([out]) as bag:
        assert bag.message_count == count
        wanted = [item for item in bag.connections if item.topic == "/conav/step"]
        for (connection, _, data), step in zip(bag.messages(wanted), run.steps, strict=True):
            message = bag.deserialize(data, connection.msgtype)
            assert np.array_equal(message.cells, step.cells)


def test_files_cut_anywhere(small_run: Path, tmp_path: Path) -> None:
    data = small_run.read_bytes()
    whole = read_run(small_run)
    path = tmp_path / "cut.mcap"
    refused = 0
    counts: list[int] = []
    lengths = {*range(0, len(data), 97), *range(64), *range(len(data) - 400, len(data), 7)}
    for length in sorted(lengths):
        path.write_bytes(data[:length])
        run = read_or_refuse(path)
        if run is None:
            refused += 1
            continue
        assert not run.intact
        assert is_beginning(run, whole)
        counts.append(len(run.steps))
    assert refused > 10
    assert counts == sorted(counts)
    assert counts[-1] == len(whole.steps)


def test_any_changed_byte_shows(small_run: Path, tmp_path: Path) -> None:
    data = small_run.read_bytes()
    whole = read_run(small_run)
    path = tmp_path / "flipped.mcap"
    for place in [*range(0, len(data), 61), *range(400), *range(len(data) - 400, len(data))]:
        flipped = bytearray(data)
        flipped[place] ^= 1 << (place % 8)
        path.write_bytes(flipped)
        run = read_or_refuse(path)
        if run is not None:
            assert not run.intact, place
            assert is_beginning(run, whole)


edits = st.lists(
    st.tuples(
        st.sampled_from(["set", "insert", "drop", "cut", "long"]),
        st.floats(0, 1, exclude_max=True),
        st.binary(min_size=1, max_size=12),
    ),
    min_size=1,
    max_size=4,
)


@settings(max_examples=150, deadline=None)
@given(edits)
def test_mangled_files(small_run: Path, tmp_path_factory, edits: list) -> None:
    data = bytearray(small_run.read_bytes())
    for kind, where, content in edits:
        at = int(where * len(data))
        if kind == "set":
            data[at : at + len(content)] = content
        elif kind == "insert":
            data[at:at] = content
        elif kind == "drop":
            del data[at : at + len(content)]
        elif kind == "cut":
            del data[at:]
        else:
            data[at : at + 8] = b"\xff" * (len(content) % 8) + b"\x7f"
    path = tmp_path_factory.mktemp("mangled") / "run.mcap"
    path.write_bytes(data)
    read_or_refuse(path)


def items_of(path: Path) -> list[RawMessage | Metadata]:
    with path.open("rb") as stream:
        return list(records(stream))


def write_items(items: list[RawMessage | Metadata], path: Path) -> None:
    sink = McapSink(open_for_writing(path))
    channels: dict[str, int] = {}
    for item in items:
        if isinstance(item, Metadata):
            sink.metadata(*item)
            continue
        if item.topic not in channels:
            channels[item.topic] = sink.channel(
                item.topic, item.schema, item.schema_text, item.metadata
            )
        sink.message(channels[item.topic], item.time_ns, item.sequence, item.data)
    sink.close()


@settings(max_examples=150, deadline=None)
@given(
    topic=st.sampled_from([HEADER_TOPIC, WORLD_TOPIC, STEP_TOPIC, RESULT_TOPIC]),
    which=st.integers(0, 1000),
    where=st.floats(0, 1, exclude_max=True),
    content=st.binary(min_size=1, max_size=8),
    cut=st.booleans(),
)
def test_lies_with_right_checksums(
    small_run: Path,
    tmp_path_factory,
    topic: str,
    which: int,
    where: float,
    content: bytes,
    cut: bool,
) -> None:
    """Whole files with nonsense inside are refused, read up to it, or rejected by the verifier."""
    items = items_of(small_run)
    places = [
        number
        for number, item in enumerate(items)
        if isinstance(item, RawMessage) and item.topic == topic
    ]
    place = places[which % len(places)]
    item = items[place]
    assert isinstance(item, RawMessage)
    data = bytearray(item.data)
    at = int(where * len(data))
    if cut:
        del data[at:]
    else:
        data[at : at + len(content)] = content
    items[place] = item._replace(data=bytes(data))
    path = tmp_path_factory.mktemp("lies") / "run.mcap"
    write_items(items, path)
    run = read_or_refuse(path)
    if run is not None:
        # A header of nonsense cannot be verified; anything else is accepted or rejected.
        with suppress(InputError):
            verify_exploration(run)


def test_events_out_of_turn_end_the_run(small_run: Path, tmp_path: Path) -> None:
    items = items_of(small_run)
    events = [item for item in items if isinstance(item, RawMessage) and item.topic in EVENT_TOPICS]
    header, world, *steps, result = events
    path = tmp_path / "run.mcap"
    for order, count in (
        ([header, world, *steps, header, result], len(steps)),
        ([header, world, *steps[:3], world, *steps[3:]], 3),
        ([header, world, *steps[:3], result, *steps[3:]], 3),
        ([header, world, result, result], 0),
    ):
        write_items(list(order), path)
        run = read_run(path)
        assert not run.intact
        assert len(run.steps) == count
    for order in ([world, header, *steps], steps, [header, *steps, world], [result]):
        write_items(list(order), path)
        with pytest.raises(InputError):
            read_run(path)
    write_items([item for item in items if item not in events], path)
    with pytest.raises(InputError, match="holds no conav run"):
        read_run(path)


def record(kind: int, body: bytes, length: int | None = None) -> bytes:
    return struct.pack("<BQ", kind, len(body) if length is None else length) + body


def chunk(size: int, method: bytes, packed: bytes, length: int | None = None) -> bytes:
    length = len(packed) if length is None else length
    head = struct.pack("<QQQII", 0, 0, size, 0, len(method)) + method
    return record(6, head + struct.pack("<Q", length) + packed)


GREEDY = """
import resource, sys, time
from pathlib import Path
import conav
from conav.errors import InputError
from conav.runs.mcap_records import MAX_BYTES
import numpy, mcap.writer, rosbags.typesys, zstandard, lz4.frame
import conav.runs.reader
conav.runs.schemas.typestore()
used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
limit = used + (64 << 20)
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
start = time.monotonic()
for path in sorted(Path(sys.argv[1]).glob("*.mcap")):
    try:
        run = conav.read_run(path)
        assert not run.intact, path
    except InputError:
        pass
assert time.monotonic() - start < 5
print("frugal")
"""


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux")
def test_false_lengths_cost_no_memory(small_run: Path, tmp_path: Path) -> None:
    """Under a limit of 64 MiB more than an idle process, no claim of a length runs out of it."""
    magic = b"\x89MCAP0\r\n"
    data = small_run.read_bytes()
    # A zstd frame that says it holds 2^40 bytes: magic number, flags, length, an empty last block.
    frame = struct.pack("<IBQ", 0xFD2FB528, 0xE0, 2**40) + b"\x01\x00\x00"
    greedy = {
        "record": magic + record(4, b"", 2**62),
        "record2": magic + record(4, b"", 2**64 - 1),
        "chunk": magic + chunk(2**62, b"zstd", b"abc"),
        "frame": magic + chunk(2**40, b"zstd", frame),
        "frame2": magic + chunk(4, b"zstd", frame),
        "packed": magic + chunk(16, b"zstd", b"abc", 2**63),
        "lz4": magic + chunk(2**29, b"lz4", b"\x04\x22\x4d\x18" + b"\x00" * 30),
        "unknown": magic + chunk(2**29, b"best", b"abc"),
        "nested": magic + chunk(100, b"", chunk(0, b"", b"").ljust(100, b"\0")),
        "schema": magic + record(3, struct.pack("<HI", 1, 2**32 - 1)),
        "map": magic + record(12, struct.pack("<IBI", 1, 65, 2**32 - 1)),
        "empty": magic,
        "later": data[: len(data) // 2] + record(4, b"", 2**40) + data[len(data) // 2 :],
    }
    for name, content in greedy.items():
        (tmp_path / f"{name}.mcap").write_bytes(content)
    done = subprocess.run(
        [sys.executable, "-c", GREEDY, str(tmp_path)], capture_output=True, text=True, timeout=60
    )
    assert done.stdout == "frugal\n", done.stderr
