"""Claims no figure covers: the exploration rate, overlap, and how robots respond."""

from math import isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np

from conav.experiments.potential_games.lab import (
    Lab,
    curve,
    finished_share,
    mean_times,
    time_estimate,
    time_ratio,
)
from conav.experiments.potential_games.report import (
    HELD,
    NOT_HELD,
    OPEN,
    Section,
    below,
    estimate,
    number,
    percent,
)
from conav.experiments.potential_games.teams import (
    BAND,
    EPSILONS,
    TIES,
    TIME_HEADER,
    add_times,
    algorithm_2,
)
from conav.experiments.potential_games.world import team
from conav.exploration.turn_sequences import points_in_square
from conav.intervals import Estimate, mean_interval, ratio_interval
from conav.pictures.plots import Series, save_curves, save_points


class _Rate(NamedTuple):
    epsilon: float
    total: Estimate
    early: Estimate
    equilibria: Estimate


def _against_epsilon(label: str, rates: list[_Rate], measure: str) -> Series:
    found: list[Estimate] = [getattr(rate, measure) for rate in rates]
    floor = 0.0 if measure == "equilibria" else 1.0
    return Series(
        label,
        [rate.epsilon for rate in rates],
        [one.value for one in found],
        # Bars that are cut off at what is drawn: an axis of logarithms has no room below 1 step.
        [max(one.low, floor) if isfinite(one.low) else one.value for one in found],
        [one.high if isfinite(one.high) else one.value for one in found],
    )


def exploration_rate(lab: Lab) -> Section:
    """Epsilon from 0.01 to 1: times, realised turn rate, cost, equilibria."""
    section = Section(
        "epsilon",
        "The exploration rate",
        "Algorithm 2, sRange 2. A turn rate is turn sequences per step in which a robot is free to "
        "choose; decisions and points are per robot and step, over all steps played. The share of "
        "steps at a Nash equilibrium of the game with utilities (7) counts steps until all is "
        "seen.",
        ("epsilon", "ties", "T100", "finished", "turn rate", "decisions", "points", "equilibrium"),
    )
    points_each = 5 * points_in_square(2)
    traced = min(lab.games, 50)
    lines: dict[str, list[_Rate]] = {}
    for tie, text in TIES:
        for epsilon in EPSILONS:
            players = algorithm_2(epsilon, tie)
            played = lab.bulk(players)
            seen = lab.bulk(players, games=traced, steps=min(2000, lab.steps), traced=True)
            done = finished_share(played, 3)
            time_ = time_estimate(played, 3, lab.steps)
            early = time_estimate(played, 0, lab.steps)
            turns = mean_interval([one.turns for one in played])
            decisions = mean_interval([one.decisions for one in played])
            at_rest = mean_interval([one.equilibria for one in seen])
            label = players.label
            section.add(label, 2, "T100", "steps", time_)
            section.add(label, 2, "T90", "steps", early)
            section.add(label, 2, "finished", "share of games", done)
            section.add(label, 2, "turn rate", "per free robot-step", turns)
            section.add(label, 2, "decisions", "per robot-step", decisions)
            section.add(label, 2, "steps at equilibrium", "share", at_rest)
            least = "" if done.value == 1.0 else "at least "
            section.table.append(
                (
                    f"{epsilon:g}",
                    text,
                    least + estimate(time_),
                    percent(done),
                    estimate(turns),
                    estimate(decisions),
                    number(decisions.value * points_each),
                    estimate(at_rest),
                )
            )
            lines.setdefault(text, []).append(_Rate(epsilon, time_, early, at_rest))
    series = [
        _against_epsilon(f"{name}, {text}", found, measure)
        for text, found in lines.items()
        for name, measure in (("T100", "total"), ("T90", "early"))
    ]

    note = f"Unfinished games count as {lab.steps} steps. Bars are 95 % intervals over layouts."

    def draw(path: Path) -> None:
        save_points(
            path, series, xlabel="epsilon", ylabel="steps", note=note,
            title="Exploration time against epsilon", log_x=True, log_y=True, connect=True,
        )  # fmt: skip

    section.pictures.append(("epsilon.png", "Exploration time against epsilon", draw))
    rests = [_against_epsilon(text, found, "equilibria") for text, found in lines.items()]

    def draw_rest(path: Path) -> None:
        save_points(
            path, rests, xlabel="epsilon", ylabel="share of steps",
            title="Steps at a Nash equilibrium until all is seen",
            note="Bars are 95 % intervals over layouts.", log_x=True, connect=True,
        )  # fmt: skip

    section.pictures.append(("equilibrium.png", "Share of steps at a Nash equilibrium", draw_rest))
    small, large = lines["ties drawn"][0].equilibria, lines["ties drawn"][-1].equilibria
    section.judge(
        "section 2.4",
        "a small epsilon makes it likely that robots play a Nash equilibrium",
        HELD if small.low > large.high else NOT_HELD if small.high < large.low else OPEN,
        f"share of steps at epsilon {EPSILONS[0]:g}: {estimate(small)}, at 1: {estimate(large)}",
    )
    half = ratio_interval(
        mean_times(lab.bulk(algorithm_2(0.1)), 3, lab.steps),
        mean_times(lab.bulk(algorithm_2(1.0)), 3, lab.steps),
    )
    section.judge(
        "section 2.4",
        "a small epsilon explores faster than epsilon 1",
        below(half, 1.0),
        f"T100 at 0.1 over that at 1: {estimate(half)}",
    )
    free = mean_interval(
        [one.turns for one in lab.bulk(team("Algorithm 1", "potential-1", epsilon=0.1))]
    )
    with_obstacles = mean_interval([one.turns for one in lab.bulk(algorithm_2(0.1))])
    section.add("Algorithm 1, epsilon 0.1", 2, "turn rate", "per free robot-step", free)
    section.judge(
        "section 3",
        "obstacles act as a larger epsilon would",
        HELD if with_obstacles.low > free.high else OPEN,
        f"turn rate at epsilon 0.1: {estimate(with_obstacles)} with Algorithm 2, "
        f"{estimate(free)} with Algorithm 1 on the same maps",
    )
    decisions = mean_interval([one.decisions for one in lab.bulk(algorithm_2(0.1))])
    section.judge(
        "section 3.1",
        "a robot decides seldom",
        HELD if decisions.high < 0.5 else NOT_HELD,
        f"decisions per robot and step at epsilon 0.1: {estimate(decisions)}",
    )
    return section


