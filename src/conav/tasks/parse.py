"""Formulas from text.

    F goal & G safe          (!b U a) & F b          coverage(dock, shelf) & avoid("room 1")

Precedence, strongest first: `!` and the operators before a formula; `U R W`; `&`; `|`; `->`; `<->`.
Equals between two formulas group to the right. The parser climbs precedences: a level of nesting
costs two calls, and levels are counted.
"""

import difflib
import re
from collections.abc import Collection
from typing import NamedTuple, NoReturn

from conav.errors import InputError
from conav.tasks.formula import (
    BINDING,
    CONSTANTS,
    HELPERS,
    MAX_DEPTH,
    PLAIN_NAME,
    UNARY,
    VARIADIC,
    Formula,
    Operator,
    region,
    word_operator,
    written_name,
)
from conav.tasks.patterns import PATTERNS

SYMBOLS = {
    "!": Operator.NOT,
    "~": Operator.NOT,
    "&": Operator.AND,
    "&&": Operator.AND,
    "|": Operator.OR,
    "||": Operator.OR,
    "->": Operator.IMPLIES,
    "=>": Operator.IMPLIES,
    "<->": Operator.IFF,
    "<=>": Operator.IFF,
    "<>": Operator.EVENTUALLY,
    "[]": Operator.ALWAYS,
}

_TOKEN = re.compile(
    r"\s*(?:(?P<symbol><->|<=>|->|=>|<>|\[\]|&&?|\|\|?|[!~(),])"
    rf'|(?P<word>{PLAIN_NAME.pattern})|"(?P<quoted>[^"]*)"|(?P<end>$))'
)
_EXCERPT = 76  # letters of a line that shows the place


def parse_formula(
    text: str, *, regions: Collection[str] | None = None, allow_next: bool = False
) -> Formula:
    """The formula that a text says.

    With `regions` only their names may occur. `X` and `WX` are refused unless `allow_next`: a word
    has a letter only where the regions change (`conav.tasks.automaton`), so "next" is the next
    change and no step of time.

    Raises `InputError` that shows the text with a caret under the place.

    >>> str(parse_formula("<> goal and always(safe)"))
    'F goal & G safe'
    """
    parser = _Parser(text, regions, allow_next)
    formula = parser.formula(1, 0)
    token = parser.token
    if token.text == ")":
        parser.refuse(token, "')' closes nothing", "leave it out or open it")
    if token.text == ",":
        parser.refuse(token, "',' stands between regions of a helper only", "write & or |")
    if token.kind != "end":
        parser.refuse_neighbours()
    return formula


class _Token(NamedTuple):
    kind: str  # symbol, word, quoted or end
    text: str
    start: int

    @property
    def operator(self) -> Operator | None:
        if self.kind == "symbol":
            return SYMBOLS.get(self.text)
        return word_operator(self.text) if self.kind == "word" else None

    @property
    def shown(self) -> str:
        return f"'{self.text}'" if self.kind != "end" else "the end"


