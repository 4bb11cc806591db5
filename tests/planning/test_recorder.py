"""A plan's run file: what is written is read, by us and by tools that do not know us."""

import os
import signal
import subprocess
import sys
from dataclasses import replace
from math import atan2, isclose
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from conav.errors import InputError
from conav.planning.budget import Progress
from conav.planning.catalogue import make_solver, settings_of
from conav.planning.recorded import problem_record, recorded_problem, recorded_trajectories
from conav.planning.recorder import PlanRecorder
from conav.planning.trajectory import positions
from conav.planning.verify import verify_plan
from conav.runs.reader import read_exploration, read_plan, read_run, repair_run
from conav.runs.types import PlanRun

from .hand_plan import hand_problem, hand_result, hand_trajectories, write_plan


def test_the_problem_comes_back(hand_run: PlanRun) -> None:
    problem = hand_problem()
    again = recorded_problem(hand_run)
    assert problem_record(again) == problem_record(problem)
    assert again.robots[0].name == "ann"
    assert again.robots[0].regions["lawn"].polygon is not None
    assert again.floor.area == 60 - 4


def test_the_plan_comes_back(hand_run: PlanRun) -> None:
    assert isinstance(read_run(hand_run.path), PlanRun)
    found = recorded_trajectories(hand_run)
    for one, expected in zip(found, hand_trajectories(), strict=True):
        assert one is not None
        assert np.array_equal(one.pieces, expected.pieces)
    assert hand_run.history == [{"round": 0, "sum": 30.0}]
    assert [one.improvement for one in hand_run.trajectories] == [1, 1]
    assert hand_run.result is not None
    assert hand_run.result["status"] == "done"
    assert hand_run.header["seed"] == 3
    assert set(hand_run.timing) == {"compute_s", "python", "machine", "conav", "numpy", "numba"}


def test_graphs_and_lost_trajectories_come_back(tmp_path: Path) -> None:
    problem = hand_problem()
    ann, bob = hand_trajectories()
    graphs = (np.arange(12.0).reshape(4, 3), np.empty((0, 3)))
    costs = np.array([[1.0, 2.0], [np.inf, np.inf]])
    result = hand_result(problem, trajectories=(ann, None), graphs=graphs, costs=costs)
    with PlanRecorder(tmp_path / "p.mcap", problem, solver="x", settings={}, seed=0) as recorder:
        recorder.improvement({"sum": 2.0}, (ann, bob))
        recorder.improvement({"sum": 1.0}, (ann, None))
        recorder.finish(result, compute_s=0.0)
    run = read_plan(tmp_path / "p.mcap")
    assert [(one.robot, one.improvement) for one in run.trajectories] == [(0, 1), (1, 1), (1, 2)]
    assert run.pieces(1) is None
    assert np.array_equal(run.graphs[0], graphs[0])
    assert run.graphs[1].shape == (0, 3)
    assert run.result is not None
    assert run.result["costs"] == [[1.0, 2.0], [None, None]]


def test_the_digest_is_of_the_plan_alone(tmp_path: Path) -> None:
    problem = hand_problem()
    result = hand_result(problem)
    digests = []
    for number in range(2):
        path = tmp_path / f"{number}.mcap"
        with PlanRecorder(path, problem, solver="x", settings={}, seed=0) as recorder:
            recorder.finish(result, compute_s=float(number))
        run = read_plan(path)
        assert run.digest == recorder.digest
        digests.append(run.digest)
    assert digests[0] == digests[1]
    other = write_plan(tmp_path / "other.mcap", replace(problem, margin_m=0.2), result)
    assert other.digest != digests[0]


def test_other_jobs_are_told_apart(hand_run: PlanRun) -> None:
    with pytest.raises(InputError, match="job 'plan'"):
        read_exploration(hand_run.path)


