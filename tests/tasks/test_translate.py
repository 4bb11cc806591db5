"""Automata: they accept what finite LTL says, they are minimal, and equal where languages are."""

from collections.abc import Callable, Iterator
from itertools import product
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.tasks import progression
from conav.tasks.automaton import INITIAL, Automaton, stutter_free
from conav.tasks.formula import BINDING, MAX_DEPTH, UNARY, Formula, Operator, region
from conav.tasks.parse import parse_formula
from conav.tasks.translate import (
    automaton_of,
    disjoint_letters,
    equivalent_states,
    every_letter,
)

LETTERS = every_letter("ab")
Word = tuple[frozenset[str], ...]


def words(letters: tuple[frozenset[str], ...], longest: int) -> Iterator[Word]:
    """All words of one letter at least."""
    for length in range(1, longest + 1):
        yield from product(letters, repeat=length)


def of(text: str, letters: Any = None) -> Automaton:
    return automaton_of(parse_formula(text, allow_next=True), letters)


# --- What is accepted


def word(text: str) -> list[set[str]]:
    """`a ab -` is in a, then in a and b, then nowhere; the empty text is the empty word."""
    return [set(part) - {"-"} for part in text.split()]


@pytest.mark.parametrize(
    ("text", "accepted", "refused"),
    [
        ("true", ["-", "a - b"], [""]),
        ("false", [], ["", "-", "a"]),
        ("a", ["a", "a -", "ab b"], ["-", "b a"]),
        ("!a", ["-", "b a"], ["a", "ab -"]),
        ("a & b", ["ab -"], ["a", "a b"]),
        ("a | b", ["a", "b a"], ["-", "- a"]),
        ("a -> b", ["-", "b a", "ab"], ["a", "a b"]),
        ("a <-> b", ["-", "ab", "- a"], ["a", "b ab"]),
        ("F a", ["a", "- a", "- a -"], ["-", "b", "- b -"]),
        ("G a", ["a", "a ab a"], ["-", "a -", "- a", "a b a"]),
        ("a U b", ["b", "a b", "ab", "a ab b -", "b - a"], ["a", "- b", "a - b", "a"]),
        ("a R b", ["b", "b ab", "ab -", "b ab a"], ["a", "b -", "b a", "-", "a b"]),
        ("a W b", ["a", "a b -", "b", "a ab a"], ["-", "a -", "a - b"]),
        ("X a", ["- a", "b a -"], ["a", "-", "- b a"]),
        ("WX a", ["-", "a", "- a -"], ["- b", "a - a"]),
        ("X true", ["- a", "a b a"], ["-", "a"]),
        ("F WX false", ["-", "a b a"], [""]),
        ("G X a", [], ["a", "- a", "a a a"]),
        ("G WX a", ["-", "- a", "b a ab"], ["- a -", "a b"]),
        ("F (a & X b)", ["a b", "- a ab -"], ["a", "ab", "a - b"]),
        ("G (a -> F b)", ["-", "a b", "ab", "b a - b"], ["a", "a b a", "b a"]),
        ("F G a", ["a", "- a", "- b a"], ["a -", "-"]),
        ("G F a", ["a", "- a"], ["a -", "-"]),
        ("(!b U a) & F b", ["ab", "a b", "- a - b"], ["b a", "a", "b"]),
    ],
)
def test_every_operator_by_hand(
    text: str, accepted: list[str], refused: list[str], holds: Callable[..., bool]
) -> None:
    formula = parse_formula(text, allow_next=True)
    task = of(text, LETTERS)
    for each in accepted:
        assert task.accepts(word(each)), each
        assert holds(formula, word(each)), each
    for each in refused:
        assert not task.accepts(word(each)), each
        assert not (each and holds(formula, word(each))), each


