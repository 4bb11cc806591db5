"""What the paper claims, and whether it holds in the runs: sections of the page."""

from collections.abc import Callable
from math import pi

from conav.experiments.compare.outcome import Failure
from conav.experiments.potential_games.report import Verdict, below, estimate
from conav.experiments.two_stage.play import Played
from conav.experiments.two_stage.results import (
    RIVALS,
    Results,
    Row,
    Section,
    Value,
    compare_methods,
    judge_sizes,
    over_sizes,
    ratio_row,
    row,
)
from conav.experiments.two_stage.world import WAITS_S
from conav.intervals import Estimate, mean_interval
from conav.status import Status

TIME = "exploration time"


def exploration_time(results: Results) -> Section:
    """Figure 3 (a): the time, its ratio to the bound and to the rivals' time."""
    section = Section(
        "Figure 3 (a): exploration time",
        "Simulated seconds until all is seen, in brackets the mean over the certified lower bound "
        "for the same starts: no team finishes before it, whatever it does. DTA holds no auctions, "
        "so it waits for none.",
        ("robots", "TSCA, 5 s", "TSCA, 0 s", "DTA", "RAA, 5 s", "RAA, 0 s", "bound [s]"),
    )
    columns = [("TSCA", 5.0), ("TSCA", 0.0), ("DTA", 0.0), ("RAA", 5.0), ("RAA", 0.0)]
    for robots in results.robots:
        cells = [str(robots)]
        for method, wait_s in columns:
            time = row(section, results, TIME, "s", method, robots, wait_s, lambda run: run.time_s)
            over = row(
                section, results, "time over the bound", "", method, robots, wait_s,
                lambda run: run.time_s / run.bound_s,
            )  # fmt: skip
            cells.append(
                "-" if time is None or over is None else f"{estimate(time)} ({over.value:.2f})"
            )
        bound = row(
            section, results, "lower bound", "s", "TSCA", robots, 5.0, lambda run: run.bound_s
        )
        cells.append("-" if bound is None else estimate(bound))
        section.table.append(tuple(cells))
    for wait_s in WAITS_S:
        for rival in RIVALS:
            for robots in results.robots:
                ratio = ratio_row(
                    section, results, TIME, rival, robots, wait_s, lambda run: run.time_s
                )
                if ratio is not None:
                    section.verdicts.append(
                        Verdict(
                            "Figure 3 (a)",
                            f"saves time against {rival}: {_team(robots)}, {_wait(wait_s)}",
                            below(ratio, 1.0),
                            f"time of TSCA over {rival}: {estimate(ratio)}",
                        )
                    )
    section.pictures += [
        ("figure-3a.png", "Exploration time"),
        ("over-bound.png", "Time over the bound"),
    ]
    return section


FRAMES: dict[str, tuple[str, Value]] = {
    "target": (
        "a local map per target set out for, an edge of a rectangle being one",
        lambda run: run.targets,
    ),
    "task": ("a local map per task, a whole rectangle being one", lambda run: run.tasks),
    "turn": ("a local map per straight stretch of the path", lambda run: run.turns),
    "range": (
        "a local map wherever the last one is out of the sensor's range",
        lambda run: run.stretches,
    ),
}
"""Definition of a coordinate frame transformation -> what it says, and the count."""


def frame_transformations(results: Results) -> Section:
    """Figure 3 (b), under each definition."""
    section = Section(
        "Figure 3 (b): coordinate frame transformations",
        "The paper does not say what it counts. Each local map that is started has to be "
        "transformed into the global one, so local maps are counted, by four definitions:\n\n"
        + "\n".join(f"- `{name}`: {text}." for name, (text, _) in FRAMES.items())
        + "\n\nMeans over runs of team totals, auctions with a wait of 5 s; methods are ranked by "
        "their totals, the fewest first.",
        ("robots", "definition", "TSCA", "DTA", "RAA", "ranking"),
    )
    for name, (_, value) in FRAMES.items():
        compare_methods(section, results, f"frame transformations ({name})", name, value)
        judge_sizes(
            section, results, "Figure 3 (b)", f"saves frame transformations ({name})", value
        )
    section.pictures.append(("figure-3b.png", "Local maps by the definition `turn`"))
    return section


def task_assignment(results: Results) -> Section:
    """Figure 3 (c) and (d), as we read them."""
    section = Section(
        "Figure 3 (c) and (d): task assignment",
        "The paper only says that they show a simplified procedure. Our reading: (c) is the number "
        "of assignments that are made, (d) that of the bids robots send for them. An assignment is "
        "a section sold by TSCA, an auction of all tasks held by RAA (which sells dozens in it), "
        "and one of the whole team computed by DTA. A bid is a value that a robot sends: TSCA "
        "sends the best one in each round, RAA one per task, and DTA has none. Messages are all "
        "that minds send, requests and orders of DTA as well; scans are not among them. Means over "
        "runs of team totals, auctions with a wait of 5 s.",
        ("robots", "measure", "TSCA", "DTA", "RAA", "ranking"),
    )
    values: dict[str, Value] = {
        "rounds": lambda run: run.rounds,
        "bids": lambda run: run.bids,
        "messages": lambda run: run.messages,
        "bytes": lambda run: run.bytes,
    }
    for name, value in values.items():
        compare_methods(section, results, f"assignment {name}", name, value)
    team = [robots for robots in results.robots if robots > 1]
    judge_sizes(
        section,
        results,
        "Figure 3 (c)",
        "simplifies task assignment: fewer rounds",
        values["rounds"],
    )
    judge_sizes(
        section,
        results,
        "Figure 3 (d)",
        "simplifies task assignment: fewer bids",
        values["bids"],
        rivals=("RAA",),
        sizes=team,
    )
    judge_sizes(
        section,
        results,
        "Figure 3 (d)",
        "simplifies task assignment: fewer messages",
        values["messages"],
        sizes=team,
    )
    section.pictures += [("figure-3c.png", "Assignment rounds"), ("figure-3d.png", "Bids sent")]
    return section


