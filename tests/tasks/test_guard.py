"""Guards: they hold where they should, nowhere else, and cannot be said shorter."""

from collections.abc import Callable, Sequence
from itertools import product
from random import Random

import pytest

from conav.tasks import guard as guard_module
from conav.tasks.automaton import Letter
from conav.tasks.formula import Formula, Operator
from conav.tasks.guard import guard, guards
from conav.tasks.parse import parse_formula
from conav.tasks.translate import automaton_of, disjoint_letters, every_letter


def split(letters: Sequence[Letter], sides: Sequence[int]) -> tuple[list[Letter], list[Letter]]:
    """The letters inside and outside; those of any other side do not occur."""
    pairs = list(zip(letters, sides, strict=True))
    return [x for x, side in pairs if side == 1], [x for x, side in pairs if side == 0]


def literals(formula: Formula) -> int:
    """How many names are written."""
    if formula.operator == Operator.NAME:
        return 1
    return sum(map(literals, formula.operands))


def fewest_literals(inside: list[Letter], outside: list[Letter], names: str) -> int:
    """Of a disjunction of terms that holds inside and not outside, by trying all terms."""
    terms: list[tuple[int, int]] = []  # names, and the letters inside at which it holds
    for signs in product((None, True, False), repeat=len(names)):
        wanted = {name: sign for name, sign in zip(names, signs, strict=True) if sign is not None}

        def holds(letter: Letter, wanted: dict[str, bool] = wanted) -> bool:
            return all((name in letter) == sign for name, sign in wanted.items())

        if not any(map(holds, outside)):
            terms.append((len(wanted), sum(1 << i for i, x in enumerate(inside) if holds(x))))
    full = 1 << len(inside)
    cost = [0] + [10**9] * (full - 1)
    for covered in range(full):  # a term never uncovers: later ones are larger numbers
        for price, held in terms:
            cost[covered | held] = min(cost[covered | held], cost[covered] + price)
    return cost[-1]


def test_guards_of_three_names_are_right_and_shortest(holds: Callable[..., bool]) -> None:
    """All 256 functions, and 300 where some label sets do not occur."""
    letters = every_letter("abc")
    rng = Random(0)
    cases = [
        *product((0, 1), repeat=8),
        *([rng.randrange(3) for _ in range(8)] for _ in range(300)),
    ]
    clauses = 0
    for sides in cases:
        inside, outside = split(letters, sides)
        found = guard(inside, outside)
        assert all(holds(found, [letter]) for letter in inside)
        assert not any(holds(found, [letter]) for letter in outside)
        terms = fewest_literals(inside, outside, "abc")
        dual = fewest_literals(outside, inside, "abc")
        assert literals(found) == min(terms, dual)
        clauses += dual < terms
        assert parse_formula(str(found)) == found
    assert clauses > 20


@pytest.mark.parametrize("names", ["abcd", "abcde", "abcdef"])
def test_guards_of_more_names_are_right(names: str, holds: Callable[..., bool]) -> None:
    letters = every_letter(names)
    rng = Random(1)
    for _ in range(10):
        inside, outside = split(letters, [rng.choice((0, 0, 1, 2)) for _ in letters])
        found = guard(inside, outside)
        assert all(holds(found, [letter]) for letter in inside)
        assert not any(holds(found, [letter]) for letter in outside)


def test_guards_of_very_many_letters(holds: Callable[..., bool]) -> None:
    """Nine names, 512 letters: right, and without a name that could be left out of a term."""
    letters = every_letter("abcdefghi")
    rng = Random(2)
    for _ in range(2):
        inside, outside = split(letters, [rng.choice((0, 1, 2)) for _ in letters])
        found = guard(inside, outside)
        assert all(holds(found, [letter]) for letter in inside)
        assert not any(holds(found, [letter]) for letter in outside)
        terms = guard_module._shortened(
            *(
                sorted(sum(1 << "abcdefghi".index(name) for name in letter) for letter in side)
                for side in (inside, outside)
            )
        )
        for has, own in terms:
            for bit in (1 << i for i in range(9) if has >> i & 1):
                fewer = has & ~bit
                masks = (sum(1 << "abcdefghi".index(x) for x in letter) for letter in outside)
                assert any(mask & fewer == own & fewer for mask in masks)
    # What matters little is found all the same.
    some = [letter for letter in letters if "a" in letter and "b" not in letter]
    assert str(guard(some, [letter for letter in letters if letter not in some])) == "a & !b"


@pytest.mark.parametrize(
    ("inside", "outside", "text"),
    [
        (["gs"], ["", "g", "s"], "g & s"),
        (["s"], ["", "g", "gs"], "s & !g"),
        (["", "g"], ["s", "gs"], "!s"),
        (["", "g"], [], "true"),
        ([], ["g"], "false"),
        (["g"], ["", "s"], "g"),  # where they do not overlap
        ([""], ["g", "s"], "!g & !s"),
        (["ac", "ad", "bc", "bd"], ["a", "b", "c", "d", ""], "(a | b) & (c | d)"),
        (["ab", "c", "abc"], ["", "a", "b", "d"], "c | a & b"),
    ],
)
def test_guards_by_hand(inside: list[str], outside: list[str], text: str) -> None:
    assert str(guard(list(map(frozenset, inside)), list(map(frozenset, outside)))) == text


def test_many_regions_that_do_not_overlap() -> None:
    """A list of letters, not a table of 2^40 label sets."""
    names = [f"r{i:02}" for i in range(40)]
    task = automaton_of(parse_formula("G !r07 & F r31"), disjoint_letters(names))
    assert {(p, q): str(text) for p, q, text in guards(task)} == {
        (0, 0): "!r07 & !r31",
        (0, 1): "r07",
        (0, 2): "r31",
        (1, 1): "true",
        (2, 1): "r07",
        (2, 2): "!r07",
    }


def test_every_arrow_has_its_guard(holds: Callable[..., bool]) -> None:
    task = automaton_of(parse_formula("F a & F b & G !c"))
    found = {(p, q): text for p, q, text in guards(task)}
    for state, row in enumerate(task.transition.tolist()):
        assert {q for p, q in found if p == state} == set(row)
        for letter, then in zip(task.letters, row, strict=True):
            assert holds(found[state, then], [letter])