def test_seventy_thousand_words(
    holds: Callable[..., bool], random_formula: Callable[..., Formula]
) -> None:
    """200 formulas up to size 7, with and without X, on every word of up to four letters."""
    rng = Random(1)
    short = list(words(LETTERS, 4))
    sizes: set[int] = set()
    accepted = 0
    for i in range(200):
        formula = random_formula(rng, rng.randint(1, 7), "ab", bool(i % 2))
        task = automaton_of(formula, LETTERS)
        sizes.add(task.n_states)
        for each in short:
            expected = holds(formula, each)
            accepted += expected
            assert task.accepts(each) == expected, (str(formula), each)
    # The check means something: neither all true nor all of a kind.
    assert 0.2 < accepted / (200 * len(short)) < 0.8
    assert {1, 2, 3, 4, 5} <= sizes


@given(data=st.data())
@settings(max_examples=200, deadline=None)
def test_words_of_three_regions(
    data: Any, formulas: Callable[..., Any], holds: Callable[..., bool]
) -> None:
    formula = data.draw(formulas("abc", with_next=True))
    letters = data.draw(st.lists(st.sampled_from(every_letter("abcd")), min_size=1, unique=True))
    task = automaton_of(formula, letters)
    for each in data.draw(st.lists(st.lists(st.sampled_from(letters), min_size=1, max_size=9))):
        assert task.accepts(each) == holds(formula, each)


# --- Stuttering


@given(data=st.data())
@settings(max_examples=200, deadline=None)
def test_repeated_letters_change_nothing_without_next(
    data: Any, formulas: Callable[..., Any]
) -> None:
    formula = data.draw(formulas("ab"))
    task = automaton_of(formula, LETTERS)
    assert task.stutter_invariant
    after = task.transition
    for letter in range(len(LETTERS)):
        once = after[:, letter]
        assert np.array_equal(after[once, letter], once)
    each = data.draw(st.lists(st.sampled_from(LETTERS), min_size=1, max_size=8))
    longer = [letter for letter in each for _ in range(data.draw(st.integers(1, 3)))]
    assert task.accepts(longer) == task.accepts(each) == task.accepts(stutter_free(longer))


def test_next_does_count_letters() -> None:
    task = of("X a")
    assert not task.stutter_invariant
    assert of("X a | !X a").stutter_invariant  # where X says nothing
    assert not task.accepts([{"a"}])
    assert task.accepts([{"a"}, {"a"}])


# --- Size and shape


@pytest.mark.parametrize(
    ("text", "states", "sinks"),
    [
        ("F goal & G safe", 3, 1),
        ("F a & F b & G !c", 5, 1),
        ("(!b U a) & F b", 4, 1),
        ("F a", 2, 0),
        ("G a", 2, 1),
        ("a", 3, 1),
        ("true", 1, 0),
        ("F true", 1, 0),
        ("false", 1, 1),
        ("G (a -> F b)", 2, 0),
        ("sequence(a, b, c, d)", 5, 0),
        ("X X X a", 6, 1),
    ],
)
def test_sizes(text: str, states: int, sinks: int) -> None:
    task = of(text)
    assert (task.n_states, int(task.sink.sum())) == (states, sinks)


def distinguishable(task: Automaton) -> set[tuple[int, int]]:
    """Pairs of states that some word tells apart, by filling the table from acceptance back."""
    told = {(p, q) for p in range(task.n_states) for q in range(task.n_states)
            if task.accepting[p] != task.accepting[q]}  # fmt: skip
    while True:
        more = {
            (p, q)
            for p in range(task.n_states)
            for q in range(task.n_states)
            if any((int(a), int(b)) in told
                   for a, b in zip(task.transition[p], task.transition[q], strict=True))
        } - told  # fmt: skip
        if not more:
            return told
        told |= more


def residuals(formula: Formula, holds: Callable[..., bool], longest: int) -> set[tuple[bool, ...]]:
    """What short words of a letter at least make of the short words after them, by definition."""
    rests = [(), *words(LETTERS, longest)]
    return {
        tuple(holds(formula, before + rest) for rest in rests) for before in words(LETTERS, longest)
    }


