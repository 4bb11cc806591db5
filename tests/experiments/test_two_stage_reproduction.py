"""The reproduction of the two-stage paper: measures by hand, verdicts, and what it writes."""

import csv
import json
import sys
from dataclasses import replace
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from conav.cli import run
from conav.errors import InputError
from conav.experiments.compare.journal import JOURNAL
from conav.experiments.compare.outcome import Failure
from conav.experiments.potential_games.report import HELD, NOT_HELD, OPEN
from conav.experiments.two_stage.claims import (
    balance,
    exploration_time,
    frame_transformations,
    unfinished,
)
from conav.experiments.two_stage.drift import Drift, replay
from conav.experiments.two_stage.lab import Runner
from conav.experiments.two_stage.paths import (
    changes,
    directions,
    lengths,
    spread,
    stretches,
    turn_between,
    turns_of,
)
from conav.experiments.two_stage.play import Played, Track, play, target_of, task_of
from conav.experiments.two_stage.reproduce import reproduce
from conav.experiments.two_stage.results import Results, numbers_text, ranking
from conav.experiments.two_stage.world import (
    Case,
    World,
    all_cases,
    case_key,
    problem_of,
    strategy_of,
)
from conav.exploration.nearest import NearestMemory
from conav.exploration.rectangle_drive import Rectangle
from conav.exploration.team_assignment import TeamMemory
from conav.exploration.two_stage_flow import Phase
from conav.exploration.two_stage_turn import TwoStageMemory
from conav.simulation.run_exploration import run_exploration

SMALL = World(side_m=24.0)


def path(*places: tuple[float, float]) -> np.ndarray:
    return np.array(places, dtype=float)


# --- paths ----------------------------------------------------------------------------------------


def test_turns_by_hand() -> None:
    # East twice, north, a stop, north, back south, south-west.
    one = path((0, 0), (1, 0), (2, 0), (2, 1), (2, 1), (2, 2), (2, 1), (1, 0))
    assert directions(one) == [0, 0, 2, -1, 2, 6, 5]
    turns = turns_of(one)
    # 90 degrees, 180, and 45.
    assert turns.count == 3
    assert turns.angle == pytest.approx(pi * (0.5 + 1.0 + 0.25))
    assert turns.length_m == pytest.approx(5 + sqrt(2))
    assert lengths(one).tolist() == pytest.approx([0, 1, 2, 3, 3, 4, 5, 5 + sqrt(2)])


def test_a_turn_is_the_shorter_way_round() -> None:
    assert [turn_between(0, k) for k in range(8)] == [0, 1, 2, 3, 4, 3, 2, 1]
    assert turn_between(7, 1) == 2


def test_standing_still_has_no_turns_and_no_length() -> None:
    still = turns_of(path((3, 3), (3, 3)))
    assert (still.count, still.angle, still.length_m) == (0, 0.0, 0.0)


def test_stretches_by_hand() -> None:
    """With a reach of 2: bases at 0, 3 and 6 of a straight line to 7."""
    line = path(*[(float(x), 0.0) for x in range(8)])
    assert stretches(line, 2.0) == 3
    assert stretches(line, 100.0) == 1
    # To and fro within reach is one.
    assert stretches(path((0, 0), (2, 0), (0, 0), (2, 0)), 2.0) == 1


def test_spread_by_hand() -> None:
    assert spread([5.0, 5.0]) == 0.0
    assert spread([1.0, 3.0]) == pytest.approx(0.25)  # shares 1/4 and 3/4
    assert spread([0.0, 0.0]) == 0.0


# --- frame transformations ------------------------------------------------------------------------


