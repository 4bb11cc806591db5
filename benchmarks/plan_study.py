"""Very many plans over random scenes, each verified: a table, and the journal in the folder.

    python benchmarks/plan_study.py --out study               # 10,000 plans
    python benchmarks/plan_study.py --out study --plans 500

The same command goes on where it was stopped. The exit code is 1 if a plan breaks a rule.
"""

import argparse
import sys
from pathlib import Path

from conav.experiments.plan_study import plan_study, tallies


def tell(done: int, total: int) -> None:
    if done % 100 == 0 or done == total:
        print(f"  {done} of {total} plans", file=sys.stderr, flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("plan-study"))
    parser.add_argument("--plans", type=int, default=10_000)
    parser.add_argument("--samples", type=int, default=120)
    options = parser.parse_args()
    rows = tallies(plan_study(options.out, options.plans, samples=options.samples, progress=tell))
    heads = (
        "solver", "plans", "done", "out of budget", "infeasible", "verified", "partly checked",
        "violated", "collisions", "timeouts", "errors", "least clearance [m]",
    )  # fmt: skip
    print(f"| {' | '.join(heads)} |\n{'|---' * len(heads)}|")
    for row in rows:
        *counts, clearance = vars(row).values()
        least = "" if clearance is None else f"{clearance:.2g}"
        print(f"| {' | '.join((*map(str, counts), least))} |")
    return 1 if rows[-1].violated or rows[-1].errors else 0


if __name__ == "__main__":
    sys.exit(main())