def smoothness(results: Results) -> Section:
    """Figure 4's claim in numbers."""
    section = Section(
        "Figure 4: regular and smooth trajectories",
        "Turns, and the angle turned, per metre driven; standing still is no turn. Of the many "
        "equally short paths on a grid DTA and RAA take one by a fixed rule, so part of their "
        "turns is that rule's. Auctions with a wait of 5 s.",
        ("robots", "measure", "TSCA", "DTA", "RAA", "ranking"),
    )
    values: dict[str, Value] = {
        "turns per 100 m": lambda run: 100 * run.turns / run.path_m,
        "degrees turned per m": lambda run: 180 / pi * run.turned / run.path_m,
    }
    for name, value in values.items():
        compare_methods(section, results, name, name, value)
        judge_sizes(section, results, "Figure 4", f"more regular and smoother: {name}", value)
    section.pictures.append(("figure-4.png", "Two robots' trajectories by the three methods"))
    return section


def balance(results: Results) -> Section:
    """The claim that auctions balance what stage 1 left unbalanced."""
    section = Section(
        "Balance by auction",
        "The standard deviation of the robots' shares of the team's path, 0 being even: of what "
        "each drove in stage 1, and of the whole run. Beside it the share of their time robots "
        "stood still, which shares of the path do not show. A wait of 5 s.",
        (
            "robots",
            "after stage 1",
            "at the end",
            "end less stage 1",
            "stage 2 began [s]",
            "stood still",
        ),
    )
    differences: list[tuple[int, Estimate]] = []
    for robots in results.robots:
        runs = [
            run
            for run in results.runs("TSCA", robots, 5.0).values()
            if run.balance_first is not None
        ]
        if robots < 2 or not runs:
            continue
        first = mean_interval([run.balance_first or 0.0 for run in runs])
        end = mean_interval([run.balance for run in runs])
        less = mean_interval([run.balance - (run.balance_first or 0.0) for run in runs])
        began = [run.second_s for run in runs if run.second_s is not None]
        still = mean_interval([100 * run.still for run in runs])
        for measure, unit, found in (
            ("balance after stage 1", "", first),
            ("balance at the end", "", end),
            ("balance, end less stage 1", "", less),
            ("time stood still", "%", still),
        ):
            section.rows.append(Row(measure, unit, "TSCA", robots, 5.0, *found))
        differences.append((robots, less))
        second = estimate(mean_interval(began)) if began else "-"
        section.table.append(
            (
                str(robots),
                estimate(first),
                estimate(end),
                estimate(less),
                second,
                f"{still.value:.1f} %",
            )
        )
    if differences:
        section.verdicts.append(
            over_sizes(
                "section 2",
                "auctions balance the robots' tasks after stage 1",
                [(robots, found, below(found, 0.0)) for robots, found in differences],
                "spread at the end less after stage 1",
            )
        )
    return section


def integrated(results: Results) -> Section:
    """Drift of odometry, and what closed loops save."""
    section = Section(
        "Integrated exploration: drift and closed loops",
        "Not in the paper's figures, but its title says integrated and its rectangles close "
        "loops. Each run's paths are replayed with odometry that drifts: per square root of "
        "metres 0.2 degrees of heading and 2 cm of distance, per square root of quarter turns 1 "
        "degree, all normal and seeded. A robot that comes within 1 m of a place where it (own) or "
        "anybody (shared) was at least 250 s before takes over the error that the map has there, "
        "at most once in 250 s; nothing before is corrected, and robots do not drive otherwise for "
        "it. Errors are the root mean square over robots at the end of a run [m], mean errors "
        "that over robots and steps; then the mean over runs. Auctions with a wait of 5 s.",
        ("robots", "measure", "TSCA", "DTA", "RAA", "ranking"),
    )
    values: dict[str, Value] = {
        "closures, own map": lambda run: run.closures_own,
        "closures, shared maps": lambda run: run.closures_shared,
        "error, no closures [m]": lambda run: run.error_none_m,
        "error, own map [m]": lambda run: run.error_own_m,
        "error, shared maps [m]": lambda run: run.error_shared_m,
        "mean error, no closures [m]": lambda run: run.mean_none_m,
        "mean error, own map [m]": lambda run: run.mean_own_m,
        "mean error, shared maps [m]": lambda run: run.mean_shared_m,
    }
    for name, value in values.items():
        compare_methods(section, results, name, name, value, most=name.startswith("closures"))
    for name in ("own map", "shared maps"):
        judge_sizes(
            section,
            results,
            "title",
            f"closed loops leave a smaller mean error of position ({name})",
            values[f"mean error, {name} [m]"],
        )
    section.pictures.append(("drift.png", "Mean error of position, loops closed in the own map"))
    return section


SECTIONS: tuple[Callable[[Results], Section], ...] = (
    exploration_time,
    frame_transformations,
    task_assignment,
    smoothness,
    balance,
    integrated,
)
"""The sections in the page's order."""


def unfinished(results: Results) -> tuple[int, int]:
    """How many runs did not see all, and how many could not be played."""
    runs = list(results.found.values())
    late = sum(isinstance(run, Played) and run.status != Status.DONE for run in runs)
    return late, sum(isinstance(run, Failure) for run in runs)


def _team(robots: int) -> str:
    return "1 robot" if robots == 1 else f"{robots} robots"


def _wait(wait_s: float) -> str:
    return f"wait {wait_s:g} s"
