"""conav pursue: what it prints, writes and refuses."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image


def test_a_floor_is_cleared(conav: Callable[..., Any], tmp_path: Path) -> None:
    outcome = conav("pursue", "rooms:3", "--out", "p.mcap", "--png", "p.png")
    assert outcome.code == 0, outcome.err
    lines = outcome.out.splitlines()
    assert lines[0] == "rooms:3: 1 pursuer: nobody can slip away (verified)"
    assert lines[2] == "  no smaller team can do it"
    with Image.open(tmp_path / "p.png") as picture:
        assert picture.format == "PNG"
    outcome = conav("verify", "p.mcap")
    assert outcome.code == 0, outcome.out
    assert "captured" in outcome.out


def test_json(conav: Callable[..., Any]) -> None:
    outcome = conav("pursue", "ring", "--json", "--start", "1,1", "--speed", "2")
    assert outcome.code == 0, outcome.err
    summary = json.loads(outcome.out)
    assert summary["pursuers"] == 2
    assert summary["verdict"] == "captured"
    assert summary["minimal_proved"] is True
    assert summary["lower_bound"] == 2
    assert summary["time_s"] == pytest.approx(summary["distance_m"] / 2)


def test_random_evaders(conav: Callable[..., Any]) -> None:
    arguments = ("pursue", "rooms:3", "--evader", "random", "--evaders", "40")
    lines = conav(*arguments, "--evader-speed", "0.5").out.splitlines()
    assert lines[2].startswith("  40 of 40 random evaders at 0.5 m/s seen, after ")
    one, again, other = (
        json.loads(conav(*arguments, "--seed", seed, "--json").out) for seed in ("4", "4", "5")
    )
    assert one["evader"] == again["evader"] != other["evader"]
    assert one["evader"]["caught"] == 40
    assert 0.0 < one["evader"]["mean_s"] < one["time_s"]


def test_what_labels_claim_is_judged(conav: Callable[..., Any]) -> None:
    arguments = ("pursue", "rooms:3", "--method", "splitting", "--labels", "paper")
    outcome = conav(*arguments)
    assert outcome.code == 1
    lines = outcome.out.splitlines()
    assert lines[0].endswith("claimed captured; an evader can slip away, the verifier found")
    assert len(lines) == 2
    summary = json.loads(conav(*arguments, "--json").out)
    assert (summary["claim"], summary["verdict"]) == ("captured", "escapes")
    assert (summary["method"], summary["labels"]) == ("splitting", "paper")
    assert summary["counters"]["states"] > 0


def test_delegation_and_a_loss(conav: Callable[..., Any]) -> None:
    arguments = ("pursue", "ring", "--method", "delegation", "--reach", "60")
    outcome = conav(*arguments, "--fault", "pursuer_2:dies:3", "--out", "d.mcap")
    assert outcome.code == 0, outcome.err
    lines = outcome.out.splitlines()
    assert lines[0] == "ring: 3 pursuers: nobody can slip away (verified)"
    assert lines[2] == "  2 calls for help, 12 messages, 1 lost"
    assert conav("verify", "d.mcap").code == 0


def test_a_floor_nobody_knows(conav: Callable[..., Any], tmp_path: Path) -> None:
    outcome = conav(
        *("pursue", "rooms:3", "--unknown", "--edb", "1", "--json"),
        *("--out", "u.mcap", "--png", "u.png", "--after", "6"),
    )
    assert outcome.code == 0, outcome.err
    summary = json.loads(outcome.out)
    assert summary["method"] == "unknown-map"
    assert summary["known"] is False
    assert summary["verdict"] == "captured"
    assert summary["explored"] == pytest.approx(1.0)
    assert summary["recontaminations"] > 0
    assert summary["counters"]["pursuits"] > 0
    with Image.open(tmp_path / "u.png") as picture:
        assert picture.format == "PNG"
    outcome = conav("verify", "u.mcap")
    assert outcome.code == 0, outcome.out
    outcome = conav("pursue", "rooms:3", "--unknown")
    assert "100% explored, contaminated again after" in outcome.out


def test_a_team_that_is_too_small(conav: Callable[..., Any]) -> None:
    outcome = conav("pursue", "ring", "--pursuers", "1")
    assert outcome.code == 1
    assert outcome.out.startswith("ring: infeasible: 1 pursuer cannot clear this floor")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("ring", "--pursuers", "none"), "give auto, or 1 to 60"),
        (("ring", "--pursuers", "0"), "give auto, or 1 to 60"),
        (("ring", "--start", "1"), "give x,y in metres"),
        (("ring", "--start", "50,50"), "off the floor"),
        (("ring", "--speed", "0"), "metres per second"),
        (("ring", "--set", "wieght=1"), "did you mean weight"),
        (("ring", "--evader", "clever"), "there is: random"),
        (("ring", "--evader-speed", "2"), "add --evader random"),
        (("ring", "--seed", "2"), "add --evader random"),
        (("ring", "--evader", "random", "--evaders", "0"), "give 1 or more"),
        (("ring", "--evader", "random", "--evader-speed=-1"), "give 0 m/s or more"),
        (("ring", "--method", "spliting"), "did you mean splitting?"),
        (("ring", "--labels", "none"), "there are: shadows, paper"),
        (("ring", "--method", "delegation", "--labels", "paper"), "there are: shadows"),
        (("ring", "--reach", "0"), "metres above 0"),
        (("ring", "--reach", "9"), "limited range or reach"),
        (("ring", "--fault", "pursuer_1:dies:3"), "use delegation"),
        (("ring", "--fault", "robot_1:dies:3"), "not in the team"),
        (("ring", "--fault", "pursuer_1:stalls:3"), "all it can do is die"),
        (("ring", "--unknown", "--edb", "0"), "1 or more, or unlimited"),
        (("ring", "--unknown", "--edb", "all"), "setting 'edb'"),
        (("ring", "--edb", "2"), "add --unknown"),
        (("ring", "--unknown", "--method", "splitting"), "is for known floors"),
        (("ring", "--unknown", "--start", "9,9"), "off the floor"),
        (("ring", "--after", "2"), "add --png"),
        (("ring", "--png", "a.png", "--after", "99"), "drives"),
        (("ring", "--out", "a.png"), "end it in .mcap"),
        (("ring", "--png", "no/a.png"), "make the folder first"),
        (("rings",), "ring"),
    ],
)
def test_bad_input(conav: Callable[..., Any], arguments: tuple[str, ...], words: str) -> None:
    outcome = conav("pursue", *arguments)
    assert outcome.code == 2
    assert words in outcome.err
    assert len(outcome.err.strip().splitlines()) == 1
