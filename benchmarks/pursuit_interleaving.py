"""Exploration and pursuit in turn against exploring first: docs/pursuit-unknown.md.

    python benchmarks/pursuit_interleaving.py
    python benchmarks/pursuit_interleaving.py --care 0 --floors rooms:3 ring --bounds 1 unlimited

Prints a line for each floor and bound, and the table of ratios.
"""

import argparse

from conav.experiments.pursuit.interleaving import (
    BOUNDS,
    FLOORS,
    Bound,
    Cleared,
    against_exploring_first,
    compare_bounds,
    table,
)
from conav.pursuit.clear_unknown_map import ClearUnknownMap


def bound(text: str) -> Bound:
    return "unlimited" if text == "unlimited" else int(text)


def show(one: Cleared) -> None:
    print(
        f"{one.floor} edb {one.edb}: {one.verdict or 'given up'}, {one.pursuers} pursuers, "
        f"{one.distance_m:.1f} m in {one.time_s:.1f} s, {one.recontaminations} recontaminations, "
        f"{one.explored_vertices} vertices explored, {one.pursuits} pursuits",
        flush=True,
    )


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--floors", nargs="+", default=list(FLOORS))
parser.add_argument("--bounds", nargs="+", type=bound, default=list(BOUNDS))
parser.add_argument("--care", type=float, default=ClearUnknownMap.care)
chosen = parser.parse_args()
rows = compare_bounds(chosen.floors, chosen.bounds, care=chosen.care, on_cleared=show)
print("\n".join(table(against_exploring_first(rows))))
