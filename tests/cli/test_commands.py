"""What the commands print, write and return."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import conav as library
from conav.cli.explore import parse_points, ratio_text
from conav.exploration.bounds.bounds import FinishBounds
from conav.exploration.catalogue import DEFAULT_STRATEGY
from conav.maps.ascii_art import parse_ascii

FAST = ("explore", "three-obstacles", "--robots", "2", "--seed", "3")

KEYS = {
    "job",
    "map",
    "strategy",
    "robots",
    "seed",
    "status",
    "steps",
    "time_s",
    "coverage",
    "t90_s",
    "t95_s",
    "t99_s",
    "t100_s",
    "lower_bound_s",
    "lower_bound_by",
    "upper_bound_s",
    "upper_bound_by",
    "ratio",
    "bounds",
    "path_m",
    "overlap",
    "balance",
    "messages",
    "bytes",
    "robot_events",
    "decision_ms",
    "compute_s",
    "run",
}
MORE = {"digest", "interrupted", "warnings"}


@pytest.fixture(autouse=True)
def compiled() -> None:
    """The notice about compiling comes only on a new machine; these tests are not about it."""
    library.explore("three-obstacles", robots=1, max_time_s=10)


def test_the_json_of_a_run(conav: Any) -> None:
    outcome = conav(*FAST, "--json", "--out", "run.mcap")
    assert outcome.code == 0
    assert outcome.err == ""
    assert outcome.out.count("\n") == 1
    summary = json.loads(outcome.out)
    assert set(summary) == KEYS | MORE
    assert summary["job"] == "explore"
    assert summary["map"] == "three-obstacles"
    assert (summary["strategy"], summary["robots"], summary["seed"]) == (DEFAULT_STRATEGY, 2, 3)
    assert summary["status"] == "done"
    assert summary["coverage"] == 1.0
    assert summary["t90_s"] <= summary["t95_s"] <= summary["t99_s"] <= summary["t100_s"]
    assert summary["t100_s"] == summary["time_s"]
    assert len(summary["path_m"]) == 2
    low, high = summary["ratio"]
    assert low == summary["t100_s"] / summary["upper_bound_s"] >= 1.0
    assert high == summary["t100_s"] / summary["lower_bound_s"] >= low
    assert summary["lower_bound_by"] in ("swath", "eccentricity", "witness")
    assert summary["upper_bound_by"] in ("known-map", "this-run")
    assert list(summary["bounds"]) == ["t90", "t95", "t99", "t100"]
    for name, bounds in summary["bounds"].items():
        assert set(bounds) == {key for key in KEYS if "bound_" in key} | {"ratio"}
        assert bounds["ratio"][1] == summary[f"{name}_s"] / bounds["lower_bound_s"]
    assert summary["bounds"]["t100"] == {key: summary[key] for key in summary["bounds"]["t100"]}
    assert set(summary["balance"]) == {"seen", "path"}
    assert {"mean", "p99", "max"} == set(summary["decision_ms"])
    assert summary["run"] == "run.mcap"
    assert summary["interrupted"] is False
    assert summary["warnings"] == []
    run = library.read_run("run.mcap")
    assert summary["digest"] == run.digest
    assert summary["steps"] == len(run.steps) - 1


def test_json_without_a_file(conav: Any) -> None:
    summary = json.loads(conav(*FAST, "--json").out)
    assert summary["run"] is None
    assert set(summary) == KEYS | MORE


def test_a_run_that_does_not_finish(conav: Any) -> None:
    outcome = conav(*FAST, "--json", "--max-time", "20")
    assert outcome.code == 1
    summary = json.loads(outcome.out)
    assert summary["status"] == "out_of_budget"
    assert summary["t100_s"] is None
    assert summary["time_s"] <= 20
    assert summary["ratio"] == [1.0, None]
    assert summary["upper_bound_s"] is None
    assert summary["lower_bound_s"] > 20
    assert conav(*FAST, "--max-time", "20", "--quiet").code == 1
    assert "out of budget" in conav(*FAST, "--max-time", "20").out


def test_the_summary_for_people(conav: Any) -> None:
    outcome = conav(*FAST, "--out", "run.mcap")
    assert outcome.code == 0
    assert outcome.err == ""
    first, second, *_ = outcome.out.splitlines()
    assert first == "three-obstacles, 40 x 40 m: 2 robots, lanes-and-pockets, seed 3"
    assert second.startswith("  done: 100 % of ")
    said = r"  [\d.]+ to [\d.]+ times the best possible time: no team takes less than [\d.]+ s, "
    assert re.search(said + r"one that knows the map took [\d.]+ s\n", outcome.out)
    assert "  run file: run.mcap" in outcome.out


def test_bounds_can_be_left_out_or_worked_on_longer(conav: Any) -> None:
    none = json.loads(conav(*FAST, "--json", "--bounds", "none").out)
    assert set(none) == KEYS | MORE
    assert all(none[key] is None for key in ("ratio", "bounds", "lower_bound_s", "lower_bound_by"))
    assert "possible" not in conav(*FAST, "--bounds", "none").out
    full = json.loads(conav(*FAST, "--json", "--bounds", "full").out)
    quick = json.loads(conav(*FAST, "--json").out)
    assert full["lower_bound_s"] >= quick["lower_bound_s"]
    assert full["bounds"]["t90"]["lower_bound_s"] >= quick["bounds"]["t90"]["lower_bound_s"]
    outcome = conav(*FAST, "--bounds", "some")
    assert outcome.code == 2
    assert outcome.err == ("conav: bounds 'some': is not known; use one of: quick, full, none\n")


def test_an_interrupt_while_bounds_are_found_keeps_the_run(
    conav: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*args: Any, **options: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr("conav.simulation.explore.finish_bounds", interrupted)
    outcome = conav(*FAST, "--json")
    assert outcome.code == 0
    summary = json.loads(outcome.out)
    assert (summary["status"], summary["ratio"]) == ("done", None)
    # Nobody sees them, nobody waits for them.
    assert conav(*FAST, "--quiet") == (0, "", "")


class Took:
    """What the wording needs of a run."""

    def __init__(self, time_s: float | None) -> None:
        self.time_s = time_s

    def ratios(self, bounds: FinishBounds) -> tuple[float, float]:
        return bounds.ratios_beyond(50.0) if self.time_s is None else bounds.ratios(self.time_s)


@pytest.mark.parametrize(
    ("time_s", "lower_s", "upper_s", "by", "said"),
    [
        (30.0, 16.0, 21.0, "known-map", "1.42 to 1.88 times the best possible time: no team takes"),
        (30.0, 16.0, 30.0, "this-run", "1 to 1.88 times the best possible time: no team takes"),
        (30.0, 16.0, 30.0, "this-run", "nothing faster is known"),
        (None, 16.0, 25.0, "known-map", "at least 2 times the best possible time"),
        (None, 60.0, None, None, "no team takes less than 60 s to see all, no run that saw all"),
        (16.0, 16.0, 16.0, "known-map", "the best possible time: no team takes less than 16 s"),
        (0.0, 0.0, 0.0, "this-run", "the best possible time: no team takes less than 0 s"),
    ],
)
def test_the_wording_of_ratios(
    time_s: float | None, lower_s: float, upper_s: float | None, by: str | None, said: str
) -> None:
    bounds = FinishBounds(
        *(1.0, 9, 9, lower_s, "swath", lower_s, 0.0, 0.0, (), 0, 9, 0, upper_s, by)
    )
    assert said in ratio_text(Took(time_s), bounds)


def test_quiet(conav: Any) -> None:
    outcome = conav(*FAST, "--quiet", "--out", "run.mcap")
    assert outcome == (0, "", "")
    assert library.read_run("run.mcap").intact
    # The answer that was asked for is still given.
    assert json.loads(conav(*FAST, "--quiet", "--json").out)["status"] == "done"


def test_warnings_go_to_standard_error(conav: Any) -> None:
    # The ground around the building is drawn free and is larger than what is inside.
    yard = ["." * 30] * 6
    house = ["." * 8 + "#" * 14 + "." * 8, *["." * 8 + "#" + "." * 12 + "#" + "." * 8] * 8]
    picture = [*yard, house[0], *house[1:], house[0], *yard]
    Path("house.txt").write_text("\n".join(picture) + "\n")
    assert parse_ascii("\n".join(picture)).rows == 22
    outcome = conav("explore", "house.txt", "--json", "--robots", "1", "--resolution", "1")
    assert outcome.code == 0
    (warning,) = json.loads(outcome.out)["warnings"]
    assert "--outside" in warning
    assert outcome.err == f"conav: warning: {warning}\n"
    assert conav("explore", "house.txt", "--quiet", "--robots", "1").err == ""
    assert conav("explore", "house.txt", "--outside", "--robots", "1").err == ""


def test_settings_reach_the_strategy(conav: Any) -> None:
    conav(*FAST, "--strategy", "nearest", "--set", "keep-goal=true", "--out", "run.mcap", "--quiet")
    assert library.read_run("run.mcap").header["settings"] == {"keep_goal": True}
    conav(*FAST, "--strategy", "nearest", "--set", "keep_goal=0", "--out", "run.mcap", "--quiet")
    assert library.read_run("run.mcap").header["settings"] == {"keep_goal": False}


def test_starts_may_be_negative(conav: Any) -> None:
    Path("map.yaml").write_text(
        "image: map.pgm\nresolution: 1.0\norigin: [-10.0, -5.0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )
    Path("map.pgm").write_bytes(b"P5\n20 10\n255\n" + b"\xfe" * 200)
    outcome = conav(
        *("explore", "map.yaml", "--robots", "2", "--starts", "-9.5,-4.5 -3,2", "--json"),
        *("--out", "run.mcap", "--range", "3"),
    )
    assert outcome.code == 0, outcome.err
    # One cell a robot may stand on is a metre wide, so these are cells of the pixels themselves.
    assert library.read_run("run.mcap").header["starts"] == [0, 7 * 20 + 7]


def test_points() -> None:
    assert parse_points("--starts", " 1,2;3,-4  5e-1,6 ") == [(1, 2), (3, -4), (0.5, 6)]


def test_the_list_of_maps(conav: Any) -> None:
    outcome = conav("maps")
    assert outcome.code == 0
    names = [item["name"] for item in json.loads(conav("maps", "--json").out)["builtin"]]
    assert {"office", "cave", "maze", "field", "three-obstacles"} <= set(names)
    for name in names:
        assert f"\n{name}: " in "\n" + outcome.out
    assert "conav explore office" in outcome.out


def test_what_a_map_holds(conav: Any) -> None:
    Path("room.txt").write_text("#####\n#..##\n#####\n")
    outcome = conav("maps", "room.txt", "--json", "--resolution", "0.5")
    assert outcome.code == 0
    assert outcome.out.count("\n") == 1
    facts = json.loads(outcome.out)
    assert (facts["rows"], facts["cols"], facts["resolution"]) == (3, 5, 0.5)
    assert facts["free_m2"] == 0.5
    assert facts["reachable_cells"] == 2
    text = conav("maps", "room.txt", "--resolution", "0.5").out
    assert "5 x 3 cells of 0.5 m" in text


def test_a_map_with_no_place_for_a_robot_is_still_described(conav: Any) -> None:
    Path("wall.txt").write_text("###\n###\n")
    facts = json.loads(conav("maps", "wall.txt", "--json").out)
    assert facts["reachable_cells"] == 0
    assert len(facts["warnings"]) == 1
    assert conav("maps", "wall.txt").code == 0


def test_floor_plans(conav: Any) -> None:
    outcome = conav("maps", "comb:2", "--json", "--out", "a.geojson", "--png", "a.png")
    assert outcome.code == 0
    facts = json.loads(outcome.out)
    assert (facts["vertices"], facts["reflex_vertices"], facts["holes"]) == (12, 4, 0)
    assert (facts["area_m2"], facts["bounds"]) == (13.0, [0, 0, 5, 5])
    assert (facts["written"], facts["picture"]) == (["a.geojson"], "a.png")
    assert Path("a.png").stat().st_size > 500
    text = conav("maps", "a.geojson").out
    assert "12 vertices, 4 of them reflex; no holes" in text
    assert "floor 13 m2, x 0 to 5 m, y 0 to 5 m: 5 x 5 m" in text
    names = [item["name"] for item in json.loads(conav("maps", "--json").out)["floor_plans"]]
    assert {"comb", "spider", "triples", "corridor-tree"} <= set(names)


def test_a_floor_plan_of_a_grid(conav: Any) -> None:
    Path("room.txt").write_text("#####\n#..##\n##..#\n##?##\n")
    facts = json.loads(conav("maps", "room.txt", "--floor-plan", "--json").out)
    assert facts["area_m2"] == 5
    assert "20.0% of the floor are unknown cells" in facts["warnings"][0]
    walled = conav(
        *("maps", "room.txt", "--floor-plan", "--unknown", "wall", "--evader-radius", "0.8"),
        *("--tolerance", "0.8", "--resolution", "1", "--json"),
    )
    facts = json.loads(walled.out)
    assert facts["area_m2"] < 4
    assert facts["warnings"] == []
    text = conav("maps", "room.txt", "--floor-plan", "--at", "1.5,2.5", "--out", "room.json").out
    assert "written: room.json" in text
    assert "warning: 20.0% of the floor" in text


def test_pictures_of_everything_built_in(conav: Any) -> None:
    Path("all").mkdir()
    assert conav("maps", "--png", "all").code == 0
    drawn = {path.stem for path in Path("all").iterdir()}
    assert {"office", "comb", "triples", "office-loops"} <= drawn


def test_maps_round_trip(conav: Any) -> None:
    outcome = conav("maps", "office", "--size", "12x9", "--seed", "4", "--out", "x.yaml", "--json")
    assert outcome.code == 0
    written = json.loads(outcome.out)["written"]
    assert sorted(Path(path).name for path in written) == ["x.pgm", "x.yaml"]
    made = library.builtin_map("office", width_m=12, height_m=9, seed=4)
    back = library.read_map(Path("x.yaml"))
    assert (back.cells == made.cells).all()
    assert (back.resolution, back.origin) == (made.resolution, made.origin)
    again = json.loads(conav("maps", "x.yaml", "--json").out)
    first = json.loads(outcome.out)
    same = set(first) - {"map", "written", "warnings"}
    assert {key: again[key] for key in same} == {key: first[key] for key in same}
    assert conav("explore", "x.yaml", "--max-time", "5", "--quiet").code in (0, 1)


def test_verify(conav: Any) -> None:
    conav(*FAST, "--out", "run.mcap", "--quiet")
    outcome = conav("verify", "run.mcap")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.splitlines()[-1].startswith("accepted: run.mcap")
    report = json.loads(conav("verify", "run.mcap", "--json").out)
    assert report["accepted"] is True
    assert report["digest"] == library.read_run("run.mcap").digest
    tamper(Path("run.mcap"))
    outcome = conav("verify", "run.mcap")
    assert outcome.code == 1
    assert "metrics: BROKEN 1 times" in outcome.out
    assert json.loads(conav("verify", "run.mcap", "--json").out)["accepted"] is False


def tamper(path: Path) -> None:
    """Write the run anew with a better time than it had."""
    from conav.runs.exploration_writer import ExplorationWriter

    run = library.read_run(path)
    assert run.result is not None
    run.result["metrics"]["t90_s"] = 1.0
    with ExplorationWriter(path) as writer:
        writer.header(run.header)
        writer.world(run.cells, run.resolution, run.origin)
        for step in run.steps:
            writer.step(step.step, step)
        writer.result(len(run.steps), run.result)


def test_repair(conav: Any) -> None:
    conav(*FAST, "--out", "run.mcap", "--quiet")
    data = Path("run.mcap").read_bytes()
    Path("run.mcap").write_bytes(data[: len(data) * 3 // 4])
    assert "cut short" in conav("verify", "run.mcap").out
    outcome = conav("repair", "run.mcap", "--out", "whole.mcap")
    assert (outcome.code, outcome.err) == (0, "")
    count = int(outcome.out.removeprefix("whole.mcap: ").removesuffix(" messages saved\n"))
    assert count > 3
    assert library.read_run("whole.mcap").digest == library.read_run("run.mcap").digest
    assert conav("verify", "whole.mcap").code == 0
    outcome = conav("repair", "run.mcap", "--out", "run.mcap")
    assert outcome.code == 2
    assert "is the damaged file itself" in outcome.err


def test_pictures_are_written(conav: Any) -> None:
    outcome = conav(*FAST, "--png", "end.png", "--gif", "run.gif", "--json")
    assert outcome.code == 0
    assert json.loads(outcome.out)["run"] is None  # the run file was a temporary one
    assert Path("end.png").read_bytes().startswith(b"\x89PNG")
    assert Path("run.gif").read_bytes().startswith(b"GIF8")


def test_names_outside_the_terminals_encoding(tmp_path: Path) -> None:
    if sys.platform != "linux":
        pytest.skip("file names of any bytes")
    name = os.fsdecode(b"m\xffp.txt")
    (tmp_path / name).write_text("....\n....\n")
    done = subprocess.run(
        [sys.executable, "-m", "conav", "explore", name, "--robots", "1", "--quiet"],
        cwd=tmp_path,
        capture_output=True,
        timeout=60,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    done = subprocess.run(
        [sys.executable, "-m", "conav", "maps", name], cwd=tmp_path, capture_output=True, timeout=60
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"m\\udcffp" in done.stdout


def test_a_reader_that_goes_away(tmp_path: Path) -> None:
    done = subprocess.run(
        f'"{sys.executable}" -m conav maps | head -n 1; echo "${{PIPESTATUS[0]}}"',
        shell=True,
        executable="/bin/bash",
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.stderr == ""
    assert done.stdout.splitlines()[-1] == "0"


def test_help_and_version(conav: Any) -> None:
    outcome = conav("--help")
    assert outcome.code == 0
    for command in ("explore", "maps", "verify", "repair"):
        assert command in outcome.out
    assert conav("--version").out.strip() == library.__version__
    text = conav("explore", "--help").out
    for option in ("--robots", "--starts", "--radio", "--max-time", "--out", "--json", "--quiet"):
        assert option in text
