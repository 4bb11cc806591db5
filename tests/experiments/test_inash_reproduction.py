"""The reproduction of iNash-trajectory: its plans, its verdicts, its page."""

import csv
import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from conav.cli import run
from conav.errors import InputError
from conav.experiments.compare.journal import JOURNAL
from conav.experiments.compare.outcome import Failure
from conav.experiments.inash.claims import lengths, success
from conav.experiments.inash.game_claims import checks, equilibria, messages, prices
from conav.experiments.inash.lab import Runner
from conav.experiments.inash.play import Played, Watch, looked_over, play
from conav.experiments.inash.reproduce import reproduce
from conav.experiments.inash.results import (
    LEAST_TRIALS,
    Results,
    each_trial,
    less,
    means_of,
    more,
    over_trials,
    paired_difference,
    slope,
)
from conav.experiments.inash.world import (
    ANYTIME,
    EXPERIMENTS,
    INASH,
    METHODS,
    ON_PAPER_GRAPHS,
    OURS,
    PLAIN,
    Case,
    Effort,
    all_cases,
    case_key,
    problem_of,
    settings_of,
)
from conav.experiments.potential_games.report import HELD, NOT_HELD, OPEN, Verdict
from conav.intervals import Estimate
from conav.planning.budget import Progress
from conav.planning.catalogue import make_solver
from conav.planning.plan import plan
from conav.planning.types import Trajectory

SMALL = Effort(samples=400, batch=50)

# --- the world ------------------------------------------------------------------------------------


def test_the_papers_tables() -> None:
    """Row sums, added up by hand from the paper."""
    sums = {
        (name, method): sum(counts)
        for name, about in EXPERIMENTS.items()
        for method, counts in about.reached.items()
    }
    assert sums == {
        ("discs", INASH): 143, ("discs", PLAIN): 148, ("discs", ANYTIME): 157,
        ("intersection", INASH): 82, ("intersection", PLAIN): 85, ("intersection", ANYTIME): 111,
    }  # fmt: skip
    assert [len(about.reached[INASH]) for about in EXPERIMENTS.values()] == [8, 6]


def test_a_trial_is_the_same_scene_for_all_methods_and_teams() -> None:
    for name, about in EXPERIMENTS.items():
        starts = {
            method: [
                robot.start for robot in problem_of(Case(name, method, about.robots, 3)).robots
            ]
            for method in METHODS
        }
        assert len({tuple(one) for one in starts.values()}) == 1
        small = problem_of(Case(name, INASH, 4, 3)).robots
        assert [robot.start for robot in small] == starts[INASH][:4]
        assert {robot.radius_m for robot in small} == {0.5}


def test_numbers_at_the_intersection_are_dealt() -> None:
    trials = [problem_of(Case("intersection", INASH, 6, trial)).robots for trial in range(40)]
    places = {frozenset(robot.start for robot in robots) for robots in trials}
    assert len(places) == 1
    assert {robots[0].start for robots in trials} == next(iter(places))  # everybody is first once
    assert [robot.name for robot in trials[7]] == [f"robot_{number}" for number in range(6)]
    # A start keeps its goal.
    assert len({(r.start, r.regions["goal"].disc) for robots in trials for r in robots}) == 6


def test_scenes_do_not_change_unnoticed() -> None:
    """The page's numbers are of these; if they change, make the page anew."""
    discs = problem_of(Case("discs", INASH, 8, 0))
    assert discs.robots[0].start == pytest.approx((17.00260669307909, 1.789365447376615))
    assert discs.discs.sum() == pytest.approx(204.46967320659527)
    dealt = problem_of(Case("intersection", INASH, 6, 0))
    assert [robot.start for robot in dealt.robots] == [
        (-6.0, -1.5), (-1.5, 6.0), (8.2, 1.5), (1.5, -8.2), (1.5, -6.0), (6.0, 1.5),
    ]  # fmt: skip


def test_obstacles_are_new_in_each_trial() -> None:
    discs = [problem_of(Case("discs", PLAIN, 8, trial)).discs for trial in (0, 1)]
    assert discs[0].shape == discs[1].shape == (10, 3)
    assert not np.array_equal(discs[0], discs[1])


