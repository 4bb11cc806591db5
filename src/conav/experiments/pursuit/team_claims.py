"""What the paper's labels claim, and how many pursuers floors take: sections of the page."""

from math import log2, sqrt
from typing import Any

from conav.experiments.inash.results import less
from conav.experiments.potential_games.report import HELD, NOT_HELD, OPEN, estimate
from conav.experiments.pursuit.results import (
    Results,
    Section,
    always,
    ratio_of,
)
from conav.experiments.pursuit.world import (
    METHODS,
    PAPER_LIMIT,
    PAPER_MOST,
    TEAMS,
    WALLS,
    is_random,
)


def by_method(results: Results) -> dict[str, dict[str, dict[str, Any]]]:
    """Rows of team sizes by method, then floor."""
    return {
        method: {row["floor"]: row for row in results.rows(TEAMS, method)} for method in METHODS
    }


def captured(row: dict[str, Any] | None) -> bool:
    """Whether there is such a run, and the verifier says that the floor is clear."""
    return row is not None and row["verdict"] == "captured"


def labels(results: Results) -> Section:
    """Whether what labels of critical vertices call clear is clear."""
    section = Section(
        "What labels of vertices claim",
        "Known floors, cleared with the paper's labels, on the whole pursuit graph and split at "
        "nodes of highest degree. A claim is a run that ended with all labels clear; the verifier, "
        f"with code of its own, decides whether somebody can escape. A graph of more than "
        f"{PAPER_LIMIT:,} states, or a team of more than {PAPER_MOST} on the whole graph, counts "
        "as no plan. One more floor, of nine corners, has three pursuers who begin where they see "
        "all walls, and not a triangle in the middle.",
    )
    rows = by_method(results)
    table: list[tuple[str, ...]] = []
    for method in METHODS[3:]:
        every = [*rows[method].values(), *results.rows(WALLS, method)]
        claims = [row for row in every if row["verdict"]]
        wrong = [row for row in claims if row["verdict"] == "escapes"]
        undecided = sum(row["verdict"] == "unknown" for row in claims)
        table.append(
            (
                method,
                str(len(every)),
                str(len(claims)),
                str(len(claims) - len(wrong) - undecided),
                str(len(wrong)),
                str(undecided),
            )
        )
        verdict = NOT_HELD if wrong else OPEN if undecided or not claims else HELD
        where = f", `{wrong[0]['floor']}` for one" if wrong else ""
        section.judge(
            "section 3.2" if method == METHODS[3] else "section 3.3",
            f"{method}: when all critical vertices are clear no evader is left",
            verdict,
            f"an evader escapes in {len(wrong)} of {len(claims)} claims{where}",
        )
    section.tables.append(
        (("labels", "floors", "claims", "captured", "escapes", "not decided"), table)
    )
    alone = [
        (floor, rows["paper labels"][floor])
        for floor, row in rows["known-map"].items()
        if captured(row) and row["pursuers"] == 1 and floor in rows["paper labels"]
    ]
    found = [row["pursuers"] == 1 and bool(row["verdict"]) for _, row in alone]
    missed = [floor for (floor, _), one in zip(alone, found, strict=True) if not one]
    section.judge(
        "section 3.2",
        "where a solution for one pursuer exists the pursuit graph has it",
        always(found),
        f"on {sum(found)} of {len(found)} floors that one pursuer clears"
        + (f"; not on `{missed[0]}`" if missed else ""),
    )
    return section


