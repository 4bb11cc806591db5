"""Comparisons say how far runs are from the best possible, and find bounds once for all of them."""

import csv
import json
from math import inf
from pathlib import Path
from typing import Any

import pytest

import conav
from conav.cli import run
from conav.experiments.compare import run_case
from conav.experiments.compare.arguments import make_study
from conav.experiments.compare.cases import Case, Ground, Group, Study, World
from conav.experiments.compare.compare import Comparison, compare
from conav.experiments.compare.journal import JOURNAL, Journal
from conav.experiments.compare.optimum import AgainstBest, against_best, median_ratio
from conav.experiments.compare.outcome import CaseBounds, Failure, Outcome
from conav.experiments.compare.tables import tables, totals
from conav.experiments.compare.wording import best_text, group_rows, total_rows
from conav.maps.ascii_art import parse_ascii
from conav.simulation.finish_bounds import finish_bounds

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


def small(folder: Path, **changed: Any) -> Comparison:
    options: dict[str, Any] = {
        "maps": [GRID],
        "strategies": ["nearest", "hungarian"],
        "robots": (2,),
        "ranges_m": (2.0,),
        "runs": 2,
        "jobs": 1,
        "plots": False,
        "max_time_s": 600.0,
    }
    return compare(folder=folder, **{**options, **changed})


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "results.csv").open() as stream:
        return list(csv.DictReader(stream))


