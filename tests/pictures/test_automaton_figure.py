"""Automata drawn: everything is there, nothing lies on anything else, and files repeat."""

import re
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from conav.errors import InputError
from conav.pictures.automaton_figure import label_text, save_automaton, state_name
from conav.pictures.automaton_layout import RADIUS, Arrow, Edge, clashes, lay_out
from conav.tasks.automaton import Automaton
from conav.tasks.guard import guards
from conav.tasks.parse import parse_formula
from conav.tasks.translate import automaton_of, disjoint_letters

TEXTS = [
    "F goal & G safe",
    "F a & F b & G !c",
    "(!b U a) & F b",
    "sequence(a, b, c)",
    "coverage(a, b, c)",
    "G (request -> F dock) & F shelf & avoid(wet)",
    "false",
]


def of(text: str, disjoint: bool = False) -> Automaton:
    formula = parse_formula(text)
    return automaton_of(formula, disjoint_letters(formula.names) if disjoint else None)


def words(path: Path) -> list[str]:
    """What is written in an SVG: matplotlib keeps each line as a comment beside its outlines."""
    return [unescape(text) for text in re.findall(r"<!-- (.*?) -->", path.read_text())]


def edges(automaton: Automaton) -> list[Edge]:
    return [Edge(p, q, 0.09 * len(str(guard)), 0.18) for p, q, guard in guards(automaton)]


@pytest.mark.parametrize("text", TEXTS)
def test_nothing_covers_anything_else(text: str) -> None:
    """By the layout's own count, and by other arithmetic."""
    task = of(text)
    some = edges(task)
    layout = lay_out(task.n_states, some)
    assert layout.clashes == 0
    boxes = [
        (x - e.width / 2, y - e.height / 2, x + e.width / 2, y + e.height / 2)
        for e, (x, y) in zip(some, (arrow.label for arrow in layout.arrows), strict=True)
    ]
    for i, (left, down, right, up) in enumerate(boxes):
        for other in boxes[:i]:
            assert left > other[2] or right < other[0] or down > other[3] or up < other[1]
        for x, y in layout.states:
            nearest = (min(max(x, left), right), min(max(y, down), up))
            assert np.hypot(nearest[0] - x, nearest[1] - y) >= RADIUS
        for j, arrow in enumerate(layout.arrows):
            x, y = arrow.points.T
            if i != j:
                assert not ((left < x) & (x < right) & (down < y) & (y < up)).any()
    for a, b in ((p, q) for i, p in enumerate(layout.states) for q in layout.states[:i]):
        assert np.hypot(*(a - b)) > 2 * RADIUS


@pytest.mark.parametrize("text", TEXTS)
def test_arrows_go_from_border_to_border(text: str) -> None:
    task = of(text)
    some = edges(task)
    layout = lay_out(task.n_states, some)
    for edge, arrow in zip(some, layout.arrows, strict=True):
        for end, state in ((0, edge.source), (-1, edge.target)):
            assert np.hypot(*(arrow.points[end] - layout.states[state])) == pytest.approx(
                RADIUS, abs=0.02
            )


def test_clashes_are_counted() -> None:
    states = np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]])
    straight = np.linspace((RADIUS, 0.0), (4.0 - RADIUS, 0.0), 50)
    edge = Edge(0, 2, 0.4, 0.2)
    assert clashes(states, [edge], [Arrow(straight, (1.0, 0.5))]) == 1  # the state on the way
    assert clashes(states, [edge], [Arrow(straight, (2.0, 0.2))]) == 2  # and the label on it
    up = np.array([0.0, 1.0])
    around = straight + up
    other = Edge(0, 2, 0.4, 0.2)
    assert clashes(states, [edge, other], [Arrow(around, (1.0, 1.0))] * 2) == 3
    apart = [Arrow(around, (1.0, 1.0)), Arrow(straight - up, (1.0, -1.0))]
    assert clashes(states, [edge, other], apart) == 0


def test_everything_is_written(tmp_path: Path) -> None:
    task = of("F a & F b & G !c")
    save_automaton(tmp_path / "all.svg", task, title="a task", sink=True)
    seen = words(tmp_path / "all.svg")
    assert "a task" in seen
    assert not any("Not drawn" in text for text in seen)
    for state in range(task.n_states):
        assert seen.count(state_name(state)) == 1
    for guard in {str(guard) for _, _, guard in guards(task)}:
        assert seen.count(guard) == sum(str(other) == guard for *_, other in guards(task))


def test_the_sink_is_left_out_with_a_note(tmp_path: Path) -> None:
    """As in the paper, whose automaton for this task has two states."""
    task = of("F goal & G safe")
    save_automaton(tmp_path / "two.svg", task)
    seen = words(tmp_path / "two.svg")
    assert [text for text in seen if text.startswith("q")] == ["q₀", "q₂"]
    assert sorted(text for text in seen if "safe" in text) == [
        "goal & safe",
        "safe",
        "safe & !goal",
    ]
    assert any(text.startswith("Not drawn: q₁, from which") for text in seen)
    save_automaton(tmp_path / "never.svg", of("false"))  # there is nothing else
    assert words(tmp_path / "never.svg").count("q₀") == 1


def test_accepting_states_are_doubled(tmp_path: Path) -> None:
    """The same drawing but for what a state is."""
    rows = np.zeros((1, 1), dtype=np.int32)
    for name, ends in (("yes", True), ("no", False)):
        task = Automaton((), (frozenset(),), rows, np.array([ends]))
        save_automaton(tmp_path / f"{name}.png", task)
    dark: list[int] = []
    for name in ("yes", "no"):
        with Image.open(tmp_path / f"{name}.png") as picture:
            dark.append(int((np.asarray(picture.convert("L")) < 128).sum()))
    assert dark[0] > dark[1] + 150


def test_long_labels_are_broken() -> None:
    guard = parse_formula("loading_dock & kitchen & !storage_room | garage")
    assert label_text(guard) == "loading_dock & kitchen\n& !storage_room\n| garage"
    assert label_text(parse_formula("a & !b")) == "a & !b"


def test_a_label_that_says_nothing_gives_a_number(tmp_path: Path) -> None:
    save_automaton(tmp_path / "odd.svg", of("F (a <-> b <-> c <-> d <-> e)"))
    seen = words(tmp_path / "odd.svg")
    assert seen.count("16 of 32") == 2
    assert seen.count("label sets") == 2


def test_files_repeat(tmp_path: Path) -> None:
    for suffix in ("png", "svg"):
        for name in ("a", "b"):
            save_automaton(tmp_path / f"{name}.{suffix}", of("F a & G !b"), title="t")
        first, second = (tmp_path / f"{name}.{suffix}" for name in ("a", "b"))
        assert first.read_bytes() == second.read_bytes()


def test_too_many_states(tmp_path: Path) -> None:
    task = of("coverage(a, b, c, d, e)", disjoint=True)
    with pytest.raises(InputError, match="its 32 states are too many to draw"):
        save_automaton(tmp_path / "no.png", task)
    assert not (tmp_path / "no.png").exists()
