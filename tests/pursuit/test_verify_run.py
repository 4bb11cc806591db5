"""Run files of pursuits: written, read, accepted, and rejected when anything was changed."""

import copy
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from conav.cli import run as command
from conav.errors import InputError
from conav.pursuit.recorder import record_pursuit
from conav.pursuit.types import (
    HiddenRegion,
    Pursuer,
    PursuitProblem,
    PursuitResult,
    Schedule,
)
from conav.pursuit.verify import verify_pursuit
from conav.pursuit.verify_certificate_check import certificate_faults
from conav.pursuit.verify_decide import Verdict
from conav.pursuit.verify_escape_check import escape_faults, evader_path
from conav.runs.reader import read_exploration, read_pursuit, read_run
from conav.runs.types import PursuitRun
from conav.status import Status

from .floors import DOORS, LEFT, LEFT_TO_RIGHT, RIGHT, RING, ROOMS, Way


def timed(*ways: Way) -> Schedule:
    """Pursuers who drive these ways at 1 m/s; each leg lasts as long as its longest drive."""
    positions = np.array(ways, dtype=np.float64).transpose(1, 0, 2)
    lengths = np.hypot(*np.moveaxis(np.diff(positions, axis=0), 2, 0)).max(axis=1)
    times = np.concatenate(([0.0], np.cumsum(lengths)))
    return Schedule(times, positions, np.ones((len(lengths), len(ways)), dtype=np.bool_))


def result_of(schedule: Schedule, **changes: Any) -> PursuitResult:
    starts = schedule.positions[0].tolist()
    pursuers = tuple(Pursuer(f"scout {i}", (x, y)) for i, (x, y) in enumerate(starts))
    plain = PursuitResult(Status.DONE, "", schedule, pursuers, 1, len(pursuers) == 1)
    return replace(plain, **changes)


def write(
    path: Path,
    result: PursuitResult,
    plan: Any = ROOMS,
    known: bool = True,
    most: int | None = None,
) -> PursuitRun:
    problem = PursuitProblem(plan, result.pursuers[:1], known, most)
    digest = record_pursuit(
        path, problem, result, method="hand", settings={"depth": 2}, seed=7, compute_s=0.25
    )
    run = read_pursuit(path)
    assert run.digest == digest
    assert run.intact
    return run


@pytest.fixture
def good(tmp_path: Path) -> PursuitRun:
    return write(tmp_path / "good.mcap", result_of(timed(LEFT_TO_RIGHT)))


def test_a_run_is_read_as_it_was_written(good: PursuitRun) -> None:
    assert good.header["settings"] == {"depth": 2}
    assert good.header["seed"] == 7
    assert [leg.after[0].tolist() for leg in good.legs] == [list(at) for at in LEFT_TO_RIGHT[1:]]
    assert good.result is not None
    assert good.result["status"] == "done"
    assert isinstance(read_run(good.path), PursuitRun)
    with pytest.raises(InputError, match="job 'pursue'"):
        read_exploration(good.path)


def test_others_read_it_with_the_definitions_inside(good: PursuitRun) -> None:
    topics: dict[str, list[Any]] = {}
    with AnyReader([good.path]) as reader:
        for connection, time_ns, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            topics.setdefault(connection.topic, []).append((time_ns, message))
    (walls,) = topics["/floor"][0][1].markers
    assert [(point.x, point.y) for point in walls.points[:-1]] == [
        tuple(corner) for corner in ROOMS.outer.tolist()
    ]
    poses = topics["/scout_0/pose"]
    assert len(poses) == len(topics["/tf"]) > len(LEFT_TO_RIGHT)
    time_ns, last = poses[-1]
    assert time_ns == round(good.legs[-1].end_s * 1e9)
    assert (last.pose.position.x, last.pose.position.y) == RIGHT
    legs = [message for _, message in topics["/conav/leg"]]
    assert [leg.end_s for leg in legs] == [leg.end_s for leg in good.legs]


def test_the_same_run_has_the_same_digest(tmp_path: Path, good: PursuitRun) -> None:
    again = write(tmp_path / "again.mcap", result_of(timed(LEFT_TO_RIGHT)))
    assert again.digest == good.digest
    other = write(tmp_path / "other.mcap", result_of(timed(LEFT_TO_RIGHT), lower_bound=0))
    assert other.digest != good.digest


