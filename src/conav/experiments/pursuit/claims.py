"""What the paper says, and whether it holds here: exploring in turn, messages, all sections."""

from collections.abc import Callable, Sequence
from statistics import median
from typing import Any

import numpy as np

from conav.experiments.inash.results import less
from conav.experiments.potential_games.report import estimate, number
from conav.experiments.pursuit.interleaving import BOUNDS, Cleared, against_exploring_first
from conav.experiments.pursuit.message_cost import round_bound
from conav.experiments.pursuit.part_claims import graphs, orders
from conav.experiments.pursuit.results import (
    Results,
    Section,
    always,
    mean_of,
    ratio_of,
)
from conav.experiments.pursuit.team_claims import labels, team_sizes
from conav.experiments.pursuit.world import (
    INTERLEAVING,
    MESSAGES,
    is_random,
)


def interleaving(results: Results) -> Section:
    """Distance, time, team and recontaminations for each exploration depth bound."""
    section = Section(
        "Exploring and clearing in turn",
        "Floors that nobody knows, with each exploration depth bound, by `unknown-map`. The ratio "
        "is the distance over that of a team of the same size that explores everything first; its "
        "geometric mean and Student's interval are over random floors. Medians are over all floors "
        "that were captured. Recontaminations are drives after which something clear was "
        "contaminated again.",
        pictures=[("interleaving.png", "Ratios of distances by exploration depth bound")],
    )
    cleared = [Cleared(**row) for row in results.rows(INTERLEAVING)]
    compared = {one.edb: one for one in against_exploring_first(cleared)}
    table: list[tuple[str, ...]] = []
    for edb in BOUNDS:
        own = [one for one in cleared if one.edb == edb]
        captured = [one for one in own if one.verdict == "captured"]
        if not captured:
            continue
        middle = [
            number(median(values))
            for values in (
                [one.distance_m for one in captured],
                [one.time_s for one in captured],
                [float(one.recontaminations) for one in captured],
            )
        ]
        cells = ["1", "-", "-"]
        if edb in compared:
            ratios = compared[edb].ratios
            found = ratio_of(
                [one for floor, one in ratios.items() if is_random(floor)],
                [1.0] * sum(map(is_random, ratios)),
            )
            section.add(INTERLEAVING, f"edb {edb}", "distance over exploring first", "ratio", found)
            longest = max(ratios, key=lambda floor: ratios[floor], default="")
            cells = [
                estimate(found),
                f"{sum(one < 1 - 1e-9 for one in ratios.values())} of {len(ratios)}",
                f"`{longest}` {number(ratios[longest])}" if longest else "-",
            ]
            section.judge(
                "conclusion",
                f"edb {edb}: exploring and clearing in turn shortens the distance",
                less(found, 1.0),
                f"distance over that of exploring first: {estimate(found)}",
            )
        sizes = [one.pursuers for one in captured]
        table.append(
            (
                str(edb),
                f"{len(captured)} of {len(own)}",
                *middle,
                f"{min(sizes)} to {max(sizes)}",
                *cells,
            )
        )
    if compared:
        others = sum(len(one.other_teams) for one in compared.values())
        pairs = others + sum(len(one.ratios) for one in compared.values())
        section.judge(
            "beyond the paper",
            "the bound does not change the size of the team",
            always([not one.other_teams for one in compared.values()]),
            f"other sizes in {others} of {pairs} pairs of runs",
        )
    section.tables.append(
        (
            (
                "edb", "captured", "distance [m]", "time [s]", "recontaminations", "pursuers",
                "ratio", "shorter on", "longest",
            ),
            table,
        )
    )  # fmt: skip
    return section


def messages(results: Results) -> Section:
    """Messages of the protocol over the size of the team."""
    section = Section(
        "Messages",
        "By `delegation` with teams of which all stand ready from the beginning; the team may "
        "grow. The exponent is the slope of log messages over log pursuers on a floor, and its "
        "mean with Student's interval is over random floors on which help was asked for.",
        pictures=[("messages.png", "Messages over team size")],
    )
    by_floor: dict[str, list[dict[str, Any]]] = {}
    rows = results.rows(MESSAGES)
    for row in rows:
        if row["messages"]:
            by_floor.setdefault(row["floor"], []).append(row)
    section.tables.append(
        (
            (
                "floor", "pursuers", "calls for help", "messages", "of the longest round",
                "at most", "bytes",
            ),
            [
                (
                    f"`{floor}`",
                    str(row["pursuers"]),
                    str(row["deliberations"]),
                    str(row["messages"]),
                    str(row["longest_round"]),
                    str(round_bound(row["pursuers"])),
                    str(row["size_bytes"]),
                )
                for floor, own in by_floor.items()
                if not is_random(floor)
                for row in own
            ],
        )
    )  # fmt: skip
    slopes = [exponent(own) for floor, own in by_floor.items() if is_random(floor) and len(own) > 1]
    found = section.add(MESSAGES, "delegation", "exponent of messages", "", mean_of(slopes))
    section.judge(
        "conclusion",
        "messages are O(n²) in the number of pursuers",
        less(found, 2.0),
        f"exponent over 3 to 24 pursuers, {found.n} floors: {estimate(found)}",
    )
    asked = [row for own in by_floor.values() for row in own]
    kept = [row["longest_round"] <= round_bound(row["pursuers"]) for row in asked]
    section.judge(
        "beyond the paper",
        "a round takes at most 7 (n - 1) + 1 messages",
        always(kept),
        f"{sum(kept)} of {len(kept)} runs with calls for help",
    )
    clear = [row["captured"] for row in rows]
    section.judge(
        "remarks",
        "what the team calls clear is clear",
        always(clear),
        f"{sum(clear)} of {len(clear)} runs captured by the verifier",
    )
    return section


def exponent(rows: Sequence[dict[str, Any]]) -> float:
    """The slope of log messages over log pursuers, by least squares."""
    x = np.log([row["pursuers"] for row in rows])
    y = np.log([row["messages"] for row in rows])
    x = x - x.mean()
    return float((x * y).sum() / (x * x).sum())


SECTIONS: Sequence[Callable[[Results], Section]] = (
    labels,
    interleaving,
    graphs,
    orders,
    messages,
    team_sizes,
)
"""In the order of the page."""
