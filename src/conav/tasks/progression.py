"""What is left of a formula after each letter: formula progression [Bacchus1998].

An obligation is a formula the rest of the word must satisfy. Here it is a set of clauses, of which
one must be kept whole; a clause is a set of elements, the subformulas with a temporal operator on
top. No clause contains another, so obligations that are equal by propositional logic over their
elements are the same Python value, and a formula has finitely many. Clauses are numbers, bit i
standing for element i.

Finite words differ from [Bacchus1998]'s infinite ones in two places: `satisfied_by_nothing` says
which obligations may be left when the word ends, and X asks for a letter that WX does not ask for.
"""

from conav.errors import InputError
from conav.tasks.formula import CONSTANTS, Formula, Operator

Obligation = tuple[int, ...]
"""Clauses, sorted, none a superset of another."""

NOTHING: Obligation = (0,)
"""Every rest will do: the empty clause."""
NEVER: Obligation = ()
"""No rest will do."""

MAX_CLAUSES = 2_000
"""In one obligation, before it is called too large."""

# Of subformulas in negation normal form.
_LITERAL, _AND, _OR, _UNTIL, _RELEASE, _NEXT, _WEAK_NEXT = range(7)

_NEGATED = {
    Operator.AND: Operator.OR,
    Operator.OR: Operator.AND,
    Operator.TRUE: Operator.FALSE,
    Operator.FALSE: Operator.TRUE,
    Operator.EVENTUALLY: Operator.ALWAYS,
    Operator.ALWAYS: Operator.EVENTUALLY,
    Operator.UNTIL: Operator.RELEASE,
    Operator.RELEASE: Operator.UNTIL,
    Operator.NEXT: Operator.WEAK_NEXT,
    Operator.WEAK_NEXT: Operator.NEXT,
}


