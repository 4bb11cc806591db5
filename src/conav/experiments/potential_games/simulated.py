"""What takes the ordinary simulator: information, meetings, and the true potential game."""

import numpy as np

from conav.experiments.potential_games.lab import (
    Lab,
)
from conav.experiments.potential_games.report import (
    HELD,
    OPEN,
    Section,
    estimate,
)
from conav.experiments.potential_games.teams import TIMES, algorithm_2, alone, improved
from conav.experiments.potential_games.world import Team, team
from conav.intervals import Estimate, mean_interval, ratio_interval


def information(lab: Lab) -> Section:
    """What robots tell each other."""
    section = Section(
        "information",
        "Information exchanged",
        "By the ordinary simulator, per robot and step until all is seen: positions and newly seen "
        "points for all, for the improved algorithm headings and changes of sets, for marginal "
        "contributions heading and sequence.",
        ("team", "messages", "bytes", "points looked at"),
    )
    teams = [
        algorithm_2(0.1),
        improved(0.1),
        team("marginal contributions, epsilon 0.1", "marginal-contribution", epsilon=0.1),
        alone(),
    ]
    sizes: list[Estimate] = []
    for players in teams:
        runs = lab.simulated(players)
        found = [
            mean_interval([np.mean([getattr(run, name) for run in layout]) for layout in runs])
            for name in ("messages", "bytes", "points")
        ]
        if players.strategy == "marginal-contribution":
            del found[2]  # it keeps lists of points, and no count of those it looked at for them
        for name, one in zip(("messages", "bytes", "points looked at"), found, strict=False):
            section.add(players.label, 2, name, "per robot-step", one)
        section.table.append((players.label, *map(estimate, found), *[""] * (3 - len(found))))
        sizes.append(found[1])
    section.judge(
        "section 4",
        "the improved algorithm needs more information",
        HELD if sizes[1].low > sizes[0].high else OPEN,
        f"bytes per robot and step: {estimate(sizes[1])} against {estimate(sizes[0])}",
    )
    return section


def meetings(lab: Lab) -> Section:
    """Robots that pass through each other, as in the paper, and robots that do not."""
    section = Section(
        "traffic",
        "Robots that meet",
        "The paper has no rule against two robots in one place. The same games by the ordinary "
        "simulator without and with one.",
        ("team", "T90", "T99", "T100"),
    )
    for players in (algorithm_2(0.1), algorithm_2(0.3)):
        free = lab.simulated(players)
        apart_team = Team(
            players.label + ", kept apart", players.strategy, players.settings, 2, "pibt"
        )
        apart = lab.simulated(apart_team)
        means: list[list[list[float]]] = []
        for one, runs in ((players, free), (apart_team, apart)):
            table = [
                [
                    float(np.mean([min(run.times[column], lab.steps) for run in layout]))
                    for layout in runs
                ]
                for column in range(4)
            ]
            means.append(table)
            for column in range(4):
                section.add(one.label, 2, TIMES[column], "steps", mean_interval(table[column]))
            section.table.append(
                (one.label, *(estimate(mean_interval(table[column])) for column in (0, 2, 3)))
            )
        ratio = ratio_interval(means[1][3], means[0][3])
        section.add(f"{players.label}, kept apart over not", 2, "T100 ratio", "", ratio)
    return section


def marginal(lab: Lab) -> Section:
    """The true potential game."""
    section = Section(
        "marginal",
        "Beyond: a true potential game",
        "Robots are paid what the team would miss without them and play to an equilibrium in every "
        "step, by the ordinary simulator. Regret is what a robot could have gained, by all that "
        "the team had seen; with a perfect radio it is 0 in every step, with a short one robots do "
        "not know of each other.",
        ("team", "radio [m]", "T90", "T99", "T100", "finished", "regret > 0"),
    )
    rivals = [algorithm_2(0.1), algorithm_2(0.3)]
    settings = (("epsilon", 0.1),)
    name = "marginal-contribution"
    teams = [
        Team(f"marginal contributions, epsilon 0.1, radio {text}", name, settings, radio_m=radio)
        for text, radio in (("perfect", None), ("16 m", 16.0), ("8 m", 8.0), ("4 m", 4.0))
    ]
    means: dict[str, list[list[float]]] = {}
    for players in (*rivals, *teams):
        runs = lab.simulated(players)
        table = [
            [
                float(np.mean([min(run.times[column], lab.steps) for run in layout]))
                for layout in runs
            ]
            for column in range(4)
        ]
        means[players.label] = table
        every_run = [run for layout in runs for run in layout]
        done = sum(bool(np.isfinite(run.times[3])) for run in every_run)
        found = [mean_interval(table[column]) for column in range(4)]
        for column in range(4):
            section.add(players.label, 2, TIMES[column], "steps", found[column])
        regret = mean_interval([np.mean([run.regretful for run in layout]) for layout in runs])
        playing = players.strategy == name
        if playing:
            section.add(players.label, 2, "regret above 0", "share of robot-steps", regret)
        radio = "perfect" if players.radio_m is None else f"{players.radio_m:g}"
        section.table.append(
            (
                players.label.partition(", radio")[0],
                radio,
                *(estimate(found[column]) for column in (0, 2, 3)),
                f"{done} of {len(every_run)}",
                (f"{100 * regret.value:.2g} %" if regret.value else "never") if playing else "",
            )
        )
    best = means[teams[0].label]
    for players in rivals:
        for column in (0, 3):
            ratio = ratio_interval(best[column], means[players.label][column])
            label = f"marginal contributions over {players.label}"
            section.add(label, 2, f"{TIMES[column]} ratio", "", ratio)
            section.text += (
                f" {TIMES[column]} of marginal contributions over {players.label}: "
                f"{estimate(ratio)}."
            )
    return section