def test_targets_and_tasks_of_a_rectangle() -> None:
    """Each edge is a target of its own; the rectangle with the way to it is one task."""
    memory = TwoStageMemory()
    targets, tasks = [target_of(memory)], [task_of(memory)]
    memory.phase = Phase.APPROACH
    memory.goal_lane = (8, 25, 1)
    targets.append(target_of(memory))
    tasks.append(task_of(memory))
    memory.phase = Phase.SCAN
    memory.rectangle = Rectangle(0, 1, 8, 25, 40)
    for leg in (0, 0, 1, 2, 3):
        memory.rectangle.leg = leg
        targets.append(target_of(memory))
        tasks.append(task_of(memory))
    memory.phase = Phase.AUCTION
    targets.append(target_of(memory))
    tasks.append(task_of(memory))
    memory.phase = Phase.REST
    memory.rectangles = 1
    memory.rest = NearestMemory(goal=7)
    targets.append(target_of(memory))
    tasks.append(task_of(memory))
    assert changes(targets) == 1 + 4 + 1
    assert changes(tasks) == 1 + 1


def test_targets_of_frontier_methods_are_their_goals() -> None:
    keys = []
    for goal in (-1, 5, 5, 9, -1, 9, 5):
        memory = TeamMemory()
        memory.drive.goal = goal
        assert target_of(memory) == task_of(memory)
        keys.append(target_of(memory))
    assert changes(keys) == 3  # 5, 9, 5


# --- drift ----------------------------------------------------------------------------------------

NO_NOISE = Drift(0.0, 0.0, 0.0, near_m=1.0, apart_s=10.0)


def there_and_back(metres: int) -> np.ndarray:
    out = [(float(x), 0.5) for x in range(metres + 1)]
    return path(*out, *out[-2::-1])


def generators(count: int, seed: int = 0) -> list[np.random.Generator]:
    return [np.random.default_rng([seed, robot]) for robot in range(count)]


def test_without_noise_there_is_no_error() -> None:
    found = replay([there_and_back(20)], 1.0, NO_NOISE, generators(1), closing="own")
    assert (found.final_m, found.mean_m) == (0.0, 0.0)


def test_closures_by_hand() -> None:
    """There and back along 20 m at 1 m/s, places 10 s apart, none sooner than 10 s after another.

    Back at x = 15 it was there 10 s before; within 1 m lies 14, of 11 s before; so the first
    closure is where 14 is near, on arriving at 15. Then at x = 5, ten steps on.
    """
    found = replay([there_and_back(20)], 1.0, NO_NOISE, generators(1), closing="own")
    assert found.closures == 2
    assert replay([there_and_back(20)], 1.0, NO_NOISE, generators(1), closing="none").closures == 0
    never = replace(NO_NOISE, apart_s=1000.0)
    assert replay([there_and_back(20)], 1.0, never, generators(1), closing="own").closures == 0


def test_a_closed_loop_takes_over_the_error_of_the_place() -> None:
    """A loop that ends where it began has the error it began with: none."""
    side = 12
    square = [(float(x), 0.5) for x in range(side)]
    square += [(float(side), 0.5 + y) for y in range(side)]
    square += [(float(side - x), 0.5 + side) for x in range(side)]
    square += [(0.0, 0.5 + side - y) for y in range(side + 1)]
    # The start is near again one step before the end; there is no closure after that.
    noisy = Drift(0.05, 0.05, 0.0, near_m=0.5, apart_s=40.0)
    for seed in range(5):
        open_ = replay([path(*square)], 1.0, noisy, generators(1, seed), closing="none")
        closed = replay([path(*square)], 1.0, noisy, generators(1, seed), closing="own")
        assert closed.closures == 1
        assert closed.final_m == 0.0
        assert open_.final_m > 0.05
        assert closed.mean_m < open_.mean_m


