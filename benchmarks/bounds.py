"""Bounds on the finishing time, beside a run: values and how long they take to compute.

    python benchmarks/bounds.py                     # office, cave, maze of 250 x 250 cells at 0.1 m
    CONAV_DATA=... python benchmarks/bounds.py      # and the maps of Explore-Bench found there
    python benchmarks/bounds.py --large             # the large maps found there instead
    python benchmarks/bounds.py --full              # full bounds instead of quick ones
    python benchmarks/bounds.py --fine              # planning cells of 0.1 m instead of 0.3 m
    python benchmarks/bounds.py --json bounds.json  # the rows as data

Times of the simulation in seconds at 0.5 m/s, 7 m range, 8-connected. `lower` is the largest of the
three before it, `upper` the time of the fastest run known, `run` the strategy's. The ratio of the
run to the optimum lies between `from` and `to`. The last columns are processor time: of the bounds
for all four shares together, and of the run.
"""

import argparse
import json
import os
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from math import isinf
from pathlib import Path
from time import process_time

import conav
from conav.exploration.catalogue import make_strategy
from conav.exploration.types import ExplorationProblem
from conav.simulation.explore import exploration_problem
from conav.simulation.finish_bounds import Effort, finish_bounds
from conav.simulation.run_exploration import run_exploration
from conav.simulation.starts import nearest_standable

COLUMNS = (
    *("map", "robots", "share", "swath", "eccentricity", "witness", "lower", "upper"),
    *("run", "from", "to", "bounds cpu s", "run cpu s"),
)

# Explore-Bench's own starts of two robots [m], as its launch files have them; where a robot of this
# radius does not fit it starts at the nearest place where it does.
EXPLORE_BENCH = {
    "corner": {"close": [(5, 7), (7, 5)], "far": [(8, 8), (-8, -8)]},
    "corridor": {"close": [(8, 7), (8, 9)], "far": [(8, 8), (-8, -8)]},
    "loop": {"close": [(9, 7), (7, 9)], "far": [(8, 8), (-8, -8)]},
    "loop_with_corridor": {"close": [(9, 7), (7, 9)]},
    "room": {"close": [(1, 1), (-1, -1)], "far": [(8, 7.5), (-7.5, -8)]},
    "room_with_corner": {"close": [(9, 7), (7, 9)]},
}

LARGE = (
    *("aws_small_house/map", "patrolling_sim/cumberland", "navigation2/depot"),
    *("patrolling_sim/DIAG_labs", "patrolling_sim/broughton", "comprobo22/mac_1st_floor_final"),
)


def measure(
    problem: ExplorationProblem, name: str, strategy: str, effort: str
) -> list[dict[str, object]]:
    """The rows of a problem, printed as well."""
    start = process_time()
    metrics = run_exploration(problem, make_strategy(strategy), name=strategy).metrics
    ran = process_time()
    found = finish_bounds(problem, effort=effort)
    end = process_time()
    rows: list[dict[str, object]] = []
    for share, known in found.items():
        reached = getattr(metrics, f"t{share}_s")
        bounds = known.with_run(reached, strategy)
        assert bounds.upper_s is None or bounds.upper_s >= bounds.lower_s, "a run beat the bound"
        low, high = (
            bounds.ratios_beyond(metrics.time_s) if reached is None else bounds.ratios(reached)
        )
        last = share == 100
        rows.append(
            {
                "map": name,
                "robots": len(problem.robots),
                "share": share,
                "swath": bounds.swath_s,
                "eccentricity": bounds.eccentricity_s,
                "witness": bounds.witness_s,
                "lower": bounds.lower_s,
                "upper": bounds.upper_s,
                "run": reached,
                "from": low,
                "to": None if isinf(high) else high,
                "bounds cpu s": end - ran if last else None,
                "run cpu s": ran - start if last else None,
            }
        )
        print("| " + " | ".join(shown(key, rows[-1][key]) for key in COLUMNS) + " |", flush=True)
    return rows


def starting_at(
    problem: ExplorationProblem, points: Sequence[tuple[float, float]]
) -> ExplorationProblem:
    plan = problem.plan
    x0, y0, _ = plan.grid.origin
    cells = [plan.lattice.cell_at(x - x0, y - y0) for x, y in points]
    return replace(problem, starts=tuple(nearest_standable(plan, cell) for cell in cells))


def shown(key: str, value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.2f}" if key in ("from", "to") else f"{value:.1f}"
    return str(value)


def mended(path: Path, folder: Path) -> Path:
    """A copy of a map that names its own picture; `loop.yaml` names one that is not there."""
    text = path.read_text().splitlines()
    lines = [f"image: {path.stem}.pgm" if line.startswith("image:") else line for line in text]
    shutil.copy(path.with_suffix(".pgm"), folder)
    (folder / path.name).write_text("\n".join(lines) + "\n")
    return folder / path.name


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--fine", action="store_true")
    parser.add_argument("--strategy", default="nearest")
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    size = {"cell_m": 0.1, "radius_m": 0.035} if options.fine else {}
    effort = "full" if options.full else "quick"
    print("| " + " | ".join(COLUMNS) + " |\n|" + "---|" * len(COLUMNS))
    rows: list[dict[str, object]] = []
    data = os.environ.get("CONAV_DATA")
    maps = Path(data) / "maps" if data else None
    warm, _ = exploration_problem("three-obstacles", robots=1, max_time_s=20.0)
    finish_bounds(warm, effort=Effort(rounds=1))  # the kernels are loaded
    if options.large:
        for name in LARGE:
            if maps is not None and (maps / f"{name}.yaml").exists():
                problem, _ = exploration_problem(maps / f"{name}.yaml", robots=3, **size)
                rows += measure(problem, name, options.strategy, effort)
    else:
        for name in ("office", "cave", "maze"):
            grid = conav.builtin_map(name, width_m=25.0, height_m=25.0, resolution=0.1)
            for robots in (2, 4):
                problem, _ = exploration_problem(grid, robots=robots, seed=options.seed, **size)
                rows += measure(problem, name, options.strategy, effort)
        for name, teams in EXPLORE_BENCH.items():
            if maps is None or not (maps / f"explore_bench/{name}.yaml").exists():
                continue
            with tempfile.TemporaryDirectory() as folder:
                path = mended(maps / f"explore_bench/{name}.yaml", Path(folder))
                problem, _ = exploration_problem(path, robots=2, **size)
                for team, points in teams.items():
                    given = starting_at(problem, points)
                    rows += measure(given, f"{name} {team}", options.strategy, effort)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
