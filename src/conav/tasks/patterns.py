"""Tasks that occur all the time, under the names OMPL gives their automata.

They differ from OMPL's where regions overlap: there every label serves one region, here it serves
every region it holds, so that it does not matter whether a robot comes to two places at once or
one right after the other.
"""

from conav.errors import InputError
from conav.tasks.formula import (
    Formula,
    always,
    conjunction,
    disjunction,
    eventually,
    negation,
    region,
)


def coverage(*regions: str | Formula) -> Formula:
    """Every region is visited, in any order. A text is a region's name, not a formula's text.

    >>> str(coverage("a", "b", "c"))
    'F a & F b & F c'
    """
    return conjunction(*(eventually(each) for each in _formulas("coverage", regions)))


def sequence(*regions: str | Formula) -> Formula:
    """The regions are visited in this order; other visits before, between and after do not matter.

    A text is a region's name, not a formula's text.

    >>> str(sequence("a", "b", "c"))
    'F (a & F (b & F c))'
    """
    *firsts, last = _formulas("sequence", regions)
    task = eventually(last)
    for each in reversed(firsts):
        task = eventually(conjunction(each, task))
    return task


def avoid(*regions: str | Formula) -> Formula:
    """No region is ever entered. A text is a region's name, not a formula's text.

    >>> str(avoid("a", "b"))
    'G !(a | b)'
    """
    return always(negation(disjunction(*_formulas("avoid", regions))))


PATTERNS = {"coverage": coverage, "sequence": sequence, "avoid": avoid}
"""By the name under which a formula's text calls them."""


def _formulas(pattern: str, regions: tuple[str | Formula, ...]) -> list[Formula]:
    if not regions:
        raise InputError(pattern, "has no regions", f"write {pattern}(a, b)")
    return [each if isinstance(each, Formula) else region(each) for each in regions]
