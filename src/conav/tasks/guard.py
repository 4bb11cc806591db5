"""The labels on an automaton's arrows: short formulas without temporal operators.

A term is a conjunction of names and negated names. Of every letter inside, the shortest terms that
hold there and at no letter outside are found as minimal sets of names in which the letter differs
from each letter outside; the cheapest choice of terms that together hold at all letters inside is
the guard. That is two-level minimisation [McCluskey1956] with the label sets that cannot occur as
don't-cares, by lists of letters rather than tables of all label sets, of which there are too many.
Where even the letters are many, terms are shortened one by one instead and need not be the best.
"""

from collections.abc import Collection, Iterator

from conav.tasks.automaton import Automaton, Letter
from conav.tasks.formula import (
    Formula,
    Operator,
    conjunction,
    disjunction,
    negation,
    region,
)

MAX_LETTERS = 256
"""With more, no name can be left out of a term, but another guard may be shorter."""

MAX_SEARCH = 5_000
"""Choices of terms that are tried; after that the best so far is taken."""

Term = tuple[int, int]
"""The bits of the names it has, and which of them are not negated."""


def guards(automaton: Automaton) -> Iterator[tuple[int, int, Formula]]:
    """Each pair of states with an arrow from one to the other, and the arrow's guard, in order."""
    for source, row in enumerate(automaton.transition.tolist()):
        for target in sorted(set(row)):
            inside = [x for x, to in zip(automaton.letters, row, strict=True) if to == target]
            outside = [x for x, to in zip(automaton.letters, row, strict=True) if to != target]
            yield source, target, guard(inside, outside)


def guard(inside: Collection[Letter], outside: Collection[Letter]) -> Formula:
    """A shortest formula that holds at every letter inside and at none outside.

    It is a disjunction of terms, or a conjunction of clauses where that has fewer names. With many
    letters or terms to choose from there may be shorter ones than it is (`MAX_LETTERS`,
    `MAX_SEARCH`).

    >>> occur = [frozenset(), frozenset({"a"}), frozenset({"b"})]
    >>> str(guard(occur[1:2], occur[:1] + occur[2:])), str(guard(occur[:2], occur[2:]))
    ('a', '!b')
    """
    names = sorted(frozenset[str]().union(*inside, *outside))
    bits = {name: 1 << i for i, name in enumerate(names)}
    on = {sum(bits[name] for name in letter) for letter in inside}
    off = {sum(bits[name] for name in letter) for letter in outside}
    for bit in bits.values():
        on, off = _without(bit, on, off)
    if not on or not off:
        return Formula(Operator.TRUE if on else Operator.FALSE)
    terms, holes = _cheapest(on, off), _cheapest(off, on)
    if _literals(holes) < _literals(terms):
        # What does not hold at the letters outside: each of their terms negated.
        clauses = [disjunction(*_written(names, has, has & ~own)) for has, own in holes]
        return conjunction(*clauses)
    return disjunction(*(conjunction(*_written(names, has, own)) for has, own in terms))


def _written(names: list[str], has: int, own: int) -> list[Formula]:
    """The names of a term, those that are not negated first."""
    some = [(not own >> i & 1, region(name)) for i, name in enumerate(names) if has >> i & 1]
    return [
        negation(each) if negated else each
        for negated, each in sorted(some, key=lambda pair: pair[0])
    ]


def _literals(terms: list[Term]) -> int:
    return sum(has.bit_count() for has, _ in terms)


def _without(bit: int, on: set[int], off: set[int]) -> tuple[set[int], set[int]]:
    """The letters without a name that clearly tells none of them apart; as they are with another.

    That is one which each letter also occurs with and without, on the same side. It saves time.
    """
    if all(letter ^ bit in side for side in (on, off) for letter in side):
        return {letter & ~bit for letter in on}, {letter & ~bit for letter in off}
    return on, off


def _cheapest(on: set[int], off: set[int]) -> list[Term]:
    """The terms with fewest names in all that hold at every `on` and at no `off`."""
    members = sorted(on)
    if len(on) + len(off) > MAX_LETTERS:
        return _shortened(members, sorted(off))
    terms = sorted(
        {(has, letter & has) for letter in members for has in _telling_sets(letter, off)},
        key=lambda term: (term[0].bit_count(), term),
    )
    holds = [
        sum(1 << i for i, letter in enumerate(members) if letter & has == own) for has, own in terms
    ]
    return [terms[i] for i in _cover(holds, [has.bit_count() for has, _ in terms], len(on))]


def _shortened(on: list[int], off: list[int]) -> list[Term]:
    """Terms that hold at every `on` and at no `off`, none of which can do without a name."""
    names = 0
    for letter in (*on, *off):
        names |= letter
    bits = [1 << i for i in range(names.bit_length()) if names >> i & 1]
    terms: list[Term] = []
    left = on
    while left:
        letter, has = left[0], names
        for bit in bits:
            fewer = has & ~bit
            if all((other ^ letter) & fewer for other in off):
                has = fewer
        terms.append((has, letter & has))
        left = [other for other in left if (other ^ letter) & has]
    return terms


def _telling_sets(letter: int, off: set[int]) -> list[int]:
    """The minimal sets of names of which the letter differs in one at least from each `off`."""
    differences = _minimal({letter ^ other for other in off})
    sets = {0}
    for difference in differences:
        bits = [1 << i for i in range(difference.bit_length()) if difference >> i & 1]
        longer = {one if one & difference else one | bit for one in sets for bit in bits}
        sets = set(_minimal(longer))
    return sorted(sets)


def _minimal(sets: set[int]) -> list[int]:
    """Those that contain none of the others."""
    kept: list[int] = []
    for one in sorted(sets, key=lambda bits: (bits.bit_count(), bits)):
        if not any(other & ~one == 0 for other in kept):
            kept.append(one)
    return kept


def _cover(holds: list[int], costs: list[int], count: int) -> list[int]:
    """The cheapest choice of sets that together hold all of 0 to count - 1, fewest of equals.

    Branches on the member that fewest sets hold; the first way down is greedy.
    """
    everything = (1 << count) - 1
    holders = [[i for i, held in enumerate(holds) if held >> m & 1] for m in range(count)]
    best: list[int] = []
    best_cost = (sum(costs) + 1, 0)
    # Choices still to be followed; the last is next. Recursion would be as deep as the guard long.
    open_choices: list[tuple[int, tuple[int, ...], int]] = [(0, (), 0)]
    tried = 0
    while open_choices and (tried < MAX_SEARCH or not best):
        covered, chosen, cost = open_choices.pop()
        tried += 1
        if (cost, len(chosen)) >= best_cost:
            continue
        if covered == everything:
            best, best_cost = sorted(chosen), (cost, len(chosen))
            continue
        member = min(
            (m for m in range(count) if not covered >> m & 1), key=lambda m: len(holders[m])
        )
        # The set that adds most for its names goes on top.
        after = sorted(
            holders[member],
            key=lambda i: ((holds[i] & ~covered).bit_count() / max(costs[i], 1), -i),
        )
        open_choices.extend((covered | holds[i], (*chosen, i), cost + costs[i]) for i in after)
    return best
