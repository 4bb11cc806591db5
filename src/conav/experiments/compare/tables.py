"""What a comparison found, in numbers: a table per group of runs, and one over all of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from conav.experiments.compare.cases import Case, Group, Study
from conav.experiments.compare.optimum import AgainstBest, median_ratio
from conav.experiments.compare.outcome import Failure, Outcome
from conav.experiments.compare.statistics import median_interval, ratio_bootstrap
from conav.intervals import Estimate

Result = Outcome | Failure

SHARES = (90, 99, 100)  # [%] of coverage whose times are in the tables

MEASURES: dict[str, tuple[str, Callable[[Outcome], float]]] = {
    "seen": ("seen [%]", lambda run: 100 * run.coverage),
    "path": ("path [m]", lambda run: sum(run.path_m)),
    "overlap": ("overlap", lambda run: run.overlap),
    "balance": ("balance", lambda run: run.balance_seen),
    "messages": ("messages", lambda run: float(run.messages)),
    "traffic": ("messages [kB]", lambda run: run.bytes / 1e3),
}
"""Name -> heading and value of the other measures."""


class Times(NamedTuple):
    """The median time to a share of coverage [s], runs that did not get there at the time limit."""

    median: Estimate
    at_least: bool  # the median lies among runs that did not get there
    reached: int  # how many did


class Ratio(NamedTuple):
    """The geometric mean of a strategy's times over the first strategy's in the same runs."""

    estimate: Estimate
    open_above: bool  # not all of the strategy's runs got there
    open_below: bool  # not all of the first strategy's did


@dataclass(frozen=True)
class Line:
    """A strategy in one group."""

    strategy: str
    rank: int
    runs: int  # played to their end
    finished: int  # that covered everything
    failed: int  # that could not be played
    times: dict[int, Times]  # by share [%]
    ratio: Ratio | None  # of T100
    best: tuple[float, float] | None  # between these lies the median of T100 over the best possible
    measures: dict[str, Estimate]  # medians, by names of `MEASURES`


@dataclass(frozen=True)
class Table:
    """The strategies in one group, the best first."""

    group: Group
    lines: tuple[Line, ...]
    outcomes: dict[str, tuple[Outcome, ...]]  # by strategy, in the order of seeds


@dataclass(frozen=True)
class Total:
    """A strategy over all groups."""

    strategy: str
    runs: int
    finished: int
    failed: int
    mean_rank: float
    ratios: dict[int, Ratio]  # by share [%]; none without a pair of runs
    best: tuple[float, float] | None  # as of a `Line`


def time_to(run: Outcome, percent: int, limit_s: float) -> float:
    """When a run reached a share of coverage [s]: a step at least, the time limit if it did not."""
    time = run.percent_s[percent - 1]
    return max(limit_s if time is None else time, run.step_s)


def tables(
    study: Study, results: Mapping[Case, Result], best: Mapping[Case, AgainstBest]
) -> list[Table]:
    """A table for each group of which something was played."""
    found = [_table(study, group, results, best) for group in study.groups()]
    return [table for table in found if table.lines]


def totals(
    study: Study,
    results: Mapping[Case, Result],
    best: Mapping[Case, AgainstBest],
    made: Sequence[Table],
) -> list[Total]:
    """Each strategy over all groups, in the order they were asked for."""
    cases = study.cases()
    found: list[Total] = []
    for team in study.teams:
        lines = [line for table in made for line in table.lines if line.strategy == team.name]
        if lines:
            pairs = _pairs(study, results, cases, team.name)
            found.append(
                Total(
                    strategy=team.name,
                    runs=sum(line.runs for line in lines),
                    finished=sum(line.finished for line in lines),
                    failed=sum(line.failed for line in lines),
                    mean_rank=sum(line.rank for line in lines) / len(lines),
                    ratios={share: _ratio(study, pairs, share) for share in SHARES}
                    if pairs
                    else {},
                    best=median_ratio(
                        [one for case, one in best.items() if case.strategy == team.name]
                    ),
                )
            )
    return found


def _table(
    study: Study,
    group: Group,
    results: Mapping[Case, Result],
    best: Mapping[Case, AgainstBest],
) -> Table:
    limit = study.world.max_time_s
    played: dict[str, list[Outcome]] = {}
    failed: dict[str, int] = {}
    cases = [Case(*group, team.name, seed) for team in study.teams for seed in study.seeds]
    for case in cases:
        result = results.get(case)
        if isinstance(result, Outcome):
            played.setdefault(case.strategy, []).append(result)
        elif result is not None:
            failed[case.strategy] = failed.get(case.strategy, 0) + 1
    order = {strategy: _standing(runs, limit) for strategy, runs in played.items()}
    lines = [
        Line(
            strategy=strategy,
            rank=1 + sum(other < order[strategy] for other in order.values()),
            runs=len(runs),
            finished=sum(run.percent_s[-1] is not None for run in runs),
            failed=failed.get(strategy, 0),
            times={share: _times(runs, share, limit) for share in SHARES},
            ratio=_ratio(study, pairs, 100) if pairs else None,
            best=median_ratio(
                [best[case] for case in cases if case.strategy == strategy and case in best]
            ),
            measures={
                name: median_interval([value(run) for run in runs])
                for name, (_, value) in MEASURES.items()
            },
        )
        for strategy, runs in played.items()
        for pairs in (_pairs(study, results, cases, strategy),)
    ]
    lines.sort(key=lambda line: line.rank)
    return Table(group, tuple(lines), {name: tuple(runs) for name, runs in played.items()})


def _standing(runs: Sequence[Outcome], limit_s: float) -> list[tuple[float, int]]:
    """What strategies are ranked by: T100, then who got there more often, then T99 and T90."""
    times = [_times(runs, share, limit_s) for share in reversed(SHARES)]
    return [(one.median.value, -one.reached) for one in times]


def _times(runs: Sequence[Outcome], share: int, limit_s: float) -> Times:
    reached = sum(run.percent_s[share - 1] is not None for run in runs)
    median = median_interval([time_to(run, share, limit_s) for run in runs])
    return Times(median, at_least=reached <= len(runs) // 2, reached=reached)


def _pairs(
    study: Study, results: Mapping[Case, Result], cases: Sequence[Case], strategy: str
) -> list[tuple[Outcome, Outcome]]:
    """The runs of a strategy with the same runs of the first one."""
    found: list[tuple[Outcome, Outcome]] = []
    for case in cases:
        if case.strategy == strategy:
            run = results.get(case)
            other = results.get(case._replace(strategy=study.teams[0].name))
            if isinstance(run, Outcome) and isinstance(other, Outcome):
                found.append((run, other))
    return found


def _ratio(study: Study, pairs: Sequence[tuple[Outcome, Outcome]], share: int) -> Ratio:
    limit = study.world.max_time_s
    return Ratio(
        ratio_bootstrap(
            [time_to(run, share, limit) for run, _ in pairs],
            [time_to(other, share, limit) for _, other in pairs],
        ),
        open_above=any(run.percent_s[share - 1] is None for run, _ in pairs),
        open_below=any(other.percent_s[share - 1] is None for _, other in pairs),
    )
