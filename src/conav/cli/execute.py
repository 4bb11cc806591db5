"""`conav execute`."""

import json as json_module
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

from cyclopts import Parameter

from conav.cli.numbers import Whole
from conav.errors import InputError

SHOWN = 5  # touches of a kind that are told


def execute(
    run: Path,
    /,
    *,
    tracking_error: float = 0.0,
    delay: float = 0.0,
    slack: float = 0.0,
    seed: Whole = 0,
    out: Path | None = None,
    png: Path | None = None,
    gif: Path | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Drive a plan with errors and late, and say whether anybody touched.

    The exit code is 1 when a robot overlapped another, a wall or an obstacle.

    Parameters
    ----------
    run
        A run file of conav plan.
    tracking_error
        How far a robot may be from where it should be [m].
    delay
        How late a robot may hear the plan, or its clock be [s].
    slack
        How much smaller the robots are than planned for [m].
    seed
        Seed of errors and delays.
    out
        Write what was driven to this .mcap file (read by conav verify and by ROS 2 tools).
    png
        Write a picture of what was driven.
    gif
        Write an animated picture of it.
    json
        Print one JSON object instead of the summary.
    quiet
        Print nothing but errors.
    """
    for path, suffix in ((out, ".mcap"), (png, ".png"), (gif, ".gif")):
        if path is not None and path.suffix.lower() != suffix:
            raise InputError(path, f"is no {suffix} file name", f"end it in {suffix}")
        if path is not None and not path.parent.is_dir():
            raise InputError(path, "lies in a folder that does not exist", "make the folder first")
    if out is not None and out.exists() and run.exists() and out.samefile(run):
        raise InputError(out, "is the plan itself", "name another --out")

    from conav.planning.recorded import recorded_problem, recorded_trajectories
    from conav.runs.reader import read_plan
    from conav.simulation.execution import execute as drive
    from conav.simulation.record_execution import execution_summary, record_execution

    plan = read_plan(run)
    problem, trajectories = recorded_problem(plan), recorded_trajectories(plan)
    if all(way is None for way in trajectories):
        raise InputError(run, "holds no trajectory", "give a plan in which somebody has one")
    started = perf_counter()
    driven = drive(
        problem,
        trajectories,
        tracking_error_m=tracking_error,
        delay_s=delay,
        slack_m=slack,
        seed=seed,
    )
    compute_s = perf_counter() - started
    summary = execution_summary(driven)
    if out is not None:
        record_execution(out, driven, plan_digest=plan.digest, compute_s=compute_s)
        summary["run"] = str(out)
    words = "touched" if driven.touched else "nobody touched"
    if png is not None:
        from conav.pictures.plan_picture import save_plan_picture

        save_plan_picture(driven.problem, png, driven.driven, words=words)
    if gif is not None:
        from conav.pictures.plan_animation import save_plan_animation

        save_plan_animation(driven.problem, gif, driven.driven, words=words)
    if json:
        print(json_module.dumps(summary, allow_nan=False))
    elif not quiet:
        _print_summary(summary, [("run file", out), ("picture", png), ("animation", gif)])
    return 1 if driven.touched else 0


def _print_summary(summary: dict[str, Any], files: list[tuple[str, Path | None]]) -> None:
    driving = [robot for robot in summary["robots"] if robot["lag_s"] is not None]
    team = f"{len(driving)} robots" if len(driving) != 1 else "1 robot"
    print(
        f"{summary['scene']}: {team}, errors up to {summary['tracking_error_m']:g} m, up to "
        f"{summary['delay_s']:g} s late, seed {summary['seed']}"
    )
    for touch in summary["touches"][:SHOWN]:
        a, b = touch["robots"]
        print(f"  {a} and {b} overlap by {touch['depth_m']:.3g} m at {touch['time_s']:.4g} s")
    for touch in summary["wall_touches"][:SHOWN]:
        print(f"  {touch['robot']} overlaps a wall or an obstacle by {touch['depth_m']:.3g} m")
    more = sum(max(len(summary[key]) - SHOWN, 0) for key in ("touches", "wall_touches"))
    if more:
        print(f"  and {more} more")
    if not summary["touched"]:
        print("  nobody touched another robot, a wall or an obstacle")
    clearance = summary["clearance_m"]
    least = f"{clearance:.3g} m between robots, " if clearance is not None else ""
    print(
        f"  at least {least}{summary['wall_clearance_m']:.3g} m from walls and obstacles; at most "
        f"{summary['deviation_m']:.3g} m off"
    )
    margin, safe = summary["margin_m"], summary["safe_margin_m"]
    rounding = 1e-12
    enough = (
        "so no two robots can touch" if margin >= safe - rounding
        else "so whether robots touch is chance"
    )  # fmt: skip
    print(f"  the plan keeps a margin of {margin:.3g} m, {safe:.3g} m is safe: {enough}")
    for what, path in files:
        if path is not None:
            print(f"  {what}: {path}")