def test_a_good_run_is_accepted(good: PursuitRun) -> None:
    report = verify_pursuit(good)
    assert report.accepted
    assert report.found.verdict is Verdict.CAPTURED
    assert report.found.certificate is not None
    assert report.found.certificate["run"] == good.digest
    assert report.lines()[-1].startswith("accepted")


def test_saying_done_when_somebody_escapes_is_rejected(tmp_path: Path) -> None:
    schedule = timed([LEFT, DOORS, (25, 1.5), RIGHT])
    claimed = verify_pursuit(write(tmp_path / "a.mcap", result_of(schedule)))
    assert claimed.broken() == ("capture",)
    assert claimed.found.escape is not None
    assert claimed.summary()["escape"]["times_s"][-1] == schedule.times[-1]
    humble = result_of(schedule, status=Status.STUCK, reason="no way", minimal_proved=False)
    assert verify_pursuit(write(tmp_path / "b.mcap", humble)).accepted


Change = Callable[[PursuitRun], PursuitRun]


def _leg(run: PursuitRun, k: int, **changes: Any) -> PursuitRun:
    legs = list(run.legs)
    legs[k] = legs[k]._replace(**changes)
    return replace(run, legs=legs)


def _header(key: str, value: Any) -> Change:
    return lambda run: replace(run, header={**run.header, key: value})


def _pursuer(**changes: Any) -> Change:
    def change(run: PursuitRun) -> PursuitRun:
        sent = [{**run.header["pursuers"][0], **changes}]
        return replace(run, header={**run.header, "pursuers": sent})

    return change


def _result(key: str, value: Any) -> Change:
    return lambda run: replace(run, result={**(run.result or {}), key: value})


def _through_a_wall(run: PursuitRun) -> PursuitRun:
    legs = list(run.legs)
    place = np.array([[20.0, -3.0]])
    legs[2] = legs[2]._replace(after=place)
    legs[3] = legs[3]._replace(before=place)
    return replace(run, legs=legs)


TAMPERED: dict[str, tuple[Change, str]] = {
    "a leg is missing": (lambda run: replace(run, legs=run.legs[:2] + run.legs[3:]), "form"),
    "no leg is left": (lambda run: replace(run, legs=[]), "form"),
    "somebody jumps": (lambda run: _leg(run, 1, before=np.array([[5.0, 2.0]])), "form"),
    "time goes back": (lambda run: _leg(run, 1, end_s=0.5), "form"),
    "a number is none": (lambda run: _leg(run, 5, after=np.array([[np.nan, 6.0]])), "form"),
    "the last leg is missing": (lambda run: replace(run, legs=run.legs[:-1]), "capture"),
    "it blinks": (lambda run: _leg(run, 2, active=np.array([False])), "starts"),
    "another start": (_pursuer(start=[5.0, 6.5]), "starts"),
    "too many": (lambda run: _header("most", 1)(_header("begin_with", 2)(run)), "starts"),
    "slower": (_pursuer(speed_mps=0.9), "speed"),
    "a short battery": (_pursuer(reach_m=20.0), "reach"),
    "through a wall": (_through_a_wall, "walls"),
    "blind": (_pursuer(range_m=2.0), "capture"),
    "another distance": (_result("distance_m", 30.0), "result"),
    "another time": (_result("time_s", 1.0), "result"),
    "another number of legs": (_result("legs", 9), "result"),
    "a bound above the team": (_result("lower_bound", 2), "result"),
    "a minimum without a bound": (_result("lower_bound", 0), "result"),
}


@pytest.mark.parametrize("what", TAMPERED)
def test_tampered_runs_are_rejected(good: PursuitRun, what: str) -> None:
    change, check = TAMPERED[what]
    assert check in verify_pursuit(change(good)).broken()


@pytest.mark.parametrize(
    "change",
    [
        _header("floor", {"name": "x", "outer": [[0, 0], [1, 1]], "holes": []}),
        _header("floor", None),
        _header("known", "yes"),
        _header("pursuers", []),
        _pursuer(speed_mps=-1.0),
        _pursuer(range_m=True),
    ],
)
def test_headers_that_are_none(good: PursuitRun, change: Change) -> None:
    with pytest.raises(InputError):
        verify_pursuit(change(good))


def test_a_run_cut_short_is_judged_as_far_as_it_goes(tmp_path: Path, good: PursuitRun) -> None:
    data = good.path.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: len(data) * 2 // 3])
    run = read_pursuit(cut)
    report = verify_pursuit(run)
    assert not report.intact or report.finished
    assert report.accepted or report.broken() == ("form",)


