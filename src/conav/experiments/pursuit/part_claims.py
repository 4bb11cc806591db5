"""What the paper says of parts: pursuit graphs whole and split, and parts one by one or at once."""

from math import log2
from typing import Any

from conav.experiments.inash.results import less, more
from conav.experiments.potential_games.report import OPEN, estimate, number
from conav.experiments.pursuit.results import (
    Results,
    Section,
    always,
    mean_of,
    randoms,
    ratio_of,
    was_split,
)
from conav.experiments.pursuit.world import GRAPHS, LABELS, ORDERS, is_random


def graphs(results: Results) -> Section:
    """Sizes of pursuit graphs of one pursuer, of whole floors and of parts."""
    section = Section(
        "Pursuit graphs, whole and split",
        "States of the pursuit graph of one pursuer, with labels of shadows, which are sound, and "
        "with the paper's; a graph ends at 20,000 states. n is the number of critical vertices, k "
        "that of parts. With places for the start too, a graph of n labels has at most "
        "(n + 1) 2^n states where each label is of a vertex; for shadows that is a question. "
        "Seconds are those of making the graphs, without finding the parts, and depend on the "
        "machine. With the paper's labels a part has the nodes that no guard sees, and one "
        "without a node is in no graph. Intervals are over random floors that were split.",
        pictures=[("graphs.png", "States of pursuit graphs over critical vertices")],
    )
    table: list[tuple[str, ...]] = []
    for kind in LABELS:
        rows = results.rows(GRAPHS, kind)
        split = [row for row in rows if was_split(row)]
        table += [_graph_cells(row) for row in rows if not is_random(row["floor"])]
        if not rows:
            continue
        fits = [row["whole"] <= (row["vertices"] + 1) * 2.0 ** row["vertices"] for row in rows]
        section.judge(
            "conclusion",
            f"{kind}: a pursuit graph has O(2^n) states, here at most (n + 1) 2^n",
            always(fits) if all(row["complete"] for row in rows) else OPEN,
            f"{sum(fits)} of {len(rows)} floors, "
            f"{sum(not row['complete'] for row in rows)} cut off at the limit",
        )
        rates = [log2(row["whole"]) / row["vertices"] for row in randoms(rows) if row["vertices"]]
        found = section.add(
            GRAPHS, kind, "log2 of states over n", "bits per vertex", mean_of(rates)
        )
        section.judge(
            "conclusion, read as a rate",
            f"{kind}: the states double with each critical vertex",
            more(found, 1.0 - 1e-9),
            f"log2 of states over n: {estimate(found)}",
        )
        fits = [
            row["parts_total"]
            <= (row["vertices"] + 1) * row["parts"] * 2.0 ** (row["vertices"] / row["parts"])
            for row in split
        ]
        section.judge(
            "conclusion",
            f"{kind}: k parts have O(k 2^(n/k)) states, here at most (n + 1) k 2^(n/k)",
            always(fits),
            f"{sum(fits)} of {len(fits)} floors that were split",
        )
        for measure, above, below in (
            ("states", "parts_total", "whole"),
            ("seconds", "parts_s", "whole_s"),
        ):
            own = [row for row in randoms(split) if row[below] > 0 and row[above] > 0]
            found = section.add(
                GRAPHS, kind, f"{measure} of all parts over the whole", "ratio",
                ratio_of([row[above] for row in own], [row[below] for row in own]),
            )  # fmt: skip
            section.judge(
                "conclusion",
                f"{kind}: splitting takes fewer {measure} than the whole floor's graph",
                less(found, 1.0),
                f"all parts over the whole, {found.n} floors: {estimate(found)}",
            )
    section.tables.append(
        (
            (
                "floor", "labels", "n", "whole", "k", "all parts", "largest part", "whole [s]",
                "parts [s]",
            ),
            table,
        )
    )  # fmt: skip
    return section


