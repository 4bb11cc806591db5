"""A formula read backwards along a word.

Whether it holds from a letter on depends on that letter and on which of its parts hold from the
next letter on. The sets of parts that hold are the states of a table.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from conav.planning.verify_task import Formula

MAX_STATES = 4096
"""Sets of parts, before it is given up."""


class Table(NamedTuple):
    """Which parts of a formula hold, backwards along a word; states are numbers of such sets."""

    masks: list[int]  # the labels
    ends: NDArray[np.int64]  # (labels,) the state of a word's last letter
    before: NDArray[np.int64]  # (states, labels) the state one letter earlier
    good: NDArray[np.bool_]  # (states,) whether the formula holds


def backward_table(formula: Formula, names: Sequence[str], masks: Sequence[int]) -> Table:
    """The table for words of these labels, bit i of which stands for `names[i]`.

    Raises `ValueError` where it has more than `MAX_STATES` states.
    """
    parts: list[Formula] = []

    def collect(part: Formula) -> None:
        if part[0] != "name":
            for inner in part[1:]:
                collect(inner)
        if part not in parts:
            parts.append(part)

    collect(formula)
    place = {part: i for i, part in enumerate(parts)}
    bit = {name: 1 << i for i, name in enumerate(names)}

    def earlier(mask: int, after: int | None) -> int:
        """The parts that hold from a letter on; `after`: from the next one, None at the end."""
        found = 0
        for i, part in enumerate(parts):
            if _holds(part, mask, found, after, place, bit, i):
                found |= 1 << i
        return found

    numbers: dict[int, int] = {}
    ends = [numbers.setdefault(earlier(mask, None), len(numbers)) for mask in masks]
    rows: list[list[int]] = []
    while len(rows) < len(numbers):
        state = list(numbers)[len(rows)]
        rows.append([numbers.setdefault(earlier(mask, state), len(numbers)) for mask in masks])
        if len(numbers) > MAX_STATES:
            raise ValueError(f"more than {MAX_STATES} states")
    root = 1 << place[formula]
    return Table(
        list(masks),
        np.array(ends, dtype=np.int64),
        np.array(rows, dtype=np.int64),
        np.array([bool(state & root) for state in numbers]),
    )


def _holds(
    part: Formula,
    mask: int,
    now: int,
    after: int | None,
    place: dict[Formula, int],
    bit: dict[str, int],
    number: int,
) -> bool:
    """Whether a part holds; `now` has its own parts that do, `after` what held a letter later."""
    operator = part[0]
    if operator in ("true", "false"):
        return operator == "true"
    if operator == "name":
        return bool(mask & bit[part[1]])
    truths = [bool(now >> place[inner] & 1) for inner in part[1:]]
    a, b = truths[0], truths[-1]
    last = after is None
    later = not last and bool(after >> number & 1)
    if operator == "!":
        return not a
    if operator == "&":
        return a and b
    if operator == "|":
        return a or b
    if operator == "->":
        return not a or b
    if operator == "<->":
        return a == b
    if operator == "F":
        return a or later
    if operator == "G":
        return a and (last or later)
    if operator == "U":
        return b or (a and later)
    if operator == "W":
        return b or (a and (last or later))
    if operator == "R":
        return b and (a or last or later)
    inner = place[part[1]]
    return operator == "WX" if last else bool(after >> inner & 1)