def _box(x0: float, y0: float, x1: float, y1: float, clear: bool) -> HiddenRegion:
    return HiddenRegion(np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]), (), clear)


def _rooms_after_the_second_leg(middle: bool, right: bool) -> dict[int, tuple[HiddenRegion, ...]]:
    """What a team says when it stands before the middle room's door, left room cleared."""
    return {
        1: (
            _box(1, 3, 9, 11, clear=True),
            _box(10, -8, 18, 0, clear=middle),
            _box(21, 3, 29, 11, clear=right),
        )
    }


@pytest.mark.parametrize(
    ("beliefs", "holds"),
    [
        (_rooms_after_the_second_leg(False, False), True),
        (_rooms_after_the_second_leg(True, False), False),
        (_rooms_after_the_second_leg(False, True), False),
        ({1: ()}, False),  # what is not named is taken for clear
        ({5: ()}, True),
        ({1: (_box(0, -8, 30, 11, clear=False),)}, True),  # too careful is not wrong
        ({5: (_box(0, -8, 30, 11, clear=False),)}, False),  # but does not go with done
    ],
)
def test_beliefs_are_compared_with_the_truth(
    tmp_path: Path, beliefs: dict[int, tuple[HiddenRegion, ...]], holds: bool
) -> None:
    run = write(tmp_path / "run.mcap", result_of(timed(LEFT_TO_RIGHT), beliefs=beliefs))
    assert {leg: len(regions) for leg, regions in run.beliefs.items()} == {
        leg: len(regions) for leg, regions in beliefs.items()
    }
    report = verify_pursuit(run)
    assert report.broken() == (() if holds else ("beliefs",))
    assert report.open_beliefs == 0


def test_on_an_unknown_floor_nobody_need_name_what_nobody_saw(tmp_path: Path) -> None:
    # From the left room the team knows of no other rooms; the corridor below the door it names.
    beliefs = {0: (_box(0, 0, 30, 3, clear=False),)}
    result = result_of(timed(LEFT_TO_RIGHT[:2]), beliefs=beliefs, status=Status.STUCK)
    unknown = write(tmp_path / "a.mcap", result, known=False)
    assert verify_pursuit(unknown).accepted
    known = write(tmp_path / "b.mcap", result)
    assert verify_pursuit(known).broken() == ("beliefs",)


def test_on_an_unknown_floor_nobody_drives_farther_than_somebody_saw(tmp_path: Path) -> None:
    schedule = timed([LEFT, DOORS, (9.0, 1.5), DOORS, (25.0, 1.5)])
    near = (Pursuer("near", LEFT, range_m=5.0),)
    stuck = result_of(schedule, status=Status.STUCK, pursuers=near, minimal_proved=False)
    assert verify_pursuit(write(tmp_path / "known.mcap", stuck)).accepted
    assert verify_pursuit(write(tmp_path / "a.mcap", stuck, known=False)).broken() == ("knowledge",)
    # Up to 14 m it had been seen from 9 m.
    back = timed([LEFT, DOORS, (9.0, 1.5), DOORS, (13.9, 1.5)])
    seen = replace(stuck, schedule=back)
    assert verify_pursuit(write(tmp_path / "b.mcap", seen, known=False)).accepted
    far = (Pursuer("far", LEFT),)
    free = replace(stuck, pursuers=far)
    assert verify_pursuit(write(tmp_path / "c.mcap", free, known=False)).accepted


def test_on_an_unknown_floor_no_more_is_explored_than_was_seen(tmp_path: Path) -> None:
    stuck = result_of(timed(LEFT_TO_RIGHT[:2]), status=Status.STUCK)
    for name, explored, broken in (
        ("a", None, ()),
        ("b", 0.5, ()),
        ("c", 0.9, ("knowledge",)),  # the middle and the right room were not seen
        ("d", "all", ("knowledge",)),
    ):
        told = replace(stuck, explored=explored)
        run = write(tmp_path / f"{name}.mcap", told, known=False)
        assert verify_pursuit(run).broken() == broken
        assert verify_pursuit(write(tmp_path / f"{name}_known.mcap", told)).accepted
    done = replace(stuck, status=Status.DONE, explored=0.5)
    report = verify_pursuit(write(tmp_path / "done.mcap", done, known=False))
    assert report.broken() == ("knowledge", "capture")


