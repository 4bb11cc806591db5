"""Very many plans over random scenes, each written, read again and verified.

Case k is a scene and a solver drawn from k alone: two to eight robots of different radii and speeds
on a square of random walls and discs, in every other scene of a solver that knows them some that
accelerate or turn, tasks of six forms over overlapping regions, costs of one or two components, and
robots that stay, vanish, or some of each. Every plan goes through a run file
and the verifier of `conav verify`; what it says is kept in a journal, so that a study that was
stopped goes on. Run files of plans that break a rule are kept beside it.
"""

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from math import isfinite
from pathlib import Path
from time import perf_counter
from typing import Any, cast

import numpy as np
import shapely

from conav import __version__
from conav.errors import InputError
from conav.experiments.compare.journal import JOURNAL, Journal
from conav.experiments.compare.outcome import Failure
from conav.experiments.compare.source import source_hash
from conav.maps.polygon_map import PolygonMap
from conav.planning.catalogue import SOLVERS, make_solver, settings_of
from conav.planning.floor import floor_between
from conav.planning.recorder import PlanRecorder
from conav.planning.types import (
    DOUBLE_INTEGRATOR,
    DUBINS_CAR,
    PLANNING_MOTIONS,
    SINGLE_INTEGRATOR,
    PlanningProblem,
    PlanningRobot,
    Region,
)
from conav.planning.verify import verify_plan
from conav.runs.reader import read_plan

ROBOTS = (2, 3, 4, 5, 6, 7, 8)
ENDINGS = ("stay", "vanish", "mixed")
COSTS = (("length",), ("duration",), ("length", "duration"))
TASKS = (
    "F a",
    "F a & F b",
    "(!b U a) & F b",
    "F a & G !c",
    "sequence(b, a) & G !c",
    "F (a | b)",
)
TIME_S = 60.0  # [s] wall time that ends a plan: a timeout
CLEARANCE_M = 0.05  # [m] between a start and what it must keep from

EFFORT: Mapping[str, Mapping[str, Any]] = {
    "inash": {},
    "prioritized": {},
    "anytime-prioritized": {},
    "inash-restarts": {"starts": 4},
    "social-optimum": {"nodes": 10, "last_nodes": 40, "labels": 1000},
}
"""Settings of each solver beside samples: enough for small scenes."""

STUDIED = tuple(EFFORT)

STRAIGHT = ("social-optimum",)
"""Those that plan for single integrators alone."""

Point = tuple[float, float]


@dataclass(frozen=True)
class Verdict:
    """What is kept of a plan."""

    solver: str
    robots: int
    ending: str
    task_forms: tuple[str, ...]
    status: str
    verdict: str  # of the verifier
    broken: tuple[str, ...]  # its checks that found a breach
    unchecked: tuple[str, ...]  # what it could not look at
    clearance_m: float | None  # between two robots beyond radii and margin, the lower bound
    timeout: bool
    compute_s: float  # wall time of the solver

    @staticmethod
    def read(content: dict[str, Any]) -> "Verdict":
        """The verdict that was kept. Raises `TypeError` for what is none."""
        if set(content) != {item.name for item in fields(Verdict)}:
            raise TypeError("no verdict")
        values: dict[str, Any] = {
            name: tuple(cast("list[Any]", value)) if isinstance(value, list) else value
            for name, value in content.items()
        }
        return Verdict(**values)


@dataclass(frozen=True)
class Tally:
    """A row of the table."""

    solver: str
    plans: int
    done: int
    out_of_budget: int
    infeasible: int
    verified: int
    partly: int
    violated: int
    collisions: int
    timeouts: int
    errors: int
    clearance_m: float | None


def solver_of(case: int) -> str:
    """The solver of a case."""
    return STUDIED[case % len(STUDIED)]


