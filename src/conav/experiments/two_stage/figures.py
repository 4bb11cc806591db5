"""The reproduction's pictures, from its runs."""

from collections.abc import Mapping
from pathlib import Path

from conav.experiments.two_stage.claims import FRAMES
from conav.experiments.two_stage.lab import Lab
from conav.experiments.two_stage.results import Results, Value
from conav.experiments.two_stage.world import CELL_M, METHODS, RANGE_M, SPEED_MPS, Case
from conav.pictures.plots import Series, save_points
from conav.pictures.two_stage_figures import save_flowchart, save_sections, save_trajectories

_TEAMS = {
    "TSCA, 5 s": ("TSCA", 5.0),
    "TSCA, 0 s": ("TSCA", 0.0),
    "DTA": ("DTA", 0.0),
    "RAA, 5 s": ("RAA", 5.0),
    "RAA, 0 s": ("RAA", 0.0),
}
_PAPERS = {name.partition(",")[0]: team for name, team in _TEAMS.items() if "0 s" not in name}

_CURVES: dict[str, tuple[str, str, Value, Mapping[str, tuple[str, float]]]] = {
    "figure-3a.png": (
        "Figure 3 (a). Exploration time", "simulated seconds", lambda run: run.time_s, _TEAMS
    ),
    "over-bound.png": (
        "Time over the certified lower bound", "ratio", lambda run: run.time_s / run.bound_s, _TEAMS
    ),
    "figure-3b.png": (
        "Figure 3 (b). Coordinate frame transformations", "local maps, one per straight stretch",
        FRAMES["turn"][1], _PAPERS,
    ),
    "figure-3c.png": (
        "Figure 3 (c). Assignment rounds, our reading", "rounds", lambda run: run.rounds, _PAPERS
    ),
    "figure-3d.png": (
        "Figure 3 (d). Bids sent, our reading", "bids", lambda run: run.bids, _PAPERS
    ),
    "drift.png": (
        "Mean error of position, loops closed in the own map", "metres",
        lambda run: run.mean_own_m, _PAPERS,
    ),
}  # fmt: skip


def draw_curves(folder: Path, results: Results) -> None:
    """Draw the measures over team sizes. Raises `InputError` without matplotlib."""
    note = f"Means over {len(results.seeds)} runs with 95 % intervals."
    for file, (title, unit, value, teams) in _CURVES.items():
        series: list[Series] = []
        for label, (method, wait_s) in teams.items():
            found = [
                (robots, mean)
                for robots in results.robots
                if (mean := results.mean(method, robots, wait_s, value)) is not None
            ]
            if found:
                bars = len(results.seeds) > 1
                series.append(
                    Series(
                        label,
                        [robots for robots, _ in found],
                        [mean.value for _, mean in found],
                        [mean.low for _, mean in found] if bars else None,
                        [mean.high for _, mean in found] if bars else None,
                    )
                )
        save_points(
            folder / file, series, xlabel="robots", ylabel=unit, title=title, note=note,
            connect=True, y_range=(0.0, None),
        )  # fmt: skip


def draw_runs(folder: Path, lab: Lab, seed: int) -> None:
    """Draw the flowchart, and two robots' runs from the first starts."""
    save_flowchart(folder / "figure-2.png")
    cases = {method: Case(method, 2, 5.0, seed) for method in METHODS}
    traces = lab.traces([case.played for case in cases.values()])
    runs = {method: traces[case.played] for method, case in cases.items()}
    save_trajectories(
        folder / "figure-4.png",
        {f"{method}: {trace.time_s:,.0f} s": trace.paths for method, trace in runs.items()},
        runs["TSCA"].side_m,
        f"Seed {seed}, auctions with a wait of 5 s. Rings are the starts, dots the ends.",
    )
    first = runs["TSCA"]
    if first.board is not None:
        step, axis, sections = first.board
        save_sections(
            folder / "figure-1.png",
            [path[: step + 1] for path in first.paths],
            axis,
            [(lower * CELL_M, (upper + 1) * CELL_M) for lower, upper in sections],
            RANGE_M,
            first.side_m,
            f"Seed {seed}, after {step * CELL_M / SPEED_MPS:,.0f} s, when both robots are in stage "
            "2. Rings are the starts. Grey: what nobody has scanned.",
        )