class Progression:
    """Progresses one formula by letters; a letter is a number, bit i standing for `names[i]`.

    Raises `InputError` when an obligation has more than `MAX_CLAUSES` clauses.
    """

    def __init__(self, formula: Formula) -> None:
        self.names = tuple(sorted(formula.names))
        self._bits = {name: 1 << i for i, name in enumerate(self.names)}
        # Of each subformula, numbered; equal ones have one number, which keeps <-> small.
        self._kinds: list[int] = []
        self._operands: list[tuple[int, ...]] = []  # of a literal: its bit, and 1 if negated
        self._letters: list[int] = []  # the bits it depends on
        self._numbers: dict[tuple[int, tuple[int, ...]], int] = {}
        self._normal_forms: dict[tuple[int, bool], int] = {}
        self._elements: list[int] = []  # the subformula of each element
        self._element_of: dict[int, int] = {}
        self._at_end = 0  # the elements that the end of the word satisfies
        self._members_of: dict[int, list[int]] = {}
        self._after: list[dict[int, Obligation]] = []  # what is left of each subformula, by letter
        self._true = self._number(_AND, ())
        self._false = self._number(_OR, ())
        self._more = self._number(_UNTIL, (self._true, self._true))
        self._no_more = self._number(_RELEASE, (self._false, self._false))
        self._root = self._normal(formula, True)

    def first(self, letter: int) -> Obligation:
        """What is left of the formula after the first letter."""
        return self._progress(self._root, letter)

    @property
    def first_letters(self) -> int:
        """The bits of a letter on which `first` depends."""
        return self._letters[self._root]

    def rest(self, obligation: Obligation, letter: int) -> Obligation:
        """What is left of an obligation after one more letter."""
        result: set[int] = set()
        for clause in obligation:
            sure, choices = 0, list[Obligation]()
            for number in self._members(clause):
                after = self._progress(number, letter)
                if len(after) == 1:
                    sure |= after[0]
                elif after:
                    choices.append(after)
                else:
                    break
            else:
                kept: Obligation = (sure,)
                for choice in choices:
                    kept = _both(kept, choice)
                if kept == NOTHING:
                    return NOTHING
                result.update(kept)
        return _absorbed(result)

    def letters_of(self, obligation: Obligation) -> int:
        """The bits of a letter on which `rest` depends."""
        letters = 0
        for clause in obligation:
            for number in self._members(clause):
                letters |= self._letters[number]
        return letters

    def satisfied_by_nothing(self, obligation: Obligation) -> bool:
        """Whether the word may end here: G and R ask for nothing more, F and U do."""
        return any(clause & ~self._at_end == 0 for clause in obligation)

    def _normal(self, formula: Formula, positive: bool) -> int:
        """The number of the formula's negation normal form, or of its negation's."""
        key = (id(formula), positive)
        if key not in self._normal_forms:
            self._normal_forms[key] = self._make_normal(formula, positive)
        return self._normal_forms[key]

    def _make_normal(self, formula: Formula, positive: bool) -> int:
        operator, operands = formula.operator, formula.operands
        if operator == Operator.NAME:
            return self._number(_LITERAL, (self._bits[formula.name], int(not positive)))
        if operator == Operator.NOT:
            return self._normal(operands[0], not positive)
        if operator == Operator.IMPLIES:
            kind = _OR if positive else _AND
            return self._number(
                kind, (self._normal(operands[0], not positive), self._normal(operands[1], positive))
            )
        if operator == Operator.IFF:
            pairs = [
                (self._normal(operands[0], one), self._normal(operands[1], one == positive))
                for one in (True, False)
            ]
            return self._number(_OR, tuple(self._number(_AND, pair) for pair in pairs))
        parts = tuple(self._normal(operand, positive) for operand in operands)
        if operator == Operator.WEAK_UNTIL:
            # a W b = b R (a | b), whose negation is !b U (!a & !b).
            kind, inner = (_RELEASE, _OR) if positive else (_UNTIL, _AND)
            return self._number(kind, (parts[1], self._number(inner, parts)))
        if not positive:
            operator = _NEGATED[operator]
        if operator in CONSTANTS:
            return self._true if operator == Operator.TRUE else self._false
        if operator == Operator.EVENTUALLY:
            return self._number(_UNTIL, (self._true, *parts))
        if operator == Operator.ALWAYS:
            return self._number(_RELEASE, (self._false, *parts))
        kinds = {
            Operator.AND: _AND,
            Operator.OR: _OR,
            Operator.UNTIL: _UNTIL,
            Operator.RELEASE: _RELEASE,
            Operator.NEXT: _NEXT,
            Operator.WEAK_NEXT: _WEAK_NEXT,
        }
        return self._number(kinds[operator], parts)

    def _number(self, kind: int, operands: tuple[int, ...]) -> int:
        key = (kind, operands)
        if key not in self._numbers:
            self._numbers[key] = len(self._kinds)
            self._kinds.append(kind)
            self._after.append({})
            self._operands.append(operands)
            letters = operands[0] if kind == _LITERAL else 0
            if kind != _LITERAL:
                for operand in operands:
                    letters |= self._letters[operand]
            self._letters.append(letters)
        return self._numbers[key]

    def _element(self, number: int) -> Obligation:
        """The obligation to keep one subformula."""
        if number not in self._element_of:
            i = len(self._elements)
            self._element_of[number] = i
            self._elements.append(number)
            # U is not. What X and WX wait for stands beside `_more` or `_no_more`, which decide.
            if self._kinds[number] == _RELEASE:
                self._at_end |= 1 << i
        return (1 << self._element_of[number],)

    def _members(self, clause: int) -> list[int]:
        """The subformulas that are the clause's elements."""
        found = self._members_of.get(clause)
        if found is None:
            elements = self._elements
            found = [elements[i] for i in range(clause.bit_length()) if clause >> i & 1]
            self._members_of[clause] = found
        return found

    def _progress(self, number: int, letter: int) -> Obligation:
        """What is left of a subformula after the letter."""
        letter &= self._letters[number]
        known = self._after[number]
        found = known.get(letter)
        if found is None:
            found = known[letter] = self._progress_anew(number, letter)
        return found

    def _progress_anew(self, number: int, letter: int) -> Obligation:
        kind, operands = self._kinds[number], self._operands[number]
        if kind == _LITERAL:
            bit, negated = operands
            return NOTHING if bool(letter & bit) != bool(negated) else NEVER
        if kind == _AND:
            result = NOTHING
            for operand in operands:
                result = _both(result, self._progress(operand, letter))
            return result
        if kind == _OR:
            result = NEVER
            for operand in operands:
                result = _either(result, self._progress(operand, letter))
            return result
        if kind == _UNTIL:
            longer = _both(self._progress(operands[0], letter), self._element(number))
            return _either(self._progress(operands[1], letter), longer)
        if kind == _RELEASE:
            longer = _either(self._progress(operands[0], letter), self._element(number))
            return _both(self._progress(operands[1], letter), longer)
        if kind == _NEXT:
            return _both(self._unread(operands[0]), self._element(self._more))
        return _either(self._unread(operands[0]), self._element(self._no_more))

    def _unread(self, number: int) -> Obligation:
        """The obligation to keep a subformula of which no letter was read yet."""
        kind, operands = self._kinds[number], self._operands[number]
        if kind not in (_AND, _OR):
            return self._element(number)
        result = NOTHING if kind == _AND else NEVER
        for operand in operands:
            joined = _both if kind == _AND else _either
            result = joined(result, self._unread(operand))
        return result


def _both(a: Obligation, b: Obligation) -> Obligation:
    if a == NOTHING or not b:
        return b
    if b == NOTHING or not a:
        return a
    if len(a) == len(b) == 1:
        return (a[0] | b[0],)
    result: set[int] = set()
    for x in a:
        result.update(x | y for y in b)
        if len(result) > MAX_CLAUSES:
            result = set(_absorbed(result))
    return _absorbed(result)


def _either(a: Obligation, b: Obligation) -> Obligation:
    if not a or not b:
        return a or b
    return _absorbed({*a, *b})


def _absorbed(clauses: set[int]) -> Obligation:
    """The clauses without those that contain another."""
    if len(clauses) < 2:
        return tuple(clauses)
    kept: list[int] = []
    for clause in sorted(clauses, key=int.bit_count):
        if not any(other & ~clause == 0 for other in kept):
            kept.append(clause)
    if len(kept) > MAX_CLAUSES:
        raise InputError(
            "formula",
            f"what is left of it after a letter takes {len(kept)} cases, and at most {MAX_CLAUSES} "
            "are followed",
            "say it with fewer alternatives of temporal operators",
        )
    return tuple(sorted(kept))
