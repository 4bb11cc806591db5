"""From a formula to its minimal automaton.

Obligations are found by progression from each other, letter by letter (`conav.tasks.progression`);
those that accept the same rests are merged by Moore's refinement of partitions [Moore1956]; what
remains is numbered breadth first. The number of states can be exponential in the formula's length,
and even doubly so: nothing that translates finite LTL escapes that [DeGiacomo2013].
"""

from collections.abc import Collection, Iterable
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from conav.errors import InputError
from conav.tasks.automaton import Automaton, Letter
from conav.tasks.formula import Formula
from conav.tasks.progression import Obligation, Progression

MAX_STATES = 10_000
"""Found before a translation is given up, unless another number is given."""

MAX_REGIONS = 12
"""Of a formula whose letters are not given: all 4096 label sets of so many are followed."""


def automaton_of(
    formula: Formula,
    letters: Iterable[Collection[str]] | None = None,
    *,
    max_states: int = MAX_STATES,
) -> Automaton:
    """The smallest automaton that accepts the words over `letters` which satisfy the formula.

    `letters` are the label sets that can occur. Without them those of any combination of the
    formula's regions are taken, overlaps and all (`every_letter`); with fewer the automaton is
    often smaller, and is made faster. Letters are sorted; names the formula does not have
    tell letters apart, and nothing else.

    Raises `InputError` when more than `max_states` obligations come up, before minimisation, or
    one of them is too large.
    """
    propositions, alphabet = _alphabet(formula, letters)
    progression = Progression(formula)
    bits = {name: 1 << i for i, name in enumerate(progression.names)}
    masks = [sum(bits.get(name, 0) for name in letter) for letter in alphabet]
    kinds = list(dict.fromkeys(masks))  # letters with the same of the formula's regions act alike
    first, rows, ends = _explore(progression, kinds, max_states)
    merged = equivalent_states(rows, ends)
    _, some = np.unique(merged, return_index=True)  # a state of each class
    rows, ends, first = merged[rows[some]], ends[some], merged[first]
    # Before the first letter there is a state of its own. Any state that goes on as it does can
    # stand for it, since no word ends there; one that does not accept where there are two.
    alike = np.flatnonzero((rows == first).all(axis=1))
    if alike.size:
        initial = int(alike[np.argmin(ends[alike])])
    else:
        initial = len(ends)
        rows, ends = np.vstack([rows, first]), np.append(ends, False)
    order = _breadth_first(rows, initial)
    number = np.empty(len(ends), dtype=np.int64)
    number[order] = np.arange(len(order))
    column = {kind: i for i, kind in enumerate(kinds)}
    transition = number[rows[order]][:, [column[mask] for mask in masks]]
    return Automaton(propositions, alphabet, transition.astype(np.int32), ends[order])


def every_letter(names: Iterable[str]) -> tuple[Letter, ...]:
    """All sets of these names.

    >>> [sorted(letter) for letter in every_letter(["a", "b"])]
    [[], ['a'], ['b'], ['a', 'b']]
    """
    members = sorted(set(names))
    sets = (
        frozenset(some)
        for count in range(len(members) + 1)
        for some in combinations(members, count)
    )
    return tuple(_sorted(sets))


def disjoint_letters(names: Iterable[str]) -> tuple[Letter, ...]:
    """No region, and each by itself: the label sets of regions that do not overlap.

    >>> [sorted(letter) for letter in disjoint_letters(["a", "b"])]
    [[], ['a'], ['b']]
    """
    return tuple(_sorted([frozenset[str](), *(frozenset({name}) for name in names)]))


def equivalent_states(
    transition: NDArray[np.integer], accepting: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """The class of each state, (n_states,): equal where the same words lead to acceptance.

    Moore's algorithm: states are told apart by acceptance, then by the classes their letters lead
    to, until nothing more is told apart. Rounds of sorted rows; at most n_states, usually few.
    """
    columns = np.unique(transition, axis=1)
    classes = np.unique(accepting, return_inverse=True)[1].astype(np.int64)
    while True:
        rows = np.column_stack([classes, classes[columns]])
        finer = np.unique(rows, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64)
        if finer.max() == classes.max():
            return classes
        classes = finer


def _alphabet(
    formula: Formula, letters: Iterable[Collection[str]] | None
) -> tuple[tuple[str, ...], tuple[Letter, ...]]:
    """The names that matter and the letters, both sorted."""
    if letters is None:
        count = len(formula.names)
        if count > MAX_REGIONS:
            raise InputError(
                "letters",
                f"the {count} regions of the formula make {2**count} label sets, and at most "
                f"{2**MAX_REGIONS} are followed",
                "give those that can occur, for example disjoint_letters(regions)",
            )
        return tuple(sorted(formula.names)), every_letter(formula.names)
    given = list(letters)
    for letter in given:
        if isinstance(letter, str):
            raise InputError(f"letter {letter!r}", "is a text and no set of names", "put it in { }")
    if not given:
        raise InputError("letters", "there is none", "give one at least; no region is {}")
    alphabet = _sorted(map(frozenset, given))
    return tuple(sorted(formula.names.union(*alphabet))), tuple(alphabet)


def _sorted(letters: Iterable[Letter]) -> list[Letter]:
    """The letters by the last name in which two differ: as binary numbers."""
    return sorted(set(letters), key=lambda letter: sorted(letter, reverse=True))


def _explore(
    progression: Progression, kinds: list[int], max_states: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """The states after each first letter, (n_kinds,), all rows of transitions, and acceptance."""
    states: dict[Obligation, int] = {}
    groups: dict[int, tuple[list[int], NDArray[np.intp]]] = {}

    def grouped(relevant: int) -> tuple[list[int], NDArray[np.intp]]:
        """A letter of each kind that differs in these bits, and which stands for which."""
        if relevant not in groups:
            place: dict[int, int] = {}
            which = [place.setdefault(kind & relevant, len(place)) for kind in kinds]
            groups[relevant] = (list(place), np.array(which))
        return groups[relevant]

    def numbered(found: list[Obligation]) -> NDArray[np.int64]:
        numbers = np.array([states.setdefault(each, len(states)) for each in found])
        if len(states) > max_states:
            raise InputError(
                "formula",
                f"its automaton has more than {max_states} states before minimisation "
                f"({len(states)} found so far)",
                "give fewer letters, split the task, or raise max_states",
            )
        return numbers

    some, which = grouped(progression.first_letters)
    first = numbered([progression.first(letter) for letter in some])[which]
    rows: list[NDArray[np.int64]] = []
    done = 0
    while done < len(states):
        # The dict grows as it is read; a list of it is taken once for each layer.
        for state in list(states)[done:]:
            some, which = grouped(progression.letters_of(state))
            rows.append(numbered([progression.rest(state, letter) for letter in some])[which])
            done += 1
    ends = np.array([progression.satisfied_by_nothing(state) for state in states])
    return first, np.array(rows), ends


def _breadth_first(rows: NDArray[np.int64], initial: int) -> list[int]:
    """The states in the order in which a search from the initial one meets them."""
    order = [initial]
    seen = {initial}
    for state in order:  # grows on the way
        for target in rows[state].tolist():
            if target not in seen:
                seen.add(target)
                order.append(target)
    return order
