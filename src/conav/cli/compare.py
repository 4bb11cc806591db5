"""`conav compare`."""

import json as json_module
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Annotated, Any, TypeVar

from cyclopts import Parameter

from conav.cli.numbers import Whole
from conav.errors import InputError

T = TypeVar("T")

MAX_TABLES = 30
"""Groups whose tables are printed; a page that scrolls away helps nobody."""


def compare(
    *map: str,
    strategies: str,
    robots: str = "3",
    range: str = "7",
    radio: str | None = None,
    runs: Whole = 10,
    seed: Whole = 0,
    set: Annotated[list[str] | None, Parameter(negative="")] = None,
    motion: str = "8-connected",
    sensor: str = "range",
    loss: float = 0.0,
    delay: float = 0.0,
    energy: float | None = None,
    fault: Annotated[list[str] | None, Parameter(negative="")] = None,
    traffic: str = "pibt",
    cell: float | None = None,
    radius: float = 0.1,
    speed: float = 0.5,
    resolution: float | None = None,
    outside: Annotated[bool, Parameter(negative="")] = False,
    outside_folder: Annotated[bool, Parameter(negative="")] = False,
    max_time: float = 3600.0,
    out: Path = Path("comparison"),
    bounds: str = "quick",
    jobs: Whole | None = None,
    plots: bool = True,
    json: Annotated[bool, Parameter(negative="")] = False,
    quiet: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Compare strategies over maps, team sizes, sensor ranges, radios and seeds.

    All combinations are played. Runs are kept as they end: the same command goes on where it was
    stopped, and with more runs or strategies only those are played that are missing.

    Parameters
    ----------
    map
        Map files or built-in maps' names; conav maps lists those. Each seed is another layout of a
        built-in map. FILE@METRES says the metres per cell of one of them.
    strategies
        Names, parted by commas. NAME=STRATEGY is a strategy under a name of its own, for two of a
        kind with different settings. Ratios are to the first.
    robots
        How many robots, for example 1,2,4.
    range
        Sensor ranges [m], for example 3.5,7.
    radio
        perfect, off, path-loss, or ranges [m], for example perfect,10. Default: perfect, unless a
        strategy is made for another one.
    runs
        Runs of each combination. Run k has the same starts, and on a built-in map the same layout,
        for all strategies.
    seed
        Seed of the first run; each further run has the next.
    set
        A setting of a strategy, strategy.setting=value; may be repeated.
    motion
        4-connected, 8-connected or forward-turn (a turn costs a step).
    sensor
        range (360 degrees, walls block sight) or disc (sees through walls).
    loss
        Probability with which each message is lost, 0 to 0.99.
    delay
        How long a message takes [s].
    energy
        What is in each robot's battery [J]. Default: no limit.
    fault
        What happens to a robot in every run, as for conav explore; may be repeated.
    traffic
        pibt (one rule keeps robots apart) or none (they pass through each other).
    cell
        Side of a planning cell [m]. Default: the smallest multiple of the map's resolution in which
        robots pass each other round a corner.
    radius
        Radius of a robot [m].
    speed
        Top speed of a robot [m/s].
    resolution
        Metres per pixel: needed for bare pictures, optional for other maps without a scale.
    outside
        Start in the largest free part even when it looks like the outside of a building.
    outside_folder
        Let a map's yaml name a picture outside its own folder.
    max_time
        Simulated time after which a run ends [s]; one that has not seen all is counted at it.
    out
        Folder for the page, the numbers, the plots, and the runs that were played.
    bounds
        How hard to look for bounds on the best possible time, which the runs are compared with:
        quick, full or none.
    jobs
        Processes. Default: one per processor.
    plots
        Draw the plots.
    json
        Print one JSON object instead of the tables.
    quiet
        Print nothing but errors.
    """
    counts = _listed("--robots", robots, int, "a whole number")
    ranges = _listed("--range", range, float, "a number of metres")
    settings = _settings(set or [])
    if not map:
        raise InputError(
            "MAP", "is missing", "name one or more; conav maps lists the built-in ones"
        )

    from conav.compiled import compiled_before
    from conav.experiments.compare.compare import compare as run

    if not quiet and not compiled_before():
        print(
            "conav: compiling the kernels; this happens once and takes up to a minute",
            file=sys.stderr,
        )
    with _Progress(shown=not quiet) as progress:
        made = run(
            map,
            _split(strategies),
            out,
            robots=counts,
            ranges_m=ranges,
            radios=None if radio is None else _split(radio),
            runs=runs,
            seed=seed,
            settings=settings,
            bounds=bounds,
            jobs=jobs,
            plots=plots,
            progress=progress.show,
            motion=motion,
            sensor=sensor,
            loss=loss,
            delay_s=delay,
            energy_j=energy,
            faults=fault or (),
            traffic=traffic,
            cell_m=cell,
            radius_m=radius,
            speed_mps=speed,
            resolution=resolution,
            outside=outside,
            outside_folder=outside_folder,
            max_time_s=max_time,
        )
    for warning in made.warnings if not quiet else ():
        print(f"conav: warning: {warning}", file=sys.stderr)
    if json:
        print(json_module.dumps(made.summary(), allow_nan=False))
    elif not quiet:
        _print_tables(made)
    return 1 if made.interrupted or made.failures else 0


def _split(text: str) -> list[str]:
    return [part.strip() for part in text.split(",") if part.strip()]


def _listed(place: str, text: str, read: Callable[[str], T], what: str) -> Sequence[T]:
    found: list[T] = []
    for part in _split(text):
        try:
            found.append(read(part))
        except ValueError:
            raise InputError(place, f"{part!r} is not {what}", "part several by commas") from None
    return found


def _settings(pairs: list[str]) -> dict[str, dict[str, object]]:
    found: dict[str, dict[str, object]] = {}
    for pair in pairs:
        name, equals, value = pair.partition("=")
        strategy, dot, setting = name.strip().rpartition(".")
        if not (equals and dot and strategy and setting):
            raise InputError(
                f"--set {pair}",
                "is not strategy.setting=value",
                "write for example --set nearest.keep_goal=true",
            )
        found.setdefault(strategy, {})[setting.replace("-", "_")] = value.strip()
    return found


def _print_tables(made: Any) -> None:
    from conav.experiments.compare.wording import (
        aligned,
        group_rows,
        group_text,
        total_rows,
    )

    for table in made.tables[:MAX_TABLES]:
        print(f"{group_text(made.study, table.group)}: medians [95 % interval]")
        print(aligned(group_rows(made.study, table)))
        print()
    if len(made.tables) > MAX_TABLES:
        print(f"... and {len(made.tables) - MAX_TABLES} more groups\n")
    if len(made.study.teams) > 1 and made.totals:
        first = made.study.teams[0].name
        print(f"times relative to {first}, paired runs: geometric mean [95 % interval]")
        print(aligned(total_rows(made.study, made.totals)))
        print()
    for case, failure in list(made.failures.items())[:5]:
        print(f"failed: {case.strategy} on {case.map}, seed {case.seed}: {failure.message}")
    total, there = len(made.study.cases()), len(made.results)
    if len(made.failures) > 5:
        print(f"... and {len(made.failures) - 5} more")
    if made.interrupted:
        print(f"interrupted: {there} of {total} runs; the same command goes on from there")
    print(f"{made.played} of {total} runs played now; page, numbers, plots: {made.folder}")


class _Progress:
    """A bar on standard error, with the time left, where that is a terminal."""

    def __init__(self, *, shown: bool) -> None:
        self._shown = shown and sys.stderr.isatty()
        self._bar: Any = None

    def __enter__(self) -> "_Progress":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def show(self, done: int, total: int) -> None:
        """Show that so many of the runs and bounds are there."""
        if not self._shown:
            return
        if self._bar is None:
            self._bar, self._task = _new_bar(done, total)
            self._bar.start()
        what = "comparing" if done < total else "drawing"  # plots take a while, too
        self._bar.update(self._task, completed=done, description=what)


def _new_bar(done: int, total: int) -> tuple[Any, Any]:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("runs and bounds,"),
        TimeElapsedColumn(),
        TextColumn("gone,"),
        TimeRemainingColumn(),
        TextColumn("left"),
        console=Console(stderr=True),
        transient=True,
        speed_estimate_period=600.0,  # [s] runs differ too much to look at the last few alone
    )
    return bar, bar.add_task("comparing", total=total, completed=done)