def test_methods_of_the_paper_have_the_same_graphs() -> None:
    graphs = []
    for method in ON_PAPER_GRAPHS:
        case = Case("intersection", method, 6, 1)
        solver, settings = settings_of(case, SMALL)
        graphs.append(plan(problem_of(case), solver, seed=1, settings=settings).graphs)
    for other in graphs[1:]:
        assert all(np.array_equal(a, b) for a, b in zip(graphs[0], other, strict=True))


def test_cases_and_keys() -> None:
    cases = all_cases(2, 5)
    # Four methods, and three and two smaller teams of iNash.
    assert len(cases) == len(set(cases)) == 2 * (4 + 3 + 4 + 2)
    assert [case.trial for case in cases] == [5] * 13 + [6] * 13
    assert len({case_key(case, SMALL) for case in cases}) == len(cases)
    # A batch is nothing to a method that has no iterations; samples are something to all.
    plain = Case("discs", PLAIN, 8, 0)
    assert case_key(plain, Effort()) == case_key(plain, Effort(batch=7))
    assert case_key(plain, Effort()) != case_key(plain, Effort(samples=7))
    shared = plain._replace(method=INASH)
    assert case_key(shared, Effort()) != case_key(shared, Effort(batch=7))


# --- a plan ---------------------------------------------------------------------------------------


def told(stage: str, *costs: float) -> Progress:
    return Progress(stage, 1, 1, np.array(costs)[:, None])


def test_watching_counts_announcements_and_rises() -> None:
    inf = float("inf")
    watch = Watch()
    watch(told("game", inf, inf, inf))
    assert (watch.most, watch.sent, watch.rises) == (0, 0, 0)
    watch(told("game", 5.0, inf, 4.0))  # two first paths
    watch(told("game", 3.0, 9.0, 4.0))  # two old ones, two new ones
    assert (watch.most, watch.sent, watch.rises) == (4, 6, 0)
    watch(told("last answers", 3.0, 8.0, 4.0))  # only what is new
    assert (watch.most, watch.sent, watch.rises) == (4, 7, 0)
    watch(told("game", 3.0, inf, 4.5))
    assert watch.rises == 1


def test_a_plan_of_inash_is_what_the_planner_says() -> None:
    case = Case("intersection", INASH, 6, 0)
    effort = Effort(samples=1500, batch=50)
    solver, settings = settings_of(case, effort)
    watch = Watch()
    found = plan(problem_of(case), solver, seed=0, settings=settings, on_progress=watch)
    assert watch.sent == found.counters["messages"] > 0
    played = play(case, effort)
    assert played.messages == watch.sent
    assert played.iterations == 30
    assert 0 < played.most_messages <= 12
    assert played.rises == 0
    assert played.in_equilibrium
    assert played.gains_checked
    assert played.broken == ()
    assert played.clearance_m is None or played.clearance_m >= 0
    assert played.reached == tuple(np.isfinite(found.costs[:, 0]).tolist())
    assert any(played.reached)
    assert all(one is None or one >= 1 - 1e-9 for one in played.ratios)
    kept = json.loads(json.dumps(played.__dict__))
    assert Played.read(kept) == played
    with pytest.raises(TypeError):
        Played.read({"status": "done"})


def test_breaches_are_seen() -> None:
    case = Case("intersection", OURS, 6, 0)
    solver, settings = settings_of(case, SMALL)
    problem = problem_of(case)
    found = plan(problem, solver, seed=0, settings=settings)
    clearance, broken = looked_over(problem, found)
    assert broken == ()
    assert clearance is not None
    assert clearance >= 0
    first = found.trajectories[0]
    assert first is not None
    twice = replace(found, trajectories=(first, first, *found.trajectories[2:]))
    clearance, broken = looked_over(problem, twice)
    assert clearance == pytest.approx(-1.0)  # two discs of half a metre on one place
    assert {"starts", "collisions", "tasks"} <= set(broken)
    pieces = first.pieces.copy()
    pieces[:, 2] += 20.0
    off = replace(found, trajectories=(Trajectory(pieces), *found.trajectories[1:]))
    assert {"starts", "walls"} <= set(looked_over(problem, off)[1])


