"""Time against bandwidth for `potential-quiet`: a table, bandwidth.csv and the pictures.

    python benchmarks/quiet_radio.py --out study              # 40 layouts, about ten minutes
    python benchmarks/quiet_radio.py --out study --layouts 6  # one minute

Runs are kept in the folder; the same command goes on where it was stopped.
"""

import argparse
import sys
from pathlib import Path

from conav.experiments.quiet_radio import (
    SHARES,
    draw_bandwidth,
    quiet_radio,
    write_bandwidth,
)
from conav.intervals import Estimate


def tell(done: int, total: int) -> None:
    if done % 100 == 0 or done == total:
        print(f"  {done} of {total} runs", file=sys.stderr, flush=True)


def show(at: Estimate, digits: int) -> str:
    return f"{at.value:.{digits}f} [{at.low:.{digits}f}, {at.high:.{digits}f}]"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("quiet-radio"))
    parser.add_argument("--layouts", type=int, default=40)
    parser.add_argument("--jobs", type=int, default=None)
    options = parser.parse_args()
    rows = quiet_radio(
        options.out / "runs", layouts=options.layouts, jobs=options.jobs, progress=tell
    )
    write_bandwidth(rows, options.out / "bandwidth.csv")
    note = f"Mean ratios over {options.layouts} layouts of three-obstacles, 95 % intervals."
    for share in SHARES:
        draw_bandwidth(rows, options.out / f"quiet-radio-{share}.png", share, note=note)
    heads = ("radio", "done", "bytes per robot-step", "bytes", *(f"{s} %" for s in SHARES))
    print(f"| {' | '.join(heads)} |\n{'|---' * len(heads)}|")
    for row in rows:
        cells = (row.label, str(row.finished), show(row.bytes, 1), show(row.total, 0))
        print(f"| {' | '.join((*cells, *(show(at, 2) for at in row.ratios)))} |")


if __name__ == "__main__":
    main()
