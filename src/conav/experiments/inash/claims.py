"""What the paper claims and its tables show, and whether it holds here: sections of the page."""

from collections.abc import Callable, Sequence
from functools import partial
from math import inf, isnan

import numpy as np

from conav.experiments.inash.figures import picture_of
from conav.experiments.inash.results import (
    Results,
    Row,
    Section,
    each_trial,
    exponent,
    less,
    mean_of,
    more,
    over_trials,
    paired_difference,
    slope,
    spread,
)
from conav.experiments.inash.world import (
    ANYTIME,
    EXPERIMENTS,
    INASH,
    METHODS,
    ON_PAPER_GRAPHS,
    OURS,
    PLAIN,
    TRIALS_OF_PAPER,
    team_sizes,
)
from conav.experiments.potential_games.report import (
    HELD,
    NOT_HELD,
    OPEN,
    Verdict,
    estimate,
    number,
    percent,
)
from conav.intervals import Estimate, mean_interval, wilson
from conav.planning.grid_prices import price_table

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
    found = _share((good == 1).ravel().tolist())  # all of them are no interval of means
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


def equilibria(results: Results) -> Section:
    """Whether plans end in equilibrium, and costs only fall on the way."""
    section = Section(
        "Equilibria",
        "Trials in which no robot can do better alone on its final graph, a path where it has none "
        "included; and trials in which some robot's cost rose, or its path was lost, from one "
        "iteration to the next. Gains are the planner's account; those counted under *again* the "
        "verifier found anew, from the vertices, for the paper's three methods.\n\n"
        "With best answers a prioritized plan is an equilibrium on its graphs: each robot has its "
        "best path past those before it, and those after it only take paths away from it. For the "
        "same reason the any-time method, looked at when it ends, has the plain one's plan: "
        "whoever's path stands had no better one past those before it. The paper's two methods "
        "differ in their results, so at least one of them must have had other graphs or other "
        "answers.",
    )
    rows: list[tuple[str, ...]] = []
    for experiment in EXPERIMENTS:
        for method in METHODS:
            plans = results.plans(experiment, method)
            if not plans:
                continue
            even = _share([one.in_equilibrium for one in plans])
            rose = _share([one.rises > 0 for one in plans])
            section.add(experiment, method, "ended in equilibrium", "share of trials", even)
            section.add(experiment, method, "a cost rose", "share of trials", rose)
            rows.append(
                (
                    experiment,
                    method,
                    percent(even),
                    str(sum(one.gains_checked for one in plans)),
                    "-" if method == PLAIN else percent(rose),
                )
            )
            if method == INASH:
                section.verdicts += [
                    Verdict(
                        "convergence theorem",
                        f"{experiment}: with iNash nobody's cost ever rises",
                        HELD if rose.value == 0 else NOT_HELD,
                        f"trials with a rise: {percent(rose)}",
                    ),
                    Verdict(
                        "convergence theorem",
                        f"{experiment}: iNash ends in a Nash equilibrium, on its graphs",
                        HELD if even.value == 1 else NOT_HELD,
                        f"trials: {percent(even)}",
                    ),
                ]
            elif method in ON_PAPER_GRAPHS:
                section.verdicts.append(
                    Verdict(
                        "experiments",
                        f"{experiment}: {method} does not always end in a Nash equilibrium, on its "
                        "graphs",
                        NOT_HELD if even.value == 1 else HELD,
                        f"trials in equilibrium: {percent(even)}",
                    )
                )
    section.tables.append(
        (("experiment", "method", "in equilibrium", "again", "a cost rose"), rows)
    )
    return section


def prices(results: Results) -> Section:
    """The prices of anarchy and stability where they can be had exactly."""
    del results  # nothing was sampled for it
    section = Section(
        "Prices of anarchy and stability",
        "Exact, by going through all equilibria of small games on grids; costs are steps until "
        "arrival, and the slack says how many steps above its solo cost a robot's paths may take "
        "([prices](../../planners/prices.md)).",
    )
    found = price_table()
    rows: list[tuple[str, ...]] = []
    for row in found:
        stable, anarchy = row.found.price_of_stability, row.found.price_of_anarchy
        section.rows += [
            _exact(row.name, "price of stability", row.slack, stable),
            _exact(row.name, "price of anarchy", row.slack, anarchy),
        ]
        rows.append(
            (
                row.name,
                str(row.slack),
                f"{row.found.optimum:g}",
                f"{row.found.best_equilibrium:g} / {row.found.worst_equilibrium:g}",
                "-" if stable is None else f"{stable:g}",
                "-" if anarchy is None else f"{anarchy:.2f}",
            )
        )
    section.tables.append(
        (
            (
                "instance", "slack", "optimum", "best / worst equilibrium", "price of stability",
                "price of anarchy",
            ),
            rows,
        )
    )  # fmt: skip
    stable = [row.found.price_of_stability for row in found]
    section.verdicts.append(
        Verdict(
            "lemma 1",
            "the price of stability is 1",
            HELD if all(one == 1 for one in stable) else NOT_HELD,
            f"exactly 1 in {sum(one == 1 for one in stable)} of {len(stable)} games",
        )
    )
    return section


