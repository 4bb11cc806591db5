"""The potential game with radios that are mostly off: when they are on, and what that costs."""

from math import ceil, dist, inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import conav
from conav.errors import InputError
from conav.exploration.potential_quiet import PotentialQuiet
from conav.maps.ascii_art import ascii_starts, parse_ascii
from conav.messages.message import report_bytes, scan_bytes
from conav.runs.types import ExplorationRun

PAPER: dict[str, Any] = {
    "motion": "forward-turn",
    "sensor": "disc",
    "range_m": 2.0,
    "cell_m": 1.0,
    "speed_mps": 1.0,
    "traffic": "none",
}
SMALL = {"width_m": 24, "height_m": 24}


def recorded(
    path: Path, strategy: str = "potential-quiet", seed: int = 1, **more: Any
) -> ExplorationRun:
    settings = more.pop("settings", {})
    grid = more.pop("grid", None) or conav.builtin_map("three-obstacles", seed=seed, **SMALL)
    options = PAPER | {"seed": seed, "max_time_s": 300.0} | more
    conav.explore(grid, strategy=strategy, settings=settings, out=path, **options)
    return conav.read_run(path)


def radios(run: ExplorationRun, n: int = 3) -> list[list[bool]]:
    """Whose radio is on in each step: all in the first, then as said the step before."""
    return [[True] * n] + [[not off for off in step.quiet] for step in run.steps]


def ways(run: ExplorationRun) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    return [(tuple(step.cells.tolist()), tuple(step.wishes.tolist())) for step in run.steps]


@pytest.mark.parametrize("every", [1, 3, 10])
def test_by_the_clock(every: int, tmp_path: Path) -> None:
    run = recorded(tmp_path / "run.mcap", settings={"every": every})
    for number, on in enumerate(radios(run)[:-1]):
        assert on == [number % every == 0] * 3
        sent = run.steps[number].messages
        assert sent == 0 if number % every else sent >= 6


def test_talking_in_every_step_it_is_potential(tmp_path: Path) -> None:
    for seed in range(3):
        quiet = recorded(tmp_path / "1.mcap", seed=seed, settings={"every": 1})
        always = recorded(tmp_path / "2.mcap", "potential", seed)
        assert ways(quiet) == ways(always)
        assert len(quiet.steps) > 50


def expected_radios(
    run: ExplorationRun, every: int, within: float, news: int, side: int
) -> list[list[bool]]:
    """The rule told anew, from the places and looks that were recorded; a world without loss."""
    n = 3
    due = {(i, j): 0 for i in range(n) for j in range(n) if i != j}
    own: list[set[int]] = [set() for _ in range(n)]  # cells each knows
    told: list[int] = [0] * n
    on = [True] * n
    found = [on]
    for step in run.steps:
        for i in range(n):
            own[i] |= set((step.scan(i)[0]).tolist())
        place = [divmod(int(cell), side) for cell in step.cells]
        talking = [i for i in range(n) if on[i]]
        if len(talking) > 1:
            union = set().union(*(own[i] for i in talking))
            for i in talking:
                own[i] = set(union)
                told[i] = len(union)
                for j in talking:
                    if i != j:
                        apart = dist(place[i], place[j]) - within
                        due[i, j] = step.step + max(ceil(apart / 2), 1)
        following = step.step + 1
        on = [
            len(own[i]) - told[i] >= news
            and (
                (every > 0 and following % every == 0)
                or (within > 0 and any(due[i, j] <= following for j in range(n) if j != i))
            )
            for i in range(n)
        ]
        found.append(on)
    return found


@pytest.mark.parametrize(
    "settings",
    [
        {"every": 0, "within_m": 3.0},
        {"every": 7, "within_m": 3.0},
        {"every": 0, "within_m": 0.5},
        {"every": 4, "news": 15},
        {"every": 0, "within_m": 4.0, "news": 25},
        {"every": 9, "within_m": 2.0, "news": 10, "epsilon": 0.3},
    ],
)
def test_radios_follow_from_what_was_heard_and_seen(
    settings: dict[str, Any], tmp_path: Path
) -> None:
    run = recorded(tmp_path / "run.mcap", seed=3, settings=settings)
    rule = expected_radios(
        run, settings["every"], settings.get("within_m", 0.0), settings.get("news", 0), 24
    )
    assert radios(run) == rule
    on = sum(map(sum, rule))
    assert 0.02 < on / (3 * len(rule)) < 0.9
    assert any(len(set(now)) == 2 for now in rule) == (
        settings.get("news", 0) > 0 or settings.get("within_m", 0.0) > 0
    )


def test_nothing_that_matters_is_missed_within_two_ranges_and_two_cells(tmp_path: Path) -> None:
    """With that radius a robot hears of a cell before it can look at it: the run is the same."""
    other = 0
    saved: list[Any] = []
    for seed in range(8):
        for s_range, motion, traffic in (
            (1.0, "forward-turn", "none"),
            (2.0, "4-connected", "pibt"),
            (3.0, "forward-turn", "none"),
        ):
            options: dict[str, Any] = {
                "seed": seed,
                "range_m": s_range,
                "motion": motion,
                "traffic": traffic,
                "max_time_s": 600.0,
            }
            always = recorded(tmp_path / "1.mcap", "potential", **options)
            settings = {"every": 0, "within_m": 2 * s_range + 2}
            quiet = recorded(tmp_path / "2.mcap", settings=settings, **options)
            assert ways(quiet) == ways(always)
            saved.append(np.mean([step.quiet for step in quiet.steps]))
            late = recorded(tmp_path / "3.mcap", settings={"every": 40}, **options)
            other += ways(late) != ways(always)
    assert other > 20  # what is heard does matter
    assert np.mean(saved) > 0.2


