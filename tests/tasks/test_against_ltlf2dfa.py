"""The same automata from another program, where it is there: ltlf2dfa and its MONA."""

import re
import shutil
from collections.abc import Callable
from itertools import product
from random import Random
from typing import Any

import pytest

from conav.tasks.formula import BINDING, UNARY, Formula, Operator
from conav.tasks.parse import parse_formula
from conav.tasks.translate import automaton_of, every_letter

LETTERS = every_letter("ab")


@pytest.fixture(scope="module")
def to_dot() -> Callable[[str], str]:
    """A text's automaton as ltlf2dfa draws it."""
    if shutil.which("mona") is None:
        pytest.skip("needs the program mona on PATH")
    parser: Any = pytest.importorskip("ltlf2dfa.parser.ltlf", reason="needs ltlf2dfa").LTLfParser()
    return lambda text: parser(text).to_dfa()


class Drawn:
    """An automaton read from a drawing."""

    def __init__(self, dot: str) -> None:
        arrows = re.findall(r'^ (\d+) -> (\d+) \[label="(.*)"\];$', dot, re.M)
        # Without MONA ltlf2dfa draws an automaton without arrows and says nothing.
        assert arrows, dot
        self.arrows = [(int(p), int(q), parse_formula(guard)) for p, q, guard in arrows]
        ends = re.search(r"doublecircle\]; ([\d; ]*);", dot)
        self.ends = {int(state) for state in re.findall(r"\d+", ends[1])} if ends else set()

    def accepts(self, word: Any, holds: Callable[..., bool]) -> bool:
        state = 1
        for letter in word:
            (state,) = {q for p, q, guard in self.arrows if p == state and holds(guard, [letter])}
        return state in self.ends

    @property
    def n_states(self) -> int:
        return len({p for p, _, _ in self.arrows})


def in_parentheses(formula: Formula) -> str:
    """Text that does not depend on how strongly an operator binds, without W."""
    parts = [f"({in_parentheses(part)})" for part in formula.operands]
    operator = formula.operator
    if operator in UNARY:
        return f"{operator} {parts[0]}"
    if operator == Operator.WEAK_UNTIL:
        return f"({parts[0]} U {parts[1]}) | (G {parts[0]})"
    return f" {operator} ".join(parts) if operator in BINDING else str(formula)


@pytest.mark.parametrize(
    ("text", "states"), [("F a & G b", 3), ("F a & F b & G !c", 5), ("(!b U a) & F b", 4)]
)
def test_sizes(to_dot: Callable[[str], str], text: str, states: int) -> None:
    drawn = Drawn(to_dot(in_parentheses(parse_formula(text))))
    assert drawn.n_states == automaton_of(parse_formula(text)).n_states == states


def test_the_same_words_are_accepted(
    to_dot: Callable[[str], str],
    holds: Callable[..., bool],
    random_formula: Callable[..., Formula],
) -> None:
    rng = Random(6)
    for i in range(60):
        formula = random_formula(rng, rng.randint(1, 4), "ab", bool(i % 2))
        if not formula.names:
            continue
        drawn = Drawn(to_dot(in_parentheses(formula)))
        task = automaton_of(formula, LETTERS)
        for word in (w for n in range(1, 4) for w in product(LETTERS, repeat=n)):
            assert drawn.accepts(word, holds) == task.accepts(word), (str(formula), word)