def test_gains_are_found_again() -> None:
    """Of all methods on the paper's graphs; a wrong account of them is a breach."""
    effort = Effort(samples=1500, batch=100)
    for method in ON_PAPER_GRAPHS:
        case = Case("intersection", method, 6, 0)
        assert play(case, effort).gains_checked
    solver, settings = settings_of(case, effort)
    problem = problem_of(case)
    found = plan(problem, solver, seed=0, settings=settings)
    whole = asdict(make_solver(solver, settings))
    assert looked_over(problem, found, whole)[1] == ()
    false = replace(found, epsilon=np.full(6, 0.5))
    assert looked_over(problem, false, whole)[1] == ("equilibrium",)
    # A plan in which a robot goes without although its graph has a path.
    with_path = [way is not None for way in found.trajectories].index(True)
    ways = [None if i == with_path else way for i, way in enumerate(found.trajectories)]
    assert "equilibrium" in looked_over(problem, replace(found, trajectories=tuple(ways)), whole)[1]


def test_what_cannot_be_planned_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError("no luck")

    monkeypatch.setattr("conav.experiments.inash.lab.play", broken)
    found = Runner(SMALL).run(Case("discs", PLAIN, 8, 0))
    assert isinstance(found, Failure)
    assert "RuntimeError: no luck" in found.message


# --- estimates and verdicts -----------------------------------------------------------------------


def test_verdicts_follow_from_the_whole_interval() -> None:
    assert more(Estimate(2.0, 1.0, 3.0, 9), 0.5) == HELD
    assert more(Estimate(2.0, 1.0, 3.0, 9), 1.0) == OPEN
    assert more(Estimate(2.0, 1.0, 3.0, 9), 3.0) == NOT_HELD
    assert more(Estimate(0.0, 0.0, 0.0, 9), 0.0) == NOT_HELD
    assert more(Estimate(float("nan"), -1.0, 3.0, 9), 5.0) == OPEN
    assert less(Estimate(-2.0, -3.0, -1.0, 9), 0.0) == HELD
    assert less(Estimate(2.0, 1.0, 3.0, 9), 0.0) == NOT_HELD
    assert less(Estimate(2.0, -1.0, 3.0, 9), 0.0) == OPEN


def test_statistics_over_robots() -> None:
    nan = float("nan")
    table = np.array([[1.0, nan, 3.0], [2.0, nan, nan]])
    assert means_of(table)[[0, 2]].tolist() == [1.5, 3.0]
    assert np.isnan(means_of(table)[1])
    assert np.isnan(slope(table))
    a, b = np.array([[1.0, nan, 4.0], [nan, nan, nan]]), np.array([[0.0, 5.0, 1.0], [1.0] * 3])
    found = paired_difference(a, b)
    assert found is not None
    assert (found.value, found.n) == (2.0, 1)  # (1 + 3) / 2, and a trial that has no pair
    # Of a table without gaps each trial's slope has the slope of the means as its mean.
    rng = np.random.default_rng(1)
    whole = rng.random((12, 5))
    found = each_trial(slope, whole)
    assert found.value == pytest.approx(slope(whole))
    boot = over_trials(slope, whole)
    assert boot.value == pytest.approx(found.value)
    assert boot.low == pytest.approx(found.low, abs=0.02)
    assert over_trials(slope, whole, whole)[:3] == (0.0, 0.0, 0.0)
    assert over_trials(slope, whole[: LEAST_TRIALS - 1]).high == np.inf


PLAYED = Played(
    status="done", length_m=(2.0,) * 6, solo_m=(2.0,) * 6, gain_m=(0.0,) * 6, settled=True,
    gains_checked=True,
    clearance_m=0.1, broken=(), iterations=10, messages=50, most_messages=12, rises=0, checks=60,
)  # fmt: skip


def made_up(trials: int = 10, **plans: Played) -> Results:
    """Trials at the intersection with the same plan of a method in each; the rest is `PLAYED`."""
    names = {"plain": PLAIN, "anytime": ANYTIME, "inash": INASH, "ours": OURS}
    by_method = {names[name]: one for name, one in plans.items()}
    found = {
        Case("intersection", method, 6, trial): by_method.get(method, PLAYED)
        for method in METHODS
        for trial in range(trials)
    }
    return Results(found, tuple(range(trials)))