def problem_of(case: int) -> PlanningProblem:
    """The scene of a case; five cases in a row, one of each solver, have scenes of one team size.

    Not every scene has a plan: starts are free and apart, and nothing is asked of goals.
    """
    block = case // len(STUDIED)
    rng = np.random.Generator(np.random.PCG64([2014, case]))
    motions = np.random.Generator(np.random.PCG64([2015, case]))
    curved = solver_of(case) not in STRAIGHT and block % 2 == 1
    count = ROBOTS[block % len(ROBOTS)]
    ending = ENDINGS[(block // len(ROBOTS)) % len(ENDINGS)]
    costs = COSTS[int(rng.integers(0, 4)) % len(COSTS)]
    margin = float(rng.choice([0.0, 0.05]))
    side = 6.0 + 0.75 * count + float(rng.uniform(0.0, 3.0))
    outline = ((0.0, 0.0), (side, 0.0), (side, side), (0.0, side))
    walls = [_box(rng, side) for _ in range(int(rng.integers(0, 4)))]
    discs = [_disc(rng, side, 0.3, 0.8) for _ in range(int(rng.integers(0, 5)))]
    open_floor = PolygonMap(outline)
    floor = open_floor if not walls else floor_between(outline, (), walls)
    free = floor.polygon
    robots: list[PlanningRobot] = []
    for number in range(count):
        radius = float(rng.uniform(0.15, 0.4))
        start = _start(rng, side, free, discs, robots, radius + margin)
        regions = {
            name: Region(name, disc=_disc(rng, side, 0.4, 1.0))
            if rng.random() < 0.5
            else Region(name, polygon=_box(rng, side))
            for name in "abc"
        }
        motion = SINGLE_INTEGRATOR
        if curved:
            motion = PLANNING_MOTIONS[int(motions.integers(0, len(PLANNING_MOTIONS)))]
        then = ENDINGS[int(rng.integers(0, 2))] if ending == "mixed" else ending
        task = TASKS[int(rng.integers(0, len(TASKS)))]
        robots.append(
            PlanningRobot(
                f"r{number}",
                (*start, *_rest(motion, motions)),
                task,
                {name: region for name, region in regions.items() if _named(name, task)},
                radius,
                float(rng.uniform(0.6, 1.5)),
                acceleration_mps2=float(motions.uniform(0.5, 2.0)),
                turning_radius_m=float(motions.uniform(0.2, 0.6)),
                motion=motion,
                after_arrival="vanish" if then == "vanish" else "stay",
            )
        )
    horizon = float(rng.uniform(3.0, 6.0)) * side
    return PlanningProblem(
        floor,
        tuple(robots),
        horizon,
        np.array(discs, dtype=np.float64).reshape(-1, 3),
        costs,
        margin,
        f"case {case}",
    )


def play(case: int, folder: Path, samples: int = 120) -> Verdict:
    """The verdict on the plan of a case; its run file stays in the folder if it breaks a rule."""
    problem = problem_of(case)
    name = solver_of(case)
    settings = {"samples": samples, "batch": samples // 2, "time_s": TIME_S, **EFFORT[name]}
    if name == "prioritized":
        del settings["batch"]
    solver = make_solver(name, settings)
    path = folder / f"case-{case}.mcap"
    with PlanRecorder(
        path, problem, solver=name, settings=settings_of(solver), seed=case
    ) as recorder:
        started = perf_counter()
        result = solver.solve(problem, case, lambda progress: recorder.follow(progress))
        compute_s = perf_counter() - started
        recorder.finish(result, compute_s=compute_s)
    report = verify_plan(read_plan(path))
    if report.accepted:
        path.unlink()
    clearance = report.robots.low
    stays = {robot.after_arrival for robot in problem.robots}
    return Verdict(
        name,
        len(problem.robots),
        "mixed" if len(stays) == 2 else stays.pop(),
        tuple(sorted({robot.task for robot in problem.robots})),
        str(result.status),
        report.verdict,
        report.broken(),
        tuple(sorted({text.split(":")[0] for one in report.checks for text in one.unchecked})),
        clearance if isfinite(clearance) else None,
        compute_s >= TIME_S,
        compute_s,
    )


def plan_study(
    folder: Path,
    plans: int,
    *,
    samples: int = 120,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> dict[int, Verdict | Failure]:
    """What became of cases 0, 1, ... by number; those in the folder's journal are not played again.

    A solver or verifier that raises is kept as a failure. Raises `InputError` where the folder
    cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(folder, f"cannot be made ({error.strerror})", "name another") from None
    code = source_hash("conav.experiments.plan_study", "conav.planning.catalogue", *_modules())
    found: dict[int, Verdict | Failure] = {}
    with Journal(folder / JOURNAL, Verdict.read) as journal:
        for case in range(plans):
            key = json.dumps(
                {"conav": __version__, "code": code, "case": case, "samples": samples},
                sort_keys=True,
            )
            if not isinstance(journal.results.get(key), Verdict):
                try:
                    journal.add(key, play(case, folder, samples))
                except Exception as error:
                    journal.add(key, Failure(f"{type(error).__name__}: {error}"))
            found[case] = journal.results[key]
            progress(case + 1, plans)
    return found


def tallies(found: Mapping[int, Verdict | Failure]) -> list[Tally]:
    """A row for each solver, and one for all."""
    rows = [
        _tally(name, [one for case, one in found.items() if solver_of(case) == name])
        for name in STUDIED
    ]
    return [*rows, _tally("all", list(found.values()))]


def _tally(name: str, all_of: Sequence[Verdict | Failure]) -> Tally:
    kept = [one for one in all_of if isinstance(one, Verdict)]
    status, verdict = Counter(one.status for one in kept), Counter(one.verdict for one in kept)
    gaps = [one.clearance_m for one in kept if one.clearance_m is not None]
    return Tally(
        name,
        len(all_of),
        status["done"],
        status["out_of_budget"],
        status["infeasible"],
        verdict["verified"],
        verdict["partly checked"],
        verdict["violated"],
        sum("collisions" in one.broken or "walls" in one.broken for one in kept),
        sum(one.timeout for one in kept),
        len(all_of) - len(kept),
        min(gaps, default=None),
    )


def _modules() -> list[str]:
    return [SOLVERS[name].partition(":")[0] for name in STUDIED]


def _rest(motion: str, rng: np.random.Generator) -> tuple[float, ...]:
    """What a start has beside its place: a robot that accelerates is at rest, a car looks about."""
    if motion == DOUBLE_INTEGRATOR:
        return (0.0, 0.0)
    return (float(rng.uniform(-np.pi, np.pi)),) if motion == DUBINS_CAR else ()


def _named(name: str, task: str) -> bool:
    return name in task.replace("sequence", "")


def _disc(
    rng: np.random.Generator, side: float, least: float, most: float
) -> tuple[float, float, float]:
    x, y = rng.uniform(0.1 * side, 0.9 * side, 2).tolist()
    return x, y, float(rng.uniform(least, most))


def _box(rng: np.random.Generator, side: float) -> Any:
    x, y = rng.uniform(0.1 * side, 0.75 * side, 2).tolist()
    w, h = rng.uniform(0.3, 0.2 * side, 2).tolist()
    return np.array([(x, y), (x + w, y), (x + w, y + h), (x, y + h)])


def _start(
    rng: np.random.Generator,
    side: float,
    free: Any,
    discs: Sequence[tuple[float, float, float]],
    others: Sequence[PlanningRobot],
    body: float,
) -> Point:
    """A place where the robot is clear of walls, discs and the others' starts."""
    for _ in range(10_000):
        x, y = rng.uniform(0.0, side, 2).tolist()
        place = shapely.Point(x, y)
        away = body + CLEARANCE_M
        if (
            free.contains(place)
            and free.boundary.distance(place) > away
            and all(np.hypot(x - u, y - v) > away + r for u, v, r in discs)
            and all(
                np.hypot(x - one.start[0], y - one.start[1]) > away + one.radius_m for one in others
            )
        ):
            return x, y
    raise InputError("plan study", "found no room for a start", "this seed is unlucky")
