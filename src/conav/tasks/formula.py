"""Formulas of finite linear temporal logic [DeGiacomo2013] over the names of regions.

A formula speaks of a word: the sets of regions a robot is in, one after the other, without
repetition (`conav.tasks.automaton`). `str` writes a formula so that `conav.tasks.parse` reads the
same one again.
"""

import re
from dataclasses import dataclass, field
from enum import StrEnum

from conav.errors import InputError

MAX_DEPTH = 100
"""Of operators in each other: what walks over formulas may then call itself."""


class Operator(StrEnum):
    """What a formula is made by; the value is how it is written."""

    TRUE = "true"
    FALSE = "false"
    NAME = "name"
    """The robot is in the region of that name."""
    NOT = "!"
    AND = "&"
    OR = "|"
    IMPLIES = "->"
    IFF = "<->"
    EVENTUALLY = "F"
    ALWAYS = "G"
    UNTIL = "U"
    """The second will hold, and the first does until then."""
    RELEASE = "R"
    """The second holds up to and including where the first does, or to the end."""
    WEAK_UNTIL = "W"
    """The first holds until the second does, or to the end."""
    NEXT = "X"
    """There is a next letter and from there it holds."""
    WEAK_NEXT = "WX"
    """It holds from the next letter, if there is one."""


CONSTANTS = frozenset({Operator.TRUE, Operator.FALSE})
UNARY = frozenset(
    {Operator.NOT, Operator.EVENTUALLY, Operator.ALWAYS, Operator.NEXT, Operator.WEAK_NEXT}
)
VARIADIC = frozenset({Operator.AND, Operator.OR})

BINDING = {
    Operator.IFF: 1,
    Operator.IMPLIES: 2,
    Operator.OR: 3,
    Operator.AND: 4,
    Operator.UNTIL: 5,
    Operator.RELEASE: 5,
    Operator.WEAK_UNTIL: 5,
}
"""How strongly an operator between two formulas binds; one before a formula binds strongest.

Equals group to the right.
"""

WORDS = {
    "true": Operator.TRUE,
    "false": Operator.FALSE,
    "not": Operator.NOT,
    "and": Operator.AND,
    "or": Operator.OR,
    "eventually": Operator.EVENTUALLY,
    "always": Operator.ALWAYS,
    "until": Operator.UNTIL,
    "release": Operator.RELEASE,
    **{name: Operator(name) for name in ("F", "G", "U", "R", "W", "X", "WX")},
}
"""Operators that are written as words; those of two lower-case letters or more in any case."""

HELPERS = ("coverage", "sequence", "avoid")
"""Names that need quotes to be regions, beside `WORDS`."""

PLAIN_NAME = re.compile(r"[^\W\d]\w*")
"""Names that need no quotes, and words."""


@dataclass(frozen=True, slots=True)
class Formula:
    """An operator and its operands: one or two, two or more for & and |, none for a name.

    Raises `InputError` for a wrong number of operands, for a name where none belongs or that
    cannot be written, and above `MAX_DEPTH`.
    """

    operator: Operator
    operands: tuple["Formula", ...] = ()
    name: str = ""
    depth: int = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        depth = 1 + max((operand.depth for operand in self.operands), default=0)
        if depth > MAX_DEPTH:
            raise InputError("formula", f"is more than {MAX_DEPTH} operators deep", "split it")
        count = len(self.operands)
        if self.operator in VARIADIC:
            fits = count >= 2
        elif self.operator in UNARY:
            fits = count == 1
        else:
            fits = count == (
                0 if self.operator in CONSTANTS or self.operator == Operator.NAME else 2
            )
        if not fits:
            raise InputError(f"operator {self.operator}", f"cannot have {count} operands")
        if bool(self.name) != (self.operator == Operator.NAME):
            raise InputError(f"operator {self.operator}", f"cannot have the name {self.name!r}")
        if any(letter == '"' or not letter.isprintable() for letter in self.name):
            raise InputError(
                f"name {self.name!r}", "cannot be written in a formula", "leave out quotes"
            )
        object.__setattr__(self, "depth", depth)

    def __str__(self) -> str:
        if self.operator == Operator.NAME:
            return written_name(self.name)
        if self.operator in CONSTANTS:
            return self.operator.value
        if self.operator in UNARY:
            (operand,) = self.operands
            space = "" if self.operator == Operator.NOT else " "
            return f"{self.operator}{space}{_inside(operand, 6)}"
        binding = BINDING[self.operator]
        *firsts, last = self.operands
        # Only the last may be of equal binding without parentheses, and not of & and |, whose
        # operands on one level are the operands of one formula.
        parts = [_inside(operand, binding + 1) for operand in firsts]
        parts.append(_inside(last, binding + (self.operator in VARIADIC)))
        return f" {self.operator} ".join(parts)

    @property
    def names(self) -> frozenset[str]:
        """The regions it speaks of."""
        if self.operator == Operator.NAME:
            return frozenset({self.name})
        return frozenset().union(*(operand.names for operand in self.operands))


def written_name(name: str) -> str:
    """A region's name as it stands in a formula: in quotes where it would be read otherwise.

    >>> written_name("dock"), written_name("room 1"), written_name("F")
    ('dock', '"room 1"', '"F"')
    """
    reserved = word_operator(name) is not None or name.lower() in HELPERS
    return f'"{name}"' if reserved or not PLAIN_NAME.fullmatch(name) else name


def word_operator(word: str) -> Operator | None:
    """The operator of a word, `None` where it is a name."""
    return WORDS.get(word) or (WORDS.get(word.lower()) if len(word) > 1 else None)


def region(name: str) -> Formula:
    """The formula that holds where the robot is in that region."""
    return Formula(Operator.NAME, name=name)


def negation(operand: Formula) -> Formula:
    """Not the operand."""
    return Formula(Operator.NOT, (operand,))


def eventually(operand: Formula) -> Formula:
    """The operand holds somewhere from here on."""
    return Formula(Operator.EVENTUALLY, (operand,))


def always(operand: Formula) -> Formula:
    """The operand holds everywhere from here on."""
    return Formula(Operator.ALWAYS, (operand,))


def conjunction(*operands: Formula) -> Formula:
    """All of the operands, one at least."""
    return operands[0] if len(operands) == 1 else Formula(Operator.AND, operands)


def disjunction(*operands: Formula) -> Formula:
    """Some of the operands, one at least."""
    return operands[0] if len(operands) == 1 else Formula(Operator.OR, operands)


def _inside(operand: Formula, needed: int) -> str:
    """The operand's text, in parentheses where it binds less than is needed."""
    text = str(operand)
    return f"({text})" if BINDING.get(operand.operator, 6) < needed else text
