"""Finite linear temporal logic read and evaluated for the verifier, written a second time.

A formula is a nested tuple: an operator and its operands. It is evaluated on a word by its meaning,
position by position, without any automaton.
"""

import re
from collections.abc import Sequence
from functools import reduce
from typing import Any

Formula = tuple[Any, ...]
Word = Sequence[frozenset[str]]

_TOKEN = re.compile(r'\s*(?:("[^"]*")|(<->|<=>|->|=>|<>|\[\]|&&|\|\||[!~&|(),])|([^\W\d]\w*))')
_SAME = {
    "~": "!",
    "&&": "&",
    "||": "|",
    "=>": "->",
    "<=>": "<->",
    "<>": "F",
    "[]": "G",
    "not": "!",
    "and": "&",
    "or": "|",
    "eventually": "F",
    "always": "G",
    "until": "U",
    "release": "R",
    "true": "true",
    "false": "false",
}
_LETTERS = ("F", "G", "U", "R", "W", "X", "WX")
_BEFORE = ("!", "F", "G", "X", "WX")
_LEVELS = (("<->",), ("->",), ("|",), ("&",), ("U", "R", "W"))  # weakest first
_DEEPEST = 120


class Unreadable(ValueError):
    """A text that is no formula."""


def read_formula(text: str) -> Formula:
    """The formula in a text. Raises `Unreadable`."""
    tokens = _tokens(text)
    formula, rest = _level(tokens, 0, 0)
    if rest:
        raise Unreadable(f"{rest[0][1]!r} is left over")
    return formula


def names_in(formula: Formula) -> frozenset[str]:
    """The regions it speaks of."""
    if formula[0] == "name":
        return frozenset({formula[1]})
    return frozenset[str]().union(*(names_in(part) for part in formula[1:]))


def satisfied(formula: Formula, word: Word) -> bool:
    """Whether a word, which has a letter at least, satisfies a formula."""
    return bool(word) and _truth(formula, word, {})[0]


def _truth(formula: Formula, word: Word, known: dict[Formula, list[bool]]) -> list[bool]:
    """Whether it holds from each letter of the word on."""
    if formula in known:
        return known[formula]
    operator, *parts = formula
    n = len(word)
    if operator in ("true", "false"):
        found = [operator == "true"] * n
    elif operator == "name":
        found = [parts[0] in letter for letter in word]
    else:
        truths = [_truth(part, word, known) for part in parts]
        a, b = truths[0], truths[-1]
        if operator == "!":
            found = [not x for x in a]
        elif operator == "&":
            found = [x and y for x, y in zip(a, b, strict=True)]
        elif operator == "|":
            found = [x or y for x, y in zip(a, b, strict=True)]
        elif operator == "->":
            found = [not x or y for x, y in zip(a, b, strict=True)]
        elif operator == "<->":
            found = [x == y for x, y in zip(a, b, strict=True)]
        elif operator == "F":
            found = [any(a[i:]) for i in range(n)]
        elif operator == "G":
            found = [all(a[i:]) for i in range(n)]
        elif operator in ("X", "WX"):
            found = [*a[1:], operator == "WX"]
        elif operator == "U":
            found = [any(b[j] and all(a[i:j]) for j in range(i, n)) for i in range(n)]
        elif operator == "W":
            found = [all(a[i:]) or any(b[j] and all(a[i:j]) for j in range(i, n)) for i in range(n)]
        elif operator == "R":
            found = [
                all(b[i:]) or any(a[j] and all(b[i : j + 1]) for j in range(i, n)) for i in range(n)
            ]
        else:
            raise AssertionError(operator)
    known[formula] = found
    return found


_Token = tuple[str, str]  # "name" and a name, "op" and an operator, "helper" and its name
_Tokens = list[_Token]


def _tokens(text: str) -> _Tokens:
    found: _Tokens = []
    at = 0
    while text[at:].strip():
        match = _TOKEN.match(text, at)
        if match is None:
            raise Unreadable(f"{text[at:].strip()[0]!r} means nothing")
        at = match.end()
        quoted, symbol, word = match.groups()
        if quoted is not None:
            found.append(("name", quoted[1:-1]))
        elif symbol is not None:
            found.append(("op", _SAME.get(symbol, symbol)))
        elif word in _LETTERS:
            found.append(("op", word))
        elif word.lower() in _SAME and len(word) > 1:
            found.append(("op", _SAME[word.lower()]))
        elif word.lower() in ("coverage", "sequence", "avoid"):
            found.append(("helper", word.lower()))
        else:
            found.append(("name", word))
    return found


def _level(tokens: _Tokens, level: int, depth: int) -> tuple[Formula, _Tokens]:
    """The longest formula whose operators are of this level or bind stronger, and what follows."""
    if depth > _DEEPEST:
        raise Unreadable("is nested too deeply")
    if level == len(_LEVELS):
        return _operand(tokens, depth)
    left, rest = _level(tokens, level + 1, depth)
    if rest and rest[0][0] == "op" and rest[0][1] in _LEVELS[level]:
        # Equals group to the right, which for & and | makes no difference.
        right, after = _level(rest[1:], level, depth + 1)
        return (rest[0][1], left, right), after
    return left, rest


def _operand(tokens: _Tokens, depth: int) -> tuple[Formula, _Tokens]:
    if not tokens:
        raise Unreadable("a formula is missing at the end")
    (kind, text), rest = tokens[0], tokens[1:]
    if kind == "name":
        return ("name", text), rest
    if kind == "helper":
        return _helper(text, rest, depth)
    if text in ("true", "false"):
        return (text,), rest
    if text in _BEFORE:
        if depth > _DEEPEST:
            raise Unreadable("is nested too deeply")
        inner, rest = _operand(rest, depth + 1)
        return (text, inner), rest
    if text == "(":
        inner, rest = _level(rest, 0, depth + 1)
        return inner, _after(")", rest)
    raise Unreadable(f"a formula is missing before {text!r}")


def _helper(name: str, tokens: _Tokens, depth: int) -> tuple[Formula, _Tokens]:
    rest = _after("(", tokens)
    parts: list[Formula] = []
    while True:
        part, rest = _level(rest, 0, depth + 1)
        parts.append(part)
        if not rest or rest[0] != ("op", ","):
            break
        rest = rest[1:]
    rest = _after(")", rest)
    if name == "coverage":
        return reduce(lambda a, b: ("&", a, b), [("F", part) for part in parts]), rest
    if name == "avoid":
        return ("G", ("!", reduce(lambda a, b: ("|", a, b), parts))), rest
    formula: Formula = ("F", parts[-1])
    for part in reversed(parts[:-1]):
        formula = ("F", ("&", part, formula))
    return formula, rest


def _after(symbol: str, tokens: _Tokens) -> _Tokens:
    if not tokens or tokens[0] != ("op", symbol):
        raise Unreadable(f"{symbol!r} is missing")
    return tokens[1:]