def test_two_robots_that_drive_apart_by_hand(tmp_path: Path) -> None:
    # Nine points apart on a line, nothing draws them anywhere: each drives straight on or back.
    grid = parse_ascii("\n".join(["." * 60] * 2))
    starts = [(25.5, 0.5), (34.5, 0.5)]
    run = recorded(
        tmp_path / "run.mcap",
        grid=grid,
        robots=2,
        starts=starts,
        settings={"every": 0, "within_m": 2.0, "epsilon": 0.0},
        max_time_s=3.0,
    )
    on = radios(run, 2)
    # (9 - 2) / 2 is three and a half: they cannot be within two points before step 4.
    assert on[:5] == [[True, True], [False, False], [False, False], [False, False], [True, True]]


def test_bytes_by_hand(tmp_path: Path) -> None:
    picture = "#####\n#a#b#\n#####"
    starts = [(c + 0.5, r + 0.5) for r, c in ascii_starts(picture).values()]
    grid = parse_ascii(picture)
    run = recorded(tmp_path / "run.mcap", grid=grid, robots=2, starts=starts, range_m=1.0)
    # Each sees its place and the four walls beside it. They report, and each sends the other a
    # report again with its scan.
    assert [step.bytes for step in run.steps] == [4 * report_bytes(2) + 2 * scan_bytes(5)]
    assert [step.messages for step in run.steps] == [4]


@pytest.mark.parametrize("radio", ["perfect", 5.0])
@pytest.mark.parametrize("settings", [{}, {"every": 30, "within_m": 3.0}, {"every": 5, "news": 20}])
def test_finishes_and_is_accepted(
    settings: dict[str, Any], radio: str | float, tmp_path: Path
) -> None:
    out = tmp_path / "run.mcap"
    for motion in ("forward-turn", "8-connected"):
        options = PAPER | {"motion": motion, "radio": radio, "traffic": "pibt", "range_m": 3.0}
        grid = conav.builtin_map("three-obstacles", seed=2, **SMALL)
        done = conav.explore(
            grid, strategy="potential-quiet", settings=settings, seed=2, out=out, **options
        )
        assert done.status == "done"
        report = conav.verify_exploration(conav.read_run(out))
        assert report.accepted, report.lines()


@pytest.mark.parametrize("radio", [{"delay_s": 3.0}, {"loss": 0.4}, {"loss": 0.2, "delay_s": 2.0}])
@pytest.mark.parametrize("settings", [{"every": 20}, {"every": 0, "within_m": 3.0}])
def test_slow_and_lossy_radios(
    settings: dict[str, Any], radio: dict[str, float], tmp_path: Path
) -> None:
    out = tmp_path / "run.mcap"
    run = recorded(out, settings=settings, seed=2, max_time_s=8000.0, **radio)
    assert run.result is not None
    assert run.result["status"] == "done"
    report = conav.verify_exploration(run)
    assert report.accepted, report.lines()
    assert sum(len(step.told) for step in run.steps) > 3 * 10
    assert any(step.quiet.any() for step in run.steps)


def test_who_talks_through_a_slow_radio_waits_for_the_answer(tmp_path: Path) -> None:
    run = recorded(tmp_path / "run.mcap", settings={"every": 20}, delay_s=2.0)
    for number, on in enumerate(radios(run)[:-1]):
        assert on == [number % 20 <= 3 * 2] * 3


@given(
    every=st.integers(0, 12),
    within=st.sampled_from([0.0, 0.5, 2.0, 5.0, 1e6]),
    news=st.sampled_from([0, 1, 10, 10**6]),
    seed=st.integers(0, 1000),
    radio=st.sampled_from(["perfect", 4.0, "off"]),
)
@hypothesis_settings(max_examples=25, deadline=None)
def test_any_rule_is_accepted(
    tmp_path_factory: pytest.TempPathFactory,
    every: int,
    within: float,
    news: int,
    seed: int,
    radio: str | float,
) -> None:
    if every == 0 and within == 0.0:
        with pytest.raises(ValueError, match="never be on"):
            PotentialQuiet(every=every, within_m=within)
        return
    settings = {"every": every, "within_m": within, "news": news}
    path = tmp_path_factory.mktemp("runs") / "run.mcap"
    run = recorded(path, seed=seed, settings=settings, radio=radio, max_time_s=60.0)
    report = conav.verify_exploration(run)
    assert report.accepted, report.lines()
    if news == 10**6:
        assert not np.array([step.messages for step in run.steps[1:]]).any()
    if within == 1e6 and news == 0:
        assert all(not step.quiet.any() for step in run.steps)


@pytest.mark.parametrize(
    "settings",
    [
        {"every": -1},
        {"every": 0},
        {"within_m": -2.0},
        {"within_m": inf},
        {"within_m": "nan"},
        {"news": -3},
        {"epsilon": 2},
        {"every": "often"},
    ],
)
def test_settings_out_of_range_name_the_page(settings: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r"docs/strategies/potential-quiet\.md") as caught:
        conav.explore("maze", strategy="potential-quiet", settings=settings)
    assert "\n" not in str(caught.value)
