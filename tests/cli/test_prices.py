"""conav prices: what it prints and refuses."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any


def test_exact_prices_are_printed(conav: Callable[..., Any]) -> None:
    outcome = conav("prices", "corridor-with-a-bay", "--slack", "4", "--mechanisms")
    assert outcome.code == 0
    lines = outcome.out.splitlines()
    assert lines[0] == "corridor with a bay: 2 robots, a horizon of 64 steps"
    assert "  optimum 11 steps, 8 if alone" in lines
    assert "  208 equilibria, from 11 to 15" in lines
    assert "  price of stability 1, price of anarchy 1.364" in lines
    assert "  tolls fails: an equilibrium of 15 under it is" in lines
    assert "    a: 0,0 0,1 0,2 0,1 0,1 0,2 0,3 0,4" in lines
    assert not any(line.startswith("  right of way fails") for line in lines)


def test_json_has_the_same_numbers(conav: Callable[..., Any]) -> None:
    content = json.loads(conav("prices", "cross", "--slack", "3", "--json").out)
    assert content["job"] == "prices"
    assert (content["optimum"], content["equilibria"], content["slack"]) == (9, 4, 3)
    assert content["price_of_anarchy"] == content["price_of_stability"] == 1.0
    assert content["paths"] == [77, 77]


def test_large_ones_are_sampled_and_say_so(conav: Callable[..., Any]) -> None:
    outcome = conav("prices", "open", "--slack", "5", "--starts", "6")
    assert outcome.code == 0
    assert "sampled" in outcome.err
    assert "  sampled, 6 starts: " in outcome.out
    assert "of anarchy" in outcome.out


def test_bad_input_is_refused(conav: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "odd.txt").write_text("a..\nA\n")
    for arguments in (("nothing",), ("odd.txt",), ("cross", "--robots", "5"), ("no.txt",)):
        outcome = conav("prices", *arguments)
        assert outcome.code == 2
        assert outcome.err.startswith("conav: ")
        assert "Traceback" not in outcome.err