def _graph_cells(row: dict[str, Any]) -> tuple[str, ...]:
    whole = f"{row['whole']}" if row["complete"] else f"over {row['whole']}"
    return (
        f"`{row['floor']}`",
        row["labels"],
        str(row["vertices"]),
        whole,
        str(row["parts"]),
        str(row["parts_total"]),
        str(row["parts_largest"]),
        number(row["whole_s"]),
        number(row["parts_s"]),
    )


def orders(results: Results) -> Section:
    """Parts one after the other, or at once, and with one pursuer lost."""
    section = Section(
        "Parts in parallel, and a pursuer lost",
        "By `delegation`. Lost is the first guard, halfway between its coming and the end, or the "
        "first pursuer where nobody stands guard. Ratios are over random floors on which a guard "
        "was posted: with several pursuers when parts are cleared one after the other.",
    )
    rows = results.rows(ORDERS)
    by_floor: dict[str, dict[tuple[str, bool], dict[str, Any]]] = {}
    for row in rows:
        by_floor.setdefault(row["floor"], {})[row["order"], row["lost_s"] is not None] = row
    table = [
        (
            f"`{floor}`",
            order,
            str(own[order, False]["pursuers"]),
            number(own[order, False]["time_s"]),
            number(own[order, False]["distance_m"]),
            f"{own[order, True]['pursuers']}, {number(own[order, True]['time_s'])}",
            number(own[order, True]["recontaminated_m2"]),
        )
        for floor, own in by_floor.items()
        if not is_random(floor)
        for order in ("sequence", "parallel")
    ]
    section.tables.append(
        (
            (
                "floor", "order", "pursuers", "time [s]", "distance [m]",
                "with one lost: pursuers, time [s]", "contaminated again [m²]",
            ),
            table,
        )
    )  # fmt: skip
    parted = [
        own
        for floor, own in by_floor.items()
        if is_random(floor) and own["sequence", False]["pursuers"] > 1
    ]
    alone = [own["sequence", False] for own in parted]
    at_once = [own["parallel", False] for own in parted]
    for measure, unit, claim in (
        ("time_s", "time", "parts at once are cleared in less time than one after the other"),
        ("distance_m", "distance", "parts at once are cleared with less driving"),
        ("pursuers", "pursuers", "parts at once take more pursuers"),
    ):
        found = section.add(
            ORDERS, "parallel over sequence", unit, "ratio",
            ratio_of([row[measure] for row in at_once], [row[measure] for row in alone]),
        )  # fmt: skip
        section.judge(
            "remarks, parallelization" if unit == "time" else "beyond the paper",
            claim,
            (more if unit == "pursuers" else less)(found, 1.0),
            f"{unit}, parallel over sequence, {found.n} floors: {estimate(found)}",
        )
    lost = {order: [own[order, True] for own in parted] for order in ("sequence", "parallel")}
    slower = {
        order: ratio_of(
            [row["time_s"] for row in lost[order]],
            [own[order, False]["time_s"] for own in parted],
        )
        for order in lost
    }
    for order, found in slower.items():
        section.add(ORDERS, order, "time with one lost over without", "ratio", found)
    found = section.add(
        ORDERS, "parallel over sequence", "time with one lost", "ratio",
        ratio_of(
            [row["time_s"] for row in lost["parallel"]],
            [row["time_s"] for row in lost["sequence"]],
        ),
    )  # fmt: skip
    section.judge(
        "conclusion",
        "with a pursuer lost, parts at once are cleared in less time too",
        less(found, 1.0),
        f"time, parallel over sequence: {estimate(found)}; the loss multiplies it by "
        f"{estimate(slower['sequence'])} in sequence and {estimate(slower['parallel'])} in "
        "parallel",
    )
    clear = [row["captured"] for row in rows if row["lost_s"] is not None]
    section.judge(
        "conclusion",
        "a team that loses a pursuer clears the floor all the same",
        always(clear),
        f"{sum(clear)} of {len(clear)} runs, with one more sent where need be",
    )
    return section
