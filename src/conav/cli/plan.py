"""`conav plan`."""

import json as json_module
import sys
from contextlib import ExitStack
from math import isfinite
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

from cyclopts import Parameter

from conav.cli.numbers import Whole
from conav.cli.settings import parse_settings
from conav.errors import InputError

SHOWN = 16  # robots that have a line in the summary


def plan(
    scene: str,
    /,
    *,
    solver: str = "inash",
    set: Annotated[list[str] | None, Parameter(negative="")] = None,
    samples: Whole | None = None,
    time: float | None = None,
    seed: Whole = 0,
    robots: Whole | None = None,
    out: Path | None = None,
    png: Path | None = None,
    gif: Path | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Plan the motions of robots with tasks of their own, so that no two collide.

    Ctrl-C ends it with the best plan so far.

    Parameters
    ----------
    scene
        A scene file (TOML, JSON, db-CBS yaml, CG:SHOP 2021 json, MovingAI .scen), or a made scene's
        name with settings if you like: antipodal-circle:12; conav scenes lists those.
    solver
        The planning method: inash (nobody can do better alone), inash-restarts, prioritized,
        anytime-prioritized, social-optimum, coupled (for scenes that couple robots).
    set
        A setting of the solver, name=value; may be repeated.
    samples
        Samples each robot draws; the same seed then gives the same plan on every machine.
    time
        Seconds the solver may take, once its kernels are loaded. Without --samples nothing else
        ends it.
    seed
        Seed of everything random: the solver, and a made scene whose name says none.
    robots
        How many robots: of a made scene, or the first ones of a file.
    out
        Write the run to this .mcap file (read by conav verify and by ROS 2 tools).
    png
        Write a picture of the plan.
    gif
        Write an animated picture of the plan.
    json
        Print one JSON object instead of the summary.
    quiet
        Print nothing but errors.
    """
    settings: dict[str, object] = dict(parse_settings(set or []))
    for name, value in (("samples", samples), ("time_s", time)):
        if value is not None and name in settings:
            raise InputError(f"--set {name}", "is given by its own option too", "give one of them")
        if value is not None:
            settings[name] = value
    if time is not None and samples is None:
        settings.setdefault("samples", None)
    for path, suffix in ((out, ".mcap"), (png, ".png"), (gif, ".gif")):
        if path is not None and path.suffix.lower() != suffix:
            raise InputError(path, f"is no {suffix} file name", f"end it in {suffix}")
        if path is not None and not path.parent.is_dir():
            raise InputError(path, "lies in a folder that does not exist", "make the folder first")

    from conav.cli.interrupts import EndAfterStep
    from conav.cli.plan_progress import PlanProgress
    from conav.compiled import compiled_before
    from conav.planning.catalogue import make_solver, settings_of
    from conav.planning.load_scene import load_scene
    from conav.planning.plan_summary import plan_summary
    from conav.planning.recorder import PlanRecorder
    from conav.planning.warm_up import warm_up

    chosen = make_solver(solver, settings)
    problem = load_scene(scene, robots=robots, seed=seed)
    if not quiet and not compiled_before():
        print(
            "conav: compiling the kernels; this happens once and takes up to a minute",
            file=sys.stderr,
        )
    if settings.get("time_s") is not None:
        warm_up(solver, problem)
    first: list[float] = []
    with ExitStack() as stack:
        recorder = None
        if out is not None:
            recorder = stack.enter_context(
                PlanRecorder(out, problem, solver=solver, settings=settings_of(chosen), seed=seed)
            )
        progress = stack.enter_context(PlanProgress(problem, shown=not quiet))
        interrupts = stack.enter_context(EndAfterStep())
        started = perf_counter()

        def on_progress(state: Any) -> bool:
            if not first and all(map(isfinite, state.costs[:, 0].tolist())):
                first.append(perf_counter() - started)
            progress.step(state)
            if recorder is not None:
                recorder.follow(state)
            return not interrupts.asked()

        result = chosen.solve(problem, seed, on_progress)
        compute_s = perf_counter() - started
        interrupted = interrupts.asked()
        summary = plan_summary(
            problem,
            result,
            solver=solver,
            seed=seed,
            compute_s=compute_s,
            first_solution_compute_s=first[0] if first else None,
            interrupted=interrupted,
        )
        if recorder is not None:
            recorder.finish(result, compute_s=compute_s, interrupted=interrupted)
            summary["run"] = str(out)
    for warning in problem.floor.warnings if not quiet else ():
        print(f"conav: warning: {warning}", file=sys.stderr)
    drawn = _draw(problem, result, summary, png, gif)
    if json:
        print(json_module.dumps(summary, allow_nan=False))
    elif not quiet:
        _print_summary(problem, summary, [("run file", out), *drawn])
    return 0 if summary["status"] == "done" else 1


def _draw(
    problem: Any, result: Any, summary: dict[str, Any], png: Path | None, gif: Path | None
) -> list[tuple[str, Path]]:
    """The pictures that were drawn: what each is, and where."""
    words = f"{summary['solver']} · {summary['status'].replace('_', ' ')}"
    if summary["sum_cost"] is not None:
        words += f" · sum of costs {summary['sum_cost']:.4g} {_unit(problem)}"
    drawn: list[tuple[str, Path]] = []
    if png is not None:
        from conav.pictures.plan_picture import save_plan_picture

        save_plan_picture(problem, png, result.trajectories, words=words)
        drawn.append(("picture", png))
    if gif is not None and any(item is not None for item in result.trajectories):
        from conav.pictures.plan_animation import save_plan_animation

        save_plan_animation(problem, gif, result.trajectories, words=words)
        drawn.append(("animation", gif))
    elif gif is not None:
        print("conav: warning: nobody has a path, so there is no animation", file=sys.stderr)
    return drawn


def _unit(problem: Any) -> str:
    return "m" if problem.costs[0] == "length" else "s"


def _print_summary(
    problem: Any, summary: dict[str, Any], files: list[tuple[str, Path | None]]
) -> None:
    robots, unit = summary["robots"], _unit(problem)
    team = f"{len(robots)} robots" if len(robots) > 1 else "1 robot"
    print(f"{summary['scene']}: {team}, {summary['solver']}, seed {summary['seed']}")
    how = "interrupted" if summary["interrupted"] else summary["status"].replace("_", " ")
    print(f"  {how}" + (f": {summary['reason']}" if summary["reason"] else ""))
    if summary["sum_cost"] is not None:
        text = f"  sum of costs {summary['sum_cost']:.4g} {unit}"
        if summary["ratio"] is not None:
            text += (
                f", {summary['ratio']:.4g} times a lower bound on any plan's, "
                f"{summary['lower_bound']:.4g} {unit}"
            )
        print(text)
    if summary["status"] == "done" and all(robot["epsilon"] == 0.0 for robot in robots):
        print("  an equilibrium: on its graph no robot can do better alone")
    driving = [robot for robot in robots if robot["arrival_s"] is not None]
    for robot in driving[:SHOWN]:
        alone = f", alone {robot['solo_m']:.4g} {unit}" if robot["solo_m"] is not None else ""
        print(
            f"  {robot['name']}: {robot['length_m']:.4g} m, arrives at "
            f"{robot['arrival_s']:.4g} s{alone}"
        )
    if len(driving) > SHOWN:
        print(f"  and {len(driving) - SHOWN} more robots")
    missing = [robot["name"] for robot in robots if robot["arrival_s"] is None]
    if missing:
        more = f" and {len(missing) - SHOWN} more" if len(missing) > SHOWN else ""
        print(
            f"  no path: {', '.join(missing[:SHOWN])}{more}" if driving else "  nobody has a path"
        )
    clearance = summary["min_clearance_m"]
    least = f"{clearance:.3g} m between robots at least; " if clearance is not None else ""
    first = summary["first_solution_compute_s"]
    print(
        f"  {least}{summary['vertices']} vertices, {summary['iterations']} iterations, "
        f"{summary['messages']} messages"
    )
    print(
        f"  computed in {summary['compute_s']:.3g} s"
        + (f", the first plan in {first:.3g} s" if first is not None else "")
    )
    for what, path in files:
        if path is not None:
            print(f"  {what}: {path}")
