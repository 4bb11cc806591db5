"""Large teams on one office floor: what planning costs, what verification costs, and how both grow.

Plans `office-delivery` for each number of robots on the same floor, writes the run and verifies it.
Times are processor seconds of this process, its kernels compiled before. Prints a table; `--png`
draws how an iteration of the game grows with the number of robots. Run it with the largest team
alone for that team's peak memory.
"""

import argparse
import resource
import tempfile
from itertools import pairwise
from pathlib import Path
from statistics import median
from time import process_time
from typing import NamedTuple

import numpy as np

from conav.pictures.plots import Series, save_points
from conav.planning.catalogue import make_solver, settings_of
from conav.planning.load_scene import load_scene
from conav.planning.recorder import PlanRecorder
from conav.planning.verify import verify_plan
from conav.runs.reader import read_plan

COLUMNS = (
    "robots", "seed", "m2 a robot", "first plan s", "iteration ms", "checks", "responses",
    "plan s", "sum of costs", "status", "epsilon", "verify s", "verdict", "MiB so far",
)  # fmt: skip


class Measured(NamedTuple):
    """One plan."""

    robots: int
    seed: int
    area_m2: float  # free, for each robot
    first_s: float  # until all had a path
    iteration_ms: float  # median of those after that
    checks: float  # edges and rests tested against others, mean over all iterations
    responses: float  # asked for, mean over all iterations
    plan_s: float
    total: float
    status: str
    epsilon: float
    verify_s: float
    verdict: str
    peak_mib: int  # of this process so far


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, nargs="+", default=[4, 8, 16, 32, 64])
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--office", type=int, help="the floor's seed; else each scene has its own")
    parser.add_argument("--png", type=Path)
    options = parser.parse_args()
    measure(2, 0, 0, samples=400)  # compiles the kernels
    print(" | ".join(COLUMNS), flush=True)
    rows: list[Measured] = []
    for robots in options.robots:
        for seed in options.seeds:
            rows.append(measure(robots, seed, options.office))
            print(" | ".join(map(shown, rows[-1])), flush=True)
    if options.png is not None:
        draw(rows, options.png)


def shown(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def measure(robots: int, seed: int, office: int | None, **settings: object) -> Measured:
    floor = "" if office is None else f",office={office}"
    problem = load_scene(f"office-delivery:{robots}{floor}", seed=seed)
    solver = make_solver("inash", settings)
    times: list[tuple[str, float, bool]] = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        begun = process_time()

        def look(progress) -> None:
            whole = bool(np.isfinite(progress.costs).all())
            times.append((progress.stage, process_time() - begun, whole))

        result = solver.solve(problem, seed, look)
        plan_s = process_time() - begun
        with PlanRecorder(
            path, problem, solver="inash", settings=settings_of(solver), seed=seed
        ) as recorder:
            recorder.finish(result, compute_s=0.0)
        begun = process_time()
        report = verify_plan(read_plan(path))
        verify_s = process_time() - begun
    whole = [time for _, time, complete in times if complete]
    games = [
        after - before
        for (_, before, complete), (stage, after, _) in pairwise(times)
        if complete and stage == "game"
    ]
    iterations = result.counters["iterations"]
    return Measured(
        robots, seed, problem.floor.area / robots,
        whole[0] if whole else float("nan"),
        1000.0 * median(games) if games else float("nan"),
        result.counters["collision_checks"] / iterations,
        result.counters["responses"] / iterations,
        plan_s, float(result.costs.sum()), str(result.status),
        float(result.epsilon.max()) if result.epsilon is not None else float("nan"),
        verify_s, report.verdict, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
    )  # fmt: skip


def draw(rows: list[Measured], path: Path) -> None:
    teams = sorted({row.robots for row in rows})

    def series(label: str, field: str) -> Series:
        values = [[getattr(row, field) for row in rows if row.robots == team] for team in teams]
        middle = [float(np.nanmedian(one)) for one in values]
        return Series(
            label, teams, middle, [min(one) for one in values], [max(one) for one in values]
        )

    save_points(
        path,
        [
            series("checks against others", "checks"),
            series("responses", "responses"),
            series("time of one [ms]", "iteration_ms"),
        ],
        xlabel="robots on the floor",
        ylabel="in an iteration",
        title="An iteration on one office floor",
        note="Points: medians over scenes; bars: lowest to highest. Counts are means over all "
        "iterations of a plan, times medians of those after all robots had a path.",
        log_x=True,
        log_y=True,
        connect=True,
    )


if __name__ == "__main__":
    main()
