"""The parts of the object that `conav compare --json` prints."""

from math import isfinite
from typing import Any

from conav.experiments.compare.tables import Ratio, Table, Total
from conav.intervals import Estimate


def table_summary(table: Table) -> dict[str, Any]:
    """What is said of a group."""
    return {
        **table.group._asdict(),
        "strategies": [
            {
                "strategy": line.strategy,
                "rank": line.rank,
                "runs": line.runs,
                "finished": line.finished,
                "failed": line.failed,
                **{
                    f"t{share}_s": {
                        **_estimate(times.median),
                        "at_least": times.at_least,
                        "reached": times.reached,
                    }
                    for share, times in line.times.items()
                },
                "t100_ratio": _ratio(line.ratio),
                "t100_over_best": _best(line.best),
                **{name: _estimate(found) for name, found in line.measures.items()},
            }
            for line in table.lines
        ],
    }


def total_summary(total: Total) -> dict[str, Any]:
    """What is said of a strategy over all groups."""
    return {
        "strategy": total.strategy,
        "runs": total.runs,
        "finished": total.finished,
        "failed": total.failed,
        "mean_rank": total.mean_rank,
        **{f"t{share}_ratio": _ratio(ratio) for share, ratio in total.ratios.items()},
        "t100_over_best": _best(total.best),
    }


def _best(found: tuple[float, float] | None) -> list[float | None] | None:
    return None if found is None else [end if isfinite(end) else None for end in found]


def _ratio(ratio: Ratio | None) -> dict[str, Any] | None:
    if ratio is None:
        return None
    return {
        **_estimate(ratio.estimate),
        "at_least": ratio.open_above and not ratio.open_below,
        "at_most": ratio.open_below and not ratio.open_above,
    }


def _estimate(found: Estimate) -> dict[str, Any]:
    low, high = (end if isfinite(end) else None for end in (found.low, found.high))
    return {"value": found.value, "low": low, "high": high, "n": found.n}
