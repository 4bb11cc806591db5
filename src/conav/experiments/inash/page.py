"""The page of the reproduction, in Markdown."""

from collections.abc import Sequence
from pathlib import Path

from conav.experiments.compare.outcome import Failure
from conav.experiments.inash.results import Results, Section
from conav.experiments.inash.world import EXPERIMENTS, Effort

NUMBERS = "results.csv"
PLANS = "plans.csv"
TITLE = "# iNash-trajectory: what holds"


def page(
    folder: Path, sections: Sequence[Section], results: Results, effort: Effort, *, wanted: int
) -> str:
    """The page; pictures are shown where their files lie in the folder. `wanted` plans were asked
    for."""
    command = f"conav reproduce inash --trials {len(results.trials)}"
    if results.trials[0]:
        command += f" --seed {results.trials[0]}"
    if effort.samples is not None:
        command += f" --samples {effort.samples}"
    if effort.batch != Effort().batch:
        command += f" --batch {effort.batch}"
    lines = [
        TITLE,
        "",
        "M. Zhu, M. Otte, P. Chaudhari, E. Frazzoli: Game theoretic controller synthesis for "
        "multi-robot motion planning, Part I: trajectory based algorithms. ICRA 2014.",
        "",
        f"Made by `{command}`; the numbers are in [{NUMBERS}]({NUMBERS}), the plans in "
        f"[{PLANS}]({PLANS}).",
        "",
    ]
    failed = sum(isinstance(one, Failure) for one in results.found.values())
    if len(results.found) < wanted:
        lines += [
            f"{len(results.found)} of {wanted} plans were made; trials that not all methods have "
            "played do not count.",
            "",
        ]
    if failed:
        lines += [f"{failed} plans could not be made; their trials do not count.", ""]
    lines += [
        "A claim *held* when the whole 95 % interval says so, *did not hold* when the whole "
        "interval says the opposite or that there is no difference, and is *not decided* "
        "otherwise. A claim that something is always so did not hold when one trial shows it. "
        "Every interval stands for itself: of twenty at the very limit, one may be wrong.",
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
        *_world(effort),
        "",
    ]
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


def _world(effort: Effort) -> list[str]:
    samples = " and ".join(
        f"{effort.samples_of(name):,} of each robot for `{about.scene}`"
        for name, about in EXPERIMENTS.items()
    )
    budget = (
        f"The budget is ours: {samples}, chosen on the trials of seeds 0 to 19 so that {_PLAIN} "
        "on these graphs comes near the paper's 92.5 % and 70.8 % of goals."
        if effort.samples is None
        else f"The budget was set by hand: {samples}."
    )
    return [
        "The paper says that robots are discs of one radius that move in any direction, that space "
        "and time are sampled, that each robot is to reach its goal by a short path, how many "
        "robots there are, and that there are 20 trials. Arena, obstacles, speeds, horizon and "
        "budget are ours: those of the made scenes (radius 0.5 m, 1 m/s, 60 s, robots vanish at "
        "their goals). Trials of the first experiment have obstacles, starts and goals of their "
        "own; in the second, which has nothing random in it, every trial deals the numbers anew. "
        "So a robot's number says when it chooses and nothing else. The trial is the seed of the "
        "samples.",
        "",
        f"{budget} Trials vary as much as the tables show.",
        "",
        "- `iNash`: [inash](../../planners/inash.md) with `mode=paper`, `response=first`, "
        f"`feasibility=false`, `shortcut_tries=0`, `guide=false`, `batch={effort.batch}`; the "
        "paper's batch is 1. At the end, rounds on the final graphs until nobody improves.",
        "- `prioritized` and `any-time prioritized`: [prioritized](../../planners/prioritized.md) "
        "and [anytime-prioritized](../../planners/anytime-prioritized.md) on the same graphs, "
        "vertex for vertex.",
        "- `ours`: inash as it is by default, with as many samples.",
    ]


_PLAIN = "`prioritized`"