def overlap(lab: Lab) -> Section:
    """How much robots look at the same points, over time."""
    section = Section(
        "overlap",
        "Overlap over time",
        "The share of the points in robots' ranges at a step that are in more than one range, and "
        "what each robot has seen, added up, over what the team has seen, less 1.",
        ("team", "in range at 0", "at 50", "at 200", "at 500", "seen twice at 200", "at 1,000"),
    )
    games = min(lab.games, 50)
    steps = min(2000, lab.steps)
    teams = [algorithm_2(0.1), algorithm_2(0.3), algorithm_2(1.0), algorithm_2(0.1, "baseline")]
    series: list[Series] = []
    firsts: list[tuple[Estimate, Estimate]] = []
    for players in teams:
        played = lab.bulk(players, games=games, steps=steps, traced=True)
        at = {
            step: mean_interval([one.overlap[min(step, steps)] for one in played])
            for step in (0, 50, 200, 500)
        }
        twice = {
            step: mean_interval([one.sensed[min(step, steps)] for one in played])
            for step in (200, 1000)
        }
        for step, found in at.items():
            section.add(players.label, 2, f"overlap of ranges at step {step}", "share", found)
        for step, found in twice.items():
            section.add(players.label, 2, f"overlap of what was seen at step {step}", "", found)
        section.table.append(
            (players.label, *(estimate(x) for x in at.values()), *map(estimate, twice.values()))
        )
        firsts.append((at[0], at[200]))
        mean, low, high = curve([one.overlap for one in played])
        section.add_curve(players.label, 2, "overlap of ranges", (mean, low, high))
        last = min(600, steps) + 1
        series.append(Series(players.label, np.arange(last), mean[:last], low[:last], high[:last]))

    def draw(path: Path) -> None:
        save_curves(
            path, series, xlabel="step", ylabel="share of the points in range",
            title="Points in several robots' ranges", note=BAND,
        )  # fmt: skip

    section.pictures.append(("overlap.png", "Overlap of the robots' ranges over time", draw))
    section.judge(
        "section 2.4",
        "overlapping coverage diminishes quickly",
        HELD if firsts[0][1].high < firsts[0][0].low / 4 else NOT_HELD,
        f"epsilon 0.1: {estimate(firsts[0][0])} at step 0, {estimate(firsts[0][1])} at 200",
    )
    cumulated = [
        mean_interval(
            [one.sensed[min(1000, steps)] for one in lab.bulk(
                algorithm_2(epsilon), games=games, steps=steps, traced=True
            )]
        )
        for epsilon in (0.1, 1.0)
    ]  # fmt: skip
    section.judge(
        "section 2.4",
        "robots with epsilon 1 overlap more",
        HELD
        if cumulated[1].low > cumulated[0].high
        else NOT_HELD
        if cumulated[1].high < cumulated[0].low
        else OPEN,
        f"seen twice at step 1,000: {estimate(cumulated[0])} at epsilon 0.1, "
        f"{estimate(cumulated[1])} at 1",
    )
    return section


def responses(lab: Lab) -> Section:
    """The best of four sequences against one random sequence if it is better."""
    section = Section(
        "responses",
        "Potential game against better response",
        "Section 2.1.3 draws one sequence and takes it if it is better; Algorithm 2 compares all "
        "four.",
        TIME_HEADER,
    )
    for epsilon in (0.1, 0.3, 1.0):
        one = team(f"better response, epsilon {epsilon:g}", "better-response", epsilon=epsilon)
        played = lab.bulk(one)
        add_times(section, lab, one, played)
        for tie, text in TIES:
            ratio = time_ratio(lab.bulk(algorithm_2(epsilon, tie)), played, 0, lab.steps)
            label = f"Algorithm 2 ({text}) over better response, epsilon {epsilon:g}"
            section.add(label, 2, "T90 ratio", "", ratio)
            section.judge(
                "section 2.2",
                f"comparing all sequences is faster than one random one (epsilon {epsilon:g}, "
                f"{text})",
                below(ratio, 1.0),
                f"T90 ratio {estimate(ratio)}",
            )
    return section