def test_no_two_states_are_alike_and_none_is_missing(
    holds: Callable[..., bool], random_formula: Callable[..., Formula]
) -> None:
    """Every pair of states is told apart by a word, and the states are those of the definition.

    A language has a state for each residual by a word; the state before the first letter is one of
    them where another goes on as it does.
    """
    rng = Random(2)
    own = compared = 0
    for i in range(150):
        formula = random_formula(rng, rng.randint(1, 5), "ab", bool(i % 2))
        task = automaton_of(formula, LETTERS)
        n = task.n_states
        assert len(distinguishable(task)) == n * (n - 1)
        returned = INITIAL in task.transition
        own += not returned
        if n <= 3 and i < 60:  # three letters reach all and tell all apart
            compared += 1
            assert n == len(residuals(formula, holds, 3)) + (not returned)
        if not returned:
            # No other state could have stood for it.
            assert not (task.transition[1:] == task.transition[INITIAL]).all(axis=1).any()
    assert 10 < own < 140
    assert compared > 20


def test_numbers_are_those_of_a_breadth_first_search(
    random_formula: Callable[..., Formula],
) -> None:
    rng = Random(3)
    for _ in range(100):
        task = automaton_of(random_formula(rng, 6, "ab", True), LETTERS)
        met = list(dict.fromkeys([INITIAL, *task.transition.ravel().tolist()]))
        assert met == list(range(task.n_states))


@pytest.mark.parametrize(
    "texts",
    [
        ["F a & F b", "F b & F a", "coverage(b, a)", "!(G !a | G !b)", "F a & F (F b | F F b)"],
        ["!F a", "G !a", "avoid(a)", "false R !a", "!a W false"],
        ["a W b", "G a | (a U b)", "b R (a | b)", "!(!b U (!a & !b))"],
        ["a R b", "!(!a U !b)", "b W (a & b)"],
        ["true", "F true", "a | !a", "F a | G !a", "WX true", "G true", "F a -> true U a"],
        ["false", "F a & G !a", "X false", "G false", "G X true"],
        ["sequence(a, b)", "F (a & F b)", "F F (a & F b)"],
        ["X a", "!WX !a"],
        ["a <-> b", "!(a <-> !b)", "(a -> b) & (b -> a)"],
    ],
)
def test_equal_languages_have_equal_automata(texts: list[str]) -> None:
    tasks = [of(text, LETTERS) for text in texts]
    assert all(task == tasks[0] for task in tasks)
    assert len({hash(task) for task in tasks}) == 1
    assert tasks[0] != of("F a & !b", LETTERS)
    assert tasks[0] != "F a"


@given(data=st.data())
@settings(max_examples=100, deadline=None)
def test_automata_are_equal_just_where_the_formulas_are_equivalent(
    data: Any, formulas: Callable[..., Any]
) -> None:
    first, second = data.draw(formulas("ab", with_next=True)), data.draw(formulas("ab"))
    same = automaton_of(Formula(Operator.IFF, (first, second)), LETTERS).valid
    assert same == (automaton_of(first, LETTERS) == automaton_of(second, LETTERS))
    negated = automaton_of(Formula(Operator.NOT, (first,)), LETTERS)
    assert negated.satisfiable == (not automaton_of(first, LETTERS).valid)
    double = Formula(Operator.NOT, (Formula(Operator.NOT, (first,)),))
    assert automaton_of(double, LETTERS) == automaton_of(first, LETTERS)


# --- Letters


def test_only_letters_that_occur() -> None:
    text = "F a & F b & G !c"
    apart = of(text, disjoint_letters("abc"))
    assert apart.letters == tuple(map(frozenset, ("", "a", "b", "c")))
    assert apart.n_states == 5
    assert not apart.accepts([{"a"}])
    with pytest.raises(InputError, match=r"label \{a, b\}: is none of the 4 that can occur"):
        apart.accepts([{"a", "b"}])
    # Where nothing overlaps, to be in two places at once is impossible, and to be nowhere may be.
    assert not of("F (a & b)", disjoint_letters("ab")).satisfiable
    assert of("G (a | b)", [{"a"}, {"b"}]).valid
    assert of("F c", [{"a"}, {"b"}]).propositions == ("a", "b", "c")
    assert not of("F c", [{"a"}, {"b"}]).satisfiable