def test_teammates_places_count_where_maps_are_shared() -> None:
    """The second robot crosses the start of the first, which never comes back."""
    first = path(*[(float(x), 0.5) for x in range(31)])
    second = path(*[(0.5, 30.5 - y) for y in range(31)])
    for closing, closures in (("none", 0), ("own", 0), ("shared", 1)):
        found = replay([first, second], 1.0, NO_NOISE, generators(2), closing=closing)
        assert found.closures == closures
    noisy = Drift(0.02, 0.0, 0.0, near_m=1.0, apart_s=10.0)
    alone = replay([first, second], 1.0, noisy, generators(2), closing="own")
    shared = replay([first, second], 1.0, noisy, generators(2), closing="shared")
    assert shared.final_m < alone.final_m


def test_noise_follows_the_square_root_of_what_was_driven() -> None:
    """Distance alone: after 25 m at 0.1 per root metre the error has deviation 0.5."""
    straight = path(*[(float(x), 0.5) for x in range(26)])
    errors = [
        replay([straight], 1.0, Drift(0, 0, 0.1), generators(1, seed), closing="none").final_m
        for seed in range(400)
    ]
    assert sqrt(float(np.mean(np.square(errors)))) == pytest.approx(0.5, rel=0.1)
    # Turns alone: one of 90 degrees, then 10 m straight, with 0.01 per quarter turn: 0.1 m.
    corner = path((0, 0), (1, 0), *[(1.0, float(y)) for y in range(1, 11)])
    errors = [
        replay([corner], 1.0, Drift(0, 0.01, 0), generators(1, seed), closing="none").final_m
        for seed in range(400)
    ]
    assert sqrt(float(np.mean(np.square(errors)))) == pytest.approx(0.1, rel=0.1)


