"""How far from the certified bound strategies are in an empty world of 100 x 100 m.

    python benchmarks/open_world.py
    python benchmarks/open_world.py --strategies lanes-and-pockets,two-stage,hungarian --runs 30

Cells of 0.5 m, a sensor of 4 m, 0.2 m/s, starts anywhere, as in [Dai2018]; the bound is that of
`conav.exploration.bounds` for the same starts. Means over runs with Student's 95 % interval.
"""

import argparse
from statistics import mean

import numpy as np

import conav
from conav.exploration.bounds.bounds import lower_bounds
from conav.exploration.catalogue import make_strategy
from conav.exploration.types import ExplorationProblem
from conav.intervals import mean_interval
from conav.simulation.explore import exploration_problem
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import run_exploration

SIDE_M = 100.0
CELL_M = 0.5


def world() -> conav.OccupancyGrid:
    side = round(SIDE_M / CELL_M)
    cells = np.ones((side, side), dtype=np.uint8)
    cells[1:-1, 1:-1] = 0
    return conav.OccupancyGrid(cells, CELL_M, name="empty")


def problem(robots: int, seed: int) -> ExplorationProblem:
    starts = np.random.default_rng(seed).uniform(2, SIDE_M - 2, (robots, 2)).tolist()
    made, _ = exploration_problem(
        world(), robots=robots, starts=starts, seed=seed, range_m=4.0, speed_mps=0.2
    )
    return made


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--strategies", default="lanes-and-pockets")
    parser.add_argument("--robots", default="1,2,4,6,10")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1000, help="of the first run")
    options = parser.parse_args()
    print("| robots | strategy | time / bound | worst | 99 % / bound | done | decision ms p99 |")
    print("|---|---|---|---|---|---|---|")
    for robots in (int(count) for count in options.robots.split(",")):
        for name in options.strategies.split(","):
            whole: list[float] = []
            most: list[float] = []
            decision: list[float] = []
            done = 0
            for seed in range(options.seed, options.seed + options.runs):
                given = problem(robots, seed)
                seen = observable_cells(given.plan, given.starts, given.robots[0].sensor)
                bound = lower_bounds(given, seen, witnesses=0).lower_s
                run = run_exploration(given, make_strategy(name), name=name)
                metrics = run.metrics
                done += metrics.t100_s is not None
                # What is not finished counts as long as it lasted: at least that.
                whole.append((metrics.t100_s or metrics.time_s) / bound)
                most.append((metrics.t99_s or metrics.time_s) / bound)
                decision.append(run.decision_ms["p99"])
            at = mean_interval(whole)
            print(
                f"| {robots} | {name} | {at.value:.3f} [{at.low:.3f}, {at.high:.3f}] "
                f"| {max(whole):.3f} | {mean(most):.3f} | {done} of {options.runs} "
                f"| {mean(decision):.1f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
