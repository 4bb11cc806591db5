"""What the paper's tables and text say, and whether it holds here: sections of the page."""

from collections.abc import Callable, Sequence

import numpy as np

from conav.experiments.inash.figures import picture_of
from conav.experiments.inash.game_claims import checks, equilibria, messages, prices, verified
from conav.experiments.inash.results import (
    Results,
    Section,
    each_trial,
    less,
    mean_of,
    more,
    over_trials,
    paired_difference,
    share_of,
    slope,
    spread,
)
from conav.experiments.inash.world import (
    ANYTIME,
    EXPERIMENTS,
    INASH,
    METHODS,
    OURS,
    PLAIN,
    TRIALS_OF_PAPER,
)
from conav.experiments.potential_games.report import (
    Verdict,
    estimate,
    percent,
)
from conav.intervals import Estimate, wilson

TABLES = {"discs": "first experiment", "intersection": "second experiment"}


def success(results: Results, experiment: str) -> Section:
    """Who reaches its goal how often, beside the paper's table."""
    about = EXPERIMENTS[experiment]
    trials = len(results.paired(experiment))
    section = Section(
        f"{about.title}: who reaches its goal",
        f"Of {TRIALS_OF_PAPER} trials in the paper and {trials} here, those in which robot 1, 2 "
        "... has a path when planning ends. The slope is what a robot's share gains with each "
        "number, in points; shares and slopes have Student's intervals over trials.",
    )
    rows: list[tuple[str, ...]] = []
    for method in METHODS:
        if method in about.reached:
            counts = np.array(about.reached[method], dtype=np.float64)
            shares = counts[None] / TRIALS_OF_PAPER
            rows.append(
                (
                    f"{method}, paper",
                    *(f"{count:.0f}" for count in counts),
                    f"{100 * shares.mean():.1f} %",
                    f"{100 * slope(shares):.1f}",
                )
            )
        table = results.reached(experiment, method)
        if not len(table):
            continue
        share = section.add(
            experiment, method, "goals reached", "share", each_trial(mean_of, table)
        )
        per_number = section.add(
            experiment, method, "slope of goals reached", "share per number",
            each_trial(slope, table),
        )  # fmt: skip
        counts = table.sum(axis=0)
        for robot, count in enumerate(counts.tolist(), 1):
            own = wilson(round(count), len(table))
            section.add(
                experiment, method, "goals reached", "share",
                Estimate(own.share, own.low, own.high, own.trials), str(robot),
            )  # fmt: skip
        rows.append(
            (
                f"**{method}, here**",
                *(f"{count:.0f}" for count in counts),
                percent(share),
                _points(per_number),
            )
        )
    numbers = [str(robot + 1) for robot in range(about.robots)]
    section.tables.append((("method", *numbers, "all", "slope [points]"), rows))
    section.pictures.append(
        (picture_of(experiment), "Goals reached by number, here and in the paper")
    )
    if trials:
        _judge_success(section, results, experiment)
    return section


def _judge_success(section: Section, results: Results, experiment: str) -> None:
    reached = {method: results.reached(experiment, method) for method in METHODS}
    where = TABLES[experiment]
    paper = EXPERIMENTS[experiment].reached
    for method in (PLAIN, ANYTIME):
        found = each_trial(slope, reached[method])
        section.verdicts.append(
            Verdict(
                where,
                f"{experiment}: with {method}, higher numbers reach their goals less often",
                less(found, 0.0),
                f"points per number: {_points(found)}",
            )
        )
    found = each_trial(slope, reached[INASH], reached[PLAIN])
    section.add(
        experiment, f"{INASH} - {PLAIN}", "slope of goals reached", "share per number", found
    )
    section.verdicts.append(
        Verdict(
            where,
            f"{experiment}: iNash shares the burden: success falls less with the number than with "
            f"{PLAIN}",
            more(found, 0.0),
            f"points per number, iNash less {PLAIN}: {_points(found)}",
        )
    )
    for one, other in ((PLAIN, INASH), (ANYTIME, INASH), (ANYTIME, PLAIN)):
        found = each_trial(mean_of, reached[one], reached[other])
        section.add(experiment, f"{one} - {other}", "goals reached", "share", found)
        theirs = 5 * (np.mean(paper[one]) - np.mean(paper[other]))
        section.verdicts.append(
            Verdict(
                where,
                f"{experiment}: {one} reaches more goals than {other}",
                more(found, 0.0),
                f"points more: {_points(found)}; in the paper {theirs:.1f}",
            )
        )
    good = reached[OURS]
    found = share_of((good == 1).ravel().tolist())  # all of them are no interval of means
    best = float(np.mean(paper[ANYTIME])) / TRIALS_OF_PAPER
    section.verdicts.append(
        Verdict(
            "beyond the paper",
            f"{experiment}: ours reaches more goals than any method in the paper's table",
            more(found, best),
            f"{percent(found)}, robots as if independent; the paper's best {100 * best:.1f} %",
        )
    )