def test_a_solver_is_followed(scenes: SimpleNamespace, tmp_path: Path) -> None:
    """What is written on the way is the history, with the plan of each moment."""
    problem = scenes.antipodal(4)
    solver = make_solver("inash", {"samples": 600, "batch": 100})
    seen = []
    with PlanRecorder(
        tmp_path / "p.mcap", problem, solver="inash", settings=settings_of(solver), seed=2
    ) as recorder:

        def follow(progress: Progress) -> None:
            recorder.follow(progress)
            seen.append(progress.costs[:, 0].tolist())

        result = solver.solve(problem, 2, follow)
        recorder.finish(result, compute_s=0.0)
    run = read_plan(tmp_path / "p.mcap")
    assert len(run.history) == len(result.history) > 1
    assert {one.improvement for one in run.trajectories} <= set(range(1, len(run.history) + 1))
    assert len(run.trajectories) > 4
    for one, expected in zip(recorded_trajectories(run), result.trajectories, strict=True):
        assert one is not None
        assert expected is not None
        assert np.array_equal(one.pieces, expected.pieces)
    report = verify_plan(run)
    assert report.accepted, report.lines()
    assert next(check for check in report.checks if check.name == "history").looked > 4


KILLED = """
import os, sys
sys.path.insert(0, sys.argv[2])
from hand_plan_copy import hand_problem, hand_trajectories
from conav.planning.recorder import PlanRecorder
import conav.runs.writer
conav.runs.writer.FLUSH_S = 0.0
recorder = PlanRecorder(sys.argv[1], hand_problem(), solver="x", settings={}, seed=0)
ann, bob = hand_trajectories()
recorder.improvement({"sum": 2.0}, (ann, bob))
print("written", flush=True)
sys.stdin.read()
"""


def test_a_killed_solver_leaves_what_it_had(tmp_path: Path) -> None:
    source = Path(__file__).with_name("hand_plan.py").read_text()
    (tmp_path / "hand_plan_copy.py").write_text(source)
    path = tmp_path / "killed.mcap"
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(path), str(tmp_path)],
        stdout=subprocess.PIPE,
        stdin=subprocess.PIPE,
        env=os.environ,
    )
    assert process.stdout is not None
    assert process.stdin is not None
    assert process.stdout.readline() == b"written\n"
    process.send_signal(signal.SIGKILL)
    process.wait(timeout=20)
    process.stdout.close()
    process.stdin.close()
    run = read_plan(path)
    assert not run.intact
    assert run.result is None
    assert run.history == [{"sum": 2.0}]
    found = recorded_trajectories(run)
    assert found[0] is not None
    assert np.array_equal(found[0].pieces, hand_trajectories()[0].pieces)
    repair_run(path, tmp_path / "repaired.mcap")
    assert read_plan(tmp_path / "repaired.mcap").digest == run.digest


def test_ros_tools_read_it(hand_run: PlanRun) -> None:
    messages: dict[str, list[tuple[int, Any]]] = {}
    with AnyReader([hand_run.path]) as reader:
        for connection, time_ns, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            messages.setdefault(connection.topic, []).append((time_ns, message))
    assert set(messages) >= {"/scene", "/ann/path", "/bob/path", "/ann/pose", "/tf"}
    ann, _ = hand_trajectories()
    ((_, path),) = messages["/ann/path"]
    for pose in path.poses:
        t = pose.header.stamp.sec + pose.header.stamp.nanosec * 1e-9
        place = pose.pose.position
        assert np.allclose(positions(ann, t)[0], [place.x, place.y], atol=1e-8)
    times = [time_ns for time_ns, _ in messages["/tf"]]
    assert times == sorted(times)
    assert times[-1] == 14 * 10**9
    for time_ns, pose in messages["/ann/pose"][:3]:
        turn = pose.pose.orientation
        assert isclose(2 * atan2(turn.z, turn.w), atan2(-1.5, 3))
        assert np.allclose(
            positions(ann, time_ns / 1e9)[0], [pose.pose.position.x, pose.pose.position.y]
        )
    ((_, scene),) = messages["/scene"]
    kinds = [(marker.ns, marker.type) for marker in scene.markers]
    assert kinds.count(("walls", 4)) == 2
    assert ("obstacles", 3) in kinds
    assert ("robots", 3) in kinds
    with hand_run.path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_summary() is not None
        assert sum(1 for _ in reader.iter_messages()) > 100