def verdict(verdicts: list[Verdict], *words: str) -> str:
    [found] = [one for one in verdicts if all(word in one.claim for word in words)]
    return found.verdict


def test_success_is_judged() -> None:
    late = replace(PLAYED, length_m=(2.0, 2.0, 2.0, 2.0, None, None))
    section = success(made_up(plain=late), "intersection")
    assert verdict(section.verdicts, "with prioritized, higher numbers") == HELD
    assert verdict(section.verdicts, "with any-time prioritized, higher") == NOT_HELD
    assert verdict(section.verdicts, "iNash shares the burden") == HELD
    assert verdict(section.verdicts, ": prioritized reaches more goals than iNash") == NOT_HELD
    assert verdict(section.verdicts, "any-time prioritized reaches more goals than prior") == HELD
    assert verdict(section.verdicts, "ours reaches more") == HELD  # 60 of 60: above 92.5 %
    [(header, rows)] = section.tables
    assert header == ("method", "1", "2", "3", "4", "5", "6", "all", "slope [points]")
    lines = {row[0]: row[1:] for row in rows}
    assert lines["prioritized, paper"] == ("19", "18", "19", "13", "12", "4", "70.8 %", "-14.1")
    assert lines["**prioritized, here**"][:7] == (
        "10", "10", "10", "10", "0", "0", "66.7 % [66.7, 66.7]",
    )  # fmt: skip
    poor = success(made_up(ours=late), "intersection")
    assert verdict(poor.verdicts, "ours reaches more") == NOT_HELD


def test_lengths_are_judged() -> None:
    rising = replace(PLAYED, length_m=(2.0, 2.2, 2.4, 2.6, 2.8, 3.0))
    section = lengths(made_up(plain=rising), "intersection")
    assert verdict(section.verdicts, "lower numbers have shorter paths") == HELD
    assert verdict(section.verdicts, "rise less with the number") == HELD
    assert verdict(section.verdicts, "are more even over numbers") == HELD
    assert verdict(section.verdicts, "iNash paths are longer") == NOT_HELD
    other = lengths(made_up(inash=rising), "intersection")
    assert verdict(other.verdicts, "lower numbers have shorter paths") == NOT_HELD
    assert verdict(other.verdicts, "are more even over numbers") == NOT_HELD
    assert verdict(other.verdicts, "iNash paths are longer") == HELD
    few = lengths(made_up(3, plain=rising), "intersection")
    assert verdict(few.verdicts, "are more even over numbers") == OPEN


def test_equilibria_are_judged() -> None:
    odd = replace(PLAYED, gain_m=(0.0, 0.3, None, 0.0, 0.0, 0.0), rises=2)
    section = equilibria(made_up(plain=odd))
    assert verdict(section.verdicts, "prioritized does", ": prioritized") == HELD
    assert verdict(section.verdicts, "any-time prioritized does") == NOT_HELD
    assert verdict(section.verdicts, "nobody's cost ever rises") == HELD
    bad = equilibria(made_up(inash=odd))
    assert verdict(bad.verdicts, "nobody's cost ever rises") == NOT_HELD
    assert verdict(bad.verdicts, "iNash ends in a Nash equilibrium") == NOT_HELD
    assert not replace(PLAYED, settled=False).in_equilibrium


def test_messages_and_checks_are_judged() -> None:
    assert verdict(messages(made_up()).verdicts, "two messages") == HELD
    chatty = replace(PLAYED, most_messages=13)
    assert verdict(messages(made_up(inash=chatty)).verdicts, "two messages") == NOT_HELD

    def teams(exponent: float) -> Results:
        whole = made_up()
        found = dict(whole.found)
        for robots in (2, 4, 6):
            for trial in whole.trials:
                one = replace(PLAYED, checks=round(1e6 * robots**exponent))
                found[Case("intersection", INASH, robots, trial)] = one
        return Results(found, whole.trials)

    assert verdict(checks(teams(0.9)).verdicts, "linearly") == HELD
    section = checks(teams(2.0))
    assert verdict(section.verdicts, "linearly") == NOT_HELD
    [row] = [row for row in section.rows if row.measure.startswith("exponent")]
    assert row.value == pytest.approx(2.0, abs=1e-6)


