"""How numbers, groups and tables are written for people, on a terminal and in Markdown."""

from collections.abc import Iterable, Sequence
from math import ceil, floor, isfinite

from conav.experiments.compare.cases import OWN_RADIO, Group, Study
from conav.experiments.compare.tables import MEASURES, SHARES, Line, Ratio, Table, Times, Total
from conav.intervals import Estimate
from conav.robots.radio import RADIOS
from conav.simulation.finish_bounds import NO_BOUNDS

AT_LEAST = "\N{GREATER-THAN OR EQUAL TO}"
AT_MOST = "\N{LESS-THAN OR EQUAL TO}"
ABOUT = "\N{ALMOST EQUAL TO}"

Rows = list[tuple[str, ...]]  # of a table, the heading first


def number(value: float) -> str:
    """A number as people read it, to three digits.

    >>> [number(value) for value in (12345.0, 123.4, 12.34, 1.234, 0.1234, 0.0)]
    ['12,345', '123', '12.3', '1.23', '0.12', '0']
    """
    if value == 0:
        return "0"
    size = abs(value)
    return f"{value:,.{0 if size >= 99.95 else 1 if size >= 9.995 else 2}f}"


def interval(found: Estimate) -> str:
    """A value with its interval, where it has one and it says more than the value."""
    if not (isfinite(found.low) and isfinite(found.high)) or found.low == found.high:
        return number(found.value)
    return f"{number(found.value)} [{number(found.low)}, {number(found.high)}]"


def times_text(found: Times, limit_s: float) -> str:
    """A median time with its interval, marked where it is only known to be at least that."""
    median = found.median
    text = (AT_LEAST if found.at_least else "") + number(median.value)
    if not (isfinite(median.low) and isfinite(median.high)) or median.low == median.high:
        return text
    low, high = ((AT_LEAST if end >= limit_s else "") + number(end) for end in median[1:3])
    return f"{text} [{low}, {high}]"


def ratio_text(found: Ratio | None) -> str:
    """A ratio with its interval, marked where runs without an end only bound it."""
    if found is None:
        return "-"
    signs = {
        (True, False): AT_LEAST,
        (False, True): AT_MOST,
        (True, True): ABOUT,
    }
    return signs.get((found.open_above, found.open_below), "") + interval(found.estimate)


def group_text(study: Study, group: Group) -> str:
    """A group in words."""
    return ", ".join((group.map, *(part_text(study, name, value) for name, value in _parts(group))))


def short_text(study: Study, group: Group, *, without: str = "") -> str:
    """A group in the words that tell it from the study's other groups, but for one of them."""
    parts = [group.map] if len(study.maps) > 1 and without != "map" else []
    several = {"robots": study.robots, "range_m": study.ranges_m, "radio": study.radios}
    parts += [
        part_text(study, name, value)
        for name, value in _parts(group)
        if len(several[name]) > 1 and name != without
    ]
    return ", ".join(parts)


def part_text(study: Study, name: str, value: float | str) -> str:
    """One property of a group in words."""
    if name == "robots":
        return f"{value} robots" if value != 1 else "1 robot"
    if name == "range_m":
        return f"range {value:g} m"
    if value == OWN_RADIO:
        own = [f"{team.name} {team.radio}" for team in study.teams if team.radio]
        return f"radio perfect ({', '.join(own)})"
    return f"radio {value}" if value in RADIOS else f"radio {value} m"


def _parts(group: Group) -> Iterable[tuple[str, float | str]]:
    return (("robots", group.robots), ("range_m", group.range_m), ("radio", group.radio))


def group_rows(study: Study, table: Table) -> Rows:
    """The times of a group's strategies."""
    rows: Rows = [
        ("rank", "strategy", *(f"T{share} [s]" for share in SHARES), "all seen", *_best(study)),
    ]
    for line in table.lines:
        times = (times_text(line.times[share], study.world.max_time_s) for share in SHARES)
        best = [best_text(line.best) for _ in _best(study)]
        rows.append((str(line.rank), line.strategy, *times, finished_text(line), *best))
    return rows


def measure_rows(study: Study, table: Table) -> Rows:
    """The other measures of a group's strategies."""
    rows: Rows = [
        (
            "strategy",
            *(heading for heading, _ in MEASURES.values()),
            f"T100 over {study.teams[0].name}",
        )
    ]
    for line in table.lines:
        medians = (interval(line.measures[name]) for name in MEASURES)
        rows.append((line.strategy, *medians, ratio_text(line.ratio)))
    return rows


def total_rows(study: Study, found: Sequence[Total]) -> Rows:
    """The strategies over all groups."""
    rows: Rows = [
        ("strategy", *(f"T{share}" for share in SHARES), "mean rank", "all seen", *_best(study))
    ]
    for total in found:
        ratios = (ratio_text(total.ratios.get(share)) for share in SHARES)
        best = [best_text(total.best) for _ in _best(study)]
        rows.append(
            (total.strategy, *ratios, f"{total.mean_rank:.2f}", finished_text(total), *best)
        )
    return rows


def _best(study: Study) -> list[str]:
    """The heading of the column that tells how far from the best possible; none without bounds."""
    return [] if study.effort == NO_BOUNDS else ["T100 over best possible"]


def best_text(found: tuple[float, float] | None) -> str:
    """Between what a ratio to the best possible lies, rounded outwards.

    >>> best_text((1.239, 2.301)), best_text((1.0, 1.0)), best_text((1.5, float("inf")))
    ('1.23 to 2.31', '1', '≥1.5')
    """
    if found is None:
        return "-"
    low = f"{floor(100 * found[0] + 1e-9) / 100:g}"
    if not isfinite(found[1]):
        return AT_LEAST + low
    high = f"{ceil(100 * found[1] - 1e-9) / 100:g}"
    return low if low == high else f"{low} to {high}"


def finished_text(line: Line | Total) -> str:
    """How many runs saw everything, and how many could not be played."""
    text = f"{line.finished} of {line.runs}"
    return text + f", {line.failed} failed" if line.failed else text


def aligned(rows: Rows, indent: str = "  ") -> str:
    """The table for a terminal."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return "\n".join(
        (
            indent + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    )


def markdown(rows: Rows) -> str:
    """The table for a page."""
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    lines.insert(1, "|" + "---|" * len(rows[0]))
    return "\n".join(lines)