def team_sizes(results: Results) -> Section:
    """How many pursuers floors take, by method and along families."""
    section = Section(
        "Team sizes",
        "Pursuers by method; those in brackets were not captured, and - is no plan. `known-map` "
        "looks for few pursuers, `guards` is the fewest standing ones on critical vertices, "
        "`delegation` sends one more when nobody can help. The bound of [Guibas1999], which the "
        "paper cites, is in order of magnitude: n corners, h holes. `triples:k` was made so that "
        "k pursuers are needed, which is proved here up to 2 only.",
        pictures=[("teams.png", "Pursuers over sqrt h + log2 n")],
    )
    rows = by_method(results)
    table: list[tuple[str, ...]] = []
    for floor, one in rows["known-map"].items():
        if is_random(floor):
            continue
        cells = [_size(rows[method].get(floor)) for method in METHODS]
        bound = sqrt(one["holes"]) + log2(one["corners"])
        table.append(
            (f"`{floor}`", str(one["corners"]), str(one["holes"]), f"{bound:.1f}",
             str(one["lower_bound"]), *cells)
        )  # fmt: skip
    section.tables.append((("floor", "n", "h", "sqrt h + log2 n", "at least", *METHODS), table))
    known = {floor: row for floor, row in rows["known-map"].items() if captured(row)}
    fits = [row["pursuers"] <= sqrt(row["holes"]) + log2(row["corners"]) for row in known.values()]
    section.judge(
        "section 2",
        "O(sqrt h + log n) pursuers suffice, here at most sqrt h + log2 n",
        always(fits),
        f"on {sum(fits)} of {len(fits)} floors, by `known-map`",
    )
    triples = [row for floor, row in known.items() if floor.startswith("triples:")]
    grown = [row["pursuers"] <= int(row["floor"].split(":")[1]) for row in triples]
    section.judge(
        "section 2",
        "`triples:k`: corners grow threefold, pursuers by one: log n",
        always(grown) if len(grown) > 1 else OPEN,
        _family(triples),
    )
    streets = [row for floor, row in known.items() if floor.startswith("streets:")]
    grown = [row["pursuers"] <= 1 + 2 * sqrt(row["holes"]) for row in streets]
    section.judge(
        "section 2",
        "`streets:k`, (k - 1)² blocks: pursuers grow as sqrt h, here at most 1 + 2 sqrt h",
        always(grown) if len(grown) > 1 else OPEN,
        _family(streets),
    )
    _against(section, rows, "guards", "introduction", "a team that moves is smaller than one of "
             "standing guards", over="guards")  # fmt: skip
    _minimal(section, rows)
    return section


def _against(
    section: Section,
    rows: dict[str, dict[str, dict[str, Any]]],
    other: str,
    source: str,
    claim: str,
    *,
    over: str,
) -> None:
    pairs = [
        (row["pursuers"], rows[other][floor]["pursuers"])
        for floor, row in rows["delegation"].items()
        if is_random(floor) and captured(row) and captured(rows[other].get(floor))
    ]
    found = section.add(
        TEAMS, f"delegation over {over}", "pursuers", "ratio",
        ratio_of([float(a) for a, _ in pairs], [float(b) for _, b in pairs]),
    )  # fmt: skip
    section.judge(
        source, claim, less(found, 1.0),
        f"pursuers, delegation over {over}, {found.n} random floors: {estimate(found)}",
    )  # fmt: skip


def _minimal(section: Section, rows: dict[str, dict[str, dict[str, Any]]]) -> None:
    """Whether cooperation takes the fewest pursuers."""
    pairs = [
        (floor, row["pursuers"], rows["known-map"][floor])
        for floor, row in rows["delegation"].items()
        if captured(row) and captured(rows["known-map"].get(floor))
    ]
    larger = [(floor, size) for floor, size, few in pairs if size > few["pursuers"]]
    proved = [size <= few["lower_bound"] for _, size, few in pairs]
    where = f"; more on `{larger[0][0]}`, {larger[0][1]}" if larger else ""
    section.judge(
        "conclusion",
        "cooperation takes the fewest pursuers there can be",
        NOT_HELD if larger else HELD if proved and all(proved) else OPEN,
        f"as few as `known-map` on {len(pairs) - len(larger)} of {len(pairs)} floors, proved "
        f"least on {sum(proved)}{where}",
    )


def _family(rows: list[dict[str, Any]]) -> str:
    return ", ".join(
        f"`{row['floor']}` n {row['corners']}, h {row['holes']}: {row['pursuers']}" for row in rows
    )


def _size(row: dict[str, Any] | None) -> str:
    if row is None or not row["verdict"]:
        return "-"
    return str(row["pursuers"]) if captured(row) else f"({row['pursuers']})"
