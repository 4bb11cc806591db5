"""Bounds from both sides: what more or less work changes, and that what is left out is no harm."""

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import conav
from conav.errors import InputError
from conav.exploration.bounds.bounds import Ground, lower_bounds, lower_bounds_on
from conav.exploration.bounds.views import Places
from conav.exploration.catalogue import STRATEGIES
from conav.exploration.metrics import SHARES
from conav.exploration.types import ExplorationProblem
from conav.maps.ascii_art import parse_ascii
from conav.maps.builtin.catalogue import builtin_map
from conav.maps.occupancy_grid import OccupancyGrid
from conav.robots.motion import MOTIONS
from conav.simulation import finish_bounds as module
from conav.simulation.explore import exploration_problem
from conav.simulation.finish_bounds import EFFORTS, Effort, check_effort, finish_bounds
from conav.simulation.known_map_run import known_map_run
from conav.simulation.observable import observable_cells


def problem_on(name: str, **options: Any) -> ExplorationProblem:
    grid = builtin_map(name, width_m=9.0, height_m=9.0, resolution=0.15)
    return exploration_problem(grid, **{"range_m": 3.0, **options})[0]


def test_full_is_no_weaker_than_quick_but_for_luck() -> None:
    problem = problem_on("office", robots=2, seed=1)
    quick, full = (finish_bounds(problem, effort=effort) for effort in ("quick", "full"))
    assert list(quick) == list(full) == list(SHARES)
    for share in SHARES:
        assert full[share].lower_s >= quick[share].lower_s
        assert full[share].upper_s is not None
        assert quick[share].upper_s is not None
        assert full[share].upper_s <= 1.05 * quick[share].upper_s
        assert full[share].lower_s <= full[share].upper_s
        assert quick[share].share == share / 100
    assert quick[90].witness_s == 0.0 < full[90].witness_s
    assert quick[100].lower_s == full[100].lower_s
    assert {item.upper_by for item in quick.values()} == {"known-map"}
    assert finish_bounds(problem, effort="quick") == quick


def test_bounds_do_not_depend_on_the_radio() -> None:
    near, far = (problem_on("maze", robots=2, seed=3, radio=radio) for radio in ("off", "perfect"))
    found = finish_bounds(near, effort="quick")
    assert finish_bounds(far, effort="quick") == found
    moved = replace(near, starts=near.starts[::-1])
    assert finish_bounds(moved, effort="quick")[100].lower_s == found[100].lower_s
    elsewhere = problem_on("maze", robots=2, seed=4)
    assert finish_bounds(elsewhere, effort="quick")[100] != found[100]


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", ["office", "cave"])
def test_on_maps_too_large_to_look_from_everywhere(name: str, motion: str) -> None:
    problem = problem_on(name, robots=2, seed=2, motion=motion)
    observable = observable_cells(problem.plan, problem.starts, problem.robots[0].sensor)
    whole = Ground.of(problem, observable)
    part = Ground.of(problem, observable, most=1e5)
    assert 10 < part.seen.known.sum() < observable.sum() / 5
    assert whole.seen.known[observable.reshape(-1) == 1].all()
    for share in (0.9, 1.0):
        exact, sampled = (lower_bounds_on(ground, share) for ground in (whole, part))
        assert sampled.swath_s == exact.swath_s
        assert sampled.eccentricity_s <= exact.eccentricity_s
    # To see all, the cells that were looked at still tell a lot, and nothing that is wrong.
    assert 0.6 * exact.lower_s < sampled.lower_s
    run = known_map_run(problem, rounds=20)
    assert run is not None
    assert run.metrics.t100_s is not None
    assert sampled.lower_s <= run.metrics.t100_s
    assert lower_bounds(problem, observable) == exact


def test_plans_are_left_out_where_looks_are_too_many_and_rounds_where_places_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    problem = problem_on("maze", robots=2, seed=3)
    asked: list[int] = []

    def noted(problem: ExplorationProblem, share: float, *, rounds: int) -> Any:
        asked.append(rounds)
        return known_map_run(problem, share, rounds=rounds)

    monkeypatch.setattr(module, "known_map_run", noted)
    quick = EFFORTS["quick"]
    without = finish_bounds(problem, effort=replace(quick, plan_cells=1e3))
    assert asked == []
    assert [item.upper_s for item in without.values()] == [None] * 4
    places = len(Places.of(problem).cells)
    finish_bounds(problem, effort=replace(quick, place_rounds=7.5 * places))
    finish_bounds(problem, effort=quick)
    finish_bounds(problem, (99, 100), effort=Effort(rounds=2))
    assert asked == [7, 30, 2, 2]


def test_efforts_are_counted() -> None:
    """What stands in docs/bounds.md."""
    quick = EFFORTS["quick"]
    assert (quick.rounds, quick.place_rounds) == (30, 4e5)
    assert (quick.lower_cells, quick.plan_cells) == (1e9, 1e9)
    assert EFFORTS["full"] == Effort()
    assert Effort().place_rounds == Effort().lower_cells == Effort().plan_cells == inf


