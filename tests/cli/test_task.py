"""`conav task`: what it prints, draws and refuses."""

import json
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

GOAL = "F goal & G safe"


def test_the_table_for_people(conav: Any) -> None:
    outcome = conav("task", GOAL)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.splitlines() == [
        "F goal & G safe",
        "  3 states over 4 label sets",
        "  satisfiable: a shortest word is {goal, safe}",
        "  not valid",
        "  state             label         next",
        "  q0     initial    safe & !goal  q0",
        "                    !safe         q1",
        "                    goal & safe   q2",
        "  q1     sink       true          q1",
        "  q2     accepting  !safe         q1",
        "                    safe          q2",
    ]


def test_the_json(conav: Any) -> None:
    outcome = conav("task", GOAL, "--json")
    assert outcome.out.count("\n") == 1
    assert json.loads(outcome.out) == {
        "job": "task",
        "formula": GOAL,
        "propositions": ["goal", "safe"],
        "letters": [[], ["goal"], ["safe"], ["goal", "safe"]],
        "states": 3,
        "transition": [[1, 1, 0, 2], [1, 1, 1, 1], [1, 1, 2, 2]],
        "accepting": [False, False, True],
        "sink": [False, True, False],
        "distance_to_accept": [1, -1, 0],
        "satisfiable": True,
        "valid": False,
        "stutter_invariant": True,
        "shortest_word": [["goal", "safe"]],
        "picture": None,
    }


def test_satisfiable_and_valid(conav: Any) -> None:
    never = conav("task", "F a & G !a")
    assert never.code == 1
    assert "not satisfiable: no robot can do it" in never.out
    assert "q0     initial, sink  true   q0" in never.out
    assert json.loads(conav("task", "F a & G !a", "--json").out)["shortest_word"] is None
    always = conav("task", "F a | G !a")
    assert always.code == 0
    assert "valid: every word does it" in always.out
    assert "1 state over 2 label sets" in always.out


def test_regions_that_do_not_overlap(conav: Any) -> None:
    assert conav("task", "F (a & b)").code == 0
    assert conav("task", "F (a & b)", "--disjoint").code == 1
    made = json.loads(conav("task", "coverage(a, b)", "--disjoint", "--json").out)
    assert made["letters"] == [[], ["a"], ["b"]]
    assert made["shortest_word"] == [["a"], ["b"]]


def test_next_is_for_those_who_ask(conav: Any) -> None:
    refused = conav("task", "X a")
    assert (refused.code, refused.out) == (2, "")
    assert "a letter only where the regions change" in refused.err
    allowed = conav("task", "X a", "--next")
    assert allowed.code == 0
    assert "words that repeat a letter count here" in allowed.out
    assert "words that repeat" not in conav("task", "F a", "--next").out


def test_a_table_too_long(conav: Any) -> None:
    names = [f"r{i}" for i in range(7)]
    outcome = conav("task", f"coverage({', '.join(names)})", "--disjoint")
    assert outcome.code == 0
    assert "128 states are too many for a table; --json has all" in outcome.out
    assert " -> " not in outcome.out
    refused = conav("task", f"coverage({', '.join(names)})", "--disjoint", "--max-states", "100")
    assert refused.code == 2
    assert "more than 100 states before minimisation" in refused.err


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_the_picture(conav: Any, suffix: str) -> None:
    outcome = conav("task", "F a & G !b", "--out", f"task.{suffix}")
    assert outcome.code == 0
    assert outcome.out.endswith(f"  picture: task.{suffix}\n")
    if suffix == "png":
        with Image.open("task.png") as picture:
            picture.load()
            small = picture.size
        conav("task", "F a & G !b", "--out", "sink.png", "--sink")
        with Image.open("sink.png") as picture:
            assert picture.width > small[0]
    else:
        assert "<!-- a &amp; !b -->" in Path("task.svg").read_text()


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["F goal & G savf", "--regions", "goal,safe"], ["column 12", "did you mean safe?"]),
        (["F goal &"], ["formula, column 9: a formula is missing at the end"]),
        ([""], ["there is no formula"]),
        (["(" * 10_000], ["nested more than 100 deep"]),
    ],
)
def test_bad_formulas_are_shown_with_a_caret(
    conav: Any, arguments: list[str], parts: list[str]
) -> None:
    outcome = conav("task", *arguments)
    assert (outcome.code, outcome.out) == (2, "")
    message, shown, caret = outcome.err.removesuffix("\n").split("\n")
    for part in parts:
        assert part in message
    assert caret.strip() == "^"
    assert caret.index("^") <= len(shown)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        ([], ["FORMULA requires an argument"]),
        (["F a", "--regions", "a,,b"], ["--regions a,,b: has an empty name"]),
        (["F a", "--max-states", "many"], ['"many" is not a whole number']),
        (["F a", "--out", "task.jpg"], ["task.jpg", "end the name in .png"]),
        (["F a", "--out", "no/task.png"], ["there is no folder no"]),
        (
            [f"sequence({','.join(f'r{i}' for i in range(30))})", "--disjoint", "--out", "t.png"],
            ["its 31 states are too many to draw", "at most 24"],
        ),
        ([" & ".join(f"F r{i}" for i in range(20))], ["20 regions", "1048576 label sets"]),
    ],
)
def test_refusals(conav: Any, arguments: list[str], parts: list[str]) -> None:
    outcome = conav("task", *arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.count("\n") == 1
    for part in parts:
        assert part in outcome.err
