"""`conav task`."""

import json as json_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from conav.cli.numbers import Whole
from conav.errors import InputError

if TYPE_CHECKING:
    from conav.tasks.automaton import Automaton
    from conav.tasks.formula import Formula

LONGEST_TABLE = 64
"""States of which every transition is printed, with its guard."""


def task(
    formula: str,
    /,
    *,
    regions: str | None = None,
    disjoint: Annotated[bool, Parameter(negative="")] = False,
    next: Annotated[bool, Parameter(negative="")] = False,
    max_states: Whole | None = None,
    out: Path | None = None,
    sink: Annotated[bool, Parameter(negative="")] = False,
    json: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Show what a task asks of a robot: the automaton of a formula, and whether it can be done.

    The exit code is 1 when no word satisfies the formula.

    Parameters
    ----------
    formula
        A formula of finite linear temporal logic, for example "F goal & G safe". See docs/tasks.md.
    regions
        The names it may use, for example goal,safe. Default: any.
    disjoint
        Regions do not overlap: a robot is in one at most.
    next
        Allow X and WX, which speak of the next change of regions and no step of time.
    max_states
        Give up when there are more before minimisation. Default: 10000.
    out
        Draw the automaton to a .png or .svg; needs the extra [plot].
    sink
        Draw the sink and what leads there, too.
    json
        Print one JSON object.
    """
    from conav.tasks.parse import parse_formula
    from conav.tasks.translate import MAX_STATES, automaton_of, disjoint_letters

    parsed = parse_formula(formula, regions=_names(regions), allow_next=next)
    letters = disjoint_letters(parsed.names) if disjoint else None
    limit = MAX_STATES if max_states is None else max_states
    automaton = automaton_of(parsed, letters, max_states=limit)
    if out is not None:
        from conav.pictures.automaton_figure import save_automaton

        save_automaton(out, automaton, title=str(parsed), sink=sink)
    if json:
        print(json_module.dumps(_summary(parsed, automaton, out)))
    else:
        for line in _lines(parsed, automaton):
            print(line)
        if out is not None:
            print(f"  picture: {out}")
    return 0 if automaton.satisfiable else 1


def _names(regions: str | None) -> list[str] | None:
    if regions is None:
        return None
    names = [name.strip() for name in regions.split(",")]
    if not all(names):
        raise InputError(
            f"--regions {regions}", "has an empty name", "part names by commas: goal,safe"
        )
    return names


def _summary(formula: "Formula", automaton: "Automaton", out: Path | None) -> dict[str, object]:
    word = automaton.shortest_word()
    return {
        "job": "task",
        "formula": str(formula),
        "propositions": list(automaton.propositions),
        "letters": [sorted(letter) for letter in automaton.letters],
        "states": automaton.n_states,
        "transition": automaton.transition.tolist(),
        "accepting": automaton.accepting.tolist(),
        "sink": automaton.sink.tolist(),
        "distance_to_accept": automaton.distance_to_accept.tolist(),
        "satisfiable": automaton.satisfiable,
        "valid": automaton.valid,
        "stutter_invariant": automaton.stutter_invariant,
        "shortest_word": None if word is None else [sorted(letter) for letter in word],
        "picture": None if out is None else str(out),
    }


def _lines(formula: "Formula", automaton: "Automaton") -> list[str]:
    from conav.tasks.automaton import INITIAL, shown_letter
    from conav.tasks.guard import guards

    n, letters = automaton.n_states, len(automaton.letters)
    word = automaton.shortest_word()
    lines = [
        str(formula),
        f"  {n} state{'s' * (n != 1)} over {letters} label set{'s' * (letters != 1)}",
    ]
    if word is None:
        lines.append("  not satisfiable: no robot can do it")
    else:
        shown = " ".join(map(shown_letter, word))
        lines.append(f"  satisfiable: a shortest word is {shown}")
        lines.append("  valid: every word does it" if automaton.valid else "  not valid")
    if not automaton.stutter_invariant:
        lines.append("  words that repeat a letter count here, though no robot's word does")
    if n > LONGEST_TABLE:
        lines.append(f"  {n} states are too many for a table; --json has all transitions")
        return lines
    rows = [("state", "", "label", "next")]
    before = -1
    for source, target, guard in guards(automaton):
        kinds = [
            kind
            for kind, holds in (
                ("initial", source == INITIAL),
                ("accepting", automaton.accepting[source]),
                ("sink", automaton.sink[source]),
            )
            if holds
        ]
        first = source != before
        rows.append((f"q{source}" * first, ", ".join(kinds) * first, str(guard), f"q{target}"))
        before = source
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    lines += [
        "  " + "  ".join([*(row[i].ljust(widths[i]) for i in range(3)), row[3]]).rstrip()
        for row in rows
    ]
    return lines
