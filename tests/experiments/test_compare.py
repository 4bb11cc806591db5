"""`conav compare`: every run once, none lost, none left out, and numbers that a hand can check."""

import csv
import json
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from math import exp, inf, log
from pathlib import Path
from time import monotonic, sleep
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import conav
from conav.cli import run
from conav.errors import InputError
from conav.experiments.compare import compare as module
from conav.experiments.compare.arguments import make_study
from conav.experiments.compare.cases import Case, Group, World
from conav.experiments.compare.compare import Comparison, compare
from conav.experiments.compare.figures import coverage_at
from conav.experiments.compare.journal import JOURNAL, Journal
from conav.experiments.compare.outcome import Failure, Outcome
from conav.experiments.compare.run_case import Runner
from conav.experiments.compare.statistics import median_interval, ratio_bootstrap
from conav.experiments.compare.tables import tables, totals
from conav.experiments.compare.wording import (
    aligned,
    group_rows,
    markdown,
    number,
    ratio_text,
    times_text,
    total_rows,
)
from conav.maps.ascii_art import parse_ascii

ROOMS = """
#######################
#..........#..........#
#..........#..........#
#.....................#
#..........#..........#
#..........#....#.....#
#..........#....#.....#
#######################
"""
GRID = parse_ascii(ROOMS.strip(), resolution=0.5, name="rooms")
CROSSING = """
import os
from dataclasses import dataclass
from typing import Any

from conav.exploration.types import Action


@dataclass(frozen=True)
class Crash:
    \"\"\"Stays where it is, but on seeds whose first draw is small.\"\"\"

    hard: bool = False

    def start(self, view: Any, rng: Any) -> float:
        return float(rng.random())

    def step(self, memory: float, view: Any, inbox: Any, rng: Any) -> Any:
        if view.step == 3 and memory < 0.4:
            if self.hard:
                os._exit(7)
            raise ZeroDivisionError("nothing to share")
        return memory, Action(finished=view.step == 5), ()
"""

CRASHES = [1]
"""Seeds below 3 at which one robot's first draw is that small."""


@pytest.fixture(autouse=True)
def _heard_interrupts() -> Iterator[None]:
    """Interrupts as in a terminal: started in the background of a script, tests find them ignored,
    and so would the processes they start.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def crash(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A class of strategies that other processes can import."""
    (tmp_path / "modules").mkdir()
    (tmp_path / "modules" / "conav_test_crash.py").write_text(CROSSING)
    monkeypatch.syspath_prepend(tmp_path / "modules")
    import conav_test_crash  # type: ignore[import-not-found]

    yield conav_test_crash.Crash
    del sys.modules["conav_test_crash"]


def small(folder: Path, **changed: Any) -> Comparison:
    options: dict[str, Any] = {"robots": (2,), "runs": 2, "jobs": 1, "plots": False}
    options |= {"max_time_s": 600.0, "bounds": "none"}  # bounds have tests of their own
    return compare(
        changed.pop("maps", [GRID]),
        changed.pop("strategies", ["nearest", "keep=nearest"]),
        folder,
        **{**options, "settings": {"keep": {"keep_goal": True}}, **changed},
    )


def rows(folder: Path, name: str = "results.csv") -> list[dict[str, str]]:
    with (folder / name).open() as stream:
        return list(csv.DictReader(stream))


def lines(folder: Path) -> list[str]:
    return (folder / JOURNAL).read_text().splitlines()


def outcome(percent_s: dict[int, float], *, step_s: float = 0.5, **changed: Any) -> Outcome:
    """A run that got to each percentage at the time of the next one given."""
    times = tuple(
        next((percent_s[p] for p in sorted(percent_s) if p >= percent), None)
        for percent in range(1, 101)
    )
    values: dict[str, Any] = {
        "status": "done" if 100 in percent_s else "out_of_budget",
        "steps": 10,
        "step_s": step_s,
        "time_s": 5.0,
        "coverage": 1.0,
        "percent_s": times,
        "path_m": (1.0, 2.0),
        "overlap": 0.5,
        "balance_seen": 0.1,
        "balance_path": 0.2,
        "messages": 4,
        "bytes": 1000,
        "observable_m2": 20.0,
        "warnings": (),
        "compute_s": 0.1,
        "decision_ms_mean": 0.1,
        "decision_ms_p99": 0.2,
        "decision_ms_max": 0.3,
    }
    return Outcome(**{**values, **changed})


# What is run