def test_prices_are_exact() -> None:
    section = prices(Results({}, (0,)))
    assert [one.verdict for one in section.verdicts] == [HELD]
    [(_, rows)] = section.tables
    assert ("corridor with a bay", "4", "11", "11 / 15", "1", "1.36") in rows


def test_trials_that_lack_a_method_do_not_count() -> None:
    whole = made_up(4)
    found = dict(whole.found)
    found[Case("intersection", OURS, 6, 2)] = Failure("no")
    del found[Case("intersection", PLAIN, 6, 0)]
    some = Results(found, whole.trials)
    assert some.paired("intersection") == [1, 3]
    assert some.reached("intersection", INASH).shape == (2, 6)
    nothing = Results({}, (0,))
    assert success(nothing, "discs").verdicts == []
    assert lengths(nothing, "discs").verdicts == []


# --- the whole ------------------------------------------------------------------------------------

OPTIONS = {"trials": 2, "samples": 300, "batch": 100}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    found = reproduce(folder, **OPTIONS)
    assert (found.cases, found.done, found.failed, found.broken) == (26, 26, 0, 0)
    return folder


def test_all_is_on_the_page(made: Path) -> None:
    page = (made / "README.md").read_text()
    assert "conav reproduce inash --trials 2 --samples 300 --batch 100`" in page
    assert "The budget was set by hand" in page
    assert "plans were made" not in page
    for picture in ("discs-goals.png", "intersection-goals.png"):
        assert (made / picture).is_file()
        assert f"]({picture})" in page
    for title in ("Eight robots", "Six robots", "Equilibria", "Prices", "Messages", "Collision"):
        assert f"## {title}" in page
    assert "nan" not in page
    with (made / "results.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert {row["method"] for row in rows} >= {*METHODS, f"{INASH} - {PLAIN}", "exact"}
    for row in rows:
        if row["low"] and row["high"] and row["value"]:
            assert float(row["low"]) <= float(row["value"]) * (1 + 1e-5) + 1e-9
            assert float(row["value"]) <= float(row["high"]) * (1 + 1e-5) + 1e-9
    with (made / "plans.csv").open() as stream:
        plans = list(csv.DictReader(stream))
    assert len(plans) == 26
    assert all(plan["broken"] == "" for plan in plans)


def test_it_goes_on_where_it_was_killed(made: Path, tmp_path: Path) -> None:
    lines = (made / JOURNAL).read_bytes().splitlines(keepends=True)
    (tmp_path / JOURNAL).write_bytes(b"".join(lines[:9]) + lines[9][:40])
    seen: list[tuple[int, int]] = []
    reproduce(tmp_path, **OPTIONS, plots=False, progress=lambda *now: seen.append(now))
    assert seen[0] == (9, 26)
    assert seen[-1] == (26, 26)
    for name in ("plans.csv", "results.csv"):
        assert (tmp_path / name).read_bytes() == (made / name).read_bytes()


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
    found = reproduce(tmp_path, **OPTIONS)
    assert found.interrupted
    assert "5 of 26 plans were made" in (tmp_path / "README.md").read_text()
    assert not list(tmp_path.glob("*.png"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"trials": 0}, "trials 0: is out of range"),
        ({"jobs": 0}, "jobs 0: is out of range"),
        ({"samples": 0}, "samples 0: is out of range"),
        ({"batch": 0}, "batch 0: is out of range"),
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
    effort = ["--trials", "2", "--samples", "300", "--batch", "100", "--jobs", "1", "--no-plots"]
    command = ["reproduce", "inash", *effort, "--out", str(tmp_path)]
    assert run([*command, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["paper"], said["cases"], said["done"]) == ("inash", 26, 26)
    assert {one["verdict"] for one in said["verdicts"]} <= {HELD, NOT_HELD, OPEN}
    assert run(["reproduce", "inash", "--trials", "many"]) == 2
    capsys.readouterr()
    (tmp_path / "file").write_text("")
    assert run([*command[:-1], str(tmp_path / "file")]) == 2
    assert str(tmp_path / "file") in capsys.readouterr().err
