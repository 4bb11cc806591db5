"""What one decision of the potential game costs, beside frontier detection: [Philip2014] 3.1.

    python benchmarks/decision_cost.py            # about four minutes, 0.5 GiB
    python benchmarks/decision_cost.py --quick    # smaller maps, half a minute

Counters are exact. Times are the best of many repetitions. `strategy` is
the whole call of `sequence_gains` from Python, the median over decisions, and `squares` that less
the same call with all sequences blocked; `packed`, `kept` and `lowered` are compiled loops.
"""

import argparse
import sys

from conav.experiments.decision_cost import DecisionCost, cost_by_map_size, cost_by_range
from conav.experiments.detection_cost import AREAS, Detection, detection_by_area
from conav.experiments.timing import fit_power


def tell(text: str) -> None:
    print(f"  {text} ...", file=sys.stderr, flush=True)


def print_decisions(rows: list[DecisionCost]) -> None:
    print(
        "| side | sRange | points | words | kept | strategy us | squares us | packed us | kept us "
        "| lowered per point | lowered us |"
    )
    print("|" + "---|" * 11)
    for row in rows:
        assert row.points == row.expected_points, "not what section 3.1 counts"
        print(
            f"| {row.side} | {row.s_range} | {row.points:,} | {row.words:,} | {row.kept} "
            f"| {row.strategy_us:.2f} | {row.squares_us:.2f} | {row.packed_us:.3f} "
            f"| {row.kept_us:.4f} | {row.lowered:,} | {row.lowered_us:.4f} |"
        )
    print()


def print_fits(rows: list[DecisionCost]) -> None:
    large = [row for row in rows if row.s_range >= 4]
    ranges = [row.s_range for row in large]
    print(f"Exponents in sRange, {ranges[0]} to {ranges[-1]}:")
    for name in (
        "points", "words", "kept", "lowered", "squares_us", "packed_us", "kept_us", "lowered_us"
    ):  # fmt: skip
        print(f"  {name} {fit_power(ranges, [getattr(row, name) for row in large]).exponent:.2f}")
    print("Points discovered per decision up to which kept numbers are cheaper than")
    print("  squares:", *(f"{row.break_even(row.squares_us):.0f}" for row in rows))
    print("  packed: ", *(f"{row.break_even(row.packed_us):.1f}" for row in rows))
    print()


def print_detections(rows: list[Detection]) -> None:
    print(
        "| area | side | explored | sweeps | touched | ms | there and back: sweeps | touched | ms "
        "| Dijkstra ms | scan ms |"
    )
    print("|" + "---|" * 11)
    for row in rows:
        print(
            f"| {row.area} | {row.side} | {row.explored:,} | {row.sweeps:,} | {row.touched:,} "
            f"| {row.value_iteration_ms:,.2f} | {row.back_sweeps:,} | {row.back_touched:,} "
            f"| {row.back_ms:,.2f} | {row.search_ms:,.3f} | {row.scan_ms:,.3f} |"
        )
    explored = [row.explored for row in rows]
    exponents = [
        f"{what} {fit_power(explored, [getattr(row, name) for row in rows]).exponent:.2f}"
        for what, name in (
            ("touched", "touched"),
            ("ms", "value_iteration_ms"),
            ("there and back touched", "back_touched"),
            ("ms", "back_ms"),
            ("Dijkstra ms", "search_ms"),
            ("scan ms", "scan_ms"),
        )
    ]
    print(f"Exponents in explored cells, {rows[0].area}: {', '.join(exponents)}\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="smaller maps, less time for each")
    quick = parser.parse_args().quick
    budget = 0.1 if quick else 0.5
    print("Decisions against the sensor's range\n")
    ranges = (1, 2, 4, 8, 16) if quick else (1, 2, 4, 8, 16, 32, 64)
    rows = cost_by_range(ranges, budget_s=budget, progress=tell)
    print_decisions(rows)
    print_fits(rows)
    print("Decisions against the size of the map; the decisions are the same on all\n")
    sides = (64, 256, 1024) if quick else (64, 256, 1024, 4096)
    print_decisions(cost_by_map_size(sides, budget_s=budget, progress=tell))
    print("Frontier detection against the explored area\n")
    limit = 1.0 if quick else 10.0
    for name in AREAS:
        sides = (64, 128, 256) if quick else (64, 128, 256, 512, 1024)
        if name == "winding":
            sides = (32, 64, 128) if quick else (32, 64, 128, 180, 256, 362, 512)
        found = detection_by_area(name, sides, limit_s=limit, progress=tell)
        print_detections(found)
        if found[-1].value_iteration_ms > limit * 1e3:
            print(f"Ends here: a detection took over {limit:g} s.\n")


if __name__ == "__main__":
    main()
