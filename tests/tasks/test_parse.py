"""Formulas from text and back, and what is said of text that is none."""

import pickle
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.tasks.formula import (
    MAX_DEPTH,
    Formula,
    Operator,
    always,
    conjunction,
    disjunction,
    eventually,
    negation,
    region,
)
from conav.tasks.parse import parse_formula

A, B, C = region("a"), region("b"), region("c")


def binary(operator: str, *operands: Formula) -> Formula:
    return Formula(Operator(operator), operands)


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("a", A),
        ("true", Formula(Operator.TRUE)),
        ("false", Formula(Operator.FALSE)),
        ("F goal & G safe", conjunction(eventually(region("goal")), always(region("safe")))),
        ("(!b U a) & F b", conjunction(binary("U", negation(B), A), eventually(B))),
        # An operator before a formula binds strongest, then U R W, then & before |, -> before <->.
        ("!b U a", binary("U", negation(B), A)),
        ("F a U b", binary("U", eventually(A), B)),
        ("a & b U c", conjunction(A, binary("U", B, C))),
        ("a | b & c", disjunction(A, conjunction(B, C))),
        ("a -> b | c", binary("->", A, disjunction(B, C))),
        ("a <-> b -> c", binary("<->", A, binary("->", B, C))),
        ("a & b -> c", binary("->", conjunction(A, B), C)),
        # Equals group to the right; & and | are one formula of all their operands.
        ("a -> b -> c", binary("->", A, binary("->", B, C))),
        ("a U b R c", binary("U", A, binary("R", B, C))),
        ("a W b U c", binary("W", A, binary("U", B, C))),
        ("a <-> b <-> c", binary("<->", A, binary("<->", B, C))),
        ("a & b & c", conjunction(A, B, C)),
        ("(a & b) & c", conjunction(conjunction(A, B), C)),
        ("((((a))))", A),
        # Other spellings.
        ("not a and b or c", disjunction(conjunction(negation(A), B), C)),
        ("NOT a AND b Or c", disjunction(conjunction(negation(A), B), C)),
        ("~a && b || c", disjunction(conjunction(negation(A), B), C)),
        ("a => b", binary("->", A, B)),
        ("a <=> b", binary("<->", A, B)),
        ("eventually a", eventually(A)),
        ("<>a", eventually(A)),
        ("always a", always(A)),
        ("[]a", always(A)),
        ("[]<>a", always(eventually(A))),
        ("a until b", binary("U", A, B)),
        ("a release b", binary("R", A, B)),
        ("  F\n\ta ", eventually(A)),
        ("!!a", negation(negation(A))),
        # Names.
        ('F "room 1"', eventually(region("room 1"))),
        ('"F" & "coverage"', conjunction(region("F"), region("coverage"))),
        ("Fa", region("Fa")),
        ("f", region("f")),
        ("büro_2", region("büro_2")),
        # Helpers.
        ("coverage(a, b)", conjunction(eventually(A), eventually(B))),
        ("coverage(a)", eventually(A)),
        ("sequence(a,b)", eventually(conjunction(A, eventually(B)))),
        ("avoid(c)", always(negation(C))),
        (
            "coverage(a & b, F c) | !avoid(c)",
            disjunction(
                conjunction(eventually(conjunction(A, B)), eventually(eventually(C))),
                negation(always(negation(C))),
            ),
        ),
    ],
)
def test_formulas(text: str, formula: Formula) -> None:
    assert parse_formula(text) == formula
    assert parse_formula(str(formula)) == formula


def test_next_where_it_is_allowed() -> None:
    for text, operator in (("X a", Operator.NEXT), ("WX a", Operator.WEAK_NEXT)):
        assert parse_formula(text, allow_next=True) == Formula(operator, (A,))
        with pytest.raises(InputError, match="a letter only where the regions change") as caught:
            parse_formula(f"b & {text}")
        assert "column 5" in caught.value.place
        assert "--next" in caught.value.remedy


@given(data=st.data())
@settings(max_examples=200)
def test_round_trip(data: Any, formulas: Callable[..., st.SearchStrategy[Formula]]) -> None:
    names = ("a", "wx", "U", "true", "room 1", "avoid", "é(", "42", "_")
    formula = data.draw(formulas(names, with_next=True))
    text = str(formula)
    assert parse_formula(text, allow_next=True) == formula
    assert str(parse_formula(text, allow_next=True)) == text


@given(text=st.text(alphabet='ab FGUX!&|<->()[],"~ \n\u00e9', max_size=24))
@settings(max_examples=400)
def test_any_text_is_a_formula_or_an_input_error(text: str) -> None:
    try:
        formula = parse_formula(text)
    except InputError as error:
        *_, line, caret = str(error).split("\n")
        assert caret.strip() == "^"
        assert caret.index("^") <= len(line)
    else:
        assert parse_formula(str(formula)) == formula


