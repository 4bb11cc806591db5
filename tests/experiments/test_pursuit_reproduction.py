"""`conav reproduce pursuit`: verdicts follow from outcomes, and a tiny version plays whole."""

import csv
import json
from pathlib import Path
from typing import Any

import pytest

from conav.cli import run
from conav.errors import InputError
from conav.experiments.compare.journal import JOURNAL
from conav.experiments.compare.outcome import Failure
from conav.experiments.potential_games.report import HELD, NOT_HELD, OPEN
from conav.experiments.pursuit.claims import exponent, interleaving, messages
from conav.experiments.pursuit.figures import CAPTIONS
from conav.experiments.pursuit.lab import Runner
from conav.experiments.pursuit.part_claims import graphs, orders
from conav.experiments.pursuit.play import Played, play
from conav.experiments.pursuit.reproduce import reproduce
from conav.experiments.pursuit.results import Results, Section
from conav.experiments.pursuit.team_claims import labels, team_sizes
from conav.experiments.pursuit.world import (
    GRAPHS,
    INTERLEAVING,
    MESSAGES,
    NINE,
    ORDERS,
    SIZES,
    TEAMS,
    WALLS,
    Case,
    all_cases,
)

TREES = [f"corridor-tree:segments=20,seed={seed}" for seed in range(6)]


def made_up(study: str, *entries: tuple[str, str, dict[str, Any]]) -> Results:
    """Outcomes of cases (floor, setting, values), a row each."""
    found: dict[Case, Played | Failure] = {}
    for floor, setting, values in entries:
        case = Case(study, floor, setting)
        before = found.get(case)
        rows = before.rows if isinstance(before, Played) else ()
        found[case] = Played((*rows, {"floor": floor, **values}))
    return Results(found)


def verdict(section: Section, *words: str) -> str:
    [found] = [one for one in section.verdicts if all(word in one.claim for word in words)]
    return found.verdict


# --- cases ----------------------------------------------------------------------------------------


def test_more_runs_and_sizes_keep_the_cases_there_are() -> None:
    few = all_cases(2, 0, 1)
    assert len(set(few)) == len(few)
    assert set(few) < set(all_cases(3, 0, 2)) < set(all_cases(4, 0, SIZES))
    assert {case.floor for case in all_cases(1, 5, 1)} >= {"corridor-tree:segments=20,seed=5"}


def test_what_cannot_be_played_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_: object) -> None:
        raise RuntimeError("no luck")

    monkeypatch.setattr("conav.experiments.pursuit.lab.play", broken)
    found = Runner().run(Case(GRAPHS, "comb:3", "paper"))
    assert isinstance(found, Failure)
    assert "RuntimeError: no luck" in found.message


def test_what_is_no_outcome_is_not_read() -> None:
    assert Played.read({"rows": [{"a": 1}]}) == Played(({"a": 1},))
    for content in ({}, {"rows": 1}, {"rows": [1]}, {"rows": [], "more": 0}):
        with pytest.raises(TypeError):
            Played.read(content)


def test_labels_are_clear_where_all_walls_are_seen_and_somebody_is_left() -> None:
    [row] = play(Case(WALLS, NINE, "paper labels")).rows
    assert (row["verdict"], row["pursuers"], row["distance_m"]) == ("escapes", 3, 0.0)


# --- verdicts -------------------------------------------------------------------------------------


def cleared(edb: int | str, distance: float, pursuers: int = 1) -> dict[str, Any]:
    return {
        "edb": edb, "verdict": "captured", "pursuers": pursuers, "distance_m": distance,
        "time_s": distance, "recontaminations": 1, "explored_vertices": 3, "pursuits": 1,
    }  # fmt: skip


def test_interleaving_is_judged() -> None:
    runs = []
    for number, tree in enumerate(TREES):
        runs.append((tree, "unlimited", cleared("unlimited", 10.0)))
        runs.append((tree, "1", cleared(1, 5.0 + 0.1 * number)))
        runs.append((tree, "2", cleared(2, 15.0 + 0.1 * number)))
        runs.append((tree, "3", cleared(3, 5.0 if number % 2 else 20.0)))
    # A floor that is not random counts in the table, and in no interval.
    runs += [("comb:3", "1", cleared(1, 900.0)), ("comb:3", "unlimited", cleared("unlimited", 1.0))]
    section = interleaving(made_up(INTERLEAVING, *runs))
    assert verdict(section, "edb 1") == HELD
    assert verdict(section, "edb 2") == NOT_HELD
    assert verdict(section, "edb 3") == OPEN
    assert verdict(section, "does not change") == HELD
    [(header, rows)] = section.tables
    line = dict(zip(header, rows[0], strict=True))
    assert (line["edb"], line["shorter on"], line["longest"]) == ("1", "6 of 7", "`comb:3` 900")
    other = interleaving(
        made_up(INTERLEAVING, *runs, ("comb:6", "1", cleared(1, 3.0, 2)),
                ("comb:6", "unlimited", cleared("unlimited", 3.0)))
    )  # fmt: skip
    assert verdict(other, "does not change") == NOT_HELD