def test_a_row_is_what_explore_says(tmp_path: Path) -> None:
    made = small(
        tmp_path,
        maps=["maze", GRID],
        strategies=["nearest", "potential"],
        robots=(1, 3),
        ranges_m=(2.0, 4.0),
        radios=("perfect", 3),
        runs=1,
        seed=5,
        settings={"potential": {"epsilon": 0.2}},
        motion="4-connected",
        speed_mps=1.0,
        max_time_s=40.0,
    )
    assert made.played == len(made.results) == len(rows(tmp_path)) == 2 * 2 * 2 * 2 * 2
    for case, row in zip(made.results, rows(tmp_path), strict=True):
        done = conav.explore(
            "maze" if case.map == "maze" else GRID,
            strategy=case.strategy,
            settings={"epsilon": 0.2} if case.strategy == "potential" else {},
            robots=case.robots,
            range_m=case.range_m,
            radio=case.radio,
            seed=5,
            motion="4-connected",
            speed_mps=1.0,
            max_time_s=40.0,
        )
        said = {
            key: str(value) if value is not None else "" for key, value in done.summary().items()
        }
        for name in (
            *("map", "robots", "strategy", "seed", "status", "steps", "time_s", "coverage"),
            *("t90_s", "t95_s", "t99_s", "t100_s", "overlap", "messages", "bytes"),
        ):
            assert row[name] == said[name], (case, name)
        assert float(row["balance_seen"]) == done.metrics.balance["seen"]
        assert float(row["path_m"]) == pytest.approx(sum(done.metrics.path_m))
        assert row["radio"] == case.radio


def test_times_to_every_percent_are_exact(tmp_path: Path) -> None:
    made = small(tmp_path, runs=1, strategies=["nearest"], settings={})
    (case,) = made.results
    problem, _ = Runner(made.study).problem(case)
    from conav.exploration.catalogue import make_strategy
    from conav.simulation.run_exploration import run_exploration

    result = run_exploration(problem, make_strategy("nearest"), name="nearest")
    for percent, time in enumerate(made.results[case].percent_s, 1):
        step = next(
            k for k, n in enumerate(result.covered) if 100 * n >= percent * result.observable
        )
        assert time == pytest.approx(step * problem.step_s)
    assert [float(rows(tmp_path, "coverage.csv")[0][f"t{p}_s"]) for p in range(1, 101)] == list(
        made.results[case].percent_s
    )


