"""conav execute: what it prints, writes and refuses."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image

PLAN = (
    "plan", "antipodal-circle:2", "--samples", "100", "--out", "plan.mcap",
)  # fmt: skip


def test_a_plan_is_driven_and_verified(conav: Callable[..., Any], tmp_path: Path) -> None:
    assert conav(*PLAN).code == 0
    files = ("--out", "driven.mcap", "--png", "d.png", "--gif", "d.gif")
    options = ("--tracking-error", "0.05", "--delay", "0.5", "--slack", "0.1", "--seed", "3")
    outcome = conav("execute", "plan.mcap", *options, *files, "--json")
    summary = json.loads(outcome.out)
    assert outcome.code == (1 if summary["touched"] else 0)
    assert summary["safe_margin_m"] == 0.6
    assert summary["margin_m"] == 0.2
    assert 0 < summary["deviation_m"] <= 0.05
    assert summary["run"] == "driven.mcap"
    assert all(0 <= robot["lag_s"] <= 0.5 for robot in summary["robots"])
    for name in ("d.png", "d.gif"):
        with Image.open(tmp_path / name) as picture:
            picture.verify()
    checked = conav("verify", "driven.mcap")
    assert checked.code == 0, checked.out
    assert "deviations: ok" in checked.out
    said = json.loads(conav("verify", "driven.mcap", "--json").out)
    assert said["verdict"] == "verified"
    assert said["clearance"]["robots"]["at_least_m"] <= summary["clearance_m"] + 1e-6
    told = conav("execute", "plan.mcap", *options).out
    assert "the plan keeps a margin of 0.2 m, 0.6 m is safe" in told


def test_touching_is_told_and_ends_with_1(conav: Callable[..., Any]) -> None:
    conav(*PLAN)
    outcome = conav("execute", "plan.mcap", "--tracking-error", "2")
    assert outcome.code == 1
    assert "overlap" in outcome.out


def test_bad_input_is_refused(conav: Callable[..., Any]) -> None:
    conav(*PLAN)
    for arguments, words in (
        (("missing.mcap",), "missing.mcap"),
        (("plan.mcap", "--out", "plan.mcap"), "the plan itself"),
        (("plan.mcap", "--out", "x.txt"), ".mcap"),
        (("plan.mcap", "--png", "no/x.png"), "folder"),
        (("plan.mcap", "--delay", "-1"), "delay"),
        (("plan.mcap", "--slack", "9"), "radius"),
    ):
        outcome = conav("execute", *arguments)
        assert outcome.code == 2
        assert words in outcome.err
        assert "Traceback" not in outcome.err