def sizes(vertices: int, whole: int, parts: int, total: int, **more: Any) -> dict[str, Any]:
    return {
        "labels": "shadows", "vertices": vertices, "whole": whole, "complete": True,
        "guards": parts - 1, "parts": parts, "parts_total": total, "parts_largest": total,
        "whole_s": 1.0, "parts_s": 0.5, **more,
    }  # fmt: skip


def test_sizes_of_graphs_are_judged() -> None:
    rows = [(tree, "shadows", sizes(10, 90 + i, 3, 20 + i)) for i, tree in enumerate(TREES)]
    section = graphs(made_up(GRAPHS, *rows))
    assert verdict(section, "has O(2^n)") == HELD
    assert verdict(section, "double") == NOT_HELD
    assert verdict(section, "k parts") == HELD
    assert verdict(section, "fewer states") == HELD
    assert verdict(section, "fewer seconds") == HELD
    large = graphs(made_up(GRAPHS, *rows, ("comb:3", "shadows", sizes(2, 13, 1, 13))))
    assert verdict(large, "has O(2^n)") == NOT_HELD  # 13 > 3 * 4
    cut = graphs(made_up(GRAPHS, *rows, ("comb:3", "shadows", sizes(9, 99, 1, 9, complete=False))))
    assert verdict(cut, "has O(2^n)") == OPEN
    [(_, table)] = cut.tables
    assert table == [("`comb:3`", "shadows", "9", "over 99", "1", "9", "9", "1.00", "0.500")]
    parts = graphs(made_up(GRAPHS, *rows, ("comb:3", "shadows", sizes(4, 90, 2, 41))))
    assert verdict(parts, "k parts") == NOT_HELD  # 41 > 5 * 2 * 2^2


def order(which: str, time: float, pursuers: int, lost: float | None = None) -> dict[str, Any]:
    return {
        "order": which, "lost_s": lost, "recontaminated_m2": 0.0, "pursuers": pursuers,
        "time_s": time, "distance_m": 10.0 * pursuers, "messages": 5, "captured": True,
    }  # fmt: skip


def test_orders_and_losses_are_judged() -> None:
    rows = []
    for i, tree in enumerate(TREES):
        rows += [
            (tree, "", order("sequence", 30.0 + i, 2)),
            (tree, "", order("sequence", 45.0 + i, 3, 9.0)),
            (tree, "", order("parallel", 10.0, 4)),
            (tree, "", order("parallel", 15.0, 5, 4.0)),
        ]
    section = orders(made_up(ORDERS, *rows))
    assert verdict(section, "parts at once are cleared in less time than") == HELD
    assert verdict(section, "less driving") == NOT_HELD
    assert verdict(section, "more pursuers") == HELD
    assert verdict(section, "with a pursuer lost, parts") == HELD
    assert verdict(section, "a team that loses") == HELD
    rows[1][2]["captured"] = False
    assert verdict(orders(made_up(ORDERS, *rows)), "a team that loses") == NOT_HELD


def test_messages_are_judged() -> None:
    def teams(power: float, longest: int = 8) -> Results:
        return made_up(
            MESSAGES,
            *(
                (
                    tree, str(n),
                    {"pursuers": n, "deliberations": 1, "rounds": 1, "longest_round": longest,
                     "messages": round((10 + i % 2) * n**power), "size_bytes": 99,
                     "captured": True},
                )
                for i, tree in enumerate(TREES)
                for n in (3, 6, 12)
            ),
        )  # fmt: skip

    section = messages(teams(1.2))
    assert verdict(section, "O(n²)") == HELD
    assert verdict(section, "a round takes") == HELD
    assert verdict(section, "is clear") == HELD
    assert verdict(messages(teams(2.6)), "O(n²)") == NOT_HELD
    assert verdict(messages(teams(1.2, longest=16)), "a round takes") == NOT_HELD
    rows = [{"pursuers": n, "messages": 3 * n**2} for n in (2, 4, 8)]
    assert exponent(rows) == pytest.approx(2.0)


def team(pursuers: int, found: str = "captured", **more: Any) -> dict[str, Any]:
    return {
        "corners": 32, "holes": 0, "verdict": found, "pursuers": pursuers, "lower_bound": 1,
        "distance_m": 1.0, "time_s": 1.0, **more,
    }  # fmt: skip


