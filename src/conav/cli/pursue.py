"""`conav pursue`."""

import json as json_module
import sys
import tempfile
from pathlib import Path
from time import monotonic, perf_counter
from typing import Annotated, Any

from cyclopts import Parameter

from conav.cli.progress import EVERY_S, PATIENCE_S
from conav.cli.settings import parse_settings
from conav.errors import InputError


def pursue(
    floor_plan: str,
    /,
    *,
    method: str = "known-map",
    labels: str = "shadows",
    pursuers: str = "auto",
    start: str | None = None,
    speed: float = 1.0,
    unknown: Annotated[bool, Parameter(negative="")] = False,
    edb: str | None = None,
    reach: float | None = None,
    fault: Annotated[list[str] | None, Parameter(negative="")] = None,
    set: Annotated[list[str] | None, Parameter(negative="")] = None,
    evader: str | None = None,
    evader_speed: float | None = None,
    evaders: int | None = None,
    seed: int | None = None,
    resolution: float | None = None,
    out: Path | None = None,
    png: Path | None = None,
    after: int | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Clear a floor so that nobody hidden on it can slip away, however fast.

    The verifier then decides, with code of its own, whether somebody could have.

    Parameters
    ----------
    floor_plan
        A floor plan or grid map, or a made one's name: rooms:3, office; conav maps lists those.
    method
        How: known-map; splitting, by guards until one pursuer suffices for each part; delegation,
        where pursuers who are stuck ask others for help; spanning-trees, on the graph of triangles.
    labels
        What is called clear or contaminated: shadows, or critical vertices as in the paper, whose
        claims may be wrong.
    pursuers
        How many, or auto: as few as are found to suffice.
    start
        Where they start, as x,y [m]. Default: in the middle of a piece of the floor.
    speed
        Top speed of a pursuer [m/s].
    unknown
        The pursuers know nothing of the floor but what they have seen; the method is unknown-map.
    edb
        With --unknown: how many vertices are explored between two pursuits, or unlimited: explore
        everything, then clear.
    reach
        How far each can drive in all [m]; delegation only. Default: no limit.
    fault
        Who is lost when, as pursuer_2:dies:30; may be repeated; delegation only.
    set
        A setting of the method, name=value; may be repeated.
    evader
        random: tell also when evaders that walk at random are seen on average.
    evader_speed
        With --evader: how fast they walk [m/s]. Default: 1.
    evaders
        With --evader: how many are simulated, one at a time. Default: 200.
    seed
        With --evader: of their ways. Default: 0.
    resolution
        Metres per pixel, for a bare picture.
    out
        Write the run to this .mcap file (read by conav verify and by ROS 2 tools).
    png
        Draw the floor, the pursuers' ways and what is contaminated to this file.
    after
        With --png: draw the state after so many drives. Default: the end.
    json
        Print one JSON object instead of the summary.
    quiet
        Print nothing but errors.
    """
    size = _size(pursuers)
    if not 0.0 < speed < float("inf"):
        raise InputError(f"speed {speed:g}", "is no speed", "give metres per second above 0")
    if reach is not None and not 0.0 < reach < float("inf"):
        raise InputError(f"reach {reach:g}", "is no length", "give metres above 0")
    for path, suffix in ((out, ".mcap"), (png, ".png")):
        if path is not None and path.suffix.lower() != suffix:
            raise InputError(path, f"is no {suffix} file name", f"end it in {suffix}")
        if path is not None and not path.parent.is_dir():
            raise InputError(path, "lies in a folder that does not exist", "make the folder first")
    settings = dict(parse_settings(set or []))
    unknown = unknown or method == "unknown-map"
    if unknown and method not in ("known-map", "unknown-map"):
        raise InputError(f"method {method!r}", "is for known floors", "leave out --unknown")
    if edb is not None and not unknown:
        raise InputError(f"edb {edb!r}", "is for floors that are not known", "add --unknown")
    if edb is not None:
        settings["edb"] = edb
    if after is not None and png is None:
        raise InputError(f"after {after}", "is for pictures", "add --png")
    method = "unknown-map" if unknown else method
    crowd = _crowd(evader, evader_speed, evaders, seed)

    from conav.compiled import compiled_before
    from conav.maps.load_floor_plan import load_floor_plan
    from conav.maps.read_floor_plan import FloorPlanReading
    from conav.pursuit.catalogue import make_method, settings_of
    from conav.pursuit.recorder import record_pursuit
    from conav.pursuit.starts import default_start
    from conav.pursuit.team import LARGEST
    from conav.pursuit.types import Pursuer, PursuitProblem
    from conav.pursuit.verify import verify_schedule
    from conav.robots.fault import parse_fault

    chosen = make_method(method, labels, settings)
    floor = load_floor_plan(floor_plan, FloorPlanReading(resolution=resolution))
    for warning in floor.warnings if not quiet else ():
        print(f"conav: warning: {warning}", file=sys.stderr)
    at = default_start(floor) if start is None else _point(start)
    names = [f"pursuer_{number}" for number in range(1, LARGEST + 1)]
    team = tuple(Pursuer(name, at, speed, reach_m=reach) for name in names[: size or 1])
    faults = tuple(parse_fault(text, names) for text in fault or [])
    try:
        problem = PursuitProblem(
            floor, team, known=not unknown, most=size, name=floor.name, faults=faults
        )
    except ValueError as error:
        raise InputError("fault", f"is of {error}", "write pursuer_2:dies:30") from None
    if not quiet and not compiled_before():
        print(
            "conav: compiling the kernels; this happens once and takes up to a minute",
            file=sys.stderr,
        )
    begun = perf_counter()
    with _Progress(shown=not quiet) as progress:
        result = chosen.solve(problem, progress.step)
    compute_s = perf_counter() - begun
    found = None
    if result.status == "done":
        found = verify_schedule(floor, result.schedule, (None,) * len(result.pursuers))
    seen = None
    if crowd is not None and result.status == "done":
        seen = _seen(floor, result.schedule, *crowd)
    with tempfile.TemporaryDirectory() as folder:
        run = out if out is not None else Path(folder) / "pursuit.mcap"
        if out is not None or png is not None:
            record_pursuit(
                run,
                problem,
                result,
                method=method,
                settings={"labels": labels, **settings_of(chosen)},
                seed=0,
                compute_s=compute_s,
            )
        if png is not None:
            from conav.pictures.pursuit_still import save_pursuit_still
            from conav.runs.reader import read_run
            from conav.runs.types import PursuitRun

            read = read_run(run)
            assert isinstance(read, PursuitRun)
            escape = None if found is None else found.escape
            save_pursuit_still(read, png, escape, after=after)
    schedule = result.schedule
    summary: dict[str, Any] = {
        "job": "pursue",
        "floorplan": floor.name,
        "method": method,
        "labels": labels,
        "status": str(result.status),
        "reason": result.reason,
        "claim": "captured" if result.status == "done" else None,
        "pursuers": len(result.pursuers),
        "lower_bound": result.lower_bound,
        "minimal_proved": result.minimal_proved,
        "verdict": None if found is None else str(found.verdict),
        "moves": result.counters.get("moves", 0),
        "distance_m": round(schedule.distance_m, 6),
        "time_s": round(float(schedule.times[-1]), 6),
        "known": not unknown,
        "explored": result.explored,
        "recontaminations": result.recontaminations,
        "counters": dict(result.counters),
        "evader": seen,
        "compute_s": round(compute_s, 3),
        "run": None if out is None else str(out),
    }
    if json:
        print(json_module.dumps(summary, allow_nan=False))
    elif not quiet:
        _print_summary(summary, png)
    return 0 if found is not None and found.verdict == "captured" else 1


def _size(text: str) -> int | None:
    """How many pursuers; None for auto."""
    if text == "auto":
        return None
    try:
        size = int(text)
    except ValueError:
        size = 0
    if not 1 <= size <= 60:
        raise InputError(f"pursuers {text!r}", "is no team size", "give auto, or 1 to 60")
    return size


def _crowd(
    evader: str | None, speed: float | None, evaders: int | None, seed: int | None
) -> tuple[float, int, int] | None:
    """Speed [m/s], number and seed of random evaders; None without."""
    if evader is None:
        for name, value in (("evader-speed", speed), ("evaders", evaders), ("seed", seed)):
            if value is not None:
                raise InputError(f"{name} {value}", "is for evaders", "add --evader random")
        return None
    if evader != "random":
        raise InputError(f"evader {evader!r}", "is not known", "there is: random")
    speed = 1.0 if speed is None else speed
    evaders = 200 if evaders is None else evaders
    seed = 0 if seed is None else seed
    if not 0.0 <= speed < float("inf"):
        raise InputError(f"evader-speed {speed:g}", "is no speed", "give 0 m/s or more")
    if evaders < 1:
        raise InputError(f"evaders {evaders}", "are none", "give 1 or more")
    if seed < 0:
        raise InputError(f"seed {seed}", "is negative", "give 0 or more")
    return speed, evaders, seed


def _seen(floor: Any, schedule: Any, speed: float, evaders: int, seed: int) -> dict[str, Any]:
    from conav.pursuit.random_evaders import random_evader_capture_times

    ranges = (None,) * schedule.positions.shape[1]
    found = random_evader_capture_times(
        floor, schedule, ranges, speed_mps=speed, evaders=evaders, seed=seed
    )
    mean, error = found.mean_s, found.standard_error_s
    return {
        "model": "random",
        "speed_mps": speed,
        "evaders": evaders,
        "seed": seed,
        "caught": found.caught,
        "mean_s": None if mean is None else round(mean, 6),
        "standard_error_s": None if error is None else round(error, 6),
    }


def _point(text: str) -> tuple[float, float]:
    parts = text.split(",")
    try:
        x, y = (float(part) for part in parts)
    except ValueError:
        raise InputError(f"start {text!r}", "is no place", "give x,y in metres") from None
    return x, y


def _print_summary(summary: dict[str, Any], png: Path | None) -> None:
    count = summary["pursuers"]
    team = f"{count} pursuer{'' if count == 1 else 's'}"
    if summary["verdict"] is None:
        print(f"{summary['floorplan']}: {summary['status']}: {summary['reason']}")
    else:
        words = {
            "captured": "nobody can slip away (verified)",
            "escapes": "an evader can slip away, the verifier found",
            "unknown": "the verifier could not decide",
        }
        claim = "claimed captured; " if summary["verdict"] != "captured" else ""
        print(f"{summary['floorplan']}: {team}: {claim}{words[summary['verdict']]}")
        print(
            f"  {summary['moves']} moves, {summary['distance_m']:.1f} m driven in "
            f"{summary['time_s']:.1f} s, found in {summary['compute_s']:.1f} s"
        )
        if summary["explored"] is not None:
            print(
                f"  {100 * summary['explored']:.4g}% explored, contaminated again after "
                f"{summary['recontaminations']} drives"
            )
        seen = summary["evader"]
        if seen is not None:
            when = "" if seen["mean_s"] is None else f", after {seen['mean_s']:.1f} s on average"
            print(
                f"  {seen['caught']} of {seen['evaders']} random evaders at "
                f"{seen['speed_mps']:g} m/s seen{when}"
            )
        counters = summary["counters"]
        if "messages" in counters:
            print(
                f"  {counters['deliberations']} calls for help, {counters['messages']} messages, "
                f"{counters['lost']} lost"
            )
        if summary["minimal_proved"]:
            print("  no smaller team can do it")
        elif summary["verdict"] == "captured":
            print(f"  whether fewer than {count} can is not proved")
    for what, path in (("run file", summary["run"]), ("picture", png)):
        if path is not None:
            print(f"  {what}: {path}")


class _Progress:
    """A line on standard error, only on a terminal and only when the search takes a while."""

    def __init__(self, *, shown: bool) -> None:
        self._shown = shown and sys.stderr.isatty()
        self._status: Any = None
        self._next = monotonic() + PATIENCE_S

    def __enter__(self) -> "_Progress":
        return self

    def __exit__(self, *_: object) -> None:
        if self._status is not None:
            self._status.stop()

    def step(self, size: int, expanded: int) -> bool:
        """Show how far the search is."""
        now = monotonic()
        if self._shown and now >= self._next:
            self._next = now + EVERY_S
            if self._status is None:
                from rich.console import Console

                self._status = Console(stderr=True).status("")
                self._status.start()
            word = "pursuer" if size == 1 else "pursuers"
            self._status.update(f"{size} {word}: {expanded} states looked at")
        return True