def kept(folder: Path) -> list[dict[str, Any]]:
    lines = (folder / JOURNAL).read_text().splitlines()
    return [entry for line in lines if "bounds" in (entry := json.loads(line))]


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The seeds bounds were found for, in this process."""
    seeds: list[int] = []

    def noted(problem: Any, *args: Any, **options: Any) -> Any:
        seeds.append(problem.seed)
        return finish_bounds(problem, *args, **options)

    monkeypatch.setattr(run_case, "finish_bounds", noted)
    return seeds


def test_ratios_are_those_of_explore_but_for_faster_runs(tmp_path: Path) -> None:
    made = small(tmp_path)
    best: dict[str, float] = {}
    for row in rows(tmp_path):
        time = float(row["t100_s"])
        best[row["seed"]] = min(time, best.get(row["seed"], inf))
    for case, row in zip(made.results, rows(tmp_path), strict=True):
        done = conav.explore(
            GRID,
            strategy=case.strategy,
            robots=2,
            range_m=2.0,
            seed=case.seed,
            max_time_s=600.0,
        )
        bounds = done.bounds()[100]
        assert float(row["lower_bound_s"]) == bounds.lower_s
        assert row["lower_bound_by"] == bounds.by
        assert bounds.upper_s is not None
        assert float(row["upper_bound_s"]) == min(bounds.upper_s, best[row["seed"]])
        time = float(row["t100_s"])
        assert float(row["ratio_low"]) == pytest.approx(time / float(row["upper_bound_s"]))
        assert float(row["ratio_high"]) == pytest.approx(time / bounds.lower_s)
        assert float(row["ratio_low"]) >= 1.0


def test_bounds_are_found_once_for_all_strategies_and_radios(
    tmp_path: Path, found: list[int]
) -> None:
    small(tmp_path, radios=("perfect", 3), runs=2)
    assert found == [0, 1]
    assert len(kept(tmp_path)) == 2
    small(tmp_path, radios=("perfect", 3, 5), strategies=["nearest", "minpos"])
    assert found == [0, 1]
    small(tmp_path, runs=3)
    assert found == [0, 1, 2]
    small(tmp_path, ranges_m=(2.0, 3.0))
    assert found == [0, 1, 2, 0, 1]
    small(tmp_path, bounds="full", runs=1)
    assert found == [0, 1, 2, 0, 1, 0]
    small(tmp_path, traffic="none", runs=1)
    assert found == [0, 1, 2, 0, 1, 0, 0]


def test_bounds_that_are_missing_are_found_without_playing_again(
    tmp_path: Path, found: list[int]
) -> None:
    assert small(tmp_path, bounds="none").played == 4
    assert found == []
    assert {row["lower_bound_s"] for row in rows(tmp_path)} == {""}
    made = small(tmp_path)
    assert (made.played, found) == (0, [0, 1])
    assert "" not in {row["lower_bound_s"] for row in rows(tmp_path)}


def test_other_code_finds_bounds_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    from conav.experiments.compare import source

    keys = [study().bounds_key(study().grounds()[0])]
    real = source._source.__wrapped__
    monkeypatch.setattr(
        source,
        "_source",
        lambda name: real(name) + (b"# changed" if name.endswith("bounds.swath") else b""),
    )
    changed = study()
    keys.append(changed.bounds_key(changed.grounds()[0]))
    assert keys[0] != keys[1]
    assert changed.teams == study().teams


def test_bounds_that_cannot_be_found_are_told_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(problem: Any, *args: Any, **options: Any) -> Any:
        raise ArithmeticError("no bounds today")

    monkeypatch.setattr(run_case, "finish_bounds", fails)
    made = small(tmp_path, runs=1)
    assert len(made.results) == made.played == 2
    (warning,) = made.warnings
    assert warning.startswith("no bounds for rooms, 2 robots, range 2 m, seed 0: ArithmeticError")
    assert made.tables[0].lines[0].best is None
    assert kept(tmp_path) == []


def test_an_interrupt_while_bounds_are_found_keeps_the_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(problem: Any, *args: Any, **options: Any) -> Any:
        if problem.seed == 1:
            raise KeyboardInterrupt
        return finish_bounds(problem, *args, **options)

    monkeypatch.setattr(run_case, "finish_bounds", stopped)
    made = small(tmp_path)
    assert made.interrupted
    assert len(made.results) == 4
    assert [entry["case"]["seed"] for entry in kept(tmp_path)] == [0]
    assert [row["lower_bound_s"] != "" for row in rows(tmp_path)] == [True, False] * 2


def test_bounds_come_back_as_they_were(tmp_path: Path) -> None:
    one = CaseBounds(3.0, "witness", None)
    with Journal(tmp_path / JOURNAL, Outcome.read) as journal:
        journal.add_bounds('{"seed": 1}', CaseBounds(1.0, "swath", 2.0))
        journal.add_bounds('{"seed": 1}', one)
    with Journal(tmp_path / JOURNAL, Outcome.read) as journal:
        assert journal.bounds == {'{"seed": 1}': one}
        assert (journal.results, journal.unreadable) == ({}, [])


# By hand


def study(**changed: Any) -> Study:
    options: dict[str, Any] = {
        "strategies": ["nearest", "potential"],
        "robots": (2,),
        "ranges_m": (7.0,),
        "radios": ["perfect", "off"],
        "runs": 2,
        "seed": 0,
        "settings": {},
        "bounds": "quick",
        "world": World(max_time_s=100.0),
    }
    return make_study((GRID,), **{**options, **changed})


def outcome(t100_s: float | None) -> Outcome:
    values: dict[str, Any] = dict.fromkeys(Outcome.__dataclass_fields__, 1.0)
    times = (1.0,) * 99 + (t100_s,)
    return Outcome(**{**values, "percent_s": times, "path_m": (1.0,), "warnings": ()})


def test_against_the_best_by_hand() -> None:
    perfect, off = (Group("rooms", 2, 7.0, radio) for radio in ("perfect", "off"))
    results: dict[Case, Outcome | Failure] = {
        Case(*perfect, "nearest", 0): outcome(40.0),
        Case(*perfect, "potential", 0): outcome(None),
        Case(*off, "nearest", 0): outcome(30.0),  # another radio is another way to do it
        Case(*off, "potential", 0): Failure("crashed"),
        Case(*perfect, "nearest", 1): outcome(0.0),
        Case(*perfect, "potential", 1): outcome(5.0),
    }
    ground = Ground("rooms", 2, 7.0, 0)
    bounds = {ground: CaseBounds(20.0, "witness", 35.0)}
    assert against_best(study(), results, bounds) == {
        Case(*perfect, "nearest", 0): (20.0, "witness", 30.0, "nearest", 40 / 30, 2.0),
        # Not done at the time limit of 100 s: at least that.
        Case(*perfect, "potential", 0): (20.0, "witness", 30.0, "nearest", 100 / 30, inf),
        Case(*off, "nearest", 0): (20.0, "witness", 30.0, "nearest", 1.0, 1.5),
    }
    bounds[ground] = CaseBounds(20.0, "witness", 25.0)
    bounds[ground._replace(seed=1)] = CaseBounds(0.0, "swath", None)
    best = against_best(study(), results, bounds)
    assert best[Case(*off, "nearest", 0)] == (20.0, "witness", 25.0, "known-map", 1.2, 1.5)
    assert best[Case(*perfect, "nearest", 1)] == (0.0, "swath", 0.0, "nearest", 1.0, 1.0)
    assert best[Case(*perfect, "potential", 1)][4:] == (inf, inf)
    assert against_best(study(), results, {}) == {}


def test_without_any_run_that_saw_all_the_ratio_is_at_least_one() -> None:
    group = Group("rooms", 2, 7.0, "perfect")
    results = {Case(*group, "nearest", 0): outcome(None)}
    bounds = {Ground("rooms", 2, 7.0, 0): CaseBounds(20.0, "witness", None)}
    (one,) = against_best(study(), results, bounds).values()
    assert one == (20.0, "witness", None, None, 1.0, inf)


def test_the_median_lies_between_the_medians_of_the_ends() -> None:
    ends = [(1.0, 2.0), (1.5, 1.6), (3.0, inf), (1.2, 5.0)]
    found = [AgainstBest(1.0, "swath", None, None, low, high) for low, high in ends]
    assert median_ratio(found) == (1.35, 3.5)
    assert median_ratio(found[2:3]) == (3.0, inf)
    assert median_ratio([]) is None


def test_tables_have_a_column_where_there_are_bounds() -> None:
    group = Group("rooms", 2, 7.0, "perfect")
    results = {
        Case(*group, strategy, seed): outcome(time)
        for strategy, times in {"nearest": (40.0, 30.0), "potential": (50.0, None)}.items()
        for seed, time in enumerate(times)
    }
    bounds = {Ground("rooms", 2, 7.0, seed): CaseBounds(20.0, "witness", None) for seed in (0, 1)}
    asked = study(radios=None)
    best = against_best(asked, results, bounds)
    (table,) = tables(asked, results, best)
    assert [row[-1] for row in group_rows(asked, table)] == [
        "T100 over best possible",
        "1 to 1.75",
        "≥2.29",
    ]
    over = totals(asked, results, best, [table])
    assert [row[-1] for row in total_rows(asked, over)][1:] == ["1 to 1.75", "≥2.29"]
    without = study(radios=None, bounds="none")
    assert "over best" not in str(group_rows(without, table) + total_rows(without, over))


def test_ends_are_rounded_outwards() -> None:
    assert best_text((1.239, 2.301)) == "1.23 to 2.31"
    assert best_text((1.2, 1.2)) == "1.2"
    assert best_text((1.0, inf)) == "≥1"
    assert best_text(None) == "-"


def test_the_command_says_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rooms.txt").write_text(ROOMS.strip())
    options = ("--strategies", "nearest", "--robots", "2", "--range", "2", "--runs", "1")
    options += ("--resolution", "0.5", "--no-plots", "--jobs", "1")
    assert run(["compare", "rooms.txt", *options]) == 0
    assert "T100 over best possible" in capsys.readouterr().out
    page = Path("comparison/README.md").read_text()
    assert "T100 over best possible |" in page
    assert "certified lower bound" in page
    assert run(["compare", "rooms.txt", *options, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    low, high = said["groups"][0]["strategies"][0]["t100_over_best"]
    assert 1.0 <= low <= high
    assert said["over_all"][0]["t100_over_best"] == [low, high]
    assert run(["compare", "rooms.txt", *options, "--bounds", "none"]) == 0
    page = Path("comparison/README.md").read_text()
    assert "over best possible" not in page
    assert "--bounds none" in page
    assert run(["compare", "rooms.txt", *options, "--bounds", "some"]) == 2
    assert "bounds 'some': is not known; use one of: quick, full, none" in capsys.readouterr().err