def lengths(results: Results, experiment: str) -> Section:
    """How much longer paths are than alone, by number, and how evenly that is shared."""
    about = EXPERIMENTS[experiment]
    section = Section(
        f"{about.title}: path lengths",
        "Means, over the trials in which a robot has a path, of its length over the least on its "
        "own final graph with nobody about; the paper's lengths are not in the copy at hand. "
        "Robots without a path do not count, so a method that reaches fewer goals may look better. "
        "The three methods of the paper have the same graphs in a trial; those of ours have edges "
        "in both directions and straightened paths, so its ratios have another, smaller base: "
        "metres compare. The spread is the largest of the robots' means less the smallest. It is "
        "never below 0, so its interval lies high; differences between methods decide. Intervals "
        "are bootstraps over trials.",
    )
    ratio_rows: list[tuple[str, ...]] = []
    fair_rows: list[tuple[str, ...]] = []
    for method in METHODS:
        ratios = results.ratios(experiment, method)
        if not len(ratios):
            continue
        cells: list[str] = []
        for robot in range(about.robots):
            own = over_trials(mean_of, ratios[:, robot : robot + 1])
            section.add(experiment, method, "length over solo", "ratio", own, str(robot + 1))
            cells.append(estimate(own))
        ratio_rows.append((method, *cells))
        metres = section.add(
            experiment, method, "length", "m",
            over_trials(mean_of, results.lengths(experiment, method)),
        )  # fmt: skip
        over = section.add(
            experiment, method, "length over solo", "ratio", over_trials(mean_of, ratios)
        )
        rise = section.add(
            experiment, method, "slope of length over solo", "ratio per number",
            over_trials(slope, ratios),
        )  # fmt: skip
        apart = section.add(
            experiment, method, "spread of length over solo", "ratio", over_trials(spread, ratios)
        )
        goals = section.add(
            experiment, method, "spread of goals reached", "share",
            over_trials(spread, results.reached(experiment, method)),
        )  # fmt: skip
        fair_rows.append(
            (
                method,
                estimate(metres),
                estimate(over),
                estimate(rise),
                estimate(apart),
                percent(goals),
            )
        )
    numbers = [str(robot + 1) for robot in range(about.robots)]
    section.tables.append((("length over solo", *numbers), ratio_rows))
    section.tables.append(
        (
            (
                "method", "length [m]", "over solo", "slope per number", "spread over numbers",
                "spread of goals reached",
            ),
            fair_rows,
        )
    )  # fmt: skip
    if ratio_rows:
        _judge_lengths(section, results, experiment)
    return section


def _judge_lengths(section: Section, results: Results, experiment: str) -> None:
    ratios = {method: results.ratios(experiment, method) for method in METHODS}
    found = over_trials(slope, ratios[PLAIN])
    section.verdicts.append(
        Verdict(
            "experiments, text",
            f"{experiment}: with {PLAIN}, lower numbers have shorter paths",
            more(found, 0.0),
            f"length over solo per number: {estimate(found)}",
        )
    )
    for measure, statistic in (("slope", slope), ("spread", spread)):
        found = over_trials(statistic, ratios[INASH], ratios[PLAIN])
        section.add(
            experiment, f"{INASH} - {PLAIN}", f"{measure} of length over solo", "ratio", found
        )
        what = "rise less with the number" if measure == "slope" else "are more even over numbers"
        section.verdicts.append(
            Verdict(
                "experiments, text",
                f"{experiment}: iNash shares the burden: lengths over solo {what} than with "
                f"{PLAIN}",
                less(found, 0.0),
                f"{measure}, iNash less {PLAIN}: {estimate(found)}",
            )
        )
    longer = paired_difference(ratios[INASH], ratios[PLAIN])
    if longer is not None:
        section.add(experiment, f"{INASH} - {PLAIN}", "length over solo", "ratio", longer)
        section.verdicts.append(
            Verdict(
                "experiments, text",
                f"{experiment}: iNash paths are longer than those of {PLAIN}, on the mean",
                more(longer, 0.0),
                f"length over solo, iNash less {PLAIN}, robots that have both: {estimate(longer)}",
            )
        )


SECTIONS: Sequence[Callable[[Results], Section]] = (
    *(
        (lambda results, name=name, make=make: make(results, name))
        for name in EXPERIMENTS
        for make in (success, lengths)
    ),
    equilibria,
    prices,
    messages,
    checks,
    verified,
)
"""In the order of the page."""


def _points(found: Estimate) -> str:
    """A share, or a difference of shares, in points."""
    return estimate(Estimate(100 * found.value, 100 * found.low, 100 * found.high, found.n))
