"""Bounds on the finishing time, beside a run: values and how long they take to compute.

    python benchmarks/bounds.py                     # office, cave, maze of 250 x 250 cells at 0.1 m
    CONAV_DATA=... python benchmarks/bounds.py      # and the maps of Explore-Bench found there
    python benchmarks/bounds.py --fine              # planning cells of 0.1 m instead of 0.3 m
    python benchmarks/bounds.py --json bounds.json  # the rows as data

Times of the simulation in seconds at 0.5 m/s, 7 m range, 8-connected. `lower` is the largest of the
three before it. The ratio of the run to the optimum lies between `from` and `to`. The last two
columns are wall time: the lower bounds (the first row of a map also passes over its cells, and the
first of all loads the kernels) and the known-map plan with its run.
"""

import argparse
import json
import os
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import conav
from conav.exploration.bounds.bounds import FinishBounds, lower_bounds, time_of
from conav.exploration.catalogue import make_strategy
from conav.exploration.types import ExplorationProblem
from conav.simulation.explore import exploration_problem
from conav.simulation.known_map_run import known_map_run
from conav.simulation.observable import observable_cells
from conav.simulation.run_exploration import run_exploration
from conav.simulation.starts import nearest_standable

SHARES = (90, 95, 99, 100)  # [%]
COLUMNS = (
    *("map", "robots", "share", "swath", "eccentricity", "witness", "lower", "upper"),
    *("run", "from", "to", "lower wall s", "upper wall s"),
)

# Explore-Bench's own starts of two robots [m], as its launch files have them; where a robot of this
# radius does not fit it starts at the nearest place where it does.
EXPLORE_BENCH = {
    "corner": {"close": [(5, 7), (7, 5)], "far": [(8, 8), (-8, -8)]},
    "loop": {"close": [(9, 7), (7, 9)], "far": [(8, 8), (-8, -8)]},
    "room_with_corner": {"close": [(9, 7), (7, 9)]},
}


def measure(problem: ExplorationProblem, name: str, strategy: str) -> list[dict[str, object]]:
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    metrics = run_exploration(problem, make_strategy(strategy), name=strategy).metrics
    found: list[FinishBounds] = []
    walls: list[tuple[float, float]] = []
    plans: list[Sequence[int]] = []  # observable cells seen after each step
    for share in SHARES:
        start = perf_counter()
        found.append(lower_bounds(problem, observable, share / 100))
        middle = perf_counter()
        run = known_map_run(problem, share / 100)
        walls.append((middle - start, perf_counter() - middle))
        plans += [run.covered] if run is not None else []
    rows: list[dict[str, object]] = []
    for share, bounds, wall in zip(SHARES, found, walls, strict=True):
        # A plan for one share may also be the best for another.
        steps = [
            next(step for step, seen in enumerate(covered) if seen >= bounds.needed)
            for covered in plans
            if covered[-1] >= bounds.needed
        ]
        upper = time_of(problem, min(steps)) if steps else None
        reached = getattr(metrics, f"t{share}_s")
        assert upper is None or upper >= bounds.lower_s, "a run beat the bound"
        assert reached is None or reached >= bounds.lower_s, "a run beat the bound"
        rows.append(
            {
                "map": name,
                "robots": len(problem.robots),
                "share": share,
                "swath": bounds.swath_s,
                "eccentricity": bounds.eccentricity_s,
                "witness": bounds.witness_s,
                "lower": bounds.lower_s,
                "upper": upper,
                "run": reached,
                "from": None if reached is None or upper is None else reached / upper,
                "to": None if reached is None else reached / bounds.lower_s,
                "lower wall s": wall[0],
                "upper wall s": wall[1],
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
    parser.add_argument("--fine", action="store_true")
    parser.add_argument("--strategy", default="nearest")
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    size = {"cell_m": 0.1, "radius_m": 0.035} if options.fine else {}
    print("| " + " | ".join(COLUMNS) + " |\n|" + "---|" * len(COLUMNS))
    rows: list[dict[str, object]] = []
    for name in ("office", "cave", "maze"):
        grid = conav.builtin_map(name, width_m=25.0, height_m=25.0, resolution=0.1)
        for robots in (2, 4):
            problem, _ = exploration_problem(grid, robots=robots, seed=options.seed, **size)
            rows += measure(problem, name, options.strategy)
    data = os.environ.get("CONAV_DATA")
    if data:
        with tempfile.TemporaryDirectory() as folder:
            for name, teams in EXPLORE_BENCH.items():
                path = mended(Path(data) / "maps/explore_bench" / f"{name}.yaml", Path(folder))
                problem, _ = exploration_problem(path, robots=2, **size)
                for team, points in teams.items():
                    given = starting_at(problem, points)
                    rows += measure(given, f"{name} {team}", options.strategy)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
