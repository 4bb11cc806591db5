"""Time against bandwidth: the numbers are those of the runs, and the files hold them."""

import csv
from pathlib import Path

import pytest

import conav
from conav.experiments.quiet_radio import (
    ALWAYS_ON,
    MAX_TIME_S,
    ROBOTS,
    S_RANGE,
    SHARES,
    TEAMS,
    WORLD,
    Bandwidth,
    QuietTeam,
    draw_bandwidth,
    quiet_radio,
    write_bandwidth,
)

FEW = (
    QuietTeam("k = 1", "every k steps", {"every": 1}),
    QuietTeam("k = 30", "every k steps", {"every": 30}),
    QuietTeam("r = 6", "within r", {"every": 0, "within_m": 6.0}),
)


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> list[Bandwidth]:
    folder = tmp_path_factory.mktemp("study")
    told: list[tuple[int, int]] = []
    found = quiet_radio(
        folder,
        layouts=3,
        teams=FEW,
        jobs=1,
        progress=lambda done, total: told.append((done, total)),
    )
    assert told[-1] == (12, 12)
    again = quiet_radio(folder, layouts=3, teams=FEW, jobs=1)
    assert again == found
    return found


def test_the_numbers_are_those_of_the_runs(rows: list[Bandwidth]) -> None:
    assert [row.label for row in rows] == [ALWAYS_ON, "k = 1", "k = 30", "r = 6"]
    for row, settings in zip(rows[1:], (team.settings for team in FEW), strict=True):
        played = [
            conav.explore(
                "three-obstacles",
                strategy="potential-quiet",
                settings=settings,
                robots=ROBOTS,
                range_m=S_RANGE,
                seed=seed,
                max_time_s=MAX_TIME_S,
                **WORLD,
            ).metrics
            for seed in range(3)
        ]
        rate = sum(one.bytes / (ROBOTS * one.steps) for one in played) / 3
        assert row.bytes.value == pytest.approx(rate)
        assert row.total.value == pytest.approx(sum(one.bytes for one in played) / 3)
        assert row.times[0].value == pytest.approx(sum(one.t90_s or 0.0 for one in played) / 3)
        assert row.times[2].value == pytest.approx(sum(one.t100_s or 0.0 for one in played) / 3)
        assert row.finished == 3


def test_ratios_are_to_the_team_that_is_always_on(rows: list[Bandwidth]) -> None:
    always, every, seldom, near = rows
    for row in (always, every, near):  # these three drive the same
        assert [at.value for at in row.ratios] == [1.0] * len(SHARES)
        assert row.times == always.times
    assert seldom.ratios[2].value != 1.0
    assert seldom.bytes.value < near.bytes.value < always.bytes.value < every.bytes.value


def test_the_files_hold_them(rows: list[Bandwidth], tmp_path: Path) -> None:
    write_bandwidth(rows, tmp_path / "bandwidth.csv")
    with (tmp_path / "bandwidth.csv").open(newline="") as stream:
        lines = list(csv.DictReader(stream))
    assert [line["team"] for line in lines] == [row.label for row in rows]
    for line, row in zip(lines, rows, strict=True):
        assert int(line["done"]) == row.finished
        assert float(line["bytes_per_robot_step"]) == pytest.approx(row.bytes.value, rel=1e-5)
        for share, time, ratio in zip(SHARES, row.times, row.ratios, strict=True):
            assert float(line[f"t{share}_s"]) == pytest.approx(time.value, rel=1e-5)
            assert float(line[f"t{share}_ratio_high"]) == pytest.approx(ratio.high, rel=1e-5)
    pytest.importorskip("matplotlib")
    for share in SHARES:
        draw_bandwidth(rows, tmp_path / f"{share}.png", share, note="a note")
        assert (tmp_path / f"{share}.png").read_bytes()[:4] == b"\x89PNG"


def test_every_team_has_its_own_rule() -> None:
    assert len({team.label for team in TEAMS}) == len(TEAMS)
    assert len({tuple(sorted(team.settings.items())) for team in TEAMS}) == len(TEAMS)