def test_tampered_certificates_do_not_hold(tmp_path: Path) -> None:
    corners: Way = [(1, 2), (4, 2), (4, 4), (2, 4), (2, 2)]
    run = write(tmp_path / "ring.mcap", result_of(timed([(2, 2)] * 5, corners)), RING)
    whole = json.loads(json.dumps(verify_pursuit(run).found.certificate))
    assert certificate_faults(whole) == []

    def changed(change: Callable[[dict[str, Any]], object]) -> list[str]:
        other = copy.deepcopy(whole)
        change(other)
        return certificate_faults(other)

    assert changed(lambda c: (c["pieces"].pop(0), c["layers"].pop(0)))
    assert changed(lambda c: (c["pieces"].pop(2), c["layers"].pop(2)))
    assert changed(
        lambda c: (c["pieces"].__delitem__(slice(2, 9)), c["layers"].__delitem__(slice(3, 9)))
    )
    assert changed(lambda c: c["layers"][0][0].update(contaminated=False))
    assert changed(lambda c: c["layers"][1].pop())
    assert changed(lambda c: c["pieces"][1]["pursuers"][1]["after"].__setitem__(1, 0))
    assert changed(lambda c: c["pieces"][0]["links"].__setitem__(0, [0] * 9))
    assert changed(lambda c: c["rings"][0].__setitem__(0, [-9, -9]))
    assert changed(lambda c: c["pieces"][1]["pursuers"].pop())
    assert changed(lambda c: c["pieces"][1]["pursuers"][0].update(before=[0.5, 1]))
    assert changed(lambda c: c.pop("rings"))
    tried = 0
    for k, layer in enumerate(whole["layers"]):
        for i, shadow in enumerate(layer):
            if shadow["contaminated"]:
                tried += 1
                assert changed(lambda c, k=k, i=i: c["layers"][k][i].update(contaminated=False))
    assert tried > 2


def test_paths_that_are_no_escapes(tmp_path: Path) -> None:
    schedule = timed([LEFT, DOORS, (25, 1.5), RIGHT])
    found = verify_pursuit(write(tmp_path / "a.mcap", result_of(schedule))).found.escape
    assert found is not None
    times, places = found.times, found.places

    def faults(t: Any, x: Any, ranges: tuple[float | None] = (None,)) -> list[str]:
        return escape_faults(ROOMS, schedule, ranges, evader_path(t, x))

    assert faults(times, places) == []
    assert faults(times[:-1], places[:-1])  # ends too soon
    assert faults(times[::-1], places)  # time goes back
    assert faults(times, places + np.array((0.0, 40.0)))  # outside
    assert faults([times[0], times[-1]], [(14, -5), (25, 8)])  # through walls
    assert faults([times[0], times[-1]], [(5, 8), (5, 8)])  # in plain sight
    assert faults([times[0], times[-1]], [(10.3, -2.4), (10.3, -2.4)]) == []  # beside a door
    assert faults([times[0], times[-1]], [(14, -7), (14, -7)])  # seen through the door
    assert faults([times[0], times[-1]], [(14, -7), (14, -7)], (5.0,)) == []  # but not from afar
    assert faults([times[0], times[-1]], [(np.nan, -7), (14, -7)])


def test_verify_writes_certificate_and_picture(
    tmp_path: Path, good: PursuitRun, capsys: pytest.CaptureFixture[str]
) -> None:
    proof, picture = tmp_path / "proof.json", tmp_path / "run.png"
    assert (
        command(["verify", str(good.path), "--certificate", str(proof), "--png", str(picture)]) == 0
    )
    assert "captured" in capsys.readouterr().out
    assert certificate_faults(json.loads(proof.read_text())) == []
    assert picture.read_bytes()[1:4] == b"PNG"
    assert command(["verify", str(good.path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "captured"


def test_verify_says_why_there_is_no_certificate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lap = timed([(1, 1), (5, 1), (5, 5), (1, 5), (1, 1)])
    run = write(tmp_path / "lap.mcap", result_of(lap), RING)
    picture = tmp_path / "escape.png"
    assert command(["verify", str(run.path), "--png", str(picture)]) == 1
    assert "escapes" in capsys.readouterr().out
    assert picture.exists()
    assert command(["verify", str(run.path), "--certificate", str(tmp_path / "no.json")]) == 2
    assert "only a capture has a certificate" in capsys.readouterr().err
    assert not (tmp_path / "no.json").exists()
