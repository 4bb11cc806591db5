"""`conav prices`."""

import json as json_module
import sys
from dataclasses import asdict
from math import isfinite
from typing import Annotated, Any

from cyclopts import Parameter

from conav.cli.numbers import Whole

SHORT = 16  # cells of paths that are printed


def prices(
    scene: str,
    /,
    *,
    slack: Whole = 2,
    mechanisms: Annotated[bool, Parameter(negative="")] = False,
    sampled: Annotated[bool, Parameter(negative="")] = False,
    starts: Whole = 20,
    samples: Whole = 500,
    robots: Whole | None = None,
    horizon: Whole | None = None,
    seed: Whole = 0,
    json: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Say what selfish robots cost the team: the prices of anarchy and of stability of a scene.

    Parameters
    ----------
    scene
        Robots on a grid: corridor-with-a-bay, cross, ring, open, a drawing (.txt) or a MovingAI
        scenario (file.scen:4); or any scene conav plan takes, whose equilibria are sampled.
    slack
        On a small grid all paths of up to so many steps above the shortest are gone through.
    mechanisms
        Go through all equilibria under each rule against anarchy, too (exact prices only).
    sampled
        Sample equilibria even where all could be gone through.
    starts
        Where equilibria are sampled: from how many starts.
    samples
        Where equilibria are sampled in the plane: samples of each robot's graph.
    robots
        How many robots: the first ones.
    horizon
        Of a grid: the step by which everybody has arrived.
    seed
        Seed of samples, orders and made scenes.
    json
        Print one JSON object.
    """
    from conav.planning.price_report import price_report, price_scene

    problem = price_scene(scene, robots=robots, horizon=horizon, seed=seed)
    report = price_report(
        problem,
        slack=slack,
        starts=starts,
        samples=samples,
        seed=seed,
        rules=mechanisms,
        sampled=sampled,
    )
    if json:
        content = {
            "job": "prices",
            **asdict(report),
            "price_of_anarchy": _plain(report.price_of_anarchy),
            "price_of_stability": _plain(report.price_of_stability),
            "spread": _plain(report.spread),
            "seed": seed,
        }
        print(json_module.dumps(content, allow_nan=False))
    else:
        if report.unit == "steps" and not report.exact and not sampled:
            print(
                f"conav: more paths within a slack of {slack} than can be gone through: sampled",
                file=sys.stderr,
            )
        for line in _lines(report):
            print(line)
    return 0


def _plain(ratio: float | None) -> float | None:
    return ratio if ratio is not None and isfinite(ratio) else None


def _lines(report: Any) -> list[str]:
    unit = report.unit
    count = len(report.robots)
    team = f"{count} robots" if count > 1 else "1 robot"
    ends = "steps" if unit == "steps" else "s"
    lines = [f"{report.name}: {team}, a horizon of {report.horizon:g} {ends}"]
    if report.exact:
        each = ", ".join(f"{count:,}" for count in report.paths)
        lines.append(
            f"  all paths of up to {report.slack} steps above the shortest: {each} of them"
        )
        beyond = "" if report.certain else "; a plan with longer paths may be better"
        lines.append(f"  optimum {report.optimum:g} {unit}, {report.solo:g} if alone{beyond}")
        lines.append(
            f"  {report.equilibria:,} equilibria, from {report.sums[0]:g} to {report.sums[-1]:g}"
        )
        lines.append(
            f"  price of stability {report.price_of_stability:.4g}, price of anarchy "
            f"{report.price_of_anarchy:.4g}"
        )
        lines.append("  longer paths may be in worse equilibria: with waiting there is no end")
    else:
        lines += _sampled_lines(report)
    short = all(len(path) <= SHORT for path in report.worst_paths)
    if report.worst_paths and short and report.sums[-1] > report.sums[0]:
        lines.append("  a worst one, cell by cell (row, column):")
        lines += _paths(report.robots, report.worst_paths)
    if report.rules:
        lines += _rule_lines(report)
    return lines


def _sampled_lines(report: Any) -> list[str]:
    unit = report.unit
    if not report.sums:
        return [f"  none of {report.starts} starts gave paths to all; raise --starts"]
    different = len(report.sums)
    lines = [
        f"  sampled, {report.starts} starts: {report.equilibria} equilibria with {different} "
        f"different sum{'s' * (different != 1)} of costs"
    ]
    lines.append(
        f"  best {report.sums[0]:.6g} {unit}, worst {report.sums[-1]:.6g}: {report.spread:.4g} "
        "times the best"
    )
    if report.optimum is not None:
        lines.append(
            f"  optimum {report.optimum:g} {unit}: price of stability "
            f"{report.price_of_stability:.4g} at most, of anarchy {report.price_of_anarchy:.4g} "
            "at least"
        )
    elif report.lower_bound:
        lines.append(
            f"  no plan costs less than {report.lower_bound:.6g} {unit}: the worst is at most "
            f"{report.sums[-1] / report.lower_bound:.4g} times the optimum"
        )
    return lines


def _paths(robots: Any, paths: Any) -> list[str]:
    return [
        f"    {name}: " + " ".join(f"{row},{col}" for row, col in path)
        for name, path in zip(robots, paths, strict=True)
    ]


def _rule_lines(report: Any) -> list[str]:
    rows = [("rule", "equilibria", "best", "worst", "collected", "may lose")]
    for row in report.rules:
        paid = f"{row.least_collected:g}"
        if row.most_collected > row.least_collected:
            paid += f" to {row.most_collected:g}"
        rows.append(
            (row.rule, f"{row.equilibria:,}", f"{row.best:g}", f"{row.worst:g}", paid,
             ", ".join(row.may_lose) or "nobody")
        )  # fmt: skip
    widths = [max(len(row[i]) for row in rows) for i in range(6)]
    lines = ["  " + "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip()
             for row in rows]  # fmt: skip
    for row in report.rules:
        if row.rule != "none" and row.counterexample is not None:
            lines.append(f"  {row.rule} fails: an equilibrium of {row.worst:g} under it is")
            lines += _paths(report.robots, row.counterexample)
    return lines
