"""The teams that are compared, and how their times and coverage are reported."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from conav.experiments.potential_games.lab import (
    Lab,
    curve,
    finished,
    finished_share,
    time_estimate,
)
from conav.experiments.potential_games.report import (
    Section,
    estimate,
)
from conav.experiments.potential_games.world import Played, Team, team
from conav.pictures.plots import Series, save_curves

TIMES = ("T90", "T95", "T99", "T100")
EPSILONS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0)
BAND = "Mean over layouts; the band is its 95 % interval."
TIES = (("random", "ties drawn"), ("baseline", "baseline wins ties"))


def algorithm_2(epsilon: float, tie: str = "random", s_range: int = 2) -> Team:
    """A team of Algorithm 2."""
    label = f"Algorithm 2, epsilon {epsilon:g}" + (", literal ties" if tie == "baseline" else "")
    return team(label, "potential", s_range, epsilon=epsilon, tie=tie)


def improved(epsilon: float, tie: str = "random") -> Team:
    """A team of the improved algorithm."""
    label = f"Improved, epsilon {epsilon:g}" + (", literal ties" if tie == "baseline" else "")
    return team(label, "potential-improved", epsilon=epsilon, tie=tie)


def uncoordinated(tie: str = "random") -> Team:
    """The uncoordinated team with a shared map."""
    label = "uncoordinated, shared map" + (", literal ties" if tie == "baseline" else "")
    return team(label, "uncoordinated", tie=tie)


def alone(tie: str = "random") -> Team:
    """The uncoordinated team that shares nothing."""
    label = "uncoordinated, nothing shared" + (", literal ties" if tie == "baseline" else "")
    return team(label, "uncoordinated-alone", tie=tie)


TIME_HEADER = ("team", "sRange", "T90", "T99", "T100", "finished")


def add_times(section: Section, lab: Lab, players: Team, played: list[Played]) -> None:
    """Add a team's times, and how many games finished, to the table and the rows."""
    done = finished_share(played, 3)
    counted = [finished(played, column) for column in range(4)]
    found = [time_estimate(played, column, lab.steps) for column in range(4)]
    for name, one in zip(TIMES, found, strict=True):
        section.add(players.label, players.s_range, name, "steps", one)
    section.add(players.label, players.s_range, "finished", "share of games", done)
    least = ["" if one[0] == one[1] else "at least " for one in counted]
    section.table.append(
        (
            players.label,
            str(players.s_range),
            *(least[column] + estimate(found[column]) for column in (0, 2, 3)),
            f"{counted[3][0]} of {counted[3][1]}",
        )
    )


def add_coverage(
    section: Section, lab: Lab, teams: list[tuple[Team, list[Played]]], last: int
) -> list[Series]:
    """The coverage of teams over time, as rows and as series."""
    series: list[Series] = []
    for players, played in teams:
        mean, low, high = (
            100 * part[: last + 1] for part in curve([one.coverage for one in played])
        )
        section.add_curve(players.label, players.s_range, "coverage [%]", (mean, low, high))
        series.append(Series(players.label, np.arange(len(mean)), mean, low, high))
    return series


def draw_coverage(series: list[Series], title: str, note: str = BAND) -> Callable[[Path], None]:
    """A function that draws curves of coverage to a file."""

    def draw(path: Path) -> None:
        save_curves(path, series, xlabel="step", ylabel="points seen [%]", title=title, note=note)

    return draw