def test_letters_come_in_one_order_and_once() -> None:
    given = [{"b"}, {"a", "b"}, (), ["a"], {"b"}]
    assert of("F a", given).letters == tuple(map(frozenset, ("", "a", "b", "ab")))
    assert of("F a", given) == of("F a", reversed(given))


def test_names_the_formula_has_not() -> None:
    task = of("F a")
    assert task.accepts([{"a", "kitchen"}])
    assert task.letter({"kitchen"}) == task.letter(())
    given = of("F a", [set(), {"a"}, {"kitchen"}, {"a", "kitchen"}])
    assert given.letters[2] == {"kitchen"}
    assert np.array_equal(given.transition[:, 2], given.transition[:, 0])


def test_letters_that_are_none() -> None:
    with pytest.raises(InputError, match=r"letter 'ab': is a text and no set of names"):
        of("F a", ["ab"])
    with pytest.raises(InputError, match="letters: there is none"):
        of("F a", [])


# --- Limits


def test_a_limit_on_states_names_them() -> None:
    formula = parse_formula("coverage(a, b, c, d)")
    assert automaton_of(formula, max_states=16).n_states == 16
    with pytest.raises(InputError, match=r"more than 15 states .*max_states"):
        automaton_of(formula, max_states=15)


def test_a_limit_on_letters() -> None:
    names = [f"r{i}" for i in range(13)]
    formula = parse_formula(f"sequence({', '.join(names)})")
    with pytest.raises(InputError, match=r"13 regions .* 8192 label sets"):
        automaton_of(formula)
    assert automaton_of(formula, disjoint_letters(names)).n_states == 14


def test_a_limit_on_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    """(F a1 | G b1) & ... is 2^k clauses of obligations."""
    text = " & ".join(f"(F a{i} | G b{i})" for i in range(4))
    letters = [{f"b{i}" for i in range(4)}, {f"a{i}" for i in range(4)}]
    assert of(text, letters).satisfiable
    monkeypatch.setattr(progression, "MAX_CLAUSES", 4)
    with pytest.raises(InputError, match=r"takes \d+ cases, and at most 4 are followed"):
        of(text, letters)


def nested(operator: Operator) -> Formula:
    """As deep as can be: !!...a, or a U (a U (...))."""
    formula = region("a")
    while formula.depth < MAX_DEPTH:
        operands = (formula,) if operator in UNARY else (region("a"), formula)
        formula = Formula(operator, operands)
    return formula


@pytest.mark.parametrize("operator", [op for op in Operator if op in UNARY or op in BINDING])
def test_the_deepest_formulas_are_translated(
    operator: Operator, holds: Callable[..., bool]
) -> None:
    formula = nested(operator)
    task = automaton_of(formula)
    for each in words(every_letter("a"), 1):
        assert task.accepts(each) == holds(formula, each)
    assert task.n_states <= MAX_DEPTH + 2


def test_formulas_that_repeat_parts_stay_small() -> None:
    """<-> takes each side twice; equal subformulas are kept once."""
    text = " <-> ".join("ab"[i % 2] for i in range(60))
    assert of(text, LETTERS) == of("true", LETTERS)
    assert of(" <-> ".join(["F a"] * 60), LETTERS) == of("true", LETTERS)


# --- Minimisation by itself


@given(data=st.data())
@settings(max_examples=100)
def test_equivalent_states(data: Any) -> None:
    n, k = data.draw(st.integers(1, 7)), data.draw(st.integers(1, 3))
    rows = data.draw(st.lists(st.lists(st.integers(0, n - 1), min_size=k, max_size=k),
                              min_size=n, max_size=n))  # fmt: skip
    ends = data.draw(st.lists(st.booleans(), min_size=n, max_size=n))
    classes = equivalent_states(np.array(rows), np.array(ends))
    task = Automaton((), tuple(frozenset({str(i)}) for i in range(k)), np.array(rows, np.int32),
                     np.array(ends))  # fmt: skip
    told = distinguishable(task)
    for p in range(n):
        for q in range(n):
            assert (classes[p] == classes[q]) == ((p, q) not in told)
    assert set(classes.tolist()) == set(range(int(classes.max()) + 1))
