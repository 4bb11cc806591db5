"""Reports of prices: counts of paths, what is exact and what is sampled, and scenes by name."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conav.errors import InputError
from conav.planning.grid_motion import GridProblem
from conav.planning.grid_prices import CORRIDOR_WITH_BAY, CROSS, OPEN, paths_within, price_table
from conav.planning.price_report import DRAWN, count_paths, price_report, price_scene
from conav.planning.types import PlanningProblem

SWAP = "a.b\n#.#\n\nB.A\n#.#\n"


@settings(max_examples=60)
@given(st.integers(0, 10_000), st.integers(0, 4))
def test_counting_paths_is_making_them(seed: int, slack: int) -> None:
    rng = np.random.default_rng(seed)
    free = rng.random((3, 4)) < 0.8
    cells = np.flatnonzero(free)
    if len(cells) < 2:
        return
    start, goal = rng.choice(cells, 2).tolist()
    problem = GridProblem(free, (start,), (goal,), int(rng.integers(2, 12)))
    assert count_paths(problem, 0, slack) == len(paths_within(problem, 0, slack))


def test_exact_reports_are_the_table() -> None:
    for row in price_table()[3:]:
        problem = DRAWN[row.name.replace(" ", "-")]
        report = price_report(problem, slack=row.slack)
        assert report.exact
        assert report.paths == row.paths
        assert report.equilibria == row.found.equilibria
        assert report.optimum == row.found.optimum
        assert report.sums[-1] == row.found.worst_equilibrium
        assert report.price_of_anarchy == row.found.price_of_anarchy
        assert report.price_of_stability == 1.0
        assert report.certain is row.certain


def test_a_worst_equilibrium_is_shown_as_cells() -> None:
    report = price_report(CORRIDOR_WITH_BAY, slack=4)
    a, b = report.worst_paths
    assert (a[0], a[-1], b[0], b[-1]) == ((0, 0), (0, 4), (0, 4), (0, 0))
    assert len(a) + len(b) - 2 == report.sums[-1] == 15


def test_rules_with_counterexamples_where_they_fail() -> None:
    report = price_report(CORRIDOR_WITH_BAY, slack=4, rules=True)
    failing = {row.rule: row.counterexample is not None for row in report.rules}
    assert failing == {
        "none": True, "marginal delay": True, "team cost": True, "tolls": True,
        "right of way": False,
    }  # fmt: skip
    tolls = next(row for row in report.rules if row.rule == "tolls")
    assert tolls.counterexample is not None
    assert sum(len(path) - 1 for path in tolls.counterexample) == tolls.worst == 15


def test_samples_lie_between_the_ends() -> None:
    exact = price_report(OPEN, slack=2)
    report = price_report(OPEN, sampled=True, starts=10, seed=2)
    assert not report.exact
    assert report.starts == 10
    assert 2 <= report.equilibria <= 11
    assert report.optimum == exact.optimum == report.lower_bound
    assert exact.sums[0] <= report.sums[0] <= report.sums[-1] <= exact.sums[-1]
    assert price_report(OPEN, sampled=True, starts=10, seed=2) == report
    # No order of choosing gets two robots through the corridor: the optimum alone is known.
    alone = price_report(CORRIDOR_WITH_BAY, sampled=True, starts=3)
    assert (alone.equilibria, alone.sums) == (1, (11.0,))


def test_a_scene_of_the_plane_is_sampled() -> None:
    problem = price_scene("antipodal-circle:2")
    assert isinstance(problem, PlanningProblem)
    report = price_report(problem, samples=100, starts=4)
    assert not report.exact
    assert report.unit == "m"
    assert report.lower_bound is not None
    assert report.lower_bound <= report.sums[0] <= report.sums[-1]
    assert report.equilibria >= 1
    assert report.optimum is None
    assert report.price_of_anarchy is None
    assert report.spread is not None
    assert report.spread >= 1.0


def test_scenes_by_name_and_by_drawing(tmp_path: Path) -> None:
    drawing = tmp_path / "swap.txt"
    drawing.write_text(SWAP)
    problem = price_scene(str(drawing), horizon=9)
    assert isinstance(problem, GridProblem)
    assert (problem.size, problem.horizon, problem.name) == (2, 9, "swap")
    one = price_scene("cross", robots=1)
    assert isinstance(one, GridProblem)
    assert one.size == 1
    assert price_report(one).price_of_anarchy == 1.0


def test_what_makes_no_sense_is_refused(tmp_path: Path) -> None:
    shut = tmp_path / "shut.txt"
    shut.write_text("a#A\n")
    for source, options in (
        ("no-such", {}), ("missing.txt", {}), ("cross", {"robots": 3}), ("x.scen:two", {}),
        ("antipodal-circle:2", {"horizon": 9}),
    ):  # fmt: skip
        with pytest.raises(InputError):
            price_scene(source, **options)
    with pytest.raises(InputError, match="no path"):
        price_report(price_scene(str(shut)))
    with pytest.raises(InputError, match="keep all apart"):
        price_report(CORRIDOR_WITH_BAY, slack=0)
    with pytest.raises(InputError, match="sampled"):
        price_report(CROSS, rules=True, sampled=True)
    with pytest.raises(InputError, match="profiles"):
        price_report(CORRIDOR_WITH_BAY, slack=6, rules=True)
    with pytest.raises(InputError, match="positive"):
        price_report(CROSS, slack=-1)