@pytest.mark.parametrize(
    ("text", "under", "parts"),
    [
        ("", "", ["there is no formula"]),
        ("   ", "", ["there is no formula"]),
        ("F", "", ["a formula is missing at the end"]),
        ("F a &", "", ["a formula is missing at the end"]),
        ("a & | b", "| b", ["a formula is missing before '|'"]),
        ("()", ")", ["a formula is missing before ')'"]),
        ("coverage()", ")", ["a formula is missing before ')'"]),
        ("coverage(a,)", ")", ["a formula is missing before ')'"]),
        ("a b", "b", ["there is no operator before 'b'", "for example &"]),
        ("a F b", "F b", ["there is no operator before 'F'"]),
        ("f goal", "goal", ["did you mean F for f?"]),
        ("(a u b)", "u b)", ["there is no operator before 'u'", "did you mean U for u?"]),
        ("(a", "(a", ["'(' is never closed"]),
        ("F (a & (b | c)", "(a & (b | c)", ["'(' is never closed"]),
        ("coverage(a, b", "(a, b", ["'(' is never closed"]),
        ("a) & b", ") & b", ["')' closes nothing"]),
        ("a, b", ", b", ["regions of a helper only"]),
        ("coverage a", "coverage a", ["in parentheses", '"coverage" for a region of that name']),
        ("a @ b", "@ b", ["'@' means nothing"]),
        ("room-1", "-1", ["'-' means nothing", '"room-1"']),
        ('F "room 1', '"room 1', ["the quote is never closed"]),
        ('F ""', '""', ["the name is empty"]),
        ("a\n  & ) & b", ") & b", ["a formula is missing before ')'", "column 7"]),
    ],
)  # fmt: skip
def test_bad_text_is_shown_with_a_caret(text: str, under: str, parts: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        parse_formula(text)
    message, line, caret = str(caught.value).split("\n")
    assert message.startswith("formula, column ")
    for part in parts:
        assert part in message
    assert line.strip() == text.strip().replace("\n", " ")
    assert line[caret.index("^") :] == under
    assert pickle.loads(pickle.dumps(caught.value)).args == caught.value.args


def test_regions_that_do_not_exist() -> None:
    regions = ["goal", "safe", "room 1"]
    assert parse_formula('F goal & G !"room 1"', regions=regions).names == {"goal", "room 1"}
    for text, column, remedy in (
        ("F gaol & G safe", 3, "did you mean goal?"),
        ("coverage(goal, room_1)", 16, 'did you mean "room 1"?'),
        ("F dock", 3, 'the regions: goal, "room 1", safe'),
    ):
        with pytest.raises(InputError) as caught:
            parse_formula(text, regions=regions)
        assert f"column {column}" in caught.value.place
        assert "there is no region" in caught.value.problem
        assert caught.value.remedy == remedy
    with pytest.raises(InputError, match="there is none at all"):
        parse_formula("F a", regions=[])
    assert parse_formula("true", regions=[]) == Formula(Operator.TRUE)


@pytest.mark.parametrize(
    "text",
    [
        "(" * 10_000 + "a" + ")" * 10_000,
        "(" * 10_000,
        "!" * 10_000 + "a",
        "F " * 10_000 + "a",
        "a -> " * 10_000 + "a",
        "a U " * 10_000 + "a",
        "coverage(" * 10_000 + "a",
        "(((a & b | c) U d) -> e) <-> " * 10_000 + "a",
        "((((" * 24 + "a" + " & b | c) -> d) <-> e) U f" * 24 + ")" * 24,
        "sequence(" + ", ".join(f"r{i}" for i in range(60)) + ")",
    ],
    ids=lambda text: text[:12],
)
def test_what_is_nested_too_deep_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"deep") as caught:
        parse_formula(text)
    line, caret = caught.value.excerpt.split("\n")
    assert len(line) < 100
    assert caret.index("^") < len(line)


def test_what_is_long_is_not_deep() -> None:
    text = " & ".join(["a", "F b", "(c | a)"] * 5_000)
    formula = parse_formula(text)
    assert len(formula.operands) == 15_000
    assert str(formula) == text
    at_the_limit = "F " * (MAX_DEPTH - 1) + "a"
    assert parse_formula(at_the_limit).depth == MAX_DEPTH
    assert str(parse_formula(at_the_limit)) == at_the_limit


def test_formulas_from_code_are_checked_too() -> None:
    with pytest.raises(InputError, match="cannot have 1 operands"):
        Formula(Operator.AND, (A,))
    with pytest.raises(InputError, match="cannot have 2 operands"):
        Formula(Operator.NOT, (A, B))
    with pytest.raises(InputError, match="cannot have 1 operands"):
        Formula(Operator.TRUE, (A,))
    with pytest.raises(InputError, match="cannot have the name"):
        Formula(Operator.TRUE, name="a")
    with pytest.raises(InputError, match="cannot have the name"):
        region("")
    with pytest.raises(InputError, match="cannot be written"):
        region('a"b')
    deep = A
    while deep.depth < MAX_DEPTH:
        deep = eventually(deep)
    with pytest.raises(InputError, match="operators deep"):
        eventually(deep)
    assert pickle.loads(pickle.dumps(deep)) == deep
    assert hash(pickle.loads(pickle.dumps(deep))) == hash(deep)
