"""The files of numbers a comparison writes."""

import csv
import io
from collections.abc import Mapping, Sequence
from math import inf
from pathlib import Path
from typing import Any

from conav.experiments.compare.cases import Case, Study
from conav.experiments.compare.optimum import AgainstBest
from conav.experiments.compare.outcome import Outcome
from conav.experiments.compare.tables import Result
from conav.pictures.output import whole_file

RESULTS = "results.csv"
COVERAGE = "coverage.csv"
TIMING = "timing.csv"
PARQUET = "results.parquet"

Columns = dict[str, list[Any]]

_CASE = ("map", "robots", "range_m", "radio", "strategy", "seed")
_NUMBERS = (
    "step_s", "time_s", "coverage", "t90_s", "t95_s", "t99_s", "t100_s", "path_m",
    "longest_path_m", "overlap", "balance_seen", "balance_path",
)  # fmt: skip
_BEST = {
    "lower_bound_s": "lower_s",
    "upper_bound_s": "upper_s",
    "ratio_low": "low",
    "ratio_high": "high",
    "lower_bound_by": "lower_by",
    "upper_bound_by": "upper_by",
}
_BY = ("lower_bound_by", "upper_bound_by")
_COUNTS = ("steps", "messages", "bytes")


def write_files(
    folder: Path,
    study: Study,
    results: Mapping[Case, Result],
    best: Mapping[Case, AgainstBest],
) -> list[str]:
    """Write the numbers of what was played, in the order of the cases; gives warnings.

    Wall times have a file of their own: all else is the same whenever and wherever it is run.
    """
    cases = [case for case in study.cases() if case in results]
    runs = [results[case] for case in cases]
    columns = _result_columns(study, cases, runs, best)
    _write_csv(folder / RESULTS, columns)
    percents = [_percents(run) for run in runs]
    _write_csv(
        folder / COVERAGE,
        {name: columns[name] for name in _CASE}
        | {f"t{k + 1}_s": [times[k] for times in percents] for k in range(100)},
    )
    walls = ("compute_s", "decision_ms_mean", "decision_ms_p99", "decision_ms_max")
    _write_csv(
        folder / TIMING,
        {name: columns[name] for name in _CASE}
        | {name: [getattr(run, name, None) for run in runs] for name in walls},
    )
    return _write_parquet(folder / PARQUET, columns, percents)


def _result_columns(
    study: Study,
    cases: Sequence[Case],
    runs: Sequence[Result],
    best: Mapping[Case, AgainstBest],
) -> Columns:
    rows = [
        _row(study, case, run) | _best_row(best.get(case))
        for case, run in zip(cases, runs, strict=True)
    ]
    names = (*_CASE, "status", *_COUNTS, *_NUMBERS, "observable_m2", *_BEST, "message")
    return {name: [row.get(name) for row in rows] for name in names}


def _row(study: Study, case: Case, run: Result) -> dict[str, Any]:
    place: dict[str, Any] = {**case._asdict(), "radio": study.radio(case)}
    if not isinstance(run, Outcome):
        return place | {"status": "failed", "message": run.message}
    return place | {
        **vars(run),
        **{f"t{share}_s": run.percent_s[share - 1] for share in (90, 95, 99, 100)},
        "path_m": round(sum(run.path_m), 9),
        "longest_path_m": max(run.path_m),
    }


def _best_row(found: AgainstBest | None) -> dict[str, Any]:
    """The bounds and the ratio's ends; infinity, which is no end, is left out."""
    values = {name: getattr(found, field, None) for name, field in _BEST.items()}
    return {name: None if value == inf else value for name, value in values.items()}


def _percents(run: Result) -> tuple[float | None, ...]:
    return run.percent_s if isinstance(run, Outcome) else (None,) * 100


def _write_csv(path: Path, columns: Columns) -> None:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns)
    table.writerows(zip(*columns.values(), strict=True))
    with whole_file(path) as stream:
        stream.write(text.getvalue().encode())


def _write_parquet(path: Path, columns: Columns, percents: Sequence[Any]) -> list[str]:
    try:
        import pyarrow as pa  # not everybody has the extra
        from pyarrow import parquet
    except ModuleNotFoundError as error:
        path.unlink(missing_ok=True)  # of an earlier call: it would not agree with the rest
        return [
            f"no {PARQUET}: it needs {error.name}, which is not installed; "
            'pip install "conav[data]"'
        ]
    kinds: dict[str, Any] = {
        "robots": pa.int64(),
        "range_m": pa.float64(),
        "seed": pa.int64(),
        "observable_m2": pa.float64(),
        **dict.fromkeys(_COUNTS, pa.int64()),
        **dict.fromkeys(_NUMBERS, pa.float64()),
        **{name: pa.string() if name in _BY else pa.float64() for name in _BEST},
    }
    arrays = {
        name: pa.array(column, kinds.get(name, pa.string())) for name, column in columns.items()
    }
    arrays["percent_s"] = pa.array([list(times) for times in percents], pa.list_(pa.float64()))
    with whole_file(path) as stream:
        parquet.write_table(pa.table(arrays), stream)
    return []