class _Parser:
    """The text's tokens, and how far they were read."""

    def __init__(self, text: str, regions: Collection[str] | None, allow_next: bool) -> None:
        self.text = text
        self.regions = None if regions is None else sorted(regions)
        self.allow_next = allow_next
        self.before: _Token | None = None
        self.token = self._read(0)

    def advance(self) -> _Token:
        """The token that was read; the one after it is next."""
        self.before = self.token
        self.token = self._read(self._end)
        return self.before

    def formula(self, least: int, depth: int) -> Formula:
        """The longest formula from here whose operators bind at least so strongly."""
        if depth > MAX_DEPTH:
            self._too_deep(self.token)
        left = self._operand(depth)
        while True:
            token, operator = self.token, self.token.operator
            if operator is None or BINDING.get(operator, 0) < least:
                return left
            if operator not in VARIADIC:
                self.advance()
                left = self._made(token, operator, left, self.formula(BINDING[operator], depth + 1))
                continue
            operands = [left]
            while self.token.operator == operator:
                self.advance()
                operands.append(self.formula(BINDING[operator] + 1, depth + 1))
            left = self._made(token, operator, *operands)

    def refuse(self, token: _Token, problem: str, remedy: str) -> NoReturn:
        self._refuse_at(token.start, problem, remedy)

    def refuse_neighbours(self) -> NoReturn:
        """Raises `InputError`: what is next does not belong to what was read."""
        remedy = "write one, for example &"
        for token, fitting in ((self.token, BINDING), (self.before, UNARY)):
            word = token.text if token is not None else ""
            meant = word_operator(word.upper())
            if meant in fitting and word != meant:
                remedy = f"did you mean {meant} for {word}?"
        self.refuse(self.token, f"there is no operator before {self.token.shown}", remedy)

    def _operand(self, depth: int) -> Formula:
        token = self.advance()
        operator = token.operator
        if token.text == "(" and token.kind == "symbol":
            inner = self.formula(1, depth + 1)
            self._close(token)
            return inner
        if token.kind == "quoted" or (token.kind == "word" and operator is None):
            if token.kind == "word" and token.text.lower() in HELPERS:
                return self._helper(token, depth)
            return self._region(token)
        if operator is not None and operator in UNARY:
            if operator in (Operator.NEXT, Operator.WEAK_NEXT) and not self.allow_next:
                self.refuse(
                    token,
                    f"{token.text} is not allowed: a word has a letter only where the regions "
                    "change, so the next letter is the next change and no step of time",
                    "use F, G or U, or allow it where the next change is meant (allow_next, "
                    "--next)",
                )
            return self._made(token, operator, self.formula(6, depth + 1))
        if operator is not None and operator in CONSTANTS:
            return Formula(operator)
        where = "at the end" if token.kind == "end" else f"before {token.shown}"
        if not self.text.strip():
            self.refuse(token, "there is no formula", "write one, for example F goal")
        self.refuse(
            token, f"a formula is missing {where}", "write one, for example a region's name"
        )

    def _helper(self, token: _Token, depth: int) -> Formula:
        opening = self.token
        if opening.text != "(" or opening.kind != "symbol":
            self.refuse(
                token,
                f"{token.text} needs regions in parentheses",
                f'write {token.text}(a, b), or "{token.text}" for a region of that name',
            )
        self.advance()
        regions = [self.formula(1, depth + 1)]
        while self.token.text == "," and self.token.kind == "symbol":
            self.advance()
            regions.append(self.formula(1, depth + 1))
        self._close(opening)
        try:
            return PATTERNS[token.text.lower()](*regions)
        except InputError as error:
            self.refuse(token, error.problem, error.remedy)

    def _region(self, token: _Token) -> Formula:
        if self.regions is not None and token.text not in self.regions:
            near = difflib.get_close_matches(token.text, self.regions, n=1)
            if near:
                remedy = f"did you mean {written_name(near[0])}?"
            elif self.regions:
                remedy = "the regions: " + ", ".join(map(written_name, self.regions))
            else:
                remedy = "there is none at all"
            self.refuse(token, f"there is no region {token.text!r}", remedy)
        if not token.text:
            self.refuse(token, "the name is empty", "write one")
        try:
            return region(token.text)
        except InputError as error:
            self.refuse(token, error.problem, error.remedy)

    def _close(self, opening: _Token) -> None:
        if self.token.text == ")" and self.token.kind == "symbol":
            self.advance()
        elif self.token.kind == "end":
            self.refuse(opening, "'(' is never closed", "add )")
        else:
            self.refuse_neighbours()

    def _made(self, token: _Token, operator: Operator, *operands: Formula) -> Formula:
        if any(operand.depth >= MAX_DEPTH for operand in operands):
            self._too_deep(token)
        return Formula(operator, operands)

    def _too_deep(self, token: _Token) -> NoReturn:
        self.refuse(
            token, f"is nested more than {MAX_DEPTH} deep", "write it with fewer parentheses"
        )

    def _read(self, start: int) -> _Token:
        match = _TOKEN.match(self.text, start)
        if match is None:
            at = start + len(self.text[start:]) - len(self.text[start:].lstrip())
            if self.text[at] == '"':
                self._refuse_at(at, "the quote is never closed", 'add "')
            self._refuse_at(
                at, f"{self.text[at]!r} means nothing in a formula",
                'write names of other letters in quotes, for example "room-1"',
            )  # fmt: skip
        self._end = match.end()
        kind = match.lastgroup or "end"
        # The caret belongs under the quote, not under the first letter inside.
        return _Token(kind, match[kind], match.start(kind) - (kind == "quoted"))

    def _refuse_at(self, at: int, problem: str, remedy: str) -> NoReturn:
        raise InputError(f"formula, column {at + 1}", problem, remedy, _excerpt(self.text, at))


def _excerpt(text: str, at: int) -> str:
    """The line of text around a place, and a caret under it."""
    # Every letter has to keep its column, so whatever is no letter becomes one blank.
    line = "".join(letter if letter.isprintable() else " " for letter in text)
    first = max(0, min(at - _EXCERPT // 2, len(line) - _EXCERPT))
    part = line[first : first + _EXCERPT]
    before = "... " if first else ""
    after = " ..." if first + _EXCERPT < len(line) else ""
    return f"    {before}{part}{after}\n    {' ' * (len(before) + at - first)}^"