def test_waits_change_no_noise() -> None:
    straight = path(*[(float(x), 0.5) for x in range(9)])
    waiting = path(*[(float(x // 2), 0.5) for x in range(17)])
    finals = {
        replay([one], 1.0, Drift(), generators(1), closing="none").final_m
        for one in (straight, waiting)
    }
    assert len(finals) == 1
    assert finals != {0.0}


def test_closing_is_checked() -> None:
    with pytest.raises(ValueError, match="none, own, shared"):
        replay([there_and_back(2)], 1.0, NO_NOISE, generators(1), closing="all")


# --- the world and its runs -----------------------------------------------------------------------


def test_the_world_is_the_papers() -> None:
    problem = problem_of(3, 0, World())
    plan = problem.plan
    assert plan.walls.shape == (202, 202)
    assert int((plan.walls == 0).sum()) * 0.25 == 100.0 * 100.0
    assert plan.lattice.cell_m == 0.5
    assert problem.step_s == 2.5
    assert {robot.sensor.range_m for robot in problem.robots} == {4.0}
    # A larger team has the smaller one's starts; they are all over the place.
    assert problem_of(10, 0, World()).starts[:3] == problem.starts
    cells = np.array([problem_of(1, seed, World()).starts[0] for seed in range(200)])
    for part in np.divmod(cells, 202):
        assert np.histogram(part, bins=4, range=(0, 202))[0].min() > 25


def test_robots_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="do not fit"):
        problem_of(60, 0, World(side_m=2.0))


def test_runs_that_are_the_same_are_played_once() -> None:
    cases = all_cases((1, 2), 2, 5)
    assert len(cases) == len(set(cases)) == 3 * 2 * 2 * 2
    assert [case.seed for case in cases] == [5] * 12 + [6] * 12
    assert len({case.played for case in cases}) == (2 + 1 + 1 + 2 + 1 + 2) * 2
    alone = {wait: play(Case("RAA", 1, wait, 0), SMALL) for wait in (0.0, 5.0)}
    assert alone[0.0] == alone[5.0]


def test_keys_tell_runs_apart() -> None:
    cases = {case.played for case in all_cases((1, 2), 2, 0)}
    assert len({case_key(case, SMALL) for case in cases}) == len(cases)
    assert case_key(Case("DTA", 1, 0.0, 0), SMALL) != case_key(Case("DTA", 1, 0.0, 0), World())


@pytest.mark.parametrize(("method", "side_m"), [("TSCA", 60.0), ("DTA", 36.0), ("RAA", 36.0)])
def test_a_run_is_what_the_simulator_says(method: str, side_m: float) -> None:
    """Watching changes nothing, and what it sees agrees with what a run reports itself."""
    case = Case(method, 2, 5.0, 3)
    large = World(side_m)
    played = play(case.played, large)
    plain = run_exploration(problem_of(2, 3, large), strategy_of(case), name="plain")
    assert played.status == plain.status == "done"
    assert played.time_s == plain.metrics.time_s
    assert played.path_m == pytest.approx(sum(plain.metrics.path_m))
    assert played.balance == pytest.approx(plain.metrics.balance["path"])
    assert played.bound_s < played.time_s
    assert played.messages > 0
    assert played.rounds > 0
    assert (played.bids > 0) == (method != "DTA")
    assert (played.balance_first is None) == (method != "TSCA")
    assert played.tasks <= played.targets


def test_waiting_stands_still() -> None:
    waits = {wait: play(Case("RAA", 2, wait, 1), SMALL) for wait in (0.0, 5.0)}
    assert waits[5.0].still > waits[0.0].still
    assert waits[5.0].time_s > waits[0.0].time_s


def test_the_board_is_seen_when_all_are_in_stage_2() -> None:
    trace = Runner(SMALL).trace(Case("TSCA", 1, 0.0, 1))
    assert trace.board is not None
    step, axis, sections = trace.board
    assert 0 < step < len(trace.paths[0])
    assert axis in (0, 1)
    assert all(lower <= upper for lower, upper in sections)
    assert Track().board is None


def test_what_cannot_be_played_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError("no luck")

    monkeypatch.setattr("conav.experiments.two_stage.lab.play", broken)
    found = Runner(SMALL).run(Case("TSCA", 1, 0.0, 0))
    assert isinstance(found, Failure)
    assert "RuntimeError: no luck" in found.message


# --- verdicts -------------------------------------------------------------------------------------

RUN = Played(
    status="done", time_s=100.0, bound_s=50.0, path_m=10.0, balance=0.1, balance_first=0.2,
    second_s=30.0, still=0.1, targets=5, tasks=5, stretches=3, turns=4, turned=2.0, rounds=3,
    bids=4, messages=6, bytes=100, closures_own=0, closures_shared=0, error_none_m=1.0,
    error_own_m=1.0, error_shared_m=1.0, mean_none_m=1.0, mean_own_m=1.0, mean_shared_m=1.0,
)  # fmt: skip


def results(times: dict[str, list[float]], **more: float) -> Results:
    """Runs of one robot with these times by method, the same with both waits."""
    found = {
        Case(method, 1, wait, seed): replace(RUN, time_s=time, **more if method == "TSCA" else {})
        for method, values in times.items()
        for wait in (5.0, 0.0)
        for seed, time in enumerate(values)
    }
    return Results(found, (1,), (0, 1, 2))


def test_verdicts_on_time_follow_from_the_interval() -> None:
    section = exploration_time(
        results({"TSCA": [90, 91, 92], "DTA": [180, 182, 184], "RAA": [45, 45.5, 46]})
    )
    against = {
        verdict.claim.partition(": ")[0]: (verdict.verdict, verdict.numbers)
        for verdict in section.verdicts
    }
    assert against["saves time against DTA"] == (
        HELD,
        "time of TSCA over DTA: 0.500 [0.500, 0.500]",
    )
    assert against["saves time against RAA"][0] == NOT_HELD
    assert len(section.verdicts) == 4
    # 90 s over a bound of 50 s, and so on.
    assert "(1.82)" in section.table[0][1]
    close = exploration_time(
        results({"TSCA": [90, 100, 110], "DTA": [100, 90, 105], "RAA": [100, 100, 100]})
    )
    assert {verdict.verdict for verdict in close.verdicts} == {OPEN}


def test_verdicts_over_team_sizes_need_every_size() -> None:
    found = {}
    for robots, turns in ((1, 2), (2, 9)):
        for seed in range(3):
            for method in ("TSCA", "DTA", "RAA"):
                value = turns if method == "TSCA" else 4
                run = replace(RUN, turns=value + seed, targets=value, tasks=1)
                found[Case(method, robots, 5.0, seed)] = run
    section = frame_transformations(Results(found, (1, 2), (0, 1, 2)))
    verdicts = {verdict.claim: verdict for verdict in section.verdicts}
    turn = verdicts["saves frame transformations (turn), against DTA"]
    assert turn.verdict == NOT_HELD
    assert turn.numbers.startswith("held with 1; did not hold with 2 robots.")
    assert "-2.00" in turn.numbers
    assert "5.00" in turn.numbers
    assert verdicts["saves frame transformations (task), against RAA"].verdict == OPEN  # equal
    rankings = {(row[0], row[1]): row[-1] for row in section.table}
    assert rankings["1", "turn"] == "TSCA < DTA = RAA"
    assert rankings["2", "target"] == "DTA = RAA < TSCA"


def test_verdict_on_balance() -> None:
    def runs(ends: list[float]) -> Results:
        found = {
            Case("TSCA", 2, 5.0, seed): replace(RUN, balance=end, balance_first=0.2)
            for seed, end in enumerate(ends)
        }
        return Results(found, (2,), tuple(range(len(ends))))

    assert [one.verdict for one in balance(runs([0.1, 0.11, 0.12])).verdicts] == [HELD]
    assert [one.verdict for one in balance(runs([0.3, 0.31, 0.32])).verdicts] == [NOT_HELD]
    assert [one.verdict for one in balance(runs([0.0, 0.2, 0.4])).verdicts] == [OPEN]


def test_missing_runs_and_failures_leave_gaps() -> None:
    found = {Case("TSCA", 1, 5.0, 0): RUN, Case("DTA", 1, 5.0, 0): Failure("no")}
    some = Results(found, (1,), (0,))
    assert unfinished(some) == (0, 1)
    section = exploration_time(some)
    assert section.verdicts == []
    assert section.table[0][3] == "-"
    late = Results({Case("TSCA", 1, 5.0, 0): replace(RUN, status="stuck")}, (1,), (0,))
    assert unfinished(late) == (1, 0)


def test_numbers_and_rankings_as_text() -> None:
    assert numbers_text([4]) == "4"
    assert numbers_text([1, 2, 4, 5, 6]) == "1, 2, 4 to 6"
    assert ranking({"TSCA": 3.0, "DTA": 1.0}, most=True) == "TSCA > DTA"


# --- the whole ------------------------------------------------------------------------------------

OPTIONS = {"robots": (1, 2), "runs": 2, "side_m": 32.0}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    found = reproduce(folder, **OPTIONS)
    assert (found.cases, found.done, found.unfinished, found.failed) == (24, 24, 0, 0)
    return folder


def test_all_is_on_the_page(made: Path) -> None:
    page = (made / "README.md").read_text()
    pictures = {file.name for file in made.glob("*.png")}
    assert {f"figure-{name}.png" for name in ("1", "2", "3a", "3b", "3c", "3d", "4")} < pictures
    for picture in pictures:
        assert f"]({picture})" in page
    assert "conav reproduce two-stage --runs 2 --robots 1,2 --side 32`" in page
    assert "were played." not in page
    with (made / "numbers.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert {row["method"] for row in rows} >= {"TSCA", "DTA", "RAA", "TSCA/DTA", "TSCA/RAA"}
    for row in rows:
        value = float(row["value"])
        if row["low"]:
            assert float(row["low"]) <= value * (1 + 1e-5) + 1e-9
            assert value <= float(row["high"]) * (1 + 1e-5) + 1e-9
    with (made / "runs.csv").open() as stream:
        runs = list(csv.DictReader(stream))
    assert len(runs) == (2 + 1 + 1 + 2 + 1 + 2) * 2
    assert {run["status"] for run in runs} == {"done"}


def test_the_same_again_on_several_processes(made: Path, tmp_path: Path) -> None:
    reproduce(tmp_path, **OPTIONS, jobs=2, plots=False)
    for name in ("numbers.csv", "runs.csv"):
        assert (tmp_path / name).read_bytes() == (made / name).read_bytes()


def test_it_goes_on_where_it_was_killed(made: Path, tmp_path: Path) -> None:
    lines = (made / JOURNAL).read_bytes().splitlines(keepends=True)
    (tmp_path / JOURNAL).write_bytes(b"".join(lines[:10]) + lines[10][:40])
    told: list[tuple[int, int]] = []
    reproduce(tmp_path, **OPTIONS, plots=False, progress=lambda *now: told.append(now))
    assert told[0] == (10, 18)
    assert told[-1] == (18, 18)
    assert (tmp_path / "runs.csv").read_bytes() == (made / "runs.csv").read_bytes()


def test_an_interrupt_keeps_what_was_done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left = 5
    honest = Runner.run

    def interrupted(self: Runner, case: Case) -> Played | Failure:
        nonlocal left
        left -= 1
        if left < 0:
            raise KeyboardInterrupt
        return honest(self, case)

    monkeypatch.setattr(Runner, "run", interrupted)
    found = reproduce(tmp_path, robots=(1,), runs=2, side_m=24.0)
    assert found.interrupted
    assert "cases were played." in (tmp_path / "README.md").read_text()
    with (tmp_path / "runs.csv").open() as stream:
        assert len(list(csv.DictReader(stream))) == 5
    assert not list(tmp_path.glob("*.png"))


def test_without_matplotlib_there_are_numbers_and_one_warning(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "matplotlib"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    (tmp_path / JOURNAL).write_bytes((made / JOURNAL).read_bytes())
    found = reproduce(tmp_path, **OPTIONS)
    assert len(found.warnings) == 1
    assert 'pip install "conav[plot]"' in found.warnings[0]
    assert "png" not in (tmp_path / "README.md").read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"runs": 0}, "runs 0: is out of range"),
        ({"jobs": 0}, "jobs 0: is out of range"),
        ({"robots": ()}, "names no team size"),
        ({"robots": (2, 0)}, "robots 0: is out of range"),
        ({"motion": "flying"}, "use one of: "),
        ({"side_m": 5.0}, "side 5: is out of range"),
        ({"seed": -1}, "seed -1: is out of range"),
    ],
)
def test_bad_numbers_are_named(tmp_path: Path, arguments: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        reproduce(tmp_path, **arguments)


def test_the_page_of_something_else_stays(tmp_path: Path) -> None:
    (tmp_path / "README.md").write_text("# mine\n")
    with pytest.raises(InputError, match="of something else"):
        reproduce(tmp_path, **OPTIONS)
    assert (tmp_path / "README.md").read_text() == "# mine\n"


def test_command(made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / JOURNAL).write_bytes((made / JOURNAL).read_bytes())
    world = ["--side", "32", "--runs", "2", "--jobs", "1", "--no-plots"]
    command = ["reproduce", "two-stage", "--robots", "1,2", *world, "--out", str(tmp_path)]
    assert run([*command, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["paper"], said["cases"], said["done"]) == ("two-stage", 24, 24)
    assert {verdict["verdict"] for verdict in said["verdicts"]} <= {HELD, NOT_HELD, OPEN}
    assert run(["reproduce", "two-stage", "--robots", "1,two"]) == 2
    assert "'two' is not a whole number" in capsys.readouterr().err
    (tmp_path / "file").write_text("")
    assert run([*command[:-1], str(tmp_path / "file")]) == 2
    assert str(tmp_path / "file") in capsys.readouterr().err
