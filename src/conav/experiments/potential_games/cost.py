"""Section 3.1 measured: the cost of a decision beside that of frontier detection."""

from pathlib import Path

from conav.experiments.decision_cost import DecisionCost, cost_by_map_size, cost_by_range
from conav.experiments.detection_cost import Detection, detection_by_area
from conav.experiments.potential_games.lab import Lab
from conav.experiments.potential_games.report import HELD, NOT_HELD, Row, Section, number
from conav.experiments.timing import fit_power
from conav.pictures.plots import Series, save_points

AREAS = {
    "open": "open space",
    "blocks": "open space with blocks",
    "office": "an office",
    "winding": "one winding corridor",
}
FULL = ((1, 2, 4, 8, 16, 32, 64), (64, 256, 1024, 4096), (64, 128, 256, 512), (32, 64, 128, 180))
SMALL = ((1, 2, 4, 8), (64, 256), (32, 64), (16, 32))


def decision_cost(lab: Lab) -> Section:
    """Decisions against range and map size, frontier detection against explored area."""
    ranges, sides, areas, winding = FULL if lab.games >= 20 else SMALL
    budget = 0.2 if lab.games >= 20 else 0.01
    section = Section(
        "cost",
        "The cost of a decision",
        "Points looked at and sweeps are counted; microseconds are the best of many repetitions "
        "on the machine this page was made on. `squares` looks at the points of (16), `packed` at "
        "rows of 64-bit words, `kept` reads numbers that are lowered when a point is discovered, "
        "as games in bulk do. The second picture has frontier detection by deterministic value "
        "iteration as Burgard et al. (2000) describe it, over explored areas of several shapes, "
        "beside a search by distance (Dijkstra).",
        ("map", "sRange", "points", "words", "kept", "squares [us]", "packed [us]", "kept [us]"),
    )
    by_range = cost_by_range(ranges, budget_s=budget, progress=lab.progress)
    by_size = cost_by_map_size(sides, (2,), budget_s=budget, progress=lab.progress)
    for one in (*by_range, *by_size):
        section.table.append(
            (
                f"{one.side} x {one.side}",
                str(one.s_range),
                f"{one.points:,}",
                f"{one.words:,}",
                str(one.kept),
                number(one.squares_us),
                number(one.packed_us),
                number(one.kept_us),
            )
        )
        team = f"map {one.side} x {one.side}"
        for measure, value in (
            ("points per decision", one.points),
            ("words per decision", one.words),
            ("numbers per decision", one.kept),
        ):
            section.rows.append(_row(section, team, one.s_range, measure, value))
    detections: dict[str, list[Detection]] = {}
    for area, text in AREAS.items():
        found = detection_by_area(
            area,
            winding if area == "winding" else areas,
            budget_s=budget,
            limit_s=5.0,
            progress=lab.progress,
        )
        detections[text] = found
        for one in found:
            team = f"{text}, {one.explored} cells"
            section.rows.append(_row(section, team, 0, "sweeps of value iteration", one.sweeps))
            section.rows.append(_row(section, team, 0, "cells of value iteration", one.touched))
    _judge(section, by_range, by_size, detections)
    section.pictures.append(
        (
            "cost-range.png",
            "Cost of a decision against the sensor's range",
            lambda path: _draw_ranges(path, by_range),
        )
    )
    section.pictures.append(
        (
            "cost-detection.png",
            "Cost of frontier detection against the explored area",
            lambda path: _draw_detections(path, detections, by_range[1]),
        )
    )
    return section


def _row(section: Section, team: str, s_range: int, measure: str, value: float) -> Row:
    """A counter, which has no interval."""
    return Row(
        section.name, team, s_range, measure, "", float(value), float("nan"), float("nan"), 1
    )


def _judge(
    section: Section,
    by_range: list[DecisionCost],
    by_size: list[DecisionCost],
    detections: dict[str, list[Detection]],
) -> None:
    exact = all(one.points == one.expected_points for one in by_range)
    section.judge(
        "section 3.1",
        "a decision looks at 20 (sRange^2 + sRange) points",
        HELD if exact else NOT_HELD,
        ", ".join(f"{one.points:,} at sRange {one.s_range}" for one in by_range[:4]),
    )
    same = len({one.points for one in by_size}) == 1
    section.judge(
        "section 3.1",
        "its cost does not depend on the size of the map",
        HELD if same else NOT_HELD,
        "; ".join(
            f"{one.side} x {one.side}: {one.points} points, {number(one.squares_us)} us"
            for one in by_size
        ),
    )
    fits = {
        text: fit_power([one.explored for one in found], [one.touched for one in found]).exponent
        for text, found in detections.items()
    }
    numbers = ", ".join(f"{text} {exponent:.2f}" for text, exponent in fits.items())
    section.judge(
        "sections 1.1, 3.1",
        "value iteration takes a number of steps of quadratic order in the explored area",
        HELD if min(fits.values()) > 1.8 else NOT_HELD,
        f"exponent of cells touched in explored cells: {numbers}",
    )
    largest = detections["an office"][-1]
    section.judge(
        "section 3.1",
        "frontier detection takes seconds, whatever the method",
        HELD if largest.search_ms > 1000 else NOT_HELD,
        f"an office of {largest.explored:,} explored cells: value iteration "
        f"{number(largest.value_iteration_ms)} ms, a search by distance "
        f"{number(largest.search_ms)} ms",
    )


def _draw_ranges(path: Path, rows: list[DecisionCost]) -> None:
    ranges = [one.s_range for one in rows]
    series = [
        Series("squares, (17)", ranges, [max(one.squares_us, 1e-3) for one in rows]),
        Series("packed words", ranges, [one.packed_us for one in rows]),
        Series("kept numbers", ranges, [one.kept_us for one in rows]),
        Series("kept: per point discovered", ranges, [one.lowered_us for one in rows]),
    ]
    save_points(
        path, series, xlabel="sRange", ylabel="microseconds", title="One decision",
        log_x=True, log_y=True, connect=True,
    )  # fmt: skip


def _draw_detections(
    path: Path, detections: dict[str, list[Detection]], decision: DecisionCost
) -> None:
    series = [
        Series(
            f"value iteration, {text}",
            [one.explored for one in found],
            [one.value_iteration_ms for one in found],
        )
        for text, found in detections.items()
    ]
    office = detections["an office"]
    explored = [one.explored for one in office]
    series.append(Series("search, an office", explored, [one.search_ms for one in office]))
    once = [max(decision.squares_us, 1e-3) / 1e3] * len(office)
    series.append(Series(f"a decision, sRange {decision.s_range}", explored, once))
    save_points(
        path, series, xlabel="explored cells", ylabel="milliseconds", title="Frontier detection",
        log_x=True, log_y=True, connect=True,
    )  # fmt: skip