def test_any_number_of_processes_gives_the_same_files(tmp_path: Path) -> None:
    maps = ["maze", GRID]
    small(tmp_path / "a", maps=maps, runs=3, jobs=1, max_time_s=60.0, bounds="quick")
    small(tmp_path / "b", maps=maps, runs=3, jobs=2, max_time_s=60.0, bounds="quick")
    for name in ("results.csv", "coverage.csv", "results.parquet"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    keys = [{json.dumps(json.loads(x)["case"]) for x in lines(tmp_path / end)} for end in "ab"]
    assert keys[0] == keys[1]
    assert len(keys[0]) == 12 + 6  # bounds for each map and seed
    assert [row["compute_s"] != "" for row in rows(tmp_path / "b", "timing.csv")] == [True] * 12


def test_only_what_is_missing_is_played(tmp_path: Path) -> None:
    assert small(tmp_path).played == 4
    before = lines(tmp_path)
    again = small(tmp_path)
    assert (again.played, len(again.results)) == (0, 4)
    assert small(tmp_path, runs=3).played == 2
    strategies = ["nearest", "keep=nearest", "potential"]
    assert small(tmp_path, strategies=strategies).played == 2
    assert small(tmp_path, strategies=strategies, robots=(1, 2), jobs=2).played == 6
    # Other settings are another run, another name is not.
    assert small(tmp_path, settings={}).played == 0
    assert small(tmp_path, radius_m=0.15).played == 4
    assert small(tmp_path, seed=1, runs=2).played == 0
    assert lines(tmp_path)[:4] == before
    assert len(lines(tmp_path)) == len(set(lines(tmp_path))) == 4 + 2 + 2 + 6 + 4
    made = small(tmp_path)
    assert [row["seed"] for row in rows(tmp_path)] == ["0", "1", "0", "1"]
    assert len(made.results) == 4


def test_another_map_of_that_name_is_another_run(tmp_path: Path) -> None:
    small(tmp_path)
    other = parse_ascii(ROOMS.strip().replace("....#.....#", "..........#"), resolution=0.5)
    assert small(tmp_path, maps=[conav.OccupancyGrid(other.cells, 0.5, name="rooms")]).played == 4


def test_a_map_may_say_its_own_scale(tmp_path: Path) -> None:
    file = tmp_path / "rooms.txt"
    file.write_text(ROOMS.strip() + "\n")
    made = study(maps=[f"{file}@0.5", f"{file}@0.25"])
    assert [place.name for place in made.maps] == ["rooms", f"{file}@0.25"]
    assert made.maps[0].content == study(maps=[GRID]).maps[0].content
    assert made.maps[1].content != made.maps[0].content
    assert small(tmp_path, maps=[f"{file}@0.5"]).played == 4
    assert f"{file}@0.5" in (tmp_path / "README.md").read_text()
    odd = tmp_path / "odd@2.txt"
    odd.write_text(ROOMS.strip() + "\n")
    assert [place.name for place in study(maps=[str(odd)]).maps] == ["odd@2"]
    with pytest.raises(InputError, match="metres per cell above 0"):
        study(maps=[f"{file}@-1"])


def test_other_code_is_another_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from conav.experiments.compare import source

    before = {name: study(strategies=[name]).teams[0].code for name in ("nearest", "potential")}
    for changed, moved in (
        ("conav.exploration.viewpoints", {"nearest"}),  # which it imports
        ("conav.exploration.turn_sequences", {"potential"}),
        ("conav.simulation.traffic", {"nearest", "potential"}),
        ("conav.exploration.catalogue", set()),  # a further strategy does not matter
        ("conav.pictures.still", set()),
    ):
        true_source = source._source
        with monkeypatch.context() as patch:
            patch.setattr(
                source,
                "_source",
                lambda name, changed=changed, true=true_source: (
                    true(name) + b"#" * (name == changed)
                ),
            )
            after = {name: study(strategies=[name]).teams[0].code for name in before}
        assert {name for name in before if after[name] != before[name]} == moved, changed
    assert source.source_hash("no.such.module") != source.source_hash("__main__")


def test_strategies_of_ones_own(tmp_path: Path, crash: Any) -> None:
    made = small(
        tmp_path,
        strategies={"mine": crash(), "near": "nearest"},
        settings={"near": {"keep_goal": True}},
        robots=(1,),
        jobs=2,
    )
    assert {(case.strategy, case.seed) for case in made.failures} == {("mine", k) for k in CRASHES}
    assert "from Python" in (tmp_path / "README.md").read_text()

    class Local:
        start = step = None

    with pytest.raises(InputError, match=r"cannot be sent to another process.*jobs=1"):
        small(tmp_path, strategies={"local": Local()}, settings={}, runs=3, jobs=2)


@pytest.mark.parametrize(("jobs", "hard"), [(1, False), (2, False), (2, True)])
def test_a_run_that_crashes_is_a_row(tmp_path: Path, crash: Any, jobs: int, hard: bool) -> None:
    strategies = {"near": "nearest", "mine": crash(hard=hard)}
    options: dict[str, Any] = {"strategies": strategies, "settings": {}, "robots": (1,)}
    made = small(tmp_path, **options, runs=3, jobs=jobs)
    assert [case.seed for case in made.failures] == CRASHES
    message = "ended (exit code 7)" if hard else "ZeroDivisionError: nothing to share (conav_test"
    assert all(message in failure.message for failure in made.failures.values())
    found = [row for row in rows(tmp_path) if row["status"] == "failed"]
    assert [int(row["seed"]) for row in found] == CRASHES
    assert all(message in row["message"] and row["t90_s"] == "" for row in found)
    line = next(line for line in made.tables[0].lines if line.strategy == "mine")
    assert (line.runs, line.failed) == (3 - len(CRASHES), len(CRASHES))
    assert line.ratio is not None
    assert line.ratio.estimate.n == line.runs
    assert message in (tmp_path / "README.md").read_text()
    if not hard:
        assert small(tmp_path, **options, runs=3, jobs=1).played == len(CRASHES)  # tried again


def test_a_process_that_cannot_begin_ends_the_comparison(
    tmp_path: Path, crash: Any, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    mine = crash()
    (tmp_path / "modules" / "conav_test_crash.py").unlink()
    with pytest.raises(InputError, match="ended before it began"):
        small(tmp_path / "out", strategies={"mine": mine}, settings={}, runs=3, jobs=2)
    assert "conav_test_crash" in capfd.readouterr().err


# What is kept


def started(folder: Path, *more: str) -> "subprocess.Popen[str]":
    command = ["compare", "maze", "--strategies", "nearest,potential", "--runs", "8", "--no-plots"]
    command += ["--bounds", "none"]
    return subprocess.Popen(
        [sys.executable, "-m", "conav", *command, "--max-time", "600", "--out", "out", *more],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_for_lines(process: "subprocess.Popen[str]", path: Path, count: int) -> None:
    deadline = monotonic() + 120
    while not path.exists() or path.read_bytes().count(b"\n") < count:
        assert process.poll() is None, process.communicate()
        assert monotonic() < deadline
        sleep(0.01)


def children(pid: int) -> list[int]:
    found = Path(f"/proc/{pid}/task/{pid}/children")
    return [int(word) for word in found.read_text().split()] if found.exists() else []


def test_a_killed_comparison_goes_on_where_it_stopped(tmp_path: Path) -> None:
    process = started(tmp_path, "--jobs", "2")
    wait_for_lines(process, tmp_path / "out" / JOURNAL, 3)
    left = children(process.pid)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate(timeout=20)
    deadline = monotonic() + 20
    while any(Path(f"/proc/{pid}/cmdline").exists() for pid in left) and monotonic() < deadline:
        sleep(0.05)
    assert not [pid for pid in left if Path(f"/proc/{pid}/cmdline").exists()]
    before = (tmp_path / "out" / JOURNAL).read_bytes()
    whole = before[: before.rfind(b"\n") + 1]
    assert 3 <= whole.count(b"\n") < 16
    arguments = {
        "maps": ["maze"],
        "strategies": ["nearest", "potential"],
        "settings": {},
        "robots": (3,),
        "runs": 8,
        "max_time_s": 600.0,
    }
    made = small(tmp_path / "out", **arguments)
    assert made.played == 16 - whole.count(b"\n")
    assert (tmp_path / "out" / JOURNAL).read_bytes().startswith(whole)
    small(tmp_path / "fresh", **arguments, jobs=2)
    for name in ("results.csv", "coverage.csv"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "fresh" / name).read_bytes()


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_an_interrupt_keeps_what_was_played(tmp_path: Path, jobs: str) -> None:
    process = started(tmp_path, "--jobs", jobs)
    wait_for_lines(process, tmp_path / "out" / JOURNAL, 2)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 1, err
    assert "Traceback" not in err
    there = len(lines(tmp_path / "out"))
    assert f"interrupted: {there} of 16 runs; the same command goes on from there" in out
    assert "rank" in out
    assert len(rows(tmp_path / "out")) == there
    assert f"Interrupted: {there} of 16 runs" in (tmp_path / "out" / "README.md").read_text()
    again = started(tmp_path, "--jobs", jobs, "--json")
    said = json.loads(again.communicate(timeout=120)[0])
    assert again.returncode == 0
    assert (said["played"], said["done"], said["interrupted"]) == (16 - there, 16, False)


def test_a_torn_last_line_is_played_again(tmp_path: Path) -> None:
    small(tmp_path)
    path = tmp_path / JOURNAL
    whole = path.read_bytes()
    path.write_bytes(whole[:-40])
    made = small(tmp_path)
    assert made.played == 1
    assert made.warnings == ()
    assert [json.loads(line)["case"] for line in lines(tmp_path)] == [
        json.loads(line)["case"] for line in whole.decode().splitlines()
    ]
    path.write_bytes(whole[:-1])  # only the end of the line was lost
    assert small(tmp_path).played == 0
    assert path.read_bytes() == whole


def test_lines_that_are_no_results_are_named(tmp_path: Path) -> None:
    small(tmp_path)
    kept = lines(tmp_path)
    odd = ["nonsense", '{"case": {}, "outcome": {"status": "done"}}', "[1]"]
    (tmp_path / JOURNAL).write_text("\n".join([kept[0], *odd, *kept[2:]]) + "\n")
    made = small(tmp_path)
    assert made.played == 1
    assert "line 2 cannot be read" in made.warnings[0]


def test_results_come_back_as_they_were(tmp_path: Path) -> None:
    one = outcome({90: 10.0, 100: 20.5}, warnings=("odd",))
    with Journal(tmp_path / JOURNAL, Outcome.read) as journal:
        journal.add('{"seed": 1}', one)
        journal.add('{"seed": 2}', Failure("no"))
        journal.add('{"seed": 2}', one)
        with pytest.raises(InputError, match="is being written by another conav"):
            Journal(tmp_path / JOURNAL, Outcome.read)
    with Journal(tmp_path / JOURNAL, Outcome.read) as journal:
        assert journal.results == {'{"seed": 1}': one, '{"seed": 2}': one}


def test_what_is_of_no_comparison_is_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "README.md").write_text("precious")
    with pytest.raises(InputError, match=r"holds a README\.md that is of no comparison"):
        small(tmp_path)
    assert (tmp_path / "README.md").read_text() == "precious"
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="file: cannot be made"):
        small(tmp_path / "file")


# What is said


def study(runs: int = 3, *, maps: Any = (GRID,), **changed: Any) -> Any:
    options: dict[str, Any] = {
        "strategies": ["nearest", "potential"],
        "robots": (2,),
        "ranges_m": (7.0,),
        "radios": None,
        "seed": 0,
        "settings": {},
        "bounds": "none",
        "world": World(max_time_s=100.0),
    }
    return make_study(maps, runs=runs, **{**options, **changed})


def test_tables_by_hand() -> None:
    group = Group("rooms", 2, 7.0, "perfect")
    times = {"nearest": [20.0, 40.0, 30.0], "potential": [40.0, None, None]}
    results = {
        Case(*group, strategy, seed): outcome({90: 10.0, 99: 15.0} | ({100: t} if t else {}))
        for strategy, found in times.items()
        for seed, t in enumerate(found)
    }
    asked = study()
    (table,) = tables(asked, results, {})
    first, second = table.lines
    assert (first.strategy, first.rank, first.runs, first.finished) == ("nearest", 1, 3, 3)
    assert (second.strategy, second.rank, second.runs, second.finished) == ("potential", 2, 3, 1)
    assert first.times[100] == ((30.0, -inf, inf, 3), False, 3)
    assert second.times[100] == ((100.0, -inf, inf, 3), True, 1)  # counted at the time limit
    assert second.times[90] == ((10.0, -inf, inf, 3), False, 3)
    assert second.ratio is not None
    assert second.ratio.estimate.value == pytest.approx((2 * 2.5 * 100 / 30) ** (1 / 3))
    assert (second.ratio.open_above, second.ratio.open_below) == (True, False)
    assert group_rows(asked, table)[1:] == [
        ("1", "nearest", "10.0", "15.0", "30.0", "3 of 3"),
        ("2", "potential", "10.0", "15.0", "≥100", "1 of 3"),
    ]
    over = totals(asked, results, {}, [table])
    assert total_rows(asked, over)[1:] == [
        ("nearest", "1.00", "1.00", "1.00", "1.00", "3 of 3"),
        ("potential", "1.00", "1.00", "≥2.55", "2.00", "1 of 3"),
    ]


def test_ties_share_a_rank_and_pairs_need_both() -> None:
    group = Group("rooms", 2, 7.0, "perfect")
    results: dict[Case, Outcome | Failure] = {
        Case(*group, strategy, seed): outcome({100: 10.0})
        for strategy in ("nearest", "potential")
        for seed in range(3)
    }
    (table,) = tables(study(), results, {})
    assert [line.rank for line in table.lines] == [1, 1]
    results[Case(*group, "nearest", 0)] = Failure("crashed")
    del results[Case(*group, "potential", 1)]
    (table,) = tables(study(), results, {})
    near, other = table.lines
    assert (near.runs, near.failed, other.runs) == (2, 1, 2)
    assert other.ratio is not None
    assert other.ratio.estimate.n == 1
    assert "2 of 2, 1 failed" in group_rows(study(), table)[1]
    # Of two that never see all, the one whose other times are shorter is ahead.
    results = {
        Case(*group, strategy, seed): outcome({90: 20.0 - 5 * k})
        for k, strategy in enumerate(("nearest", "potential"))
        for seed in range(3)
    }
    assert [line.strategy for line in tables(study(), results, {})[0].lines] == [
        "potential",
        "nearest",
    ]


def test_intervals_of_medians() -> None:
    # The ranks are those of the usual tables of the sign test.
    ranks = {6: (1, 6), 8: (1, 8), 9: (2, 8), 10: (2, 9), 20: (6, 15), 30: (10, 21), 50: (18, 33)}
    for n, (low, high) in ranks.items():
        values = [float(k) for k in range(1, n + 1)]
        found = median_interval(values[::-1])
        assert found == ((n + 1) / 2, low, high, n)
    assert median_interval([1.0, 2.0, 3.0, 4.0, 9.0]) == (3.0, -inf, inf, 5)
    with pytest.raises(ValueError, match="no value"):
        median_interval([])


def test_bootstrap_of_ratios() -> None:
    rng = np.random.default_rng(1)
    logs = rng.normal(0.3, 0.5, size=200)
    found = ratio_bootstrap([exp(x) for x in logs], [1.0] * 200)
    assert found.value == pytest.approx(exp(logs.mean()))
    half = 1.96 * logs.std() / 200**0.5  # what the bootstrap tends to
    assert log(found.low) == pytest.approx(logs.mean() - half, abs=0.1 * half)
    assert log(found.high) == pytest.approx(logs.mean() + half, abs=0.1 * half)
    assert found == ratio_bootstrap([exp(x) for x in logs], [1.0] * 200)
    assert ratio_bootstrap([2.0] * 6, [1.0] * 6)[:3] == pytest.approx((2.0, 2.0, 2.0))
    assert ratio_bootstrap([2.0, 8.0], [1.0, 1.0]) == (pytest.approx(4.0), -inf, inf, 2)
    with pytest.raises(ValueError, match="positive"):
        ratio_bootstrap([1.0], [0.0])


def test_curves_are_what_was_covered() -> None:
    one = outcome({50: 10.0, 90: 20.0})
    times = np.array([0.0, 9.9, 10.0, 19.0, 20.0, 99.0])
    assert coverage_at([one], times).tolist() == [[0.0, 0.0, 50.0, 50.0, 90.0, 90.0]]


def test_wording() -> None:
    from conav.experiments.compare.tables import Ratio, Times
    from conav.intervals import Estimate

    assert [number(x) for x in (99.96, 9.996, 0.004)] == ["100", "10.0", "0.00"]
    assert times_text(Times(Estimate(50.0, 40.0, 100.0, 9), False, 5), 100.0) == "50.0 [40.0, ≥100]"
    assert times_text(Times(Estimate(100.0, 100.0, 100.0, 9), True, 0), 100.0) == "≥100"
    half = Ratio(Estimate(0.5, 0.25, 1.0, 9), True, False)
    assert ratio_text(half) == "≥0.50 [0.25, 1.00]"
    assert ratio_text(half._replace(open_above=False, open_below=True)).startswith("≤")
    assert ratio_text(half._replace(open_below=True)).startswith("≈")
    assert aligned([("a", "b"), ("long", "c")]) == "  a     b\n  long  c"
    assert markdown([("a", "b|c")]) == "| a | b\\|c |\n|---|---|"


def test_the_page_shows_all_plots_and_its_command_makes_it_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my maps").mkdir()
    Path("my maps/rooms.txt").write_text(ROOMS.strip())
    options = (
        *("--strategies", "nearest,keep=nearest,uncoordinated-alone", "--robots", "1,2"),
        *("--set", "keep.keep_goal=true", "--range", "3.5", "--runs", "2", "--seed", "3"),
        *("--max-time", "120", "--cell", "0.5", "--resolution", "0.5", "--radius", "0.12"),
        *("--out", "o", "--jobs", "1"),
    )
    assert run(["compare", "my maps/rooms.txt", *options]) == 0
    capsys.readouterr()
    page = Path("o/README.md").read_text()
    drawn = {path.name for path in Path("o").glob("*.png")}
    assert drawn == {
        *("coverage-1.png", "coverage-2.png"),
        *("t90.png", "t100.png", "overlap.png", "balance.png", "traffic.png"),
    }
    assert {name for name in re.findall(r"\]\(([^)]+)\)", page) if name.endswith("png")} == drawn
    for name in re.findall(r"\]\(([^)]+)\)", page):
        assert (Path("o") / name).is_file()
    assert "radio perfect (uncoordinated-alone off)" in page
    assert {row["radio"] for row in rows(Path("o"))} == {"perfect", "off"}
    (command,) = re.findall(r"^conav (compare .*)$", page, re.M)
    assert run([*shlex.split(command), "--json", "--no-plots"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["played"], said["done"], said["runs"]) == (0, 12, 12)
    assert [group["robots"] for group in said["groups"]] == [1, 2]
    assert said["groups"][0]["strategies"][0]["t90_s"]["low"] is None


def test_without_pyarrow_and_matplotlib_there_are_numbers_and_a_line_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small(tmp_path)
    assert (tmp_path / "results.parquet").exists()
    for gone in ("matplotlib", "pyarrow"):
        for name in [name for name in sys.modules if name.partition(".")[0] == gone]:
            monkeypatch.delitem(sys.modules, name)
        monkeypatch.setitem(sys.modules, gone, None)
    made = small(tmp_path, plots=True)
    parquet, plots = made.warnings
    assert parquet.startswith("no results.parquet: it needs pyarrow, which is not installed; pip")
    assert 'pip install "conav[data]"' in parquet
    assert 'pip install "conav[plot]"' in plots
    assert not (tmp_path / "results.parquet").exists()  # the old one would tell another story
    assert len(rows(tmp_path)) == 4
    assert "png" not in (tmp_path / "README.md").read_text()


def test_parquet_and_csv_agree(tmp_path: Path) -> None:
    from pyarrow import parquet

    made = small(tmp_path)
    found = parquet.read_table(tmp_path / "results.parquet").to_pylist()
    for row, text in zip(found, rows(tmp_path), strict=True):
        assert {name: row[name] for name in ("map", "strategy", "status")}.items() <= text.items()
        assert row["t90_s"] == float(text["t90_s"]) == row["percent_s"][89]
        assert (row["seed"], row["messages"]) == (int(text["seed"]), int(text["messages"]))
    assert [row["percent_s"] for row in found] == [list(r.percent_s) for r in made.results.values()]


def test_odd_maps_are_told_of_once(tmp_path: Path) -> None:
    made = small(tmp_path, ranges_m=(0.4,), runs=3)
    (warning,) = made.warnings
    assert warning.startswith("map rooms: a sensor range of 0.4 m is less than a planning cell")
    assert warning in (tmp_path / "README.md").read_text()


# The command


def test_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    options = ("--strategies", "nearest,potential", "--runs", "1", "--no-plots", "--jobs", "1")
    assert run(["compare", "maze", *options, "--max-time", "20"]) == 0  # nobody finished: a result
    out, err = capsys.readouterr()
    assert err == ""
    assert "maze, 3 robots, range 7 m, radio perfect: medians" in out
    assert re.search(r"1 +nearest +.*≥20.0 +0 of 1", out)
    assert "2 of 2 runs played now; page, numbers, plots: comparison" in out
    assert run(["compare", "maze", *options, "--max-time", "20", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_a_failed_run_is_exit_code_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from conav.experiments.compare import run_case

    monkeypatch.chdir(tmp_path)
    true_run = run_case.run_exploration

    def fails(problem: Any, *args: Any, **options: Any) -> Any:
        if problem.seed == 1 and problem.max_time_s > 0:
            raise RuntimeError("bad luck")
        return true_run(problem, *args, **options)

    monkeypatch.setattr(run_case, "run_exploration", fails)
    options = ("--strategies", "nearest", "--runs", "2", "--no-plots", "--jobs", "1")
    assert run(["compare", "maze", *options]) == 1
    out = capsys.readouterr().out
    assert "failed: nearest on maze, seed 1: RuntimeError: bad luck (test_compare.py, line" in out
    assert "1 of 1, 1 failed" in out


FAST = ("maze", "--strategies", "nearest")


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        ((), ["--strategies requires an argument"]),
        (("--strategies", "nearest"), ["MAP: is missing", "conav maps lists"]),
        (("mazes", "--strategies", "nearest"), ["map 'mazes'", "neither a file nor a built-in"]),
        (("no.yaml", "--strategies", "nearest"), ["no.yaml: does not exist"]),
        (("bad.txt", "--strategies", "nearest"), ["bad.txt: "]),
        (("maze", "full.txt", "--strategies", "nearest"), ["map full, seed 0", "no free cell"]),
        (("maze", "--strategies", "nearst"), ["strategy 'nearst'", "did you mean nearest?"]),
        (("maze", "--strategies", "a=nearest,a=potential"), ["'a'", "the name of two strategies"]),
        (("maze", "--strategies", "=nearest"), ["neither NAME nor NAME=STRATEGY"]),
        (("maze", "--strategies", ","), ["strategies: is missing"]),
        ((*FAST, "--set", "keep_goal=1"), ["is not strategy.setting=value"]),
        ((*FAST, "--set", "near.keep_goal=1"), ["'near'", "not among the strategies compared"]),
        ((*FAST, "--set", "nearest.keep=1"), ["setting 'keep'", "did you mean keep_goal?"]),
        ((*FAST, "--robots", "1,two"), ["--robots", "'two' is not a whole number"]),
        ((*FAST, "--robots", "1.5"), ["'1.5' is not a whole number"]),
        ((*FAST, "--robots", "0"), ["robots 0", "give 1 to"]),
        (("tiny.txt", *FAST, "--robots", "1,3"), ["map tiny, seed 0: has room for 2 of 3 robots"]),
        ((*FAST, "--range", "far"), ["--range", "'far' is not a number of metres"]),
        ((*FAST, "--range", "nan"), ["range nan", "give 0 to"]),
        ((*FAST, "--range", ","), ["range: is missing"]),
        ((*FAST, "--radio", "loud"), ["radio 'loud'", "perfect"]),
        (
            ("maze", "--strategies", "uncoordinated-alone", "--radio", "perfect"),
            ["does not go with strategy uncoordinated-alone", "radio off"],
        ),
        ((*FAST, "--runs", "0"), ["runs 0", "give 1 to"]),
        ((*FAST, "--jobs", "0"), ["jobs 0", "give 1 to"]),
        ((*FAST, "--motion", "fly"), ["motion 'fly'", "4-connected"]),
        ((*FAST, "--sensor", "nose"), ["sensor 'nose'"]),
        ((*FAST, "--traffic", "wild"), ["traffic 'wild'"]),
        ((*FAST, "--cell", "0"), ["map maze, seed 0: cell 0.0", "--cell"]),
        ((*FAST, "--radius", "50"), ["map maze, seed 0: radius 50 m", "smaller --radius"]),
        ((*FAST, "--speed", "0"), ["speed 0"]),
        ((*FAST, "--max-time", "nan"), ["max-time nan"]),
        ((*FAST, "--resolution", "0"), ["map maze, seed 0", "positive number of metres"]),
        ((*FAST, "--out", "bad.txt"), ["bad.txt: cannot be made", "--out"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else None,
)
def test_bad_input_is_one_line(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    parts: list[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.txt").write_text("zz\n")
    Path("tiny.txt").write_text("####\n#..#\n####\n")
    Path("full.txt").write_text("####\n####\n####\n####\n")
    jobs = () if "--jobs" in arguments else ("--jobs", "1")
    assert run(["compare", *jobs, *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    for part in parts:
        assert part in err
    assert not [path for path in tmp_path.rglob("*") if path.name == "results.csv"]
    journal = tmp_path / "comparison" / JOURNAL
    assert not journal.exists() or journal.read_bytes() == b""


def test_one_bad_map_stops_all_before_anything_is_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = conav.OccupancyGrid(np.ones((4, 4), dtype=np.uint8), 0.5, name="full")
    with pytest.raises(InputError, match="map full, seed 0: has no free cell"):
        small(tmp_path, maps=["maze", GRID, full], jobs=2)
    assert (tmp_path / JOURNAL).read_bytes() == b""

    def refuses(self: Any, view: Any, rng: Any) -> Any:
        raise InputError("motion", "is not for this strategy")

    from conav.exploration.nearest import Nearest

    monkeypatch.setattr(Nearest, "start", refuses)
    with pytest.raises(InputError, match="map rooms, seed 0: motion: is not for this strategy"):
        small(tmp_path)
    assert (tmp_path / JOURNAL).read_bytes() == b""


def test_maps_of_one_name(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        text = ROOMS.strip() if name == "a" else ROOMS.strip().replace("#....#", "......")
        (tmp_path / name / "rooms.txt").write_text(text)
    one, two = (str(tmp_path / name / "rooms.txt") for name in ("a", "b"))
    asked = study(
        maps=[one, two, one],
        robots=(1, 1),
        radios=(3, "3.0", 0, "off"),
        world=World(resolution=0.5),
    )
    assert [place.name for place in asked.maps] == ["rooms", two]
    assert (asked.robots, asked.radios) == ((1,), ("3", "off"))
    (tmp_path / "b" / "map.txt").write_text(ROOMS.strip())
    assert study(maps=[str(tmp_path / "b" / "map.txt")]).maps[0].name == "b/map"
    other = conav.OccupancyGrid(np.zeros((4, 4), dtype=np.uint8), 0.5, name="rooms")
    with pytest.raises(InputError, match="'rooms': is the name of two maps"):
        small(tmp_path / "out", maps=[GRID, other])


def test_maps_are_read_once_and_let_go_when_there_are_many(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from conav.experiments.compare import run_case

    read: list[int] = []
    true_load = run_case.load_map

    def counted(*args: Any, **options: Any) -> Any:
        read.append(options["seed"])
        return true_load(*args, **options)

    monkeypatch.setattr(run_case, "load_map", counted)
    runner = Runner(study(runs=5))
    group = Group("rooms", 2, 7.0, "perfect")
    for seed in range(5):
        runner.problem(Case(*group, "nearest", seed))
    assert read == [0]
    mazes = Runner(study(runs=5, maps=["maze"]))
    monkeypatch.setattr(run_case, "KEPT_CELLS", 100_000)
    for seed in (0, 1, 0, 2, 3, 0):
        mazes.problem(Case("maze", 1, 7.0, "perfect", "nearest", seed))
    assert read[1:] == [0, 1, 2, 3, 0]


def test_a_map_that_changes_meanwhile_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "rooms.txt"
    path.write_text(ROOMS.strip())
    asked = study(maps=[str(path)])
    path.write_text(ROOMS.strip().replace("#....#", "......"))
    found = Runner(asked).run(Case("rooms", 1, 7.0, "perfect", "nearest", 0))
    assert isinstance(found, Failure)
    assert "has changed since the comparison began" in found.message


def test_importing_draws_nothing() -> None:
    assert isinstance(module, ModuleType)
    code = (
        "import sys, conav.experiments.compare.compare as m; "
        "print([n for n in ('matplotlib', 'numba', 'pyarrow', 'rich') if n in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
