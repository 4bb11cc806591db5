"""Which rule should give `potential-frontier` its frontiers: ranks, paths, pairs, the nearest.

    python benchmarks/frontier_rules.py --out study    # about five minutes

Each rule plays 40 layouts of three-obstacles in the world of [Philip2014], and 12 layouts each of
office, cave and maze with walls that block sight. Every robot computes the rule for itself, with
all robots it hears. Prints the tables over all; runs are kept in the folder.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from conav.experiments.compare.compare import compare
from conav.exploration.frontier_targets import Targets
from conav.exploration.greedy import assign_nearest_pairs
from conav.exploration.hungarian import assign_shortest
from conav.exploration.potential_frontier import PotentialFrontier
from conav.exploration.team_assignment import Assign
from conav.exploration.types import TeamView


def assign_nothing(
    targets: Targets, view: TeamView, robots: Sequence[int], positions: NDArray[np.int32]
) -> NDArray[np.int64]:
    """No target for anybody, so everybody goes to the nearest."""
    return np.full(len(robots), -1, dtype=np.int64)


class ByPaths(PotentialFrontier):
    assign: ClassVar[Assign] = staticmethod(assign_shortest)


class ByPairs(PotentialFrontier):
    assign: ClassVar[Assign] = staticmethod(assign_nearest_pairs)


class Nearest(PotentialFrontier):
    assign: ClassVar[Assign] = staticmethod(assign_nothing)


RULES = {
    "ranks": PotentialFrontier(),
    "paths": ByPaths(),
    "pairs": ByPairs(),
    "nearest": Nearest(),
}
PAPER: dict[str, Any] = {
    "ranges_m": (2.0,),
    "cell_m": 1.0,
    "speed_mps": 1.0,
    "motion": "forward-turn",
    "sensor": "disc",
    "traffic": "none",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("frontier-rules"))
    options = parser.parse_args()
    worlds: dict[str, tuple[list[str], int, dict[str, Any]]] = {
        "paper": (["three-obstacles"], 40, PAPER),
        "walls": (["office", "cave", "maze"], 12, {"ranges_m": (3.5,)}),
    }
    for name, (maps, runs, world) in worlds.items():
        done = compare(
            maps, RULES, options.out / name, runs=runs, jobs=1, bounds="none", plots=False, **world
        )
        print(f"{', '.join(maps)}, {runs} runs each: times to 90, 99 and 100 % over those of ranks")
        for total in done.totals:
            shown = (total.ratios[share].estimate for share in (90, 99, 100))
            ratios = "  ".join(f"{at.value:.2f} [{at.low:.2f}, {at.high:.2f}]" for at in shown)
            print(f"  {total.strategy:8} {ratios}  all seen {total.finished} of {total.runs}")


if __name__ == "__main__":
    main()
