"""What translating tasks costs: docs/performance.md, Tasks.

    python benchmarks/automata.py
    python benchmarks/automata.py 'F a & G (b -> F c)' ...     # formulas of your own

For each formula the states of its automaton, the letters (all label sets of its regions; where a d
follows, of regions that do not overlap), and the least processor time of five translations,
minimisation included.
"""

import argparse
from collections.abc import Iterable
from time import process_time

from conav.tasks.automaton import Letter
from conav.tasks.formula import Formula
from conav.tasks.parse import parse_formula
from conav.tasks.translate import automaton_of, disjoint_letters

REPEAT = 5


def tasks() -> Iterable[tuple[str, Formula, bool]]:
    """Name, formula, and whether regions do not overlap."""
    for text in ("F goal & G safe", "F a & F b & G !c", "(!b U a) & F b"):
        yield text, parse_formula(text), False
    for count in (4, 6, 8, 10):
        names = [f"a{i}" for i in range(1, count + 1)]
        yield (
            f"F a1 & ... & F a{count}",
            parse_formula(f"coverage({', '.join(names)})"),
            False,
        )
    for count in (8, 12):
        names = [f"a{i}" for i in range(1, count + 1)]
        yield f"F a1 & ... & F a{count}", parse_formula(f"coverage({', '.join(names)})"), True
    names = [f"a{i}" for i in range(1, 41)]
    yield "sequence(a1, ..., a40)", parse_formula(f"sequence({', '.join(names)})"), True


def main() -> None:
    arguments = argparse.ArgumentParser(description="What translating tasks costs.")
    arguments.add_argument("formulas", nargs="*")
    given = arguments.parse_args().formulas
    chosen = [(text, parse_formula(text), False) for text in given] if given else tasks()
    print(f"{'formula':28} {'states':>7} {'letters':>8} {'ms':>9}")
    for name, formula, disjoint in chosen:
        letters: tuple[Letter, ...] | None = disjoint_letters(formula.names) if disjoint else None
        least = float("inf")
        for _ in range(REPEAT):
            start = process_time()
            made = automaton_of(formula, letters)
            least = min(least, process_time() - start)
        shown = f"{len(made.letters)}{' d' if disjoint else '  '}"
        print(f"{name:28} {made.n_states:7} {shown:>8} {1000 * least:9.2f}")


if __name__ == "__main__":
    main()
