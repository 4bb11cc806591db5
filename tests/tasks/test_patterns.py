"""Tasks that occur all the time: what they accept, and where they differ from OMPL's automata."""

import pytest

from conav.errors import InputError
from conav.tasks.formula import region
from conav.tasks.parse import parse_formula
from conav.tasks.patterns import PATTERNS, avoid, coverage, sequence
from conav.tasks.translate import automaton_of, disjoint_letters


def word(text: str) -> list[set[str]]:
    """`a ab -` is in a, then in a and b, then nowhere."""
    return [set(part) - {"-"} for part in text.split()]


@pytest.mark.parametrize(
    ("text", "accepted", "refused"),
    [
        ("coverage(a, b, c)", ["abc", "c - b - a", "ab - c"], ["-", "a b", "a b a b"]),
        ("sequence(a, b, c)", ["a b c", "c b a b a c", "abc", "ab c"], ["c b a", "b c", "a c b"]),
        ("avoid(a, b)", ["-", "c", "- c -"], ["a", "c b", "- - ab"]),
        ("coverage(a)", ["a", "- a -"], ["-", "b"]),
        ("avoid(a)", ["b", "-"], ["a"]),
        ("sequence(a)", ["a"], ["b"]),
    ],
)
def test_what_they_accept(text: str, accepted: list[str], refused: list[str]) -> None:
    task = automaton_of(parse_formula(text), [set(some) for some in ("", *"abc", "ab", "abc")])
    for each in accepted:
        assert task.accepts(word(each)), each
    for each in refused:
        assert not task.accepts(word(each)), each


def test_text_and_functions_say_the_same() -> None:
    for name, function in PATTERNS.items():
        assert parse_formula(f"{name}(a, b, c)") == function("a", "b", "c")
        assert parse_formula(f"{name}(a | b, !c)") == function(
            parse_formula("a | b"), parse_formula("!c")
        )
        with pytest.raises(InputError, match="has no regions"):
            function()
    # A text is a name, whatever it looks like.
    assert coverage("F a").names == {"F a"}
    assert coverage(region("a"), "b") == coverage("a", "b")


@pytest.mark.parametrize("count", range(1, 7))
def test_sizes(count: int) -> None:
    """OMPL's automata over regions that do not overlap, and none for avoid but the sink."""
    names = [f"r{i}" for i in range(count)]
    for letters in (None, disjoint_letters(names)):
        assert automaton_of(coverage(*names), letters).n_states == 2**count
        assert automaton_of(sequence(*names), letters).n_states == count + 1
        assert automaton_of(avoid(*names), letters).n_states == 2


def test_two_regions_at_once_both_count() -> None:
    """OMPL's automata move on by one region a letter; ours by all that the letter holds."""
    for task in (coverage("a", "b"), sequence("a", "b")):
        assert automaton_of(task).accepts([{"a", "b"}])
