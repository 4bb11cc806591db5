"""Plans scenes from files, verifies the plans and prints a table: status, costs, processor time."""

import argparse
import tempfile
from pathlib import Path
from time import process_time

from conav.planning.catalogue import DEFAULT_SOLVER, make_solver, settings_of
from conav.planning.load_scene import load_scene
from conav.planning.recorder import PlanRecorder
from conav.planning.verify import verify_plan
from conav.runs.reader import read_plan


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--solver", default=DEFAULT_SOLVER)
    options = parser.parse_args()
    print("| scene | robots | status | sum of costs | lower bound | plan s | verify s | verdict |")
    print("|---|---|---|---|---|---|---|---|")
    for file in options.files:
        problem = load_scene(file)
        solver = make_solver(options.solver)
        with tempfile.TemporaryDirectory() as folder:
            run = Path(folder) / "run.mcap"
            begun = process_time()
            with PlanRecorder(
                run, problem, solver=options.solver, settings=settings_of(solver), seed=0
            ) as recorder:
                result = solver.solve(problem, 0, recorder.follow)
                taken = process_time() - begun
                recorder.finish(result, compute_s=taken)
            begun = process_time()
            report = verify_plan(read_plan(run))
            looked = process_time() - begun
        bound = f"{result.lower_bound:.2f}" if result.lower_bound is not None else "-"
        print(
            f"| {file.stem} | {len(problem.robots)} | {result.status} | {result.costs.sum():.2f} | "
            f"{bound} | {taken:.2f} | {looked:.2f} | {report.verdict} |",
            flush=True,
        )
        if result.reason:
            print("   ", result.reason)
        if report.verdict != "verified":
            print("\n".join(f"    {line}" for line in report.lines()))


if __name__ == "__main__":
    main()