def test_an_interrupt_is_not_taken_for_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_on("maze", robots=1, seed=3)
    run = known_map_run(problem, rounds=0)
    assert run is not None
    monkeypatch.setattr(
        module, "known_map_run", lambda *args, **options: replace(run, interrupted=True)
    )
    with pytest.raises(KeyboardInterrupt):
        finish_bounds(problem, effort="quick")


def test_efforts_are_named() -> None:
    for name in ("quick", "full", "none"):
        check_effort(name)
    with pytest.raises(InputError, match="bounds 'best': is not known; use one of: quick, full"):
        check_effort("best")


# Of a run


def test_a_run_is_a_plan_itself() -> None:
    grid = parse_ascii("###########\n#.........#\n###########")
    done = conav.explore(grid, robots=1, starts=[(1.5, 1.5)], range_m=1.0, cell_m=1.0)
    slow = done.bounds()
    assert slow[100].upper_s == done.metrics.t100_s == slow[100].lower_s
    assert slow[100].upper_by == "known-map"  # as fast as the run
    assert done.ratios(slow[100]) == (1.0, 1.0)
    for share, bounds in slow.items():
        low, high = done.ratios(bounds, share)
        assert 1.0 <= low <= high
    faster = slow[100].with_run(1.0, "magic")
    assert (faster.upper_s, faster.upper_by) == (1.0, "magic")
    assert slow[100].with_run(None, "magic") == slow[100]
    assert slow[100].with_run(1e6, "magic") == slow[100]


def test_without_a_plan_the_run_is_the_upper_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(EFFORTS, "quick", Effort(rounds=1, plan_cells=0.0))
    done = conav.explore("maze", robots=2, seed=1)
    bounds = done.bounds()
    assert {item.upper_by for item in bounds.values()} == {"this-run"}
    for share, item in bounds.items():
        assert item.upper_s == done.time_to(share)
        assert done.ratios(item, share)[0] == 1.0


def test_a_run_that_did_not_finish_takes_at_least_so_much() -> None:
    options: dict[str, Any] = {"robots": 1, "range_m": 3.0, "seed": 2}
    grid = builtin_map("office", width_m=12.0, height_m=12.0)
    whole = conav.explore(grid, strategy="uncoordinated", **options)
    known = whole.bounds()
    assert known[100].upper_s is not None
    assert whole.metrics.t100_s is not None
    assert whole.metrics.t100_s > 1.5 * known[100].upper_s
    limit = 1.4 * known[100].upper_s
    done = conav.explore(grid, strategy="uncoordinated", max_time_s=limit, **options)
    low, high = done.ratios(done.bounds()[100])
    assert low == pytest.approx(done.metrics.time_s / known[100].upper_s)
    assert 1.3 < low <= whole.metrics.t100_s / known[100].upper_s
    assert high == inf
    said = done.summary(done.bounds())
    assert said["ratio"] == [low, None]
    assert said["bounds"]["t100"]["ratio"] == [low, None]


def test_time_0() -> None:
    grid = parse_ascii("#####\n#...#\n#####")
    done = conav.explore(grid, robots=1, starts=[(2.5, 1.5)], range_m=9.0, cell_m=1.0)
    assert done.metrics.t100_s == 0.0
    bounds = done.bounds()
    for share in SHARES:
        assert (bounds[share].lower_s, bounds[share].upper_s) == (0.0, 0.0)
        assert done.ratios(bounds[share], share) == (1.0, 1.0)
    assert done.summary(bounds)["ratio"] == [1.0, 1.0]


@settings(deadline=None, max_examples=60, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_no_run_on_random_maps_is_outside(data: st.DataObject) -> None:
    rows, cols = data.draw(st.integers(4, 9)), data.draw(st.integers(4, 9))
    bits = data.draw(st.lists(st.integers(0, 3), min_size=rows * cols, max_size=rows * cols))
    cells = (np.array(bits).reshape(rows, cols) == 0).astype(np.uint8)
    try:
        done = conav.explore(
            OccupancyGrid(cells, 0.5),
            strategy=data.draw(st.sampled_from(sorted(STRATEGIES))),
            robots=data.draw(st.integers(1, 3)),
            motion=data.draw(st.sampled_from(sorted(MOTIONS))),
            sensor=data.draw(st.sampled_from(["range", "disc"])),
            range_m=data.draw(st.sampled_from([0.5, 1.0, 2.5, 9.0])),
            traffic=data.draw(st.sampled_from(["pibt", "none"])),
            seed=data.draw(st.integers(0, 99)),
            cell_m=0.5,
            max_time_s=300.0,
        )
    except InputError:
        return  # no room for the team
    for share, bounds in done.bounds().items():
        time_s = done.time_to(share)
        assert time_s is None or bounds.lower_s <= time_s
        assert bounds.upper_s is None or bounds.lower_s <= bounds.upper_s
        low, high = done.ratios(bounds, share)
        assert 1.0 <= low <= high
