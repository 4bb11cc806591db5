"""What the paper says of the game, its prices and its burden: sections of the page."""

from functools import partial
from math import inf, isnan

import numpy as np

from conav.experiments.inash.results import (
    Results,
    Row,
    Section,
    exponent,
    over_trials,
    share_of,
)
from conav.experiments.inash.world import (
    EXPERIMENTS,
    INASH,
    METHODS,
    ON_PAPER_GRAPHS,
    PLAIN,
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
from conav.intervals import mean_interval
from conav.planning.grid_prices import price_table


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
            even = share_of([one.in_equilibrium for one in plans])
            rose = share_of([one.rises > 0 for one in plans])
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


def _exact(name: str, measure: str, slack: int, value: float | None) -> Row:
    known = float("nan") if value is None else value
    return Row(f"{name}, slack {slack}", "exact", measure, "", "", known, known, known, 1)
