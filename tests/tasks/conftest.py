"""Formulas to try, and what they mean by the definition."""

from collections.abc import Callable, Sequence
from random import Random

import pytest
from hypothesis import strategies as st

from conav.tasks.formula import CONSTANTS, UNARY, VARIADIC, Formula, Operator

Word = Sequence[frozenset[str]]
NEXTS = (Operator.NEXT, Operator.WEAK_NEXT)


def _holds(formula: Formula, word: Word, i: int) -> bool:
    """Finite LTL as it is defined, by recursion over the formula and the positions of the word."""
    later = range(i, len(word))
    parts = formula.operands

    def at(which: int, j: int) -> bool:
        return _holds(parts[which], word, j)

    match formula.operator:
        case Operator.TRUE:
            return True
        case Operator.FALSE:
            return False
        case Operator.NAME:
            return formula.name in word[i]
        case Operator.NOT:
            return not at(0, i)
        case Operator.AND:
            return all(_holds(part, word, i) for part in parts)
        case Operator.OR:
            return any(_holds(part, word, i) for part in parts)
        case Operator.IMPLIES:
            return not at(0, i) or at(1, i)
        case Operator.IFF:
            return at(0, i) == at(1, i)
        case Operator.EVENTUALLY:
            return any(at(0, j) for j in later)
        case Operator.ALWAYS:
            return all(at(0, j) for j in later)
        case Operator.UNTIL:
            return any(at(1, j) and all(at(0, k) for k in range(i, j)) for j in later)
        case Operator.RELEASE:
            return all(at(1, j) or any(at(0, k) for k in range(i, j)) for j in later)
        case Operator.WEAK_UNTIL:
            return all(at(0, j) or any(at(1, k) for k in range(i, j + 1)) for j in later)
        case Operator.NEXT:
            return i + 1 < len(word) and at(0, i + 1)
        case Operator.WEAK_NEXT:
            return i + 1 == len(word) or at(0, i + 1)


def _arity(operator: Operator) -> int:
    if operator in CONSTANTS or operator == Operator.NAME:
        return 0
    return 1 if operator in UNARY else 2


def _random_formula(rng: Random, size: int, names: Sequence[str], with_next: bool) -> Formula:
    """A formula with about so many operators."""
    if size <= 0:
        if rng.random() < 0.1:
            return Formula(rng.choice((Operator.TRUE, Operator.FALSE)))
        return Formula(Operator.NAME, name=rng.choice(names))
    some = [op for op in Operator if _arity(op) and (with_next or op not in NEXTS)]
    operator = rng.choice(some)
    if _arity(operator) == 1:
        return Formula(operator, (_random_formula(rng, size - 1, names, with_next),))
    count = 3 if operator in VARIADIC and size > 2 and rng.random() < 0.3 else 2
    shares = [0] * count
    for _ in range(size - 1):
        shares[rng.randrange(count)] += 1
    return Formula(
        operator, tuple(_random_formula(rng, share, names, with_next) for share in shares)
    )


@pytest.fixture(scope="session")
def holds() -> Callable[[Formula, Word], bool]:
    """`holds(formula, word)`: whether a word of one letter at least satisfies the formula."""
    return lambda formula, word: _holds(formula, word, 0)


@pytest.fixture(scope="session")
def random_formula() -> Callable[..., Formula]:
    """`random_formula(rng, size, names, with_next)`."""
    return _random_formula


@pytest.fixture(scope="session")
def formulas() -> Callable[..., st.SearchStrategy[Formula]]:
    """`formulas(names, with_next)`: a strategy of hypothesis."""

    def strategy(
        names: Sequence[str] = ("a", "b"), with_next: bool = False
    ) -> st.SearchStrategy[Formula]:
        leaves = st.sampled_from(
            [Formula(op) for op in sorted(CONSTANTS)]
            + [Formula(Operator.NAME, name=name) for name in names]
        )

        def grown(inner: st.SearchStrategy[Formula]) -> st.SearchStrategy[Formula]:
            some = [op for op in Operator if _arity(op) and (with_next or op not in NEXTS)]
            return st.one_of(
                st.builds(
                    Formula, st.sampled_from([op for op in some if _arity(op) == 1]),
                    st.tuples(inner),
                ),
                st.builds(
                    Formula, st.sampled_from([op for op in some if _arity(op) == 2]),
                    st.tuples(inner, inner),
                ),
                st.builds(
                    Formula, st.sampled_from(sorted(VARIADIC)), st.tuples(inner, inner, inner)
                ),
            )  # fmt: skip

        return st.recursive(leaves, grown, max_leaves=6)

    return strategy
