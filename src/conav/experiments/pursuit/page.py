"""The page of the reproduction, in Markdown."""

from collections.abc import Sequence
from pathlib import Path

from conav.experiments.compare.outcome import Failure
from conav.experiments.pursuit.figures import CAPTIONS
from conav.experiments.pursuit.results import Results, Section
from conav.experiments.pursuit.world import SIZES

NUMBERS = "results.csv"
RUNS = "runs.csv"
TITLE = "# Clearing labyrinths: what holds"


def page(
    folder: Path,
    sections: Sequence[Section],
    results: Results,
    *,
    runs: int,
    seed: int,
    sizes: int,
    wanted: int,
) -> str:
    """The page; pictures are shown where their files lie in the folder. `wanted` cases were asked
    for."""
    command = f"conav reproduce pursuit --runs {runs}"
    if seed:
        command += f" --seed {seed}"
    if sizes != SIZES:
        command += f" --sizes {sizes}"
    lines = [
        TITLE,
        "",
        "D. Pellier, H. Fiorino: Coordinated exploration of unknown labyrinthine environments "
        "applied to the pursuit-evasion problem. AAMAS 2005.",
        "",
        f"Made by `{command}`; the numbers are in [{NUMBERS}]({NUMBERS}), those of every case in "
        f"[{RUNS}]({RUNS}).",
        "",
    ]
    failed = sum(isinstance(one, Failure) for one in results.found.values())
    if len(results.found) < wanted:
        lines += [f"{len(results.found)} of {wanted} cases were played.", ""]
    if failed:
        lines += [f"{failed} cases could not be played, and do not count.", ""]
    lines += [
        "A claim *held* when the whole 95 % interval says so, *did not hold* when the whole "
        "interval says the opposite or that there is no difference, and is *not decided* "
        "otherwise. A claim that something is always so did not hold when one floor shows it, and "
        "held on the floors that were played. Every interval stands for itself: of twenty at the "
        "very limit, one may be wrong.",
        "",
        "| where | claim | here | in numbers |",
        "|---|---|---|---|",
        *(
            f"| {one.source} | {one.claim} | **{one.verdict}** | {one.numbers} |"
            for section in sections
            for one in section.verdicts
        ),
        "",
        "## What is played",
        "",
        "The paper gives no floors and no numbers: its claims are in its text. Made "
        f"floors are ours, {sizes} of each family, with {runs} random corridor trees of 12 "
        "segments where floors are unknown and of 20 where they are known. Intervals are over "
        "random floors alone, which are independent. The verifier looked every plan over.",
        "",
    ]
    shown = [(file, what) for file, what in CAPTIONS if (folder / file).is_file()]
    if shown:
        lines += [
            "## The paper's figures",
            "",
            "On floors of ours; nothing is copied from the paper.",
            "",
        ]
        for file, what in shown:
            lines += [f"{what}", "", f"![{what.partition(':')[0]}]({file})", ""]
    for section in sections:
        lines += [f"## {section.title}", "", section.text, ""]
        for file, what in section.pictures:
            if (folder / file).is_file():
                lines += [f"![{what}]({file})", ""]
        for header, table in section.tables:
            if table:
                lines += [
                    "| " + " | ".join(header) + " |",
                    "|" + "---|" * len(header),
                    *("| " + " | ".join(row) + " |" for row in table),
                    "",
                ]
    return "\n".join(lines)
