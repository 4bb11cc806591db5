"""The command: exit codes, one-line errors, JSON, and what it writes."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import conav
from conav.cli import run

KEYS = {
    *("job", "map", "strategy", "robots", "seed", "status", "steps", "time_s", "coverage"),
    *("t90_s", "t95_s", "t99_s", "t100_s", "path_m", "overlap", "balance", "messages", "bytes"),
    *("decision_ms", "compute_s", "run"),
}
QUICK = ("explore", "maze", "--robots", "2", "--seed", "3")


def test_summary_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(QUICK) == 0
    out, err = capsys.readouterr()
    assert "done: 100 %" in out
    assert "2 robots" in out
    assert err == ""


def test_json_is_one_object(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    assert run([*QUICK, "--json", "--out", str(path)]) == 0
    content: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert set(content) >= KEYS
    assert content["status"] == "done"
    assert content["coverage"] == 1.0
    assert content["run"] == str(path)
    assert len(content["path_m"]) == 2
    assert set(content["decision_ms"]) == {"mean", "p99", "max"}


def test_quiet_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*QUICK, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_not_done_is_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*QUICK, "--max-time", "3"]) == 1
    assert "out of budget" in capsys.readouterr().out


def test_pictures_without_a_run_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    png, gif = tmp_path / "a.png", tmp_path / "a.gif"
    assert run([*QUICK, "--png", str(png), "--gif", str(gif), "--json"]) == 0
    assert png.read_bytes().startswith(b"\x89PNG")
    assert gif.read_bytes().startswith(b"GIF8")
    assert json.loads(capsys.readouterr().out)["run"] is None


def test_every_problem_option_is_heard(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "run.mcap"
    options = (
        *("--range", "3", "--cell", "0.2", "--radius", "0.05", "--speed", "1.5"),
        *("--motion", "4-connected", "--sensor", "disc", "--radio", "4", "--max-time", "500"),
        *("--starts", "0.7,0.7 1.3,0.7", "--set", "keep_goal=true", "--outside"),
    )
    run([*QUICK, *options, "--out", str(path), "--quiet"])
    header = conav.read_run(path).header
    robot = header["robots"][0]
    assert robot["sensor"] == {"name": "disc", "occlusion": False, "range_m": 3.0}
    assert header["cell_m"] == 0.2
    assert robot["radius_m"] == 0.05
    assert robot["speed_mps"] == 1.5
    assert robot["motion"]["name"] == "4-connected"
    assert robot["radio"] == {"name": "limited", "range_m": 4.0}
    assert header["max_time_s"] == 500.0
    assert header["settings"] == {"keep_goal": True}
    assert header["seed"] == 3
    assert len(header["starts"]) == 2
    del capsys


@pytest.mark.parametrize(
    ("arguments", "place", "remedy"),
    [
        (("explore",), "MAP", "--help"),
        (("explore", "ofice"), "ofice", "office"),
        (("explore", "none.yaml"), "none.yaml", ""),
        (("explore", "maze", "--strategy", "nearst"), "nearst", "nearest"),
        (("explore", "maze", "--set", "keep_gaol=1"), "keep_gaol", "keep_goal"),
        (("explore", "maze", "--set", "keep_goal=perhaps"), "keep_goal", "nearest.md"),
        (("explore", "maze", "--set", "keep_goal"), "--set keep_goal", "name=value"),
        (("explore", "maze", "--robots", "0"), "robots", "1"),
        (("explore", "maze", "--robots", "-1"), "robots", "1"),
        (("explore", "maze", "--robots", "many"), "robots", ""),
        (("explore", "maze", "--robots", "1000", "--cell", "1"), "maze", "fewer"),
        (("explore", "maze", "--cell", "0"), "cell", ""),
        (("explore", "maze", "--cell", "nan"), "cell", ""),
        (("explore", "maze", "--cell", "50"), "cell", "smaller"),
        (("explore", "maze", "--range", "nan"), "range", ""),
        (("explore", "maze", "--radius", "9"), "maze", "radius"),
        (("explore", "maze", "--speed", "0"), "speed", ""),
        (("explore", "maze", "--motion", "fly"), "fly", "8-connected"),
        (("explore", "maze", "--sensor", "nose"), "nose", "range"),
        (("explore", "maze", "--radio", "loud"), "loud", "perfect"),
        (("explore", "maze", "--starts", "1;2"), "--starts", "x,y"),
        (("explore", "maze", "--starts", "0.7,0.7"), "starts", "one x,y per robot"),
        (("explore", "maze", "--robots", "1", "--starts", "900,1"), "900,1", "metres"),
        (("explore", "maze", "--robots", "1", "--starts", "0.01,1"), "0.01,1", "nearest place"),
        (("explore", "maze", "--gif", "a.png"), "a.png", ".gif"),
        (("explore", "maze", "--out", "no/such/folder/run.mcap"), "run.mcap", "folder"),
        (("explore", "maze", "--colour", "red"), "--colour", "--help"),
        (("maps", "ofice"), "ofice", "office"),
        (("maps", "office", "--size", "wide"), "--size", "40x25"),
        (("maps", "office", "--size", "1x1"), "office", ""),
        (("maps", "--out", "x.yaml"), "--out", "conav maps"),
        (("verify", "none.mcap"), "none.mcap", ""),
        (("repair", "none.mcap", "--out", "x.mcap"), "none.mcap", ""),
        (("fly",), "fly", "--help"),
    ],
    ids=lambda value: "_".join(value) if isinstance(value, tuple) else None,
)
def test_bad_input_is_one_line(
    arguments: tuple[str, ...],
    place: str,
    remedy: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("conav: ")
    assert len(err.strip().splitlines()) == 1
    assert place in err
    assert remedy in err
    assert list(tmp_path.iterdir()) == []


def test_maps_lists_and_draws(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["maps"]) == 0
    out = capsys.readouterr().out
    for name in ("office", "cave", "maze", "field", "three-obstacles"):
        assert f"{name}: " in out
    assert out.count("#") > 1000


def test_maps_facts_and_conversion(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "floor.yaml"
    assert run(["maps", "office", "--size", "12x9", "--out", str(target), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["cols"], facts["rows"], facts["resolution"]) == (120, 90, 0.1)
    assert facts["reachable_m2"] <= facts["free_m2"]
    assert facts["free_m2"] + facts["occupied_m2"] == pytest.approx(108)
    again = conav.read_map(target)
    assert (again.cells == conav.builtin_map("office", width_m=12, height_m=9).cells).all()


def test_verify_and_repair(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, mended = tmp_path / "run.mcap", tmp_path / "mended.mcap"
    assert run([*QUICK, "--quiet", "--out", str(path)]) == 0
    assert run(["verify", str(path)]) == 0
    assert "accepted" in capsys.readouterr().out
    assert run(["verify", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["accepted"] is True
    path.write_bytes(path.read_bytes()[:-300])
    assert run(["repair", str(path), "--out", str(mended)]) == 0
    assert run(["verify", str(mended)]) == 0
    assert run(["repair", str(mended), "--out", str(mended)]) == 2


def test_a_rejected_run_is_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from conav.runs import reader

    path = tmp_path / "run.mcap"
    run([*QUICK, "--quiet", "--out", str(path)])
    read = reader.read_run

    def tampered(given: Any) -> Any:
        found = read(given)
        assert found.result is not None
        found.result["metrics"]["coverage"] = 0.5
        return found

    monkeypatch.setattr(reader, "read_run", tampered)
    assert run(["verify", str(path)]) == 1
    assert "REJECTED" in capsys.readouterr().out


@pytest.mark.skipif(os.name != "posix", reason="sends a POSIX signal")
def test_ctrl_c_keeps_what_there_is(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "conav", "explore", "field", "--robots", "40"),
            *("--radio", "10", "--range", "4", "--cell", "0.5", "--out", str(path)),
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 120
    while not (path.exists() and path.stat().st_size > 100_000):
        assert time.monotonic() < deadline
        assert process.poll() is None, process.communicate()
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 1, err
    assert "interrupted" in out
    assert "Traceback" not in err
    run_file = conav.read_run(path)
    assert run_file.intact
    assert run_file.result is not None
    report = conav.verify_exploration(run_file)
    assert report.accepted, report.lines()


@pytest.mark.parametrize(
    ("code", "unwanted"),
    [
        ("import conav", ("numpy", "numba", "scipy", "rich", "PIL", "cyclopts")),
        (
            "from conav.cli import run; run(['--help'])",
            ("numpy", "numba", "scipy", "pydantic", "PIL"),
        ),
    ],
)
def test_starting_loads_little(code: str, unwanted: tuple[str, ...]) -> None:
    check = f"{code}\nimport sys\nprint([m for m in {unwanted!r} if m in sys.modules])"
    result = subprocess.run(
        [sys.executable, "-c", check], check=True, capture_output=True, text=True
    )
    assert result.stdout.splitlines()[-1] == "[]"
