"""The study of many plans: a sample of it holds, and it goes on where it was stopped."""

from dataclasses import asdict
from pathlib import Path

import pytest

import conav.experiments.plan_study as study
from conav.experiments.compare.outcome import Failure
from conav.experiments.plan_study import (
    COSTS,
    EFFORT,
    ENDINGS,
    ROBOTS,
    STUDIED,
    TASKS,
    Verdict,
    plan_study,
    problem_of,
    solver_of,
    tallies,
)
from conav.planning.catalogue import SOLVERS
from conav.planning.scene_writer import scene_text
from conav.planning.types import PLANNING_MOTIONS

SAMPLE = 30


def test_no_plan_of_a_sample_breaks_a_rule(tmp_path: Path) -> None:
    found = plan_study(tmp_path, SAMPLE, samples=60)
    rows = {row.solver: row for row in tallies(found)}
    everything = rows["all"]
    assert everything.plans == SAMPLE
    assert everything.errors == everything.violated == everything.collisions == 0
    assert everything.verified + everything.partly == SAMPLE
    assert everything.done > SAMPLE // 2
    assert {row.plans for name, row in rows.items() if name != "all"} == {SAMPLE // len(STUDIED)}
    assert not list(tmp_path.glob("*.mcap"))  # only broken ones are kept


def test_cases_go_through_everything() -> None:
    cases = range(len(STUDIED) * len(ROBOTS) * len(ENDINGS))
    problems = [problem_of(case) for case in cases]
    assert {solver_of(case) for case in cases} == set(EFFORT) <= set(SOLVERS)
    assert {len(problem.robots) for problem in problems} == set(ROBOTS)
    endings = [{robot.after_arrival for robot in problem.robots} for problem in problems]
    assert {"stay"} in endings
    assert {"vanish"} in endings
    assert {"stay", "vanish"} in endings
    assert {problem.costs for problem in problems} == set(COSTS)
    assert {robot.task for problem in problems for robot in problem.robots} == set(TASKS)
    assert all(len({r.radius_m for r in p.robots}) == len(p.robots) for p in problems)
    motions: dict[str, set[str]] = {solver_of(case): set() for case in cases}
    for case, problem in zip(cases, problems, strict=True):
        motions[solver_of(case)] |= {robot.motion for robot in problem.robots}
    assert motions["social-optimum"] == {"single-integrator"}
    assert motions["inash"] == set(PLANNING_MOTIONS)
    assert scene_text(problem_of(17)) == scene_text(problem_of(17))


def test_a_study_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    played: list[int] = []

    def play(case: int, folder: Path, samples: int) -> Verdict:
        played.append(case)
        if case == 1 and played.count(1) == 1:
            raise RuntimeError("boom")
        broken = ("collisions",) if case == 2 else ()
        return Verdict(
            solver_of(case), 2, "stay", ("F a",), "done", "violated" if broken else "verified",
            broken, (), 0.1 * case, case == 3, 0.5,
        )  # fmt: skip

    monkeypatch.setattr(study, "play", play)
    first = plan_study(tmp_path, 3)
    assert isinstance(first[1], Failure)
    assert "boom" in first[1].message
    row = tallies(first)[-1]
    assert (row.plans, row.errors, row.violated, row.collisions) == (3, 1, 1, 1)
    told: list[tuple[int, int]] = []
    second = plan_study(tmp_path, 5, progress=lambda done, total: told.append((done, total)))
    assert played == [0, 1, 2, 1, 3, 4]  # those that failed are played again
    assert told[-1] == (5, 5)
    row = tallies(second)[-1]
    assert (row.plans, row.errors, row.verified, row.timeouts) == (5, 0, 4, 1)
    assert row.clearance_m == 0.0
    assert Verdict.read(asdict(second[4])) == second[4]
    with pytest.raises(TypeError):
        Verdict.read({"solver": "x"})
