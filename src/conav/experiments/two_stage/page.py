"""The page of the reproduction, in Markdown."""

from collections.abc import Sequence
from pathlib import Path

from conav.experiments.two_stage.claims import unfinished
from conav.experiments.two_stage.results import Results, Section
from conav.experiments.two_stage.world import World

NUMBERS = "numbers.csv"
RUNS = "runs.csv"
TITLE = "# The two-stage coordinated strategy: what holds"


def page(
    folder: Path,
    sections: Sequence[Section],
    results: Results,
    world: World,
    *,
    wanted: int,
) -> str:
    """The page; pictures are shown where their files lie in the folder. `wanted` runs were asked
    for."""
    sizes = ",".join(map(str, results.robots))
    command = f"conav reproduce two-stage --runs {len(results.seeds)} --robots {sizes}"
    if results.seeds[0]:
        command += f" --seed {results.seeds[0]}"
    if world.motion != World().motion:
        command += f" --motion {world.motion}"
    if world.side_m != World().side_m:
        command += f" --side {world.side_m:g}"
    lines = [
        TITLE,
        "",
        "X.-F. Dai, L.-H. Jiang: A Two-stage Coordinated Strategy for Integrated Exploration of "
        "Multi-robot Systems, 2018.",
        "",
        f"Made by `{command}`; the numbers are in [{NUMBERS}]({NUMBERS}), the runs in "
        f"[{RUNS}]({RUNS}).",
        "",
    ]
    late, failed = unfinished(results)
    if len(results.found) < wanted:
        lines += [f"{len(results.found)} of {wanted} cases were played.", ""]
    if late or failed:
        lines += [
            f"{late} runs did not see all and count with the time they took; {failed} could not be "
            "played and are left out.",
            "",
        ]
    verdicts = [verdict for section in sections for verdict in section.verdicts]
    lines += [
        "A claim *held* or *did not hold* when the whole 95 % interval says so, and is *not "
        "decided* otherwise. A claim for several team sizes held when it held at each. Every "
        "interval stands for itself: of twenty at the very limit, one may be wrong.",
        "",
        "| where | claim | here | in numbers |",
        "|---|---|---|---|",
    ]
    lines += [
        f"| {one.source} | {one.claim} | **{one.verdict}** | {one.numbers} |" for one in verdicts
    ]
    lines += [
        "",
        "## The world",
        "",
        f"As in the paper: {world.side_m:g} x {world.side_m:g} m without obstacles, 0.20 m/s, a "
        "sensor of 4 m all around, random starts all over the area, auctions with a wait of 5 s, "
        f"{len(results.seeds)} runs for each team size. Team sizes are not in its text. Ours: "
        f"cells of 0.5 m, {world.motion} moves, a wait of 0 s as well, everybody hears everybody, "
        "robots make way for each other. The paper lets robots go up, down, left and right only, "
        "to keep its discussion simple; 8-connected moves spare the other two methods staircases "
        "and change nothing about rectangles. All methods have the same starts in a run. Values "
        "are means over runs with Student's 95 % interval; ratios of times are geometric means of "
        "paired ones, other comparisons are paired differences.",
        "",
        "The methods are [two-stage](../../strategies/two-stage.md) (TSCA), "
        "[decision-theoretic](../../strategies/decision-theoretic.md) (DTA) and "
        "[repeated-auction](../../strategies/repeated-auction.md) (RAA).",
        "",
    ]
    for file, what in (
        ("figure-1.png", "Rectangles of two robots, and the sections left"),
        ("figure-2.png", "The flowchart, drawn from the program's table"),
    ):
        if (folder / file).is_file():
            lines += [f"![{what}]({file})", ""]
    for section in sections:
        lines += [f"## {section.title}", "", section.text, ""]
        for file, what in section.pictures:
            if (folder / file).is_file():
                lines += [f"![{what}]({file})", ""]
        if section.table:
            lines += [
                "| " + " | ".join(section.header) + " |",
                "|" + "---|" * len(section.header),
                *("| " + " | ".join(row) + " |" for row in section.table),
                "",
            ]
    return "\n".join(lines)
