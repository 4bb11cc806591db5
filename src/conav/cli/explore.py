"""`conav explore`."""

import json as json_module
import sys
from math import ceil, floor, inf
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from conav.cli.numbers import Whole
from conav.cli.settings import parse_settings
from conav.errors import InputError


def explore(
    map: str,
    /,
    *,
    robots: Whole = 3,
    strategy: str = "lanes-and-pockets",  # the catalogue's default, which costs an import of numpy
    set: Annotated[list[str] | None, Parameter(negative="")] = None,
    range: float = 7.0,
    cell: float | None = None,
    radius: float = 0.1,
    speed: float = 0.5,
    resolution: float | None = None,
    motion: str = "8-connected",
    sensor: str = "range",
    radio: str | None = None,
    loss: float = 0.0,
    delay: float = 0.0,
    energy: float | None = None,
    fault: Annotated[list[str] | None, Parameter(negative="")] = None,
    traffic: str = "pibt",
    starts: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    outside: Annotated[bool, Parameter(negative="")] = False,
    outside_folder: Annotated[bool, Parameter(negative="")] = False,
    seed: Whole = 0,
    max_time: float = 36_000.0,
    bounds: str = "quick",
    out: Path | None = None,
    png: Path | None = None,
    gif: Path | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Let a team of robots explore a map none of them knows.

    Parameters
    ----------
    map
        A map file (ROS map_server yaml, picture, MovingAI .map, ASCII .txt) or a built-in map's
        name; conav maps lists those.
    robots
        How many robots.
    strategy
        The exploration strategy.
    set
        A setting of the strategy, name=value; may be repeated.
    range
        Sensor range [m].
    cell
        Side of a planning cell [m]; robots stand at its centre. Default: the smallest multiple of
        the map's resolution in which robots pass each other round a corner.
    radius
        Radius of a robot [m].
    speed
        Top speed of a robot [m/s].
    resolution
        Metres per pixel: needed for a bare picture, optional for other maps without a scale.
    motion
        4-connected, 8-connected or forward-turn (a turn costs a step).
    sensor
        range (360 degrees, walls block sight) or disc (sees through walls).
    radio
        perfect, off, a range [m] within which robots hear each other, or path-loss (distance and
        walls weaken the signal). Default: perfect, unless the strategy is made for another one.
    loss
        Probability with which each message is lost, 0 to 0.99.
    delay
        How long a message takes [s].
    energy
        What is in each robot's battery [J]; a robot spends 10 J a second and 20 J a metre, and is
        dead when nothing is left. Default: no limit.
    fault
        What happens to a robot, and when [s]: robot_1:dies:100, robot_2:stalls:50:200,
        robot_0:stalls:50 (for ever), robot_3:joins:300; may be repeated.
    traffic
        pibt (one rule keeps robots apart) or none (they pass through each other, as in papers
        without such a rule).
    starts
        Where robots start, metres in the map frame: "x,y x,y ...". Default: together at a random
        place.
    outside
        Start in the largest free part even when it looks like the outside of a building.
    outside_folder
        Let a map's yaml name a picture outside its own folder.
    seed
        Seed of everything random: starts, strategies and the layout of a built-in map.
    max_time
        Simulated time after which the run ends [s].
    bounds
        How hard to look for bounds on the best possible time, which the run is compared with:
        quick, full or none.
    out
        Write the run to this .mcap file (read by conav verify and by ROS 2 tools).
    png
        Write a picture of the end of the run.
    gif
        Write an animated picture of the run.
    json
        Print one JSON object instead of the summary.
    quiet
        Print nothing but errors.
    """
    settings = parse_settings(set or [])
    for path, suffix in ((png, ".png"), (gif, ".gif")):
        if path is not None and path.suffix.lower() != suffix:
            raise InputError(path, f"is no {suffix} file name", f"end it in {suffix}")
        if path is not None and not path.parent.is_dir():
            raise InputError(path, "lies in a folder that does not exist", "make the folder first")
    points = None if starts is None else parse_points("--starts", starts)

    import tempfile

    from conav.cli.interrupts import EndAfterStep
    from conav.cli.progress import ExplorationProgress
    from conav.compiled import compiled_before
    from conav.simulation.explore import explore as run
    from conav.simulation.finish_bounds import check_effort

    check_effort(bounds)
    if not quiet and not compiled_before():
        print(
            "conav: compiling the kernels; this happens once and takes up to a minute",
            file=sys.stderr,
        )
    with tempfile.TemporaryDirectory(prefix="conav-") as folder:
        # Pictures are drawn from the run file; without --out it is a temporary one.
        target = out
        if target is None and (png is not None or gif is not None):
            target = Path(folder) / "run.mcap"
        with ExplorationProgress(shown=not quiet) as progress, EndAfterStep() as interrupts:

            def after_step(state: Any) -> None:
                progress.step(state)
                interrupts.step()

            done = run(
                map,
                strategy=strategy,
                settings=settings,
                out=target,
                progress=after_step,
                robots=robots,
                range_m=range,
                cell_m=cell,
                radius_m=radius,
                speed_mps=speed,
                resolution=resolution,
                motion=motion,
                sensor=sensor,
                traffic=traffic,
                starts=points,
                outside=outside,
                outside_folder=outside_folder,
                seed=seed,
                max_time_s=max_time,
                radio=radio,
                loss=loss,
                delay_s=delay,
                energy_j=energy,
                faults=fault or (),
            )
        for warning in done.warnings if not quiet else ():
            print(f"conav: warning: {warning}", file=sys.stderr)
        if target is not None and (png is not None or gif is not None):
            _draw(target, png, gif)
    found = _bounds(done, bounds) if json or not quiet else None
    if json:
        summary = done.summary(found)
        summary["run"] = str(out) if out is not None else None
        _print_json(summary)
    elif not quiet:
        _print_summary(done, found, out, png, gif)
    return 0 if done.status == "done" else 1


def parse_points(place: str, text: str) -> list[tuple[float, float]]:
    """The points of "x,y x,y ..."; points may also be parted by semicolons.

    >>> parse_points("--starts", "1,2 3.5,-4")
    [(1.0, 2.0), (3.5, -4.0)]
    """
    points: list[tuple[float, float]] = []
    for part in text.replace(";", " ").split():
        numbers = part.split(",")
        try:
            x, y = (float(number) for number in numbers)
        except ValueError:
            raise InputError(
                place, f"{part!r} is not x,y", 'write metres as "x,y x,y", for example "1,2 1.5,2"'
            ) from None
        points.append((x, y))
    return points


def _draw(run_file: Path, png: Path | None, gif: Path | None) -> None:
    from conav.pictures.animation import save_animation
    from conav.pictures.still import save_still
    from conav.runs.reader import read_exploration

    run = read_exploration(run_file)
    if png is not None:
        save_still(run, png)
    if gif is not None:
        save_animation(run, gif)


def _bounds(done: Any, effort: str) -> Any:
    """Bounds on the best possible time; none for a run that was interrupted, nor after Ctrl-C."""
    if effort == "none" or done.result.interrupted:
        return None
    try:
        return done.bounds(effort)
    except KeyboardInterrupt:
        return None


def ratio_text(done: Any, bounds: Any) -> str:
    """How the time to see all compares with the best possible one."""
    low, high = done.ratios(bounds)
    least = f"no team takes less than {bounds.lower_s:.4g} s"
    known = "nothing faster is known"
    if bounds.upper_by == "known-map":
        known = f"one that knows the map took {bounds.upper_s:.4g} s"
    elif bounds.upper_by is None:
        known = "no run that saw all is known"
    # Both ends are rounded outwards.
    below, above = f"{floor(100 * low) / 100:g}", high if high == inf else ceil(100 * high) / 100
    if high == 1.0:
        return f"the best possible time: {least}"
    if above == inf and low == 1.0:
        return f"{least} to see all, {known}"
    if above == inf:
        return f"at least {below} times the best possible time: {least}, {known}"
    return f"{below} to {above:g} times the best possible time: {least}, {known}"


def _print_json(content: dict[str, Any]) -> None:
    print(json_module.dumps(content, allow_nan=False))


def _print_summary(
    done: Any, bounds: Any, out: Path | None, png: Path | None, gif: Path | None
) -> None:
    summary = done.summary()
    metrics = done.metrics
    grid = done.problem.plan.grid
    team = f"{summary['robots']} robots" if summary["robots"] > 1 else "1 robot"
    print(
        f"{grid.name}, {grid.width_m:g} x {grid.height_m:g} m: {team}, {done.strategy}, "
        f"seed {summary['seed']}"
    )
    area = done.result.observable * grid.resolution**2
    how = "interrupted" if done.result.interrupted else summary["status"].replace("_", " ")
    print(
        f"  {how}: {100 * metrics.coverage:.4g} % of {area:.4g} m2 seen in {metrics.time_s:.4g} s "
        f"({metrics.steps} steps of {done.problem.step_s:.3g} s)"
    )
    times = ((90, metrics.t90_s), (95, metrics.t95_s), (99, metrics.t99_s), (100, metrics.t100_s))
    reached = [f"{share} % after {time:.4g} s" for share, time in times if time is not None]
    print("  " + (", ".join(reached) if reached else "90 % not reached"))
    if bounds is not None:
        print("  " + ratio_text(done, bounds[100]))
    lengths = ", ".join(f"{length:.4g}" for length in metrics.path_m[:8])
    more = f" and {len(metrics.path_m) - 8} more" if len(metrics.path_m) > 8 else ""
    print(f"  paths {lengths}{more} m; overlap {metrics.overlap:.3g}")
    print(
        f"  {metrics.messages} messages, {metrics.bytes / 1e3:.4g} kB; "
        f"{done.result.decision_ms['mean']:.2g} ms a decision; "
        f"computed in {done.result.compute_s:.3g} s"
    )
    events = [
        f"{event['robot']} {event['event']} at {event['time_s']:.4g} s"
        for event in summary["robot_events"]
    ]
    if events:
        more = f" and {len(events) - 8} more" if len(events) > 8 else ""
        print("  " + ", ".join(events[:8]) + more)
    for what, path in (("run file", out), ("picture", png), ("animation", gif)):
        if path is not None:
            print(f"  {what}: {path}")
