"""The reproduction's pictures: goals reached by number."""

from pathlib import Path

from conav.experiments.inash.results import Results, Section
from conav.experiments.inash.world import EXPERIMENTS, INASH, OURS, PLAIN, TRIALS_OF_PAPER
from conav.pictures.plots import Series, save_points


def picture_of(experiment: str) -> str:
    """The file's name."""
    return f"{experiment}-goals.png"


def draw(folder: Path, results: Results, sections: list[Section]) -> None:
    """Draws a picture for each experiment into the folder, from the sections' rows."""
    for experiment, about in EXPERIMENTS.items():
        series: list[Series] = []
        names = [str(robot + 1) for robot in range(about.robots)]
        for method in (INASH, PLAIN, OURS):
            rows = [
                row
                for section in sections
                for row in section.rows
                if (row.experiment, row.method, row.measure)
                == (experiment, method, "goals reached")
                and row.robot
            ]
            if rows:
                series.append(
                    Series(
                        f"{method}, here",
                        names,
                        [100 * row.value for row in rows],
                        [100 * row.low for row in rows],
                        [100 * row.high for row in rows],
                    )
                )
            if method in about.reached:
                counts = about.reached[method]
                series.append(
                    Series(
                        f"{method}, paper", names, [100 * one / TRIALS_OF_PAPER for one in counts]
                    )
                )
        if series and results.paired(experiment):
            save_points(
                folder / picture_of(experiment),
                series,
                xlabel="robot's number",
                ylabel="goals reached [%]",
                title=about.title,
                note="Bars: 95 % by Wilson.",
                y_range=(0, 102),
            )