def messages(results: Results) -> Section:
    """Paths announced in an iteration."""
    section = Section(
        "Messages",
        "Paths that all robots announce in an iteration of iNash: everybody's before a round, and "
        "each new one. The most in an iteration is counted from the costs before and after it, not "
        "by the planner.",
    )
    rows: list[tuple[str, ...]] = []
    for experiment in EXPERIMENTS:
        good = True
        most = 0
        for robots in team_sizes(experiment):
            plans = results.plans(experiment, INASH, robots)
            if not plans:
                continue
            most = max(one.most_messages for one in plans)
            good = good and most <= 2 * robots
            mean = mean_interval([one.messages / one.iterations for one in plans])
            section.add(
                experiment, INASH, f"messages in an iteration, {robots} robots", "messages", mean
            )
            rows.append((experiment, str(robots), estimate(mean), str(most), str(2 * robots)))
        if most:
            section.verdicts.append(
                Verdict(
                    "lemma on communication",
                    f"{experiment}: at most two messages for each robot in an iteration",
                    HELD if good else NOT_HELD,
                    f"the most with {EXPERIMENTS[experiment].robots} robots: {most} of "
                    f"{2 * EXPERIMENTS[experiment].robots}",
                )
            )
    section.tables.append((("experiment", "robots", "mean", "most", "twice the robots"), rows))
    return section


def checks(results: Results) -> Section:
    """How collision checks grow with the number of robots."""
    section = Section(
        "Collision checks",
        "The paper counts calls that test a path against all others' in an iteration: the number "
        "of paths of all graphs, linear in robots and exponential in vertices. Here paths are not "
        "gone through; a check is an edge, or a rest, tested against all others' paths, and it is "
        "made only where no cheaper way is clear. So there are few, and more where more is in the "
        "way: the paper's lemma is a bound on another number, and stands. Teams are the first "
        "robots of the whole one. The exponent is the slope of the logarithm of mean checks over "
        "that of robots; 1 is linear.",
    )
    rows: list[tuple[str, ...]] = []
    for experiment in EXPERIMENTS:
        counts: list[list[float]] = []
        sizes: list[int] = []
        for robots in team_sizes(experiment):
            plans = results.plans(experiment, INASH, robots)
            if len(plans) < max(len(results.paired(experiment)), 1):
                continue
            per = [one.checks / one.iterations for one in plans]
            mean = mean_interval(per)
            section.add(
                experiment, INASH, f"checks in an iteration, {robots} robots", "checks", mean
            )
            rows.append((experiment, str(robots), estimate(mean), number(mean.value / robots)))
            counts.append(per)
            sizes.append(robots)
        if len(sizes) < 2:
            continue
        growth = partial(exponent, sizes=sizes)
        found = section.add(
            experiment, INASH, "exponent of checks in robots", "",
            over_trials(growth, np.array(counts).T),
        )  # fmt: skip
        section.verdicts.append(
            Verdict(
                "lemma on complexity, another count",
                f"{experiment}: checks in an iteration grow no faster than linearly with robots",
                OPEN
                if isnan(found.value)
                else HELD
                if found.high <= 1.0
                else NOT_HELD
                if found.low > 1.0
                else OPEN,
                f"exponent over {sizes[0]} to {sizes[-1]} robots: {estimate(found)}",
            )
        )
    section.tables.append((("experiment", "robots", "checks", "for each robot"), rows))
    return section


def verified(results: Results) -> Section:
    """What the verifier says of all plans."""
    section = Section(
        "Verified",
        "Every plan is looked over by the functions of `conav verify`, which share nothing with "
        "the planners: starts, joints, speeds, arrivals, tasks, walls, and the distance of every "
        "two robots at every time. Robots without a path are not there, as in the paper's game, "
        "and robots vanish at their goals.",
    )
    rows: list[tuple[str, ...]] = []
    for experiment in EXPERIMENTS:
        for method in METHODS:
            plans = results.plans(experiment, method)
            if not plans:
                continue
            least = min((inf if one.clearance_m is None else one.clearance_m) for one in plans)
            broken = sum(bool(one.broken) for one in plans)
            rows.append((experiment, method, str(len(plans)), str(broken), f"{least:.4f}"))
    section.tables.append(
        (("experiment", "method", "plans", "with a breach", "least clearance [m]"), rows)
    )
    return section


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


def _share(good: Sequence[bool]) -> Estimate:
    found = wilson(sum(good), len(good))
    return Estimate(found.share, found.low, found.high, found.trials)


def _points(found: Estimate) -> str:
    """A share, or a difference of shares, in points."""
    return estimate(Estimate(100 * found.value, 100 * found.low, 100 * found.high, found.n))


def _exact(name: str, measure: str, slack: int, value: float | None) -> Row:
    known = float("nan") if value is None else value
    return Row(f"{name}, slack {slack}", "exact", measure, "", "", known, known, known, 1)