def test_teams_and_labels_are_judged() -> None:
    rows = []
    for i, tree in enumerate(TREES):
        rows += [
            (tree, "known-map", team(1)),
            (tree, "delegation", team(1)),
            (tree, "guards", team(5 + i % 2)),
            (tree, "paper labels", team(1)),
            (tree, "paper labels, split", team(2)),
        ]
    section = team_sizes(made_up(TEAMS, *rows))
    assert verdict(section, "suffice") == HELD
    assert verdict(section, "that moves is smaller") == HELD
    assert verdict(section, "fewest") == HELD
    assert verdict(section, "triples") == OPEN
    claims = labels(made_up(TEAMS, *rows))
    assert [one.verdict for one in claims.verdicts] == [HELD, HELD, HELD]
    rows += [("triples:1", "known-map", team(1)), ("triples:2", "known-map", team(3))]
    rows += [("triples:1", "delegation", team(2)), ("triples:1", "paper labels", team(2))]
    rows += [("comb:3", "paper labels, split", team(1, "escapes"))]
    section = team_sizes(made_up(TEAMS, *rows))
    assert verdict(section, "triples") == NOT_HELD
    assert verdict(section, "fewest") == NOT_HELD
    claims = labels(made_up(TEAMS, *rows))
    assert [one.verdict for one in claims.verdicts] == [HELD, NOT_HELD, NOT_HELD]
    assert labels(Results({})).verdicts[0].verdict == OPEN


# --- the whole ------------------------------------------------------------------------------------

OPTIONS: dict[str, Any] = {"runs": 1, "sizes": 1}
CASES = len(all_cases(1, 0, 1))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    found = reproduce(folder, **OPTIONS)
    assert (found.cases, found.done, found.failed) == (CASES, CASES, 0)
    return folder


def test_all_is_on_the_page(made: Path) -> None:
    page = (made / "README.md").read_text()
    assert "conav reproduce pursuit --runs 1 --sizes 1`" in page
    assert "cases were played" not in page
    for picture, _ in CAPTIONS:
        assert (made / picture).is_file()
        assert page.count(f"]({picture})") == 1
    for title in ("What labels", "Exploring", "Pursuit graphs", "Parts in", "Messages", "Team si"):
        assert f"## {title}" in page
    assert "nan" not in page
    assert "**did not hold** | an evader escapes in" in page
    with (made / "runs.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert {row["study"] for row in rows} == {case.study for case in all_cases(1, 0, 1)}
    with (made / "results.csv").open() as stream:
        for row in csv.DictReader(stream):
            if row["low"] and row["high"] and row["value"]:
                assert float(row["low"]) <= float(row["value"]) <= float(row["high"])


def test_it_goes_on_where_it_was_killed(made: Path, tmp_path: Path) -> None:
    lines = (made / JOURNAL).read_bytes().splitlines(keepends=True)
    (tmp_path / JOURNAL).write_bytes(b"".join(lines[:-1]) + lines[-1][:40])
    seen: list[tuple[int, int]] = []
    reproduce(tmp_path, **OPTIONS, plots=False, progress=lambda *now: seen.append(now))
    assert (seen[0], seen[-1]) == ((CASES - 1, CASES), (CASES, CASES))
    for name in ("runs.csv", "results.csv"):
        assert (tmp_path / name).read_bytes() == (made / name).read_bytes()


def test_an_interrupt_keeps_what_was_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left = 2
    honest = Runner.run

    def interrupted(self: Runner, case: Case) -> Played | Failure:
        nonlocal left
        left -= 1
        if left < 0:
            raise KeyboardInterrupt
        return honest(self, case)

    monkeypatch.setattr(Runner, "run", interrupted)
    found = reproduce(tmp_path, **OPTIONS)
    assert found.interrupted
    assert f"2 of {CASES} cases were played" in (tmp_path / "README.md").read_text()
    assert not list(tmp_path.glob("*.png"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"runs": 0}, "runs 0: is out of range"),
        ({"jobs": 0}, "jobs 0: is out of range"),
        ({"sizes": 4}, "sizes 4: is out of range"),
        ({"seed": -1}, "seed -1: is out of range"),
    ],
)
def test_bad_numbers_are_named(tmp_path: Path, arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        reproduce(tmp_path, **arguments)


def test_command(made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / JOURNAL).write_bytes((made / JOURNAL).read_bytes())
    effort = ["--runs", "1", "--sizes", "1", "--jobs", "1", "--no-plots"]
    command = ["reproduce", "pursuit", *effort, "--out", str(tmp_path)]
    assert run([*command, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["paper"], said["cases"], said["done"]) == ("pursuit", CASES, CASES)
    assert {one["verdict"] for one in said["verdicts"]} <= {HELD, NOT_HELD, OPEN}
    assert run(["reproduce", "pursuit", "--runs", "many"]) == 2
