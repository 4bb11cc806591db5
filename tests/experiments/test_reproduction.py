"""The reproduction of the potential-game paper: what it writes, and that it writes it again."""

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from conav.cli import run
from conav.errors import InputError
from conav.experiments.potential_games import reproduce as module
from conav.experiments.potential_games.lab import Lab, curve, finished, finished_share
from conav.experiments.potential_games.report import (
    HELD,
    NOT_HELD,
    OPEN,
    above,
    below,
    every,
    number,
)
from conav.experiments.potential_games.reproduce import reproduce
from conav.experiments.potential_games.studies import STUDIES
from conav.experiments.potential_games.world import Played, play, simulate, team, world
from conav.intervals import Estimate, mean_interval

SMALL = {"layouts": 2, "games": 3, "runs": 1, "steps": 2000}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    reproduce(folder, **SMALL)
    return folder


def test_all_is_on_the_page(made: Path) -> None:
    page = (made / "README.md").read_text()
    for picture in made.glob("*.png"):
        assert picture.name in page
    assert {f"figure-{number}.png" for number in range(1, 7)} <= {p.name for p in made.iterdir()}
    assert page.count("**held**") + page.count("**did not hold**") > 5
    assert "missing" not in page
    assert f"{module.STEPS}" not in page  # the options that made it are its own
    assert "--layouts 2 --games 3 --runs 1 --steps 2000" in page
    with (made / "numbers.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert {row["study"] for row in rows} == set(STUDIES)
    for row in rows:
        value = float(row["value"])
        if row["low"]:
            assert float(row["low"]) <= value <= float(row["high"])


def test_the_same_again_on_two_processes(made: Path, tmp_path: Path) -> None:
    only = ("figure-3", "traffic")
    reproduce(tmp_path, **SMALL, jobs=2, only=only)
    with (made / "numbers.csv").open() as stream:
        before = [row for row in csv.reader(stream) if row[0] in only]
    with (tmp_path / "numbers.csv").open() as stream:
        after = list(csv.reader(stream))[1:]
    assert before == after
    assert "Not all studies are in it" in (tmp_path / "README.md").read_text()


def test_an_interrupt_keeps_what_was_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(lab: Lab) -> None:
        raise KeyboardInterrupt

    monkeypatch.setitem(STUDIES, "figure-6", interrupted)
    found = reproduce(tmp_path, **SMALL)
    assert found.interrupted
    assert found.studies == ("figure-3",)
    assert "figure-3" in (tmp_path / "numbers.csv").read_text()


def test_without_matplotlib_there_are_numbers_and_one_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "matplotlib"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    found = reproduce(tmp_path, **SMALL, only=("figure-3",))
    assert len(found.warnings) == 1
    assert 'pip install "conav[plot]"' in found.warnings[0]
    assert (tmp_path / "numbers.csv").stat().st_size > 500
    assert "png" not in (tmp_path / "README.md").read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"layouts": 0}, "layouts 0: is out of range"),
        ({"steps": 10}, "give 2000"),
        ({"only": ("figure-7",)}, "figure-3, figure-6"),
    ],
)
def test_bad_numbers_are_named(tmp_path: Path, arguments: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        reproduce(tmp_path, **arguments)


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    common = ["--layouts", "2", "--games", "3", "--runs", "1", "--jobs", "1", "--steps", "2000"]
    out = ["--out", str(tmp_path / "made")]
    code = run(["reproduce", "potential-games", *common, *out, "--only", "figure-3", "--json"])
    said = json.loads(capsys.readouterr().out)
    assert code == 0
    assert said["studies"] == ["figure-3"]
    assert {verdict["verdict"] for verdict in said["verdicts"]} <= {HELD, NOT_HELD, OPEN}
    assert run(["reproduce", "potential-gamse", *out]) == 2
    assert "potential-gamse" in capsys.readouterr().err
    (tmp_path / "file").write_text("")
    assert run(["reproduce", "potential-games", "--out", str(tmp_path / "file")]) == 2
    assert str(tmp_path / "file") in capsys.readouterr().err


def test_the_world_is_the_papers() -> None:
    problem = world(3, 2, "none", "perfect")
    assert problem.plan.walls.shape == (40, 40)
    assert [divmod(cell, 40) for cell in problem.starts] == [(1, 1), (1, 2), (2, 1)]
    assert problem.step_s == 1.0
    layouts = {world(layout, 2, "none", "perfect").plan.walls.tobytes() for layout in range(20)}
    assert len(layouts) == 20


def test_bulk_and_simulator_play_the_same_game() -> None:
    players = team("any", "potential", epsilon=0.3)
    bulk = play(players, 1, 2, 2000, True)
    for game in range(2):
        alone = simulate(players, 1, game, 2000)
        assert np.array_equal(alone.times, bulk.times[game])
    assert bulk.equilibria > 0.5
    assert bulk.overlap[0] > 0.3  # side by side
    assert bulk.coverage[-1] == 1.0


def test_marginal_contributions_have_regret_only_where_they_do_not_hear() -> None:
    players = team("any", "marginal-contribution", epsilon=0.1)
    heard = simulate(players, 1, 0, 300)
    assert heard.regret == 0.0
    deaf = simulate(
        type(players)("any", players.strategy, players.settings, radio_m=1.0), 1, 0, 300
    )
    assert deaf.regretful > 0.0


def _played(times: list[float]) -> Played:
    empty = np.zeros(3)
    column = np.array([[time] * 4 for time in times])
    return Played(9, empty, column, 0.0, 0.0, 0.0, empty, empty, 0.0)


def test_unfinished_games_are_counted() -> None:
    played = [_played([100.0, np.inf]), _played([300.0, 500.0])]
    assert finished(played, 3) == (3, 4)
    assert finished_share(played, 3).value == 0.75
    assert finished_share(played, 3).high == 1.0


def test_verdicts() -> None:
    assert below(Estimate(0.5, 0.4, 0.6, 3), 1.0) == HELD
    assert below(Estimate(1.5, 1.4, 1.6, 3), 1.0) == NOT_HELD
    assert below(Estimate(1.0, 0.9, 1.1, 3), 1.0) == OPEN
    assert above(Estimate(1.5, 1.4, 1.6, 3), 1.0) == HELD
    assert every([HELD, OPEN]) == OPEN
    assert every([HELD, OPEN, NOT_HELD]) == NOT_HELD
    assert every([HELD, HELD]) == HELD


def test_a_curve_has_the_interval_of_each_step() -> None:
    table = [np.array([0.0, 1.0]), np.array([0.0, 3.0]), np.array([0.0, 2.0])]
    mean, low, high = curve(table)
    found = mean_interval([1.0, 3.0, 2.0])
    assert (mean[1], low[1], high[1]) == pytest.approx(found[:3])
    assert mean[0] == low[0] == high[0] == 0.0


def test_numbers_as_people_read_them() -> None:
    assert [number(x) for x in (12345.0, 123.4, 12.34, 1.234, 0.1234, 0.0001234, 0.0)] == [
        "12,345",
        "123",
        "12.3",
        "1.23",
        "0.123",
        "0.00012",
        "0.000",
    ]
